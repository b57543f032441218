"""How effects are called where the column is a clock's: white phase noise, flicker frequency noise.

The analysis takes the fractional frequency of a clock, in 1e-9 (ppb), for the rate of a gyro in
deg/s. Its phase, in 1e-9 s, is then the angle. Model files and outputs have the numbers that people
compare with a data sheet: Allan deviations at 1 s, the flicker floor, seconds."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..data.recording import is_clock
from ..tables.constants import PPB
from . import table
from .base import Parameter

FLOOR = 0.664282  # sqrt(2 ln 2 / pi), Allan deviation over B of flicker noise
DAY_H = 24.0


@dataclass(frozen=True)
class Spoken:
    """An effect in the language of clocks. names: parameter -> (name, unit, factor); the number of
    a model file is the factor times the number of the table."""

    kind: str
    physics: str
    confirm: str
    names: Mapping[str, tuple[str, str, float]] = field(default_factory=dict)


SPOKEN = {
    "quantization": Spoken(
        "white_phase_noise",
        "White noise of the phase: the counter or the distribution adds independent errors.",
        "Measure with a better counter. The excess at short tau must fall.",
        {"coefficient_deg": ("std_s", "s", PPB)},
    ),
    "angle_random_walk": Spoken(
        "white_frequency_noise",
        "White noise of the frequency. Its integral is a random walk of the phase.",
        "Record for longer. The Allan deviation falls with slope -1/2.",
        {"coefficient_deg_per_sqrt_h": ("deviation_at_1s", "", PPB / 60)},
    ),
    "bias_instability": Spoken(
        "flicker_frequency_noise",
        "Flicker noise of the oscillator changes the frequency on every time scale.",
        "Record ten times longer. The floor of the Allan deviation stays flat.",
        {"coefficient_deg_per_h": ("floor", "", PPB / 3600 * FLOOR)},
    ),
    "rate_random_walk": Spoken(
        "random_walk_frequency_noise",
        "The frequency does a random walk (environment, ageing).",
        "Repeat the recording at a constant temperature. A random walk differs each time, a drift "
        "is the same.",
        {"coefficient_deg_per_h_per_sqrt_h": ("deviation_at_1s", "", PPB / 216000 / 3**0.5)},
    ),
    "rate_ramp": Spoken(
        "frequency_drift",
        "The frequency drifts linearly, for example by ageing.",
        "Record for longer. The drift continues.",
        {"coefficient_deg_per_h2": ("per_day", "1/day", PPB / 3600 * DAY_H)},
    ),
    "bias_step": Spoken(
        "frequency_step",
        "The frequency jumps once.",
        "Repeat the recording. A step occurs at another time or not at all.",
        {"step_dps": ("step", "", PPB)},
    ),
}


def not_of(column: str) -> set[str]:
    """Kinds that the column cannot have: the filters of a gyro in the record of a clock."""
    filters = {kind for kind, effect in table.TABLE.items() if effect.role == "filter"}
    return filters if is_clock(column) else set()


def as_said(kind: str, parameter: Parameter) -> tuple[Parameter, float]:
    """(the parameter as a clock's model file has it, factor from the number of the table)."""
    spoken = SPOKEN.get(kind)
    if spoken and parameter.name in spoken.names:
        name, unit, factor = spoken.names[parameter.name]
        return replace(parameter, name=name, unit=unit), factor
    unit = parameter.unit.replace("deg/s", "ppb")
    return replace(parameter, name=parameter.name.replace("dps", "ppb"), unit=unit), 1.0
