"""davarlab's commands on input that nobody planned for: never a traceback."""

import io
import os
import tempfile
import unittest
from pathlib import Path

import numpy as np
from asking import run  # before numpy: it says how many threads
from davarlab import cli

SENSOR = '[sensor]\ncolumn = "gyro_z_dps"\n'
MODEL = (
    SENSOR
    + """[[effect]]
kind = "angle_random_walk"
coefficient_deg_per_sqrt_h = 0.3
[[effect]]
kind = "bias_instability"
coefficient_deg_per_h = 5.0
"""
)
SIGMA = 0.3 / 60 * 50**0.5


def noise(n, seed=1):
    return SIGMA * np.random.default_rng(seed).normal(size=n)


def table(columns):
    text = io.StringIO()
    np.savetxt(
        text,
        np.column_stack(list(columns.values())),
        fmt="%.9g",
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    return text.getvalue()


def rows(y, rate=50.0, **columns):
    return table({"time_s": np.arange(len(y)) / rate, "gyro_z_dps": y, **columns})


def effect(kind, **parameters):
    said = "\n".join(
        f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value}"
        for name, value in parameters.items()
    )
    return f'{MODEL}[[effect]]\nkind = "{kind}"\n{said}\n'


def line(f, a, n=40000, rate=50.0):
    return a * np.sin(2 * np.pi * f * np.arange(n) / rate + 1)


