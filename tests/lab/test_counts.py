"""Rates and angles in counts, rounded by formulas of this file; samples that are read twice behind
them, and dead zones.
"""

import lab_bench
import numpy as np
import pytest
from davarlab.data import counts, observations, repeats, signals
from davarlab.diagnosis import improve
from davarlab.thresholds import COUNTS
from scipy import signal

RATE, N, B = 100.0, 0.3, 5.0
SIGMA = N / 60 * RATE**0.5
MODEL = lab_bench.model(RATE, N, B)


def gyro(samples, rng):
    return lab_bench.noise(samples, RATE, rng, N, B) + rng.uniform(-0.5, 0.5)


def rate_in_counts(y, q):
    return np.round(y / q) * q


def angle_in_counts(y, q):
    """q: of the angle, as a rate over one sample."""
    return np.diff(np.round(np.concatenate([[0], np.cumsum(y)]) / q)) * q


def improved(y):
    """(improvement, N fitted over the true one)."""
    found = improve.improve(lab_bench.of_gyro(np.round(y, 6), RATE), MODEL)
    return found, np.sqrt(found.diagnosis.states[-1].fit.sizes[0]) * 60 / N


def test_the_count_is_found_whatever_was_done_to_the_values_and_only_where_there_is_one():
    rng = np.random.default_rng(1)
    for q in (1 / 131, 0.05, 0.0175 * 57.3):
        k = np.round(0.8 * rng.normal(size=50000) + 0.3)
        wild = np.round(1e3 * rng.normal(size=len(k)) * (rng.random(len(k)) < 1e-4))
        for y in (
            k * q + 0.123456,
            (k * q + 4.54).astype(np.float32).astype(float),
            np.round(k * q, 6),
            k * q - (k * q).mean(),
            np.diff(np.cumsum(k * q)),
            (k + wild) * q,
            np.round(1000 * k * q, 2) / 1000,
        ):
            assert abs(counts.step(y) / q - 1) <= 1e-3
    x = rng.normal(size=50000)
    tilted = np.round(x) + 0.5 * np.arange(len(x)) / len(x)
    for y in (x, np.round(x, 6), tilted, x[:1000], np.zeros(1000)):
        assert counts.step(y) < 1e-4
    assert abs(signals.count_of(0.2 + np.round(3 * x) * 0.0625) - 0.0625) < 5e-10


def test_mean_and_variance_of_rounded_noise_as_drawn():
    rng = np.random.default_rng(3)
    for sigma, phase in ((0.2, 0.1), (0.3, -0.4), (0.5, 0.25)):
        k = np.round(phase + sigma * rng.normal(size=400000))
        mean, variance, _ = counts.rounded(sigma, np.array([phase]))
        assert abs(mean[0] - k.mean()) <= 4 * k.std() / 400000**0.5
        assert abs(variance[0] / k.var() - 1) <= 0.02


def test_the_noise_behind_the_counts():
    rng = np.random.default_rng(4)
    for sigma in (0.25, 0.3, 0.4, 0.5):
        bias = np.linspace(0, 1.3, 100000)
        found = counts.found(np.round(bias + sigma * rng.normal(size=100000)) * 0.01, RATE)
        assert found.of == "rate"
        assert abs(found.sigma_counts / sigma - 1) <= 0.025


def test_a_moving_bias_explains_why_the_noise_changes():
    rng = np.random.default_rng(5)
    y = np.round(np.linspace(0, 2, 200000) + 0.3 * rng.normal(size=200000))
    slope, error, before, after = counts.explained(y, counts.found(y, RATE), 100)
    assert abs(slope - 1) <= max(3 * error, 0.03)
    assert before > 3 * after
    assert after < 1.4


