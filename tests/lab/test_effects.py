"""Every effect by textbook formulas: what a number of a model file means, in spectra, in Allan
deviations, in simulated courses and in tables for the device."""

import math

import heat
import lab_bench
import numpy as np
import pytest
from davarlab import simulate
from davarlab.data import signals
from davarlab.data.recording import Recording
from davarlab.effects import columns, filters, table
from davarlab.inference.parts import part_of, spectrum_of
from davarlab.model import Model, Term
from davarlab.report import export
from davarlab.tables import guess
from scipy import signal

RATE = 50.0
N, B, K, Q = 0.3 / 60, 5 / 3600, 20 / 216000, 2e-4  # deg and s
WIDE = (np.arange(400_000) + 0.5) * RATE / 800_000  # frequencies up to half the rate


def gauss_markov(tau, std=0.005, time=6.0):
    """IEEE Std 952-1997, C.1.6."""
    x = tau / time
    return 2 * std**2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))


# kind -> (parameters, Allan variance at tau by annex C of the standard, variance of a sample)
KINDS = {
    "angle_random_walk": ({"coefficient_deg_per_sqrt_h": 0.3}, lambda tau: N**2 / tau, None),
    "bias_instability": (
        {"coefficient_deg_per_h": 5.0},
        lambda tau: 2 * math.log(2) / math.pi * B**2 + 0 * tau,
        None,
    ),
    "rate_random_walk": (
        {"coefficient_deg_per_h_per_sqrt_h": 20.0},
        lambda tau: K**2 * tau / 3,
        None,
    ),
    "quantization": ({"coefficient_deg": Q}, lambda tau: 3 * Q**2 / tau**2, 2 * (Q * RATE) ** 2),
    "gauss_markov": ({"std_dps": 0.005, "correlation_time_s": 6.0}, gauss_markov, 25e-6),
    "telegraph_noise": ({"amplitude_dps": 0.005, "mean_dwell_s": 12.0}, gauss_markov, 25e-6),
    "rate_ramp": (
        {"coefficient_deg_per_h2": 100.0},
        lambda tau: (100 / 3600**2) ** 2 * tau**2 / 2,
        None,
    ),
    "sinusoid": (
        {"amplitude_dps": 0.01, "frequency_hz": 0.7},
        lambda tau: (0.01 * np.sin(np.pi * 0.7 * tau) ** 2 / (np.pi * 0.7 * tau)) ** 2,
        None,
    ),
    "narrow_band": ({"std_dps": 0.01, "frequency_hz": 3.0, "half_width_hz": 0.2}, None, 1e-4),
}
SIMULATED = ("angle_random_walk", "rate_random_walk", "gauss_markov", "quantization", "narrow_band")


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_of_a_model_file_is_its_allan_deviation_and_its_spectrum(kind):
    """The mean of two-sided ordinates over all frequencies is the variance of a sample."""
    parameters, variance, of_a_sample = KINDS[kind]
    term, effect = Term(kind, parameters), table.find(kind)
    if variance:
        found = export.table_of(Model(RATE, "gyro_z_dps", [term]), 10_000, 0.0)
        taus = np.array([32, 128, 512])
        at = [found.taus.index(m) for m in taus]
        np.testing.assert_allclose(found.adev_dps[at] ** 2, variance(taus / RATE), rtol=0.02)
    if of_a_sample:
        power = effect.dps(parameters) ** 2 * effect.spectrum(
            WIDE, RATE, effect.shape_of(parameters)
        )
        assert power.mean() == pytest.approx(of_a_sample, rel=1e-3)
    if kind in SIMULATED:  # in ten bands, by differences: no leakage of slow noise
        made = simulate.make([term], RATE, seed=3, duration_s=4000.0)
        y = np.diff(made.columns["gyro_z_dps"])
        f = np.fft.rfftfreq(len(y), 1 / RATE)[1:]
        seen = np.abs(np.fft.rfft(y)[1:]) ** 2 / len(y)
        true = spectrum_of([part_of(term)], [effect.dps(parameters) ** 2], RATE)(f)
        true = true * 4 * np.sin(np.pi * f / RATE) ** 2
        for band in np.array_split(np.arange(len(f)), 10):
            assert seen[band].sum() / true[band].sum() == pytest.approx(1, abs=0.06)


def test_a_table_adds_variances_and_says_its_taus():
    some = ("angle_random_walk", "bias_instability", "rate_ramp", "sinusoid")
    model = Model(RATE, "gyro_z_dps", [Term(kind, KINDS[kind][0]) for kind in some])
    found = export.table_of(model, 1200, 0.05)
    tau = np.array(found.taus) / RATE
    total = sum(KINDS[kind][1](tau) for kind in some)
    np.testing.assert_allclose(found.adev_dps[2:], np.sqrt(total[2:]), rtol=0.01)
    rows = [line.split(",") for line in export.csv_text(found).splitlines() if line[0] != "#"][1:]
    assert [int(row[0]) for row in rows] == [1, 2, 4, 8, 16, 32, 64, 128]
    np.testing.assert_allclose([float(row[1]) for row in rows], tau)
    np.testing.assert_allclose([float(row[2]) for row in rows], found.adev_dps, rtol=1e-8)
    assert {row[3] for row in rows} == {"0.05"}


