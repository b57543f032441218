"""Sentences and numbers of a report, on a page or in a terminal, for a person who never saw the tool."""

import re
from collections import Counter

import numpy as np

from ..data import plausible
from ..effects import table
from ..thresholds import CHANCE, JUDGE

TINY = 1e-12  # below this a p-value says "never"; its digits are those of an approximation
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# What each test of adequacy looks at (davarlab.adequacy).
TESTS = {
    "spectrum": "power of the residual at every frequency",
    "time and frequency": "power in octaves of frequency and 24 stretches of time, together",
    "largest cell": "the worst single octave and stretch",
    "narrow band": "a narrow band with too much power",
    "shocks": "single wild samples",
}


NAMES = {
    "gauss_markov": "Gauss-Markov noise",
    "low_pass": "low pass of the sensor",
    "g_sensitivity": "g-sensitivity",
    "warm_up": "warm-up",
}

UNITS = ("dps", "s", "hz", "hour", "per")


def name(kind):
    return NAMES.get(kind, kind.replace("_", " "))


def listed(kinds, shown=name, joint=" and "):
    """Each once, in the order of their first, with how many there are."""
    found = Counter(map(shown, kinds))
    names = [f"{text} ({count} times)" if count > 1 else text for text, count in found.items()]
    return (
        "nothing"
        if not names
        else names[0]
        if len(names) == 1
        else f"{', '.join(names[:-1])}{joint}{names[-1]}"
    )


def number(value, digits=4):
    """Significant digits as people write them, powers of ten written as such."""
    if value is None or value != value:
        return "–"
    if isinstance(value, str):
        return value
    if abs(value) == float("inf"):
        return "∞" if value > 0 else "−∞"
    if value == 0 or 1e-4 <= abs(value) < 1e6:
        return (
            f"{value:.0f}" if abs(value) >= 10 ** (digits - 1) else f"{value:.{digits}g}"
        ).replace("-", "−")
    mantissa, power = f"{value:.{digits - 2}e}".split("e")
    return f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}".replace("-", "−")


def bounds(estimate):
    """A way to write both ends of an interval: with as many digits as tell them apart."""
    digits = next(
        (d for d in range(4, 10) if number(estimate.low, d) != number(estimate.high, d)), 9
    )
    return lambda value: number(value, digits)


def chance(p):
    return (
        "below 10⁻¹²"
        if p < TINY
        else f"{p:.2f}"
        if p >= 0.1
        else number(p, 3)
        if p < 1e-4
        else f"{p:.2g}"
    )


def evidence(before, after, count, added, alternative=False):
    """How to take one of `count` candidates: its p-value beside the model as given and beside the final one."""
    likely = before * count < CHANCE.family_wise
    if added:
        return (
            "beyond doubt"
            if before * count < 1e-6
            else "strong"
            if likely
            else "only beside the others"
        )
    if after is not None and after * count < CHANCE.family_wise:
        return "strong"
    if likely:
        return "cannot be told from it" if alternative else "imitates what was added"
    return "weak" if before < 0.05 else "no more than chance"


def label(parameter):
    """What a parameter is called in a sentence; a coefficient needs no name."""
    words = [word for word in parameter.name.split("_") if word not in UNITS]
    return "" if words[0] == "coefficient" else " ".join(words) + " "


def bare_value(parameter, estimate):
    if isinstance(estimate.value, str):
        return label(parameter) + estimate.value
    return f"{label(parameter)}{number(estimate.value, 3)} {parameter.unit.split(' (')[0]}".rstrip()


def value_with_interval(parameter, estimate):
    if estimate.low is None:
        return bare_value(parameter, estimate) + (
            " (undetermined)" if estimate.undetermined else ""
        )
    return (
        bare_value(parameter, estimate)
        + f", 95\u00a0%: {number(estimate.low, 3)} to {number(estimate.high, 3)}"
    )


def strength(kind, estimates, shown=value_with_interval):
    """The size of an effect as fitted, and its shape."""
    return "; ".join(
        shown(p, estimates[p.name]) for p in table.find(kind).parameters if p.name in estimates
    )


def clause(kind):
    """The physics of an effect as part of a sentence."""
    physics = table.find(kind).physics.rstrip(".").split(": ")[0].split(" (")[0]
    return physics[0].lower() + physics[1:]


