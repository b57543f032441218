"""filter, fit and every part of addons/ each build without the rest of the library: they need only
public headers, number/ and their own files; fit also the header of filter.
"""

import shutil

import pytest
from compiling import ROOT, WARN, run

ALSO = {"fit": ("filter/spectrum.h",)}  # lib/DESIGN.md


@pytest.mark.parametrize("room", ("filter", "fit"))
def test_a_sibling_builds_alone(tmp_path, room):
    for part in ("include", "src/number", f"src/{room}"):
        shutil.copytree(ROOT / "lib" / part, tmp_path / part)
    for header in ALSO.get(room, ()):
        (tmp_path / "src" / header).parent.mkdir()
        shutil.copy(ROOT / "lib/src" / header, tmp_path / "src" / header)
    sources = sorted((tmp_path / "src" / room).glob("*.c"))
    assert sources
    run("gcc", *WARN, "-fsyntax-only", "-Iinclude", "-Isrc", *sources, folder=tmp_path)


PARTS = sorted(path.name for path in (ROOT / "addons").iterdir() if path.is_dir())
USES = {"can": ["monitor"], "state": ["cascade"]}  # headers of other parts


@pytest.mark.parametrize("part", PARTS)
def test_a_part_builds_alone(tmp_path, part):
    parts = [f"addons/{one}" for one in (part, *USES.get(part, []))]
    for folder in ("lib/include", "lib/src/number", *parts):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    headers = (tmp_path / f"addons/{part}/include/davar").glob("*.h")
    program = "".join(f'#include "davar/{header.name}"\n' for header in headers)
    (tmp_path / "program.c").write_text(program)
    sources = sorted((tmp_path / f"addons/{part}").glob("src/*.c"))
    include = ["-Ilib/include", "-Ilib/src", *(f"-I{one}/include" for one in parts)]
    run("gcc", *WARN, "-fsyntax-only", *include, "program.c", *sources, folder=tmp_path)
