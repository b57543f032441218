"""Recordings made with formulas of their own: numpy and scipy only, nothing of davarlab, and where
physics leaves a choice another one than davarlab's simulator (exact AR(1), sums of AR(1),
exponential dwells, real rounding). 50 Hz, gyro, temperature, accelerometer.
"""

import numpy as np
from scipy import signal

RATE = 50.0
DEG = 3600.0
LOG = np.exp  # of the uniform logarithm of a parameter
# kind -> parameter -> the range that it is drawn from, at a size that a person would see
SIZES = {
    "quantization": {"coefficient_deg": (2e-4, 6e-4)},
    "rate_random_walk": {"coefficient_deg_per_h_per_sqrt_h": (40, 80)},
    "rate_ramp": {"coefficient_deg_per_h2": (60, 120)},
    "gauss_markov": {"std_dps": (0.003, 0.008), "correlation_time_s": (0.7, 4, LOG)},
    "sinusoid": {"amplitude_dps": (0.002, 0.02), "frequency_hz": (-4, 3, LOG)},
    "low_pass": {"cutoff_hz": (4, 15)},
    "temperature": {"coefficient_dps_per_degC": (0.008, 0.02)},
    "temperature_rate": {"coefficient_dps_per_degC_per_s": (0.5, 2)},
    "g_sensitivity": {"coefficient_dps_per_g": (0.3, 1.0), "axis": "xyz"},
    "vibration_noise": {"coefficient_dps_per_g": (0.4, 1.0), "axis": "xyz"},
    "vibration_rectification": {"coefficient_dps_per_g2": (1.5, 6), "axis": "xyz"},
    "warm_up": {"amplitude_dps": (0.03, 0.06), "time_constant_s": (200, 1200)},
    "telegraph_noise": {"amplitude_dps": (0.005, 0.01), "mean_dwell_s": (30, 150)},
    "noise_step": {"start_s": (500, 5000), "stop_s": (300, 2000), "ratio": (1.4, 2.0)},
    "shocks": {"rate_per_hour": (8, 40), "amplitude_dps": (0.4, 1.0)},
}


def drawn(ranges, rng):
    """Parameters from their ranges; of a word a letter. A stop comes so much after its start."""
    found = {}
    for name, given in ranges.items():
        if isinstance(given, str):
            found[name] = str(rng.choice(list(given)))
        elif isinstance(given, tuple):
            low, high, *law = given
            found[name] = float(law[0](rng.uniform(low, high)) if law else rng.uniform(low, high))
        else:
            found[name] = given
    if "stop_s" in found:
        found["stop_s"] += found["start_s"]
    return found


def ar1(count, decay, rng):
    """Unit variance, stationary from its first sample."""
    drive = np.sqrt(1 - decay**2) * rng.standard_normal(count)
    return signal.lfilter([1], [1, -decay], drive, zi=[decay * rng.standard_normal()])[0]


def flicker_sum(count, b_dps, rng):
    """Two AR(1) an octave: S(f) = b^2 / (2 pi f) two-sided from below the record's lowest frequency
    to above half the rate.
    """
    size = b_dps * np.sqrt(np.log(2) * 0.5 / np.pi)
    return sum(size * ar1(count, np.exp(-1 / (RATE * 2.0**k)), rng) for k in np.arange(-7, 16, 0.5))


def flicker_fft(count, b_dps, rng, circle=8):
    """A circle of some records, of which one is kept. The rate does not matter."""
    nu = np.fft.rfftfreq(circle * count)
    nu[0] = nu[1]
    white = np.fft.rfft(rng.standard_normal(circle * count))
    return np.fft.irfft(white * b_dps / np.sqrt(2 * np.pi * nu), circle * count)[:count]


def flicker_kasdin(count, b_dps, rng):
    """Kasdin's filter of order one half."""
    k = np.arange(1, 2 * count)
    h = np.cumprod(np.concatenate([[1.0], (k - 0.5) / k]))
    return b_dps * signal.fftconvolve(rng.standard_normal(2 * count), h)[count : 2 * count]


def telegraph(levels, amplitude, dwell, rng, count):
    """Each switch to any of the other levels."""
    time, state, path = np.arange(count) / RATE, int(rng.integers(levels)), []
    switches = np.cumsum(rng.exponential(dwell, int(20 + 4 * time[-1] / dwell)))
    for _ in range(len(switches) + 1):
        path.append(state)
        state = (state + int(rng.integers(1, levels))) % levels
    return amplitude * (2 * np.array(path)[np.searchsorted(switches, time)] - (levels - 1))


