"""Arrays with names (a MATLAB or NumPy file, the columns of a table): which of them are a gyro's
axes, and what belongs beside them."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ..arrays import Floats, Ints
from ..errors import BadInput
from ..files import StrPath
from ..tables import guess, meaning
from ..tables.guess import Guess
from . import units
from .sensor import Numbers, Samples, Sensor, check_finite

AXIS = re.compile(
    r"(?i:roll|pitch|yaw)|(?<![A-Za-z])[xyz](?=gyr|acc)|[xyz](?![a-z])|[XYZ](?![A-Za-z])"
    r"|(?<![0-9])[012](?![0-9])"
)
RATE = re.compile(
    r"^(fs|rate|rate_hz|sample_rate|sampling_rate|freq|frequency|fsamp|sr)$", re.IGNORECASE
)
TICKS = {unit: round(size * 1e9) for unit, size in guess.SECONDS.items()}  # nanoseconds
# Of a blackbox log: one of the first is chosen.
UNFILTERED, FILTERED = ("gyroUnfilt", "gyroRaw", "gyroRAW"), "gyroADC"
UNKNOWN = " as gyro"  # of an array that may be anything
FOREIGN = ("datetime64", "timedelta64")


@dataclass
class Column:
    """A row or column of an array. name: as it is called from here on; array, place: where it is;
    count: of its numbers."""

    name: str
    array: str
    place: int | None
    count: int


def columns_of(shapes: Mapping[str, Sequence[int]]) -> Iterator[Column]:
    """The columns in arrays of these shapes (name -> shape): vectors as they are, 3 x N and N x 3
    as axes: of a gyro, if their name does not say of what."""
    for name, shape in shapes.items():
        size = [one for one in shape if one != 1]
        if len(size) == 1:
            yield Column(name, name, None, size[0])
        elif len(size) == 2 and min(size) == 3 < max(size):
            stem = name if guess.quantity_of(name) in ("gyro", "accel") else f"{name}{UNKNOWN}"
            yield from (
                Column(f"{stem}_{axis}", name, place, max(size)) for place, axis in enumerate("xyz")
            )


def stem_of(name: str) -> str:
    """A name without its axis, so that those of one sensor are alike."""
    found = [
        match
        for match in AXIS.finditer(guess.without_powers(name))
        if guess.AXES.get(match.group().lower()) == guess.axis_of(name)
    ]
    letters = [match for match in found if not match.group().isdigit()]
    cut = next(iter(letters[-1:] or found[-1:]), None)
    return (name[: cut.start()] + name[cut.end() :] if cut else name).strip(" _.-")


def sets_of(names: Iterable[str], quantity: str) -> dict[str, dict[str, str]]:
    """stem -> {axis: name} of a quantity; one set where no axis is there twice, whatever the
    stems."""
    found: dict[str, dict[str, str]] = {}
    axes: list[str] = []
    for name in names:
        axis = guess.axis_of(name)
        if guess.quantity_of(name) == quantity and axis:
            stem = stem_of(name)
            stem = stem if set(guess.tokens(stem)) - guess.UNIT_WORDS else quantity  # x (rad/s)
            found.setdefault(stem, {}).setdefault(axis, name)
            axes.append(axis)
    if len(found) > 1 and len(set(axes)) == len(axes):
        return {quantity: {axis: name for axes in found.values() for axis, name in axes.items()}}
    return found


def quantities(names: Sequence[str]) -> dict[str, list[str]]:
    """quantity -> names of the numbers: x, y, z of the first whole gyro and accelerometer, and a
    temperature."""
    out = {}
    for quantity in ("gyro", "accel"):
        whole = [axes for axes in sets_of(names, quantity).values() if set(axes) == set("xyz")]
        if whole:
            out[quantity] = [whole[0][axis] for axis in "xyz"]
    temperature = next((name for name in names if guess.quantity_of(name) == "temp"), None)
    return out | ({"temp": [temperature]} if temperature else {})


def words_of(stem: str) -> set[str]:
    """What a name says but the quantity and the unit: the device."""
    return {
        word
        for word in guess.tokens(stem)
        if guess.quantity_of(word) == "other" and word not in guess.UNIT_WORDS
    }


def nearest(stem: str, others: Sequence[str]) -> str | None:
    """The one of other names that speaks of the same device, in a unit where this one does; None
    where two do as well."""
    if len(others) < 2:
        return next(iter(others), None)
    has_unit = {
        name: any(guess.said_unit(name, quantity) for quantity in guess.UNITS)
        for name in (stem, *others)
    }
    shared = sorted(
        (
            (len(words_of(stem) & words_of(other)), has_unit[stem] == has_unit[other], other)
            for other in others
        ),
        reverse=True,
    )
    return shared[0][2] if shared[0][:2] > shared[1][:2] else None


class Log:
    """shapes: name -> shape of the arrays; load(name): one of them; whole: a table, of which every
    column is kept. given: names as the user calls them (--unit NAME=UNIT). origins: name -> what
    the numbers of a column count from. said: how the file was read. stated: sample rates in Hz that
    it states. places: of the samples in a table (sensor.Samples). known: units that it states."""

    def __init__(
        self,
        path: StrPath,
        shapes: Mapping[str, Sequence[int]],
        load: Callable[[str], Any],
        given: Iterable[str],
        what: str,
        whole: bool = False,
        line: int | None = None,
        origins: Mapping[str, int] | None = None,
        said: Sequence[str] = (),
        stated: Sequence[float] = (),
        places: Ints | None = None,
        known: guess.Known | None = None,
    ) -> None:
        self.path, self.load, self.given, self.what, self.whole, self.line, self.origins = (
            path,
            load,
            given,
            what,
            whole,
            line,
            origins or {},
        )
        self.said, self.stated, self.places, self.known = said, stated, places, known or {}
        self.columns = {
            one.name: one
            for one in columns_of(
                {name: shape for name, shape in shapes.items() if not RATE.match(name)}
            )
        }
        self.rates = [
            name for name in shapes if RATE.match(name) and max(shapes[name], default=1) == 1
        ]
        self.gyros = sets_of([name for name, one in self.columns.items() if one.count > 1], "gyro")
        sure = {stem: axes for stem, axes in self.gyros.items() if not stem.endswith(UNKNOWN)}
        self.gyros = sure or self.gyros
        self.accels = sets_of(
            [name for name, one in self.columns.items() if one.count > 1], "accel"
        )
        sets = [("gyro", stem, axes) for stem, axes in self.gyros.items()] + [
            ("accel", stem, axes) for stem, axes in self.accels.items()
        ]
        raw = any(stem.startswith(UNFILTERED) for stem in self.gyros)
        self.sensors = [
            Sensor(
                stem,
                frozenset(["unknown" if stem.endswith(UNKNOWN) else quantity]),
                self.columns[next(iter(axes.values()))].count,
                stem,
                int(raw and stem.startswith(FILTERED) or stem.lower().startswith("filtered")),
            )
            for quantity, stem, axes in sets
        ]

    def picked(self, stem: str) -> list[str]:
        """Names of the columns of a sensor: its axes, its time, and what was measured beside it."""
        axes = self.gyros.get(stem) or self.accels[stem]
        count = self.columns[next(iter(axes.values()))].count
        if self.whole:
            other = {name for axes in self.gyros.values() for name in axes.values()} - set(
                axes.values()
            )
            return [
                name
                for name, one in self.columns.items()
                if one.count == count and name not in other
            ]
        alike = [
            name for name, one in self.columns.items() if one.count == count and one.place is None
        ]
        found = list(axes.values())
        for quantity in ("temp", "time"):
            one = nearest(stem, [name for name in alike if guess.quantity_of(name) == quantity])
            found += [one] if one else []
        beside = nearest(
            stem,
            [
                other
                for other, of in self.accels.items()
                if other != stem and self.columns[next(iter(of.values()))].count == count
            ],
        )
        return found + (list(self.accels[beside].values()) if beside and stem in self.gyros else [])

    def apart(self, stem: str, quantity: str) -> Iterator[tuple[Ints, dict[str, Floats]]]:
        """(stamps, columns) of what was measured beside a gyro at a rate and with a time of its
        own."""
        singles = {
            name: {"": name}
            for name, one in self.columns.items()
            if guess.quantity_of(name) == "temp" and one.count > 1
        }
        sets = self.accels if quantity == "accel" else singles
        best = nearest(stem, list(sets))
        if best is None:
            return
        names = list(sets[best].values())
        time = nearest(
            best,
            [
                name
                for name, one in self.columns.items()
                if guess.quantity_of(name) == "time" and one.count == self.columns[names[0]].count
            ],
        )
        if time:
            found = dressed(
                {
                    name: vector(
                        self.load(self.columns[name].array),
                        self.columns[name],
                        f"{self.path}: {name}",
                    )
                    for name in [*names, time]
                },
                [],
                self.path,
                self.origins,
            )
            assert found.stamps_ns is not None  # a time is among the columns
            yield found.stamps_ns, found.columns

    def concerning(self, columns: Iterable[str]) -> list[str]:
        """The pairs of --unit that concern these columns, or none of the log, which is an error."""
        read, others = called(columns), called(self.columns)
        named = [(pair, pair.partition("=")[0]) for pair in self.given]
        return [pair for pair, name in named if name in read or name not in others]

    def read(self, stem: str) -> Samples:
        columns: dict[str, Numbers] = {}
        last: tuple[str | None, Any] = (None, None)
        for name in self.picked(stem):
            one = self.columns[name]
            last = last if last[0] == one.array else (one.array, self.load(one.array))
            columns[name] = vector(last[1], one, f"{self.path}: {name}")
        rate = float(np.ravel(self.load(self.rates[0]))[0]) if self.rates else None
        stated = self.stated or ([rate] if rate else [])
        given = self.concerning(columns)
        found = dressed(columns, given, self.path, self.origins, stated, self.known)
        if found.stamps_ns is not None and stem in self.gyros:
            found.beside = [
                other
                for quantity in ("accel", "temp")
                if not any(name.startswith(quantity) for name in found.columns)
                for other in self.apart(stem, quantity)
            ]
        found.notes["source"] = f"{self.what}, {stem}"
        found.rate_hz, found.line = rate if found.stamps_ns is None else None, self.line
        found.said, found.places = list(self.said), self.places
        return found


def called(names: Iterable[str]) -> set[str]:
    """How --unit can call these columns."""
    names = list(names)
    return {*names, *map(guess.quantity_of, names)}


def vector(values: Any, column: Column, where: str) -> Numbers:
    """The numbers of one column, of a type that they can be counted in."""
    values = np.squeeze(np.asarray(values))
    if column.place is not None:
        values = values[column.place] if values.shape[0] == 3 else values[:, column.place]
    if values.dtype.name.startswith(FOREIGN):
        found: Numbers = values.astype(f"{values.dtype.name.split('[')[0]}[ns]").astype(np.int64)
        return found
    if values.dtype.kind not in "iufb":
        raise BadInput(f"{where}: no numbers ({values.dtype})")
    found = values
    return found


def with_known(guesses: list[Guess], known: guess.Known) -> list[Guess]:
    for one in guesses:
        units = known.get(one.name) or known.get(one.quantity)
        if units and one.quantity in guess.UNITS:
            (one.unit, one.factor, one.by), one.sure, one.doubt = units, True, ""
    return guesses


def overridden(guesses: list[Guess], given: Iterable[str], path: StrPath) -> list[Guess]:
    """Guesses with what --unit NAME=UNIT says: of a column, or of all of a quantity. A number is a
    factor to deg/s, g, degC or s."""
    for pair in given:
        name, _, unit = pair.partition("=")
        met = [one for one in guesses if name in (one.name, one.quantity)]
        if not met:
            names = ", ".join(one.name for one in guesses)
            raise BadInput(
                f"--unit {pair}: {path} has no such column (there are: {names}; or gyro, accel, "
                "temp, time for all of one kind)"
            )
        for one in met:
            if one.quantity == "other" and unit in guess.SECONDS:
                one.quantity = "time"
            factors = guess.UNITS.get(one.quantity, {})
            try:
                one.unit, one.factor = (
                    (unit, factors[unit]) if unit in factors else ("counts", float(unit))
                )
                one.sure, one.by, one.doubt, one.unused = True, "by --unit", "", ""
            except ValueError:
                raise BadInput(
                    f"--unit {pair}: not a unit of {one.name} (there are: {', '.join(factors)}; or "
                    f"a number, the factor to {next(iter(factors), '1')})"
                ) from None
    return guesses


def dressed(
    columns: dict[str, Numbers],
    given: Iterable[str],
    path: StrPath,
    origins: Mapping[str, int],
    stated: Sequence[float] = (),
    known: guess.Known = MappingProxyType({}),
) -> Samples:
    """Raw columns as Samples in davarlab's names and units, by guesses that can be overridden.
    Columns of no known quantity keep their names. stated: sample rates of the file, in Hz; known:
    units that it states."""
    guesses = meaning.guesses(
        columns, stated, lambda found: overridden(with_known(found, known), given, path)
    )
    there = dict(columns)
    out, stamps = {}, None
    for one in guesses:
        values = columns.pop(one.name)
        if one.quantity == "time" and one.column not in out:
            stamps = nanoseconds(values, one, origins.get(one.name, 0), path)
        else:
            out[column_name(one)] = units.scaled(values, one.factor)
    if stamps is None:
        check_forward(guesses, there, path)
    return Samples(out, stamps, guesses=guesses)


def check_forward(guesses: Iterable[Guess], columns: Mapping[str, Numbers], path: StrPath) -> None:
    """Raises BadInput where a column is a time by its name that does not run forward."""
    for one in guesses:
        if one.quantity == "other" and guess.quantity_of(one.name) == "time":
            back = np.flatnonzero(np.diff(columns[one.name].astype(np.float64)) < 0)
            where = f" at sample {back[0] + 2}" * bool(len(back))
            raise BadInput(f"{path}: column {one.name}: time runs backwards{where}")


def column_name(one: Guess) -> str:
    """Counts that nobody has given a unit stay counts."""
    if one.unit == "counts" and one.factor == 1 and one.quantity == "gyro" and not one.sure:
        return f"gyro_{one.axis}_counts"
    return one.column


def nanoseconds(values: Numbers, one: Guess, origin: int, path: StrPath) -> Ints:
    """Stamps as whole nanoseconds: exact where the log has whole numbers. origin: what they count
    from, in their unit."""
    unit, where = TICKS.get(one.unit), f"{path}: column {one.name}"
    if values.dtype.kind in "iu" and unit:
        return units.nanoseconds(values, unit, where, origin)
    check_finite(values, where)
    units.check_stamps(values, one.factor * 1e9, where, origin)
    return units.nanoseconds(
        np.round(np.asarray(values, np.float64) * one.factor * 1e9), 1, where, origin * (unit or 0)
    )
