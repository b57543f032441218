"""davarlab on a few recordings of awkward sensors (awkward.py), short ones; and the scoring of the
benchmarks on made-up answers.
"""

import unittest
from types import SimpleNamespace

import benchmark_awkward
import real_recordings
import scoring


class Awkward(unittest.TestCase):
    """Short, so of each effect one that is seen in a few ten thousand samples. Where the benchmark
    allows a share of mistakes these allow none.
    """

    def right(self, case, seed, rate=None, seconds=None):
        row = benchmark_awkward.one((case, seed, rate, seconds))
        self.assertEqual((row["outcome"], row["reasons"]), ("right", []), row)
        self.assertEqual(row["untrue_observations"], [], row)
        return row

    def test_nothing_there_beside_columns_that_move(self):
        self.right("clean decoys", 1, rate=20.0)

    def test_a_line_with_a_width(self):
        self.right("narrow_band", 1, seconds=600.0)

    def test_two_samples_averaged(self):
        self.right("two_tap_average", 1, seconds=600.0)

    def test_a_filter_of_second_order(self):
        self.right("butterworth", 1, seconds=600.0)

    def test_a_band_beside_a_filter_and_no_other(self):
        for seed in (1, 2, 3):
            row = benchmark_awkward.one(("low_band + butterworth", seed, None, 600.0))
            self.assertEqual(sorted(row["named"]), ["low_pass", "narrow_band"], row)

    def test_slow_noise_behind_an_average_of_several_samples_and_nothing_else(self):
        for seed in (1, 2, 3, 4):
            row = benchmark_awkward.one(("gauss_markov + average_of_several", seed, None, 900.0))
            self.assertEqual(set(row["named"]), {"moving_average", "gauss_markov"}, row)

    def test_one_line_that_drifts(self):
        for case in ("drifting_line", "drifting_as_it_warms"):
            for seed in (1, 2):
                row = self.right(case, seed, seconds=900.0)
                self.assertEqual(row["named"], ["drifting_line"], row)

    def test_a_dead_zone_is_observed_and_nothing_named(self):
        for seed in (1, 2, 3):
            row = self.right("dead_zone", seed, seconds=300.0)
            self.assertEqual((row["verdict"], row["named"]), ("unknown", []), row)

    def test_repeats_behind_counts_are_observed_and_nothing_named(self):
        for seed in (1, 2, 3):
            row = self.right("repeated_behind_counts", seed, seconds=300.0)
            self.assertEqual((row["verdict"], row["named"]), ("unknown", []), row)

    def test_turned_by_hand(self):
        self.right("motion_turned", 1, rate=20.0)

    def test_samples_lost(self):
        self.right("line + lost_samples", 1, rate=20.0)


def answer(verdict, named, **more):
    fitted = [{"kind": kind, "parameters": {}} for kind in ["angle_random_walk", *named]]
    return {"verdict": verdict, "missing": list(named), "fitted": fitted, "steps": [{}]} | more


def truth(*groups, **more):
    return SimpleNamespace(
        **{
            "groups": [set(group) for group in groups],
            "extra": set(),
            "observations": set(),
            "shape": {},
            "said": "",
            "unknown_is_right": False,
            **more,
        }
    )


class Scoring(unittest.TestCase):
    def scored(self, found, true):
        return scoring.outcome(found, true)[0]

    def test_what_is_there_and_nothing_else_is_right(self):
        self.assertEqual(
            self.scored(answer("low_pass", ["low_pass"]), truth(["moving_average", "low_pass"])),
            "right",
        )
        self.assertEqual(self.scored(answer("none", []), truth()), "right")
        self.assertEqual(
            self.scored(
                answer("low_pass", ["low_pass", "narrow_band", "narrow_band"]),
                truth(["low_pass"], ["narrow_band"]),
            ),
            "right",
        )

    def test_a_false_kind_is_wrong_when_it_explains_and_unknown_when_not(self):
        self.assertEqual(self.scored(answer("sinusoid", ["sinusoid"]), truth()), "wrong")
        self.assertEqual(self.scored(answer("unknown", ["sinusoid"]), truth()), "unknown")
        self.assertEqual(
            self.scored(answer("sinusoid", ["sinusoid"], steps=[{"adequacy": "no"}]), truth()),
            "unknown",
        )
        self.assertEqual(
            self.scored(answer("unknown", ["temperature"]), truth(["temperature"])), "unknown"
        )

    def test_undecided_is_right_when_the_truth_is_among_a_few(self):
        found = answer(
            "rate_random_walk", ["rate_random_walk"], alternatives=[{"kind": "temperature"}]
        )
        self.assertEqual(self.scored(found, truth(["temperature"])), "right")
        found["alternatives"] = [
            {"kind": kind} for kind in ("warm_up", "rate_ramp", "gauss_markov", "temperature")
        ]
        self.assertEqual(self.scored(found, truth(["temperature"])), "wrong")

    def test_half_of_the_truth_is_missed(self):
        self.assertEqual(
            self.scored(answer("low_pass", ["low_pass"]), truth(["low_pass"], ["sinusoid"])),
            "missed",
        )
        self.assertEqual(self.scored(answer("none", []), truth(observations={"motion"})), "missed")
        self.assertEqual(
            self.scored(
                answer("none", [], observations=[{"kind": "motion"}]),
                truth(observations={"motion|outliers"}),
            ),
            "right",
        )

    def test_a_shape_is_part_of_the_truth(self):
        true = truth(["temperature"], shape={("temperature", "lag_s"): (30, 90)})
        self.assertEqual(self.scored(answer("temperature", ["temperature"]), true), "missed")
        found = answer("temperature", ["temperature"])
        found["fitted"][1]["parameters"]["lag_s"] = {"value": 60.0, "low": 50.0, "high": 70.0}
        self.assertEqual(self.scored(found, true), "right")

    def test_words_count_where_they_are_said_of_the_recording(self):
        true = truth(said="common cause")
        self.assertEqual(
            self.scored(answer("none", [], candidates=[{"why": "a common cause"}]), true), "missed"
        )
        self.assertEqual(
            self.scored(answer("none", [], notes=["a common cause that was not logged"]), true),
            "right",
        )

    def test_an_interval_counts_where_it_has_a_width_and_the_kind_is_single(self):
        found, true = answer("sinusoid", ["sinusoid"]), truth(["sinusoid"])
        true.kinds = {"sinusoid": {"frequency_hz": 3.0, "amplitude_dps": 1.0}}
        found["fitted"][1]["parameters"] = {
            "frequency_hz": {"value": 3.1, "low": 3.05, "high": 3.2},
            "amplitude_dps": {"value": 1, "low": 1, "high": 1},
        }
        self.assertEqual(
            scoring.intervals(found, true), [("sinusoid", "frequency_hz", False, 3.0, 3.05, 3.2)]
        )

    def test_an_expert_contradicts_a_made_up_cause(self):
        real = real_recordings.RECORDINGS["ADIS16405 run 1"]
        self.assertEqual(real_recordings.judgement(real, "x", ["low_pass"], [])[0], "yes")
        self.assertEqual(real_recordings.judgement(real, "z", ["low_pass"], [])[0], "partly")
        self.assertEqual(
            real_recordings.judgement(real, "z", ["narrow_band", "g_sensitivity"], [])[:2],
            ("no", ["g_sensitivity"]),
        )


if __name__ == "__main__":
    unittest.main()
