"""Flies a third-party attitude filter, the EKF of the package ahrs, with four values of the gyro's
noise, and prints how large and how consistent its error is.

    pip install . -r examples/ahrs_flight/requirements.txt
    python examples/ahrs_flight/flight.py

- sheet: the noise of the data sheet.
- tuned: the constant with which other flights of this kind had the least error.
- fed: what davar measured from the samples so far. While davar withholds ARW, the value before.
- truth: the true noise.
"""

import argparse
import warnings
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import NamedTuple

import davar
import numpy as np
from ahrs.filters import EKF
from numpy.typing import NDArray

RATE_HZ = 1000  # of the gyro
STEP = 40  # samples of the gyro per step of the filter
LSB = 1 / 16.4  # deg/s
SHEET_ARW = 0.6  # deg/sqrt(h)
FIELD_NOISE = 0.005  # standard deviation of gravity and magnetic field, which have length 1
SECONDS = 60  # of each regime
FILTERS = ("sheet", "tuned", "fed", "truth")
FACTORS = np.geomspace(1.0, 10.0, 9)  # constants to choose from, over that of the data sheet

Array = NDArray[np.float64]


class Regime(NamedTuple):
    name: str
    noise: float  # white noise over that of the data sheet
    tone_dps: float = 0.0  # amplitude of a rotor tone that wanders from 80 to 90 Hz


REGIMES = (
    Regime("hover", 1.0),
    Regime("climb", 3.0),
    Regime("rough", 8.0),
    Regime("tone", 1.0, 5.0),
    Regime("landing", 1.5),
)
SAMPLES = SECONDS * RATE_HZ * len(REGIMES)


class Flight(NamedTuple):
    """The true attitude and what the filter gets, at its steps; and what davar gets."""

    attitude: Array  # (steps, 4): quaternions from the body to north, east, down
    rate: Array  # (steps, 3): rad/s, the mean since the step before
    gravity: Array  # (steps, 3)
    field: Array  # (steps, 3)
    counts: NDArray[np.int32]  # (samples, 3)


def product(a: Array, b: Array) -> Array:
    """Quaternions (..., 4) times quaternions (..., 4)."""
    w, v, x, u = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    real = w * x - np.sum(v * u, axis=-1, keepdims=True)
    return np.concatenate([real, w * u + x * v + np.cross(v, u)], axis=-1)


def conjugate(q: Array) -> Array:
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def in_body(attitude: Array, vector: Array) -> Array:
    """A fixed vector (3,), seen from the body: (n, 3)."""
    pure = np.broadcast_to(np.concatenate([[0.0], vector]), attitude.shape)
    return product(product(conjugate(attitude), pure), attitude)[:, 1:]


def manoeuvres(noise: np.random.Generator) -> Array:
    """(samples + 1, 4): heading, pitch and roll swing by up to 15 deg, with periods above 15 s."""
    time_s = np.arange(SAMPLES + 1) / RATE_HZ
    attitude = np.broadcast_to(np.eye(4)[0], (SAMPLES + 1, 4))
    for axis in (3, 2, 1):
        half = np.zeros(SAMPLES + 1)
        for _ in range(2):
            wave = 2 * np.pi * (time_s / noise.uniform(15.0, 40.0) + noise.uniform())
            half += np.radians(noise.uniform(1.5, 3.75)) * np.sin(wave)
        turn = np.cos(half)[:, None] * np.eye(4)[0] + np.sin(half)[:, None] * np.eye(4)[axis]
        attitude = product(attitude, turn)
    return attitude


def of_samples(values: Sequence[float]) -> Array:
    """(samples,): one value for each regime."""
    return np.repeat(values, SECONDS * RATE_HZ)


def vibration(noise: np.random.Generator) -> Array:
    """(samples, 3) in deg/s: the white noise of each regime, and its tone."""
    sheet = SHEET_ARW / 60 * np.sqrt(RATE_HZ)
    level = of_samples([regime.noise for regime in REGIMES])[:, None]
    wander = 2 * np.pi * (np.arange(SAMPLES) / RATE_HZ / 13.0 + noise.uniform())
    phase = 2 * np.pi * np.cumsum(85.0 + 5.0 * np.sin(wander)) / RATE_HZ
    tone = of_samples([regime.tone_dps for regime in REGIMES])[:, None]
    of_axes = noise.uniform(0, 2 * np.pi, 3)
    return sheet * level * noise.normal(size=(SAMPLES, 3)) + tone * np.sin(phase[:, None] + of_axes)


def flown(seed: int) -> Flight:
    noise = np.random.default_rng(seed)
    attitude = manoeuvres(noise)
    small = product(conjugate(attitude[:-1]), attitude[1:])[:, 1:]  # half an angle
    rate_dps = np.degrees(2 * small * RATE_HZ)
    counts = np.round((rate_dps + vibration(noise)) / LSB).astype(np.int32)
    here, ekf = attitude[STEP::STEP], new_filter()
    gravity, field = (
        in_body(here, reference) + FIELD_NOISE * noise.normal(size=(len(here), 3))
        for reference in (ekf.a_ref, ekf.m_ref)
    )
    rate = np.radians(counts.reshape(-1, STEP, 3).mean(axis=1) * LSB)
    return Flight(here, rate, gravity, field, counts)


