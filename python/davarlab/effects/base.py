"""What an effect is. Frequencies in Hz, rates in deg/s, spectra two-sided and times the sample
rate: the variance of one ordinate of the orthonormal cosine transform (DESIGN 1)."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from ..arrays import Floats
from ..data.recording import Recording

INFINITE = float("inf")
# Values of parameters by name. Each Parameter says whether its value is a number or a word.
Values = dict[str, Any]
Spectrum = Callable[[Floats, float, Values], Floats]
Regressor = Callable[..., Floats]
Simulation = Callable[[Recording, Values, np.random.Generator, Floats], Floats]
Grid = Callable[[Recording], Iterable[Any]]
Function = TypeVar("Function")


def needed(function: Function | None) -> Function:
    """A function of an effect whose role requires it."""
    assert function is not None
    return function


def one_name(text: str) -> bool:
    """It can be the name of a column."""
    return set(text).isdisjoint(",\n\r")


@dataclass(frozen=True)
class Parameter:
    """`scale` turns the unit of the model file into deg/s and seconds. `values`: the words that it
    may be, for one that is no number; `form`: of a text, whether it is a good one, beside the
    words; it may raise BadInput to say more; `default`: what it is where a model file does not
    say; `optional`: where it is at the default it stays there, until diagnose finds that the effect
    is missing with it."""

    name: str
    unit: str
    low: float
    high: float
    scale: float = 1.0
    values: tuple[str | int, ...] = ()
    default: float | str | None = None
    form: Callable[[str], bool] | None = None
    optional: bool = False
    whole: bool = False  # a number of things
    searched: bool = False  # found by a search of its own: a fit never moves it


@dataclass(frozen=True)
class Effect:
    """One physical effect. The first parameter is its size, the others its shape (axis: x, y, z).

    role      spectrum   stationary noise; `spectrum(f, rate_hz, shape)` of size 1
              filter     acts on everything in front of it; `spectrum` is its power gain,
                         `regressor`, if any, how it settles
              mean       a known course of time; `regressor(recording, shape)` of size 1
              variance   white noise whose level changes; of an effect of one's own,
                         `regressor` is its standard deviation at every sample, at size 1
              events     isolated outliers
              states     jumps between two levels; `spectrum` of size 1
    grid      shape parameter -> function of the recording that gives the values worth trying
    variants  name -> other regressors of the same effect, tried beside it: what a record cannot say
              of the physics (over how long the body averages), or how much of the noise of a logged
              column is taken out
    slow      of a course: it does not move within half a second
    in_front  is this noise in front of the sensor's filters; that of counts is behind
    behind    of a filter: the parameter that is the standard deviation of white noise behind it,
              deg/s
    sized     False: the first parameter is a shape too
    nothing   the first parameter at which the effect is absent; of a filter there is none
    most      of an effect on a column, in the unit of the first parameter: a larger magnitude is
              not physical (limits.py). By the unit at the end of the name of the column that a
              model file names, else under ""
    simulate  (recording, parameters, rng, white) -> what it adds to the gyro, deg/s; None: from
              spectrum or regressor
    """

    kind: str
    physics: str
    parameters: tuple[Parameter, ...]
    confirm: str
    role: str
    signature: str
    spectrum: Spectrum | None = None
    regressor: Regressor | None = None
    simulate: Simulation | None = None
    grid: dict[str, Grid] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    variants: dict[str, Regressor] = field(default_factory=dict)
    slow: bool = False
    in_front: bool = True
    behind: str = ""
    sized: bool = True
    nothing: float = 0.0
    most: Mapping[str, float] = field(default_factory=dict)

    @property
    def size(self) -> Parameter:
        return self.parameters[0]

    @property
    def shape_names(self) -> list[str]:
        sizes = 0 if self.role == "filter" or not self.sized else 1
        return [
            parameter.name for parameter in self.parameters[sizes:] if parameter.name != self.behind
        ]

    @property
    def forms(self) -> tuple[str, ...]:
        return ("raw", *self.variants)

    def shape_of(self, parameters: Values) -> Values:
        """The shape among parameters; what they do not say is at its default."""
        return {
            p.name: parameters.get(p.name, p.default)
            for p in self.parameters
            if p.name in self.shape_names
        }

    def said(self, shape: Values) -> Values:
        """The shape without what is optional and at its default: a lag of nothing."""
        unsaid = [p.name for p in self.parameters if p.optional and shape.get(p.name) == p.default]
        return {name: value for name, value in shape.items() if name not in unsaid}

    def limit(self, shape: Values) -> float:
        """The largest physical magnitude of the first parameter; infinite where none is known."""
        return self.most.get(shape.get("column", "").rpartition("_")[2], INFINITE)

    def dps(self, parameters: Values) -> float:
        """The size in deg/s."""
        found: float = parameters[self.size.name] * self.size.scale
        return found
