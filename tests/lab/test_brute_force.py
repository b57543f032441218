"""What of davarlab is small enough to be checked against brute force."""

import itertools
from ctypes import util
from dataclasses import replace
from unittest import mock

import lab_bench
import numpy as np
import pytest
from davarlab import arrays, model, simulate
from davarlab.candidates import candidate
from davarlab.candidates import ranking as candidates
from davarlab.data import events, signals
from davarlab.data.recording import Recording
from davarlab.diagnosis import diagnose, fitting, improve
from davarlab.effects import device
from davarlab.effects.device import chain_of_levels
from davarlab.errors import BadInput
from davarlab.inference import allan, estimate, refine, states, whittle
from davarlab.inference.parts import Bench, Part
from davarlab.thresholds import EVENTS
from elsewhere import telegraph
from scipy import optimize, signal, stats

RATE = 50.0
WHITE = np.zeros((0, 2))  # no slow noise


def every_course(count, stay, levels):
    """(course, its chance) of all courses of a chain of levels 2 apart."""
    for course in itertools.product(range(levels - 1, -levels, -2), repeat=count):
        steps = [stay if a == b else (1 - stay) / (levels - 1) for a, b in zip(course, course[1:])]
        yield np.array(course), np.prod(steps) / levels


def every_path(values, level, noise, stay, levels):
    """(path, joint density) of all paths of a chain of levels 2 apart in white noise."""
    for path, chance in every_course(len(values), stay, levels):
        yield path, chance * np.prod(stats.norm.pdf(values, level * path, noise))


@pytest.mark.parametrize("levels, count", [(2, 9), (3, 7)])
def test_levels_as_the_sum_over_all_paths(levels, count):
    values = np.random.default_rng(3).normal(size=count)
    for level, noise, stay in ((0.8, 1.0, 0.9), (3.0, 0.2, 0.6), (0.1, 2.0, 0.999)):
        paths = list(every_path(values, level, noise, stay, levels))
        whole = sum(density for _, density in paths)
        given = values, WHITE, noise**2, (level, 1 - stay), levels
        likelihood, chance = chain_of_levels(*given, posterior=True)
        state = states.places(levels) @ chance
        assert abs(likelihood - np.log(whole)) < 5e-8
        mean = sum(path * density for path, density in paths) / whole
        np.testing.assert_allclose(state, mean, atol=1e-9)
        assert chain_of_levels(*given)[0] == likelihood


def test_a_level_that_no_path_can_reach_is_no_path():
    """Without a switch, the record stays on the one level that its first values have."""
    values = np.array([100.0, 100.0, 100.0, -100.0, -100.0])
    found = chain_of_levels(values, WHITE, 1.0, (100.0, 0.0), 2)[0]
    assert found == pytest.approx(np.log(0.5) + stats.norm.logpdf(values - 100.0).sum())


@pytest.mark.parametrize("levels, processes", [(9, 0), (0, 0), (2, 21)])
def test_more_levels_or_processes_than_there_is_room_for_are_refused(levels, processes):
    slow = np.tile([0.9, 1.0], (processes, 1))
    with pytest.raises(MemoryError):
        chain_of_levels(np.zeros(5), slow, 1.0, (1.0, 0.1), levels, posterior=True)


def test_a_library_built_from_other_sources_is_refused(monkeypatch):
    """Its functions would read and write through the wrong pointers."""
    monkeypatch.setenv("DAVAR_LAB_LIBRARY", util.find_library("m"))
    with pytest.raises(BadInput, match="run tools/davarlab"):
        device.library.__wrapped__()


@pytest.mark.parametrize("levels, count", [(2, 10), (3, 7)])
def test_levels_beside_slow_noise_as_the_sum_over_all_paths(levels, count):
    """Paths whose last switch is at the same value between the same levels are one, with the mean
    of their slow noise: nearly the sum.
    """
    slow = np.array([[0.95, 0.5], [0.6, 0.2], [1.0, 4.0]])
    lags = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    covariance = 0.3**2 * np.eye(count) + sum(size * decay**lags for decay, size in slow)
    noise = stats.multivariate_normal(np.zeros(count), covariance)
    rng = np.random.default_rng(7)
    for level, stay in ((1.0, 0.9), (3.0, 0.6), (0.3, 0.97)):
        moves = np.where(rng.random(count) > stay, rng.integers(1, levels, count), 0)
        path = level * states.places(levels)[np.cumsum(moves) % levels]
        values = path + noise.rvs(random_state=rng)
        whole = np.log(
            sum(
                noise.pdf(values - level * one) * chance
                for one, chance in every_course(count, stay, levels)
            )
        )
        found = chain_of_levels(values, slow, 0.3**2, (level, 1 - stay), levels)[0]
        assert abs(found - whole) < 0.01, (level, found, whole)


