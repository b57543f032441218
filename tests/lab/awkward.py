"""Recordings of awkward sensors: what real ones do and textbooks do not. Numpy and scipy only, nothing of davarlab. 100 Hz, one hour, ARW 0.3 deg/sqrt(h),
BI 5 deg/h unless a case says otherwise; all else is drawn. `awkward.py CASE SEED REC.csv` writes one.

A case is a row of ingredients in the order of physics: what moves the rate, then the sensor's own filter, its counts, its clock. Each adds to the
recording and to the truth."""

import sys
from dataclasses import dataclass, field

import numpy as np
from elsewhere import DEG, ar1, flicker_fft, flicker_kasdin, flicker_sum
from scipy import signal

RATE, SECONDS = 100.0, 3600.0
N, B = 0.3, 5.0


@dataclass
class Truth:
    kinds: dict = field(default_factory=dict)  # kind -> its true parameters, for the coverage of intervals
    groups: list = field(default_factory=list)  # of each group one kind must be named: names of the same thing
    extra: set = field(default_factory=set)  # kinds that may be named besides and are true of the recording too
    observations: set = field(default_factory=set)  # must be said; "a|b": one of them
    tolerated: set = field(default_factory=set)  # may be said
    shape: dict = field(default_factory=dict)  # (kind, parameter) -> the range, or the word, that it must have
    said: str = ""  # words that must stand in the answer, outside the candidates
    unknown_is_right: bool = False  # no effect of the table describes it whole
    clean: bool = False
    covers: bool = True  # N and B are those of the recording


class Bench:
    """One recording in the making."""

    def __init__(self, rng, rate, seconds):
        self.rng, self.rate, self.count = rng, rate, int(round(rate * seconds))
        self.t = np.arange(self.count) / rate
        self.stamps = self.t
        self.white = N / 60 * np.sqrt(rate) * rng.standard_normal(self.count)
        flicker = (flicker_sum, flicker_fft, flicker_kasdin)[rng.integers(3)]
        self.slow = flicker(self.count, B / DEG, rng)
        self.keep = slice(None)
        self.temperature = self.celsius(str(rng.choice(["walk", "cycles", "chamber"])))
        self.gravity = np.array([0.0, 0.0, 1.0])
        self.accel = np.zeros((3, self.count))
        self.more = {}
        self.truth = Truth()

    def celsius(self, how):
        """A course of the temperature; each turns more than once or has a corner."""
        rng, span = self.rng, self.t[-1]
        if how == "cycles":
            cycles = rng.uniform(3, 6)
            return 25 + rng.uniform(2, 4) * np.sin(2 * np.pi * cycles * self.t / span + rng.uniform(0, 6))
        if how == "warming":
            return 22 + rng.uniform(5, 9) * -np.expm1(-self.t / rng.uniform(0.1, 0.4) / span)
        if how == "walk":
            walk = np.interp(self.t, np.linspace(0, span, 40), np.cumsum(rng.standard_normal(40)))
            return 25 + rng.uniform(5, 8) * (walk - walk.min()) / np.ptp(walk)
        steps = np.repeat(rng.permutation(np.linspace(-4, 4, 6)), -(-self.count // 6))[:self.count]
        return 25 + self.lagged(steps, rng.uniform(60, 180))

    def lagged(self, x, lag_s):
        """A first-order lag that begins at rest."""
        a = np.exp(-1 / (self.rate * lag_s))
        return signal.lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]

    def sign(self):
        return float(self.rng.choice([-1, 1]))

    def hide(self, kind, parameters, same=()):
        self.truth.kinds[kind] = parameters
        self.truth.groups.append({kind, *same})

    def through(self, a_filter):
        """The sensor's own filter: all that came before passes."""
        self.slow, self.white = a_filter(self.white + self.slow), np.zeros(self.count)

    def columns(self):
        rng = self.rng
        y = self.white + self.slow
        table = {"time_s": self.stamps, "gyro_z_dps": y + self.more.pop("bias", 0.2), "temp_degC": self.temperature + 0.02 * rng.standard_normal(self.count)}
        for axis, gravity, felt in zip("xyz", self.gravity, self.accel):
            table[f"accel_{axis}_g"] = gravity + felt + 0.002 * rng.standard_normal(self.count)
        table.update(self.more)
        return {name: values[self.keep] for name, values in table.items()}


# What moves the rate.

def temperature(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.02)
    bench.slow += coefficient * (bench.temperature - 25)
    bench.hide("temperature", {"coefficient_dps_per_degC": coefficient})


def temperature_lag(bench):
    how = str(bench.rng.choice(["walk", "cycles", "chamber"]))
    bench.temperature = bench.celsius(how)
    coefficient, lag = bench.sign() * bench.rng.uniform(0.01, 0.02), bench.rng.uniform(45, 75)
    bench.slow += coefficient * (bench.lagged(bench.temperature, lag) - 25)
    bench.hide("temperature", {"coefficient_dps_per_degC": coefficient, "lag_s": lag})
    bench.truth.shape["temperature", "lag_s"] = (lag / 2.5, lag * 2.5)


def played(x, width):
    """A dead band of a width: the follower moves when it is pushed."""
    y, out = x[0], np.empty(len(x))
    for k, value in enumerate(x):
        y = min(max(y, value - width / 2), value + width / 2)
        out[k] = y
    return out


def temperature_hysteresis(bench):
    bench.temperature = bench.celsius(str(bench.rng.choice(["walk", "cycles"])))
    width = bench.rng.uniform(0.15, 0.4) * np.ptp(bench.temperature)
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.02)
    every = np.arange(0, bench.count, int(bench.rate))
    felt = np.interp(bench.t, bench.t[every], played(bench.temperature[every], width))
    bench.slow += coefficient * (felt - 25)
    bench.hide("temperature_hysteresis", {"coefficient_dps_per_degC": coefficient, "width_degC": width})


