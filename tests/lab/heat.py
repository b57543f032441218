"""Recordings whose gyro follows a logged column, made with formulas of their own: numpy only,
nothing of davarlab. 50 Hz, one hour.
"""

import numpy as np
from elsewhere import flicker_fft

RATE = 50.0


def late(x, lag_s):
    """A body that follows x, at rest before; Euler's rule in steps of half a second, then straight
    lines.
    """
    step = int(RATE / 2)
    body, found = x[0], []
    for value in x[::step]:
        body += (value - body) * 0.5 / lag_s
        found.append(body)
    return np.interp(np.arange(len(x)), step * (1 + np.arange(len(found))), found)


def loop(x, width):
    """Backlash: x pushes the body along."""
    body, found = x[0], np.empty(len(x))
    for i, value in enumerate(x):
        body = found[i] = min(max(body, value - width / 2), value + width / 2)
    return found


def walk(count, rng):
    x = np.cumsum(rng.standard_normal(count))
    return x - x.mean()


def temperature(how, t, rng):
    if how == "rise":  # after power-on
        return 15 + 12 * (1 - np.exp(-t / 300))
    cycles = {"cycles": 4, "cycle": 1}
    if how in cycles:
        return 25 + 2 * np.sin(2 * np.pi * cycles[how] * t / t[-1] + rng.uniform(0, 6))
    x = walk(len(t), rng)
    return 25 + 3 * x / np.abs(x).max()


def noise(t, rng):
    """ARW 0.3 deg/sqrt(h)."""
    return 0.3 / 60 * np.sqrt(RATE) * rng.standard_normal(len(t))


def flicker(t, rng):
    """Bias instability 5 deg/h."""
    return flicker_fft(len(t), 5 / 3600, rng, 4)


def course(case, heat, t, rng):
    """(what the gyro gets, further columns)."""
    if case == "supply":
        volts = walk(len(t), rng)
        volts *= 0.05 / volts.std()
        return 0.15 * volts, {"supply_V": 5 + volts + 0.002 * rng.standard_normal(len(t))}
    if case == "leak":
        slow = 0.05 * np.sin(2 * np.pi * t / 300)
        other = slow + 0.035 * rng.standard_normal(len(t)) + flicker(t, rng)
        return 0.1 * other, {"gyro_x_dps": other}
    known = {
        "lag": lambda: 0.012 * late(heat, 60),
        "at once": lambda: -0.0015 * heat,
        "hysteresis": lambda: 0.012 * loop(heat, 1.0),
        "square": lambda: 0.004 * (heat - 25) ** 2,
        "walk": lambda: walk(len(t), rng) * 150 / 3600 / 60 / np.sqrt(RATE),
    }
    return known[case]() if case in known else 0 * t, {}


def make(case, how, seed, seconds=3600):
    """Columns of a recording: ARW 0.3 deg/sqrt(h), bias instability 5 deg/h, and the case."""
    rng = np.random.default_rng([seed, 31])
    t = np.arange(int(seconds * RATE)) / RATE
    heat = temperature(how, t, rng)
    white = noise(t, rng)
    if case == "noise":
        white *= np.exp(0.05 * (heat - heat.mean()))
    more, columns = course(case, heat, t, rng)
    return {
        "time_s": t,
        "gyro_z_dps": white + flicker(t, rng) + more + 0.1,
        "temp_degC": heat + 0.02 * rng.standard_normal(len(t)),
    } | columns


def accelerometers(seed, seconds=3600):
    """Columns with a true sensitivity of 0.5 deg/s/g along x, and with a cause behind both sensors
    instead, felt by the gyro later.
    """
    rng, t = np.random.default_rng([seed, 32]), np.arange(int(seconds * RATE)) / RATE
    tilt = [walk(len(t), rng) for _ in "xyz"]
    tilt, cause = [x / x.std() for x in tilt], walk(len(t), rng)
    gyro, cause = noise(t, rng) + flicker(t, rng), cause / cause.std()
    true = {"time_s": t, "gyro_z_dps": gyro + 0.5 * 0.01 * tilt[0]}
    false = {"time_s": t, "gyro_z_dps": gyro + 5 * 0.01 * late(cause, 30)}
    for columns, shared in ((true, None), (false, cause)):
        for axis, own in zip("xyz", tilt):
            felt = 0.01 * own if shared is None else 0.01 * shared + 0.001 * own
            columns[f"accel_{axis}_g"] = felt + 0.002 * rng.standard_normal(len(t))
    return true, false


SECONDS = 1800  # of what follows


def still(seed):
    """A gyro at rest beside the noise of an accelerometer of 2 mg, and a random generator."""
    found, rng = make("none", "walk", seed, SECONDS), np.random.default_rng([seed, 33])
    count = len(found["time_s"])
    return found | {f"accel_{axis}_g": 0.002 * rng.standard_normal(count) for axis in "xyz"}, rng


def tilted(seed, size):
    """Slow tilts of 10 mg."""
    found, rng = still(seed)
    for axis in "xyz":
        tilt = walk(len(found["time_s"]), rng)
        found[f"accel_{axis}_g"] += 0.01 * tilt / tilt.std()
        if axis == "x":
            found["gyro_z_dps"] = found["gyro_z_dps"] + size * 0.01 * tilt / tilt.std()
    return found


def shaken(seed, level, noise=0.0, bias=0.0):
    """Three bursts of white vibration along x. noise: deg/s per g rms; bias: deg/s/g^2."""
    found, rng = still(seed)
    t = found["time_s"] / SECONDS
    on = sum(((t > start) & (t < start + 0.08)).astype(float) for start in (0.15, 0.45, 0.8))
    found["accel_x_g"] = found["accel_x_g"] + level * on * rng.standard_normal(len(t))
    felt = noise * level * on * rng.standard_normal(len(t)) + bias * level**2 * on
    found["gyro_z_dps"] = found["gyro_z_dps"] + felt
    return found


def heated(seed, size):
    found = make("none", "cycles", seed, SECONDS)
    rng, t = np.random.default_rng([seed, 34]), found["time_s"]
    warm = np.sin(2 * np.pi * 4 * t / t[-1] + rng.uniform(0, 6))
    return found | {
        "temp_degC": 25 + warm / max(1.0, size) + 1e-4 * rng.standard_normal(len(t)),
        "gyro_z_dps": found["gyro_z_dps"] + size * warm / max(1.0, size),
    }


def supplied(seed, size, name="supply_V", unit=1.0):
    found, rng = still(seed)
    volts = walk(len(found["time_s"]), rng)
    volts *= 0.05 / volts.std() / max(1.0, size)
    return found | {
        name: (5 + volts + 1e-6 * rng.standard_normal(len(volts))) / unit,
        "gyro_z_dps": found["gyro_z_dps"] + size * volts,
    }