def test_the_mean_dwell_says_how_likely_a_level_stays():
    rng = np.random.default_rng(2)
    for levels in (2, 3, 4):
        level = telegraph(levels, 0.5, 0.4, rng, 100_000)
        same = np.mean(level[:-10] == level[10:])
        assert abs(states.staying(10 / RATE, 0.4, levels) - same) <= 0.01


def test_the_simulator_makes_three_levels():
    values = {"amplitude_dps": 0.01, "mean_dwell_s": 2.0, "levels": 3}
    terms = [model.checked_term({"kind": "telegraph_noise", **values}, "here")]
    y = simulate.make(terms, RATE, duration_s=2000.0).columns["gyro_z_dps"]
    levels = np.unique(np.round(y - y.min(), 9))
    np.testing.assert_allclose(levels, [0, 0.02, 0.04], atol=1e-9)
    assert abs(2000 / np.sum(np.diff(y) != 0) - 2.0) <= 0.25


def at_random(rng):
    levels, count = int(rng.integers(2, 6)), int(rng.integers(6, 400))
    places = levels - 1 - 2 * (np.cumsum(rng.integers(1, levels, count)) % levels)
    return places, rng.exponential(300, count), levels


def switched_evenly(rng):
    count, duty = int(rng.integers(60, 200)), rng.uniform(0.1, 0.5)
    share = np.where(np.arange(count) % 2, duty, 1 - duty)
    dwells = 500 * share * (1 + rng.uniform(0.1, 0.3) * rng.uniform(-1, 1, count))
    return 1 - 2 * (np.arange(count) % 2), dwells, 2


def sawtooth(rng):
    """Teeth of random length: only the order tells."""
    levels = int(rng.integers(3, 6))
    dwells = np.repeat(300 * rng.exponential(1, 200), levels)
    return np.tile(np.arange(levels - 1, -levels, -2), 200), dwells, levels


@pytest.mark.parametrize(
    "drawn, chance", [(at_random, True), (switched_evenly, False), (sawtooth, False)]
)
def test_levels_at_random_are_telegraph_noise_and_an_order_is_not(drawn, chance):
    for seed in range(40):
        places, dwells, levels = drawn(np.random.default_rng([6, seed]))
        path = np.repeat(places, np.maximum(1, np.round(dwells).astype(int))).astype(float)
        assert states.like_chance(path, levels) == chance, seed


def test_a_continuum_as_the_joint_density():
    values = np.random.default_rng(4).normal(size=300)
    for std, noise, decay in ((0.7, 1.0, 0.95), (2.0, 0.1, 0.5)):
        lags = np.abs(np.subtract.outer(np.arange(300), np.arange(300)))
        covariance = std**2 * decay**lags + noise**2 * np.eye(300)
        exact = stats.multivariate_normal.logpdf(values, np.zeros(300), covariance)
        found = chain_of_levels(values, np.array([[decay, std**2]]), noise**2, (0.0, 0.0), 1)[0]
        assert abs(found - exact) < 5e-6


def test_a_dwell_longer_than_the_record_is_no_fault():
    noise = states.Noise(np.zeros(0), np.zeros(0), 0.1**2)
    values = np.random.default_rng(5).normal(size=3000)
    state, square = states.decoded(values, RATE, noise, 0.5, 1e9)
    assert (len(state), np.isfinite(state).all(), abs(square - 1) < 1e-9) == (3000, True, True)


def test_the_dwell_is_not_lengthened_by_the_blocks():
    rng = np.random.default_rng(5)
    switches = np.cumsum(rng.exponential(4.0, 2000))
    level = np.where(np.searchsorted(switches, np.arange(180000) / RATE) % 2, 0.02, -0.02)
    noise = states.Noise(np.zeros(0), np.zeros(0), 0.035**2 / RATE)
    _, amplitude, dwell = states.fit_levels(
        level + 0.035 * rng.normal(size=180000), RATE, noise, (0.02, 5.0)
    )
    assert abs(dwell - 4.0) <= 3 * 4.0 / 900**0.5  # 900 switches
    assert abs(amplitude - 0.02) <= 0.001


def test_a_ramp_with_a_wave_passes_the_filter_of_the_thermometer():
    t = np.arange(50000) / RATE
    course = 22 + 6 * t / t[-1] + 0.3 * np.sin(2 * np.pi * t / 300)
    noisy = course + 0.02 * np.random.default_rng(6).normal(size=len(t))
    assert np.sqrt(np.mean((signals.denoised(noisy) - course) ** 2)) < 0.01


def test_vibration_that_starts_suddenly_keeps_its_edges():
    rng, envelope = np.random.default_rng(8), np.zeros(60000)
    envelope[20000:40000] = 0.1
    square = signals.mean_square_between(
        1 + envelope * rng.normal(size=60000) + 0.002 * rng.normal(size=60000), 50, 3000
    )
    assert square[:19995].max() < 1e-4
    np.testing.assert_allclose(square[20005:39995], 0.01, rtol=0.15)