def temperature_squared(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.0015, 0.004)
    bench.slow += coefficient * (bench.temperature - 25) ** 2
    bench.hide("temperature_squared", {"coefficient_dps_per_degC2": coefficient})
    bench.truth.extra.add("temperature")  # where the parabola has its vertex is a straight term


def supply(bench):
    """Volts: loads that are switched, a battery that empties, ripple of the logger."""
    rng = bench.rng
    loads = np.cumsum(rng.exponential(200, 60))
    volts = 5 - 0.1 * bench.t / bench.t[-1] - 0.15 * (np.searchsorted(loads, bench.t) % 2) + 0.05 * ar1(bench.count, np.exp(-1 / (30 * bench.rate)), rng)
    bench.more["supply_V"] = volts + 0.002 * rng.standard_normal(bench.count)
    return volts


def supply_voltage(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.08, 0.2)
    bench.slow += coefficient * (supply(bench) - 5)
    bench.hide("follows", {"coefficient": coefficient})
    bench.truth.shape["follows", "column"] = "supply_V"


def rocking(bench):
    """Degrees per second about x, as on water: it tilts gravity into y."""
    f, rng = bench.rng.uniform(0.08, 0.3), bench.rng
    rate = rng.uniform(0.5, 1.5) * band(bench.count, f / bench.rate, 0.1 * f / bench.rate, rng)
    bench.accel[1] += np.sin(np.radians(np.cumsum(rate - rate.mean()) / bench.rate))
    sigma = N / 60 * np.sqrt(bench.rate)
    bench.more["gyro_x_dps"] = rate + sigma * rng.standard_normal(bench.count) - 0.1
    bench.more["gyro_y_dps"] = sigma * rng.standard_normal(bench.count) + 0.3
    bench.truth.tolerated.add("motion")
    return rate


def axis_leak(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.03)
    bench.slow += coefficient * rocking(bench)
    bench.hide("follows", {"coefficient": coefficient})
    bench.truth.shape["follows", "column"] = "gyro_x_dps"


def band(count, nu, half_width, rng):
    """Unit variance about a frequency: an oscillator whose amplitude and phase are kicked. All in cycles per sample."""
    decay = np.exp(-2 * np.pi * half_width)
    return ar1(count, decay, rng) * np.cos(2 * np.pi * nu * np.arange(count)) + ar1(count, decay, rng) * np.sin(2 * np.pi * nu * np.arange(count))


