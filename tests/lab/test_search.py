"""The way of the search: where it ends, and what it may cost."""

from dataclasses import dataclass, replace
from unittest import mock

import lab_bench
import numpy as np
import pytest
from davarlab.data.recording import Recording
from davarlab.diagnosis import evidence, fitting, search
from davarlab.thresholds import SEARCH

RATE, COLUMN = 50.0, "gyro_z_dps"


@dataclass(frozen=True)
class Judgement:
    adequate: bool


@dataclass(frozen=True)
class Step:
    name: str
    judgement: Judgement


def ends(*adequate, late=()):
    """Names of the steps that are kept; late: those that the tests in time refute."""
    steps = [Step(name, Judgement(good)) for name, good in zip("abcde", adequate)]
    again = mock.Mock(
        side_effect=lambda one: replace(one, judgement=Judgement(one.name not in late))
    )
    with mock.patch.object(search, "judged", again):
        return "".join(step.name for step in search.best(steps))


def test_it_ends_at_the_last_adequate_step():
    assert ends(False, False, True) == "abc"
    assert ends(False, True, False) == "ab"
    assert ends(True, False, False) == "a"
    assert ends(False, True, True, False, late="c") == "ab"


def test_without_an_adequate_step_all_are_kept():
    assert ends(False, False, False) == "abc"
    assert ends(False, True, False, late="b") == "abc"


MODEL = lab_bench.model(RATE, 0.4)


def crowded(lines, samples=20_000, seed=11):
    """White noise and many lines that wander, which bands follow one after the other."""
    rng = np.random.default_rng(seed)
    y = 0.05 * rng.standard_normal(samples)
    for f in np.linspace(1.0, 20.0, lines):
        turn = 2 * np.pi * f * np.arange(samples) / RATE
        y += 0.02 * np.sin(turn + np.cumsum(0.05 * rng.standard_normal(samples)))
    return Recording({"time_s": np.arange(samples) / RATE, COLUMN: y}, RATE)


@pytest.fixture(scope="module")
def start():
    with np.errstate(all="ignore"):
        return fitting.start(crowded(12), MODEL)


def forward(start):
    """(search, its steps, fits, transforms): counts, which are the same on every machine."""
    work, steps = start.bench.data.work, []
    before = replace(work)
    start.bench.data.fits.clear()
    with np.errstate(all="ignore"):
        way = search.forward(start, 2, steps.append)
    return way, len(steps), work.fits - before.fits, work.transforms - before.transforms


@pytest.mark.slow
def test_a_crowded_spectrum_is_searched_within_the_bounds(start):
    _, steps, fits, transforms = forward(start)
    assert steps <= SEARCH.steps_most
    assert fits < SEARCH.fits_most
    assert transforms < 1000


@pytest.mark.slow
def test_a_search_ends_with_the_step_that_reaches_the_bound_and_says_so(start, monkeypatch):
    monkeypatch.setattr(search, "SEARCH", replace(SEARCH, fits_most=100))
    way, steps, fits, _ = forward(start)
    assert (steps, way.ended) == (1, "100 fits")
    assert fits >= 100
    monkeypatch.setattr(search, "SEARCH", replace(SEARCH, steps_most=2))
    way, steps, *_ = forward(start)
    assert (steps, way.ended) == (2, "2 steps")


def test_a_search_without_anything_left_did_not_reach_a_bound():
    quiet = lab_bench.of_gyro(0.05 * np.random.default_rng(5).standard_normal(20_000))
    with np.errstate(all="ignore"):
        way = search.forward(fitting.start(quiet, MODEL), 2, lambda text: None)
    assert way.ended == ""
    assert evidence.notes(quiet, MODEL, (), way.ended) == []
    (note,) = evidence.notes(quiet, MODEL, (), "24 steps")
    assert "ended after 24 steps" in note
    assert "may be missing" in note
