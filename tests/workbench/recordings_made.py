"""Recordings for the tests of the workbench, each with a property that is known."""

import math
import random
import struct

from visiting import run

FIRST = (
    '[sensor]\nrate_hz = {rate}\ncolumn = "{column}"\n[[effect]]\nkind = "angle_random_walk"\n'
    "coefficient_deg_per_sqrt_h = 0.3\n"
    '[[effect]]\nkind = "bias_instability"\ncoefficient_deg_per_h = 5.0\n'
)
MODEL = FIRST.format(rate=50.0, column="gyro_z_dps")


def effect(kind, **values):
    """An effect in a model file."""
    lines = [f"{name} = {value!r}" for name, value in values.items()]
    return "\n".join(["[[effect]]", f'kind = "{kind}"', *lines, ""])


def simulated(folder, *effects, seconds=900, seed=8, name="rec.csv"):
    """A gyro at 50 Hz with the noise of MODEL and these effects, from `davarlab simulate`."""
    scenario, path = folder / "scenario.toml", folder / name
    scenario.write_text(
        MODEL + "".join(effects) + f"[simulate]\nseed = {seed}\nduration_s = {seconds}\n"
    )
    done = run("simulate", scenario, "-o", path)
    assert done.returncode == 0, done.stderr
    return path


def model_file(folder, text=MODEL):
    path = folder / "model.toml"
    path.write_text(text)
    return path


def table_of(path):
    """(header, rows) of a recording, as text."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return lines[0], lines[1:]


def written(path, header, rows):
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def noise(path, header, *signals, rows=6000, step=0.02, sigma=0.05, seed=3):
    """White noise in each column after the time; signals: functions of the sample, added to it."""
    rng, signals = random.Random(seed), signals or (lambda i: 0.0,)
    lines = [
        ",".join([f"{i * step:.6g}", *(f"{rng.gauss(0, sigma) + one(i):.6f}" for one in signals)])
        for i in range(rows)
    ]
    return written(path, header, lines)


def two_axes(path, rows=3000, first_missing=None):
    """Two gyro axes: x follows the temperature, z has a line of 1 Hz. From `first_missing` on,
    every third sample is missing.
    """
    rng, lines = random.Random(3), []
    for i in range(rows):
        warm = 25 + 5 * math.sin(i / 400)
        if first_missing is None or i < first_missing or i % 3:
            lines.append(
                f"{i / 50:.2f},{rng.gauss(0, 0.05) + 0.05 * (warm - 25):.6f},"
                f"{rng.gauss(0, 0.05) + 0.02 * math.sin(2 * math.pi * i / 50):.6f},{warm:.3f}"
            )
    return written(path, "time_s,gyro_x_dps,gyro_z_dps,temp_degC", lines)


NAMES = (
    *("timestamp_us", "GyroX [rad/s]", "wz_raw", "accX", "accY", "accZ"),
    *("Temp (C)", "<b>vbat</b>"),
)


def foreign(path, names=NAMES, rows=2000):
    """A log of another program: time in us, a rate in rad/s, counts, m/s^2, a voltage."""
    rng, lines = random.Random(4), []
    for i in range(rows):
        lines.append(
            f"{1_700_000_000_000_000 + 5000 * i};{rng.gauss(0.01, 0.0017):.7f};"
            f"{round(rng.gauss(3, 20))};{rng.gauss(0.1, 0.02):.5f};"
            f"{rng.gauss(0.0, 0.02):.5f};{rng.gauss(9.8, 0.02):.5f};"
            f"{25 + 0.01 * math.sin(i / 300):.3f};{3.7 + i * 1e-5:.5f}"
        )
    return written(path, ";".join(names), lines)


def flight(path, sigmas_dps, rows=2000, short=None):
    """An ArduPilot log of several IMUs at 200 Hz, gyros in rad/s with these standard deviations.
    short: the IMU that stops after 6 samples.
    """

    def named(kind, length, name, form, columns):
        return struct.pack("<BBBBB4s16s64s", 0xA3, 0x95, 0x80, kind, length, name, form, columns)

    rng = random.Random(5)
    out = named(0x80, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns") + named(
        0x81, 24, b"IMU", b"QBfff", b"TimeUS,I,GyrX,GyrY,GyrZ"
    )
    for i in range(rows):
        for one, sigma in enumerate(sigmas_dps):
            if one == short and i >= 6:
                continue
            gyro = (rng.gauss(0, math.radians(sigma)) for _ in range(3))
            out += struct.pack("<BBBQBfff", 0xA3, 0x95, 0x81, 5000 * i, one, *gyro)
    path.write_bytes(out)
    return path


def gimbal(path, rows=12000):
    """A gyro whose bias is 0.06 deg/s times the sine of the angle of a motor, which turns at
    random.
    """
    rng, angle, lines = random.Random(8), 0.0, []
    for i in range(rows):
        angle += rng.gauss(0, 6)
        bias = 0.06 * math.sin(math.radians(angle))
        lines.append(f"{i / 50:.2f},{rng.gauss(bias, 0.05):.6f},{angle:.3f}")
    return written(path, "time_s,gyro_z_dps,motor_deg", lines)


def dead_zone(path):
    """Small rates are all 0, so no model can be fitted."""
    rng, lines = random.Random(5), []
    for i in range(6000):
        x = rng.gauss(0, 0.05) + 0.02 * math.sin(i / 900)
        lines.append(f"{i / 50:.2f},{0.0 if abs(x) < 0.04 else round(x / 0.0002) * 0.0002:.4f}")
    return written(path, "time_s,gyro_z_dps", lines)


def smoothed(path):
    """White noise through a low-pass that nobody declares."""
    rng, smooth, lines = random.Random(1), 0.0, []
    for _ in range(6000):
        smooth += 0.2 * (rng.gauss(0, 1) - smooth)
        lines.append(f"{smooth:.6f}")
    return written(path, "gyro_z_dps", lines)
