"""davar-sim --floor: the noise between lines and motion where the spectrum is known, beside noise
that is added to real flights, and bad input.
"""

import gzip
from pathlib import Path

import numpy as np
import pytest
from scipy import signal, stats
from sim_case import REAL, parsed, sim
from spectra import SPECTRA, motion, shaped

FLIGHTS = REAL.parent / "flight"
RATE, LSB = 1000.0, 0.01
WINDOW = 4 * 256 + 32
OPTIONS = ("--law", "fixed", "--mode", "trailing", "--segment", "0", "--taus", "1")
NAMES = [f"floor_{part}deg_per_sqrt_h" for part in ("", "low_", "high_")]


def floors(folder, counts, *options, lsb=LSB, rate=RATE):
    """(why, value, low, high) after each 256 samples, of windows that are full."""
    path = folder / "rec.csv"
    np.savetxt(path, counts, fmt="%d", header="gyro_z_counts", comments="")
    words = ("--rate", rate, "--lsb", lsb, "--bits", 24, "--floor", *OPTIONS)
    done = sim(path, *words, "--window-max", 256, "--stride", 256, *options)
    assert done.returncode == 0, done.stderr
    rows = parsed(done.stdout)[5:]
    cells = [[float(row[name] or "nan") for name in NAMES] for row in rows]
    return np.array([int(row["floor_why"]) for row in rows]), *np.array(cells).T


def quietest(spectrum):
    """The mean over the quietest quarter of 31 frequencies, as a Hann window of 64 differences sees
    them: the definition, on a fine grid."""
    f = np.fft.fftfreq(64 * 64)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(64) + 0.5) / 64)
    kernel = np.abs(np.fft.fft(window, len(f))) ** 2

    def seen(power):
        both = np.fft.ifft(np.fft.fft(power) * np.fft.fft(kernel)).real
        return both[::64][1:32]

    difference = 4 * np.sin(np.pi * f) ** 2
    density = seen(spectrum(np.abs(f)) * difference) / seen(difference)
    return np.sort(density)[:8].mean()


@pytest.mark.parametrize("seed, name", enumerate(SPECTRA), ids=SPECTRA)
def test_intervals_contain_the_mean_over_the_quietest_quarter(tmp_path, seed, name):
    random, sigma = np.random.default_rng([57, seed]), 20.0
    counts = np.rint(sigma * shaped(random, SPECTRA[name], 600_000))
    why, value, low, high = floors(tmp_path, counts, "--bandwidth", "none")
    truth = 60 * LSB * sigma * np.sqrt(quietest(SPECTRA[name]) / RATE)
    assert (why == 0).mean() > 0.99
    assert abs(np.nanmean(value) / truth - 1) < 0.04
    assert ((low < truth) & (truth < high)).mean() >= 0.9


def test_lines_that_sweep_leave_the_floor(tmp_path):
    random, sigma = np.random.default_rng(58), 20.0
    t = np.arange(300_000)
    throttle = np.clip(1 + 0.3 * np.sin(2 * np.pi * t / 3700), 0.6, 1.5)
    x = random.normal(size=len(t)) + shaped(random, lambda f: motion(f, 1e5, 0.004), len(t))
    for c in (0.071, 0.083):
        phase = 2 * np.pi * np.cumsum(c * throttle)
        x += sum(20 / h * throttle**2 * np.sin(h * phase) for h in (1, 2, 3))
    why, value, low, high = floors(tmp_path, np.rint(sigma * x), "--bandwidth", "none")
    truth = 60 * LSB * sigma / np.sqrt(RATE)
    assert (why == 0).mean() > 0.95
    assert abs(np.nanmedian(value) / truth - 1) < 0.1
    assert (high[why == 0] > truth).mean() >= 0.95


@pytest.mark.parametrize(
    "cutoff, has_value", ((0.45, True), (0.3, True), (0.25, True), (0.2, True), (0.15, False))
)
def test_behind_a_filter_it_is_the_noise_in_front_or_an_upper_limit(tmp_path, cutoff, has_value):
    random = np.random.default_rng(59)
    white = random.normal(0, 20.0, 300_000)
    counts = np.rint(signal.lfilter(*signal.butter(2, cutoff, fs=1), white))
    why, value, low, high = floors(tmp_path, counts, "--bandwidth", f"biquad:{cutoff * RATE}")
    truth = 60 * LSB * 20.0 / np.sqrt(RATE)
    assert set(why) == ({0} if has_value else {2})
    assert (high > truth).mean() > 0.95
    if has_value:
        assert ((low < truth) & (truth < high)).mean() >= 0.9
    else:
        assert np.isnan(value).all()


@pytest.mark.parametrize("kind", ("analogue", "biquad"))
def test_a_cutoff_that_is_known_to_ten_percent_is_in_the_interval(tmp_path, kind):
    """Over gyros whose cutoffs scatter by as much."""
    random, over, held = np.random.default_rng(62), 16 if kind == "analogue" else 1, []
    cutoff, text = (0.35, "350:2:10") if kind == "analogue" else (0.42, "biquad:420:10")
    for factor in 1 + 0.1 * stats.norm.ppf(np.arange(1, 8) / 8):
        white = random.normal(0, 20.0 * np.sqrt(over), 100_000 * over)
        sections = signal.butter(2, factor * cutoff, fs=over, output="sos")
        counts = np.rint(signal.sosfilt(sections, white)[::over])
        why, _, low, high = floors(tmp_path, counts, "--bandwidth", text)
        aliases = np.arange(-8, 9) / (factor * cutoff) if over > 1 else np.zeros(1)
        truth = 60 * LSB * 20.0 / np.sqrt(RATE) * np.sqrt(np.sum(1 / (1 + aliases**4)))
        assert set(why) == {0}
        held.append(((low < truth) & (truth < high)).mean())
    assert np.mean(held) >= 0.9


