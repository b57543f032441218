"""The results of pip for the repository: sdist, wheel, types, and the program davarlab with and
without the extra.
"""

import csv
import importlib.metadata
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile
from pathlib import Path

import davar
import together

DIST = Path(os.environ["DAVAR_DIST"])
VERSION = ".".join(
    re.findall(
        r"#define DAVAR_VERSION_\w+ (\d+)\n",
        (together.ROOT / "lib/include/davar/version.h").read_text(),
    )
)


def run(command, folder, **environment):
    variables = {
        "PATH": os.environ["PATH"],
        "HOME": str(folder),
        "MPLCONFIGDIR": str(folder),
        **environment,
    }
    return subprocess.run(
        list(map(str, command)), cwd=folder, env=variables, text=True, capture_output=True
    )


class Made(unittest.TestCase):
    def test_one_wheel_for_every_python(self):
        names = sorted(path.name for path in DIST.iterdir())
        self.assertRegex(names[0], rf"^davar-{re.escape(VERSION)}-py3-none-linux_\w+\.whl$")
        self.assertEqual(names[1:], [f"davar-{VERSION}.tar.gz"])

    def test_the_wheel_contains_only_the_packages(self):
        with zipfile.ZipFile(next(DIST.glob("*.whl"))) as wheel:
            names = wheel.namelist()
        self.assertEqual(
            {name.split("/")[0] for name in names},
            {"davar", "davarlab", "davarfleet", f"davar-{VERSION}.dist-info"},
        )
        for name in (
            "davar/py.typed",
            "davar/libdavar_python.so",
            "davarlab/shared/libdavar_lab.so",
            "davarlab/shared/davar.dbc",
            "davarlab/shared/davar-plan",
            "davarlab/shared/davar-promise",
            "davarlab/shared/planner/costs.json",
            "davarlab/report/page.html",
            "davarfleet/page.html",
        ):
            self.assertIn(name, names)
        self.assertTrue(any(name.endswith("licenses/LICENSE") for name in names))
        self.assertEqual(
            [
                name
                for name in names
                if name.endswith((".c", ".a", ".pyc", ".txt"))
                and not name.endswith("entry_points.txt")
            ],
            [],
        )

    def test_the_sdist_has_no_tests_and_no_build(self):
        with tarfile.open(next(DIST.glob("*.tar.gz"))) as archive:
            folders = {name.split("/")[1] for name in archive.getnames() if "/" in name}
        self.assertLessEqual(
            {"lib", "host_sim", "python", "tools", "pyproject.toml", "LICENSE"}, folders
        )
        self.assertFalse({"tests", "build", ".git"} & folders)

    def test_the_extra_is_the_pins_of_the_workbench(self):
        pins = (together.ROOT / "tools/requirements-lab.txt").read_text().split()
        wanted = importlib.metadata.requires("davar")
        self.assertEqual(
            sorted(one.split(";")[0].strip() for one in wanted if "extra" in one), sorted(pins)
        )
        self.assertEqual([one.split(">")[0] for one in wanted if "extra" not in one], ["numpy"])


