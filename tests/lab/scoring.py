"""What an answer of davarlab (the JSON of diagnose) is worth beside the truth of awkward.py.
Standard library only, and nothing of davarlab.
"""

import json
import math

BASE = {"angle_random_walk", "bias_instability"}
OUTCOMES = ("right", "unknown", "missed", "wrong", "crash")


def named(found):
    """The kinds that the answer adds."""
    if "missing" in found:
        return list(found["missing"])
    return [kind for kind in final_effects(found) if kind not in BASE]


def final_effects(found):
    return (
        [entry["kind"] for entry in found["fitted"]]
        if found.get("fitted")
        else found["steps"][-1]["effects"]
    )


def adequate(found):
    """Does the answer say that its final model explains the recording? (`adequacy` beside
    `adequate` in diagnose is of the model as given.)
    """
    last = found["steps"][-1] if found.get("steps") else {}
    return found["verdict"] != "unknown" and last.get("adequacy", "") != "no"


def observed(found):
    return {o["kind"] for o in found.get("observations", [])}


def alternatives(found, most=3):
    """Kinds that the answer leaves open. Who leaves everything open says nothing: only the first
    few count.
    """
    return {a["kind"] for a in found.get("alternatives", [])[:most]}


def fitted_value(found, kind, parameter):
    """None: not in the answer."""
    for entry in found.get("fitted") or []:
        value = (entry["parameters"].get(parameter) or {}) if entry["kind"] == kind else {}
        if value.get("value") is not None:
            return value["value"]
    return None


def has_shape(found, kind, parameter, wanted):
    if isinstance(wanted, str):
        return any(
            wanted in json.dumps(entry)
            for entry in found.get("fitted") or []
            if entry["kind"] == kind
        )
    value = fitted_value(found, kind, parameter)
    try:
        return value is not None and wanted[0] <= float(value) <= wanted[1]
    except ValueError:
        return False


def faults(found, truth):
    """(kinds named that are not there, what is lacking)."""
    names, open_ones = set(named(found)), alternatives(found)
    false = names - set().union(truth.extra, *truth.groups)
    lacking = []
    for group in truth.groups:
        if group & names:
            continue
        if group & open_ones:  # "A or B", and it is B
            false -= set(sorted(false)[:1])
        else:
            lacking.append("no " + " or ".join(sorted(group)))
    for (kind, parameter), wanted in truth.shape.items():
        if kind in names and not has_shape(found, kind, parameter, wanted):
            lacking.append(f"{kind} without the right {parameter}")
    seen = observed(found) | names
    lacking += [
        f"{wanted} not observed"
        for wanted in sorted(truth.observations)
        if not seen & set(wanted.split("|"))
    ]
    outside = (
        json.dumps({name: value for name, value in found.items() if name != "candidates"})
        .replace("_", " ")
        .lower()
    )
    if truth.said not in outside:
        lacking.append(f'"{truth.said}" not said')
    return false, lacking


def outcome(found, truth):
    """(one of OUTCOMES, reasons). wrong: a kind that is not there, with "explains this recording";
    missed: something that is there is not said, nothing false either; unknown: honestly not
    explained.
    """
    false, lacking = faults(found, truth)
    reasons = [f"{kind} is not there" for kind in sorted(false)] + lacking
    if not adequate(found):
        if truth.unknown_is_right and not false:
            lacking = [reason for reason in lacking if reason.endswith("observed")]
            return ("missed" if lacking else "right"), lacking
        return "unknown", reasons or ["all named, yet not adequate"]
    if false:
        return "wrong", reasons
    return ("missed", reasons) if lacking else ("right", [])


def intervals(found, truth):
    """(kind, parameter, is the truth inside, true value, low, high) of every number that is
    reported with an interval.
    """
    rows, kinds = [], final_effects(found)
    for entry in found.get("fitted") or []:
        for name, e in entry["parameters"].items():
            value = (
                truth.kinds.get(entry["kind"], {}).get(name)
                if kinds.count(entry["kind"]) == 1
                else None
            )
            low, high = (e or {}).get("low"), (e or {}).get("high")
            if value is not None and finite(low) and finite(high) and high > low:
                rows.append(
                    (entry["kind"], name, bool(low <= value <= high), float(value), low, high)
                )
    return rows


def finite(value):
    return isinstance(value, (int, float)) and math.isfinite(value)
