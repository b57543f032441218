"""What the rate is, and no error of the sensor."""

import numpy as np

from .bench import N
from .lines import band


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
        shape = (bench.t >= centre) * np.exp(
            -np.clip(bench.t - centre, 0, 100) / rng.uniform(0.4, 1.2)
        )
        wobble += (
            rng.uniform(0.4, 3) * shape * np.sin(2 * np.pi * rng.uniform(1, 6) * (bench.t - centre))
        )
        held += shape
    bench.slow += wobble
    moved(bench, 0.5 * wobble, -0.7 * wobble, 0.01 * held)


def motion_tilt(bench):
    """Tilted about the axis that is measured, and nearly back some minutes later: gravity says so.
    The x axis points up.
    """
    rng = bench.rng
    there, angle, width = (
        rng.uniform(0.1, 0.5) * bench.t[-1],
        bench.sign() * rng.uniform(0.3, 1.0),
        rng.uniform(4, 15),
    )
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
