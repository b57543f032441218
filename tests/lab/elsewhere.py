"""Recordings made with formulas of their own: numpy and scipy only, nothing of davarlab, and where
physics leaves a choice another one than davarlab's simulator (exact AR(1), sums of AR(1),
exponential dwells, analogue poles, real rounding). 50 Hz, gyro, temperature, accelerometer.
`elsewhere.py CASE SEED REC.csv` writes one.
"""

import sys

import numpy as np
from scipy import signal

RATE = 50.0
DEG = 3600.0


def ar1(count, decay, rng):
    """Unit variance, stationary from its first sample."""
    drive = np.sqrt(1 - decay**2) * rng.standard_normal(count)
    return signal.lfilter([1], [1, -decay], drive, zi=[decay * rng.standard_normal()])[0]


def flicker_sum(count, b_dps, rng):
    """Two AR(1) an octave: S(f) = b^2 / (2 pi f) two-sided from below the record's lowest frequency
    to above half the rate.
    """
    times = 2.0 ** np.arange(-7, 16, 0.5)
    return b_dps * sum(
        np.sqrt(np.log(2) * 0.5 / np.pi) * ar1(count, np.exp(-1 / (RATE * t)), rng) for t in times
    )


def flicker_fft(count, b_dps, rng):
    """A circle of eight records, of which one is kept."""
    f = np.fft.rfftfreq(8 * count, 1 / RATE)
    f[0] = f[1]
    return np.fft.irfft(
        np.fft.rfft(rng.standard_normal(8 * count)) * b_dps * np.sqrt(RATE / (2 * np.pi * f)),
        8 * count,
    )[:count]


def flicker_kasdin(count, b_dps, rng):
    """Kasdin's filter of order one half."""
    h = np.cumprod(
        np.concatenate([[1.0], (np.arange(1, 2 * count) - 0.5) / np.arange(1, 2 * count)])
    )
    x = signal.fftconvolve(rng.standard_normal(2 * count), h)[count : 2 * count]
    return b_dps * x


