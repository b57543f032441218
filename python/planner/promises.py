"""What a design gives: precision, delay, false alarms, the reach of the curve."""

import math
from dataclasses import dataclass
from statistics import NormalDist

from . import programs
from .design import CASCADE_CLUSTERS, MEAN_WINDOW, Design, noise_counts

FLOOR = 0.664  # deviation of bias instability B, over B: (1.2) of lib/DESIGN.md
PRESENT_LEAST = 97.0  # percent of windows


@dataclass(frozen=True)
class Promise:
    """Times in seconds. None: does not apply."""

    arw_percent: float  # half of the 95 % interval over the value; infinite: hidden by rounding
    respond_s: float  # a doubling is seen within it in 90 % of cases; infinite: in fewer
    false_alarms_per_hour: float | None
    longest_tau_s: float
    curve_first_s: float | None  # until the longest averaging time has a value
    curve_settled_s: float | None  # until its interval is as narrow as it becomes
    curve_percent: float | None  # half of that interval over the value
    bias_instability_deg_per_h: float | None  # from here on the curve shows it, by typical noise


def chi_square_percent(freedom: float) -> float:
    """Half of the 95 % interval of a deviation over its value: Wilson and Hilferty."""
    z, k = NormalDist().inv_cdf(0.975), 2 / (9 * freedom)
    low, high = (math.pow(1 - k + sign * z * math.sqrt(k), -1.5) for sign in (1, -1))
    return 50 * (high - low)


def promise(design: Design) -> Promise:
    """What the design gives. Raises BadOption for a filter that the library rejects."""
    wishes, slow = design.wishes, design.cascade_taus > 0
    glr = design.law == "glr"
    window = int(design.window * MEAN_WINDOW) if glr else design.window
    alarms = wishes.false_alarms_per_hour if glr else None
    alarm = (design.window, design.stride) if glr else ()
    found = programs.promise(wishes, design.taus, window, noise_counts(wishes), alarm)
    shown = found.get("present_percent", 0.0) >= PRESENT_LEAST
    respond = design.respond_s
    if glr:
        seen = found.get("doubling_samples", math.inf)
        respond = seen / wishes.rate_hz
    longest = design.taus_s[-1]
    freedom = 0.927 * (CASCADE_CLUSTERS + 0.36)  # of random walk: (5.1) of lib/src/fit/DESIGN.md
    edge = wishes.noise / (FLOOR * math.sqrt(longest / 3600)) if slow and wishes.noise else None
    return Promise(
        arw_percent=found["arw_percent"] if shown else math.inf,
        respond_s=respond,
        false_alarms_per_hour=alarms,
        longest_tau_s=longest,
        curve_first_s=2 * longest if slow else None,
        curve_settled_s=(CASCADE_CLUSTERS + 2) * longest if slow else None,
        curve_percent=chi_square_percent(freedom) if slow else None,
        bias_instability_deg_per_h=edge,
    )