def adequacy(judgement):
    """The judge's sentence: the same on a page, in a terminal and of the JSON's word."""
    shown = (
        f"5 % is shown up to {number(judgement.shown_to_tau_s, 3)} s of averaging, beyond it is not contradicted."
        if judgement.shown_to_tau_s
        else "The record is too short to show 5 % at any averaging time."
    )
    if judgement.doubted:
        return (
            "The recording is implausible, so no model is reported as adequate. Correct its units as listed, or confirm them with "
            f"{plausible.CONFIRM}."
        )
    if judgement.adequacy == "statistical":
        return f"The model is statistically adequate: what is left over is what chance leaves (p = {chance(judgement.p_value)}). {shown}"
    if judgement.adequacy == "practical":
        small = (
            f"at most {number(abs(judgement.largest['percent']), 2)} % ({place(judgement.largest)}) is proven"
            if judgement.largest
            else "none is proven"
        )
        return (
            f"The model is practically adequate within 5 %, though something is left over (p = {chance(judgement.p_value)}): of deviations of "
            f"the Allan deviation {small}. {shown}"
        )
    if judgement.largest and abs(judgement.largest["percent"]) > 5:
        return f"The model is not adequate: the Allan deviation is {off(judgement.largest)} at the least."
    if not judgement.error == judgement.error:
        return (
            "The model cannot be judged: the record has no averaging time that nine windows fit in."
        )
    beside = f"; proven is {off(judgement.largest)}" if judgement.largest else ""
    return f"The model is not adequate: its error is {judgement.error / judgement.floor:.2f} times that of a true model{beside}."


def place(deviation):
    return f"at {number(deviation['tau_s'], 3)} s, from {deviation['start_s']:.0f} to {deviation['stop_s']:.0f} s"


def off(deviation):
    return f"{number(abs(deviation['percent']), 2)} % {'above' if deviation['percent'] > 0 else 'below'} the model's {place(deviation)}"


def observation(one):
    """What is in the record and no error of the sensor."""
    return f"In the record: {name(one.kind)}: {one.detail}"


def misfit(comparison):
    """Where the whole record is off, and by how much at most, in one sentence; what the judge takes for chance is not."""
    span = comparison.duration_s
    away = [cell for cell in comparison.where if cell.start_s == 0 and cell.stop_s >= 0.99 * span]
    if away:
        away.sort(key=lambda cell: cell.tau_s)
        farthest = max(away, key=lambda cell: abs(np.log(cell.ratio)))
        reach = (
            f"between {away[0].tau_s:.3g} and {away[-1].tau_s:.3g} s"
            if len(away) > 1
            else f"at {away[0].tau_s:.3g} s only"
        )
        return (
            f"Over the whole record the measured Allan deviation is off {reach}, farthest at {farthest.tau_s:.3g} s "
            f"({times(farthest.ratio)}, {farthest.z:+.0f} standard deviations)."
        )
    if comparison.where:
        local = comparison.where[0]
        return (
            f"Over the whole record the Allan deviation agrees with the model, but not everywhere: between {local.start_s:.0f} and "
            f"{local.stop_s:.0f} s it is {times(local.ratio)} at {local.tau_s:.3g} s."
        )
    if comparison.judgement.largest:  # in a window that the map does not show
        return f"Over the whole record the Allan deviation agrees with the model, but not everywhere: it is {off(comparison.judgement.largest)}."
    return "No averaging time and no part of the record is off by more than chance."


def times(ratio):
    if 0.9 < ratio < 1.1:
        return f"{100 * abs(ratio - 1):.2g} % {'above' if ratio > 1 else 'below'} the model's"
    return f"{ratio:.2g} times the model's"


def failed_tests(tests):
    """What the tests that fail by themselves look for, most telling first; None when none does."""
    bad = [
        TESTS.get(what, what)
        for p, what in sorted((p, what) for what, p in tests.items())
        if p * JUDGE.independent_tests < CHANCE.adequate_p
    ]
    return "; ".join(bad) or None


def verdict_of_comparison(comparison):
    tone = {"statistical": "good", "practical": "good", "no": "bad"}[comparison.judgement.adequacy]
    return tone, adequacy(comparison.judgement)


def helpful(found):
    """Does the error fall with what was added."""
    return found.last.error < found.base.error


def verdict_of_unknown(found):
    added = found.added
    if not added:
        return "Something is missing that this tool does not know: none of its effects explains the misfit."
    errors = f"(error {found.base.error:.3f} to {found.last.error:.3f})"
    if helpful(found):
        return (
            f"The model lacks more than this tool knows: {listed(added)} would help {errors}, but what is left is still more "
            "than chance."
        )
    return (
        f"Something is missing that this tool does not know: with {listed(added)} the recording would be likelier, but its "
        f"Allan deviation no better explained {errors}."
    )


def verdict_held_out(found):
    """What a second recording says of the final model: a sentence, or None without one."""
    error, floor = found.last.error_held_out, found.last.error_floor_held_out
    if error is None:
        return None
    sizes = f"its error there is {error:.3f}, and a true model would give about {floor:.3f}"
    return (
        f"The final model does not explain the held-out recording: {sizes}."
        if error > CHANCE.held_out_above_floor * floor
        else f"The final model holds on the held-out recording: {sizes}."
    )


