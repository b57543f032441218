"""Long records are kept in single precision and processed in pieces, with the same results."""

from unittest import mock

import lab_bench
import numpy as np
import pytest
from davarlab.data import signals
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve

RATE, COUNT = 100.0, 60000
MODEL = lab_bench.model(RATE)


def recording(seed):
    """White and flicker noise, a line, and a temperature that the bias follows."""
    rng, time = np.random.default_rng([31, seed]), np.arange(COUNT) / RATE
    warm = 25 + 8 * np.sin(2 * np.pi * time / 410)
    y = lab_bench.noise(COUNT, RATE, rng)
    y += 0.01 * (warm - 25) + 0.003 * np.sin(2 * np.pi * 17.31 * time)
    return Recording({"time_s": time, "gyro_z_dps": y, "temp_degC": warm}, RATE)


def numbers(found):
    return {
        (term.kind, name): estimate
        for term, entry in zip(found.model.terms, found.estimates)
        for name, estimate in entry.items()
        if estimate.low is not None
    }


@pytest.mark.slow
def test_single_precision_gives_the_same_results():
    for seed in range(3):
        double = improve.improve(recording(seed), MODEL)
        with mock.patch.object(signals, "NARROW_FROM", 1000):
            single = improve.improve(recording(seed), MODEL)
        assert double.added == single.added
        assert double.judgement.adequacy == single.judgement.adequacy
        assert abs(double.judgement.error - single.judgement.error) < 5e-7
        for name, one in numbers(double).items():
            # A fit stops within 1e-6 units, which moves a parameter by 0.0014 standard errors.
            off = abs(numbers(single)[name].value - one.value)
            assert off < 0.0014 * (one.high - one.low), name


def test_a_record_is_turned_back_in_pieces():
    x, turns = np.random.default_rng(5).standard_normal(10007), 0.2137
    edges = np.linspace(0, len(x), 31).astype(int)
    for time in (None, np.arange(len(x)) + 0.1 * x):
        at = np.arange(len(x)) if time is None else time
        sums, middle = signals.turned_back(x, turns, 30, time)
        for piece, (first, end) in enumerate(zip(edges, edges[1:])):
            expected = np.sum(x[first:end] * np.exp(-2j * np.pi * turns * at[first:end]))
            assert abs(sums[piece] - expected) < 5e-10
            assert abs(middle[piece] - at[first:end].mean()) < 5e-10
