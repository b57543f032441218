"""filter, fit, cascade, monitor, select, state and wire each build without the rest of the library:
they need only public headers, number/ and their own files; fit also the header of filter.
"""

import shutil
import tempfile
import unittest
from pathlib import Path

from compiling import objects

LIB = Path(__file__).resolve().parents[2] / "lib"
ALONE = ("filter", "fit", "cascade", "monitor", "select", "state", "wire")
ALSO = {"state": ("core/instance.h",), "fit": ("filter/spectrum.h",)}  # lib/DESIGN.md


class Rooms(unittest.TestCase):
    def test_each_of_the_siblings_builds_alone(self):
        for room in ALONE:
            with self.subTest(room=room), tempfile.TemporaryDirectory() as folder:
                work = Path(folder)
                for part in ("include", "src/number", f"src/{room}"):
                    shutil.copytree(LIB / part, work / part)
                for header in ALSO.get(room, ()):
                    (work / "src" / header).parent.mkdir()
                    shutil.copy(LIB / "src" / header, work / "src" / header)
                flags = [
                    "-std=c11",
                    "-Wall",
                    "-Wextra",
                    "-Wpedantic",
                    "-Werror",
                    "-O1",
                    "-I",
                    work / "include",
                    "-I",
                    work / "src",
                ]
                self.assertTrue(
                    objects(work / "objects", flags, sorted((work / "src" / room).glob("*.c")))
                )


if __name__ == "__main__":
    unittest.main()
