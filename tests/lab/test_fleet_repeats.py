"""A fleet says the same whatever the machine is busy with: workers, order, folder, load, threads,
hash seed; and to nine digits on other processors.
"""

import contextlib
import json
import multiprocessing
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asking import ROOT  # before numpy: it says how many threads

sys.path.insert(0, str(ROOT / "data"))
import make_fleet

MODEL = (
    '[sensor]\nrate_hz = 20.0\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.35\n"
    '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 8.0\n'
)
UNITS, SECONDS, EFFECT = 16, 100.0, 0.04
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "tools/lab")}
FEATURES = {  # from the widest vectors to the narrowest
    "SkylakeX": {"avx512f", "avx512vl"},
    "Haswell": {"avx2", "fma"},
    "Zen": {"avx2", "fma"},
    "Sandybridge": {"avx"},
    "Prescott": {"pni"},
}


def load(seed):
    rng = random.Random(seed)
    while True:
        sum(range(10**6))
        time.sleep(rng.uniform(0, 0.05))


@contextlib.contextmanager
def busy():
    """Twice as many processes as processors that count and sleep in irregular turns."""
    others = [
        multiprocessing.get_context("fork").Process(target=load, args=(seed,), daemon=True)
        for seed in range(2 * os.cpu_count())
    ]
    for one in others:
        one.start()
    try:
        yield
    finally:
        for one in others:
            one.kill()
            one.join()


def cores():
    """Those of OpenBLAS's kernels that this processor has; none where its linear algebra is
    another.
    """
    if "openblas" not in np.show_config(mode="dicts")["Build Dependencies"]["blas"]["name"]:
        return []
    flags = set(
        next(
            (
                line
                for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("flags")
            ),
            "",
        ).split()
    )
    return [core for core, needed in FEATURES.items() if needed <= flags]


