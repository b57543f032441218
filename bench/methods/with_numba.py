"""numba: the loop of tools/davar-bench, which has a deviation at every sample. The noise is that at
one sample, as in the 25 lines of C.

Source: numba.pydata.org
"""

import bench_numba
import numpy as np
from signals import LOST, STRIDE, Floats, NotHere, Record

WINDOW = 600
SIZES = 2 ** np.arange(7)
loop = bench_numba.compiled(bench_numba.sliding)


def sliding(record: Record) -> Floats:
    if loop is None:
        raise NotHere("no numba")
    present = record.counts != LOST
    counts = record.counts[present]
    adev = np.empty((max(0, counts.size - WINDOW + 1), SIZES.size))
    loop(counts, WINDOW, SIZES, adev)
    answers = np.full((record.counts.size // STRIDE, 4), np.nan)
    newest = np.cumsum(present)[STRIDE - 1 :: STRIDE] - WINDOW
    answers[newest >= 0, 0] = record.lsb_dps * adev[newest[newest >= 0], 0]
    return answers


METHODS = {"numba": sliding}
