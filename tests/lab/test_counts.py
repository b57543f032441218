"""Rates and angles in counts, rounded by formulas of this file."""

import lab_bench
import numpy as np
import pytest
from davarlab.data import counts
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve

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
    y = np.array([float(f"{value:.6f}") for value in y])
    return improve.improve(Recording({"gyro_z_dps": y}, RATE), MODEL)


def test_the_count_is_found_whatever_was_done_to_the_values():
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


def test_values_without_a_grid_have_no_count():
    x = np.random.default_rng(2).normal(size=50000)
    for y in (
        x,
        np.round(x, 6),
        np.round(x) + 0.5 * np.arange(len(x)) / len(x),
        x[:1000],
        np.zeros(1000),
    ):
        assert counts.step(y) in (0.0, counts.step(y) if counts.step(y) < 1e-4 else 0.0)


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
        found = counts.of(np.round(bias + sigma * rng.normal(size=100000)) * 0.01, RATE)
        assert found.of == "rate"
        assert abs(found.sigma_counts / sigma - 1) <= 0.025


def test_a_moving_bias_explains_why_the_noise_changes():
    rng = np.random.default_rng(5)
    y = np.round(np.linspace(0, 2, 200000) + 0.3 * rng.normal(size=200000))
    slope, error, before, after = counts.explained(y, counts.of(y, RATE), 100)
    assert abs(slope - 1) <= max(3 * error, 0.03)
    assert before > 3 * after
    assert after < 1.4


@pytest.mark.slow
def test_nothing_is_missing():
    for seed, sigma in enumerate((0.25, 0.3, 0.4, 0.6, 1.0)):
        rng = np.random.default_rng([6, seed])
        drift = np.linspace(0, 0.7, 120000) * SIGMA / sigma  # through most of a count
        y = rate_in_counts(gyro(120000, rng), SIGMA / sigma)
        found = improved(y)
        assert (found.diagnosis.added, found.verdict) == ([], "none"), sigma
        assert abs(np.sqrt(found.diagnosis.states[0].fit.sizes[0]) * 60 / N - 1) <= 0.03
        named = improved(rate_in_counts(gyro(120000, rng) + drift, SIGMA / sigma)).diagnosis.added
        assert not set(named) & {
            "noise_step",
            "shocks",
            "low_pass",
            "quantization",
            "gauss_markov",
        }, (sigma, named)


def test_the_error_spectrum_is_that_of_a_rounded_walk():
    rng = np.random.default_rng(7)
    for sigma, mean in ((0.1, 0.37), (0.2, 0.13), (0.3, 0.013), (0.5, 0.2)):
        angle = np.cumsum(mean + sigma * rng.normal(size=400000))
        error = np.round(angle) - angle
        drawn = (
            np.abs(np.fft.rfft(error * np.hanning(len(error)))) ** 2
            / np.sum(np.hanning(len(error)) ** 2)
        )[1:]
        increments = np.zeros(counts.LAGS + 1)
        increments[0] = sigma**2
        known = counts.error_spectrum(increments, np.array([mean]))
        nu = np.arange(1, len(drawn) + 1) / len(error)
        ratio = [
            drawn[part].mean() / np.interp(nu[part], np.linspace(0, 0.5, len(known)), known).mean()
            for part in np.array_split(np.arange(len(nu)), 20)
        ]
        np.testing.assert_allclose(ratio, 1, atol=0.06)


@pytest.mark.slow
def test_it_is_quantization_and_nothing_else():
    wrong = []
    for seed, sigma in enumerate((0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.5, 0.7, 1.0, 1.5)):
        found = improved(
            angle_in_counts(gyro(100000, np.random.default_rng([8, seed])), SIGMA / sigma)
        )
        size = np.sqrt(found.diagnosis.states[-1].fit.sizes[0]) * 60 / N
        right = (
            found.verdict == "quantization"
            and found.diagnosis.added == ["quantization"]
            and abs(size - 1) < 0.02
        )
        if not right or found.last.error > 1.25 * found.last.error_floor:
            wrong.append((sigma, found.verdict, found.diagnosis.added, size))
    assert len(wrong) <= 1, wrong
