"""davarlab on a few recordings of awkward sensors (awkward.py), short ones; and the scoring of the
benchmarks on made-up answers.
"""

from types import SimpleNamespace

import real_recordings
import scoring

# Short, so of each effect one that is seen in a few ten thousand samples. Where the benchmark
# allows a share of mistakes these allow none.


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


def scored(found, true):
    return scoring.outcome(found, true)[0]


def test_what_is_there_and_nothing_else_is_right():
    assert (
        scored(answer("low_pass", ["low_pass"]), truth(["moving_average", "low_pass"])) == "right"
    )
    assert scored(answer("none", []), truth()) == "right"
    assert (
        scored(
            answer("low_pass", ["low_pass", "narrow_band", "narrow_band"]),
            truth(["low_pass"], ["narrow_band"]),
        )
        == "right"
    )


def test_a_false_kind_is_wrong_when_it_explains_and_unknown_when_not():
    assert scored(answer("sinusoid", ["sinusoid"]), truth()) == "wrong"
    assert scored(answer("unknown", ["sinusoid"]), truth()) == "unknown"
    assert (
        scored(answer("sinusoid", ["sinusoid"], steps=[{"adequacy": "no"}]), truth()) == "unknown"
    )
    assert scored(answer("unknown", ["temperature"]), truth(["temperature"])) == "unknown"


def test_undecided_is_right_when_the_truth_is_among_a_few():
    found = answer("rate_random_walk", ["rate_random_walk"], alternatives=[{"kind": "temperature"}])
    assert scored(found, truth(["temperature"])) == "right"
    found["alternatives"] = [
        {"kind": kind} for kind in ("warm_up", "rate_ramp", "gauss_markov", "temperature")
    ]
    assert scored(found, truth(["temperature"])) == "wrong"


def test_half_of_the_truth_is_missed():
    assert scored(answer("low_pass", ["low_pass"]), truth(["low_pass"], ["sinusoid"])) == "missed"
    assert scored(answer("none", []), truth(observations={"motion"})) == "missed"
    assert (
        scored(
            answer("none", [], observations=[{"kind": "motion"}]),
            truth(observations={"motion|outliers"}),
        )
        == "right"
    )


def test_a_shape_is_part_of_the_truth():
    true = truth(["temperature"], shape={("temperature", "lag_s"): (30, 90)})
    assert scored(answer("temperature", ["temperature"]), true) == "missed"
    found = answer("temperature", ["temperature"])
    found["fitted"][1]["parameters"]["lag_s"] = {"value": 60.0, "low": 50.0, "high": 70.0}
    assert scored(found, true) == "right"


def test_words_count_where_they_are_said_of_the_recording():
    true = truth(said="common cause")
    assert scored(answer("none", [], candidates=[{"why": "a common cause"}]), true) == "missed"
    assert scored(answer("none", [], notes=["a common cause that was not logged"]), true) == "right"


def test_an_interval_counts_where_it_has_a_width_and_the_kind_is_single():
    found, true = answer("sinusoid", ["sinusoid"]), truth(["sinusoid"])
    true.kinds = {"sinusoid": {"frequency_hz": 3.0, "amplitude_dps": 1.0}}
    found["fitted"][1]["parameters"] = {
        "frequency_hz": {"value": 3.1, "low": 3.05, "high": 3.2},
        "amplitude_dps": {"value": 1, "low": 1, "high": 1},
    }
    assert scoring.intervals(found, true) == [("sinusoid", "frequency_hz", False, 3.0, 3.05, 3.2)]


def test_an_expert_contradicts_a_made_up_cause():
    real = real_recordings.RECORDINGS["ADIS16405 run 1"]
    assert real_recordings.judgement(real, "x", ["low_pass"], [])[0] == "yes"
    assert real_recordings.judgement(real, "z", ["low_pass"], [])[0] == "partly"
    assert real_recordings.judgement(real, "z", ["narrow_band", "g_sensitivity"], [])[:2] == (
        "no",
        ["g_sensitivity"],
    )
