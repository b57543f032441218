"""What is measured of the answers of a method: error, coverage, time to a doubling, alarms."""

import numpy as np
import numpy.typing as npt
from signals import STRIDE, Floats, Record

SETTLED = 100  # answers: 1000 samples, in which every method has begun
THRESHOLD = 2**0.5  # of a method without an alarm: its value over its own median in quiet
QUIET_S = 30.0  # after a change, until that median is taken


def errors(answers: Floats, record: Record) -> Floats:
    """ln(value / truth) of every answer; NaN: it has no value."""
    size = min(len(answers), len(record.sigma_dps))
    with np.errstate(divide="ignore"):
        found: Floats = np.log(answers[SETTLED:size, 0] / record.sigma_dps[SETTLED:size])
    return np.where(np.isinf(found), np.nan, found)


def covered(answers: Floats, record: Record) -> Floats:
    """1: the interval of an answer contains the truth, 0: it does not, NaN: there is none."""
    size = min(len(answers), len(record.sigma_dps))
    _, low, high, _ = answers[SETTLED:size].T
    truth = record.sigma_dps[SETTLED:size]
    return np.where(np.isnan(low), np.nan, (low <= truth) & (truth <= high))


def alarms(answers: Floats, record: Record) -> npt.NDArray[np.intp]:
    """The answers at which an alarm begins: its own, or else a value above the threshold."""
    values, alarm = answers[:, 0], answers[:, 3]
    if np.isnan(alarm).all():
        place = np.arange(len(values))
        changed = np.diff(record.sigma_dps, prepend=record.sigma_dps[:1]) != 0
        since = place - np.maximum.accumulate(np.where(changed, place, 0))
        is_late = since * STRIDE > QUIET_S * record.rate_hz
        is_quiet = is_late & (record.sigma_dps == record.sheet_dps)
        if np.isnan(values[is_quiet]).all():
            return np.array([], np.intp)
        alarm = values > THRESHOLD * np.nanmedian(values[is_quiet])
    begins = np.flatnonzero((alarm[1:] == 1) & (alarm[:-1] != 1)) + 1
    return begins[begins >= SETTLED]


def delays_s(answers: Floats, record: Record) -> Floats:
    """From each doubling to the next alarm that begins before the noise changes back; NaN: none."""
    begins = alarms(answers, record)
    changes = np.flatnonzero(np.diff(record.sigma_dps))
    ends = [*changes[1:], len(answers)]
    found = []
    for change, end in zip(changes, ends):
        if record.sigma_dps[change + 1] > record.sigma_dps[change]:
            inside = begins[(begins > change) & (begins <= end)]
            found.append((inside[0] - change) * STRIDE / record.rate_hz if inside.size else np.nan)
    return np.array(found)


def alarms_per_hour(answers: Floats, record: Record) -> float:
    hours = (len(answers) - SETTLED) * STRIDE / record.rate_hz / 3600
    return len(alarms(answers, record)) / hours
