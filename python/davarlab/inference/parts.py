"""A model in the form that the likelihood works with: parts with shapes, their rows and columns."""

import copy
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..arrays import Floats
from ..data import counts as counted
from ..data import signals
from ..data.counts import Counts
from ..data.recording import Recording
from ..effects import filters, table
from ..effects.base import Effect, Values, needed
from ..effects.means import TURNING
from ..model import Term
from ..thresholds import FIT
from . import changes
from .changes import Blocks
from .whittle import Data, Fit, maximise

Key = tuple[Hashable, ...]  # of a part: kind, form and shape


@dataclass(frozen=True)
class Part:
    """An effect with its shape; `form` says which variant of the regressor (raw: the effect's own)
    or decoded states."""

    kind: str
    shape: Values = field(default_factory=dict)
    form: str = "raw"

    @property
    def effect(self) -> Effect:
        return table.find(self.kind)

    @property
    def role(self) -> str:
        return (
            "mean"
            if self.form == "decoded"
            else "spectrum"
            if self.effect.role == "states"
            else self.effect.role
        )

    @property
    def turning(self) -> bool:
        """A line: its course has a sine and a cosine."""
        return self.kind in TURNING

    @property
    def behind(self) -> str:
        """The parameter of a filter that says what noise is behind it, when there is some."""
        return self.effect.behind if self.form == "behind" else ""

    @property
    def key(self) -> Key:
        return (self.kind, self.form, *self.shape.values())

    @property
    def any_response(self) -> str:
        """Of a low-pass with any response, as --bandwidth has it; "" for one of the list."""
        response: str = self.shape.get("response", filters.RESPONSES[0])
        return "" if response in filters.RESPONSES else response

    def moved(self, name: str, value: float | str) -> "Part":
        return replace(self, shape={**self.shape, name: value})


def part_of(term: Term) -> Part:
    effect = table.find(term.kind)
    form = "behind" if term.parameters.get(effect.behind) else "raw"
    part = Part(term.kind, effect.shape_of(term.parameters), form)
    if part.any_response:  # it states the order
        shape = {name: value for name, value in part.shape.items() if name != "order"}
        return replace(part, shape=shape)
    return part


def without(parts: Sequence[Part], others: Sequence[Part]) -> list[Part]:
    """The parts that are none of the others, which are told apart from their equals."""
    return [part for part in parts if all(part is not other for other in others)]


def as_spectra(parts: Sequence[Part]) -> list[Part] | None:
    """Decoded states as the noise that they are; None when there are none. The decoded course takes
    some of the noise with it and leaves the doubt about each switch behind, so that what only a
    spectrum beside it could explain is asked beside this too (6.5)."""
    if all(part.form != "decoded" for part in parts):
        return None
    return [replace(part, form="raw") if part.form == "decoded" else part for part in parts]


def unit_spectrum(part: Part, f: Floats, rate_hz: float, counts: Counts | None = None) -> Floats:
    """Of size 1. Of an angle in counts the error is known, not only where it is white."""
    if part.kind == "quantization" and counts and counts.of == "angle":
        return counts.level(f) * 12 * (rate_hz / counts.q) ** 2
    return needed(part.effect.spectrum)(f, rate_hz, part.shape)


def known_level(parts: Sequence[Part], counts: Counts | None) -> Callable[[Floats], Floats] | None:
    """The level of the counts of a rate as a function of the frequency; None where there are none,
    or where the model has its own."""
    if counts is None or counts.of == "angle" or any(part.kind == "quantization" for part in parts):
        return None
    return counts.level


def spectrum_of(
    parts: Sequence[Part],
    sizes: Sequence[float] | Floats,
    rate_hz: float,
    counts: Counts | None = None,
) -> Callable[[Floats], Floats]:
    """The variance of an ordinate as a function of the frequency in Hz: what Bench.rows and these
    sizes give per bin."""
    known = known_level(parts, counts) or np.zeros_like
    # None: a model without noise is white in front of its filters.
    noise: list[Part | None] = [part for part in parts if part.role == "spectrum"]
    noise = [*(noise or [None]), *(part for part in parts if part.behind)]

    def at(f: Floats) -> Floats:
        gain = np.ones_like(f)
        for one in parts:
            if one.role == "filter":
                gain = gain * unit_spectrum(one, f, rate_hz, counts)
        found = known(f)
        for size, part in zip(sizes, noise):
            if not size:
                continue
            if part is None:
                found = found + size * rate_hz * gain
            elif part.behind:
                found = found + size
            else:
                row = unit_spectrum(part, f, rate_hz, counts)
                found = found + size * (row * gain if part.effect.in_front else row)
        return found

    return at