def of_scipy(b, a, f):
    """Of SciPy's coefficients."""
    return np.abs(signal.freqz(b, a, worN=f, fs=RATE)[1]) ** 2


def test_filters_and_shapes_of_spectra_are_those_of_their_definitions():
    f = np.linspace(0.1, 24.9, 300)
    z = np.exp(-2j * np.pi * f / RATE)
    a = np.exp(-2 * np.pi / (100 * RATE))
    w = 2 * np.pi * 12 / RATE
    alpha = np.sin(w) / (2 * 3)  # as the audio EQ cookbook and flight controllers have Q
    for kind, values, exact, rtol in (
        *(
            (
                "low_pass",
                {"cutoff_hz": 8.0, "response": "bilinear", "order": order},
                of_scipy(*signal.butter(order, 8.0, fs=RATE), f),
                1e-9,
            )
            for order in (1, 2)
        ),
        *(
            ("low_pass", {"cutoff_hz": 8.0, "response": text}, of_scipy(b, a, f), 1e-6)
            for text, b, a in (
                ("biquad:8", *signal.butter(2, 8.0, fs=RATE)),
                ("notch:12:3", [1, -2 * np.cos(w), 1], [1 + alpha, -2 * np.cos(w), 1 - alpha]),
                (
                    "ba:0.2,0.1,0.3:-0.5,0.1:2",
                    [0.2 / 0.6, 0.1 / 0.6, 0.5],
                    [1 / 0.6, -0.5 / 0.6, 0.1 / 0.6],
                ),
                ("average2:4", np.convolve(np.ones(4), np.ones(4)) / 16, [1]),
                (
                    "biquad:8+average:5",
                    np.convolve(signal.butter(2, 8.0, fs=RATE)[0], np.ones(5) / 5),
                    signal.butter(2, 8.0, fs=RATE)[1],
                ),
            )
        ),
        *(
            (
                "moving_average",
                {"samples": float(m)},
                np.abs((z[:, None] ** np.arange(m)).mean(1)) ** 2,
                1e-7,
            )
            for m in (2, 3, 5)
        ),
        (
            "high_pass",
            {"corner_period_s": 100.0},
            np.abs(1 - (1 - a) / (1 - a * z)) ** 2,
            0.01,
        ),
    ):
        effect = table.find(kind)
        found = effect.spectrum(f, RATE, effect.shape_of(values))
        np.testing.assert_allclose(found, exact, rtol=rtol, atol=1e-12)
    for memory in (0.1, -0.25):  # of an error: its differences have the variance 2 (1 - memory)
        power = table.find("quantization").spectrum(WIDE, RATE, {"memory": memory})
        assert power.mean() / RATE**2 == pytest.approx(2 * (1 - memory), rel=1e-3)
    shape = {"frequency_hz": 8.0, "half_width_hz": 0.2}
    peak, low, high = table.find("narrow_band").spectrum(np.array([8.0, 7.8, 8.2]), RATE, shape)
    assert (low / peak, high / peak) == pytest.approx((0.5, 0.5), rel=0.03)


def test_ordinates_of_averaged_noise_have_the_variance_of_gain_and_ends():
    """Against the covariance matrix, with every ordinate; the gain is nothing at its zeros."""
    count = 300
    basis, f = signals.transform(np.eye(count)), signals.frequencies(count, RATE)
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    for samples in (2.0, 3.0, 4.0, 5.3, 8.0):
        weights, shape = np.ones(int(np.ceil(samples))), {"samples": samples}
        weights[-1] -= len(weights) - samples
        products = np.correlate(weights, weights, "full")[len(weights) - 1 :] / samples**2
        covariance = np.where(lag < len(weights), products[np.minimum(lag, len(weights) - 1)], 0)
        exact = np.einsum("ki,ij,kj->k", basis, covariance, basis)[1:]
        found = filters.moving_average(f, RATE, shape) + filters.leaked(f, RATE, shape) / count
        np.testing.assert_allclose(found, exact, atol=1e-13)
        zeros = np.array(filters.zeros(RATE, shape))
        assert len(zeros) == (samples // 2 if samples.is_integer() else 0)
        np.testing.assert_allclose(filters.moving_average(zeros, RATE, shape), 0, atol=1e-28)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.25, 0.4])
