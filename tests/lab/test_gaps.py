"""Missing samples against formulas of this file."""

import lab_bench
import numpy as np
import pytest
from davarlab.data import recording
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve
from davarlab.inference import allan, estimate, gaps, images
from davarlab.inference.parts import Bench, Part
from scipy import fft, linalg

RATE, N_DEG, B_DEG = 50.0, 0.3, 6.0


def losses(count, rng):
    return {
        "3 %": rng.random(count) > 0.03,
        "50 %": rng.random(count) > 0.5,
        "bursts": np.arange(count) % 900 < 450,
    }


def test_mean_and_covariance_are_those_of_the_joint_density():
    rng, count = np.random.default_rng(1), 24
    level = 0.5 + 3.0 / np.arange(1, count)
    waves = fft.idct(np.eye(count), norm="ortho", axis=0)
    covariance = waves @ np.diag(np.concatenate([[level[0]], level])) @ waves.T
    y = linalg.cholesky(covariance, lower=True) @ rng.standard_normal(count)
    known = rng.random(count) > 0.4
    m, o = np.flatnonzero(~known), np.flatnonzero(known)
    pull = covariance[np.ix_(m, o)] @ linalg.inv(covariance[np.ix_(o, o)])
    mean = y[o].mean() + pull @ (y[o] - y[o].mean())
    left = covariance[np.ix_(m, m)] - pull @ covariance[np.ix_(o, m)]
    drawn = np.array(
        [gaps.conditional_draw(np.where(known, y, 0), known, level, rng)[m] for _ in range(6000)]
    )
    np.testing.assert_allclose(drawn.mean(axis=0), mean, atol=5 * np.sqrt(left.max() / 6000))
    np.testing.assert_allclose(np.cov(drawn.T), left, atol=6 * left.max() / np.sqrt(6000))


def test_known_samples_are_left_alone_and_the_spectrum_is_unbiased():
    rng, count = np.random.default_rng(2), 60000
    f = np.arange(1, count) * RATE / 2 / count
    level = ((N_DEG / 60) ** 2 + (B_DEG / 3600) ** 2 / (2 * np.pi * f)) * RATE
    level /= 1 + (f / 8) ** 2
    y0 = fft.idct(
        np.concatenate([[0], np.sqrt(level) * rng.standard_normal(count - 1)]), norm="ortho"
    )
    for name, known in losses(count, rng).items():
        y = gaps.conditional_draw(np.where(known, y0, 0), known, level, rng)
        np.testing.assert_array_equal(y[known], y0[known])
        ratio = fft.dct(y, norm="ortho")[1:] ** 2 / level
        for band in np.array_split(ratio, 10):
            assert abs(band.mean() - 1) <= 5 * np.sqrt(2 / len(band)), name


def drawn_again(y, known, level, rng):
    """What is fitted to a record whose missing samples are drawn, and drawn again by the fit."""
    parts = [Part("angle_random_walk"), Part("bias_instability")]
    for _ in range(3):
        y = gaps.conditional_draw(y, known, level, rng)
        bench = Bench(Recording({"gyro_z_dps": y}, RATE), y)
        found, f = bench.fit(parts), np.log(bench.data.f)
        level = np.exp(np.interp(f, np.log(bench.data.f_bin), np.log(found.level)))
    n, b = estimate.all_estimates(bench, parts, found)
    return n["coefficient_deg_per_sqrt_h"], b["coefficient_deg_per_h"]


def test_noise_and_bias_instability_are_within_their_intervals():
    inside, tries = 0, 0
    for seed in range(4):
        rng = np.random.default_rng([3, seed])
        y0 = lab_bench.noise(60000, RATE, rng, N_DEG, B_DEG)
        for known in losses(len(y0), rng).values():
            y = np.where(known, y0, 0)
            n, b = drawn_again(y, known, gaps.first_level(y, known), rng)
            inside += (n.low <= N_DEG <= n.high) + (b.low <= B_DEG <= b.high)
            tries += 2
            assert abs(n.value - N_DEG) <= 0.015 * N_DEG
    assert inside >= tries - 6  # 95 %; where half is lost the draw's own scatter comes on top


def blocks(rng, seconds=60.0, rate=968.0, length=4, every_s=0.0248):
    """Places on the grid of a FIFO that is read too late: a quarter of the blocks comes late."""
    start = np.arange(int(seconds / every_s)) * every_s * rate
    start += length * (rng.random(len(start)) < 0.25)
    return np.round(start[:, None] + np.arange(length)).astype(int).ravel()


# Samples in regular blocks show a line at other frequencies too.


SIGMA = 0.02  # deg/s a sample


