"""Fits and their 95 % intervals against theory that is not in davarlab: exact Poisson limits, the
chi-square law of a variance, ordinary least squares, Cramér and Rao.
"""

from types import SimpleNamespace

import lab_bench
import numpy as np
import pytest
from davarlab.data.recording import Recording
from davarlab.inference import changes, estimate, modulation, whittle
from davarlab.inference.estimate import Estimate
from davarlab.inference.parts import Bench, Part
from davarlab.inference.whittle import Data
from scipy import fft, optimize, stats

RATE = 50.0
WHITE = Part("angle_random_walk")
N = "coefficient_deg_per_sqrt_h"


def benched(y, **columns):
    return Bench(Recording({"gyro_z_dps": y, **columns}, RATE), y)


def fitted(y, *parts, restricted=True, **columns):
    bench, parts = benched(y, **columns), [WHITE, *parts]
    fit = bench.fit(parts, restricted=restricted)
    return bench, parts, fit, estimate.all_estimates(bench, parts, fit)


def white(seed, count, sigma=0.035):
    return sigma * np.random.default_rng(seed).standard_normal(count)


def reach(one):
    return (one.high - one.low) / 2


@pytest.mark.parametrize("count", [1, 2, 5, 17, 200])
@pytest.mark.parametrize("hours", [0.5, 1.0, 7.0])
def test_the_rate_of_shocks_has_the_exact_limits_of_a_poisson_count(count, hours):
    """Garwood (1936): each limit is the rate at which a count as extreme has a chance of 2.5 %."""
    shocks = SimpleNamespace(count=count, amplitude_dps=0.5, error_dps=0.02)
    made = SimpleNamespace(samples=int(hours * 3600 * RATE), rate_hz=RATE)
    found = estimate.shock_estimates(shocks, made)
    rate, size = found["rate_per_hour"], found["amplitude_dps"]
    assert rate.value == pytest.approx(count / hours)
    assert rate.low == pytest.approx(stats.chi2.ppf(0.025, 2 * count) / 2 / hours)
    assert rate.high == pytest.approx(stats.chi2.ppf(0.975, 2 * count + 2) / 2 / hours)
    assert stats.poisson.cdf(count, rate.high * hours) == pytest.approx(0.025)
    assert stats.poisson.sf(count - 1, rate.low * hours) == pytest.approx(0.025)
    assert (size.low, size.high) == pytest.approx((0.4608, 0.5392))