def verdict_of_missing(found):
    added = found.added
    sizes = found.estimates[-len(added) :]
    if len(added) == 1:
        if found.diagnosis.alternatives and found.diagnosis.ranking[0].kind == added[0]:
            rivals = listed(
                added + [one.kind for one in found.diagnosis.alternatives], joint=" or "
            )
            return f"The model lacks {rivals}, which this recording cannot tell apart."
        return f"The model lacks {name(added[0])}: {clause(added[0])} ({strength(added[0], sizes[0])})."
    named = listed(zip(added, sizes), lambda one: f"{name(one[0])} ({strength(*one, bare_value)})")
    return f"The model lacks {named}; with {'both' if len(added) == 2 else 'these'} it explains this recording."


def verdict_of_diagnosis(found):
    """(tone, sentences) of an improvement."""
    tone, sentence = verdict_of_recording(found)
    outside = verdict_held_out(found)
    if outside and "does not" in outside:
        return ("missing" if tone == "good" else tone), f"{sentence} {outside}"
    return tone, f"{sentence} {outside}" if outside else sentence


def verdict_of_recording(found):
    if found.judgement.doubted:
        return "bad", adequacy(found.judgement)
    if found.verdict == "unknown":
        return "bad", f"{verdict_of_unknown(found)} {adequacy(found.judgement)}"
    if found.added:
        return "missing", f"{verdict_of_missing(found)} {adequacy(found.judgement)}"
    if found.comparison.adequate:
        return "good", f"Nothing is missing. {adequacy(found.judgement)}"
    return "missing", (
        "No effect is missing, but the sizes in the model file are off: with the same effects refitted the "
        "model explains this recording."
    )


def improvement(found):
    first, last = found.steps[0], found.steps[-1]
    refitted = f" ({found.refitted.error:.3f} refitted)" if found.refitted else ""
    if len(found.steps) == 1:
        return f"The error is {first.error:.3f}{refitted}; a true model would give about {found.last.error_floor:.3f}."
    sentence = (
        f"With {listed(found.added)} added the error goes from {first.error:.3f}{refitted} to {last.error:.3f}; "
        f"a true model would give about {last.error_floor:.3f}."
    )
    if last.error_held_out is not None:
        sentence += f" On the held-out recording it goes from {first.error_held_out:.3f} to {last.error_held_out:.3f}."
    return sentence


def confirmations(found):
    """How to make sure of each effect that was found, and to tell it from its likes."""
    added = found.added if found.verdict != "unknown" or helpful(found) else []
    lines = [f"Confirm {name(kind)}: {table.find(kind).confirm}" for kind in dict.fromkeys(added)]
    lines += [
        f"This recording cannot tell {name(found.diagnosis.ranking[0].kind)} from {name(one.kind)}. To tell them apart: {one.confirm}"
        for one in found.diagnosis.alternatives
        if one.kind not in added
    ]
    return lines + [
        f"Not named: {name(kind)}: {why}." for kind, why in found.diagnosis.doubtful.items()
    ]


def what_next(found, run):
    """Actions in order: (what to do, the command that does it or None)."""
    added, lines = found.added, []
    if found.judgement.doubted:
        return []
    if found.verdict == "unknown":
        lines.append(
            (
                "Look at the failure map and the residual spectrum below: when and at which averaging time it fails "
                "says more about an unknown effect than any list. An effect of your own joins the list with",
                "--effects FILE.py",
            )
        )
    lines += [(sentence, None) for sentence in confirmations(found)]
    if added and run.output:
        lines.append((f"The model with {listed(added)} is in", run.output))
    elif added and found.verdict != "unknown":
        lines.append(
            (f"Add {listed(added)} to the model:", run.follow_up("improve", "-o", "BETTER.toml"))
        )
    if not added and found.verdict == "none" and not found.comparison.adequate:
        lines.append(("Refit the sizes:", run.follow_up("fit", "-o", "FITTED.toml")))
    return lines


def after_comparison(comparison, state, run):
    """The same after `davarlab compare`; state: the effects refitted."""
    if comparison.adequate or comparison.judgement.doubted:
        return []
    if state.judgement.adequate:
        return [
            (
                "The same effects with other sizes would do. Refit them:",
                run.follow_up("fit", "-o", "FITTED.toml"),
            )
        ]
    return [("Find out what is missing:", run.follow_up("diagnose", "--report", "DIAGNOSIS.html"))]


def gap_note(recording):
    """What gaps do to the results; None without gaps."""
    if not len(recording.gaps):
        return None
    return (
        f"The recording has {len(recording.gaps)} gaps, in which {(~recording.known).sum()} samples of its even grid are missing. Allan "
        "deviations span none of them: where gaps are a large part, long times rest on little."
    )


def in_ascii(text):
    """The same for a terminal of any encoding."""
    text = re.sub("·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda found: "e" + found[1].translate(PLAIN_DIGITS), text)
    return (
        text.replace("\u00a0", " ")
        .replace("−", "-")
        .replace("–", "-")
        .replace("∞", "inf")
        .replace("below 10⁻¹²", "below 1e-12")
    )