def narrow_band(bench):
    scale = bench.rate / RATE
    f, half_width, std = bench.rng.uniform(17, 38) * scale, bench.rng.uniform(0.15, 0.5) * scale, bench.rng.uniform(0.02, 0.06)
    bench.slow += std * band(bench.count, f / bench.rate, half_width / bench.rate, bench.rng)
    bench.hide("narrow_band", {"std_dps": std, "frequency_hz": f, "half_width_hz": half_width})


def line(bench, low=0.02, high=0.4):
    f, amplitude = bench.rate * bench.rng.uniform(low, high), bench.rng.uniform(0.006, 0.02)
    bench.slow += amplitude * np.sin(2 * np.pi * f * bench.t + bench.rng.uniform(0, 6))
    bench.hide("sinusoid", {"frequency_hz": f, "amplitude_dps": amplitude})


def two_lines(bench):
    line(bench, 0.02, 0.15)
    line(bench, 0.2, 0.4)
    bench.truth.groups.pop()


def drifting_line(bench):
    f, moves = bench.rate * bench.rng.uniform(0.17, 0.38), bench.rng.uniform(0.3, 1.5)
    u = bench.t / bench.t[-1]
    course = f + moves * (u if bench.rng.random() < 0.5 else np.sin(2 * np.pi * u * bench.rng.uniform(0.5, 2)) / 2)
    amplitude = bench.rng.uniform(0.02, 0.05)
    bench.slow += amplitude * np.sin(2 * np.pi * np.cumsum(course) / bench.rate)
    bench.truth.groups.append({"narrow_band", "sinusoid", "intermittent_line"})


def intermittent_line(bench):
    f, amplitude = bench.rate * bench.rng.uniform(0.02, 0.4), bench.rng.uniform(0.01, 0.03)
    length = bench.rng.uniform(0.08, 0.3) * bench.t[-1]
    start = bench.rng.uniform(0.05 * bench.t[-1], 0.95 * bench.t[-1] - length)
    on = (bench.t >= start) & (bench.t < start + length)
    bench.slow += on * amplitude * np.sin(2 * np.pi * f * bench.t + bench.rng.uniform(0, 6))
    bench.hide("intermittent_line", {"frequency_hz": f, "amplitude_dps": amplitude, "start_s": start, "stop_s": start + length})


def temperature_noise(bench):
    bench.temperature = bench.celsius(str(bench.rng.choice(["walk", "cycles", "chamber", "warming"])))
    kappa = bench.sign() * np.exp(bench.rng.uniform(np.log(0.0087), np.log(0.082)))
    bench.white = bench.white * np.exp(kappa * (bench.temperature - bench.temperature.mean()))
    bench.hide("temperature_noise", {"relative_per_degC": kappa})


def telegraph_three_levels(bench):
    dwell, amplitude = bench.rng.uniform(6, 30), bench.rng.uniform(0.015, 0.03)
    visits = int(20 + 3 * bench.t[-1] / dwell)
    switches = np.cumsum(bench.rng.exponential(dwell, visits))
    level = np.cumsum(np.concatenate([[0], bench.rng.integers(1, 3, visits)])) % 3 - 1  # to one of the other two
    bench.slow += amplitude * level[np.searchsorted(switches, bench.t)]
    bench.hide("telegraph_noise", {"mean_dwell_s": dwell})


def telegraph(bench):
    dwell, amplitude = bench.rng.uniform(6, 30), bench.rng.uniform(0.012, 0.025)
    switches = np.cumsum(bench.rng.exponential(dwell, int(20 + 3 * bench.t[-1] / dwell)))
    bench.slow += amplitude * np.where(np.searchsorted(switches, bench.t) % 2, 1.0, -1.0)
    bench.hide("telegraph_noise", {"amplitude_dps": amplitude, "mean_dwell_s": dwell})


def random_walk(bench):
    k = bench.rng.uniform(40, 100)  # deg/h/sqrt(h)
    bench.slow += np.cumsum(bench.rng.standard_normal(bench.count)) * k / DEG / 60 / np.sqrt(bench.rate)
    bench.hide("rate_random_walk", {"coefficient_deg_per_h_per_sqrt_h": k})


