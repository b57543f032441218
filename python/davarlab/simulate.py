"""Makes a recording from listed effects and from columns that wander whether the gyro feels them or
not."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from . import model as models
from .arrays import Floats
from .data import signals
from .data.recording import MINIMUM_SAMPLES, Recording
from .effects import spectra, table
from .effects.base import needed
from .effects.columns import FOLLOWING
from .effects.means import TURNING
from .errors import BadInput
from .files import StrPath
from .model import Term
from .tables import table as tables

SAMPLES_MAX = 10**8  # 6 GB
DEFAULTS: dict[str, float] = {
    "duration_s": 7200.0,
    "seed": 1,
    "vibration_g": 0.05,
    "tilt_g": 0.01,
    "temperature_degC": 3.0,
}


def wandering_temperature(time: Floats, span: float, rng: np.random.Generator) -> Floats:
    """Warm-up of the box, a slow wave of the room, a random walk; then the thermometer's noise and
    its count of 0.01."""
    warm = -rng.uniform(0.3, 1) * span * np.exp(-time / rng.uniform(300, 2500))
    room = (
        rng.uniform(0.1, 0.5)
        * span
        * np.sin(2 * np.pi * time / rng.uniform(2000, 6000) + rng.uniform(0, 6))
    )
    walk = np.cumsum(rng.standard_normal(len(time)))
    walk *= 0.2 * span / max(float(np.std(walk)), 1e-12)
    found: Floats = np.round(25 + warm + room + walk + 0.02 * rng.standard_normal(len(time)), 2)
    return found


def vibration_envelope(time: Floats, size: float, rng: np.random.Generator) -> Floats:
    """Bursts of some minutes with soft edges."""
    envelope: Floats = np.zeros(len(time))
    for _ in range(rng.integers(3, 8)):
        start, length = rng.uniform(0, time[-1]), rng.uniform(60, 600)
        edge = rng.uniform(2, 20)
        gate = (
            1
            / (1 + np.exp(np.clip(-(time - start) / edge, -50, 50)))
            / (1 + np.exp(np.clip((time - start - length) / edge, -50, 50)))
        )
        envelope = np.maximum(envelope, size * rng.uniform(0.5, 1.5) * gate)
    return envelope


def wandering_column(name: str, time: Floats, seed: int) -> Floats:
    """A column for an effect that follows one, drawn apart from the others: another gyro axis that
    is turned slowly to and fro, or a quantity about 5 that wanders by 0.1."""
    rng = np.random.default_rng([seed, *name.encode()])
    walk = np.cumsum(rng.standard_normal(len(time)))
    walk /= max(float(np.std(walk)), 1e-12)
    wave = np.sin(2 * np.pi * time / rng.uniform(100, 1500) + rng.uniform(0, 6))
    noise = rng.standard_normal(len(time))
    if name.startswith("gyro_"):
        found: Floats = 0.1 * wave + 0.05 * (walk - walk.mean()) + 0.03 * noise
        return found
    found = np.round(5 + 0.1 * (wave + 0.5 * (walk - walk.mean())) + 0.005 * noise, 3)
    return found


def accelerometer(
    time: Floats, gravity: float, settings: Mapping[str, float], rng: np.random.Generator
) -> Floats:
    tilt = np.cumsum(rng.standard_normal(len(time)))
    tilt *= settings["tilt_g"] / max(float(np.std(tilt)), 1e-12)
    shake = vibration_envelope(time, settings["vibration_g"], rng) * rng.standard_normal(len(time))
    found: Floats = gravity + tilt - tilt.mean() + shake + 0.002 * rng.standard_normal(len(time))
    return found


def contribution(
    term: Term, recording: Recording, rng: np.random.Generator, white: Floats
) -> Floats:
    """What one effect adds to the gyro, deg/s."""
    effect, parameters = table.find(term.kind), term.parameters
    if effect.simulate:
        return effect.simulate(recording, parameters, rng, white)
    if effect.role == "mean":
        regressor = needed(effect.regressor)
        course = effect.dps(parameters) * regressor(recording, effect.shape_of(parameters))
        return course if term.kind in TURNING else course - course.mean()
    if effect.role == "variance":
        deviation = needed(effect.regressor)(recording, effect.shape_of(parameters))
        return effect.dps(parameters) * deviation * rng.standard_normal(recording.samples)
    spectrum = needed(effect.spectrum)
    return effect.dps(parameters) * spectra.from_spectrum(
        lambda f: spectrum(f, recording.rate_hz, parameters),
        recording.samples,
        recording.rate_hz,
        rng,
    )


def in_front(term: Term) -> bool:
    """Is the effect in front of the sensor's filters: all but counts and single wild samples
    are."""
    effect = table.find(term.kind)
    return effect.in_front and effect.role != "events"


def white_noise(terms: Sequence[Term], recording: Recording, rng: np.random.Generator) -> Floats:
    size = np.sqrt(
        sum(
            table.find(t.kind).dps(t.parameters) ** 2
            for t in terms
            if t.kind == "angle_random_walk"
        )
    )
    found: Floats = size * np.sqrt(recording.rate_hz) * rng.standard_normal(recording.samples)
    return found


def behind_filters(
    terms: Sequence[Term], gyro: Floats, recording: Recording, rng: np.random.Generator
) -> Floats:
    """What the sensor's filters leave of the gyro, and the noise behind them."""
    filters = [
        (table.find(term.kind), term.parameters)
        for term in terms
        if table.find(term.kind).role == "filter"
    ]
    if not filters:
        return gyro
    f = np.concatenate([[0.0], signals.frequencies(len(gyro), recording.rate_hz)])
    gain = np.prod(
        [
            needed(effect.spectrum)(f, recording.rate_hz, effect.shape_of(values))
            for effect, values in filters
        ],
        axis=0,
    )
    noise = np.sqrt(sum(values.get(effect.behind, 0.0) ** 2 for effect, values in filters))
    found = signals.inverse(signals.transform(gyro) * np.sqrt(gain))
    return found + noise * rng.standard_normal(len(gyro)) if noise else found


