"""Every effect by textbook formulas: what a number of a model file means, in spectra, in Allan
deviations, in simulated courses and in tables for the device."""

import math

import heat
import lab_bench
import numpy as np
import pytest
from davarlab import simulate
from davarlab.data import guess
from davarlab.data.recording import Recording
from davarlab.effects import table
from davarlab.inference.parts import part_of, spectrum_of
from davarlab.model import Model, Term
from davarlab.report import export

RATE = 50.0
N, B, K, Q = 0.3 / 60, 5 / 3600, 20 / 216000, 2e-4  # deg and s
TERMS = {
    "angle_random_walk": {"coefficient_deg_per_sqrt_h": 0.3},
    "bias_instability": {"coefficient_deg_per_h": 5.0},
    "rate_random_walk": {"coefficient_deg_per_h_per_sqrt_h": 20.0},
    "quantization": {"coefficient_deg": 2e-4},
    "gauss_markov": {"std_dps": 0.005, "correlation_time_s": 6.0},
    "telegraph_noise": {"amplitude_dps": 0.005, "mean_dwell_s": 12.0},
    "rate_ramp": {"coefficient_deg_per_h2": 100.0},
    "sinusoid": {"amplitude_dps": 0.01, "frequency_hz": 0.7},
    "narrow_band": {"std_dps": 0.01, "frequency_hz": 3.0, "half_width_hz": 0.2},
}


def gauss_markov(tau, std=0.005, time=6.0):
    """IEEE Std 952-1997, C.1.6."""
    x = tau / time
    return 2 * std**2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))


ALLAN = {  # IEEE Std 952-1997, annex C: variances at tau
    "angle_random_walk": lambda tau: N**2 / tau,
    "bias_instability": lambda tau: 2 * math.log(2) / math.pi * B**2 + 0 * tau,
    "rate_random_walk": lambda tau: K**2 * tau / 3,
    "quantization": lambda tau: 3 * Q**2 / tau**2,
    "gauss_markov": gauss_markov,
    "telegraph_noise": gauss_markov,
    "rate_ramp": lambda tau: (100 / 3600**2) ** 2 * tau**2 / 2,
    "sinusoid": lambda tau: (0.01 * np.sin(np.pi * 0.7 * tau) ** 2 / (np.pi * 0.7 * tau)) ** 2,
}


@pytest.mark.parametrize("kind", ALLAN)
def test_the_allan_deviation_of_a_number_of_a_model_file(kind):
    model = Model(RATE, "gyro_z_dps", [Term(kind, TERMS[kind])])
    taus = [32, 128, 512]
    found = export.table_of(model, 10_000, 0.0)
    at = [found.taus.index(m) for m in taus]
    expected = np.sqrt(ALLAN[kind](np.array(taus) / RATE))
    np.testing.assert_allclose(found.adev_dps[at], expected, rtol=0.01)


def test_a_table_adds_variances_and_says_its_taus():
    some = ("angle_random_walk", "bias_instability", "rate_ramp", "sinusoid")
    model = Model(RATE, "gyro_z_dps", [Term(kind, TERMS[kind]) for kind in some])
    found = export.table_of(model, 1200, 0.05)
    tau = np.array(found.taus) / RATE
    total = sum(ALLAN[kind](tau) for kind in some)
    np.testing.assert_allclose(found.adev_dps[2:], np.sqrt(total[2:]), rtol=0.01)
    rows = [line.split(",") for line in export.csv_text(found).splitlines() if line[0] != "#"][1:]
    assert [int(row[0]) for row in rows] == [1, 2, 4, 8, 16, 32, 64, 128]
    np.testing.assert_allclose([float(row[1]) for row in rows], tau)
    np.testing.assert_allclose([float(row[2]) for row in rows], found.adev_dps, rtol=1e-8)
    assert {row[3] for row in rows} == {"0.05"}


@pytest.mark.parametrize("kind", ["gauss_markov", "telegraph_noise", "narrow_band", "quantization"])
def test_a_spectrum_holds_the_variance_of_its_process(kind):
    """The mean of two-sided ordinates over all frequencies is the variance of a sample."""
    term = Term(kind, TERMS[kind])
    effect = table.find(kind)
    f = (np.arange(400_000) + 0.5) * RATE / 800_000
    power = effect.dps(term.parameters) ** 2 * effect.spectrum(
        f, RATE, effect.shape_of(term.parameters)
    )
    size = {"quantization": 2 * (Q * RATE) ** 2, "narrow_band": 1e-4}.get(kind, 25e-6)
    assert power.mean() == pytest.approx(size, rel=1e-3)