def test_a_stuck_sensor_has_no_value_that_falls(tmp_path):
    counts = np.rint(np.random.default_rng(63).normal(0, 20.0, 40_000))
    counts[20_100:24_000] = counts[20_099]
    path = tmp_path / "rec.csv"
    np.savetxt(path, counts, fmt="%d", header="gyro_z_counts", comments="")
    words = ("--rate", RATE, "--lsb", LSB, "--floor", "--bandwidth", "none", *OPTIONS)
    rows = parsed(sim(path, *words, "--window-max", 64, "--stride", 64).stdout)
    truth = 60 * LSB * 20.0 / np.sqrt(RATE)
    values = [float(row[NAMES[0]] or "nan") for row in rows]
    stuck = [row["floor_why"] == "6" for row in rows]
    assert 4000 / 64 < sum(stuck) < (4000 + 2 * WINDOW) / 64
    assert np.nanmin(values) > 0.8 * truth


def flights():
    return sorted(FLIGHTS.glob("*.csv.gz")) if FLIGHTS.is_dir() else []


def flown(path):
    """(rows, columns) of a flight, its rate and the size of a count."""
    with gzip.open(path, "rt") as text:
        rows = [line for line in text if line[0] != "#"]
    data = np.genfromtxt(rows[1:], delimiter=",")
    return (data, 1000.0, 1.0) if "betaflight" in path.name else (data, 800.0, 4000 / 2**19)


@pytest.mark.skipif(not flights(), reason="needs the flights in shared/data")
@pytest.mark.parametrize("path", flights(), ids=lambda path: path.name.split(".")[0])
def test_in_real_flight_it_is_always_there_and_sees_what_is_added(tmp_path, path):
    data, rate, lsb = flown(path)
    random = np.random.default_rng(60)
    for axis in (1, 2, 3):
        counts = np.rint(data[:, axis] / lsb)
        ends = np.arange(6 * 256, len(counts), 256)[: len(counts) // 256 - 5]
        flying = np.array([counts[end - WINDOW : end].std() * lsb > 1 for end in ends])
        options = ("--bandwidth", "none")
        why, value, _, _ = floors(tmp_path, counts, *options, lsb=lsb, rate=rate)
        flying = flying[: len(why)]
        assert (why[flying] == 0).mean() >= 0.95
        known = flying & (why == 0)
        floor = np.median(value[known])
        sigma = floor / 60 * np.sqrt(rate) / lsb
        rounding = (60 * lsb) ** 2 / rate / 12  # of the counts of the file
        for floors_added in (1, 2, 4):
            added = random.normal(0, sigma * np.sqrt(floors_added), len(counts))
            louder = np.rint((data[:, axis] / lsb + added) * 16)
            again = floors(tmp_path, louder, *options, "--bits", 32, lsb=lsb / 16, rate=rate)[1]
            rise = np.nanmedian(again[known] ** 2 - rounding - value[known] ** 2) / floor**2
            assert abs(np.sqrt(rise / floors_added) - 1) < 0.15


def test_the_rows_do_not_depend_on_the_pace_or_the_other_columns(tmp_path):
    random = np.random.default_rng(61)
    counts = np.rint(random.normal(0, 20, (6000, 2)))
    path = tmp_path / "rec.csv"
    np.savetxt(
        path, counts, fmt="%d", delimiter=",", header="gyro_x_counts,gyro_y_counts", comments=""
    )
    words = (path, "--rate", 1000, "--lsb", LSB, "--floor", "--bandwidth", "none", "--stride", 100)
    fast = sim(*words, "--column", "gyro_y_counts").stdout
    slow = sim(*words, "--column", "gyro_y_counts", "--pace", "20").stdout
    both = parsed(sim(*words, "--column", "gyro_x_counts,gyro_y_counts").stdout)
    assert fast == slow
    mine = [row for row in both if row["channel"] == "gyro_y_counts"]
    assert [row["floor_high_deg_per_sqrt_h"] for row in mine] == [
        row["floor_high_deg_per_sqrt_h"] for row in parsed(fast)
    ]


@pytest.mark.parametrize(
    "options, way",
    (
        (("--bandwidth", "none", "--arith", "float"), "counts"),
        (("--bandwidth", "none", "--out", "dronecan:can0"), "mavlink:.."),
        (("--bandwidth", "none", "--device", "tools/davar-mcu"), "--device"),
        ((), "--bandwidth"),
        (("--bandwidth", "auto"), "gyro_x_dps: the filter is unknown"),
    ),
)
def test_where_it_cannot_be_is_one_line(tmp_path, options, way):
    path = tmp_path / "rec.csv"
    np.savetxt(path, np.zeros(2000), fmt="%.2f", header="gyro_x_dps", comments="")
    done = sim(Path(path), "--rate", 100, "--floor", *options)
    *_, last = done.stderr.splitlines()
    assert (done.returncode, done.stdout) == (2, "")
    assert "--floor" in last and way in last
