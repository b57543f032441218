"""The dynamic Allan variance by its definition, in numpy: lib/DESIGN.md, formulas (1.1), (1.5),
(3.1) to (3.4), (4.1) and (4.2). It shares no code with the library.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass
class Setting:
    """The options of davar-sim, by their names."""

    mode: str = "centred"
    law: str = "or"
    longest: int = 60
    shortest: int = 40
    segment: int = 10
    grow: int = 2
    shrink: int = 2
    stride: int = 1
    kurtosis: tuple = (2.5, 3.3)
    contribution: tuple = (0.0, 0.07)
    taus: tuple = (1, 2, 4)

    def words(self):
        return (
            *("--mode", self.mode, "--law", self.law, "--window-max", self.longest),
            *("--window-min", self.shortest, "--segment", self.segment, "--stride", self.stride),
            *("--grow", self.grow, "--shrink", self.shrink),
            *("--kurtosis", "{}:{}".format(*self.kurtosis)),
            *("--contribution", "{}:{}".format(*self.contribution)),
            *("--taus", ",".join(map(str, self.taus))),
        )


def kurtosis_of(samples):
    deviation = samples - np.mean(samples)
    second = np.mean(deviation**2)
    return np.mean(deviation**4) / second**2 if np.ptp(samples) > 0 else math.nan


def judge(samples, setting):
    """(kurtosis, contribution, unstable) of a window."""
    whole, first = kurtosis_of(samples), kurtosis_of(samples[: -setting.segment])
    change = abs(whole - first) / whole
    f1 = not math.isnan(whole) and not setting.kurtosis[0] <= whole <= setting.kurtosis[1]
    f2 = not math.isnan(change) and not setting.contribution[0] <= change <= setting.contribution[1]
    unstable = {"kurtosis": f1, "and": f1 and f2}.get(setting.law, f1 or f2)
    return whole, change, unstable


def deviation_of(samples, gaps, m):
    """(Allan deviation, number of differences); gaps: the places in the window after which samples
    are missing.
    """
    sums = np.concatenate([[0], np.cumsum(samples)])
    squares = (sums[2 * m :] - 2 * sums[m:-m] + sums[: -2 * m]).astype(float) ** 2
    kept = np.ones(len(squares), bool)
    for gap in gaps:
        kept[max(gap - 2 * m + 1, 0) : max(gap, 0)] = False
    number = int(kept.sum())
    return (math.sqrt(squares[kept].sum() / (2 * number)) / m if number else math.nan), number


def results(counts, gaps, setting):
    """The results of all epochs; gaps: the samples before which others are missing. A centred
    window continues beyond both ends of the recording with their mirror images.
    """
    counts, total = np.asarray(counts), len(counts)
    centred, filling = setting.mode == "centred", setting.mode == "trailing"
    half = setting.longest // 2 if centred else 0
    padded = np.concatenate([counts[:half][::-1], counts, counts[total - half :][::-1]])
    images = {at for gap in gaps for at in (gap, -gap, 2 * total - gap)}
    length = setting.longest if centred else min(setting.stride, setting.longest)
    for epoch in range(setting.stride - 1, total, setting.stride):
        head = epoch + length // 2 if centred else epoch + 1
        tail, unstable = head - length, False
        if centred or length >= setting.shortest:
            window = padded[tail + half : head + half]
            kurtosis, contribution, unstable = judge(window, setting)
            inside = [gap - tail for gap in sorted(images) if tail < gap < head]
            yield {
                "epoch": epoch,
                "window_samples": length,
                "kurtosis": kurtosis,
                "contribution": contribution,
                "unstable": int(unstable),
                "gaps_in_window": len(inside),
                "adev": {m: deviation_of(window, inside, m) for m in setting.taus},
            }
        if unstable and setting.law != "fixed":
            filling, change = False, -setting.shrink
        else:
            filling = filling and length < setting.longest
            change = setting.grow if centred else 1 if filling else min(setting.grow, 1)
            change = max(change, 1) if setting.law == "fixed" else change
        length += change * setting.stride
        length = max(setting.shortest, length) if change < 0 else min(setting.longest, length)
