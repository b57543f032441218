"""A line that drifts, the zeros of a moving average, repeats behind counts and dead zones: against
brute force and simulations with numpy.
"""

import re

import numpy as np
from davarlab.candidates import drifting
from davarlab.candidates.candidate import Candidate
from davarlab.data import observations, repeats, signals
from davarlab.data.recording import Recording
from davarlab.effects import filters
from davarlab.inference.parts import Bench, Part, part_of
from davarlab.model import Term
from lab_bench import run
from scipy import interpolate
from scipy import signal as scipy_signal

RATE = 100.0


def test_ordinates_of_averaged_noise_have_the_variance_of_gain_and_ends():
    """Against the covariance matrix, with every ordinate."""
    for samples in (2.0, 3.0, 4.0, 5.3, 8.0):
        weights = np.ones(int(np.ceil(samples)))
        weights[-1] -= len(weights) - samples
        products = np.correlate(weights, weights, "full") / samples**2
        count, reach = 300, len(weights) - 1
        lag = np.subtract.outer(np.arange(count), np.arange(count))
        covariance = np.where(np.abs(lag) <= reach, products[np.clip(lag + reach, 0, 2 * reach)], 0)
        basis = signals.transform(np.eye(count))
        exact = np.einsum("ki,ij,kj->k", basis, covariance, basis)[1:]
        f, shape = signals.frequencies(count, RATE), {"samples": samples}
        found = filters.moving_average(f, RATE, shape)
        found = found + filters.leaked(f, RATE, shape) / count
        np.testing.assert_allclose(found, exact, atol=1e-13)


def test_zeros_are_where_the_gain_is_nothing():
    for samples in range(2, 9):
        shape = {"samples": float(samples)}
        at = np.array(filters.zeros(RATE, shape))
        assert len(at) == samples // 2
        np.testing.assert_allclose(filters.moving_average(at, RATE, shape), 0, atol=1e-28)
    assert filters.zeros(RATE, {"samples": 3.5}) == []


def test_the_course_of_a_line_in_noise_is_followed():
    """Frequency within 3 mHz everywhere but at the ends, and nearly all of the line's energy,
    though it is below the noise of single samples.
    """
    for seed, moves in ((1, 0.4), (2, 1.5), (3, 2.5)):
        rng, count = np.random.default_rng(seed), 90_000
        u = np.arange(count) / count
        f = 0.27 + moves / RATE * np.cumsum(np.cos(9 * u + seed)) / count
        line = 0.5 * np.sin(2 * np.pi * np.cumsum(f))
        z, time = drifting.beside_zero(line + rng.standard_normal(count), 0.23, 0.31)
        _, knots = drifting.followed(z, time, count - 1.0)
        at = np.linspace(0, count - 1, len(knots))
        course = (int(0.23 * count) + len(z) // 2) / count
        course = course + interpolate.CubicSpline(at, knots)(np.arange(count))
        inside = slice(count // 20, -count // 20)
        assert np.abs(course - f)[inside].max() * RATE < 3e-3
        gain = drifting.gathered(z, time, count - 1.0, knots)[0]
        assert gain > 0.9 * np.sum(line**2) / 2


def test_a_steady_line_does_not_drift():
    """Whatever else the model lacks: a second line, and a slow wave."""
    for seed in range(6):
        rng, count = np.random.default_rng([seed, 9]), 60_000
        first, second = rng.uniform(1, 49, 2)
        y, at = 0.05 * rng.standard_normal(count), np.arange(count) / RATE
        for hz, size in ((first, 0.02), (second, 0.02), (0.0015, 0.04)):
            y += size * np.sin(2 * np.pi * (hz * at + rng.random()))
        white = part_of(Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3}))
        bench = Bench(Recording({"gyro_z_dps": y}, RATE), y)
        fit = bench.fit([white])
        shape = {"std_dps": 0.0, "frequency_hz": first, "half_width_hz": 0.001}
        band = Candidate("narrow_band", Part("narrow_band", shape), 100.0, -90.0)
        assert drifting.search(bench, [white], fit, band) is None, seed