def test_white_noise_is_as_uncertain_as_a_standard_deviation_is():
    """Of n normal values: relative standard error 1 / sqrt(2 n). A size that is fitted as nothing
    is bounded by 1.96 of its error.
    """
    count = 20_000
    y = white(1, count)
    bench, parts, fit, found = fitted(y)
    one, error = found[0][N], stats.norm.ppf(0.975) / np.sqrt(2 * count)
    assert one.value == pytest.approx(60 * y.std(ddof=1) / RATE**0.5, rel=1e-3)
    assert np.log(one.high / one.value) == pytest.approx(error, rel=0.01)
    assert np.log(one.value / one.low) == pytest.approx(error, rel=0.01)
    covariance = whittle.size_covariance(bench.data, bench.rows(parts), fit.level)
    assert covariance[0, 0] / fit.sizes[0] ** 2 == pytest.approx(2 / (count - 1), rel=0.01)
    nothing = estimate.spectrum_estimate(0.5, 0.0, np.inf, 4e-4)
    assert (nothing.value, nothing.low) == (0.0, 0.0)
    assert nothing.high == pytest.approx(2 * np.sqrt(stats.norm.ppf(0.975) * 4e-4))
    some = estimate.spectrum_estimate(0.5, 0.09, 0.2, np.nan)
    assert (some.value, some.high) == pytest.approx((0.6, 0.6 * np.exp(1.96 * 0.1)), rel=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_coefficient_of_a_column_is_that_of_least_squares(seed):
    rng, count = np.random.default_rng(seed), 6000
    slow = np.cumsum(rng.standard_normal(count))
    warm = 25 + slow / np.abs(slow).max()
    y = 0.03 * (warm - 25) + 0.05 * rng.standard_normal(count)
    found = fitted(y, Part("temperature", {"lag_s": 0.0}), temp_degC=warm)[3]
    one = found[1]["coefficient_dps_per_degC"]
    plain = stats.linregress(warm, y)
    assert one.value == pytest.approx(plain.slope, abs=0.3 * plain.stderr)
    assert reach(one) == pytest.approx(1.96 * plain.stderr, rel=0.05)
    assert one.high - one.value == pytest.approx(one.value - one.low)


def line_bound(size, sigma, count):
    """Of Cramér and Rao, in Hz."""
    return np.sqrt(6 / count) * sigma / (np.pi * size * count / RATE)


def test_a_line_and_a_visit_have_the_errors_of_cramer_and_rao():
    count, size, f, sigma = 20_000, 0.01, 3.2, 0.035
    t = np.arange(count) / RATE
    y = white(9, count) + size * np.sin(2 * np.pi * f * t + 1)
    found = fitted(y, Part("sinusoid", {"frequency_hz": f}))[3][1]
    off = sigma * (2 / count) ** 0.5
    assert found["amplitude_dps"].value == pytest.approx(size, abs=3 * off)
    # wider, up to twice: the phase at the start of the record is correlated with the frequency
    assert 0.9 < reach(found["amplitude_dps"]) / (1.96 * off) < 2.1
    bound = 1.96 * line_bound(size, sigma, count)
    assert reach(found["frequency_hz"]) == pytest.approx(bound, rel=0.1)

    t = np.arange(2 * count) / RATE
    y = white(3, 2 * count) + ((t >= 200) & (t < 500)) * 0.03 * np.sin(2 * np.pi * 7.0 * t)
    shape = {"frequency_hz": 7.0, "start_s": 200.0, "stop_s": 500.0}
    found = fitted(y, Part("intermittent_line", shape))[3][1]
    bound = 1.96 * line_bound(0.03, sigma, 300 * RATE)
    assert reach(found["frequency_hz"]) == pytest.approx(bound, rel=0.1)
    assert found["start_s"].low < 200 < found["start_s"].high
    assert 0.2 < reach(found["start_s"]) < 5


def test_what_columns_take_is_taken_off_the_degrees_of_freedom():
    """An unbiased variance divides by n - k (REML); the likelihood alone by n."""
    count, lines = 1000, 60
    parts = [Part("sinusoid", {"frequency_hz": 0.4 * (k + 1)}) for k in range(lines)]
    bench = benched(white(4, count))
    free, plain = (bench.fit([WHITE, *parts], restricted=one).sizes[0] for one in (True, False))
    assert free / plain == pytest.approx((count - 1) / (count - 1 - 2 * lines), rel=0.01)


@pytest.mark.parametrize("count", [2, 5, 9, 15])
def test_sizes_fit_at_least_as_well_as_by_the_general_method(count):
    rng, f = np.random.default_rng(count), np.linspace(0.01, 1, 400)
    for _ in range(20):
        middle, width = rng.uniform(0, 1, (count, 1)), rng.uniform(0.01, 0.5, (count, 1))
        shapes = 1 / (1 + ((f - middle) / width) ** 2)
        wanted = shapes[: (count + 1) // 2].sum(axis=0) * rng.chisquare(10, len(f)) / 10
        wanted -= 0.3 * shapes[-1]  # one of them wants to be negative
        weight = rng.uniform(1, 5, len(f))
        sizes = whittle.non_negative_step(shapes, wanted, weight)
        general = optimize.nnls(shapes.T * np.sqrt(weight)[:, None], wanted * np.sqrt(weight))[1]
        assert sizes.min() >= 0
        assert weight @ (wanted - sizes @ shapes) ** 2 <= general**2 * (1 + 1e-9)


def test_a_score_of_a_column_is_what_the_fit_gains():
    rng, count = np.random.default_rng(5), 8000
    x = np.cumsum(rng.standard_normal(count))
    data = Data(0.035 * rng.standard_normal(count) + 1e-3 * x / x.std(), RATE)
    data.add("x", x)
    level = np.full(len(data.counts), 0.035**2)
    score = whittle.score_of_column(data, [], level, "x")
    before = whittle.log_likelihood(data, data.product("gyro", "gyro"), level)
    beta, inverse, residual = whittle.generalised_least_squares(data, ["x"], level)
    assert score == pytest.approx(whittle.log_likelihood(data, residual, level) - before)
    assert score == pytest.approx(0.5 * beta[0] ** 2 / inverse[0, 0])


def test_a_score_of_a_row_is_what_the_fit_gains_to_second_order():
    flicker = lab_bench.flicker(8000, 20 / 3600, np.random.default_rng(5), 2)
    bench, parts = benched(white(5, 8000) + flicker), [WHITE, Part("bias_instability")]
    before, after = bench.fit(parts[:1]), bench.fit(parts)
    rows, gyro = bench.rows(parts), bench.data.product("gyro", "gyro")
    score = whittle.score_of_row(bench.data, rows[:1], gyro, before.level, rows[1])
    gain = after.log_likelihood - before.log_likelihood
    assert 5 < gain < score < 40 * gain


def test_the_likelihood_is_that_of_independent_normal_ordinates():
    y = white(6, 500)
    bench = benched(y)
    fit = bench.fit([WHITE])
    c = fft.dct(y - y.mean(), norm="ortho")[1:]
    exact = stats.norm.logpdf(c, 0, np.sqrt(fit.sizes[0] * RATE)).sum()
    assert fit.log_likelihood - 0.5 * len(c) * np.log(2 * np.pi) == pytest.approx(exact)
    again = estimate.vector_likelihood(bench, [WHITE], fit.sizes, fit.coefficients)
    assert again == pytest.approx(fit.log_likelihood)


def test_minus_the_hessian():
    matrix = np.array([[3.0, 1.0, 0.5], [1.0, 2.0, -0.3], [0.5, -0.3, 1.0]])
    found = estimate.curvature(lambda x: 7 - 0.5 * x @ matrix @ x, np.array([0.1, 0.2, 0.05]))
    np.testing.assert_allclose(found, matrix, atol=1e-9)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.04])