class Repeated(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.top = Path(folder.name)
        (cls.top / "model.toml").write_text(MODEL)
        make_fleet.make(cls.top / "first", UNITS, EFFECT, SECONDS)
        # units that show what they lack by themselves, two of them of a kind that is hard to tell
        for place in range(4):
            rng, count = np.random.default_rng(place), 3000
            hum, walk = (
                0.01 * np.sin(2 * np.pi * 1.3 * np.arange(count) / 20),
                np.cumsum(rng.normal(0, 0.001, count)),
            )
            pq.write_table(
                pa.table(
                    {
                        "time_s": 1e6 + np.arange(count) / 20,
                        "gyro_z_dps": rng.normal(0, 0.02, count) + (hum if place % 2 else walk),
                        "temp_degC": 25 + np.cumsum(rng.normal(0, 0.02, count)),
                    }
                ),
                cls.top / f"first/{'AB'[place % 2]}_9{place:03d}.parquet",
            )
        cls.names = sorted(path.name for path in (cls.top / "first").iterdir())
        cls.first = cls.fleet("first", cls.names, 2)

    @classmethod
    def fleet(cls, folder, names, workers, **more):
        """(rows by file without what was spent on them, what --json says of the population) of
        files in a folder.
        """
        out = Path(tempfile.mkdtemp(dir=cls.top))
        done = subprocess.run(
            [
                sys.executable,
                "-B",
                "-m",
                "davarlab",
                "fleet",
                *(cls.top / folder / name for name in names),
                "-m",
                cls.top / "model.toml",
                "-o",
                out,
                "--batch",
                r"([AB])_\d+",
                "--workers",
                str(workers),
                "--json",
            ],
            env={**ENVIRONMENT, **more},
            text=True,
            capture_output=True,
        )
        assert done.returncode == 1, done.stderr
        text = done.stdout.replace(f"{cls.top / folder}/", "")
        rows = pq.read_table(out / "fleet.parquet").to_pylist()
        rows = sorted(
            (
                dict(sorted({**row, "file": Path(row["file"]).name, "seconds": None}.items()))
                for row in rows
            ),
            key=lambda row: row["file"],
        )
        return repr(rows), json.dumps({**json.loads(text), "done_now": None}, sort_keys=True)

    def assert_same(self, found):
        for one, other in zip(self.first, found):
            self.assertEqual(one, other)

    def test_the_fleet_is_worth_repeating(self):
        rows, said = self.first
        named = [one for one in json.loads(said)["hidden"] if one["named"]]
        self.assertIn("B", [one["batch"] for one in named])
        self.assertTrue(any(one["alternatives"] for one in named))
        self.assertGreater(len(json.loads(said)["verdicts"]), 2)
        self.assertRegex(rows, "'alternatives': '[a-z]")

    def test_one_worker_in_any_order(self):
        names = list(self.names)
        random.Random(5).shuffle(names)
        self.assert_same(self.fleet("first", names, 1, PYTHONHASHSEED="77"))

    def test_five_workers_on_a_busy_machine(self):
        with busy():
            self.assert_same(self.fleet("first", self.names[::-1], 5))

    def test_another_folder_and_more_threads(self):
        shutil.copytree(self.top / "first", self.top / "elsewhere/second")
        self.assert_same(
            self.fleet(
                "elsewhere/second",
                self.names,
                2,
                OPENBLAS_NUM_THREADS="4",
                OMP_NUM_THREADS="3",
                MKL_NUM_THREADS="4",
            )
        )

    def test_other_processors_say_the_same_in_nine_digits(self):
        """Their last digits are not the same: a product and a sum in one step round once. A
        log-likelihood of some 10 000 units has nine digits to 1e-5.
        """
        code = (
            "import json, sys\nfrom davarfleet import job\n"
            "print(json.dumps([job.measured(job.Job(path, open(sys.argv[1]).read(), "
            "chance=True))['rows'] for path in sys.argv[2:]]))"
        )
        others = cores()
        if len(others) < 2:
            self.skipTest(
                "this processor, or its linear algebra, has fewer than two kernels of "
                "OpenBLAS to compare"
            )
        chosen = self.names[::5] + self.names[-1:]
        found = {}
        for core in others:
            done = subprocess.run(
                [
                    sys.executable,
                    "-W",
                    "ignore",
                    "-c",
                    code,
                    self.top / "model.toml",
                    *(self.top / "first" / name for name in chosen),
                ],
                env={**ENVIRONMENT, "OPENBLAS_CORETYPE": core},
                text=True,
                capture_output=True,
                check=True,
            )
            found[core] = json.loads(done.stdout)
        for core, rows in found.items():
            self.assert_close(found[others[0]], rows, core)

    def test_other_processors_find_the_same_in_the_population(self):
        """What is decided, not the digits that it is decided by."""
        others = cores()
        if len(others) < 2:
            self.skipTest(
                "this processor, or its linear algebra, has fewer than two kernels of "
                "OpenBLAS to compare"
            )
        for core in (others[0], others[-1]):  # the widest and the narrowest vectors
            self.assertEqual(
                self.decided(self.first[1]),
                self.decided(self.fleet("first", self.names, 2, OPENBLAS_CORETYPE=core)[1]),
                core,
            )

    @staticmethod
    def decided(said):
        found = json.loads(said)
        hidden = [
            {name: one[name] for name in ("batch", "kind", "found", "named", "alternatives")}
            for one in found["hidden"]
        ]
        return (
            sorted(hidden, key=lambda one: (one["batch"], one["kind"])),
            found["verdicts"],
            found["adequacy"],
        )

    def assert_close(self, one, other, where):
        if isinstance(one, dict):
            self.assertEqual(set(one), set(other), where)
            for name in one:
                self.assert_close(one[name], other[name], f"{where}.{name}")
        elif isinstance(one, list):
            self.assertEqual(len(one), len(other), where)
            for place, pair in enumerate(zip(one, other)):
                self.assert_close(*pair, f"{where}.{place}")
        elif isinstance(one, float):
            self.assertLess(
                abs(one - other),
                1e-5 if ".gains." in where or ".chance." in where else 1e-9 * abs(one) + 1e-15,
                (where, one, other),
            )
        else:
            self.assertEqual(one, other, where)


if __name__ == "__main__":
    unittest.main()