N = 3000
T = np.arange(N) / 50
STUCK = noise(N)
STUCK[N // 2 :] = STUCK[N // 2]
# name -> (recording, model)
CASES = {
    "short": (rows(noise(1000)), MODEL),
    "short drift": (rows(noise(1000) + 0.01 * np.arange(1000)), MODEL),
    "pure sine": (rows(line(3.3, 0.1, N)), MODEL),
    "pure slow sine": (rows(line(0.01, 0.1, N)), MODEL),
    "huge ramp": (rows(noise(N) + 20000 / 3600**2 * T), MODEL),
    "huge ramp known": (
        rows(noise(N) + 20000 / 3600**2 * T),
        effect("rate_ramp", coefficient_deg_per_h2=20000.0),
    ),
    "rough quantization": (
        rows(noise(N) + 0.005 * 50 * np.diff(np.random.default_rng(2).normal(size=N + 1))),
        MODEL,
    ),
    "rough quantization known": (
        rows(noise(N) + 0.005 * 50 * np.diff(np.random.default_rng(2).normal(size=N + 1))),
        effect("quantization", coefficient_deg=0.005),
    ),
    "stuck half": (rows(STUCK), MODEL),
    "stuck start": (rows(np.where(T < 20, 0, noise(N))), MODEL),
    "dead": (rows(np.full(N, 0.25)), MODEL),
    "noiseless counter": (rows(np.arange(N) * 1.0), MODEL),
    "saw tooth": (rows(np.arange(N) % 7 * 1.0), MODEL),
    "two values": (rows((np.arange(N) % 2) * 1.0), MODEL),
    "slow rate": (rows(noise(8000), 0.1), MODEL),
    "one count": (rows(np.round(noise(N) * 8) / 8 + 0.06), MODEL),
    "denormal steps": (
        "time_s,gyro_z_dps\n"
        + "".join(f"{i * 5e-324!r},{v:.6f}\n" for i, v in enumerate(noise(1200))),
        MODEL,
    ),
    "equal stamps": ("time_s,gyro_z_dps\n" + "".join(f"1,{v:.6f}\n" for v in noise(1200)), MODEL),
    "nested model": (rows(noise(1200)), "a = " + "[" * 20000 + "]" * 20000),
    "nested tables": (rows(noise(1200)), SENSOR + ".".join("a" * 2000) + " = 1\n"),
    "one line": (rows(noise(40000) + line(7.3, 0.01)), MODEL),
    "two lines": (rows(noise(40000) + line(7.3, 0.01) + line(1.1, 0.01)), MODEL),
    "line known": (
        rows(noise(20000) + line(7.3, 0.01, 20000)),
        effect("sinusoid", amplitude_dps=0.01, frequency_hz=7.3),
    ),
    "step": (rows(noise(N) + (T > 60) * 5.0), MODEL),
    "giant": (rows(noise(N) * 1e12), MODEL),
    "faint": (rows(noise(N) * 1e-9), MODEL),
    "wild": (rows(noise(N) + 1e3 * (np.arange(N) % 997 == 5)), MODEL),
    "no white": (
        rows(np.cumsum(noise(N))),
        SENSOR + '[[effect]]\nkind = "rate_random_walk"\ncoefficient_deg_per_h_per_sqrt_h = 1.0\n',
    ),
    "only a ramp": (
        rows(noise(N)),
        SENSOR + '[[effect]]\nkind = "rate_ramp"\ncoefficient_deg_per_h2 = 1.0\n',
    ),
    "noise step without white": (
        rows(noise(N)),
        SENSOR + '[[effect]]\nkind = "noise_step"\nstart_s = 10\nstop_s = 20\nratio = 2\n',
    ),
    "noise step outside": (
        rows(noise(N)),
        effect("noise_step", start_s=1e6, stop_s=2e6, ratio=2.0),
    ),
    "noise step drowned": (
        rows(np.cumsum(noise(N))),
        effect("noise_step", start_s=10.0, stop_s=20.0, ratio=2.0),
    ),
    "vibration known": (
        rows(noise(N), accel_x_g=np.zeros(N)),
        effect("vibration_noise", coefficient_dps_per_g=1.0, axis="x"),
    ),
    "telegraph known": (
        rows(noise(N)),
        effect("telegraph_noise", amplitude_dps=0.01, mean_dwell_s=1e6),
    ),
    "shocks known": (rows(noise(N)), effect("shocks", amplitude_dps=1.0, rate_per_hour=5.0)),
    "low pass known": (rows(noise(N)), effect("low_pass", cutoff_hz=1e5)),
    "flat temperature": (
        rows(noise(N), temp_degC=np.full(N, 25.0)),
        effect("temperature", coefficient_dps_per_degC=0.1),
    ),
    "temperature is the gyro": (rows(STUCK, temp_degC=STUCK), MODEL),
}
COMMANDS = (["compare"], ["diagnose", "--report"], ["fit"])
QUICK = (["compare"], ["diagnose"], ["fit"])  # a page takes longer than all of these
ALL_COMMANDS = (
    ["compare", "--report"],
    ["diagnose", "--report"],
    ["improve", "--report"],
    ["compare"],
    ["improve"],
    ["fit"],
)
OFTEN = ("short", "pure sine", "stuck half", "one line")  # with every command
UNREPORTED = (
    "known",
    "noise step",
    "short",
    "only",
    "faint",
    "giant",
    "huge",
    "rough",
    "two lines",
    "slow",
    "no white",
    "flat",
)


class Awkward(unittest.TestCase):
    def command(self, folder, words):
        recording, model, page = (
            str(Path(folder) / name) for name in ("r.csv", "m.toml", "page.html")
        )
        return [
            words[0],
            recording,
            "-m",
            model,
            *(["--report", page] if "--report" in words else []),
        ]

    def check(self, name, words, folder):
        with self.subTest(name, command=" ".join(words)):
            done = run(*self.command(folder, words))
            status, out, err = done.returncode, done.stdout, done.stderr
            self.assertIn(status, (0, 1, 2), err[-3000:])
            self.assertTrue(status != 1 or words[0] in ("compare", "improve"), (status, err))
            if status == 2:
                said = [row for row in err.splitlines() if row]
                self.assertEqual(
                    ("", True),
                    (out, said[-1].startswith("davarlab: ") and len(said[-1]) < 400),
                    err,
                )
            else:
                self.assertTrue(
                    out.strip() or words == ["fit"]
                )  # a model without effects has no estimates
            return status

    def test_no_traceback(self):
        os.environ["DAVAR_LAB_TRACEBACK"] = "1"
        self.addCleanup(os.environ.pop, "DAVAR_LAB_TRACEBACK")
        for name, (recording, model) in CASES.items():
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "r.csv").write_text(recording)
                (Path(folder) / "m.toml").write_text(model)
                for words in (
                    ALL_COMMANDS
                    if name in OFTEN
                    else QUICK
                    if any(word in name for word in UNREPORTED)
                    else COMMANDS
                ):
                    if self.check(name, words, folder) == 2:
                        break

    def test_what_nobody_foresaw_is_one_line_and_status_3(self):
        cli.COMMANDS["effects"], kept = (
            (lambda options: [][1], *cli.COMMANDS["effects"][1:]),
            cli.COMMANDS["effects"],
        )
        self.addCleanup(cli.COMMANDS.__setitem__, "effects", kept)
        done = run("effects")
        self.assertEqual((3, "", 1), (done.returncode, done.stdout, len(done.stderr.splitlines())))
        self.assertIn("internal error: IndexError", done.stderr)


if __name__ == "__main__":
    unittest.main()