@pytest.mark.parametrize(
    "kind", ["angle_random_walk", "rate_random_walk", "gauss_markov", "quantization", "narrow_band"]
)
def test_what_is_simulated_has_the_spectrum_that_is_fitted(kind):
    """In ten bands, by the periodogram of differences, which has no leakage of slow noise."""
    term = Term(kind, TERMS[kind])
    made = simulate.make([term], RATE, seed=3, duration_s=4000.0)
    y = np.diff(made.columns["gyro_z_dps"])
    f = np.fft.rfftfreq(len(y), 1 / RATE)[1:]
    seen = np.abs(np.fft.rfft(y)[1:]) ** 2 / len(y)
    gain = 4 * np.sin(np.pi * f / RATE) ** 2
    sizes = [table.find(kind).dps(term.parameters) ** 2]
    true = spectrum_of([part_of(term)], sizes, RATE)(f) * gain
    for band in np.array_split(np.arange(len(f)), 10):
        assert seen[band].sum() / true[band].sum() == pytest.approx(1, abs=0.06)


def test_a_low_pass_and_an_average_have_the_gain_of_their_definitions():
    f = np.linspace(0.1, 24.9, 300)
    low = table.find("low_pass")
    for order in (1, 2):
        shape = low.shape_of({"cutoff_hz": 8.0, "response": "analogue", "order": order})
        np.testing.assert_allclose(
            low.spectrum(f, RATE, shape), 1 / (1 + (f / 8.0) ** (2 * order)), rtol=1e-9
        )
    average = table.find("moving_average")
    for samples in (2, 3, 5):
        exact = np.abs(np.exp(-2j * np.pi * np.outer(f, np.arange(samples)) / RATE).mean(1)) ** 2
        found = average.spectrum(f, RATE, {"samples": float(samples)})
        np.testing.assert_allclose(found, exact, atol=1e-12)
    high = table.find("high_pass")
    found = high.spectrum(f, RATE, {"corner_period_s": 100.0})
    a = np.exp(-2 * np.pi / (100 * RATE))
    z = np.exp(-2j * np.pi * f / RATE)
    np.testing.assert_allclose(found, np.abs(1 - (1 - a) / (1 - a * z)) ** 2, rtol=0.01)


def test_courses_of_columns_are_those_of_their_definitions():
    t = np.arange(3000) / RATE
    temp = 25 + np.sin(t / 7)
    columns = {"time_s": t, "temp_degC": temp, "accel_x_g": 0.1 * np.cos(t), "gyro_z_dps": t}
    made = Recording(columns, RATE)

    def course(kind, **values):
        return simulate.contribution(Term(kind, values), made, np.random.default_rng(1), t)

    def moves(found):
        return found - found.mean()

    for kind, values, exact in (
        ("temperature", {"coefficient_dps_per_degC": 0.02}, 0.02 * temp),
        ("g_sensitivity", {"coefficient_dps_per_g": 0.5, "axis": "x"}, 0.05 * np.cos(t)),
        ("rate_ramp", {"coefficient_deg_per_h2": 3600.0**2}, t),
        ("warm_up", {"amplitude_dps": 0.05, "time_constant_s": 9.0}, 0.05 * np.exp(-t / 9)),
        ("bias_step", {"time_s": 20.0, "step_dps": 0.1}, 0.1 * (t >= 20)),
    ):
        np.testing.assert_allclose(moves(course(kind, **values)), moves(exact), atol=2e-3)
    line = course("sinusoid", amplitude_dps=0.3, frequency_hz=2.0)
    assert (line.max(), 2 * np.var(line)) == pytest.approx((0.3, 0.09), rel=0.01)
    rate = course("temperature_rate", coefficient_dps_per_degC_per_s=1.0)
    exact = np.cos(t / 7) * np.sin(5 / 7) / 5  # from 5 s before to 5 s after
    np.testing.assert_allclose(moves(rate[300:-300]), moves(exact[300:-300]), atol=0.01)
    late = course("temperature", coefficient_dps_per_degC=1.0, lag_s=4.0)
    np.testing.assert_allclose(np.diff(late), np.diff(heat.late(temp, 4.0)), atol=2e-3)


