"""The scoring of the benchmarks, on made-up answers."""

import pytest
import real_recordings
import scoring
from ingredients.bench import Truth


def answer(*named, verdict=None, parameters=None, **more):
    fitted = [{"kind": kind, "parameters": parameters or {}} for kind in named]
    verdict = verdict or (named[0] if named else "none")
    return {"verdict": verdict, "missing": list(named), "fitted": fitted, "steps": [{}], **more}


def truth(*groups, **more):
    return Truth(groups=[set(group.split()) for group in groups], **more)


MANY = [{"kind": kind} for kind in ("warm_up", "rate_ramp", "gauss_markov", "temperature")]
LAG = {"lag_s": {"value": 60.0, "low": 50.0, "high": 70.0}}
LATE = truth("temperature", shape={("temperature", "lag_s"): (30, 90)})
COMMON = truth(said="common cause")
SCORES = {
    "one name of two": ("right", answer("low_pass"), truth("moving_average low_pass")),
    "nothing": ("right", answer(), truth()),
    "a kind twice": (
        "right",
        answer("sinusoid", "low_pass", "low_pass"),
        truth("low_pass", "sinusoid"),
    ),
    "a false kind that explains": ("wrong", answer("sinusoid"), truth()),
    "a false kind, unknown": ("unknown", answer("sinusoid", verdict="unknown"), truth()),
    "not adequate": ("unknown", answer("sinusoid", steps=[{"adequacy": "no"}]), truth()),
    "true, yet unknown": ("unknown", answer("warm_up", verdict="unknown"), truth("warm_up")),
    "one of a few": ("right", answer("shocks", alternatives=MANY[-1:]), truth("temperature")),
    "one of many": ("wrong", answer("shocks", alternatives=MANY), truth("temperature")),
    "half": ("missed", answer("low_pass"), truth("low_pass", "sinusoid")),
    "not observed": ("missed", answer(), truth(observations={"motion"})),
    "observed": (
        "right",
        answer(observations=[{"kind": "motion"}]),
        truth(observations={"motion|outliers"}),
    ),
    "no shape": ("missed", answer("temperature"), LATE),
    "the shape": ("right", answer("temperature", parameters=LAG), LATE),
    "said of a candidate": ("missed", answer(candidates=[{"why": "a common cause"}]), COMMON),
    "said of the recording": ("right", answer(notes=["a common cause, not logged"]), COMMON),
}


@pytest.mark.parametrize("name", SCORES)
def test_an_answer_beside_its_truth(name):
    score, found, true = SCORES[name]
    assert scoring.outcome(found, true)[0] == score


def test_an_interval_counts_where_it_has_a_width():
    true = truth(kinds={"sinusoid": {"frequency_hz": 3.0, "amplitude_dps": 1.0}})
    ends = {"frequency_hz": (3.05, 3.2), "amplitude_dps": (1, 1)}
    given = {name: {"value": low, "low": low, "high": high} for name, (low, high) in ends.items()}
    found = answer("sinusoid", parameters=given)
    assert scoring.intervals(found, true) == [("sinusoid", "frequency_hz", False, 3.0, 3.05, 3.2)]


def test_an_expert_contradicts_a_made_up_cause():
    real = real_recordings.RECORDINGS["ADIS16405 run 1"]
    assert real_recordings.judgement(real, "x", ["low_pass"], [])[0] == "yes"
    assert real_recordings.judgement(real, "z", ["low_pass"], [])[0] == "partly"
    strange = real_recordings.judgement(real, "z", ["narrow_band", "g_sensitivity"], [])
    assert strange[:2] == ("no", ["g_sensitivity"])