def test_the_error_spectrum_is_that_of_a_rounded_walk():
    rng = np.random.default_rng(7)
    for sigma, mean in ((0.1, 0.37), (0.2, 0.13), (0.3, 0.013), (0.5, 0.2)):
        angle = np.cumsum(mean + sigma * rng.normal(size=400000))
        nu, drawn = signal.periodogram(np.round(angle) - angle, 2.0, "hann", detrend=False)
        increments = np.zeros(COUNTS.lags + 1)
        increments[0] = sigma**2
        known = counts.error_spectrum(increments, np.array([mean]))
        ratio = [
            drawn[part].mean() / np.interp(nu[part], np.linspace(0, 1, len(known)), known).mean()
            for part in np.array_split(np.arange(1, len(nu)), 20)
        ]
        np.testing.assert_allclose(ratio, 1, atol=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("seed, sigma", [(0, 0.25), (2, 0.4), (4, 1.0)])
def test_of_a_rate_in_counts_nothing_is_missing(seed, sigma):
    rng, q = np.random.default_rng([6, seed]), SIGMA / sigma
    drift = np.linspace(0, 0.7, 120000) * q  # through most of a count
    found, size = improved(rate_in_counts(gyro(120000, rng), q))
    assert (found.diagnosis.added, found.verdict) == ([], "none")
    assert abs(size - 1) <= 0.03
    named = improved(rate_in_counts(gyro(120000, rng) + drift, q))[0].diagnosis.added
    made_up = {"noise_step", "shocks", "low_pass", "quantization", "gauss_markov"}
    assert not set(named) & made_up


@pytest.mark.parametrize("seconds", (18, 60))
def test_a_bias_on_a_count_leaves_short_sections_without_a_change_and_the_model_fits(seconds):
    """With noise of 0.35 counts, a sample in seven has another value: 36 in a row may have none."""
    fits = []
    for seed in range(6):
        rng = np.random.default_rng([18, seed])
        place = 3 + rng.uniform(-0.06, 0.06)
        y = 0.061 * np.round(place + 0.35 * rng.standard_normal(int(seconds * RATE)))
        state, _, estimates = improve.fit(lab_bench.of_gyro(y, RATE), MODEL)
        fits.append(state.judgement.adequate)
        arw = estimates[0]["coefficient_deg_per_sqrt_h"].number
        assert arw == pytest.approx(60 * 0.35 * 0.061 / RATE**0.5, rel=0.12)
    assert sum(fits) >= 5, fits


@pytest.mark.slow
def test_an_angle_in_counts_is_quantization_and_nothing_else():
    wrong = []
    for seed, sigma in enumerate((0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.5, 0.7, 1.0, 1.5)):
        rng = np.random.default_rng([8, seed])
        found, size = improved(angle_in_counts(gyro(60000, rng), SIGMA / sigma))
        right = (found.verdict, found.diagnosis.added) == ("quantization", ["quantization"])
        if not right or abs(size - 1) > 0.02 or found.last.error > 1.25 * found.last.error_floor:
            wrong.append((sigma, found.verdict, found.diagnosis.added, size))
    assert len(wrong) <= 1, wrong


# Equal samples beside each other: by counts alone, or because they are read twice.


def counted(seed, per_noise, each=1.0, decay=0.0, count=60_000):
    """A gyro in counts, so many per noise, that is read `each` times a sample."""
    rng = np.random.default_rng([seed, 8])
    y = signal.lfilter([1], [1, -decay], rng.standard_normal(count)) * np.sqrt(1 - decay**2)
    return 0.01 * np.round(y * per_noise + rng.random())[(np.arange(count) / each).astype(int)]


def repeated(x):
    return repeats.find({"gyro_z_dps": x}, np.ones(len(x), bool))


def test_counts_explain_the_equal_samples_of_gaussian_noise():
    for per_noise in (0.7, 1.0, 2.0, 4.0):
        for decay in (0.0, 0.5):
            x = counted(1, per_noise, decay=decay, count=400_000)
            chance = repeats.by_counts(x, np.ones(len(x), bool))
            assert chance is None or abs(chance / np.mean(np.diff(x) == 0) - 1) <= 0.06


def test_repeats_are_found_behind_counts_and_not_left_out_and_coarse_counts_are_none():
    for seed in range(5):
        for per_noise, each in ((0.8, 1.3), (1.0, 1.8), (2.0, 2.0), (3.0, 3.0)):
            assert not repeated(counted(seed, per_noise, each)).clear
        for per_noise in (0.25, 0.4, 0.7, 1.0, 2.0, 5.0):
            for decay in (0.0, 0.6, 0.95):
                assert repeated(counted(seed, per_noise, decay=decay)) is None


AXES = ("gyro_x_dps", "gyro_y_dps", "gyro_z_dps")


def of_axes(seed, per_noise, decay=0.0, count=20_000, turned=0.0):
    """Three axes in counts at biases of their own, that are turned in the second half."""
    rng = np.random.default_rng([seed, 9])
    noise = signal.lfilter([1], [1, -decay], rng.standard_normal((3, count))) * per_noise
    turn = np.maximum(np.arange(count) - count // 2, 0) * 2 * np.pi * 0.7 / RATE
    x = np.sqrt(1 - decay**2) * noise + rng.random((3, 1)) + turned * np.sin(turn)
    return {name: 0.061 * np.round(axis) for name, axis in zip(AXES, x)}


def sampled(columns, at):
    return {name: column[at] for name, column in columns.items()}


def found_in(columns):
    return repeats.find(columns, np.ones(len(columns[AXES[0]]), bool))


@pytest.mark.parametrize("per_noise", (0.2, 0.35, 0.7, 2.0, 30.0))
def test_several_axes_tell_repeats_from_counts(per_noise):
    """Even ones from half a count of noise on, random ones where counts hide few."""
    for seed in range(4):
        for decay in (0.0, 0.9):
            for turned in (0.0, 300.0):
                assert found_in(of_axes(seed, per_noise, decay, turned=turned)) is None
        whole = of_axes(seed, per_noise)
        again = np.random.default_rng(seed).random(20_000) < 0.3
        at = np.maximum.accumulate(np.where(again, 0, np.arange(20_000)))
        for chosen, least in ((at, 2), (np.arange(20_000) * 7 // 10, 0.7)):
            found = found_in(sampled(whole, chosen))
            if per_noise >= least:
                assert abs((found.share - found.chance) / (1 - found.chance) - 0.3) <= 0.03
                assert found.clear == (per_noise >= 2)


def test_an_axis_in_other_words_and_a_common_vibration_are_no_repeats():
    t = np.arange(20_000) / RATE
    for seed in range(3):
        rng = np.random.default_rng([seed, 10])
        x = np.round(0.35 * rng.standard_normal(20_000) + rng.random())
        for other in (-x, x * np.pi / 180, 2 * x + 1):
            assert found_in({AXES[0]: x, AXES[1]: other}) is None
        bursts = np.where(t % 1 < 0.3, 5.0, 0.35) * rng.standard_normal((3, 20_000))
        rocking = [
            0.35 * rng.standard_normal((3, 20_000)) + size * np.sin(2 * np.pi * 0.08 * RATE * t)
            for size in (2.0, 5.0)
        ]
        for noise in (bursts, *rocking):
            y = np.round(noise + rng.random((3, 1)))
            assert found_in(dict(zip(AXES, y))) is None


def test_a_sensor_that_stalls_on_all_axes_is_found():
    columns = of_axes(1, 5.0)
    for start in range(50, 20_000, 2000):
        for axis in columns.values():
            axis[start : start + 300] = axis[start]
    assert abs(found_in(columns).share - 0.1495) < 0.005


def test_an_axis_that_keeps_a_value_is_told_from_one_in_coarse_counts():
    known = np.ones(20_000, bool)
    for seed in range(4):
        for per_noise in (0.2, 0.35, 1.0, 5.0, 300.0):
            for decay in (0.0, 0.9):
                columns = of_axes(seed, per_noise, decay)
                assert not repeats.held(columns, AXES[0], known).any()
        columns, true = of_axes(seed, 5.0), np.zeros(20_000, bool)
        for start in range(50, 20_000, 200):
            columns[AXES[0]][start : start + 12] = columns[AXES[0]][start]
            true[start + 1 : start + 12] = True
        found = repeats.held(columns, AXES[0], known)
        assert found[true].mean() == 1
        assert found[~true].mean() < 0.001  # the next sample may be equal by chance
        assert not repeats.held(columns, AXES[1], known).any()


def test_small_rates_that_are_one_value_are_a_dead_zone_and_noise_in_counts_is_none():
    for seed in range(5):
        noise = np.random.default_rng(seed).standard_normal(20_000)
        known = np.ones(len(noise), bool)

        def seen(x, known=known):
            return observations.dead(lab_bench.of_gyro(x, RATE), x, known)

        found = seen(np.round(np.where(np.abs(noise) < 0.4, 0, 0.05 * noise), 3))
        assert abs(found.share - 0.31) <= 0.02
        assert found.spoils
        for per_noise in (0.3, 1, 3, 6, 30, 1e4):
            assert seen(np.round(noise * per_noise) * 0.01) is None
        turned = 400 * np.sin(np.arange(20_000) / 3e3) ** 9  # counts, after a rest
        zone = np.round(5 * noise + turned)
        assert seen(np.where(np.abs(zone) < 9, 0, zone) * 0.061) is not None
        for per_noise in (0.25, 0.4, 0.8):
            assert seen(np.round(noise * per_noise + turned) * 0.061) is None