def measured_arw(counts: NDArray[np.int32]) -> Array:
    """(steps,) in deg/sqrt(h): the root mean square of the axes, since the filter takes one value.
    Before the first result, it is that of the data sheet.
    """
    squares = []
    for axis in counts.T:
        epochs = davar.dynamic(axis, RATE_HZ, lsb=LSB, bandwidth="none", law="glr", stride=STEP)
        seen = np.flatnonzero(np.isfinite(epochs.arw_deg_per_sqrt_h))
        steps = np.arange(len(counts) // STEP)
        newest = np.searchsorted(epochs["epoch"][seen], (steps + 1) * STEP - 1, "right") - 1
        known = np.append(epochs.arw_deg_per_sqrt_h[seen], SHEET_ARW)  # the last one is also at -1
        squares.append(known[newest] ** 2)
    return np.sqrt(np.mean(squares, axis=0))


def new_filter() -> EKF:
    ekf = EKF(
        frequency=RATE_HZ / STEP,
        noises=[0.0, FIELD_NOISE**2, FIELD_NOISE**2],
        magnetic_ref=60.0,
        P=np.eye(4) * 1e-6,
    )
    ekf.mag = True  # its updates get a magnetic field
    return ekf


def variance_of(arw: Array) -> Array:
    """Of the mean rate in a step, (rad/s)^2, as davar/kalman.h has it."""
    return (np.radians(arw) / 60) ** 2 * RATE_HZ / STEP


def filtered(flight: Flight, variances: Array) -> Array:
    """(regimes, 2): the mean squared error in rad^2 and NEES / 3, with a variance at each step."""
    ekf, q = new_filter(), flight.attitude[0]
    attitude, covariance = np.empty((len(variances), 4)), np.empty((len(variances), 4, 4))
    for k, variance in enumerate(variances):
        ekf.g_noise = variance
        q = ekf.update(q, flight.rate[k], flight.gravity[k], flight.field[k])
        attitude[k], covariance[k] = q, ekf.P
    wrong = product(conjugate(attitude), flight.attitude)
    error = 2 * wrong[:, 1:, None] * np.sign(wrong[:, :1, None])  # rad, (steps, 3, 1)
    turns = product(attitude[:, None, :], np.eye(4)[1:])  # dq by half an angle of each body axis
    expected = 4 * turns @ covariance @ turns.transpose(0, 2, 1)
    found = np.stack([error * error, error * np.linalg.solve(expected, error) / 3])
    return found.sum(axis=(2, 3)).reshape(2, len(REGIMES), -1).mean(axis=2).T


def constant(factor: float) -> Array:
    return np.full(SAMPLES // STEP, SHEET_ARW * factor)


def errors_of_constants(seed: int) -> list[float]:
    """The mean squared error of a flight with each of FACTORS."""
    flight = flown(seed)
    return [
        float(filtered(flight, variance_of(constant(factor)))[:, 0].mean()) for factor in FACTORS
    ]


def compared(tuned: float, seed: int) -> list[Array]:
    """The results of FILTERS in one flight."""
    flight = flown(seed)
    true = SHEET_ARW * of_samples([regime.noise for regime in REGIMES])[::STEP]
    values = (constant(1.0), constant(tuned), measured_arw(flight.counts), true)
    return [filtered(flight, variance_of(arw)) for arw in values]


def over_truth(squares: Array, of_truth: Array) -> tuple[float, float]:
    """The ratio of rms errors over flights (n,), and its standard error by the jackknife."""
    ratio = np.sqrt(squares.sum() / of_truth.sum())
    without = np.sqrt((squares.sum() - squares) / (of_truth.sum() - of_truth))
    return float(ratio), float(np.std(without) * np.sqrt(len(squares) - 1))


def show(found: Array) -> None:
    """Prints results (flights, filters, regimes, 2)."""
    print(f"{'regime':9}{'noise':7}{'rms deg':>8}  {'over truth':18}{'NEES / 3':>8}")
    for r, regime in enumerate(REGIMES):
        for f, name in enumerate(FILTERS):
            squares, nees = found[:, f, r].T
            ratio, error = over_truth(squares, found[:, 3, r, 0])
            limits = f"[{ratio - 1.96 * error:.3f}, {ratio + 1.96 * error:.3f}]"
            rms = np.degrees(np.sqrt(squares.mean()))
            print(f"{regime.name:9}{name:7}{rms:8.4f}  {ratio:.3f} {limits:16}{nees.mean():6.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--flights", type=int, default=200, help="at least 2 (default 200)")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=None, help="processes (default: all cores)")
    options = parser.parse_args()
    if options.flights < 2:
        parser.error("--flights: at least 2")
    warnings.simplefilter("ignore")  # davar warns that it withholds ARW in the tone
    seeds = range(options.first_seed, options.first_seed + options.flights)
    others = range(seeds.stop, seeds.stop + max(2, options.flights // 20))
    with ProcessPoolExecutor(options.jobs) as pool:
        by_constant = np.sum(list(pool.map(errors_of_constants, others)), axis=0)
        tuned = float(FACTORS[np.argmin(by_constant)])
        found = np.array(list(pool.map(partial(compared, tuned), seeds)))
    print(f"{len(seeds)} flights; the constant in hindsight is {tuned:.1f} times the data sheet")
    show(found)


if __name__ == "__main__":
    main()