class Installed(unittest.TestCase):
    def test_outside_of_the_checkout(self):
        for path in (davar.__file__, sys.prefix):
            self.assertFalse(Path(path).resolve().is_relative_to(together.ROOT), path)
        self.assertEqual(importlib.metadata.version("davar"), VERSION)

    def test_types_are_complete(self):
        """Runs mypy as a user's project would."""
        with tempfile.TemporaryDirectory() as folder:
            use = Path(folder, "use.py")
            use.write_text(
                "import davar\nimport numpy as np\nfound = davar.adev(np.zeros(10), 1.0)\n"
                "reveal_type(found.n)\nreveal_type(davar.Stream(1.0, lsb=1.0).push([1]))\n"
                "davar.dynamic([1.0], window_max='6')\n"
            )
            done = run(
                [
                    os.environ["DAVAR_MYPY"],
                    "-m",
                    "mypy",
                    "--python-executable",
                    sys.executable,
                    "--strict",
                    "use.py",
                ],
                folder,
            )
            self.assertRegex(done.stdout, r'use.py:4: note: Revealed type is "numpy.ndarray')
            self.assertIn(
                'use.py:5: note: Revealed type is "int"', done.stdout.replace("builtins.int", "int")
            )
            self.assertIn('use.py:6: error: Argument "window_max"', done.stdout)
            done = run(
                [
                    os.environ["DAVAR_MYPY"],
                    "-m",
                    "mypy",
                    "--python-executable",
                    sys.executable,
                    "--strict",
                    "-p",
                    "davar",
                ],
                folder,
            )
            self.assertEqual(done.returncode, 0, done.stdout)

    def test_davarlab_without_the_extra_reports_it(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run([Path(sys.executable).with_name("davarlab"), "--help"], folder)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(
                done.stderr, r'^davarlab: not installed: .*; pip install "davar\[lab\]"\n$'
            )


class WithTheExtra(unittest.TestCase):
    """In the Python with the pins: installs the wheel into a separate folder."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.site = Path(cls.folder.name, "site")
        done = run(
            [
                os.environ["DAVAR_LAB_PYTHON"],
                "-m",
                "pip",
                "install",
                "--disable-pip-version-check",
                "--no-deps",
                "--no-index",
                "--target",
                cls.site,
                next(DIST.glob("*.whl")),
            ],
            cls.folder.name,
        )
        assert done.returncode == 0, done.stdout + done.stderr

    def run_in(self, *command):
        return run(
            [os.environ["DAVAR_LAB_PYTHON"], *command],
            self.folder.name,
            PYTHONPATH=str(self.site),
            OPENBLAS_NUM_THREADS="1",
        )

    def davarlab(self, *words):
        return self.run_in(self.site / "bin/davarlab", *words)

    def test_the_program_runs_with_its_own_library(self):
        done = self.davarlab("--help")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("improve", done.stdout)
        folder = Path(self.folder.name)
        scenario = folder / "s.toml"
        scenario.write_text(
            (together.ROOT / "data/tutorial_sensor.toml").read_text().replace("7200", "600")
        )
        done = self.davarlab("simulate", "s.toml", "-o", "rec.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        with (folder / "rec.csv").open() as file:
            column = next(
                name
                for row in csv.reader(file)
                if not row[0].startswith("#")
                for name in row
                if name.startswith("gyro_")
            )
        (folder / "m.toml").write_text(
            f'[sensor]\nrate_hz = 50.0\ncolumn = "{column}"\n\n[[effect]]\n'
            'kind = "angle_random_walk"\ncoefficient_deg_per_sqrt_h = 0.3\n'
        )
        done = self.davarlab("compare", "rec.csv", "-m", "m.toml", "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertIn('"verdict"' if "verdict" in done.stdout else '"p_value"', done.stdout)

    def test_the_workbench_has_its_planner(self):
        done = self.run_in(
            "-c",
            "from davarlab.workbench import plans\n"
            "print(plans.planner()['missing'], plans.programs.__file__)\n"
            "options = {'sensor': 'icm42688@1000', 'core': 'cortex-m4f'}\n"
            "print(plans.plan(**options)['subject'], len(plans.setup(**options)) > 1000)\n",
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        first, second = done.stdout.splitlines()
        self.assertEqual(first, f"None {self.site}/davarlab/shared/planner/programs.py")
        self.assertEqual(second, "1 axis of int16 at 1000 Hz (icm42688@1000) on a cortex-m4f True")

    def test_another_log_is_read(self):
        done = self.run_in(
            "-c",
            "import numpy as np, davar\n"
            "t = np.arange(3000) / 200\n"
            "np.savez('log.npz', time_s=t, gyro_x=np.sin(t), gyro_y=np.cos(t), "
            "gyro_z=np.sin(2 * t))\n"
            "made = davar.read('log.npz')\n"
            "print(round(made.rate_hz, 6), sorted(made.columns), len(made.time_s))\n"
            "open('log.npz', 'wb').write(b'PK\\x03\\x04broken')\n"
            "try:\n    davar.read('log.npz')\nexcept ValueError as why:\n    print(why)\n",
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        first, second = done.stdout.splitlines()
        self.assertRegex(
            first, r"^200\.0 \['gyro_x_(dps|rad_s)', 'gyro_y_\w+', 'gyro_z_\w+', 'time_s'\] 3000$"
        )
        self.assertTrue(second.startswith("log.npz: damaged"), second)


if __name__ == "__main__":
    unittest.main()
