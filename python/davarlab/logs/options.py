"""How a log is to be read, as the options of a command state it."""

from dataclasses import dataclass, field


@dataclass
class Options:
    """How a log is to be read. sensor: the name of one of its sensors; units: NAME=UNIT pairs over
    guesses; renames, scales: OLD=NEW, NAME=FACTOR; types: .msg files; names: of the columns of an
    array without, or of a text, over its own; plain: a CSV as it is, without guesses; as_recorded:
    rate, units and levels are right, however implausible; skip_lines: of a text, at its
    beginning."""

    rate_hz: float | None = None
    sensor: str | None = None
    units: list[str] = field(default_factory=list)
    renames: list[str] = field(default_factory=list)
    scales: list[str] = field(default_factory=list)
    types: list[str] = field(default_factory=list)
    names: list[str] | None = None
    plain: bool = False
    as_recorded: bool = False
    skip_lines: int = 0
