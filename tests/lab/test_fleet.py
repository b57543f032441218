"""davarlab fleet from outside: the table against fit and diagnose, a second run, a killed one, HTTP
and S3, limits, and what a population shows.
"""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asking import ROOT, run  # before numpy: it says how many threads
from serving import serving

sys.path.insert(0, str(ROOT / "data"))
import make_fleet

MODEL = """[sensor]
rate_hz = 20.0
column = "gyro_z_dps"
[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.35
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 8.0
"""
N = "angle_random_walk.coefficient_deg_per_sqrt_h"
SECONDS, UNITS, EFFECT = (
    600.0,
    48,
    0.0015,
)  # of the small fleet: shorter recordings, so a larger effect is as hard to see in one
INTERRUPTED = 16  # recordings of a run that is ended behind the second
BATCH = r"([AB])_\d+"
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(ROOT / "tools/lab"),
    "AWS_ACCESS_KEY_ID": "a",
    "AWS_SECRET_ACCESS_KEY": "b",
    "AWS_DEFAULT_REGION": "us-east-1",
}


def command(*arguments):
    return [sys.executable, "-B", "-m", "davarlab", "fleet", *map(str, arguments)]


def fleet(*arguments, **more):
    """A run in this process, its workers in others: libraries are loaded once."""
    with mock.patch.dict(os.environ, {**ENVIRONMENT, **more}):
        return run("fleet", *arguments)


def table(folder):
    return pq.read_table(Path(folder) / "fleet.parquet").to_pylist()


class Made(unittest.TestCase):
    """A small fleet, made once, and what was said of it."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.top = Path(folder.name)
        cls.model = cls.top / "model.toml"
        cls.model.write_text(MODEL)
        make_fleet.make(cls.top / "units", UNITS, EFFECT, SECONDS)

    def some(self, count):
        """A folder of its own with the first recordings."""
        folder = Path(tempfile.mkdtemp(dir=self.top))
        for path in sorted((self.top / "units").glob("A_*"))[:count]:
            shutil.copy(path, folder)
        return folder


class Population(Made):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.top / "units/A_9998.parquet").write_bytes(b"PAR1 and no more")
        (cls.top / "units/B_9999.csv").write_text("time_s,gyro_z_dps\n0,1\n")
        cls.limits = cls.top / "limits.toml"
        cls.limits.write_text(f'[[limit]]\ncoefficient = "{N}"\nmax = 0.33\nmin = 0.1\n')
        cls.out = cls.top / "out"
        cls.arguments = [
            cls.top / "units/*",
            "-m",
            cls.model,
            "-o",
            cls.out,
            "--batch",
            BATCH,
            "--limits",
            cls.limits,
            "--json",
        ]
        cls.done = fleet(*cls.arguments)
        cls.said = json.loads(cls.done.stdout)

    def test_the_hidden_effect_is_found_and_named_in_its_batch_only(self):
        named = [(one["batch"], one["kind"]) for one in self.said["hidden"] if one["named"]]
        self.assertEqual(named, [("B", "temperature")])
        self.assertEqual({one["batch"] for one in self.said["hidden"] if one["found"]}, {"B"})
        alone = self.said["named_alone"]["B"].get("temperature", 0)
        self.assertLess(alone, UNITS / 2 / 4, "a single recording shows it: nothing is hidden")
        self.assertEqual(self.done.returncode, 1)

    def test_a_row_says_what_fit_and_diagnose_say(self):
        rows = {row["file"]: row for row in table(self.out)}
        for name in ("A_0000", "B_0001"):
            path = str(self.top / f"units/{name}.parquet")
            row, fitted = (
                rows[path],
                json.loads(run("fit", path, "-m", self.model, "--json").stdout),
            )
            for effect in fitted["effects"]:
                for parameter, said in effect["parameters"].items():
                    column = f"{effect['kind']}.{parameter}"
                    self.assertEqual(
                        [row[column], row[column + ".low"], row[column + ".high"]],
                        [said["value"], said["low"], said["high"]],
                    )
            self.assertEqual(row["adequacy"], fitted["adequacy"])
            told = json.loads(run("diagnose", path, "-m", self.model, "--json").stdout)
            self.assertEqual(row["verdict"], told["verdict"])
            temperature = next(one for one in told["candidates"] if one["kind"] == "temperature")
            self.assertAlmostEqual(row["gain.temperature"], max(temperature["gain"], 0), places=6)
            columns = pq.read_table(path).to_pydict()
            self.assertAlmostEqual(
                row["temperature_degC"], float(np.mean(columns["temp_degC"])), places=6
            )
            self.assertAlmostEqual(row["start"].timestamp(), columns["time_s"][0], places=3)
            self.assertEqual((row["batch"], row["samples"]), (name[0], 12000))
            self.assertAlmostEqual(row["rate_hz"], 20.0, places=6)
            self.assertRegex(row["davar"], r"^\d+\.\d+\.\d+$")
            self.assertEqual(row["table_version"], 2)

    def test_a_file_that_cannot_be_used_is_a_row_with_its_reason(self):
        rows = [row for row in table(self.out) if row["failed"]]
        self.assertEqual([Path(row["file"]).name for row in rows], ["A_9998.parquet", "B_9999.csv"])
        self.assertIn("damaged, or not Parquet", rows[0]["failed"])
        self.assertEqual({row["verdict"] for row in rows}, {None})
        self.assertEqual(len(table(self.out)), UNITS + 2)

    def test_a_second_run_does_nothing_and_a_changed_file_is_done_again(self):
        before = (self.out / "fleet.parquet").read_bytes()
        again = fleet(*self.arguments)
        self.assertIn(f"{UNITS + 2} recordings: {UNITS + 2} finished, 0 remaining", again.stderr)
        self.assertEqual((self.out / "fleet.parquet").read_bytes(), before)
        os.utime(self.top / "units/A_0000.parquet")
        self.assertIn(f"{UNITS + 1} finished, 1 remaining", fleet(*self.arguments).stderr)

    def test_the_limits_say_pass_and_fail_as_the_intervals_do(self):
        for row in (row for row in table(self.out) if not row["failed"]):
            self.assertEqual(
                row["limits"],
                "fail" if row[N + ".low"] > 0.33 or row[N + ".high"] < 0.1 else "pass",
            )
        judged = self.said["limits"]
        self.assertEqual(judged["pass"] + judged["fail"], UNITS)
        self.assertEqual(
            [one["limit"] for one in judged["stated"]], [f"{N} >= 0.1", f"{N} <= 0.33"]
        )

    def test_the_page_needs_nothing_else_and_says_what_the_numbers_say(self):
        page = (self.out / "fleet.html").read_text()
        for said in (
            "Batch B as a whole has an effect that the model lacks: temperature.",
            "A_9998.parquet".replace("_", "_<wbr>"),
        ):
            self.assertTrue(said in page, said)
        self.assertFalse("<script" in page)
        self.assertEqual(re.findall(r'(?:src|href)="(?!data:)[^"]*', page), [])
        self.assertEqual(json.loads((self.out / "fleet.json").read_text())["rows"], UNITS)


def ended(group):
    """Nothing of a run is left."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)