def test_noise_with_a_width_has_no_course():
    """A line with a width forgets its phase: it stays a narrow band."""
    for seed in (1, 2, 3):
        rng, count = np.random.default_rng([seed, 5]), 90_000
        decay = np.exp(-2 * np.pi * 0.2 / RATE)
        kicks = rng.standard_normal((2, count)) * np.sqrt(1 - decay**2)
        a, b = scipy_signal.lfilter([1], [1, -decay], kicks, axis=1)
        turn = 2 * np.pi * 0.27 * np.arange(count)
        band = 0.5 * (a * np.cos(turn) + b * np.sin(turn))
        z, time = drifting.beside_zero(band + rng.standard_normal(count), 0.23, 0.31)
        _, knots = drifting.followed(z, time, count - 1.0)
        gain = drifting.gathered(z, time, count - 1.0, knots)[0]
        assert gain < 0.5 * np.sum(band**2) / 2


def drifting_term(course):
    return f'[[effect]]\nkind = "drifting_line"\namplitude_dps = 0.05\ncourse_hz = "{course}"\n'


def test_a_model_with_a_course_is_simulated_found_and_explains(lab):
    recording, better = lab.simulated(drifting_term("9 9.2 9.9 9.7"), 4, 900), "better.toml"
    done = run("improve", recording, "-m", lab.model, "-o", lab.work / better)
    assert done.returncode == 0, done.stderr
    assert "lacks drifting line: " in done.stdout
    assert re.search(r"course (8\.9|9)\S* to (9\.9|10)\S* Hz \(\d+ knots\)", done.stdout)
    assert run("compare", recording, "-m", lab.work / better).returncode == 0


def counted(seed, per_noise, each=1.0, decay=0.0, count=60_000):
    """A gyro in counts, so many per noise, that is read `each` times a sample."""
    rng = np.random.default_rng([seed, 8])
    y = scipy_signal.lfilter([1], [1, -decay], rng.standard_normal(count)) * np.sqrt(1 - decay**2)
    y = np.round(y * per_noise + rng.uniform(0, 1))[(np.arange(count) / each).astype(int)]
    return {"gyro_z_dps": 0.01 * y}


def test_counts_explain_the_equal_samples_of_gaussian_noise():
    for per_noise in (0.7, 1.0, 2.0, 4.0):
        for decay in (0.0, 0.5):
            x = counted(1, per_noise, decay=decay, count=400_000)["gyro_z_dps"]
            chance = repeats.by_counts(x, np.ones(len(x), bool))
            if chance is not None:
                assert abs(chance / np.mean(np.diff(x) == 0) - 1) <= 0.06


def test_repeats_are_found_behind_counts_and_not_left_out():
    for seed in range(5):
        for per_noise, each in ((0.8, 1.3), (1.0, 1.8), (2.0, 2.0), (3.0, 3.0)):
            columns = counted(seed, per_noise, each)
            found = repeats.find(columns, np.ones(60_000, bool))
            assert found is not None
            assert not found.clear


def test_coarse_counts_alone_are_no_repeats():
    for seed in range(10):
        for per_noise in (0.25, 0.4, 0.7, 1.0, 2.0, 5.0):
            for decay in (0.0, 0.6, 0.95):
                columns = counted(seed, per_noise, decay=decay)
                assert repeats.find(columns, np.ones(60_000, bool)) is None


def seen(x):
    time = np.arange(len(x)) / RATE
    recording = Recording({"time_s": time, "gyro_z_dps": x}, RATE)
    return observations.dead(recording, x, np.ones(len(x), bool))


def test_small_rates_that_are_one_value_are_a_dead_zone():
    for seed in range(5):
        x = 0.05 * np.random.default_rng(seed).standard_normal(20_000)
        found = seen(np.round(np.where(np.abs(x) < 0.02, 0, x), 3))
        assert abs(found.share - 0.31) <= 0.02
        assert found.spoils


def test_noise_behind_counts_is_none():
    for seed in range(10):
        x = np.random.default_rng(seed).standard_normal(20_000)
        for counts in (0.3, 1, 3, 6, 30, 1e4):
            assert seen(np.round(x * counts) * 0.01) is None
