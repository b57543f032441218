"""Other people's log formats, into a recording."""

import contextlib
import math


from ..errors import BadInput
from . import recording as recordings
from . import table


def renamed(names, mapping, path):
    """`old=new` pairs; new names must carry a unit."""
    for pair in mapping:
        old, equals, new = pair.partition("=")
        if not equals or old not in names:
            raise BadInput(f"--rename {pair}: {path} has no column {old!r} (there are: {', '.join(names)})")
        if new in names and new != old:
            raise BadInput(f"--rename {pair}: {path} has a column {new} already")
        if not new or not set(new).isdisjoint(",\n\r") or new != new.strip():
            raise BadInput(f"--rename {pair}: not a name for a column")
        names = [new if name == old else name for name in names]
    return names


def factor_of(pair, names):
    """A `NAME=FACTOR` pair of --scale."""
    name, _, factor = pair.partition("=")
    if name not in names:
        raise BadInput(f"--scale {pair}: no column {name!r} (there are: {', '.join(names)})")
    with contextlib.suppress(ValueError):
        if float(factor) and math.isfinite(float(factor)):
            return name, float(factor)
    raise BadInput(f"--scale {pair}: a finite factor other than 0 expected")


def imported(path, rate_hz, mapping, scales):
    """A CSV with any separator (comma, semicolon, tab) and any names, as a Recording."""
    notes, columns, line = table.read(path, ";\t,", lambda names, where: renamed(names, mapping, where))
    for pair in scales:
        name, factor = factor_of(pair, columns)
        columns[name] = columns[name] * factor
    return recordings.of_columns(columns, rate_hz, path, notes, line)