class Interrupted(Made):
    def setUp(self):
        self.addCleanup(
            signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler)
        )  # whoever started the tests may ignore it

    def start(self, folder, out):
        started = subprocess.Popen(
            command(folder / "*", "-m", self.model, "-o", out, "--chance", 0, "--workers", 1),
            env=ENVIRONMENT,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.addCleanup(ended, started.pid)
        while len(list((out / "units").glob("*.json") if out.exists() else [])) < 2:
            self.assertIsNone(started.poll(), "it ended by itself")
            time.sleep(0.01)
        return started

    def check(self, number, status):
        folder = self.some(INTERRUPTED)
        out = folder.parent / (folder.name + "-out")
        started = self.start(folder, out)
        os.kill(started.pid, number) if number == signal.SIGKILL else os.killpg(started.pid, number)
        said = started.communicate()[1]
        self.assertEqual(started.returncode, status, said)
        self.assertNotIn("Traceback", said)
        there = [json.loads(path.read_text()) for path in (out / "units").glob("*.json")]
        self.assertLess(len(there), INTERRUPTED)
        self.assertFalse((out / "fleet.parquet").exists())
        again = fleet(folder / "*", "-m", self.model, "-o", out, "--chance", 0, "--workers", 1)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn(f"{len(there)} finished, {INTERRUPTED - len(there)} remaining", again.stderr)
        self.assertEqual(len(table(out)), INTERRUPTED)

    def test_ctrl_c_leaves_what_is_done_and_the_next_run_goes_on(self):
        self.check(signal.SIGINT, 130)

    def test_a_kill_leaves_nothing_half_written(self):
        self.check(signal.SIGKILL, -signal.SIGKILL)


class Elsewhere(Made):
    def test_http_with_a_glob(self):
        folder = self.some(3)
        with serving(folder.parent) as server:
            arguments = [
                f"http://127.0.0.1:{server.port}/{folder.name}/A_*.parquet",
                "-m",
                self.model,
                "-o",
                folder / "out",
                "--chance",
                0,
                "--workers",
                1,
            ]
            (folder / "other.txt").write_text("no recording")
            done = fleet(f"http://127.0.0.1:{server.port}/gone.parquet", *arguments)
            self.assertEqual(
                [bool(row["failed"]) for row in table(folder / "out")],
                [True, False, False, False],
                done.stderr,
            )
            self.assertEqual(done.returncode, 1)
            server.fetched.clear()
            again = fleet(*arguments)
            self.assertIn("3 recordings: 3 finished, 0 remaining", again.stderr)
            self.assertEqual(again.returncode, 0)
            self.assertFalse({name for name in server.fetched if name.startswith("A_")})

    def test_s3_with_a_glob(self):
        folder = self.some(2)
        out = self.top / "s3-out"
        with serving(folder.parent) as server:
            done = fleet(
                f"s3://{folder.name}/A_*.parquet",
                "-m",
                self.model,
                "-o",
                out,
                "--chance",
                0,
                "--workers",
                1,
                AWS_ENDPOINT_URL=f"http://127.0.0.1:{server.port}",
            )
            self.assertEqual((done.returncode, len(table(out))), (0, 2), done.stderr)
            self.assertTrue(table(out)[0]["file"].startswith("s3://"))

    def test_the_workers_of_a_scheduler_that_is_there(self):
        from dask import distributed

        with distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            dashboard_address="127.0.0.1:0",
            host="127.0.0.1",
            protocol="tcp",
        ) as cluster:
            folder = self.some(2)
            done = fleet(
                folder / "*",
                "-m",
                self.model,
                "-o",
                folder / "out",
                "--chance",
                0,
                "--scheduler",
                cluster.scheduler_address,
            )
            self.assertEqual((done.returncode, len(table(folder / "out"))), (0, 2), done.stderr)

    def test_all_axes_of_a_log(self):
        rng, folder = np.random.default_rng(4), self.some(0)
        columns = {
            "time_s": np.arange(12000) / 20.0,
            **{
                f"gyro_{axis}_dps": rng.normal(0, 0.02 * (place + 1), 12000)
                for place, axis in enumerate("xy")
            },
            "accel_x_g": rng.normal(0, 0.001, 12000),
        }
        pq.write_table(pa.table(columns), folder / "log.parquet")
        done = fleet(
            folder / "log.parquet",
            "-m",
            self.model,
            "-o",
            folder / "out",
            "--chance",
            0,
            "--axes",
            "all",
            "--workers",
            1,
        )
        rows = table(folder / "out")
        self.assertEqual(
            [row["axis"] for row in rows], ["gyro_x_dps", "gyro_y_dps", "accel_x_g"], done.stderr
        )
        for row, sigma in zip(rows, (0.02, 0.04)):
            self.assertAlmostEqual(row[N] / (sigma / 20**0.5 * 60), 1, delta=0.05)
        self.assertAlmostEqual(
            rows[2]["velocity_random_walk.coefficient_m_per_s_per_sqrt_h"]
            / (9.80665e-3 / 20**0.5 * 60),
            1,
            delta=0.05,
        )
        self.assertIsNone(rows[2][N])


