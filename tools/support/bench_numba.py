"""What an expert writes instead of davar: Allan deviations in loops that numba compiles, exact for
integer counts.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Counts = npt.NDArray[np.int16]
Floats = npt.NDArray[np.float64]


def sliding(counts: Counts, window: int, sizes: npt.NDArray[np.int64], adev: Floats) -> None:
    """Deviations (epochs, sizes) of the window that ends at each sample, in counts. The sum of each
    size gains the difference that enters the window and loses the one that leaves it.
    """
    total = np.zeros(counts.size + 1, np.int64)
    for i in range(counts.size):
        total[i + 1] = total[i] + counts[i]
    squares = np.zeros(sizes.size, np.int64)
    scale = 1.0 / (2.0 * sizes * sizes * (window - 2 * sizes + 1))
    for end in range(1, counts.size + 1):
        for t in range(sizes.size):
            m = sizes[t]
            if end >= 2 * m:
                entering = total[end] - 2 * total[end - m] + total[end - 2 * m]
                squares[t] += entering * entering
            if end > window:
                start = end - window - 1
                leaving = total[start + 2 * m] - 2 * total[start + m] + total[start]
                squares[t] -= leaving * leaving
            if end >= window:
                adev[end - window, t] = np.sqrt(squares[t] * scale[t])


def octaves(x: Floats, adev: Floats) -> None:
    """Deviations of a record at 1, 2, 4 ... samples, in one pass per size and in floats."""
    total = np.zeros(x.size + 1)
    for i in range(x.size):
        total[i + 1] = total[i] + x[i]
    for t in range(adev.size):
        m = 1 << t
        squares = 0.0
        for i in range(x.size - 2 * m + 1):
            difference = total[i + 2 * m] - 2.0 * total[i + m] + total[i]
            squares += difference * difference
        adev[t] = np.sqrt(squares / (2.0 * m * m * (x.size - 2 * m + 1)))


def compiled(loop: Callable[..., None]) -> Callable[..., Any] | None:
    """The loop as machine code. None: numba is not installed."""
    try:
        import numba
    except ImportError:
        return None
    machine_code: Callable[..., Any] = numba.njit(loop)
    return machine_code
