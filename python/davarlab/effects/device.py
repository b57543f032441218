"""The library of the device, as tools/davarlab builds it or pip installed it: filters as all
programs read them."""

import ctypes
import os
from functools import cache

import numpy as np
from davar import places

from ..arrays import Floats
from ..errors import BadInput

ZEROS, POLES = 32, 9  # coefficients of a filter
BINS_MOST, TEXT_BYTES = 512, 512  # of learned()


class Filter(ctypes.Structure):
    """davar_filter_t of davar/filter.h."""

    _fields_ = (
        ("b", ctypes.c_double * ZEROS),
        ("a", ctypes.c_double * POLES),
        ("uncertainty", ctypes.c_double),
        ("level", ctypes.c_double),
        ("count_variance", ctypes.c_double),
        ("count_step", ctypes.c_double),
        ("length", ctypes.c_uint16),
        ("summed", ctypes.c_uint16),
        ("averages", ctypes.c_uint8),
    )


@cache
def library() -> ctypes.CDLL:
    path = os.environ.get(
        "DAVAR_LAB_LIBRARY", str(places.shared("build/tools/python/libdavar_lab.so"))
    )
    try:
        found = ctypes.CDLL(path)
        _declare(found)
    except (OSError, AttributeError) as why:  # none, or one of another version
        raise BadInput(f"{path}: cannot load the library ({why}); run tools/davarlab") from None
    return found


def _declare(found: ctypes.CDLL) -> None:
    """States the arguments of the functions. Raises AttributeError if the library lacks one."""
    pointer = ctypes.POINTER
    doubles = pointer(ctypes.c_double)
    found.davar_lab_windows.argtypes = [
        pointer(ctypes.c_float),
        ctypes.c_size_t,
        ctypes.c_double,
        ctypes.c_uint32,
        ctypes.c_uint32,
        pointer(ctypes.c_uint32),
        ctypes.c_uint8,
        doubles,
        ctypes.c_size_t,
    ]
    found.davar_lab_edf.argtypes = [ctypes.c_int, ctypes.c_uint32, ctypes.c_uint32]
    found.davar_lab_edf.restype = ctypes.c_double
    found.davar_lab_filter.argtypes = [
        ctypes.c_char_p,
        ctypes.c_double,
        pointer(Filter),
    ]
    found.davar_lab_filter.restype = ctypes.c_char_p
    found.davar_lab_learn.argtypes = [
        doubles,
        ctypes.c_size_t,
        ctypes.c_double,
        ctypes.c_int,
        ctypes.c_char_p,
    ]
    found.davar_lab_chain.argtypes = [
        doubles,
        ctypes.c_size_t,
        doubles,
        ctypes.c_uint,
        doubles,
        ctypes.c_uint,
        doubles,
    ]
    found.davar_lab_chain.restype = ctypes.c_double


def _doubles(values: Floats) -> "ctypes._Pointer[ctypes.c_double]":
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


@cache
def filter_of(text: str, rate_hz: float) -> Filter:
    """A value of --bandwidth; rate_hz 0 only checks its form. Raises BadInput."""
    found = Filter()
    expected = library().davar_lab_filter(text.encode(), rate_hz, found)
    if expected:
        raise BadInput(f"{expected.decode()} expected, found {text}")
    return found


def learned(
    angle: Floats, power: Floats, weight: Floats, rounding: float, front: Floats | None
) -> tuple[str, int]:
    """The filter of any shape that a spectrum shows, as filter_of() reads it, and how many numbers
    it has; "": none. Of each bin (up to BINS_MOST) the angle in a sample, the power, the ordinates
    in it that vary as exponentials, and the power in front of the filter up to a factor; None:
    white noise, with any flicker and walk. rounding: power behind the filter."""
    known = np.ones_like(angle) if front is None else front
    bins = np.ascontiguousarray(np.column_stack([angle, power, weight, known]), float)
    text = ctypes.create_string_buffer(TEXT_BYTES)
    numbers = library().davar_lab_learn(
        _doubles(bins), len(bins), rounding, front is not None, text
    )
    return text.value.decode(), numbers


def chain_of_levels(
    values: Floats,
    slow: Floats,
    white: float,
    chain: tuple[float, float],
    levels: int,
    posterior: bool = False,
) -> tuple[float, Floats]:
    """(log-likelihood of the values, the chance of each level at each) of a symmetric chain of
    levels beside noise. slow: rows of the decay and the variance of processes of first order;
    white: variance; chain: half the distance of neighbouring levels, and the chance of a switch
    between two values. Up to eight levels, the highest first (one: the noise alone); without
    `posterior` the chances are empty."""
    values, slow = np.ascontiguousarray(values, float), np.ascontiguousarray(slow, float)
    given = np.array([white, *chain])
    chance = np.empty((len(values), levels) if posterior else (0, levels))
    found: float = library().davar_lab_chain(
        _doubles(values),
        len(values),
        _doubles(slow),
        len(slow),
        _doubles(given),
        levels,
        _doubles(chance) if posterior else None,
    )
    if found == -np.inf:
        raise MemoryError
    return found, chance.T
