"""AllanTools: oadev of the last 6 s, at least 600 samples, for each answer. The interval is that of
its confidence_interval for white noise. The noise is read at one sample, or at 1 s, as IEEE Std 952
reads an angle random walk.

Source: pypi.org/project/AllanTools
"""

from functools import cache

import allantools
import numpy as np
from signals import LOST, STRIDE, Floats, Record


@cache
def limits(samples: int, cluster: int) -> Floats:
    """Of a deviation of 1."""
    edf = allantools.edf_simple(samples, cluster, alpha=0)
    return np.array(allantools.confidence_interval(1.0, edf, ci=0.95))


def read(record: Record, cluster: int) -> Floats:
    x = np.where(record.counts == LOST, np.nan, record.counts * record.lsb_dps)
    window = max(600, round(6 * record.rate_hz))
    answers = np.full((x.size // STRIDE, 4), np.nan)
    for answer in range(window // STRIDE - 1, len(answers)):
        part = x[: STRIDE * (answer + 1)][-window:]
        part = part[~np.isnan(part)]  # it knows no gaps
        _, adev, _, _ = allantools.oadev(
            part, rate=record.rate_hz, data_type="freq", taus=[cluster / record.rate_hz]
        )
        answers[answer, 0] = cluster**0.5 * adev[0]
        answers[answer, 1:3] = answers[answer, 0] * limits(part.size, cluster)
    return answers


METHODS = {
    "AllanTools": lambda record: read(record, 1),
    "AllanTools 1 s": lambda record: read(record, round(record.rate_hz)),
}