def temperature(time, how, rng):
    span = time[-1]
    if how == "sine":
        return 25 + 2.5 * np.sin(
            2 * np.pi * time / rng.uniform(0.4, 1.1) / span + rng.uniform(0, 6)
        )
    if how == "ramp":
        return 22 + 6 * time / span + 0.3 * np.sin(2 * np.pi * time / 900)
    if how == "walk":
        x = np.cumsum(rng.standard_normal(len(time)))
        return 25 + 3 * x / np.abs(x).max()
    steps = np.repeat(rng.uniform(-4, 4, 8), -(-len(time) // 8))[
        : len(time)
    ]  # a thermal chamber: steps through its time constant
    a = np.exp(-1 / (RATE * 180))
    return 25 + signal.lfilter([1 - a], [1, -a], steps)


def accelerometer(time, rng, how):
    """axis -> (what the sensor body feels, envelope of the vibration in g rms)."""
    found, envelope = {}, np.zeros(len(time))
    for _ in range(rng.integers(3, 7)):
        start, length = rng.uniform(0, time[-1] - 200), rng.uniform(40, 500)
        envelope[(time >= start) & (time < start + length)] = rng.uniform(0.03, 0.12)
    for axis, gravity in zip("xyz", (0.0, 0.0, 1.0)):
        tilt = np.zeros(len(time))
        for _ in range(5):  # set down anew: smooth steps of the tilt
            tilt += rng.uniform(-0.03, 0.03) / (
                1
                + np.exp(-np.clip((time - rng.uniform(0, time[-1])) / rng.uniform(1, 10), -50, 50))
            )
        shake = rng.standard_normal(len(time))
        if how == "band":
            shake = signal.lfilter(*signal.butter(2, [8, 16], "band", fs=RATE), shake)
            shake /= shake.std()
        found[axis] = (gravity + tilt + envelope * shake, envelope)
    return found


def low_passed(white, n_dps, cutoff, how, rng):
    count = len(white)
    if how == "pole":
        a = np.exp(-2 * np.pi * cutoff / RATE)
        return signal.lfilter([1 - a], [1, -a], white)
    if how == "bilinear":
        return signal.lfilter(*signal.butter(1, cutoff, fs=RATE), white)
    if how == "response":
        return np.fft.irfft(
            np.fft.rfft(white) / np.sqrt(1 + (np.fft.rfftfreq(count, 1 / RATE) / cutoff) ** 2),
            count,
        )
    fine = n_dps * np.sqrt(RATE * 10) * rng.standard_normal(count * 10)
    a = np.exp(-2 * np.pi * cutoff / RATE / 10)
    return signal.lfilter([1 - a], [1, -a], fine)[::10]


def make(effects, seed, seconds=7200, n=0.3, b=5.0, **how):
    """(columns) with effects kind -> parameters; `how` chooses among the ways to make a thing."""
    rng = np.random.default_rng([seed, 777])
    count = int(seconds * RATE)
    t = np.arange(count) / RATE
    n_dps = n / 60
    true_temp = temperature(t, how.get("temperature", "walk"), rng)
    logged = true_temp + 0.02 * rng.standard_normal(count)
    if how.get("thermometer") == "slow":  # once a second, counts of 1/16
        logged = np.repeat(np.round(logged[::50] * 16) / 16, 50)[:count]
    felt = accelerometer(t, rng, how.get("vibration", "white"))
    white = n_dps * np.sqrt(RATE) * rng.standard_normal(count)
    if "noise_step" in effects:
        p = effects["noise_step"]
        white = white * np.where((t >= p["start_s"]) & (t < p["stop_s"]), p["ratio"], 1)
    if "low_pass" in effects:
        white = low_passed(
            white, n_dps, effects["low_pass"]["cutoff_hz"], how.get("low_pass", "pole"), rng
        )
    flicker = {"sum": flicker_sum, "fft": flicker_fft, "kasdin": flicker_kasdin}[
        how.get("flicker", "fft")
    ]
    y = white + flicker(count, b / DEG, rng)
    for kind, p in effects.items():
        y = y + course(kind, p, t, true_temp, felt, rng, how)
    if "quantization" in effects:  # the integrator's angle in whole counts, differenced
        step = effects["quantization"]["coefficient_deg"] * np.sqrt(12)
        y = (
            np.diff(
                np.round(np.concatenate([[0], np.cumsum(y / RATE)]) / step + rng.random()) * step
            )
            * RATE
        )
    if how.get("lsb"):
        y = np.round(y / how["lsb"]) * how["lsb"]
    columns = {"time_s": t, "gyro_z_dps": y + how.get("bias", 0.2), "temp_degC": logged}
    return columns | {
        f"accel_{axis}_g": a + 0.002 * rng.standard_normal(count) for axis, (a, _) in felt.items()
    }


def course(kind, p, t, temp, felt, rng, how):
    count = len(t)
    if kind == "rate_random_walk":
        return (
            np.cumsum(rng.standard_normal(count))
            * p["coefficient_deg_per_h_per_sqrt_h"]
            / DEG
            / 60
            / np.sqrt(RATE)
        )
    if kind == "rate_ramp":
        return p["coefficient_deg_per_h2"] / DEG**2 * t
    if kind == "gauss_markov":
        return p["std_dps"] * ar1(count, np.exp(-1 / (RATE * p["correlation_time_s"])), rng)
    if kind == "sinusoid":
        return sum(
            p["amplitude_dps"]
            / k
            * np.sin(2 * np.pi * k * p["frequency_hz"] * t + rng.uniform(0, 6))
            for k in range(1, how.get("harmonics", 1) + 1)
        )
    if kind == "temperature":
        return p["coefficient_dps_per_degC"] * (temp - 25)
    if kind == "temperature_rate":
        return p["coefficient_dps_per_degC_per_s"] * np.gradient(temp, t)
    if kind == "g_sensitivity":
        return p["coefficient_dps_per_g"] * felt[p["axis"]][0]
    if kind == "vibration_noise":
        return p["coefficient_dps_per_g"] * felt[p["axis"]][1] * rng.standard_normal(count)
    if kind == "vibration_rectification":
        return p["coefficient_dps_per_g2"] * felt[p["axis"]][1] ** 2
    if kind == "warm_up":
        return p["amplitude_dps"] * np.exp(-t / p["time_constant_s"])
    if kind == "telegraph_noise":
        switches = np.cumsum(
            rng.exponential(p["mean_dwell_s"], int(10 + 4 * t[-1] / p["mean_dwell_s"]))
        )
        return p["amplitude_dps"] * np.where(np.searchsorted(switches, t) % 2, 1.0, -1.0)
    if kind == "shocks":
        return shocks(p, t, rng, how.get("shocks", "sample"))
    return np.zeros(count)


def shocks(p, t, rng, how):
    y = np.zeros(len(t))
    for place in rng.integers(0, len(t) - 50, rng.poisson(p["rate_per_hour"] * t[-1] / 3600)):
        size = p["amplitude_dps"] * rng.choice([-1, 1])
        if how == "sample":
            y[place] += size
        elif how == "normal":  # sizes scatter, so that some drown
            y[place] += p["amplitude_dps"] * rng.standard_normal()
        else:  # a damped ring of a tenth of a second
            k = np.arange(20)
            y[place : place + 20] += size * np.exp(-k / 4) * np.cos(2 * np.pi * k / 6)
    return y


def axis(rng):
    return str(rng.choice(list("xyz")))


def interval(rng):
    start = rng.uniform(500, 5000)
    return {
        "noise_step": {
            "start_s": start,
            "stop_s": start + rng.uniform(300, 2000),
            "ratio": 1 + rng.uniform(0.4, 1),
        }
    }


WARMTH = "coefficient_dps_per_degC"
# name -> (what is hidden, drawn with a generator; how it is made)
CASES = {
    "clean": (lambda r: {}, {}),
    "clean sum": (lambda r: {}, {"flicker": "sum", "temperature": "sine", "vibration": "band"}),
    "clean kasdin": (
        lambda r: {},
        {"flicker": "kasdin", "temperature": "chamber", "thermometer": "slow"},
    ),
    "clean lsb": (lambda r: {}, {"lsb": 0.01, "temperature": "ramp"}),
    "clean coarse lsb": (lambda r: {}, {"lsb": 0.0625}),
    **{
        f"low_pass {way}": (
            lambda r: {"low_pass": {"cutoff_hz": r.uniform(4, 15)}},
            {"low_pass": way},
        )
        for way in ("pole", "bilinear", "response", "analogue")
    },
    "quantization": (lambda r: {"quantization": {"coefficient_deg": r.uniform(2e-4, 6e-4)}}, {}),
    "rate_random_walk": (
        lambda r: {"rate_random_walk": {"coefficient_deg_per_h_per_sqrt_h": r.uniform(40, 80)}},
        {"flicker": "sum"},
    ),
    "rate_ramp": (
        lambda r: {"rate_ramp": {"coefficient_deg_per_h2": r.uniform(60, 120)}},
        {"temperature": "sine"},
    ),
    "gauss_markov": (
        lambda r: {
            "gauss_markov": {
                "std_dps": r.uniform(0.003, 0.008),
                "correlation_time_s": np.exp(r.uniform(0.7, 4)),
            }
        },
        {"flicker": "kasdin"},
    ),
    "sinusoid": (
        lambda r: {
            "sinusoid": {
                "amplitude_dps": r.uniform(0.002, 0.02),
                "frequency_hz": np.exp(r.uniform(-4, 3)),
            }
        },
        {},
    ),
    **{
        f"temperature {way}": (
            lambda r: {"temperature": {WARMTH: r.uniform(0.008, 0.02)}},
            {"temperature": way},
        )
        for way in ("sine", "ramp", "walk", "chamber")
    },
    "temperature slow": (
        lambda r: {"temperature": {WARMTH: r.uniform(0.008, 0.02)}},
        {"temperature": "chamber", "thermometer": "slow"},
    ),
    "temperature_rate sine": (
        lambda r: {"temperature_rate": {"coefficient_dps_per_degC_per_s": r.uniform(2, 6)}},
        {"temperature": "sine"},
    ),
    "temperature_rate chamber": (
        lambda r: {"temperature_rate": {"coefficient_dps_per_degC_per_s": r.uniform(0.5, 2)}},
        {"temperature": "chamber"},
    ),
    **{
        f"g_sensitivity {way}": (
            lambda r: {
                "g_sensitivity": {"coefficient_dps_per_g": r.uniform(0.3, 1), "axis": axis(r)}
            },
            {"vibration": way},
        )
        for way in ("white", "band")
    },
    **{
        f"vibration_noise {way}": (
            lambda r: {
                "vibration_noise": {"coefficient_dps_per_g": r.uniform(0.4, 1), "axis": axis(r)}
            },
            {"vibration": way},
        )
        for way in ("white", "band")
    },
    **{
        f"vibration_rectification {way}": (
            lambda r: {
                "vibration_rectification": {
                    "coefficient_dps_per_g2": r.uniform(1.5, 6),
                    "axis": axis(r),
                }
            },
            {"vibration": way},
        )
        for way in ("white", "band")
    },
    "warm_up": (
        lambda r: {
            "warm_up": {
                "amplitude_dps": r.uniform(0.03, 0.06),
                "time_constant_s": r.uniform(200, 1200),
            }
        },
        {"flicker": "sum"},
    ),
    "telegraph_noise": (
        lambda r: {
            "telegraph_noise": {
                "amplitude_dps": r.uniform(0.005, 0.01),
                "mean_dwell_s": r.uniform(30, 150),
            }
        },
        {},
    ),
    "telegraph fast": (
        lambda r: {
            "telegraph_noise": {
                "amplitude_dps": r.uniform(0.01, 0.02),
                "mean_dwell_s": r.uniform(3, 10),
            }
        },
        {},
    ),
    "noise_step": (interval, {}),
    **{
        f"shocks {way}": (
            lambda r: {
                "shocks": {"rate_per_hour": r.uniform(8, 40), "amplitude_dps": r.uniform(0.4, 1)}
            },
            {"shocks": way},
        )
        for way in ("sample", "normal", "ring")
    },
    "low_pass pole + rate_ramp": (
        lambda r: {
            "low_pass": {"cutoff_hz": r.uniform(5, 12)},
            "rate_ramp": {"coefficient_deg_per_h2": r.uniform(60, 120)},
        },
        {},
    ),
    "sinusoid fan": (
        lambda r: {"sinusoid": {"amplitude_dps": 0.008, "frequency_hz": r.uniform(1, 6)}},
        {"harmonics": 3},
    ),
    "quantization + temperature": (
        lambda r: {
            "temperature": {WARMTH: 0.015},
            "quantization": {"coefficient_deg": r.uniform(3e-4, 6e-4)},
        },
        {},
    ),
    "low_pass bilinear + gauss_markov": (
        lambda r: {
            "low_pass": {"cutoff_hz": r.uniform(5, 12)},
            "gauss_markov": {"std_dps": 0.006, "correlation_time_s": r.uniform(3, 30)},
        },
        {"low_pass": "bilinear"},
    ),
    "vibration_noise + vibration_rectification": (
        lambda r: {
            "vibration_noise": {"coefficient_dps_per_g": 0.8, "axis": "x"},
            "vibration_rectification": {"coefficient_dps_per_g2": 4.0, "axis": "x"},
        },
        {},
    ),
    "telegraph_noise + temperature": (
        lambda r: {
            "telegraph_noise": {"amplitude_dps": 0.008, "mean_dwell_s": 60.0},
            "temperature": {WARMTH: 0.015},
        },
        {"temperature": "chamber"},
    ),
    "sinusoid + shocks": (
        lambda r: {
            "sinusoid": {"amplitude_dps": 0.01, "frequency_hz": r.uniform(0.05, 10)},
            "shocks": {"rate_per_hour": 20, "amplitude_dps": 0.6},
        },
        {},
    ),
}


def recording(case, seed):
    """(columns, what is hidden, N in deg/sqrt(h), B in deg/h). Of a line with harmonics the first
    is in what is hidden.
    """
    hidden, how = CASES[case]
    number = sum(map(ord, case))
    rng = np.random.default_rng([seed, number])
    n, b = rng.uniform(0.2, 0.4), rng.uniform(2, 8)
    effects = hidden(rng)
    return make(effects, seed * 1000 + number, n=n, b=b, **how), effects, n, b


def write(columns, path):
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        fmt="%.9g",
        delimiter=",",
        header=",".join(columns),
        comments="",
    )


if __name__ == "__main__":
    write(recording(sys.argv[1], int(sys.argv[2]))[0], sys.argv[3])
