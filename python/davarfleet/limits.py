"""Limits of a production test: pass or fail from the intervals, and how often a good unit fails.

A coefficient x is estimated with the standard error s of ln x (of x itself where the interval is
even about the value): s = ln(high / low) / (2 * 1.96). A unit fails a limit L where its estimate is
beyond L by more than z s, z the normal quantile of 1 - at_limit. So a unit whose true value is L
fails with the chance `at_limit`, and one whose true value is t with

    P(fail | t) = Phi((ln t - ln L) / s - z)        (max; the signs turned for min)        (F.1)

tests/lab/test_fleet.py draws sensors at a limit and beside it, and counts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from davarlab import model as models
from davarlab.distributions import norm_cdf, norm_isf, norm_ppf
from davarlab.errors import BadInput
from davarlab.thresholds import CHANCE

from .store import Found, Row

AT_LIMIT = 0.025
CAUGHT = 0.95


@dataclass(frozen=True)
class Limit:
    """side: +1 for a largest, -1 for a smallest value."""

    coefficient: str
    value: float
    side: int

    @property
    def said(self) -> str:
        return f"{self.coefficient} {'<=' if self.side > 0 else '>='} {self.value:g}"


@dataclass(frozen=True)
class Test:
    """at_limit: share of the units exactly at a limit that fail; adequate: must the model be
    adequate.
    """

    limits: tuple[Limit, ...]
    at_limit: float
    adequate: bool


def number(value: object, where: str) -> float:
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not abs(value) < models.HUGE
    ):
        raise BadInput(f"{where} must be a number")
    return float(value)


def limits_in(entry: object, where: str) -> list[Limit]:
    if not isinstance(entry, dict) or not isinstance(entry.get("coefficient"), str):
        raise BadInput(f"{where}: a limit needs coefficient, as kind.parameter")
    wrong = set(entry) - {"coefficient", "min", "max"}
    if wrong or not {"min", "max"} & set(entry):
        raise BadInput(
            f"{where}: {f'unknown {min(wrong)}' if wrong else 'a limit needs min or max'}"
        )
    return [
        Limit(entry["coefficient"], number(entry[name], f"{where}: {name}"), side)
        for name, side in (("min", -1), ("max", 1))
        if name in entry
    ]


def read(path: str) -> Test:
    """The test in a TOML file. Raises BadInput."""
    data = models.load_toml(path)
    wrong = set(data) - {"at_limit", "adequate", "limit"}
    if wrong:
        raise BadInput(f"{path}: unknown {min(wrong)}")
    share, adequate, entries = (
        number(data.get("at_limit", AT_LIMIT), f"{path}: at_limit"),
        data.get("adequate", False),
        data.get("limit", []),
    )
    if not 0 < share <= 0.5:
        raise BadInput(f"{path}: at_limit = {share:g} is outside 0 .. 0.5")
    if not isinstance(adequate, bool):
        raise BadInput(f"{path}: adequate must be true or false")
    if not isinstance(entries, list) or not entries and not adequate:
        raise BadInput(f"{path}: no [[limit]] in it")
    return Test(
        tuple(
            one
            for place, entry in enumerate(entries, 1)
            for one in limits_in(entry, f"{path}: limit {place}")
        ),
        share,
        adequate,
    )


def check_names(test: Test, names: Sequence[str], path: str) -> None:
    """Raises BadInput for a limit on what no unit has."""
    for one in test.limits:
        if names and one.coefficient not in names:
            raise BadInput(
                f"{path}: {one.coefficient}: no unit has it (there are: {', '.join(names)})"
            )


def relative(value: float, low: float | None, high: float | None) -> bool:
    """Is the interval even in the logarithm."""
    if low is None or high is None or low <= 0:
        return False
    return math.isclose(low * high, value * value, rel_tol=1e-6)


def error_of(value: float, low: float, high: float) -> tuple[float, bool]:
    """(standard error, is it of the logarithm) of an estimate."""
    if relative(value, low, high):
        return math.log(high / low) / (2 * CHANCE.normal_95), True
    return (high - low) / (2 * CHANCE.normal_95) if low < value else (
        high - value
    ) / CHANCE.normal_95, False


def beyond(limit: Limit, value: float, low: float | None, high: float | None) -> float | None:
    """By how many standard errors the estimate is beyond the limit; None where the record says next
    to nothing.
    """
    if low is None or high is None:
        return None
    error, logarithm = error_of(value, low, high)
    if logarithm and limit.value > 0:
        return limit.side * math.log(value / limit.value) / error
    return (
        limit.side * (value - limit.value) / error
        if error > 0
        else limit.side * math.inf * (value - limit.value or -1)
    )


def outcome(test: Test, row: Row) -> tuple[str, list[str]]:
    """("pass", "fail" or "no result", what it failed). A unit that was not measured has not
    passed.
    """
    threshold, failed, unknown = norm_isf(test.at_limit), [], []
    for limit in test.limits:
        estimate = row["coefficients"].get(limit.coefficient)
        off = beyond(limit, *estimate) if estimate else None
        if off is None:
            unknown.append(limit.said)
        elif off > threshold:
            failed.append(limit.said)
    if test.adequate and row["adequacy"] == "no":
        failed.append("model adequate")
    return ("fail", failed) if failed else ("no result", unknown) if unknown else ("pass", [])


def chance_of_fail(
    limit: Limit, true: float, error: float, logarithm: bool, at_limit: float
) -> float:
    """(F.1): of a unit whose true value is `true`."""
    off = math.log(true / limit.value) if logarithm else true - limit.value
    return float(norm_cdf(limit.side * off / error - norm_isf(at_limit)))


def stated(test: Test, rows: Sequence[Row]) -> list[Found]:
    """Of each limit: the chances to fail of a unit at the limit and of the median unit, and the
    true value that fails in 95 of 100 cases.
    """
    found = []
    for limit in test.limits:
        known = [
            row["coefficients"][limit.coefficient]
            for row in rows
            if row["coefficients"].get(limit.coefficient, [0, None])[1] is not None
        ]
        pairs = [error_of(*one) for one in known if one[0] > 0 or not relative(*one)]
        if not pairs:
            continue
        logarithm = limit.value > 0 and sum(pair[1] for pair in pairs) * 2 > len(pairs)
        error, median = (
            float(np.median([pair[0] for pair in pairs if pair[1] == logarithm])),
            float(np.median([one[0] for one in known])),
        )
        reach = limit.side * (norm_isf(test.at_limit) + norm_ppf(CAUGHT)) * error
        typical = (
            None
            if logarithm and median <= 0
            else chance_of_fail(limit, median, error, logarithm, test.at_limit)
        )
        found.append(
            {
                "limit": limit.said,
                "coefficient": limit.coefficient,
                "at_limit": test.at_limit,
                "median": median,
                "median_unit": typical,
                "relative_error": error if logarithm else None,
                "caught_from": limit.value * math.exp(reach) if logarithm else limit.value + reach,
            }
        )
    return found
