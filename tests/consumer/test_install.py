"""Runs the installation commands of docs/PACKAGES.md as typed, for this machine and for
microcontrollers (two of them in every build type), and a program that uses the installed library.
"""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TYPED = re.search(
    r"^    (cmake -S davar .*)$",
    (ROOT / "docs/PACKAGES.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)[1]
ARM = ROOT / "port/bare_metal/targets/cortex_m.cmake"
BARE = (
    "-DCMAKE_EXE_LINKER_FLAGS=--specs=nosys.specs",
    "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY",
)
CORES = {
    "host": (),
    **{
        core: (f"-DCMAKE_TOOLCHAIN_FILE={ARM}", f"-DDAVAR_TARGET={core}")
        for core in ("cortex-m0", "cortex-m4f", "cortex-m7")
    },
}
TYPES = ("", "Debug", "MinSizeRel")
BUILDS = [
    (core, kind) for core in CORES for kind in TYPES if not kind or core in ("host", "cortex-m4f")
]


def run(command, folder):
    done = subprocess.run(
        ["sh", "-ec", command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert done.returncode == 0, f"{command}:\n{done.stdout}"
    return done.stdout


class Install(unittest.TestCase):
    def test_as_the_page_says(self):
        for core, kind in BUILDS:
            with self.subTest(core=core, kind=kind), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "davar").symlink_to(ROOT)
                settings = CORES[core]
                wanted = [*settings, *([f"-DCMAKE_BUILD_TYPE={kind}"] if kind else [])]
                run(TYPED.replace("-B b", " ".join(["-B b", *map(str, wanted)])), folder)
                found = {path.name for path in Path(folder, "P").rglob("*") if path.is_file()}
                self.assertTrue({"libdavar.a", "davar.h", "options.h"} <= found, found)
                bare = BARE if settings else ()
                run(
                    f"cmake -S {HERE}/find_package -B user -DCMAKE_PREFIX_PATH={folder}/P "
                    f"{' '.join(map(str, [*wanted, *bare]))} && cmake --build user",
                    folder,
                )
                if not settings:
                    self.assertRegex(
                        run("user/consumer", folder), r"^davar \d+\.\d+\.\d+ epoch 99 window 60\n$"
                    )
                if not kind:  # the installed library is optimised by default
                    self.assertIn(
                        "CMAKE_BUILD_TYPE:STRING=Release",
                        (Path(folder) / "b/CMakeCache.txt").read_text(),
                    )


if __name__ == "__main__":
    unittest.main()