def test_allan_deviations_scale_with_the_samples_at_any_size():
    """By powers of two every digit stays, beyond the largest full scale of the library too."""
    y = np.random.default_rng(4).normal(size=3000)
    found = allan.by_library(y, 1000, [1, 2, 4])
    for exponent in (-90, -10, 10, 70, 200):
        scaled = allan.by_library(np.ldexp(y, exponent), 1000, [1, 2, 4])
        np.testing.assert_array_equal(scaled, np.ldexp(found, exponent))


def test_a_sine_in_pieces_is_the_sine():
    for turns, samples, first in ((0.0123, 5000, 0.25), (0.4999, 1024, 0.0), (3e-6, 7, 0.9)):
        whole = np.sin(2 * np.pi * (turns * np.arange(samples) + first))
        np.testing.assert_allclose(signals.sine(turns, samples, first), whole, atol=1e-9)


def test_jumps_do_not_depend_on_the_pieces_in_which_they_are_looked_for():
    rng = np.random.default_rng(15)
    x, good = np.round(3 * rng.standard_normal(30_000)) * 0.1, rng.random(30_000) > 0.02
    x[rng.integers(3, 29_990, 30)] += 25.6
    whole = events.jumps_of("gyro_x_dps", x, good)
    with mock.patch.object(events, "PIECE", 3 * EVENTS.noise_block):
        pieces = events.jumps_of("gyro_x_dps", x, good)
    assert len(whole.at) > 20
    for name in ("at", "size", "noise"):
        np.testing.assert_array_equal(getattr(pieces, name), getattr(whole, name))


def test_long_averaging_times_of_means_are_those_of_samples():
    """Of white noise and a walk: the same clusters, fewer of them (DESIGN 8.6)."""
    rng, window = np.random.default_rng(16), 1 << 17
    y = rng.standard_normal(window) + np.cumsum(rng.standard_normal(window)) * 1e-3
    taus = allan.octaves(window)
    whole = allan.by_library(y, window, taus)[0]
    with mock.patch.object(allan, "JUDGE", replace(allan.JUDGE, means_from=1)):
        means = allan.measured(y, window, taus)[0]
    split = taus.index(256)
    np.testing.assert_array_equal(means[:split], whole[:split])
    np.testing.assert_allclose(means[split:], whole[split:], rtol=0.01)


NOISE = [Part("angle_random_walk"), Part("bias_instability")]


@pytest.fixture
def bench():
    rng, t = np.random.default_rng(9), np.arange(60000) / RATE
    y = 0.035 * rng.normal(size=60000) + 0.01 * np.sin(2 * np.pi * 3.21234 * t + 1)
    return Bench(Recording({"gyro_z_dps": y}, RATE), y)


def test_a_line_is_refined_to_the_peak_of_its_likelihood(bench):
    parts = NOISE + [Part("sinusoid", {"frequency_hz": 3.2125})]
    found = refine.refined(bench, parts)[-1].shape["frequency_hz"]
    around = [found + k * 2e-6 for k in range(-6, 7)]
    best = max(
        around,
        key=lambda f: (bench.fit(NOISE + [Part("sinusoid", {"frequency_hz": f})]).log_likelihood),
    )
    assert abs(found - best) <= 2e-6
    assert abs(found - 3.21234) <= 6e-5


def test_the_maximum_is_reached_where_one_ordinate_holds_most_of_the_energy():
    rng = np.random.default_rng(13)
    for size, place in ((0.027, 255000), (0.05, 150000), (0.1, 300000)):
        y = 0.27 / 60 * RATE**0.5 * rng.normal(size=360000) + size * (np.arange(360000) > place)
        bench = Bench(Recording({"gyro_z_dps": y}, RATE), y)
        fit = bench.fit(NOISE)
        around = [
            estimate.vector_likelihood(bench, NOISE, np.array([n, b]), np.zeros(0))
            for n in fit.sizes[0] * np.geomspace(0.2, 5, 21)
            for b in np.geomspace(1e-8, 1e-3, 41)
        ]
        assert fit.log_likelihood > max(around) - 0.01


def test_sizes_are_those_of_non_negative_least_squares():
    rng = np.random.default_rng(17)
    for _ in range(50):
        shapes = rng.random((6, 300)) ** 3
        wanted = rng.uniform(-1, 1, 6) @ shapes + 0.1 * rng.standard_normal(300)
        weight = rng.uniform(0.1, 10, 300)
        plain = optimize.nnls((shapes * np.sqrt(weight)).T, wanted * np.sqrt(weight))[0]
        found = whittle.non_negative_step(shapes, wanted, weight)
        np.testing.assert_allclose(found, plain, atol=1e-9)


