"""filter, fit, cascade, monitor, select, state and wire each build without the rest of the library:
they need only public headers, number/ and their own files; fit also the header of filter.
"""

import shutil

import pytest
from compiling import ROOT, WARN, run

ALSO = {"state": ("core/instance.h",), "fit": ("filter/spectrum.h",)}  # lib/DESIGN.md


@pytest.mark.parametrize("room", ("filter", "fit", "cascade", "monitor", "select", "state", "wire"))
def test_a_sibling_builds_alone(tmp_path, room):
    for part in ("include", "src/number", f"src/{room}"):
        shutil.copytree(ROOT / "lib" / part, tmp_path / part)
    for header in ALSO.get(room, ()):
        (tmp_path / "src" / header).parent.mkdir()
        shutil.copy(ROOT / "lib/src" / header, tmp_path / "src" / header)
    sources = sorted((tmp_path / "src" / room).glob("*.c"))
    assert sources
    run("gcc", *WARN, "-fsyntax-only", "-Iinclude", "-Isrc", *sources, folder=tmp_path)
