"""Which measure of noise describes how the angle of a strapdown integration drifts in flight?

    pip install .
    python examples/strapdown/strapdown.py

A craft turns by motion, rotor lines and broad vibration of its airframe, simulated at 8 kHz. Its
gyro adds white noise. The firmware takes 1 kHz, as the mean of eight samples or as every eighth
one, and integrates. All numbers are in deg/sqrt(h), so that equal numbers agree.
"""

import argparse
import warnings
from collections.abc import Callable

import davar
import numpy as np
from numpy.typing import NDArray

FAST_HZ, RATE_HZ, SECONDS = 8000, 1000, 300
EACH = FAST_HZ // RATE_HZ
ARW = 0.5  # of the gyro
LSB = 0.001  # deg/s
TAUS_S = (0.001, 0.01, 0.1, 1.0)
AIRFRAMES = (0.0, 1.0, 30.0)  # broad vibration, variance of a fast sample over the frequencies

Array = NDArray[np.float64]


def bump(f: Array, centre: float, width: float, power: float) -> Array:
    return power * np.exp(-0.5 * ((f - centre) / width) ** 2)


def turning(f: Array, airframe: float) -> Array:
    """The spectrum of the craft's rate, f in Hz, over that of white noise of 1 deg/s."""
    rotors = sum(
        bump(f, c * h, 0.8 * h, 3e3 / h**2) for c in (151, 158, 166, 173) for h in (1, 2, 3)
    )
    motion = 4e6 / (1 + (f / 3) ** 4)
    broad = airframe * np.exp(-(((f - 400) / 250) ** 2))
    return np.asarray(motion + rotors + broad)


def rates(random: np.random.Generator, airframe: float) -> Array:
    count = FAST_HZ * SECONDS
    f = np.fft.rfftfreq(2 * count, 1 / FAST_HZ)
    white = np.fft.rfft(random.normal(size=2 * count))
    return np.asarray(np.fft.irfft(white * np.sqrt(turning(f, airframe)))[:count])


def mean_of(fast: Array) -> Array:
    return np.asarray(fast.reshape(-1, EACH).mean(axis=1))


def every(fast: Array) -> Array:
    return fast[EACH - 1 :: EACH]


TAKES: dict[str, Callable[[Array], Array]] = {"mean of 8": mean_of, "every 8th": every}


def measured(rate_dps: Array, noise: Array, take: Callable[[Array], Array]) -> list[float]:
    """The walk of the angle by the noise, the floor, its limit, and the total noise at TAUS_S."""
    samples = take(rate_dps + noise)
    wrong = np.cumsum(samples) / RATE_HZ - np.cumsum(take(rate_dps)) / RATE_HZ
    drift = 60 * np.std(np.diff(wrong[::RATE_HZ]))
    counts = np.rint(samples / LSB).astype(np.int64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # ARW is withheld next to lines
        options = {"law": "fixed", "stride": 256, "fit_every": 0, "bandwidth": "none"}
        found = davar.dynamic(counts, RATE_HZ, lsb=LSB, floor=True, **options)
    names = ("floor_deg_per_sqrt_h", "floor_high_deg_per_sqrt_h")
    floors = [float(np.nanmedian(found[name])) for name in names]
    total = davar.adev(samples, RATE_HZ, taus_s=TAUS_S)
    return [drift, *floors, *(60 * total.adev * np.sqrt(total.taus_s))]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1)
    random = np.random.default_rng(parser.parse_args().seed)
    head = " ".join(f"{f'{tau:g} s':>7}" for tau in TAUS_S)
    print(
        f"{'airframe':10}{'samples':12}{'gyro':>5}{'drift':>7}{'floor':>7}{'high':>7}  total {head}"
    )
    for airframe in AIRFRAMES:
        rate_dps = rates(random, airframe)
        noise = ARW / 60 * np.sqrt(FAST_HZ) * random.normal(size=len(rate_dps))
        for name, take in TAKES.items():
            drift, floor, high, *total = measured(rate_dps, noise, take)
            shown = " ".join(f"{one:7.1f}" for one in total)
            line = f"{airframe:<10g}{name:12}{ARW:5.2f}{drift:7.2f}{floor:7.2f}{high:7.2f}"
            print(f"{line}        {shown}")


if __name__ == "__main__":
    main()