def settling(parts: Sequence[Part]) -> list[Part]:
    """Filters that take their time as the record begins: a mean part of their own."""
    return [part for part in parts if part.role == "filter" and part.effect.regressor]


class Bench:
    """The recording, cleaned of shocks, with rows and columns for every part that is asked for.
    `counts` (data/counts.py): of the record as it was logged, `logged`; None: none are known.
    `gyro`: its column."""

    def __init__(
        self,
        recording: Recording,
        y: Floats,
        counts: Counts | None = None,
        data: Data | None = None,
        gyro: str | None = None,
        logged: Floats | None = None,
    ) -> None:
        self.recording, self.y, self.counts, self.gyro = recording, y, counts, gyro
        self.logged = y if logged is None else logged
        self.data = data or Data(y, recording.rate_hz)
        self.decoded: dict[Key, Floats] = {}  # courses of states
        self.squares: dict[Key, float] = {}  # their mean squares
        # Size of noise that is there and is not fitted.
        self.held: list[tuple[Part, float]] = []
        # Called before each fit that is not known yet; may raise, to give it up.
        self.between: Callable[[], None] = lambda: None
        # What was last worked out of a fit, and of which: as long as the record each.
        self.latest: dict[str, tuple[Fit, Floats]] = {}

    def on(self, y: Floats, data: Data) -> "Bench":
        """The same with another gyro record or other bins."""
        other = copy.copy(self)
        other.y, other.data = y, data
        return other

    def with_gyro(self, y: Floats) -> "Bench":
        """The same with another gyro record; what is known of the columns is kept."""
        other = self.on(y, self.data.with_gyro(y))
        other.decoded, other.squares = dict(self.decoded), dict(self.squares)
        return other

    def asking(self, between: Callable[[], None]) -> "Bench":
        """The same, with `between` called before each fit."""
        other = copy.copy(self)
        other.between = between
        return other

    def resolving(self, parts: Sequence[Part]) -> "Bench":
        """The same with bins that are narrow enough for the narrow bands and the zeros of filters
        among the parts; itself when they are already (1.3)."""
        bands = tuple(band for part in parts for band in self.narrow(part))
        if self.data.resolves(bands):
            return self
        return self.on(self.y, self.data.resolving(bands))

    def narrow(self, part: Part) -> list[tuple[float, float]]:
        """(frequency, half width in Hz) of each peak or zero of a part's spectrum that usual bins
        do not resolve."""
        if part.kind == "narrow_band":
            return [(part.shape["frequency_hz"], part.shape["half_width_hz"])]
        if part.kind != "moving_average":
            return []
        rate = self.data.rate_hz
        width = rate / (2 * np.pi * np.sqrt(self.data.samples))  # (2.3) is about as much there
        return [(f_hz, width) for f_hz in filters.zeros(rate, part.shape)]

    def courses(self, part: Part) -> Iterator[Floats]:
        """The time series of a mean part, or of how a filter settles, size 1; one at a time."""
        if part.form == "decoded":
            yield self.decoded[part.key]
            return
        raw = needed(part.effect.regressor)
        yield part.effect.variants.get(part.form, raw)(self.recording, part.shape)
        if part.turning:
            yield raw(self.recording, part.shape, turn=0.25)

    def keys(self, part: Part) -> list[str]:
        count = 2 if part.turning else 1
        keys = [f"{part.key}:{i}" for i in range(count)]
        if keys[0] not in self.data.columns:
            for key, course in zip(keys, self.courses(part)):
                self.data.add(key, course, self.together(part))
        return keys

    def forget(self, part: Part) -> None:
        """Frees the columns of a shape that was only tried."""
        for i in range(2):
            key = f"{part.key}:{i}"
            self.data.columns.pop(key, None)
            self.data.products = {
                pair: value for pair, value in self.data.products.items() if key not in pair
            }
        if part.form == "decoded":  # another course may have the same shape
            self.data.fits = {
                asked: fit for asked, fit in self.data.fits.items() if part.key not in asked[0]
            }

    def row(self, part: Part, gain: Floats) -> Floats:
        shape = self.data.binned(
            part.key, lambda f: unit_spectrum(part, f, self.data.rate_hz, self.counts)
        )
        return shape * gain if part.effect.in_front else shape

    def gain(self, parts: Sequence[Part]) -> Floats:
        """What the sensor's filters leave of everything in front of them, per bin."""
        gain = np.ones_like(self.data.f_bin)
        for part in parts:
            if part.role == "filter":
                gain = gain * self.data.binned(part.key, partial(self.passed, part))
        return gain

    def passed(self, part: Part, f: Floats) -> Floats:
        """The power gain of a filter at the ordinates of this record."""
        gain = unit_spectrum(part, f, self.data.rate_hz)
        if part.kind != "moving_average":
            return gain
        leaked = filters.leaked(f, self.data.rate_hz, part.shape)
        least = part.shape["samples"] ** -2
        return gain + FIT.settled / self.data.samples * np.maximum(leaked, least)

    def rows(self, parts: Sequence[Part]) -> Floats:
        """One per spectrum, in the order of the parts; then one, white, per filter that says what
        is behind it."""
        gain = self.gain(parts)
        found = [self.row(part, gain) for part in parts if part.role == "spectrum"]
        found = found or [self.row(Part("angle_random_walk"), gain)]
        return np.array(found + [np.ones_like(gain) for part in parts if part.behind])

    def fixed(self, parts: Sequence[Part]) -> Floats | float:
        """What is not fitted of the level of each bin: the counts of a rate (those of an angle are
        an effect, quantization; where the model has it, it is fitted), and noise that is held."""
        known = known_level(parts, self.counts)
        level = self.data.binned("counts", known) if known else 0.0
        return sum((size * self.row(part, self.gain(parts)) for part, size in self.held), level)

    def blocks(self, parts: Sequence[Part], fit: Fit) -> Blocks:
        """Energies of short blocks of the whitened residual, with what the counts are known to do
        to them divided out."""
        w, rate = self.residual(parts, fit), self.recording.rate_hz
        return changes.blocks_of(
            w, rate, counted.relative_variance(self.logged, self.counts, changes.block_length(rate))
        )

    def all_keys(self, parts: Sequence[Part]) -> list[str]:
        """Of the mean parts, in their order; then of how filters settle as the record begins."""
        return [
            key
            for group in ([part for part in parts if part.role == "mean"], settling(parts))
            for part in group
            for key in self.keys(part)
        ]

    def coefficients_of(self, keys: Iterable[str], parts: Sequence[Part], fit: Fit) -> Floats:
        """Those of some of the columns in a fit of the parts."""
        found = dict(zip(self.all_keys(parts), fit.coefficients))
        return np.array([found[key] for key in keys])

    def fit(
        self, parts: Sequence[Part], restricted: bool = False, near: Floats | None = None
    ) -> Fit:
        """The maximum of the likelihood, sought once. `near`: level of a similar fit to start
        from."""
        asked = tuple(part.key for part in parts), restricted
        if asked not in self.data.fits:
            self.between()
            self.data.work.fits += 1
            self.data.fits[asked] = maximise(
                self.data,
                self.rows(parts),
                self.all_keys(parts),
                near,
                restricted,
                self.fixed(parts),
            )
        return self.data.fits[asked]

    def remembered(self, what: str, fit: Fit, make: Callable[[], Floats]) -> Floats:
        """What is worked out of a fit, once as long as nothing else is asked; not to be written
        to."""
        if what not in self.latest or self.latest[what][0] is not fit:
            self.latest[what] = fit, make()
            self.latest[what][1].setflags(write=False)
        return self.latest[what][1]

    def mean_course(self, parts: Sequence[Part], fit: Fit) -> Floats:
        """The sum of the mean parts, deg/s."""
        if not len(fit.coefficients):
            return np.zeros(len(self.y))
        return self.remembered(
            "course",
            fit,
            lambda: signals.in_time(
                self.data.columns["gyro"][0]
                - self.data.without(fit.coefficients, self.all_keys(parts))
            ),
        )

    def together(self, part: Part) -> int:
        """Samples of which the course of a part need only know the mean (1.4)."""
        turn = part.shape["frequency_hz"] * FIT.slow_s if part.kind == "sinusoid" else np.inf
        if part.form == "decoded" or not (part.effect.slow or turn < FIT.slow_turn):
            return 1
        return max(1, min(int(FIT.slow_s * self.data.rate_hz), self.data.samples // FIT.slow_means))

    def whitened(self, parts: Sequence[Part], fit: Fit) -> Floats:
        """Ordinates of the residual, unit variance when the model is true."""
        return self.remembered(
            "whitened",
            fit,
            lambda: self.data.whitened(fit.level, fit.coefficients, self.all_keys(parts)),
        )

    def residual(self, parts: Sequence[Part], fit: Fit) -> Floats:
        """The whitened residual in time, unit variance when the model is true."""
        return self.remembered("residual", fit, lambda: signals.in_time(self.whitened(parts, fit)))