def bias_step(bench):
    when, size = bench.rng.uniform(0.15, 0.85) * bench.t[-1], bench.sign() * bench.rng.uniform(0.01, 0.03)
    bench.slow += size * (bench.t >= when)
    bench.hide("bias_step", {"time_s": when, "step_dps": size})


def bias_steps(bench):
    for low, high in ((0.1, 0.35), (0.45, 0.6), (0.7, 0.9)):
        bench.slow += bench.sign() * bench.rng.uniform(0.01, 0.03) * (bench.t >= bench.rng.uniform(low, high) * bench.t[-1])
    bench.truth.groups.append({"bias_step"})


def warm_up_two(bench):
    rng, size = bench.rng, bench.sign()
    bench.slow += size * (rng.uniform(0.04, 0.1) * np.exp(-bench.t / rng.uniform(20, 60)) + rng.uniform(0.04, 0.1) * np.exp(-bench.t / rng.uniform(400, 900)))
    bench.truth.groups.append({"warm_up"})
    bench.truth.unknown_is_right = True


def common_cause(bench):
    """A reference drifts that gyro and accelerometer share, each through a filter of its own. Nobody logs it."""
    rng = bench.rng
    cause = ar1(bench.count, np.exp(-1 / (bench.rate * rng.uniform(60, 300))), rng)
    through = bench.lagged(cause, rng.uniform(5, 20))
    sigma = N / 60 * np.sqrt(bench.rate)
    bench.slow += rng.uniform(0.005, 0.012) * through
    for axis in "xy":
        bench.more[f"gyro_{axis}_dps"] = rng.uniform(0.004, 0.012) * through + sigma * rng.standard_normal(bench.count)
    bench.accel += rng.uniform(4e-4, 9e-4) * cause
    bench.truth.groups.append({"gauss_markov", "rate_random_walk", "common_cause"})
    bench.truth.extra |= {"low_pass"}
    bench.truth.said = "common cause"


# What the rate is, and no error of the sensor.

def bell(bench, centre, width):
    return np.exp(-0.5 * ((bench.t - centre) / width) ** 2)


def places(bench, number):
    """Instants that keep clear of each other and of the ends."""
    slots = bench.rng.permutation(12)[:number]
    return (slots + bench.rng.uniform(0.3, 0.7, number)) / 12 * bench.t[-1]


def moved(bench, rate_x, rate_y, shake):
    sigma = N / 60 * np.sqrt(bench.rate)
    for axis, rate in zip("xy", (rate_x, rate_y)):
        bench.more[f"gyro_{axis}_dps"] = rate + sigma * bench.rng.standard_normal(bench.count)
    bench.accel += shake * bench.rng.standard_normal((3, bench.count))
    bench.truth.observations.add("motion")
    bench.truth.tolerated |= {"outliers"}


def motion_turned(bench):
    """Turned by hand about the vertical: a few seconds each, with the tremor of the hand."""
    rng, turn, held = bench.rng, np.zeros(bench.count), np.zeros(bench.count)
    for centre in places(bench, rng.integers(2, 6)):
        width = rng.uniform(0.6, 2)
        shape = bell(bench, centre, width)
        turn += bench.sign() * rng.uniform(15, 90) / (width * np.sqrt(2 * np.pi)) * shape
        held += shape
    tremor = band(bench.count, 8 / bench.rate, 2 / bench.rate, rng) * held
    bench.slow += turn + tremor
    moved(bench, 0.05 * turn + 0.5 * tremor, -0.03 * turn + 0.4 * tremor, 0.02 * held)


def motion_touched(bench):
    """The table is leant on and let go: wobbles of a second or three."""
    rng, wobble, held = bench.rng, np.zeros(bench.count), np.zeros(bench.count)
    for centre in places(bench, rng.integers(4, 9)):
        shape = (bench.t >= centre) * np.exp(-np.clip(bench.t - centre, 0, 100) / rng.uniform(0.4, 1.2))
        wobble += rng.uniform(0.4, 3) * shape * np.sin(2 * np.pi * rng.uniform(1, 6) * (bench.t - centre))
        held += shape
    bench.slow += wobble
    moved(bench, 0.5 * wobble, -0.7 * wobble, 0.01 * held)


