"""The shared library: its functions with their types, and one run of it."""

import ctypes
import os
import re
from ctypes import (
    POINTER,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_size_t,
    c_uint8,
    c_uint32,
    c_uint64,
    c_void_p,
    create_string_buffer,
)
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._types import Floats

SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "new": (c_void_p, ()),
    "free": (None, (c_void_p,)),
    "error": (c_char_p, (c_void_p,)),
    "option": (c_bool, (c_void_p, c_char_p, c_char_p)),
    "configure": (c_bool, (c_void_p, POINTER(c_uint64))),
    "admit": (c_bool, (c_void_p, c_bool, c_void_p, c_size_t, POINTER(c_size_t))),
    "torn": (c_size_t, (c_void_p, c_size_t, c_void_p, c_void_p)),
    "model": (c_bool, (c_void_p, c_void_p, c_void_p, c_void_p, c_size_t)),
    "learn": (c_bool, (c_void_p, c_void_p, c_size_t, c_void_p, c_char_p, c_size_t)),
    "start": (c_bool, (c_void_p, c_double, c_double, c_double)),
    "columns": (c_size_t, (c_void_p,)),
    "column": (c_char_p, (c_void_p, c_size_t)),
    "gap": (None, (c_void_p, c_uint32)),
    "push": (
        c_size_t,
        (c_void_p, c_void_p, c_size_t, c_void_p, c_size_t, c_size_t, POINTER(c_size_t)),
    ),
    "flush": (c_size_t, (c_void_p, c_void_p, c_size_t, c_size_t)),
    "slide": (
        c_size_t,
        (c_void_p, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t, c_size_t),
    ),
    "adev": (
        c_bool,
        (c_void_p, c_size_t, c_double, c_double, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p),
    ),
    "intervals": (c_bool, (c_void_p, c_void_p, c_uint8, c_uint32, c_double, c_double, c_void_p)),
    "taus": (c_uint8, (c_uint32, c_uint8, c_void_p)),
    "health": (None, (c_void_p, POINTER(c_uint32))),
}
HEALTH = (
    "gaps",
    "missing",
    "saturated",
    "not_finite",
    "restarts",
    "missed",
    "cuts",
    "alarms",
    "shocks",
)
FLUSHED = 1 << 10  # rows of a table, if the end of the record needs another one
FILTER_SIZE = 512
TAUS_MAX = 32
PARTS = 64  # of a record (record.c)
# Of one call, a third of a second: Ctrl-C waits for its end.
PIECE = 1 << 28  # differences
PUSHED = 1 << 17  # samples with a fit after each
UINT32_MAX = 0xFFFFFFFF


@cache
def calls() -> ctypes.CDLL:
    """Loads the library from DAVAR_LIBRARY, from this folder, or from the build of a checkout.
    Raises ImportError."""
    here = Path(__file__).resolve().parent
    folders = here, here.parents[1] / "build/tools/python"
    built = (str(one) for folder in folders for one in folder.glob("libdavar_python.*"))
    path = os.environ.get("DAVAR_LIBRARY") or next(built, "")
    try:
        if not path:
            raise OSError(f"no libdavar_python in {' or '.join(map(str, folders))}")
        found = ctypes.CDLL(path)
    except OSError as why:
        raise ImportError(
            f"davar: cannot load its library ({why}); install the package: pip install ."
        ) from None
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(found, f"davar_python_{name}")
        function.restype, function.argtypes = result, arguments
    return found


def named(text: str, taus: str = "taus") -> str:
    """A message of davar-sim with Python arguments for options: --window-max -> window_max, --rate
    -> rate_hz, --longest-tau -> longest_tau_s, --taus -> `taus`.
    """
    names = {"rate": "rate_hz", "taus": taus, "longest-tau": "longest_tau_s"}
    return re.sub(
        r"--([a-z][a-z-]*)", lambda option: names.get(option[1], option[1].replace("-", "_")), text
    )


