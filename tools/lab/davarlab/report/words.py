"""Sentences and numbers of a report, on a page or in a terminal, for a person who never saw the tool."""

import re

import numpy as np

from ..diagnosis.compare import SIGNIFICANT
from ..diagnosis.diagnose import ADEQUATE, FAMILY_WISE
from ..effects import table
from ..inference.adequacy import INDEPENDENT

HELD_OUT_CLEARLY = 1.5  # the same of parameters that were fitted on another recording
TINY = 1e-12  # below this a p-value says "never"; its digits are those of an approximation
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PLAIN_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# What each test of adequacy looks at (davarlab.adequacy).
TESTS = {
    "spectrum": "power of the residual at every frequency",
    "bias step": "one sudden step of the bias",
    "time and frequency": "power in octaves of frequency and 24 stretches of time, together",
    "largest cell": "the worst single octave and stretch",
    "line": "one sharp spectral line",
    "narrow band": "a narrow band with too much power",
    "amplitudes": "tails too heavy or too light (kurtosis)",
    "jumps": "a short excursion of the mean",
    "shocks": "single wild samples",
}


NAMES = {"gauss_markov": "Gauss-Markov noise", "low_pass": "low pass of the sensor", "g_sensitivity": "g-sensitivity",
         "warm_up": "warm-up"}

UNITS = ("dps", "s", "hz", "hour", "per")


def name(kind):
    return NAMES.get(kind, kind.replace("_", " "))


def listed(kinds, shown=name, joint=" and "):
    names = [shown(kind) for kind in kinds]
    return "".join(names) if len(names) < 2 else f"{', '.join(names[:-1])}{joint}{names[-1]}"


def number(value, digits=4):
    """Significant digits as people write them, powers of ten written as such."""
    if value is None or value != value:
        return "–"
    if isinstance(value, str):
        return value
    if value == 0 or 1e-4 <= abs(value) < 1e6:
        return (f"{value:.0f}" if abs(value) >= 10 ** (digits - 1) else f"{value:.{digits}g}").replace("-", "−")
    mantissa, power = f"{value:.{digits - 2}e}".split("e")
    return f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}".replace("-", "−")


def bounds(estimate):
    """A way to write both ends of an interval: with as many digits as tell them apart."""
    digits = next((d for d in range(4, 10) if number(estimate.low, d) != number(estimate.high, d)), 9)
    return lambda value: number(value, digits)


def chance(p):
    return "below 10⁻¹²" if p < TINY else f"{p:.2f}" if p >= 0.1 else number(p, 3) if p < 1e-4 else f"{p:.2g}"


def evidence(before, after, count, added, alternative=False):
    """How to take one of `count` candidates: its p-value beside the model as given and beside the final one."""
    likely = before * count < FAMILY_WISE
    if added:
        return "beyond doubt" if before * count < 1e-6 else "strong" if likely else "only beside the others"
    if after is not None and after * count < FAMILY_WISE:
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
    low, high = number(estimate.low, 3), number(estimate.high, 3)
    return bare_value(parameter, estimate) + ("" if low == high else f", 95\u00a0%: {low} to {high}")


def strength(kind, estimates, shown=value_with_interval):
    """The size of an effect as fitted, and its shape."""
    return "; ".join(shown(p, estimates[p.name]) for p in table.find(kind).parameters if p.name in estimates)


def clause(kind):
    """The physics of an effect as part of a sentence."""
    physics = table.find(kind).physics.rstrip(".").split(": ")[0].split(" (")[0]
    return physics[0].lower() + physics[1:]


def misfit(comparison):
    """Where the whole record is off, and by how much at most, in one sentence."""
    whole = [cell for cell in comparison.cells if cell.start_s == 0 and
             cell.stop_s >= 0.99 * comparison.samples / comparison.rate_hz]
    off = [cell for cell in whole if abs(cell.z) > SIGNIFICANT]
    if off:
        farthest, surest = max(off, key=lambda cell: abs(np.log(cell.ratio))), max(off, key=lambda cell: abs(cell.z))
        span = f"between {off[0].tau_s:.3g} and {off[-1].tau_s:.3g} s" if len(off) > 1 else f"at {off[0].tau_s:.3g} s only"
        least_doubt = "" if surest is farthest else (f"; surest at {surest.tau_s:.3g} s ({times(surest.ratio)}, "
                                                     f"{surest.z:+.0f} standard deviations)")
        return (f"Over the whole record the measured Allan deviation is off {span}, farthest "
                f"at {farthest.tau_s:.3g} s ({times(farthest.ratio)}, {farthest.z:+.0f} standard deviations){least_doubt}.")
    local = max(comparison.cells, key=lambda cell: abs(cell.z))
    if abs(local.z) > SIGNIFICANT:
        return (f"Over the whole record the Allan deviation agrees with the model, but not everywhere: between "
                f"{local.start_s:.0f} and {local.stop_s:.0f} s it is {times(local.ratio)} at "
                f"{local.tau_s:.3g} s.")
    return "The measured Allan deviation agrees with the model at every averaging time and in every part of the record."


def times(ratio):
    if 0.9 < ratio < 1.1:
        return f"{100 * abs(ratio - 1):.2g} % {'above' if ratio > 1 else 'below'} the model's"
    return f"{ratio:.2g} times the model's"


