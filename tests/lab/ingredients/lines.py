"""Lines and bands."""

import numpy as np
from elsewhere import ar1

from .bench import RATE


def band(count, nu, half_width, rng):
    """Unit variance about a frequency: an oscillator whose amplitude and phase are kicked. All in
    cycles per sample.
    """
    decay = np.exp(-2 * np.pi * half_width)
    return ar1(count, decay, rng) * np.cos(2 * np.pi * nu * np.arange(count)) + ar1(
        count, decay, rng
    ) * np.sin(2 * np.pi * nu * np.arange(count))


def narrow_band(bench):
    scale = bench.rate / RATE
    f, half_width, std = (
        bench.rng.uniform(17, 38) * scale,
        bench.rng.uniform(0.15, 0.5) * scale,
        bench.rng.uniform(0.02, 0.06),
    )
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
    course = f + moves * (
        u if bench.rng.random() < 0.5 else np.sin(2 * np.pi * u * bench.rng.uniform(0.5, 2)) / 2
    )
    amplitude = bench.rng.uniform(0.02, 0.05)
    bench.slow += amplitude * np.sin(2 * np.pi * np.cumsum(course) / bench.rate)
    bench.truth.groups.append({"drifting_line"})


def drifting_as_it_warms(bench):
    """Fast at first, then slower and slower: a fan or an oscillator after power-on."""
    f, moves = bench.rate * bench.rng.uniform(0.1, 0.35), bench.rng.uniform(0.5, 3)
    course = f - moves * np.expm1(-bench.t / bench.rng.uniform(0.06, 0.3) / bench.t[-1])
    amplitude = bench.rng.uniform(0.02, 0.05)
    bench.slow += amplitude * np.sin(2 * np.pi * np.cumsum(course) / bench.rate)
    bench.truth.groups.append({"drifting_line"})


def low_band(bench):
    """A band where the slope of a low pass begins."""
    scale = bench.rate / RATE
    f, half_width = bench.rng.uniform(8, 30) * scale, bench.rng.uniform(0.15, 0.5) * scale
    std = bench.rng.uniform(0.02, 0.06)
    bench.slow += std * band(bench.count, f / bench.rate, half_width / bench.rate, bench.rng)
    bench.hide("narrow_band", {"std_dps": std, "frequency_hz": f, "half_width_hz": half_width})


def intermittent_line(bench):
    f, amplitude = bench.rate * bench.rng.uniform(0.02, 0.4), bench.rng.uniform(0.01, 0.03)
    length = bench.rng.uniform(0.08, 0.3) * bench.t[-1]
    start = bench.rng.uniform(0.05 * bench.t[-1], 0.95 * bench.t[-1] - length)
    on = (bench.t >= start) & (bench.t < start + length)
    bench.slow += on * amplitude * np.sin(2 * np.pi * f * bench.t + bench.rng.uniform(0, 6))
    bench.hide(
        "intermittent_line",
        {"frequency_hz": f, "amplitude_dps": amplitude, "start_s": start, "stop_s": start + length},
    )
