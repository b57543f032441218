"""davar-sim on the boards with Linux: the same bytes as on this machine, both results and error
messages. DAVAR_SIM: this machine's davar-sim.
"""

import gzip
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/support"))
import targets

ROOT = Path(__file__).resolve().parents[2]
SIM = os.environ.get("DAVAR_SIM", "davar-sim")
JOBS = {
    "rows": ("--lsb", "0.001", "--stride", "100"),
    "lines with everything": ("--lsb", "0.001", "--stride", "50", "--out", "jsonl", "--details"),
    "trailing, at every sample": ("--lsb", "0.002", "--mode", "trailing", "--taus", "1,2,4,8,16"),
    "floating point": ("--arith", "float", "--stride", "70"),
}
WRONG = (("--window-max", "0"), ("--policy", "guess"), ("--lsb", "-1"), ("--column", "absent"))


def built(target):
    """The board's davar-sim. Debian has no zlib for all such machines, so recordings are plain text
    there.
    """
    board, where = targets.MACHINES[target], targets.folder(target, "sim")
    library = targets.run(
        [board["toolchain"] + "gcc", "-print-file-name=libm.a"], f"libm.a of {target}"
    ).strip()  # any: no function of zlib is called
    targets.run(
        [
            "cmake",
            "-S",
            str(ROOT),
            "-B",
            str(where),
            f"-DCMAKE_TOOLCHAIN_FILE={ROOT}/port/bare_metal/targets/linux.cmake",
            f"-DDAVAR_TARGET={target}",
            "-DCMAKE_BUILD_TYPE=Release",
            "-DDAVAR_WERROR=ON",
            "-DDAVAR_BUILD_SIM=ON",
            f"-DZLIB_INCLUDE_DIR={ROOT}/tests/target/without_zlib",
            f"-DZLIB_LIBRARY={library}",
        ],
        f"configuring {target}",
    )
    targets.run(
        [
            "cmake",
            "--build",
            str(where),
            "--target",
            "davar-sim",
            "--parallel",
            str(os.cpu_count() or 2),
        ],
        f"building {target}",
    )
    return where / "host_sim/davar-sim"


class Linux(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.recording = Path(folder.name, "demo.csv")
        cls.recording.write_bytes(
            gzip.decompress((ROOT / "data/demo_disturbance.csv.gz").read_bytes())
        )
        cls.simulators = {
            target: built(target) for target in targets.MACHINES if target not in targets.BARE
        }

    def run_on(self, target, options):
        done = subprocess.run(
            [*targets.command(target, self.simulators[target]), self.recording, *options],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr

    @classmethod
    def run_here(cls, options):
        done = subprocess.run(
            [SIM, cls.recording, *options],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            check=False,
        )
        return done.returncode, done.stdout, done.stderr

    def test_the_same_bytes_as_here(self):
        for name, options in JOBS.items():
            status, rows, weather = self.run_here(options)
            self.assertEqual(0, status, weather)
            self.assertGreater(rows.count(b"\n"), 50)
            for target in self.simulators:
                with self.subTest(target=target, job=name):
                    self.assertTrue(
                        (status, rows, weather) == self.run_on(target, options),
                        "other bytes than here",
                    )

    def test_the_same_complaints(self):
        for options in WRONG:
            expected = self.run_here(options)
            self.assertEqual(2, expected[0])
            for target in self.simulators:
                with self.subTest(target=target, options=options):
                    self.assertEqual(expected, self.run_on(target, options))


if __name__ == "__main__":
    unittest.main()