class Run:
    """One davar_python_t (davar_python.h). Errors are ValueErrors with the name of the argument.
    taus: the argument that set the cluster sizes.
    """

    def __init__(self, options: dict[str, str], taus: str = "taus") -> None:
        self._calls, self._taus = calls(), taus
        self._run = self._calls.davar_python_new()
        if not self._run:
            raise MemoryError
        for name, text in options.items():
            option = name.removesuffix("_s").replace("_", "-")
            self._check(self._calls.davar_python_option(self._run, option.encode(), text.encode()))
        needed = c_uint64()
        self._check(self._calls.davar_python_configure(self._run, byref(needed)))
        self.needed = needed.value
        self.columns: list[str] = []
        self._tables: list[Floats] = []  # waiting rows; only the last table has room for more
        self._used = 0  # rows of the last table

    def __del__(self) -> None:
        if getattr(self, "_run", None):
            self._calls.davar_python_free(self._run)

    def __reduce__(self) -> str:
        raise TypeError("davar: a run with samples cannot be copied or pickled")

    def _check(self, good: bool) -> None:
        if not good:
            raise ValueError(self.reason())

    def admit(self, values: Floats, counted: bool) -> int | None:
        """Converts finite float64 values in place to the input of push. Returns the index of the
        first bad one.
        """
        bad = c_size_t()
        good = self._calls.davar_python_admit(
            self._run, counted, values.ctypes.data, len(values), byref(bad)
        )
        return None if good else bad.value

    def reason(self) -> str:
        return named(self._calls.davar_python_error(self._run).decode(), self._taus)

    def model(self, m: npt.NDArray[np.uint32], adev_dps: Floats, tolerance: Floats) -> None:
        """Compares every result with this table of an error model. Call it before start."""
        self._check(
            self._calls.davar_python_model(
                self._run, m.ctypes.data, adev_dps.ctypes.data, tolerance.ctypes.data, len(m)
            )
        )

    def learn(self, values: Floats, ends: npt.NDArray[np.uintp]) -> str | None:
        """Learns the filter from all admitted values (option bandwidth "auto"; before start). ends:
        of the runs without a gap. Returns it as a value of bandwidth; None: unknown.
        """
        found = create_string_buffer(FILTER_SIZE)
        self._check(
            self._calls.davar_python_learn(
                self._run,
                values.ctypes.data,
                len(values),
                ends.ctypes.data,
                found,
                FILTER_SIZE,
            )
        )
        return found.value.decode() or None

    def start(self, rate_hz: float, low: float, high: float) -> None:
        self._check(self._calls.davar_python_start(self._run, rate_hz, low, high))
        count = self._calls.davar_python_columns(self._run)
        self.columns = [
            self._calls.davar_python_column(self._run, i).decode() for i in range(count)
        ]

    def gap(self, missing: int) -> None:
        self._calls.davar_python_gap(self._run, min(int(missing), UINT32_MAX))

    def push(self, values: Floats, stride: int) -> None:
        """Adds the epochs that these admitted values complete to the waiting rows, in pieces."""
        done = 0
        while done < len(values):
            some, taken = values[done : done + PUSHED], c_size_t()
            place = self._place((len(values) - done) // stride + 4)
            written = self._calls.davar_python_push(
                self._run, some.ctypes.data, len(some), *place, byref(taken)
            )
            if not written and not taken.value:
                raise MemoryError(self.reason())
            self._used += written
            done += taken.value

    def slide(self, values: Floats, ends: npt.NDArray[np.uintp]) -> bool:
        """Adds all epochs of a complete record to the waiting rows, instead of gap, push and flush.
        ends: of the runs without a gap. False: the settings do not allow it.
        """
        at, stride, _ = self._place(len(values))
        record = values.ctypes.data, len(values), ends.ctypes.data, len(ends)
        while written := self._calls.davar_python_slide(self._run, *record, at, stride, PUSHED):
            self._used += written
        return self._used > 0

    def flush(self) -> None:
        """Adds the epochs up to the mirrored end of the record to the waiting rows."""
        while True:
            place = self._place(FLUSHED)
            written = self._calls.davar_python_flush(self._run, *place)
            self._used += written
            if written < place[-1]:
                return

    def _place(self, rows: int) -> tuple[int, int, int]:
        """The address of the next row, the rows of its table, and how many of them are free. A new
        table has room for at least so many rows.
        """
        if not self._tables or self._used == self._tables[-1].shape[1]:
            # An odd number of cache lines: rows of a table then share no set of the cache.
            self._tables.append(np.empty((len(self.columns), rows // 16 * 16 + 24)))
            self._used = 0
        table = self._tables[-1]
        at = table.ctypes.data + self._used * table.itemsize
        return at, table.shape[1], table.shape[1] - self._used

    @property
    def waiting(self) -> int:
        """Rows."""
        full: int = sum(table.shape[1] for table in self._tables[:-1])
        return full + self._used

    def rows(self) -> list[Floats]:
        """Returns and clears the waiting rows, as at least one table (columns, rows)."""
        self._place(0)
        tables = [*self._tables[:-1], self._tables[-1][:, : self._used]]
        self._tables, self._used = [], 0
        return tables

    def health(self) -> dict[str, int]:
        counters = (c_uint32 * len(HEALTH))()
        self._calls.davar_python_health(self._run, counters)
        return dict(zip(HEALTH, counters))


def torn_of(counts: Floats, ends: npt.NDArray[np.uintp]) -> npt.NDArray[np.bool_]:
    """Which of these admitted counts are torn register reads. ends: of the runs without a gap."""
    torn = np.zeros(len(counts), np.bool_)
    calls().davar_python_torn(counts.ctypes.data, len(counts), ends.ctypes.data, torn.ctypes.data)
    return torn


def taus_of(window: int, wanted: int) -> npt.NDArray[np.uint32]:
    """Cluster sizes for a window: octaves (wanted = 0) or `wanted` sizes on a
    log scale.
    """
    found = np.zeros(TAUS_MAX, np.uint32)
    return found[: calls().davar_python_taus(window, wanted, found.ctypes.data)]


def adev_of(
    values: Floats,
    centre: float,
    step: float,
    ends: npt.NDArray[np.uintp],
    m: npt.NDArray[np.uint32],
) -> Floats:
    """Rows deviation, number of differences and those of batches, of values in whole steps from a
    centre (davar_python_adev), in pieces.
    """
    rows = np.empty((2 + 2 * PARTS, len(m)))
    for some in pieces(len(values), len(m)):
        rows[:, some] = piece_of(values, centre, step, ends, m[some])
    return rows


def pieces(count: int, taus: int) -> list[slice]:
    """Which sizes each call computes, for `count` samples."""
    most = max(1, PIECE // count)
    return [slice(first, first + most) for first in range(0, taus, most)]


def piece_of(
    values: Floats,
    centre: float,
    step: float,
    ends: npt.NDArray[np.uintp],
    m: npt.NDArray[np.uint32],
) -> Floats:
    """The columns of adev_of for some sizes. No other size has an effect on them."""
    rows = np.zeros((2 + 2 * PARTS, len(m)))
    if not calls().davar_python_adev(
        values.ctypes.data,
        len(values),
        centre,
        step,
        ends.ctypes.data,
        len(ends),
        m.ctypes.data,
        len(m),
        rows.ctypes.data,
    ):
        raise MemoryError
    return rows


def limits_of(
    m: npt.NDArray[np.uint32], rows: Floats, count: int, rate_hz: float, unit_per_count: float = 0.0
) -> Floats:
    """Rows low, high for the rows of adev_of. If there are more sizes than one fit allows, each fit
    uses a frame that spans all of them and some of the others.
    """
    limits = np.empty((2, len(m)))
    for some in parts(m):
        sizes, these, found = m[some], np.ascontiguousarray(rows[:, some]), np.empty((2, len(some)))
        if not calls().davar_python_intervals(
            sizes.ctypes.data,
            these.ctypes.data,
            len(some),
            count,
            rate_hz,
            unit_per_count,
            found.ctypes.data,
        ):
            raise MemoryError
        limits[:, some] = found
    return limits


def parts(m: npt.NDArray[np.uint32]) -> list[npt.NDArray[np.intp]]:
    """Indices in m of the sizes that are fitted together, at most TAUS_MAX at a time."""
    every = np.arange(len(m))
    if len(m) <= TAUS_MAX:
        return [every]
    frame = np.unique(
        np.searchsorted(m, np.geomspace(m[0], m[-1], TAUS_MAX // 2)).clip(max=len(m) - 1)
    )
    rest = np.setdiff1d(every, frame)
    count = -(-len(rest) // (TAUS_MAX - len(frame)))
    return [np.union1d(frame, rest[i::count]) for i in range(count)]
