"""compare, fit, diagnose and improve on recordings and models of any size: a result with status 0
or 1, or an error; never anything else.
"""

import unittest
from profile import examples

import asked
import numpy as np
from davarlab import model as models
from davarlab.data import recording as recordings
from hypothesis import given
from hypothesis import strategies as st
from test_models import terms

SHAPES = {
    "noise": lambda time, rng: rng.standard_normal(len(time)),
    "constant": lambda time, rng: np.ones(len(time)),
    "ramp": lambda time, rng: np.linspace(0, 1, len(time)),
    "sine": lambda time, rng: np.sin(0.3 * np.arange(len(time))),
    "two values": lambda time, rng: rng.integers(0, 2, len(time)) * 1.0,
    "counts": lambda time, rng: np.round(rng.standard_normal(len(time)) * 2) / 2,
    "walk": lambda time, rng: np.cumsum(rng.standard_normal(len(time))),
    "stuck": lambda time, rng: (
        rng.standard_normal(len(time)) * (np.arange(len(time)) < len(time) // 2)
    ),
    "late": lambda time, rng: (
        rng.standard_normal(len(time)) * (np.arange(len(time)) > len(time) - 5)
    ),
    "spikes": lambda time, rng: (
        rng.standard_normal(len(time)) * (1 + 1e6 * (rng.random(len(time)) < 0.01))
    ),
    "slow sine": lambda time, rng: np.sin(6.3e-4 * np.arange(len(time))),
    "saw tooth": lambda time, rng: np.arange(len(time)) % 7 * 1.0,
    "repeated": lambda time, rng: np.repeat(rng.standard_normal(len(time)), 3)[: len(time)],
    "heavy": lambda time, rng: rng.standard_cauchy(len(time)),
}
CLOCKS = {
    "even": lambda count, rng: np.arange(count) * 1.0,
    "jitter": lambda count, rng: np.arange(count) + 0.3 * rng.random(count),
    "gaps": lambda count, rng: np.arange(count) + 1000.0 * np.cumsum(rng.random(count) < 0.005),
    "lost": lambda count, rng: np.arange(count) + np.cumsum(rng.random(count) < 0.2) * 1.0,
    "uneven": lambda count, rng: np.cumsum(rng.exponential(size=count)),
    "twice": lambda count, rng: np.arange(count) // 2 * 1.0,
    "stands": lambda count, rng: np.ones(count),
    "denormal": lambda count, rng: 5e-324 * np.arange(count),
}
EXTRA = st.dictionaries(
    st.sampled_from(("temp_degC", "accel_x_g", "accel_y_g", "accel_z_g", "gyro_x_dps", "volt")),
    st.sampled_from(sorted(SHAPES)),
    max_size=3,
)


class Analysis(asked.Lawful):
    @given(
        st.sampled_from(("compare", "fit", "diagnose", "improve")),
        st.sampled_from(sorted(SHAPES)),
        st.sampled_from(sorted(CLOCKS)),
        EXTRA,
        st.sampled_from((1.0, 1.0, 1e-3, 1e-12, 1e12, 1e-20, 1e20)),
        st.sampled_from((50.0, 50.0, 1000.0, 1e-6, 1e8)),
        st.sampled_from((1000, 1001, 1500)),
        st.lists(terms(), max_size=2),
        st.booleans(),
        st.integers(0, 99),
    )
    @examples(30)
    def test_a_result_or_an_error(
        self, command, shape, clock, extra, size, rate_hz, count, added, report, seed
    ):
        rng = np.random.default_rng(seed)
        time = CLOCKS[clock](count, rng) / rate_hz
        columns = {"time_s": time, "gyro_z_dps": size * SHAPES[shape](time, rng)} | {
            name: SHAPES[kind](time, rng) for name, kind in extra.items()
        }
        path, model, out = self.work / "r.csv", self.work / "m.toml", self.work / "out.toml"
        recordings.write_columns(columns, {}, path)
        noise = models.Term(
            "angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3 * min(max(size, 1e-9), 1e6)}
        )
        models.write(models.Model(None, "gyro_z_dps", [noise, *added]), model)
        page = self.work / "page.html"
        out.unlink(missing_ok=True)
        page.unlink(missing_ok=True)
        done = asked.run(
            command,
            path,
            "-m",
            model,
            *(("-o", out) if command == "improve" else ()),
            *(("--report", page) if report and command != "fit" else ()),
        )
        self.keeps_the_law(
            done, self.named(done), (0, 1) if command in ("compare", "improve") else (0,)
        )
        self.assertEqual(out.exists(), command == "improve" and done.returncode < 2)
        self.assertEqual(page.exists(), report and command != "fit" and done.returncode < 2)
        if out.exists():
            models.read(out)

    def named(self, done):
        """The file that an error may name: the recording, or the model."""
        return "m.toml" if "m.toml" in done.stderr.rsplit("davarlab: ", 1)[-1] else "r.csv"


if __name__ == "__main__":
    unittest.main()
