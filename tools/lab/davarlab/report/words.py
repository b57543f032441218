"""Sentences and numbers of a report, for a page or a terminal. The reader may not know the tool."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import numpy as np

from ..data import plausible
from ..data.observations import Observation
from ..data.recording import Recording
from ..diagnosis.compare import Comparison
from ..diagnosis.improve import Estimates, Improvement
from ..diagnosis.judge import Deviation, Judgement
from ..diagnosis.state import Judged
from ..effects import table
from ..effects.base import Parameter
from ..inference.estimate import Estimate
from ..thresholds import CHANCE, JUDGE

CONFIDENCE = f"{100 - 100 * CHANCE.family_wise:g} % confidence"  # of a proven deviation
TINY = 1e-12  # below this a p-value says "never"; its digits are those of an approximation
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# What each adequacy test detects (inference/adequacy.py).
TESTS = {
    "spectrum": "wrong residual power at any frequency",
    "time and frequency": (
        "wrong residual power in any octave and any of 24 time segments, combined"
    ),
    "largest cell": "wrong residual power in the worst single octave and time segment",
    "narrow band": "a narrow band with too much power",
    "shocks": "single outlier samples",
}

# What to do, and the command that does it.
Action = tuple[str, str | None]


class FollowUp(Protocol):
    """The run of a report, as far as its sentences name it (contents.Run)."""

    output: str | None

    def follow_up(self, command: str, *options: str) -> str: ...


NAMES = {
    "gauss_markov": "Gauss-Markov noise",
    "low_pass": "low pass of the sensor",
    "g_sensitivity": "g-sensitivity",
    "warm_up": "warm-up",
}

UNITS = ("dps", "s", "hz", "hour", "per")


def name(kind: str) -> str:
    return NAMES.get(kind, kind.replace("_", " "))


def listed(kinds: Iterable[Any], shown: Callable[[Any], str] = name, joint: str = " and ") -> str:
    """Lists each kind once, in order of first appearance, with its count."""
    found = Counter(map(shown, kinds))
    names = [f"{text} ({count} times)" if count > 1 else text for text, count in found.items()]
    return (
        "nothing"
        if not names
        else names[0]
        if len(names) == 1
        else f"{', '.join(names[:-1])}{joint}{names[-1]}"
    )


def number(value: float | str | None, digits: int = 4) -> str:
    """Formats a number with `digits` significant digits and a typeset power of ten."""
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


def bounds(estimate: Estimate) -> Callable[[float], str]:
    """Returns a formatter with enough digits to distinguish the two ends of an interval."""
    digits = next(
        (d for d in range(4, 10) if number(estimate.low, d) != number(estimate.high, d)), 9
    )
    return lambda value: number(value, digits)


def chance(p: float) -> str:
    return (
        "below 10⁻¹²"
        if p < TINY
        else f"{p:.2f}"
        if p >= 0.1
        else number(p, 3)
        if p < 1e-4
        else f"{p:.2g}"
    )


def evidence(
    before: float, after: float | None, count: int, added: bool, alternative: bool = False
) -> str:
    """Rates one of `count` candidates from its p-values with the initial and the final model."""
    likely = before * count < CHANCE.family_wise
    if added:
        return (
            "conclusive"
            if before * count < 1e-6
            else "strong"
            if likely
            else "only with the other added effects"
        )
    if after is not None and after * count < CHANCE.family_wise:
        return "strong"
    if likely:
        return "indistinguishable from it" if alternative else "imitates an added effect"
    return "weak" if before < 0.05 else "not significant"


def label(parameter: Parameter) -> str:
    """The name of a parameter in a sentence. A coefficient needs no name."""
    words = [word for word in parameter.name.split("_") if word not in UNITS]
    return "" if words[0] == "coefficient" else " ".join(words) + " "


def bare_value(parameter: Parameter, estimate: Estimate) -> str:
    if isinstance(estimate.value, str):
        return label(parameter) + estimate.value
    return f"{label(parameter)}{number(estimate.value, 3)} {parameter.unit.split(' (')[0]}".rstrip()


def value_with_interval(parameter: Parameter, estimate: Estimate) -> str:
    if estimate.low is None:
        return bare_value(parameter, estimate) + (
            " (undetermined)" if estimate.undetermined else ""
        )
    return (
        bare_value(parameter, estimate)
        + f", 95\u00a0%: {number(estimate.low, 3)} to {number(estimate.high, 3)}"
    )


def strength(
    kind: str,
    estimates: Estimates,
    shown: Callable[[Parameter, Estimate], str] = value_with_interval,
) -> str:
    """The fitted size and shape of an effect."""
    return "; ".join(
        shown(p, estimates[p.name]) for p in table.find(kind).parameters if p.name in estimates
    )


def clause(kind: str) -> str:
    """The physics of an effect, as a clause inside a sentence."""
    physics = table.find(kind).physics.rstrip(".").split(": ")[0].split(" (")[0]
    return physics[0].lower() + physics[1:]


def adequacy(judgement: Judgement) -> str:
    """The verdict on a model: the same sentences on a page, in a terminal and in JSON."""
    shown = (
        "The recording is long enough to confirm a fit within 5 % up to "
        f"{seconds(judgement.shown_to_tau_s)} averaging time."
        if judgement.shown_to_tau_s
        else "The recording is too short to confirm a fit within 5 % at any averaging time."
    )
    if judgement.doubted:
        return (
            "The recording is implausible, so no model is reported as adequate. Correct its "
            f"units as listed, or confirm them with {plausible.CONFIRM}."
        )
    if judgement.adequacy == "statistical":
        return (
            "The model is statistically adequate: the residual is consistent with noise "
            f"(p = {chance(judgement.p_value)}). {shown}"
        )
    if judgement.adequacy == "practical":
        small = (
            f"The largest proven deviation is {off(judgement.largest)} ({CONFIDENCE})."
            if judgement.largest
            else f"No deviation is proven ({CONFIDENCE})."
        )
        return (
            "The model is practically adequate: it fits within 5 %, but the residual is not pure "
            f"noise (p = {chance(judgement.p_value)}). {small} {shown}"
        )
    if judgement.largest and abs(judgement.largest["percent"]) > 5:
        return f"The model does not fit. {proven(judgement.largest)}"
    if judgement.error != judgement.error:
        return (
            "The model cannot be tested: the recording is too short. "
            "No averaging time fits into it nine times."
        )
    also = f" {proven(judgement.largest)}" if judgement.largest else ""
    return (
        "The model does not fit. "
        f"Its error is {judgement.error / judgement.floor:.2f} times that of a true model.{also}"
    )


def seconds(value: float) -> str:
    """A time in seconds, from two minutes on also in minutes or hours."""
    text = f"{number(value, 3)} s"
    if value < 120:
        return text
    return (
        f"{text} ({number(value / 60, 2)} min)"
        if value < 7200
        else f"{text} ({number(value / 3600, 2)} h)"
    )


def place(deviation: Deviation) -> str:
    start, stop = deviation["start_s"], deviation["stop_s"]
    return f"at {seconds(deviation['tau_s'])}, from {start:.0f} to {stop:.0f} s of the recording"


def off(deviation: Deviation) -> str:
    percent = number(abs(deviation["percent"]), 2)
    return (
        f"{percent} % {'above' if deviation['percent'] > 0 else 'below'} the model "
        f"{place(deviation)}"
    )


def factor(ratio: float) -> str:
    return f"{max(ratio, 1 / max(ratio, 1e-9)):.3g}"


def proven(deviation: Deviation) -> str:
    """The largest deviation, as a factor by which the model is too low or too high, and its
    bound."""
    least = 1 + deviation["percent"] / 100
    return (
        f"{capital(place(deviation))}, its Allan deviation is too {'low' if least > 1 else 'high'} "
        f"by a factor of {factor(deviation['ratio'])} (at least {factor(least)} with {CONFIDENCE})."
    )


def observation(one: Observation) -> str:
    """A disturbance in the recording that is not an error of the sensor."""
    return f"In the recording: {name(one.kind)}. {one.detail}"


def misfit(comparison: Comparison) -> str:
    """One sentence on where the whole recording deviates significantly from the model, and how
    far."""
    span = comparison.duration_s
    away = [cell for cell in comparison.where if cell.start_s == 0 and cell.stop_s >= 0.99 * span]
    if away:
        away.sort(key=lambda cell: cell.tau_s)
        farthest = max(away, key=lambda cell: abs(np.log(cell.ratio)))
        reach = (
            f"between {away[0].tau_s:.3g} and {seconds(away[-1].tau_s)}"
            if len(away) > 1
            else f"only at {seconds(away[0].tau_s)}"
        )
        return (
            "Over the whole recording, the measured Allan deviation deviates from the model "
            f"{reach}. The largest deviation is at {seconds(farthest.tau_s)}: "
            f"{times(farthest.ratio)}, {farthest.z:+.0f} standard deviations."
        )
    if comparison.where:
        local = comparison.where[0]
        return (
            "Over the whole recording, the Allan deviation agrees with the model, but not in "
            f"every part. Between {local.start_s:.0f} and {local.stop_s:.0f} s it is "
            f"{times(local.ratio)} at {seconds(local.tau_s)}."
        )
    if comparison.judgement.largest:  # in a window that the map does not show
        return (
            "Over the whole recording, the Allan deviation agrees with the model, but not in "
            f"every part. It is at least {off(comparison.judgement.largest)} ({CONFIDENCE})."
        )
    return "The Allan deviation agrees with the model at every averaging time and in every part."


def times(ratio: float) -> str:
    if 0.9 < ratio < 1.1:
        return f"{100 * abs(ratio - 1):.2g} % {'above' if ratio > 1 else 'below'} the model"
    return f"{ratio:.2g} times the model"


def failed_tests(tests: Mapping[str, float]) -> str | None:
    """What each failed test detects, the smallest p-value first; None when no test fails."""
    bad = [
        TESTS.get(what, what)
        for p, what in sorted((p, what) for what, p in tests.items())
        if p * JUDGE.independent_tests < CHANCE.adequate_p
    ]
    return "; ".join(bad) or None


def verdict_of_comparison(comparison: Comparison) -> tuple[str, str]:
    tone = {"statistical": "good", "practical": "good", "no": "bad"}[comparison.judgement.adequacy]
    return tone, adequacy(comparison.judgement)


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def helpful(found: Improvement) -> bool:
    """Whether the added effects reduce the error."""
    return found.last.error < found.base.error


def verdict_of_unknown(found: Improvement) -> str:
    added = found.added
    if not added:
        return (
            "The model lacks an effect that is not in davarlab's table: no effect explains the "
            "misfit."
        )
    errors = f"(error {found.base.error:.3f} to {found.last.error:.3f})"
    if helpful(found):
        return (
            "The model lacks an effect that is not in davarlab's table. "
            f"{capital(listed(added))} would help {errors}, but the residual is not pure noise."
        )
    return (
        "The model lacks an effect that is not in davarlab's table. "
        f"Adding {listed(added)} raises the likelihood, but does not improve the fit to the "
        f"Allan deviation {errors}."
    )


def verdict_held_out(found: Improvement) -> str | None:
    """A sentence on how well the final model fits the held-out recording; None without one."""
    error, floor = found.last.error_held_out, found.last.error_floor_held_out
    if error is None or floor is None:
        return None
    sizes = f"its error there is {error:.3f}, and a true model would give about {floor:.3f}"
    return (
        f"The final model does not fit the held-out recording: {sizes}."
        if error > CHANCE.held_out_above_floor * floor
        else f"The final model also fits the held-out recording: {sizes}."
    )


def verdict_of_missing(found: Improvement) -> str:
    added = found.added
    sizes = found.estimates[-len(added) :]
    if len(added) == 1:
        if found.diagnosis.alternatives and found.diagnosis.ranking[0].kind == added[0]:
            rivals = listed(
                added + [one.kind for one in found.diagnosis.alternatives], joint=" or "
            )
            return f"The model lacks {rivals}. This recording cannot distinguish them."
        return (
            f"The model lacks {name(added[0])}: {clause(added[0])} "
            f"({strength(added[0], sizes[0])})."
        )
    named = listed(
        zip(added, sizes), lambda one: f"{name(one[0])} ({strength(one[0], one[1], bare_value)})"
    )
    return (
        f"The model lacks {named}. With {'both' if len(added) == 2 else 'these'}, it explains "
        "this recording."
    )


def verdict_of_diagnosis(found: Improvement) -> tuple[str, str]:
    """(tone, sentences) of an improvement."""
    tone, sentence = verdict_of_recording(found)
    outside = verdict_held_out(found)
    if outside and "does not fit" in outside:
        return ("missing" if tone == "good" else tone), f"{sentence} {outside}"
    return tone, f"{sentence} {outside}" if outside else sentence


def verdict_of_recording(found: Improvement) -> tuple[str, str]:
    if found.judgement.doubted:
        return "bad", adequacy(found.judgement)
    final = adequacy(found.judgement)
    if found.added:
        final = final.replace("The model ", "With the added effects, the model ", 1)
    if found.verdict == "unknown":
        return "bad", f"{verdict_of_unknown(found)} {final}"
    if found.added:
        return "missing", f"{verdict_of_missing(found)} {final}"
    if found.comparison.adequate:
        return "good", f"Nothing is missing. {final}"
    return "missing", (
        "No effect is missing, but the values in the model file are off. With the same effects "
        "refitted, the model explains this recording."
    )


def outdone(found: Improvement) -> str:
    """The effects that the search removed again, in one sentence; "" without one."""
    kinds = [kind for kind in found.diagnosis.outdone if kind not in found.added]
    if not kinds or not found.added:
        return ""
    was, them = ("was", "it") if len(kinds) == 1 else ("were", "them")
    return (
        f" {listed(kinds)} {was} added on the way and removed again, because later effects explain "
        f"{them}."
    )


def improvement(found: Improvement) -> str:
    first, last = found.steps[0], found.steps[-1]
    refitted = f" ({found.refitted.error:.3f} refitted)" if found.refitted else ""
    if len(found.steps) == 1:
        return (
            f"The error is {first.error:.3f}{refitted}. "
            f"A true model would give about {found.last.error_floor:.3f}."
        )
    sentence = (
        f"Adding {listed(found.added)} changes the error from {first.error:.3f}{refitted} to "
        f"{last.error:.3f}. A true model would give about {last.error_floor:.3f}."
    )
    if last.error_held_out is not None:
        sentence += (
            " On the held-out recording, it changes from "
            f"{first.error_held_out:.3f} to {last.error_held_out:.3f}."
        )
    return sentence + outdone(found)


def confirmations(found: Improvement) -> list[str]:
    """How to confirm each effect that was found, and how to distinguish it from similar ones."""
    added = found.added if found.verdict != "unknown" or helpful(found) else []
    lines = [f"Confirm {name(kind)}: {table.find(kind).confirm}" for kind in dict.fromkeys(added)]
    lines += [
        f"This recording cannot distinguish {name(found.diagnosis.ranking[0].kind)} from "
        f"{name(one.kind)}. To distinguish them: {one.confirm}"
        for one in found.diagnosis.alternatives
        if one.kind not in added
    ]
    return lines + [
        f"Not reported as missing: {name(kind)}. Reason: {why}."
        for kind, why in found.diagnosis.doubtful.items()
    ]


def what_next(found: Improvement, run: FollowUp) -> list[Action]:
    """Actions in order: (what to do, the command that does it or None)."""
    added = found.added
    lines: list[Action] = []
    if found.judgement.doubted:
        return []
    if found.verdict == "unknown":
        lines.append(
            (
                "Look at the failure map and the residual spectrum below. The times, averaging "
                "times and frequencies of the misfit point to the cause. Add your own effect to "
                "the table with",
                "--effects FILE.py",
            )
        )
    lines += [(sentence, None) for sentence in confirmations(found)]
    if added and run.output:
        lines.append((f"The model with {listed(added)} was written to", run.output))
    elif added and found.verdict != "unknown":
        lines.append(
            (f"Add {listed(added)} to the model:", run.follow_up("improve", "-o", "BETTER.toml"))
        )
    if not added and found.verdict == "none" and not found.comparison.adequate:
        lines.append(("Refit the values:", run.follow_up("fit", "-o", "FITTED.toml")))
    return lines


def after_comparison(comparison: Comparison, state: Judged, run: FollowUp) -> list[Action]:
    """The next actions after `davarlab compare`. state: the refitted effects."""
    if comparison.adequate or comparison.judgement.doubted:
        return []
    if state.judgement.adequate:
        return [
            (
                "The same effects fit with other values. Refit them:",
                run.follow_up("fit", "-o", "FITTED.toml"),
            )
        ]
    return [("Find the missing effect:", run.follow_up("diagnose", "--report", "DIAGNOSIS.html"))]


def gap_note(recording: Recording) -> str | None:
    """A note on how gaps affect the results; None without gaps."""
    if not len(recording.gaps):
        return None
    missing = recording.samples - recording.measured_samples
    return (
        f"The recording has {len(recording.gaps)} gaps with {missing} missing "
        "samples. No Allan deviation spans a gap, so long averaging times use less data."
    )


def in_ascii(text: str) -> str:
    """Replaces every character outside ASCII, for terminals of any encoding."""
    text = re.sub("·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda found: "e" + found[1].translate(PLAIN_DIGITS), text)
    return (
        text.replace("\u00a0", " ")
        .replace("−", "-")
        .replace("–", "-")
        .replace("∞", "inf")
        .replace("below 10⁻¹²", "below 1e-12")
    )