def test_shocks_and_levels_come_as_often_as_is_stated():
    made = lab_bench.of_gyro(np.zeros(720_000))  # four hours
    rng = np.random.default_rng(5)
    shocks = Term("shocks", {"rate_per_hour": 600.0, "amplitude_dps": 0.5})
    y = simulate.contribution(shocks, made, rng, None)
    assert set(np.unique(y)) == {-0.5, 0.0, 0.5}
    assert np.count_nonzero(y) == pytest.approx(2400, abs=4 * 2400**0.5)
    levels = Term("telegraph_noise", {"amplitude_dps": 0.1, "mean_dwell_s": 5.0})
    y = simulate.contribution(levels, made, rng, None)
    assert set(np.unique(y)) == {-0.1, 0.1}
    assert np.count_nonzero(np.diff(y)) == pytest.approx(2880, abs=4 * 2880**0.5)


TIME_NAMES = {
    1e-9: "t_ns, timestamp_ns, nsec",
    1e-6: "time_us, usec, timestamp_us, micros, TimeUS, t [us], microseconds",
    1e-3: "timestamp (ms), time_ms, msec, millis",
    1: "time [s]",
}


@pytest.mark.parametrize(
    "name, quantity, axis, factor",
    [
        ("gyro_x_rad_s", "gyro", "x", 57.29577951),
        ("wz [deg/s]", "gyro", "z", 1),
        ("gy_mdps", "gyro", "y", 1e-3),
        ("acc_y m/s2", "accel", "y", 1 / 9.80665),
        ("ax_mg", "accel", "x", 1e-3),
        ("az [g]", "accel", "z", 1),
        *(
            (name, "time", "", factor)
            for factor, names in TIME_NAMES.items()
            for name in names.split(", ")
        ),
    ],
)
def test_units_that_a_name_says(name, quantity, axis, factor):
    found = guess.of_column(name, np.arange(100) * 0.37)
    assert (found.quantity, found.axis) == (quantity, axis)
    assert found.factor == pytest.approx(factor)


@pytest.mark.parametrize(
    "name, values, unit",
    [
        ("gx", 0.0055 * np.random.default_rng(1).standard_normal(5000), "rad/s"),
        ("gx", 0.0065 * np.random.default_rng(1).standard_normal(5000), "deg/s"),
        ("gx", np.round(30 * np.random.default_rng(1).standard_normal(5000)), "counts"),
        ("t", np.arange(500) * 2_000_000, "ns"),
        ("t", np.arange(500) * 2000, "us"),
        ("t", np.arange(500) * 2, "ms"),
        ("t", np.arange(500) * 40, "ms"),
        ("t", np.arange(500) * 60, "us"),
        ("t", np.arange(500) * 0.002, "s"),
        ("temp", 2500 + 0.5 * np.sin(np.arange(500)), "0.01 degC"),
        ("temp", 25 + 0.5 * np.sin(np.arange(500)), "degC"),
    ],
)
def test_units_by_numbers(name, values, unit):
    assert guess.of_column(name, np.asarray(values, float)).unit == unit


@pytest.mark.parametrize("unit, factor", [("dps", 1.0), ("rad_s", 180 / math.pi)])
def test_rates_of_a_column_are_in_degrees(unit, factor):
    name = f"gyro_z_{unit}"
    made = Recording({name: np.array([0.5, -1.0])}, RATE)
    np.testing.assert_allclose(made.rate_dps(name), np.array([0.5, -1.0]) * factor)


@pytest.mark.parametrize("memory", [0.1, -0.25])
def test_rounding_with_a_memory(memory):
    """Differences of an error with this correlation have the variance 2 (1 - memory)."""
    f = (np.arange(400_000) + 0.5) * RATE / 800_000
    power = table.find("quantization").spectrum(f, RATE, {"memory": memory})
    assert power.mean() / RATE**2 == pytest.approx(2 * (1 - memory), rel=1e-3)


def test_a_band_has_half_of_its_power_at_half_its_width():
    shape = {"frequency_hz": 8.0, "half_width_hz": 0.2}
    peak, low, high = table.find("narrow_band").spectrum(np.array([8.0, 7.8, 8.2]), RATE, shape)
    assert (low / peak, high / peak) == pytest.approx((0.5, 0.5), rel=0.03)


@pytest.mark.parametrize("lag", [0.1, 1.0, 20.0])
def test_a_ramp_is_late_by_the_lag(lag):
    from davarlab.effects import columns

    x = np.arange(20_000) / RATE
    late = x - columns.lagged(x, RATE, lag, moving=True)
    assert late[10_000:].mean() == pytest.approx(lag, abs=0.03)
