"""The library in one file, which takes one compilation instead of sixty."""

import sys

import c_library
import compiling
import pytest


@pytest.fixture(scope="session")
def one_file(tmp_path_factory):
    """A folder with both files of tools/support/amalgamate.py."""
    folder = tmp_path_factory.mktemp("one")
    compiling.run(sys.executable, compiling.ROOT / "tools/support/amalgamate.py", folder)
    (folder / "davar").mkdir()
    for header in (path for place in c_library.PUBLIC for path in (place / "davar").glob("*.h")):
        # a program that includes it gets the single file
        (folder / "davar" / header.name).write_text('#include "../davar.h"\n')
    return folder
