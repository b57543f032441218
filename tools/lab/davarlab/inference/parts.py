"""A model in the form that the likelihood works with: parts with shapes, their rows and columns."""

from dataclasses import dataclass, field, replace

import numpy as np

from ..data import counts as counted, signals
from ..effects import table
from . import changes
from .whittle import Data, maximise


@dataclass(frozen=True)
class Part:
    """An effect with its shape; `form` says which variant of the regressor (raw: the effect's own) or decoded states."""
    kind: str
    shape: dict = field(default_factory=dict)
    form: str = "raw"

    @property
    def effect(self):
        return table.find(self.kind)

    @property
    def role(self):
        return "mean" if self.form == "decoded" else "spectrum" if self.effect.role == "states" else self.effect.role

    @property
    def turning(self):
        """A line: its course has a sine and a cosine."""
        return self.kind in ("sinusoid", "intermittent_line")

    @property
    def key(self):
        return (self.kind, self.form, *self.shape.values())

    def moved(self, name, value):
        return replace(self, shape={**self.shape, name: value})


def part_of(term):
    return Part(term.kind, table.find(term.kind).shape_of(term.parameters))


def as_spectra(parts):
    """Decoded states as the noise that they are; None when there are none. The decoded course takes some of the noise with it and leaves
    the doubt about each switch behind, so that what only a spectrum beside it could explain is asked beside this too (6.5)."""
    if all(part.form != "decoded" for part in parts):
        return None
    return [replace(part, form="raw") if part.form == "decoded" else part for part in parts]


class Bench:
    """The recording, cleaned of shocks, with rows and columns for every part that is asked for."""

    def __init__(self, recording, y, counts=None):
        """counts (data/counts.py): of the record as it was logged, `logged`; None: none are known."""
        self.recording, self.y, self.counts, self.logged = recording, y, counts, y
        self.data = Data(y, recording.rate_hz)
        self.decoded, self.squares = {}, {}  # courses of states and their mean squares

    def with_gyro(self, y):
        """The same with another gyro record; what is known of the columns is kept."""
        other = Bench(self.recording, y, self.counts)
        other.logged = self.logged
        other.decoded, other.squares = dict(self.decoded), dict(self.squares)
        other.data.columns.update({key: value for key, value in self.data.columns.items() if key != "gyro"})
        other.data.products = {pair: value for pair, value in self.data.products.items() if "gyro" not in pair}
        other.data.spectra = dict(self.data.spectra)
        return other

    def courses(self, part):
        """The time series of a mean part, size 1."""
        if part.form == "decoded":
            return [self.decoded[part.key]]
        course = part.effect.variants.get(part.form, part.effect.regressor)(self.recording, part.shape)
        if part.turning:
            return [course, part.effect.regressor(self.recording, part.shape, turn=0.25)]
        return [course]

    def keys(self, part):
        count = 2 if part.turning else 1
        keys = [f"{part.key}:{i}" for i in range(count)]
        if keys[0] not in self.data.columns:
            for key, course in zip(keys, self.courses(part)):
                self.data.add(key, course)
        return keys

    def forget(self, part):
        """Frees the columns of a shape that was only tried."""
        for i in range(2):
            key = f"{part.key}:{i}"
            self.data.columns.pop(key, None)
            self.data.products = {pair: value for pair, value in self.data.products.items() if key not in pair}

    def spectrum(self, part, f):
        """Of size 1. Of an angle in counts the error is known, not only where it is white."""
        if part.kind == "quantization" and self.counts and self.counts.of == "angle":
            return self.counts.level(f) * 12 * (self.data.rate_hz / self.counts.q) ** 2
        return part.effect.spectrum(f, self.data.rate_hz, part.shape)

    def row(self, part, gain):
        shape = self.data.binned(part.key, lambda f: self.spectrum(part, f))
        return shape * gain if part.kind == "angle_random_walk" else shape

    def gain(self, parts):
        """What the sensor's low pass leaves of its white noise, per bin."""
        gain = np.ones_like(self.data.f_bin)
        for part in parts:
            if part.role == "filter":
                gain = gain * self.data.binned(
                    part.key, lambda f, part=part: part.effect.spectrum(f, self.data.rate_hz, part.shape))
        return gain

    def rows(self, parts):
        gain = self.gain(parts)
        found = [self.row(part, gain) for part in parts if part.role == "spectrum"]
        return np.array(found) if found else self.row(Part("angle_random_walk"), gain)[None, :]

    def fixed(self, parts):
        """What the counts of a rate add to the level of each bin. Those of an angle are an effect, quantization; where the model has it, it is
        fitted."""
        if self.counts is None or self.counts.of == "angle" or any(part.kind == "quantization" for part in parts):
            return 0.0
        return self.data.binned("counts", self.counts.level)

    def blocks(self, parts, fit):
        """Energies of short blocks of the whitened residual, with what the counts are known to do to them divided out."""
        w, rate = self.residual(parts, fit), self.recording.rate_hz
        return changes.blocks_of(w, rate, counted.relative_variance(self.logged, self.counts, changes.block_length(rate)))

    def all_keys(self, parts):
        return [key for part in parts if part.role == "mean" for key in self.keys(part)]

    def fit(self, parts, restricted=False, near=None):
        """`near`: level of a similar fit to start from."""
        return maximise(self.data, self.rows(parts), self.all_keys(parts), near, restricted, self.fixed(parts))

    def mean_course(self, parts, fit):
        """The sum of the mean parts, deg/s."""
        total, keys = np.zeros(len(self.y)), self.all_keys(parts)
        courses = [course for part in parts if part.role == "mean" for course in self.courses(part)]
        for key, value, course in zip(keys, fit.coefficients, courses):
            scale = self.data.scale(key)
            if scale:
                total += value / scale * (course - course.mean())
        return total

    def residual(self, parts, fit):
        """Whitened residual in time, unit variance when the model is true."""
        c = self.data.whitened(fit.level, fit.coefficients, self.all_keys(parts))
        return signals.inverse(np.concatenate([[0.0], c]))