def make(
    terms: Sequence[Term], rate_hz: float, column: str = "gyro_z_dps", **settings: float
) -> Recording:
    """A Recording with time, the gyro column, a temperature and three accelerometer columns.
    Seeded."""
    settings = {**DEFAULTS, **settings}
    rng = np.random.default_rng(int(settings["seed"]))
    time = np.arange(int(settings["duration_s"] * rate_hz)) / rate_hz
    columns = {
        "time_s": time,
        column: np.zeros(len(time)),
        "temp_degC": wandering_temperature(time, settings["temperature_degC"], rng),
    }
    for axis, gravity in zip("xyz", (0.0, 0.0, 1.0)):
        columns[f"accel_{axis}_g"] = accelerometer(time, gravity, settings, rng)
    for name in dict.fromkeys(
        term.parameters["column"] for term in terms if term.kind in FOLLOWING
    ):
        if name not in columns:
            columns[name] = wandering_column(name, time, int(settings["seed"]))
    recording = Recording(columns, rate_hz, notes={"description": "SIMULATED by davarlab"})
    gyro = white = white_noise(terms, recording, rng)
    others = [
        term
        for term in terms
        if term.kind != "angle_random_walk" and table.find(term.kind).role != "filter"
    ]
    front, rest = (
        [term for term in others if in_front(term) == wanted] for wanted in (True, False)
    )
    for term in front:
        gyro = gyro + contribution(term, recording, rng, white)
    gyro = behind_filters(terms, gyro, recording, rng)
    for term in rest:
        gyro = gyro + contribution(term, recording, rng, white)
    columns[column] = gyro + rng.uniform(-0.5, 0.5)
    return recording


def defaulted(data: dict[str, Any], path: StrPath) -> dict[str, Any]:
    """A scenario need not say its column."""
    return {**data, "sensor": {"column": "gyro_z_dps", **models.table_in(data, "sensor", path)}}


def from_scenario(path: StrPath, progress: Callable[[str], None]) -> Recording:
    """SCENARIO.toml: a model file with a further table [simulate] (duration_s, seed, vibration_g,
    ...)."""
    data = models.load_toml(path)
    settings = models.table_in(data, "simulate", path)
    for name, value in settings.items():
        if name not in DEFAULTS:
            raise BadInput(f"{path}: [simulate] has no {name} (it has: {', '.join(DEFAULTS)})")
        if (
            isinstance(value, bool)
            or not isinstance(value, (int, float))
            or not 0 <= value < models.HUGE
        ):
            raise BadInput(f"{path}: [simulate] {name} must be a number, 0 or more")
    if settings.get("seed", 0) % 1:
        raise BadInput(f"{path}: [simulate] seed must be a whole number")
    model = models.from_toml(defaulted(data, path), path)
    if not tables.is_name(model.column):
        raise BadInput(
            f"{path}: [sensor] column: not a name that a recording holds: {model.column!r}"
        )
    if not model.rate_hz:
        raise BadInput(f"{path}: [sensor] needs rate_hz")
    samples = settings.get("duration_s", DEFAULTS["duration_s"]) * model.rate_hz
    if not MINIMUM_SAMPLES <= samples <= SAMPLES_MAX:
        raise BadInput(
            f"{path}: [simulate] duration_s: {samples:.6g} samples; {MINIMUM_SAMPLES} to "
            f"{SAMPLES_MAX:g} can be made"
        )
    if "simulate" not in data:
        said = ", ".join(f"{name} = {value:g}" for name, value in DEFAULTS.items())
        progress(f"{path} has no table [simulate]: taken as {said}")
    return make(model.terms, float(model.rate_hz), model.column, **settings)