def motion_tilt(bench):
    """Tilted about the axis that is measured, and nearly back some minutes later: gravity says so. The x axis points up."""
    rng = bench.rng
    there, angle, width = rng.uniform(0.1, 0.5) * bench.t[-1], bench.sign() * rng.uniform(0.3, 1.0), rng.uniform(4, 15)
    back = there + rng.uniform(0.1, 0.3) * bench.t[-1]
    def rise(at):
        return 1 / (1 + np.exp(-np.clip((bench.t - at) / width, -50, 50)))
    course = angle * (rise(there) - rng.uniform(0.7, 1) * rise(back))
    bench.gravity = np.zeros(3)
    bench.accel[:2] += [np.cos(np.radians(course)), np.sin(np.radians(course))]
    bench.slow += np.gradient(course, 1 / bench.rate)
    bench.truth.observations.add("motion")


def wild_samples(bench):
    at = bench.rng.choice(bench.count, bench.rng.integers(3, 30), replace=False)
    bench.slow[at] += bench.rng.uniform(0.6, 5, len(at)) * bench.rng.choice([-1, 1], len(at))
    bench.truth.observations.add("outliers|shocks")
    bench.truth.extra.add("shocks")


# The sensor's own filter.

def counted(bench):
    """Counts that show in the stop band."""
    count = bench.rng.uniform(0.005, 0.03)
    bench.slow = np.round(bench.slow / count) * count
    bench.truth.extra.add("quantization")
    bench.truth.tolerated.add("coarse_counts")


def two_tap_average(bench):
    """The same filter as a bilinear pole at a quarter of the rate: no recording can tell them apart."""
    bench.through(lambda x: signal.lfilter([0.5, 0.5], [1], x))
    bench.hide("moving_average", {"samples": 2}, {"low_pass"})
    if bench.rng.random() < 0.5:
        counted(bench)


def butterworth(bench):
    cutoff = 0.2 * bench.rate
    if bench.rng.random() < 0.5:
        bench.through(lambda x: signal.lfilter(*signal.butter(2, cutoff, fs=bench.rate), x))
    else:  # ahead of the converter: ten times as fast, then every tenth; the white noise above half the rate folds back
        fine = N / 60 * np.sqrt(10 * bench.rate) * bench.rng.standard_normal(10 * bench.count)
        white = signal.lfilter(*signal.butter(2, cutoff, fs=10 * bench.rate), fine)[::10]
        b, a = signal.butter(2, cutoff, fs=bench.rate)
        bench.slow, bench.white = white + signal.lfilter(b, a, bench.slow), np.zeros(bench.count)
    counted(bench)
    bench.hide("low_pass", {"cutoff_hz": cutoff})
    bench.truth.shape["low_pass", "order"] = (2, 2)


def one_pole(bench):
    cutoff = bench.rate * bench.rng.uniform(0.06, 0.2)
    a = np.exp(-2 * np.pi * cutoff / bench.rate)
    bench.through(lambda x: signal.lfilter([1 - a], [1, -a], x))
    bench.hide("low_pass", {"cutoff_hz": cutoff})


def bias_subtracted(bench):
    """The driver subtracts its own running mean: an exponential one, which is a high pass of first order."""
    period = bench.rng.uniform(0.03, 0.12) * bench.t[-1]
    bench.through(lambda x: x - bench.lagged(x, period / (2 * np.pi)))
    bench.hide("high_pass", {"corner_period_s": period})


# Its counts.

def rounded_angle(bench):
    """An integrator's whole counts, each of several times the noise of the angle in a sample."""
    per_sample = N / 60 / np.sqrt(bench.rate)
    count = per_sample * bench.rng.uniform(2, 6)
    bias = bench.rng.uniform(0.02, 0.35) * count * bench.rate
    angle = np.cumsum(np.concatenate([[bench.rng.random() * count], (bench.white + bench.slow + bias) / bench.rate]))
    bench.slow, bench.white = np.diff(np.round(angle / count)) * count * bench.rate, np.zeros(bench.count)
    bench.more["bias"] = 0.0
    bench.truth.kinds["quantization"] = {"coefficient_deg": count / np.sqrt(12)}
    bench.truth.observations.add("coarse_counts|quantization")
    bench.truth.extra.add("quantization")


