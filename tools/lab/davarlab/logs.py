"""Other people's log formats, into a recording."""

import numpy as np

from . import recording as recordings
from .errors import BadInput


def renamed(names, mapping, path):
    """`old=new` pairs; new names must carry a unit."""
    for pair in mapping:
        old, equals, new = pair.partition("=")
        if not equals or old not in names:
            raise BadInput(f"--rename {pair}: {path} has no column {old!r} (there are: {', '.join(names)})")
        names = [new if name == old else name for name in names]
    return names


def imported(path, rate_hz, mapping, scales):
    """A CSV with any separator (comma, semicolon, tab) and any names, as a Recording."""
    text = recordings.open_bytes(path).decode("utf-8", errors="replace").replace(";", ",").replace("\t", ",")
    notes, names, line, offset = recordings.split_header(text, path)
    names = renamed(names, mapping, path)
    table = recordings.read_numbers(text[offset:], line, names, path)
    columns = dict(zip(names, np.ascontiguousarray(table.T)))
    for pair in scales:
        name, equals, factor = pair.partition("=")
        try:
            columns[name] = columns[name] * float(factor)
        except (KeyError, ValueError):
            raise BadInput(f"--scale {pair}: no such column, or not a number") from None
    rate, gaps = recordings.clock(columns, rate_hz, path, line)
    return recordings.Recording(columns, rate, str(path), notes, gaps)