def failed_tests(tests):
    """What the tests that fail by themselves look for, most telling first; None when none does."""
    bad = [TESTS.get(what, what) for p, what in sorted((p, what) for what, p in tests.items()) if p * INDEPENDENT < ADEQUATE]
    return "; ".join(bad) or None


def verdict_of_comparison(comparison):
    if comparison.adequate:
        return "good", "The model explains this recording: what is left over is what chance leaves."
    return "bad", "The model does not explain this recording: measurement and model differ by more than chance can do."


def helpful(found):
    """Does the error fall with what was added."""
    return found.last.error < found.base.error


def verdict_of_unknown(found):
    added = found.diagnosis.added
    if not added:
        return "Something is missing that this tool does not know: none of its effects explains the misfit."
    errors = f"(error {found.base.error:.3f} to {found.last.error:.3f})"
    if helpful(found):
        return (f"The model lacks more than this tool knows: {listed(added)} would help {errors}, but what is left is still more "
                "than chance.")
    return (f"Something is missing that this tool does not know: with {listed(added)} the recording would be likelier, but its "
            f"Allan deviation no better explained {errors}.")


def verdict_held_out(found):
    """What a second recording says of the final model: a sentence, or None without one."""
    error, floor = found.last.error_held_out, found.last.error_floor_held_out
    if error is None:
        return None
    sizes = f"its error there is {error:.3f}, and a true model would give about {floor:.3f}"
    return f"The final model does not explain the held-out recording: {sizes}." if error > HELD_OUT_CLEARLY * floor else \
        f"The final model holds on the held-out recording: {sizes}."


def verdict_of_missing(found):
    added = found.diagnosis.added
    sizes = found.estimates[-len(added):]
    if len(added) == 1:
        if found.diagnosis.alternatives and found.diagnosis.ranking[0].kind == added[0]:
            rivals = listed(added + found.diagnosis.alternatives, joint=" or ")
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
    if found.verdict == "unknown":
        return "bad", verdict_of_unknown(found)
    if found.diagnosis.added:
        return "missing", verdict_of_missing(found)
    if found.comparison.adequate:
        return "good", "Nothing is missing: the model explains this recording, and what is left over is what chance leaves."
    return "missing", ("No effect is missing, but the sizes in the model file are off: with the same effects refitted the "
                       "model explains this recording.")


def improvement(found):
    first, last = found.steps[0], found.steps[-1]
    refitted = f" ({found.refitted.error:.3f} refitted)" if found.refitted else ""
    if len(found.steps) == 1:
        return f"The error is {first.error:.3f}{refitted}; a true model would give about {found.last.error_floor:.3f}."
    sentence = (f"With {listed(found.diagnosis.added)} added the error goes from {first.error:.3f}{refitted} to {last.error:.3f}; "
                f"a true model would give about {last.error_floor:.3f}.")
    if last.error_held_out is not None:
        sentence += f" On the held-out recording it goes from {first.error_held_out:.3f} to {last.error_held_out:.3f}."
    return sentence


def confirmations(found):
    """How to make sure of each effect that was found, and to tell it from its likes."""
    added = found.diagnosis.added if found.verdict != "unknown" or helpful(found) else []
    lines = [f"Confirm {name(kind)}: {table.find(kind).confirm}" for kind in added]
    return lines + [f"This recording cannot tell {name(found.diagnosis.ranking[0].kind)} from {name(kind)}. To tell them "
                    f"apart: {table.find(kind).confirm}" for kind in found.diagnosis.alternatives]


def what_next(found, run):
    """Actions in order: (what to do, the command that does it or None)."""
    added, lines = found.diagnosis.added, []
    if found.verdict == "unknown":
        lines.append(("Look at the failure map and the residual spectrum below: when and at which averaging time it fails "
                      "says more about an unknown effect than any list. An effect of your own joins the list with",
                      "--effects FILE.py"))
    lines += [(sentence, None) for sentence in confirmations(found)]
    if added and run.output:
        lines.append((f"The model with {listed(added)} is in", run.output))
    elif added and found.verdict != "unknown":
        lines.append((f"Add {listed(added)} to the model:", run.follow_up("improve", "-o", "BETTER.toml")))
    if not added and found.verdict == "none" and not found.comparison.adequate:
        lines.append(("Refit the sizes:", run.follow_up("fit", "-o", "FITTED.toml")))
    return lines


def after_comparison(comparison, state, run):
    """The same after `davarlab compare`; state: the effects refitted."""
    if comparison.adequate:
        return []
    if state.adequacy.p_value >= ADEQUATE:
        return [("The same effects with other sizes would do. Refit them:", run.follow_up("fit", "-o", "FITTED.toml"))]
    return [("Find out what is missing:", run.follow_up("diagnose", "--report", "DIAGNOSIS.html"))]


def gap_note(recording):
    """What gaps do to the results; None without gaps."""
    if not len(recording.gaps):
        return None
    return (f"The recording has {len(recording.gaps)} gaps. Samples are taken as if they followed each other, and times "
            "below count samples: do not trust slow terms (bias instability, random walk, drifts) where gaps are a large "
            "part.")


def in_ascii(text):
    """The same for a terminal of any encoding."""
    text = re.sub("·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda found: "e" + found[1].translate(PLAIN_DIGITS), text)
    return text.replace("\u00a0", " ").replace("−", "-").replace("–", "-").replace("below 10⁻¹²", "below 1e-12")