def temperature(time, how, rng):
    span = time[-1]
    if how == "sine":
        cycles, phase = 1 / rng.uniform(0.4, 1.1) / span, rng.uniform(0, 6)
        return 25 + 2.5 * np.sin(2 * np.pi * time * cycles + phase)
    if how == "ramp":
        return 22 + 6 * time / span + 0.3 * np.sin(2 * np.pi * time / 900)
    x = np.cumsum(rng.standard_normal(len(time)))
    return 25 + 3 * x / np.abs(x).max()


def accelerometer(time, rng, how):
    """axis -> (what the sensor body feels, envelope of the vibration in g rms)."""
    found, envelope = {}, np.zeros(len(time))
    for _ in range(rng.integers(3, 7)):
        start, length = rng.uniform(0, time[-1] - 200), rng.uniform(40, 500)
        envelope[(time >= start) & (time < start + length)] = rng.uniform(0.03, 0.12)
    for axis, gravity in zip("xyz", (0.0, 0.0, 1.0)):
        tilt = np.zeros(len(time))
        for _ in range(5):  # set down anew: smooth steps of the tilt
            size, at, width = rng.uniform(-0.03, 0.03), rng.uniform(0, time[-1]), rng.uniform(1, 10)
            tilt += size / (1 + np.exp(-np.clip((time - at) / width, -50, 50)))
        shake = rng.standard_normal(len(time))
        if how == "band":
            shake = signal.lfilter(*signal.butter(2, [8, 16], "band", fs=RATE), shake)
            shake /= shake.std()
        found[axis] = (gravity + tilt + envelope * shake, envelope)
    return found


def low_passed(white, cutoff, how):
    if how == "pole":
        a = np.exp(-2 * np.pi * cutoff / RATE)
        return signal.lfilter([1 - a], [1, -a], white)
    if how == "bilinear":
        return signal.lfilter(*signal.butter(1, cutoff, fs=RATE), white)
    response = np.sqrt(1 + (np.fft.rfftfreq(len(white), 1 / RATE) / cutoff) ** 2)
    return np.fft.irfft(np.fft.rfft(white) / response, len(white))


def make(effects, seed, seconds=7200, n=0.3, b=5.0, **how):
    """Columns with effects kind -> parameters; `how` chooses among the ways to make a thing."""
    rng, count = np.random.default_rng([seed, 777]), int(seconds * RATE)
    t = np.arange(count) / RATE
    true_temp = temperature(t, how.get("temperature", "walk"), rng)
    logged = true_temp + 0.02 * rng.standard_normal(count)
    felt = accelerometer(t, rng, how.get("vibration", "white"))
    white = n / 60 * np.sqrt(RATE) * rng.standard_normal(count)
    if "noise_step" in effects:
        p = effects["noise_step"]
        white = white * np.where((t >= p["start_s"]) & (t < p["stop_s"]), p["ratio"], 1)
    if "low_pass" in effects:
        white = low_passed(white, effects["low_pass"]["cutoff_hz"], how.get("low_pass", "pole"))
    flicker = flicker_sum if how.get("flicker") == "sum" else flicker_fft
    y = white + flicker(count, b / DEG, rng)
    for kind, p in effects.items():
        y = y + course(kind, p, t, true_temp, felt, rng, how)
    if "quantization" in effects:  # the integrator's angle in whole counts, differenced
        step = effects["quantization"]["coefficient_deg"] * np.sqrt(12)
        angle = np.concatenate([[0], np.cumsum(y / RATE)])
        y = np.diff(np.round(angle / step + rng.random()) * step) * RATE
    if how.get("lsb"):
        y = np.round(y / how["lsb"]) * how["lsb"]
    columns = {"time_s": t, "gyro_z_dps": y + 0.2, "temp_degC": logged}
    for axis, (a, _) in felt.items():
        columns[f"accel_{axis}_g"] = a + 0.002 * rng.standard_normal(count)
    return columns


SIZE = {  # kind that course() makes -> its parameter that is a factor
    "rate_random_walk": "coefficient_deg_per_h_per_sqrt_h",
    "sinusoid": "amplitude_dps",
    "telegraph_noise": "amplitude_dps",
    "shocks": "amplitude_dps",
    "rate_ramp": "coefficient_deg_per_h2",
    "temperature": "coefficient_dps_per_degC",
    "g_sensitivity": "coefficient_dps_per_g",
    "vibration_noise": "coefficient_dps_per_g",
    "vibration_rectification": "coefficient_dps_per_g2",
    "warm_up": "amplitude_dps",
}