def rounded_rate(bench):
    sigma = N / 60 * np.sqrt(bench.rate)
    share = bench.rng.uniform(0.22, 1.0)  # noise in counts
    count, bias = sigma / share, bench.rng.uniform(-0.5, 0.5)
    bench.slow = np.round((bench.white + bench.slow + bias) / count) * count
    bench.white, bench.more["bias"] = np.zeros(bench.count), 0.0
    (bench.truth.observations if share < 0.6 else bench.truth.tolerated).add("coarse_counts")


# Its clock.

def held(bench, at):
    """Sample i shows what the sensor had at sample at[i]."""
    bench.slow, bench.white = (bench.white + bench.slow)[at], np.zeros(bench.count)
    bench.accel = bench.accel[:, at]
    bench.truth.observations.add("repeated_samples")


def repeated_each(bench):
    """The host reads twice, or three times, as often as the sensor measures."""
    each = int(bench.rng.integers(2, 4))
    bench.white /= np.sqrt(each)
    held(bench, np.arange(bench.count) // each * each)


def repeated_slower(bench):
    """The sensor's own rate is a little lower than the host's: now and then a sample is read twice."""
    ratio = bench.rng.uniform(0.7, 0.95)
    bench.white *= np.sqrt(ratio)
    held(bench, np.floor(np.floor(np.arange(bench.count) * ratio) / ratio).astype(int))


def repeated_stale(bench):
    """The bus fails at random; the driver answers with the last value."""
    stale = bench.rng.random(bench.count) < bench.rng.uniform(0.05, 0.2)
    stale[0] = False
    held(bench, np.maximum.accumulate(np.where(stale, 0, np.arange(bench.count))))


def jittered_stamps(bench):
    """An even clock; the stamps are of the arrival at a busy host, partly in bunches."""
    late = bench.rng.exponential(bench.rng.uniform(0.2, 1.5) / bench.rate, bench.count)
    bench.stamps = np.maximum.accumulate(bench.t + late) + 1e-5 * np.arange(bench.count) / bench.count
    bench.stamps = np.round(bench.stamps + 1e-6 * np.arange(bench.count), 6)
    bench.truth.observations.add("jitter")


def uneven_clock(bench):
    """The samples themselves come at uneven times, as the stamps say: a line is a line in time, not in samples. First of the ingredients."""
    steps = 1 + 0.3 * bench.rng.uniform(-1, 1, bench.count) + 0.01 * np.sin(2 * np.pi * np.arange(bench.count) / bench.count)
    bench.t = bench.stamps = np.round((np.cumsum(steps) - steps[0]) / bench.rate, 6)
    bench.truth.tolerated.add("jitter")


def lost_samples(bench):
    """3 %, one to five in a row; the stamps tell."""
    lost, mean = np.zeros(bench.count, bool), bench.rng.uniform(1, 5)
    starts = bench.rng.choice(bench.count - 40, int(0.03 * bench.count / mean), replace=False)
    for start, length in zip(starts, bench.rng.geometric(1 / mean, len(starts))):
        lost[start:start + length] = True
    bench.keep = np.flatnonzero(~lost)
    bench.truth.observations.add("lost_samples")


def clipped(bench):
    y = bench.white + bench.slow
    limit = np.quantile(np.abs(y), 1 - bench.rng.uniform(0.003, 0.02))
    bench.slow, bench.white = np.clip(y, -limit, limit), np.zeros(bench.count)
    bench.truth.observations.add("clipped")
    bench.truth.unknown_is_right, bench.truth.covers = True, False


# Nothing there.

def decoys(bench):
    """Columns that move and that the gyro does not follow: bursts of vibration, the sensor set down anew about the other axes, volts, other axes."""
    rng = bench.rng
    for start in rng.uniform(0, 0.85, rng.integers(2, 5)) * bench.t[-1]:
        on = (bench.t >= start) & (bench.t < start + rng.uniform(20, 300))
        bench.accel += rng.uniform(0.02, 0.1) * on * rng.standard_normal((3, bench.count))
    sigma, turns = N / 60 * np.sqrt(bench.rate), np.zeros((2, bench.count))
    for axis, centre in enumerate(rng.uniform(0.1, 0.9, 2) * bench.t[-1]):
        tilt = rng.uniform(0.3, 1.5) / (1 + np.exp(-np.clip((bench.t - centre) / rng.uniform(1, 5), -50, 50)))
        turns[axis] = np.gradient(tilt, 1 / bench.rate)
        bench.accel[1 - axis] += np.sin(np.radians(tilt))
    for axis, turn in zip("xy", turns):
        bench.more[f"gyro_{axis}_dps"] = turn + sigma * rng.standard_normal(bench.count) + flicker_fft(bench.count, B / DEG, rng)
    supply(bench)
    bench.truth.tolerated.add("motion")


def clean(bench):
    bench.truth.clean = True


# name -> (ingredients, rate, seconds)
HOUR = (RATE, SECONDS)
CASES = {
    **{make.__name__: ((make,), *HOUR) for make in (
        temperature_lag, temperature_hysteresis, temperature_squared, supply_voltage, axis_leak, narrow_band, two_tap_average, butterworth,
        temperature_noise, telegraph_three_levels, repeated_each, repeated_slower, repeated_stale, lost_samples, motion_turned, motion_touched,
        motion_tilt, rounded_angle, rounded_rate, common_cause, bias_step, bias_steps, intermittent_line, drifting_line, bias_subtracted,
        warm_up_two, wild_samples, clipped)},
    "jittered_stamps + line": ((line, jittered_stamps), *HOUR),
    "uneven_clock + line": ((uneven_clock, line), *HOUR),
    "clean": ((clean,), *HOUR),
    "clean decoys": ((decoys, clean), *HOUR),
    "clean decoys 200 Hz": ((decoys, clean), 200.0, 1800.0),
    "clean 10 Hz": ((clean,), 10.0, 10800.0),
    "supply_voltage 25 Hz": ((supply_voltage,), 25.0, 7200.0),
    "temperature_lag 10 Hz": ((temperature_lag,), 10.0, 14400.0),
    "narrow_band 200 Hz": ((narrow_band,), 200.0, 1800.0),
    "butterworth 500 Hz": ((butterworth,), 500.0, 600.0),
    "bias_subtracted 1 Hz": ((bias_subtracted,), 1.0, 40000.0),
    "temperature_lag + two lines": ((temperature_lag, two_lines), *HOUR),
    "line + butterworth": ((line, butterworth), *HOUR),
    "narrow_band + temperature": ((narrow_band, temperature), *HOUR),
    "random_walk + one_pole": ((random_walk, one_pole), *HOUR),
    "temperature + rounded_rate": ((temperature, rounded_rate), *HOUR),
    "temperature + rounded_angle": ((temperature, rounded_angle), *HOUR),
    "temperature + motion_turned": ((temperature, motion_turned), *HOUR),
    "line + lost_samples": ((line, lost_samples), *HOUR),
    "narrow_band + two_tap_average": ((narrow_band, two_tap_average), *HOUR),
    "bias_step + temperature": ((bias_step, temperature), *HOUR),
    "telegraph + narrow_band": ((telegraph, narrow_band), *HOUR),
    "supply_voltage + temperature_noise": ((supply_voltage, temperature_noise), *HOUR),
    "intermittent_line + temperature_squared": ((intermittent_line, temperature_squared), *HOUR),
    "narrow_band + temperature_lag + one_pole": ((narrow_band, temperature_lag, one_pole), *HOUR),
}


def case(name, seed, rate=None, seconds=None):
    """(columns, Truth)."""
    ingredients, usual_rate, usual_seconds = CASES[name]
    rng = np.random.default_rng([seed, *name.encode()])
    bench = Bench(rng, rate or usual_rate, seconds or usual_seconds)
    for ingredient in ingredients:
        ingredient(bench)
    columns = bench.columns()
    if bench.truth.covers:
        bench.truth.kinds |= {"angle_random_walk": {"coefficient_deg_per_sqrt_h": N}, "bias_instability": {"coefficient_deg_per_h": B}}
    return columns, bench.truth


def write(columns, path):
    formats = ",".join("%.6f" if name == "time_s" else "%.7g" for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), fmt=formats, header=",".join(columns), comments="")


if __name__ == "__main__":
    write(case(sys.argv[1], int(sys.argv[2]))[0], sys.argv[3])
