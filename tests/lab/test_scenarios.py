"""davarlab names what is hidden in a recording, and nothing else: lab_scenarios.py."""

import numpy as np
import pytest
import scoring
from lab_scenarios import QUICK, SCENARIOS

ROWS = [
    pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK), id=name)
    for name in SCENARIOS
]


def near(found, true):
    value, off = true
    return abs(found["value"] - value) <= off


def inside(found, value):
    return found["low"] <= value <= found["high"] and found["low"] < found["value"] < found["high"]


def as_list(value):
    return value if isinstance(value, list) else [value]


@pytest.mark.parametrize("name", ROWS)
def test_what_is_hidden_is_found_with_its_numbers(analysed, name):
    one = analysed(name)
    row, found = one.scenario, one.json
    if row.missing is not None:
        assert sorted(found["missing"]) == sorted(row.missing), found["answer_said"]
    assert not row.includes or row.includes in found["missing"], found["doubtful"]
    if row.verdict == "known":
        assert found["verdict"] != "unknown", found["answer_said"]
    elif row.verdict:
        assert found["verdict"] == row.verdict
    open_ones = {entry["kind"] for entry in found["alternatives"]}
    assert not set(row.absent) & (open_ones | set(found["missing"]))
    for parameter, truths in row.near.items():
        for estimate, true in zip(one.estimates(parameter), as_list(truths), strict=True):
            if isinstance(true, str):
                assert estimate["value"] == true
            else:
                assert near(estimate, true), (parameter, estimate, true)
    for parameter, true in row.holds.items():
        (estimate,) = one.estimates(parameter)
        assert inside(estimate, true), (parameter, estimate)
    if row.truth:
        assert scoring.outcome(found, row.truth) == ("right", [])
        told = {*"|".join([*row.truth.observations, *row.truth.tolerated]).split("|"), "unknown"}
        assert scoring.observed(found) <= told
    errors = [step["error"] for step in found["steps"]]
    assert errors[-1] <= errors[0] * 1.02


def test_what_one_sine_cannot_tell_is_said(analysed):
    confirm = [one["confirm"] for one in analysed("late heat, one cycle").json["alternatives"]]
    assert "two full cycles" in " ".join(confirm)


def test_a_random_walk_has_only_other_noise_beside_it(analysed):
    from davarlab.candidates import identifiable

    kinds = {one["kind"] for one in analysed("a random walk").json["alternatives"]}
    assert kinds <= set(identifiable.NOISE)


def test_a_lag_that_the_model_lacks_takes_the_place_of_its_temperature(analysed):
    kinds = ["angle_random_walk", "bias_instability", "temperature"]
    assert analysed("a temperature of the model felt late").kinds == kinds


@pytest.mark.slow
def test_a_low_pass_is_named_from_any_cutoff_and_without_a_model(analysed):
    """One extra effect by chance is allowed."""
    extra = 0
    for name in (name for name in SCENARIOS if name.startswith("a cutoff")):
        one = analysed(name)
        assert "low_pass" in one.json["missing"]
        extra += len(one.json["missing"]) - 1
        (arw,) = one.estimates("angle_random_walk.coefficient_deg_per_sqrt_h")
        assert 0.99 * arw["low"] < 0.2 < 1.01 * arw["high"]
    assert extra <= 1


def test_improve_adds_in_steps_whose_errors_fall(analysed):
    steps = analysed("line").json["steps"]
    assert [step["added"] for step in steps] == [None, "sinusoid"]
    assert steps[1]["error"] < steps[0]["error"] / 2
    assert steps[0]["p_value"] < 1e-6
    assert steps[1]["p_value"] > 0.01


@pytest.mark.parametrize("name", ["temperature", "line", "shocks", "a step", "a visit"])
def test_every_interval_has_its_value_inside(analysed, name):
    for entry in analysed(name).json["fitted"]:
        for one in entry["parameters"].values():
            if one["low"] is not None:
                assert np.isfinite([one["low"], one["high"]]).all()
                assert one["low"] <= one["value"] <= one["high"]
