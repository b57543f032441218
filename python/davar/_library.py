"""The shared library: its functions with their types, and one run of it."""

import ctypes
import os
import re
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_size_t, c_uint32, c_uint64, c_void_p
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ._types import Floats

SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "new": (c_void_p, ()),
    "free": (None, (c_void_p,)),
    "error": (c_char_p, (c_void_p,)),
    "option": (c_bool, (c_void_p, c_char_p, c_char_p)),
    "configure": (c_bool, (c_void_p, POINTER(c_uint64))),
    "admit": (c_bool, (c_void_p, c_bool, c_void_p, c_size_t, POINTER(c_size_t))),
    "start": (c_bool, (c_void_p, c_double, c_double, c_double)),
    "columns": (c_size_t, (c_void_p,)),
    "column": (c_char_p, (c_void_p, c_size_t)),
    "gap": (None, (c_void_p, c_uint32)),
    "push": (c_size_t, (c_void_p, c_void_p, c_size_t, c_void_p, c_size_t, POINTER(c_size_t))),
    "flush": (c_size_t, (c_void_p, c_void_p, c_size_t)),
    "health": (None, (c_void_p, POINTER(c_uint32))),
}
HEALTH = ("gaps", "missing", "saturated", "not_finite", "restarts", "missed", "cuts", "alarms", "shocks")
FLUSHED = 1024  # rows that are asked for at once
UINT32_MAX = 0xFFFFFFFF


@cache
def library() -> ctypes.CDLL:
    """The library beside this file, or the one that DAVAR_LIBRARY names. Raises ImportError."""
    path = os.environ.get("DAVAR_LIBRARY") or next(map(str, Path(__file__).parent.glob("libdavar_python.*")), "")
    try:
        if not path:
            raise OSError(f"no libdavar_python beside {__file__}")
        found = ctypes.CDLL(path)
    except OSError as why:
        raise ImportError(f"davar: cannot load its library ({why}); install the package: pip install .") from None
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(found, f"davar_python_{name}")
        function.restype, function.argtypes = result, arguments
    return found


def named(text: str) -> str:
    """A message of davar-sim with its options as arguments of Python: --window-max -> window_max."""
    return re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), text)


class Run:
    """One davar_python_t (davar_python.h). Errors are ValueErrors that name the argument."""

    def __init__(self, options: dict[str, str]) -> None:
        self._calls = library()
        self._run = self._calls.davar_python_new()
        if not self._run:
            raise MemoryError
        for name, text in options.items():
            self._check(self._calls.davar_python_option(self._run, name.replace("_", "-").encode(), text.encode()))
        needed = c_uint64()
        self._check(self._calls.davar_python_configure(self._run, byref(needed)))
        self.needed = needed.value
        self.columns: list[str] = []

    def __del__(self) -> None:
        if getattr(self, "_run", None):
            self._calls.davar_python_free(self._run)

    def _check(self, good: bool) -> None:
        if not good:
            raise ValueError(named(self._calls.davar_python_error(self._run).decode()))

    def admit(self, values: Floats, counted: bool) -> int | None:
        """Changes finite float64 values in place to what push takes; the index of one that cannot be taken."""
        bad = c_size_t()
        good = self._calls.davar_python_admit(self._run, counted, values.ctypes.data, len(values), byref(bad))
        return None if good else bad.value

    def reason(self) -> str:
        return named(self._calls.davar_python_error(self._run).decode())

    def start(self, rate_hz: float, low: float, high: float) -> None:
        self._check(self._calls.davar_python_start(self._run, rate_hz, low, high))
        count = self._calls.davar_python_columns(self._run)
        self.columns = [self._calls.davar_python_column(self._run, i).decode() for i in range(count)]

    def gap(self, missing: int) -> None:
        self._calls.davar_python_gap(self._run, min(int(missing), UINT32_MAX))

    def push(self, values: Floats, stride: int) -> list[Floats]:
        """Pieces of rows (rows, columns) that these admitted values complete."""
        pieces, done = [], 0
        while done < len(values):
            rows = np.empty(((len(values) - done) // stride + 4, len(self.columns)))
            taken = c_size_t()
            rest = values[done:]
            written = self._calls.davar_python_push(self._run, rest.ctypes.data, len(rest), rows.ctypes.data, len(rows), byref(taken))
            pieces.append(rows[:written])
            done += taken.value
        return pieces

    def flush(self) -> list[Floats]:
        pieces = []
        while True:
            rows = np.empty((FLUSHED, len(self.columns)))
            written = self._calls.davar_python_flush(self._run, rows.ctypes.data, len(rows))
            pieces.append(rows[:written])
            if written < FLUSHED:
                return pieces

    def health(self) -> dict[str, int]:
        counters = (c_uint32 * len(HEALTH))()
        self._calls.davar_python_health(self._run, counters)
        return dict(zip(HEALTH, counters))