def test_a_fit_from_a_level_near_by_is_the_same_maximum(bench):
    fresh = bench.fit([*NOISE, Part("sinusoid", {"frequency_hz": 3.2125})])
    bench.data.fits.clear()
    near = bench.fit(NOISE).level
    again = bench.fit([*NOISE, Part("sinusoid", {"frequency_hz": 3.2125})], near=near)
    assert abs(again.log_likelihood - fresh.log_likelihood) <= 1e-4


def test_a_size_fitted_as_nothing_has_a_bound_that_such_noise_would_reach():
    rng = np.random.default_rng(11)
    zeros, bounds = 0, []
    for _ in range(12):
        y = 0.035 * rng.normal(size=20000)
        bench = Bench(Recording({"gyro_z_dps": y}, RATE), y)
        found = estimate.all_estimates(bench, NOISE, bench.fit(NOISE))[1]["coefficient_deg_per_h"]
        if found.value == 0:
            zeros += 1
            bounds.append(found.high)
    assert zeros > 2
    # deg/h; 400 s of 0.3 deg/sqrt(h) hide about 8
    assert all(2 < bound < 30 for bound in bounds), bounds


def test_long_memory_is_a_random_walk_unless_it_turns():
    def of(kind, gain):
        return candidate.Candidate(kind, Part(kind), gain, -gain)

    for lead, first in ((2.0, "rate_random_walk"), (5.0, "gauss_markov")):
        found = [of("gauss_markov", 20 + lead), of("rate_random_walk", 20.0)]
        found.append(of("temperature", 1.0))
        candidates.simplest_first(found)
        assert min(found, key=lambda c: c.log_p).kind == first


# A software that subtracts an exponential mean, which began with the first sample.


def test_how_it_settles_is_its_own_and_no_warm_up():
    for seed, period in ((1, 200.0), (2, 60.0)):
        rng = np.random.default_rng(seed)
        x = np.cumsum(rng.standard_normal(90000)) * 2e-4 + 0.03 * rng.standard_normal(90000)
        x[0] = 0.2
        a = np.exp(-2 * np.pi / period / RATE)
        y = x - signal.lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]
        given = [
            model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.25}),
            model.Term("rate_random_walk", {"coefficient_deg_per_h_per_sqrt_h": 300.0}),
        ]
        found = diagnose.diagnose(
            Recording({"time_s": np.arange(90000) / RATE, "gyro_z_dps": y}, RATE),
            model.Model(RATE, "gyro_z_dps", given),
        )
        assert found.added == ["high_pass"]
        last = found.states[-1]
        error = estimate.standard_errors(last.bench, last.parts, last.fit)[1][
            len(last.parts) - 1, "corner_period_s"
        ]
        assert error < 0.1
        assert abs(np.log(last.parts[-1].shape["corner_period_s"] / period)) < 3 * error


def test_the_response_may_be_left_out_of_a_model_file_and_is_then_found():
    term = model.checked_term({"kind": "low_pass", "cutoff_hz": 8.0}, "here")
    assert term.parameters == {"cutoff_hz": 8.0}
    rng = np.random.default_rng(12)
    y = signal.lfilter(*signal.butter(1, 8.0, fs=RATE), 0.035 * rng.normal(size=60000))
    recording = Recording({"gyro_z_dps": y}, RATE)
    terms = [model.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3}), term]
    state = fitting.judged(fitting.start(recording, model.Model(RATE, "gyro_z_dps", terms)))
    assert state.parts[1].shape["response"] == "bilinear"
    assert state.adequacy.p_value > 0.01


# Long records are kept in single precision and processed in pieces.


def long_record(seed, rate=100.0, count=60000):
    """White and flicker noise, a line, and a temperature that the bias follows."""
    rng, time = np.random.default_rng([31, seed]), np.arange(count) / rate
    warm = 25 + 8 * np.sin(2 * np.pi * time / 410)
    y = lab_bench.noise(count, rate, rng)
    y += 0.01 * (warm - 25) + 0.003 * np.sin(2 * np.pi * 17.31 * time)
    return Recording({"time_s": time, "gyro_z_dps": y, "temp_degC": warm}, rate)


def numbers(found):
    return {
        (term.kind, name): estimate
        for term, entry in zip(found.model.terms, found.estimates)
        for name, estimate in entry.items()
        if estimate.low is not None
    }


@pytest.mark.slow
def test_single_precision_gives_the_same_results():
    given = lab_bench.model(100.0)
    for seed in range(3):
        double = improve.improve(long_record(seed), given)
        with mock.patch.object(arrays, "NARROW_FROM", 1000):
            single = improve.improve(long_record(seed), given)
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