def filled(seed, *lines):
    """(record with zeros where it is missing, known, the lines everywhere); lines: (amplitude,
    Hz) at 968 Hz."""
    rng = np.random.default_rng(seed)
    at = blocks(rng)
    known = np.zeros(at[-1] + 1, bool)
    known[at] = True
    turns = 2 * np.pi * np.arange(len(known)) / 968
    true = sum((a * np.sin(f * turns + rng.uniform(0, 6)) for a, f in lines), np.zeros(len(known)))
    y = true + SIGMA * rng.standard_normal(len(known)) + 0.3
    return np.where(known, y, 0.0), known, true


def test_lines_go_on_through_the_gaps_and_their_images_do_not():
    for seed in range(11, 15):
        for lines in (((0.012, 49.2),), ((0.02, 171.3), (0.01, 12.7))):
            y, known, true = filled(seed, *lines)
            off = images.lines(y, known) - true
            assert off.std() < 0.1 * true.std(), (seed, lines)


def test_noise_alone_or_slow_noise_shows_no_line():
    assert sum(images.lines(*filled(seed)[:2]).any() for seed in range(20, 40)) <= 1
    for seed in range(40, 50):  # batches, with much longer pauses
        known = np.arange(120_000) % 4000 < 1024
        y = known * np.random.default_rng(seed).normal(0.3, 1.0, len(known))
        assert not images.lines(y, known).any(), seed
    for seed in range(40, 43):
        y, known, _ = filled(seed)
        walk = np.cumsum(np.random.default_rng(seed).standard_normal(len(y)))
        for size in (0.001, 0.01):
            assert not images.lines(y + size * walk * known, known).any(), seed


def test_images_are_at_multiples_of_the_block_rate_and_random_or_single_gaps_have_none():
    shifts = images.shifts(filled(1)[1]) * 968
    np.testing.assert_allclose(shifts, np.arange(1, len(shifts) + 1) / 0.0248, rtol=1e-3)
    near = images.of_line(49.2 / 968, shifts / 968) * 968
    for f in (49.2 - 40.32, 49.2 + 40.32):
        assert np.abs(near - f).min() < 0.1
    at_random = np.random.default_rng(3).random(60000) > 0.4
    for known in (at_random, np.abs(np.arange(60000) - 30000) > 9000, None):
        assert len(images.shifts(known)) == 0


@pytest.mark.slow
def test_a_diagnosis_names_the_line_and_nothing_else():
    model = lab_bench.model(968.0, 0.04, 1.0, "gyro_x_dps")
    true, company = 60 * SIGMA / np.sqrt(968), 0
    for seed, f in zip(range(51, 57), (49.2, 133.7, 12.9, 300.1, 89.5, 221.4)):
        y, known, _ = filled(seed, (0.012, f))
        columns = {"time_s": np.flatnonzero(known) / 968, "gyro_x_dps": y[known]}
        found = improve.improve(recording.of_columns(columns, None, "r.csv", {}, 1), model)
        named = [one["frequency_hz"].value for one in found.estimates if "frequency_hz" in one]
        assert len(named) == 1, (seed, found.added, found.diagnosis.doubtful)
        assert abs(named[0] - f) <= 0.05
        arw = found.estimates[0]["coefficient_deg_per_sqrt_h"]
        assert abs(arw.value - true) <= 0.04 * true
        company += found.added != ["sinusoid"]
    assert company <= 1  # by chance, rarely


def test_only_known_samples_count():
    rng, window, taus = np.random.default_rng(4), 600, [1, 4, 16]
    y, known = rng.standard_normal(1800) + 5, rng.random(1800) > 0.01
    known[600:900] = False
    found, share = allan.windows(np.where(known, y, 99), window, taus, known)
    for row, (part, there) in enumerate(zip(y.reshape(3, -1), known.reshape(3, -1))):
        for column, m in enumerate(taus):
            square = [
                (part[i + m : i + 2 * m].mean() - part[i : i + m].mean()) ** 2
                for i in range(window - 2 * m + 1)
                if there[i : i + 2 * m].all()
            ]
            assert abs(share[row, column] - len(square) / (window - 2 * m + 1)) < 5e-8
            assert abs(found[row, column] - np.sqrt(np.mean(square) / 2)) < 5e-8


def test_without_a_gap_it_is_what_the_library_says():
    y = np.random.default_rng(5).standard_normal(4000)
    found, share = allan.windows(y, 1000, [1, 8, 64], np.ones(4000, bool))
    np.testing.assert_allclose(
        allan.masked(y, 1000, [1, 8, 64], np.ones(4000, bool))[0], found, rtol=1e-5
    )
    assert share.min() == 1
