"""The way of the search: where it ends, and what it may cost."""

import tempfile
import unittest
from dataclasses import dataclass, replace
from pathlib import Path
from unittest import mock

import asking
import numpy as np
import scoring
from davarlab.data.recording import Recording
from davarlab.diagnosis import evidence, search
from davarlab.diagnosis import state as state_of
from davarlab.model import Model, Term
from davarlab.thresholds import SEARCH
from scipy import signal

RATE, COLUMN = 50.0, "gyro_z_dps"


@dataclass(frozen=True)
class Judgement:
    adequate: bool


@dataclass(frozen=True)
class Step:
    name: str
    judgement: Judgement


class Filters(unittest.TestCase):
    def test_a_low_pass_is_named_from_any_cutoff_and_without_a_model(self):
        """White noise behind SciPy's bilinear filter, in counts. One extra effect by chance is
        allowed.
        """
        rate, arw, count, extra = 100.0, 0.2, 0.005, 0
        for share in (0.03, 0.1, 0.2, 0.3, 0.42):
            rng = np.random.default_rng(round(1000 * share))
            white = arw / 60 * np.sqrt(rate) * rng.standard_normal(60000)
            passed = signal.lfilter(*signal.butter(1, share * rate, fs=rate), white)
            with self.subTest(share=share), tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "rec.csv"
                time = np.arange(len(passed)) / rate
                rows = np.column_stack([time, np.round(passed / count) * count])
                np.savetxt(path, rows, "%.5f", ",", header="time_s,gyro_x_dps", comments="")
                found, _, wrong, _ = asking.ask(["improve", path])
                self.assertEqual(wrong, "")
                named = scoring.named(found)
                self.assertIn("low_pass", named)
                self.assertNotIn("moving_average", named)
                extra += len(named) - 1
                one = found["fitted"][0]["parameters"]["coefficient_deg_per_sqrt_h"]
                self.assertLess(one["low"], 1.01 * arw)
                self.assertGreater(one["high"], 0.99 * arw)
        self.assertLessEqual(extra, 1)


class End(unittest.TestCase):
    def ends(self, *adequate, late=()):
        """Names of the steps that are kept; late: those that the tests in time refute."""
        steps = [Step(name, Judgement(good)) for name, good in zip("abcde", adequate)]
        again = mock.Mock(
            side_effect=lambda one: replace(one, judgement=Judgement(one.name not in late))
        )
        with mock.patch.object(search, "judged", again):
            return "".join(step.name for step in search.best(steps))

    def test_it_ends_at_the_last_adequate_step(self):
        self.assertEqual(self.ends(False, False, True), "abc")
        self.assertEqual(self.ends(False, True, False), "ab")
        self.assertEqual(self.ends(True, False, False), "a")
        self.assertEqual(self.ends(False, True, True, False, late="c"), "ab")

    def test_without_an_adequate_step_all_are_kept(self):
        self.assertEqual(self.ends(False, False, False), "abc")
        self.assertEqual(self.ends(False, True, False, late="b"), "abc")


def crowded(lines, samples=20_000, seed=11):
    """White noise and many lines that wander, which bands follow one after the other."""
    rng = np.random.default_rng(seed)
    y = 0.05 * rng.standard_normal(samples)
    for f in np.linspace(1.0, 20.0, lines):
        turn = 2 * np.pi * f * np.arange(samples) / RATE
        y += 0.02 * np.sin(turn + np.cumsum(0.05 * rng.standard_normal(samples)))
    return Recording({"time_s": np.arange(samples) / RATE, COLUMN: y}, RATE)


MODEL = Model(
    RATE,
    COLUMN,
    [
        Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.4}),
        Term("bias_instability", {"coefficient_deg_per_h": 5.0}),
    ],
)


class Cost(unittest.TestCase):
    """By counts, which are the same on every machine."""

    @classmethod
    def setUpClass(cls):
        with np.errstate(all="ignore"):
            cls.start = state_of.start(crowded(12), MODEL)

    def forward(self):
        """(search, its steps, fits, transforms)."""
        work, steps = self.start.bench.data.work, []
        before = replace(work)
        self.start.bench.data.fits.clear()
        with np.errstate(all="ignore"):
            way = search.forward(self.start, 2, steps.append)
        return way, len(steps), work.fits - before.fits, work.transforms - before.transforms

    def test_a_crowded_spectrum_is_searched_within_the_bounds(self):
        _, steps, fits, transforms = self.forward()
        self.assertLessEqual(steps, SEARCH.steps_most)
        self.assertLess(fits, SEARCH.fits_most)
        self.assertLess(transforms, 1000)

    def test_a_search_ends_with_the_step_that_reaches_the_bound_and_says_so(self):
        with mock.patch.object(search, "SEARCH", replace(SEARCH, fits_most=100)):
            way, steps, fits, _ = self.forward()
        self.assertEqual((steps, way.ended), (1, "100 fits"))
        self.assertGreaterEqual(fits, 100)
        with mock.patch.object(search, "SEARCH", replace(SEARCH, steps_most=2)):
            way, steps, *_ = self.forward()
        self.assertEqual((steps, way.ended), (2, "2 steps"))

    def test_a_search_without_anything_left_did_not_reach_a_bound(self):
        quiet = Recording(
            {
                "time_s": np.arange(20_000) / RATE,
                COLUMN: 0.05 * np.random.default_rng(5).standard_normal(20_000),
            },
            RATE,
        )
        with np.errstate(all="ignore"):
            way = search.forward(state_of.start(quiet, MODEL), 2, lambda text: None)
        self.assertEqual(way.ended, "")
        self.assertEqual(evidence.notes(quiet, MODEL, (), way.ended), [])

    def test_a_note_names_the_bound(self):
        notes = evidence.notes(crowded(1), MODEL, (), "24 steps")
        self.assertEqual(len(notes), 1)
        self.assertIn("ended after 24 steps", notes[0])
        self.assertIn("may be missing", notes[0])


if __name__ == "__main__":
    unittest.main()