class BadInput(Made):
    def test_every_mistake_is_one_line_and_status_2(self):
        wrong = self.top / "wrong.toml"
        cases = [
            (["nothing_*.csv"], "", "nothing_*.csv: no such file"),
            (["--batch", "("], "", "--batch ("),
            (["--limits", wrong], "[[limit]]\nmax = 1\n", "limit 1: a limit needs coefficient"),
            (
                ["--limits", wrong],
                '[[limit]]\ncoefficient = "x.y"\n',
                "limit 1: a limit needs min or max",
            ),
            (["--limits", wrong], "at_limit = 0.7\n", "at_limit = 0.7 is outside"),
            (["--limits", wrong], "", "no [[limit]]"),
            (
                ["--limits", wrong],
                '[[limit]]\ncoefficient = "x.y"\nmax = 1\n',
                "x.y: no unit has it",
            ),
            (["gopher://x/y*"], "", "gopher"),
            (["--workers", "0"], "", "--workers"),
        ]
        folder = self.some(1)
        fleet(folder / "*", "-m", self.model, "-o", folder / "out", "--chance", 0, "--workers", 1)
        for more, text, said in cases:
            with self.subTest(more=more, text=text):
                wrong.write_text(text)
                done = run(
                    "fleet",
                    folder / "*.parquet",
                    *more,
                    "-m",
                    self.model,
                    "-o",
                    folder / "out",
                    "--chance",
                    0,
                )
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(said, done.stderr.splitlines()[-1])
        (folder / "plain").write_text("")
        self.assertEqual(
            run("fleet", folder / "*.parquet", "-m", self.model, "-o", folder / "plain").returncode,
            2,
        )


if __name__ == "__main__":
    unittest.main()