@pytest.mark.parametrize("order", [1, 2])
def test_a_sampled_filter_has_the_spectrum_of_its_autocovariance(order, share):
    """White noise behind an analogue Butterworth filter: of one pole exp(-w t), of two
    exp(-u t) (cos(u t) + sin(u t)), u = w / sqrt(2).
    """
    shape = {"cutoff_hz": share * RATE, "order": order, "response": "sampled"}
    lag = np.arange(1, 2000)
    u = 2 * np.pi * share * lag / (1 if order == 1 else math.sqrt(2))
    covariance = np.exp(-u) * (1 if order == 1 else np.cos(u) + np.sin(u))
    f = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0]) * RATE / 2
    power = 1 + 2 * np.cos(2 * np.pi * np.outer(f, lag) / RATE) @ covariance
    found = filters.low_pass(f, RATE, shape)
    np.testing.assert_allclose(found, power / power[0], rtol=0.01, atol=1e-6)


def test_courses_of_columns_are_those_of_their_definitions():
    t = np.arange(3000) / RATE
    temp = 25 + np.sin(t / 7)
    made = Recording(
        {"time_s": t, "temp_degC": temp, "accel_x_g": 0.1 * np.cos(t), "gyro_z_dps": t}, RATE
    )

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


def test_a_lag_is_late_by_its_time_and_play_is_the_chain_of_its_pushes():
    x = np.arange(180_000) / RATE
    for lag in (0.1, 1.0, 20.0, 60.0):
        for moving, place in ((False, -1), (True, 100), (True, -1)):
            late = x - columns.lagged(x, RATE, lag, moving=moving)
            assert late[place] == pytest.approx(lag, abs=0.03)
    np.testing.assert_array_equal(columns.lagged(x, RATE, 0.0), x)
    for count in (1, 2, 1000, 1023):
        x = np.cumsum(np.random.default_rng(count).standard_normal(count))
        np.testing.assert_allclose(columns.play(x, 3.0), heat.loop(x, 3.0), atol=1e-12)


def test_shocks_and_levels_come_as_often_as_is_stated():
    made, rng = lab_bench.of_gyro(np.zeros(720_000)), np.random.default_rng(5)  # four hours
    for kind, values, levels, count in (
        ("shocks", {"rate_per_hour": 600.0, "amplitude_dps": 0.5}, {-0.5, 0.0, 0.5}, 2400),
        ("telegraph_noise", {"amplitude_dps": 0.1, "mean_dwell_s": 5.0}, {-0.1, 0.1}, 2880),
    ):
        y = simulate.contribution(Term(kind, values), made, rng, None)
        assert set(np.unique(y)) == levels
        changes = np.count_nonzero(y if kind == "shocks" else np.diff(y))
        assert changes == pytest.approx(count, abs=4 * count**0.5)


# What a name and numbers say of a column.


NAMED = {  # quantity, axis and factor -> names
    ("gyro", "x", 57.29577951): "gyro_x_rad_s",
    ("gyro", "z", 1): "wz [deg/s]",
    ("gyro", "y", 1e-3): "gy_mdps",
    ("accel", "y", 1 / 9.80665): "acc_y m/s2",
    ("accel", "x", 1e-3): "ax_mg",
    ("accel", "z", 1): "az [g]",
    ("time", "", 1e-9): "t_ns, timestamp_ns, nsec",
    ("time", "", 1e-6): (
        "time_us, usec, us, timestamp_us, micros, TimeUS, t [us], t_usec, us_since_boot, "
        "Time [\u03bcs], microseconds"
    ),
    ("time", "", 1e-3): "timestamp (ms), time_ms, msec, millis",
    ("time", "", 1): "time [s]",
}
NOISE, COUNT = np.random.default_rng(1).standard_normal(5000), np.arange(500)
NUMBERED = [
    *(("gx", 0.0055 * NOISE, "rad/s"), ("gx", 0.0065 * NOISE, "deg/s")),
    ("gx", np.round(30 * NOISE), "counts"),
    *(("t", COUNT * 2_000_000, "ns"), ("t", COUNT * 2000, "us"), ("t", COUNT * 2, "ms")),
    *(("t", COUNT * 40, "ms"), ("t", COUNT * 60, "us"), ("t", COUNT * 0.002, "s")),
    ("temp", 2500 + 0.5 * np.sin(COUNT), "0.01 degC"),
    ("temp", 25 + 0.5 * np.sin(COUNT), "degC"),
]


@pytest.mark.parametrize("quantity, axis, factor", NAMED)
def test_units_that_a_name_says(quantity, axis, factor):
    for name in NAMED[quantity, axis, factor].split(", "):
        found = guess.of_column(name, np.arange(100) * 0.37)
        assert (found.quantity, found.axis) == (quantity, axis), name
        assert found.factor == pytest.approx(factor), name


@pytest.mark.parametrize("name, values, unit", NUMBERED)
def test_units_by_numbers(name, values, unit):
    assert guess.of_column(name, np.asarray(values, float)).unit == unit


@pytest.mark.parametrize("unit, factor", [("dps", 1.0), ("rad_s", 180 / math.pi)])
def test_rates_of_a_column_are_in_degrees(unit, factor):
    name = f"gyro_z_{unit}"
    made = Recording({name: np.array([0.5, -1.0])}, RATE)
    np.testing.assert_allclose(made.rate_dps(name), np.array([0.5, -1.0]) * factor)