def test_samples_that_were_drawn_say_nothing(share):
    """The interval is that of n share samples: wider by 1 / sqrt(share)."""
    times = 1 / np.sqrt(share)
    one = estimate.of_share(Estimate(2.0, 1.8, 2.0 * 2.0 / 1.8), share)
    assert np.log(one.high / 2.0) == pytest.approx(times * np.log(2.0 / 1.8))
    assert np.log(2.0 / one.low) == pytest.approx(times * np.log(2.0 / 1.8))
    even = estimate.of_share(Estimate(1.0, -1.0, 3.0), share)
    assert (even.low, even.high) == pytest.approx((1 - 2 * times, 1 + 2 * times))
    assert estimate.of_share(Estimate(1.0), share) == Estimate(1.0)


def test_intervals_of_errors_and_of_what_is_not_known():
    z = stats.norm.ppf(0.975)
    even, relative = estimate.interval(2.0, 0.1, False), estimate.interval(-2.0, 0.1, True)
    assert (even.low, even.high) == pytest.approx((2 - 0.1 * z, 2 + 0.1 * z))
    ends = -2 * np.exp(0.1 * z), -2 * np.exp(-0.1 * z)
    assert (relative.low, relative.high) == pytest.approx(ends)
    for value, error, as_ratio in ((1.0, np.inf, False), (1.0, 0.0, False), (1.0, 9.0, True)):
        assert estimate.interval(value, error, as_ratio).undetermined
    assert not estimate.interval(1.0, 9.0, False).undetermined
    wide = estimate.widened(Estimate(1.0, 0.9, 1.2), Estimate(1.1, 0.8, 1.15))
    assert wide == Estimate(1.0, 0.8, 1.2)


def test_levels_whose_mean_shrinks_them():
    """sum(y m) / (n square), for the sum(y m) / sum(m^2) of least squares."""
    course = np.array([0.5, -0.5, 1.0, -1.0])
    found = estimate.of_levels(Estimate(0.8, 0.4, 1.2), course, 1.0)
    assert (found.value, found.low, found.high) == pytest.approx((0.5, 0.25, 0.75))


def test_noise_that_has_grown_for_a_while():
    """The ratio of two standard deviations of n1 and n2 normal values."""
    count, shape = 40_000, {"start_s": 200.0, "stop_s": 500.0}
    t = np.arange(count) / RATE
    on = (t >= 200) & (t < 500)
    found = fitted(np.where(on, 1.5, 1.0) * white(7, count), Part("noise_step", shape))[3]
    ratio, quiet = found[1]["ratio"], found[0][N]
    error = 1.96 * np.sqrt(0.5 / on.sum() + 0.5 / (~on).sum())
    assert ratio.value == pytest.approx(1.5, rel=1.5 * error)
    assert error < np.log(ratio.high / ratio.value) < 1.6 * error
    for one, true in ((quiet, 60 * 0.035 / RATE**0.5), *((found[1][k], shape[k]) for k in shape)):
        assert one.low < true < one.high


