"""The Allan curve of a result, for a chart: every cluster size of its channel, with 95 % intervals
and the fitted terms."""

import functools
import math

import numpy as np
from davar.wire.frames import Result

from ..arrays import Floats
from ..distributions import chi2_ppf
from ..report.values import Json

H = 3600.0  # seconds
# The Allan variance of each term, (1.2) of lib/DESIGN.md: column of the coefficient -> (its unit in
# deg and s, factor of its square, power of tau).
TERMS = {
    "qn_deg": (1.0, 3.0, -2),
    "arw_deg_per_sqrt_h": (1 / math.sqrt(H), 1.0, -1),
    "bi_deg_per_h": (1 / H, 2 * math.log(2) / math.pi, 0),
    "rrw_deg_per_h_per_sqrt_h": (1 / H / math.sqrt(H), 1 / 3, 1),
    "rr_deg_per_h2": (1 / H**2, 1 / 2, 2),
}


@functools.cache
def widths() -> tuple[Floats, Floats, Floats]:
    """(half the 95 % interval, lower limit, upper limit) of a deviation of 1, from many degrees of
    freedom to one."""
    edf = np.geomspace(1e8, 1, 2000)
    low, high = (np.sqrt(edf / chi2_ppf(p, edf)) for p in (0.975, 0.025))
    return (high - low) / 2, low, high


def limits(value: float, uncertainty: float) -> tuple[float, float] | None:
    """The 95 % interval of a deviation. `uncertainty` is half its width over the value: it follows
    from the degrees of freedom, as both limits do. None: unknown, or wider than a frame can hold.
    """
    if not (math.isfinite(value) and math.isfinite(uncertainty)):
        return None
    half, low, high = widths()
    return (
        value * float(np.interp(uncertainty, half, low)),
        value * float(np.interp(uncertainty, half, high)),
    )


def fitted(values: dict[str, float], tau_s: float) -> float | None:
    """The deviation of the fitted terms together at this averaging time. None: no term is
    present."""
    variance = sum(
        factor * (values[name] * unit) ** 2 * tau_s**power
        for name, (unit, factor, power) in TERMS.items()
        if math.isfinite(values.get(name, math.nan))
    )
    return math.sqrt(variance) if variance > 0 else None


def curve(result: Result) -> Json | None:
    """Lists with one entry per cluster size, ascending: m (samples), tau_s (None: rate not known
    yet), adev, low, high, fitted (deg/s; None: absent). None: no Allan deviations are sent, or no
    cluster size is known yet."""
    sender = result.sender
    rate = sender.setup.get("rate_hz")
    sizes = sorted((sender.clusters[t], t) for t in result.adev if t in sender.clusters)
    if not sizes:
        return None
    found: Json = {
        "m": [m for m, _ in sizes],
        "tau_s": [m / rate for m, _ in sizes] if rate else None,
        "adev": [],
        "low": [],
        "high": [],
        "fitted": [],
    }
    for m, t in sizes:
        adev = result.adev[t] if math.isfinite(result.adev[t]) else None
        low, high = limits(result.adev[t], result.uncertainty.get(t, math.nan)) or (None, None)
        model = fitted(result.values, m / rate) if rate and adev is not None else None
        for name, value in zip(("adev", "low", "high", "fitted"), (adev, low, high, model)):
            found[name].append(value)
    return found
