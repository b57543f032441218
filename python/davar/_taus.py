"""Averaging times: a word, cluster sizes in samples, or seconds. The argument's name gives the
unit.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _samples
from ._library import TAUS_MAX, taus_of

Sizes = npt.NDArray[np.uint32]
WORDS = "'octave', 'decade', 'all' or 'geometric:K'"


class Wanted(NamedTuple):
    """Averaging times of the caller. name: the argument. word: the word of `taus`, or None. sizes:
    in samples, ascending, if word is None.
    """

    name: str
    word: str | None
    sizes: list[int]


def wanted(
    rate_hz: float, taus: str | None, clusters: npt.ArrayLike | None, taus_s: npt.ArrayLike | None
) -> Wanted:
    """Parses the arguments. Raises ValueError with the argument's name."""
    given = [
        name
        for name, value in (("taus", taus), ("clusters", clusters), ("taus_s", taus_s))
        if value is not None
    ]
    if len(given) > 1:
        raise ValueError(
            f"{given[0]}: give one of taus, clusters and taus_s, found {' and '.join(given)}"
        )
    if clusters is not None:
        return Wanted("clusters", None, in_samples(clusters))
    if taus_s is not None:
        return Wanted("taus_s", None, in_seconds(taus_s, rate_hz))
    if taus is not None and not isinstance(taus, str):
        raise ValueError(
            "taus: a word expected; a list needs its unit: clusters= for cluster sizes in "
            "samples, taus_s= for seconds"
        )
    return Wanted("taus", "octave" if taus is None else str(taus), [])


def numbers(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """One dimension, at least one number, all finite and above 0. Raises ValueError."""
    if isinstance(value, str):
        raise ValueError(f"{name}: numbers expected, found {value!r} (words belong in taus=)")
    found = _samples.unmasked(name, value)
    found = found if found.ndim else found.reshape(1)
    if found.ndim != 1 or not found.size:
        raise ValueError(f"{name}: a list of numbers expected, found shape {found.shape}")
    found = found.astype(np.float64)
    wrong = found[~(np.isfinite(found) & (found > 0))]
    if wrong.size:
        raise ValueError(f"{name}: numbers above 0 expected, found {wrong[0]:g}")
    return found


def in_samples(clusters: npt.ArrayLike) -> list[int]:
    found = numbers("clusters", clusters)
    part = found[found != np.floor(found)]
    if part.size:
        raise ValueError(
            f"clusters: whole numbers of samples expected, found {part[0]:g} "
            "(seconds go into taus_s=)"
        )
    if np.any(np.diff(found) <= 0):
        raise ValueError("clusters: sizes must ascend")
    return [int(one) for one in found]


def in_seconds(taus_s: npt.ArrayLike, rate_hz: float) -> list[int]:
    """Rounds each to a whole number of samples and merges equal ones."""
    found = numbers("taus_s", taus_s)
    if np.any(np.diff(found) < 0):
        raise ValueError("taus_s: times must ascend")
    sizes = np.floor(found * rate_hz + 0.5)
    if sizes[0] < 1:
        raise ValueError(
            f"taus_s: {found[0]:g} s is less than half a sample period ({1 / rate_hz:g} s)"
        )
    return [int(one) for one in np.unique(sizes)]


def of_record(what: Wanted, count: int) -> Sizes:
    """The cluster sizes for a record of `count` samples. Raises ValueError."""
    if what.word is not None:
        return of_word(what.word, count)
    if what.sizes[-1] > count // 2:
        raise ValueError(
            f"{what.name}: cluster sizes up to {count // 2} samples (half of x) expected, "
            f"found {what.sizes[-1]}"
        )
    return np.array(what.sizes, np.uint32)


def of_word(word: str, count: int) -> Sizes:
    octaves = taus_of(count, 0)
    if word == "octave":
        return octaves
    largest = count // 9 if count >= 18 else 1  # the same limit as for octaves
    if word == "all":
        return np.arange(1, largest + 1, dtype=np.uint32)
    if word == "decade":
        decades = [m * 10**k for k in range(10) for m in (1, 2, 4)]
        return np.array([m for m in decades if m <= largest], np.uint32)
    kind, _, number = word.partition(":")
    number = number if ":" in word else "12"
    if (
        kind != "geometric"
        or not (number.isascii() and number.isdigit())
        or not 1 <= int(number) <= TAUS_MAX
    ):
        raise ValueError(f"taus: {WORDS} with K from 1 to {TAUS_MAX} expected, found {word!r}")
    return taus_of(count, int(number))


def option(what: Wanted) -> str:
    """Text for davar-sim --taus. Raises ValueError."""
    if what.word in ("all", "decade"):
        raise ValueError(
            f"taus: {what.word!r} works only in adev(); windows accept 'octave', 'geometric:K', "
            f"or up to {TAUS_MAX} sizes as clusters= or taus_s="
        )
    if len(what.sizes) > TAUS_MAX:
        raise ValueError(
            f"{what.name}: 1 to {TAUS_MAX} cluster sizes expected, found {len(what.sizes)}"
        )
    if what.word is None and what.sizes[-1] >= 1 << 32:
        raise ValueError(
            f"{what.name}: cluster sizes below 2^32 samples expected, found {what.sizes[-1]}"
        )
    return what.word or ",".join(map(str, what.sizes))