def course(kind, p, t, temp, felt, rng, how):
    """What an effect adds to the rate; nothing here of those that `make` makes."""
    count, axis = len(t), p.get("axis")
    if kind not in SIZE:
        return np.zeros(count)
    size = p[SIZE[kind]]
    if kind == "rate_random_walk":
        return np.cumsum(rng.standard_normal(count)) * size / DEG / 60 / np.sqrt(RATE)
    if kind == "sinusoid":
        turns = 2 * np.pi * p["frequency_hz"] * t
        harmonics = range(1, how.get("harmonics", 1) + 1)
        return sum(size / k * np.sin(k * turns + rng.uniform(0, 6)) for k in harmonics)
    if kind == "telegraph_noise":
        dwell = p["mean_dwell_s"]
        switches = np.cumsum(rng.exponential(dwell, int(10 + 4 * t[-1] / dwell)))
        return size * np.where(np.searchsorted(switches, t) % 2, 1.0, -1.0)
    if kind == "shocks":
        return shocks(p, t, rng, how.get("shocks", "sample"))
    others = {
        "rate_ramp": lambda: size / DEG**2 * t,
        "temperature": lambda: size * (temp - 25),
        "g_sensitivity": lambda: size * felt[axis][0],
        "vibration_noise": lambda: size * felt[axis][1] * rng.standard_normal(count),
        "vibration_rectification": lambda: size * felt[axis][1] ** 2,
        "warm_up": lambda: size * np.exp(-t / p["time_constant_s"]),
    }
    return others[kind]()


def shocks(p, t, rng, how):
    y, k = np.zeros(len(t)), np.arange(20)
    for place in rng.integers(0, len(t) - 50, rng.poisson(p["rate_per_hour"] * t[-1] / 3600)):
        size = p["amplitude_dps"] * rng.choice([-1, 1])
        if how == "sample":
            y[place] += size
        else:  # a damped ring of a tenth of a second
            y[place : place + 20] += size * np.exp(-k / 4) * np.cos(2 * np.pi * k / 6)
    return y


# name -> (kind -> parameters that are not drawn from SIZES; how it is made)
CASES = {
    "clean sum": ({}, {"flicker": "sum", "temperature": "sine", "vibration": "band"}),
    "clean coarse lsb": ({}, {"lsb": 0.0625}),
    "low_pass bilinear": ({"low_pass": {}}, {"low_pass": "bilinear"}),
    "low_pass response": ({"low_pass": {}}, {"low_pass": "response"}),
    "low_pass pole + rate_ramp": ({"low_pass": {"cutoff_hz": (5, 12)}, "rate_ramp": {}}, {}),
    "temperature ramp": ({"temperature": {}}, {"temperature": "ramp"}),
    "g_sensitivity band": ({"g_sensitivity": {}}, {"vibration": "band"}),
    "vibration_noise white": ({"vibration_noise": {}}, {}),
    "vibration_noise band": ({"vibration_noise": {}}, {"vibration": "band"}),
    "vibration_rectification band": ({"vibration_rectification": {}}, {"vibration": "band"}),
    "shocks sample": ({"shocks": {}}, {}),
    "shocks ring": ({"shocks": {}}, {"shocks": "ring"}),
    "quantization": ({"quantization": {}}, {}),
    "rate_random_walk": ({"rate_random_walk": {}}, {"flicker": "sum"}),
    "warm_up": ({"warm_up": {}}, {"flicker": "sum"}),
    "telegraph fast": (
        {"telegraph_noise": {"amplitude_dps": (0.01, 0.02), "mean_dwell_s": (3, 10)}},
        {},
    ),
    "noise_step": ({"noise_step": {}}, {}),
    "sinusoid fan": (
        {"sinusoid": {"amplitude_dps": 0.008, "frequency_hz": (1, 6)}},
        {"harmonics": 3},
    ),
}


def recording(case, seed):
    hidden, how = CASES[case]
    number = sum(map(ord, case))
    rng = np.random.default_rng([seed, number])
    n, b = rng.uniform(0.2, 0.4), rng.uniform(2, 8)
    effects = {kind: drawn(SIZES[kind] | own, rng) for kind, own in hidden.items()}
    return make(effects, seed * 1000 + number, n=n, b=b, **how)