def test_energies_of_blocks_are_fitted_as_a_brute_search_finds():
    rng = np.random.default_rng(8)
    shapes = np.array([np.ones(400), np.linspace(0, 2, 400)])
    variance = np.array([1.0, 0.7]) @ shapes
    blocks = changes.Blocks(variance * rng.chisquare(50, 400) / 50, 50, 1.0, 50.0)
    sizes, _, likelihood = changes.fit(blocks, shapes)
    around = max(
        -25 * np.sum(np.log(v) + blocks.energy / v)
        for a in sizes[0] * np.linspace(0.97, 1.03, 31)
        for b in sizes[1] * np.linspace(0.9, 1.1, 31)
        for v in [a * shapes[0] + b * shapes[1]]
    )
    assert likelihood >= around - 1e-3
    errors = np.sqrt(np.diag(changes.size_covariance(blocks, shapes, variance)))
    assert (np.abs(sizes - [1.0, 0.7]) < 4 * errors).all()
    draws = rng.chisquare(50, (60, 400)) / 50
    drawn = [changes.fit(changes.Blocks(variance * d, 50, 1.0, 50.0), shapes)[0] for d in draws]
    np.testing.assert_allclose(np.std(drawn, axis=0) / errors, 1, atol=0.35)


def test_the_share_of_white_noise_in_a_spectrum():
    y = lab_bench.noise(20_000, RATE, np.random.default_rng(10), b=60.0)
    bench, parts, fit, _ = fitted(y, Part("bias_instability"), restricted=False)
    share = modulation.white_share(bench, parts, fit)
    expected = fit.sizes[0] * RATE / fit.level
    np.testing.assert_allclose(share, expected, rtol=1e-6)


def test_the_ends_of_a_growth_are_known_to_three_nats():
    """Half a block, and blocks on the wrong side up to a likelihood of exp(-3)."""
    part = Part("noise_step", {"start_s": 100.0, "stop_s": 300.0})
    blocks = changes.Blocks(np.ones(400), 50, 1.0, 50.0)
    nats = 25 * (1.5**2 - 1) - 50 * np.log(1.5)  # of 50 normal values with the wrong variance
    found = estimate.ends([part], blocks, 1.5)
    assert reach(found["start_s"]) == pytest.approx(0.5 + 3 / nats)
    assert found["stop_s"].high == pytest.approx(300.5 + 3 / nats)


def test_white_noise_that_grows_beside_flicker_keeps_its_level():
    rng, count = np.random.default_rng(12), 60_000
    t = np.arange(count) / RATE
    white = 0.3 / 60 * RATE**0.5 * rng.standard_normal(count)
    slow = lab_bench.flicker(count, 150 / 3600, rng, 2)
    y = white * np.where((t >= 300) & (t < 800), 1.6, 1.0) + slow
    parts = [Part("bias_instability"), Part("noise_step", {"start_s": 300.0, "stop_s": 800.0})]
    found = fitted(y, *parts)[3]
    assert found[0][N].value == pytest.approx(0.3, rel=0.05)
    assert found[2]["ratio"].value == pytest.approx(1.6, rel=0.05)


@pytest.mark.parametrize(
    "kind, entry, absent",
    [
        ("bias_instability", {"coefficient_deg_per_h": Estimate(0.0, 0.0, 1.2)}, True),
        ("bias_instability", {"coefficient_deg_per_h": Estimate(5.0, 4.0, 6.0)}, False),
        ("noise_step", {"ratio": Estimate(1.00, 0.98, 1.03)}, True),
        ("noise_step", {"ratio": Estimate(0.90, 0.85, 0.95)}, False),
        ("temperature", {"coefficient_dps_per_degC": Estimate(-0.01, -0.03, 0.01)}, True),
        ("temperature", {"coefficient_dps_per_degC": Estimate(-0.02, -0.03, -0.01)}, False),
        ("temperature_noise", {"relative_per_degC": Estimate(0.001, -0.001, 0.003)}, True),
        (
            "temperature_noise",
            {
                "relative_per_degC": Estimate(0.001, -0.001, 0.003),
                "curvature_per_degC2": Estimate(-0.02, -0.03, -0.01),
            },
            False,
        ),
        ("sinusoid", {"amplitude_dps": Estimate(0.0, undetermined=True)}, True),
        ("low_pass", {"cutoff_hz": Estimate(8.0, 7.0, 9.0)}, False),
        ("bias_instability", {"coefficient_deg_per_h": Estimate(5.0)}, False),  # as set
    ],
)
def test_an_effect_may_be_absent_when_its_interval_says_so(kind, entry, absent):
    assert estimate.superfluous(kind, entry) == absent
