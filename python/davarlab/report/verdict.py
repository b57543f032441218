"""Every sentence about a verdict, once, for terminal, page, report and JSON: does the model fit,
how far is it off and where, what is missing, and what to add or to log next."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from ..candidates.candidate import Candidate
from ..candidates.identifiable import Alternative
from ..data import plausible
from ..data.observations import Observation
from ..diagnosis import evidence
from ..diagnosis.compare import Comparison
from ..diagnosis.improve import Improvement
from ..diagnosis.judge import Deviation, Judgement
from ..diagnosis.state import Judged
from ..diagnosis.unexplained import Excluded, Hint, Unexplained
from ..effects import table
from ..inference import estimate
from ..inference.estimate import Entry, as_shown
from ..inference.reading import Reading
from ..model import kind_said
from ..thresholds import CHANCE, JUDGE, READING
from . import words
from .words import capital, listed, name, number, p_is, seconds, times

CONFIDENCE = f"{100 - 100 * CHANCE.family_wise:g} % confidence"  # of a proven deviation
SHOWN_EXCLUDED = 3  # kinds that a sentence lists with their p
SHOWN_AGAINST = 3  # the same of what speaks against a model that fits
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
UNKNOWN = "Something is missing that davarlab does not know."
NOTHING = "Nothing is missing."
UNTRIED = "Missing effects were not searched for. To do so, run diagnose."
TO_FIND = "To find the missing effect, run diagnose."
TO_REFIT = "The same effects fit with other values. To refit them, run fit."
NOT_VALID = "No intervals are shown, because they assume that the model fits."
OWN_EFFECT = "If you know the cause, write it as your own effect and add it with"
# Columns that an effect needs -> what to log.
LOGGED = {
    "temp_degC": "the temperature (temp_degC)",
    "accel": "the acceleration (accel_x_g, accel_y_g, accel_z_g)",
}

# What to do, and the command that does it.
Action = tuple[str, str | None]


class FollowUp(Protocol):
    """The run of a report, as far as its sentences name it (contents.Run)."""

    output: str | None

    def follow_up(self, command: str, *options: str) -> str: ...


WITHHELD = ("implausible", "spoiled", "untestable")  # answers that permit no verdict

# Does the model fit, how far is it off, and where?


def adequacy(judgement: Judgement) -> str:
    """The verdict on a model."""
    if judgement.spoiled_by == plausible.KIND:
        return (
            "The recording is implausible, so no model is reported as adequate. Correct its "
            f"units as listed, or confirm them with {plausible.CONFIRM}."
        )
    if judgement.spoiled_by:
        return (
            f"The samples are not what the sensor measures ({name(judgement.spoiled_by)}), so no "
            "effect was tried and no model is reported as adequate."
        )
    if not judgement.testable:
        return (
            "The model cannot be tested: no averaging time has enough neighbouring samples. Record "
            "for longer and without gaps."
        )
    if judgement.adequacy == "statistical":
        return (
            f"The model fits{reach(judgement)}: no check rejects it ({p_is(judgement.p_value)}). "
            f"{confirmed(judgement)}"
        )
    if judgement.adequacy == "practical":
        return f"The model fits{reach(judgement)}: {small(judgement)} {confirmed(judgement)}"
    if misread_alone(judgement) and judgement.reading:
        return f"The model does not fit. {misread(judgement.reading)}"
    if judgement.largest and abs(judgement.largest["percent"]) > 5:
        return f"The model does not fit. {proven(judgement.largest)}"
    error = (
        "The model does not fit. "
        f"Its error is {judgement.error / judgement.floor:.2f} times that of a true model."
    )
    if judgement.largest:
        return f"{error} {proven(judgement.largest)}"
    if judgement.farthest:
        return f"{error} The largest deviation is {off(judgement.farthest)}."
    return error


def headline(
    judgement: Judgement, duration_s: float, first: bool, known: bool = True
) -> tuple[str, str, str]:
    """The verdict in one line: (words, the words that it stresses, words). first: is this the
    model before any step. A refit can widen the largest deviation while the error falls, so a later
    step names only its place. known: does any known effect explain what is left."""
    if judgement.spoiled_by == plausible.KIND:
        return "The recording is", "implausible", ""
    if judgement.spoiled_by:
        return "The samples are", "not what the sensor measures", ""
    worst = judgement.largest or judgement.farthest
    if not judgement.testable or worst is None:
        return "The recording is", "too short", "to test a model"
    if judgement.adequate:
        tolerance = "" if judgement.adequacy == "statistical" else "within 5\u00a0% "
        return "The model", "fits", f"{tolerance}{brief_reach(judgement)}".replace(" ,", ",")
    if misread_alone(judgement) and judgement.reading:
        ratio = judgement.reading.ratio
        far = words.away(ratio) if 1e-3 < ratio < 1e3 else "more than 1000\N{MULTIPLICATION SIGN}"
        return "The white noise is off by", far, ""
    if not known:
        return "Something is missing that", "no known effect", "explains"
    start, stop, tau = worst["start_s"], worst["stop_s"], words.brief(worst["tau_s"])
    part = f", from {words.brief(start)} to {words.brief(stop)}"
    where = part if stop - start < 0.99 * duration_s else ""
    if not first:
        return "The remaining misfit is at", tau, where
    return "The model is off by", words.away(worst["ratio"]), f"at {tau}{where}"


def untested(judgement: Judgement, longest_s: float) -> str:
    """The averaging times that the verdict says nothing about. longest_s: the longest of a cell;
    "" if none can be tested."""
    if not judgement.testable:
        return ""
    if not judgement.adequate:
        return f"Not tested above {words.brief(longest_s)}"
    if not judgement.shown_to_tau_s:
        return "No averaging time is confirmed within 5 %"
    return f"Not confirmed above {words.brief(judgement.shown_to_tau_s)}"


def against(judgement: Judgement) -> str:
    """What the residual shows against a model, in a few words; "" if nothing."""
    if judgement.adequacy == "statistical" or not judgement.testable:
        return ""
    largest = judgement.largest
    if judgement.p_value < CHANCE.adequate_p:
        return f"the residual is not noise alone, {p_is(judgement.p_value)}"
    if largest:
        return f"a deviation of at least {number(abs(largest['percent']), 2)} % is proven"
    if misread_alone(judgement):
        return "the recording has another level of white noise"
    return f"the error is {judgement.error / judgement.floor:.2f} times that of a true model"


def lacks(found: Sequence[Candidate]) -> str:
    """What speaks against a model that fits: the likeliest effect, and those that the recording
    hardly tells from it, with p."""
    rivals = [one for one in found if one.log_p - found[0].log_p < CHANCE.tell_apart]
    named = words.listed(rivals[:SHOWN_AGAINST], titled, joint=" or ")
    return f"{named}, {p_is(p_of(found[0]))}"


def p_of(one: Candidate) -> float:
    """Chance of an effect, as many as are tried."""
    return min(1.0, float(np.exp(one.log_p)) * len(table.TABLE))


def titled(one: Candidate) -> str:
    """One that is not what it seems is something beyond chance all the same."""
    title = words.title(one.kind, one.part.shape)
    return f"something that resembles {title}" if one.doubt else title


def counter(one: Candidate) -> str:
    """An effect that speaks against a model, with its p."""
    return f"{titled(one)} ({p_is(p_of(one))})"


HARDLY = "the Allan deviation at the times that are tested."


def advice(against: Sequence[Candidate], which: str) -> str:
    """Of effects that are what they seem."""
    sound = any(not one.doubt for one in against)
    return f" Add {which} if you need what it changes, such as the bias." if sound else ""


def contradicted(against: Sequence[Candidate]) -> str:
    """What speaks against a model that fits, in sentences."""
    rest = len(against) - SHOWN_AGAINST
    more = f", and {rest} other{'s' * (rest > 1)}" if rest > 0 else ""
    return (
        "But the recording has effects that the model lacks: "
        f"{', '.join(map(counter, against[:SHOWN_AGAINST]))}{more}. Each p counts all effects. "
        f"They hardly change {HARDLY}{advice(against, 'one')}"
    )


def contested(judgement: Judgement, against: Sequence[Candidate]) -> str:
    """The verdict on a model, with what a search for missing effects has against it."""
    if not (judgement.adequate and against):
        return adequacy(judgement)
    return (
        f"The model fits within 5 %{reach(judgement)}, but lacks {lacks(against)}. "
        f"That hardly changes {HARDLY}{advice(against[:1], 'it')} {confirmed(judgement)}"
    ).rstrip()


def reach(judgement: Judgement) -> str:
    """The averaging times at which a fit within 5 % is shown (7.3); "" without any."""
    if not judgement.shown_to_tau_s:
        return ""
    return (
        f" from {seconds(judgement.shown_from_tau_s)} to {seconds(judgement.shown_to_tau_s)} "
        "averaging time"
    )


def brief_reach(judgement: Judgement) -> str:
    """The same for a headline."""
    if not judgement.shown_to_tau_s:
        return ", but the recording is too short to confirm it"
    first, last = words.brief(judgement.shown_from_tau_s), words.brief(judgement.shown_to_tau_s)
    return f"from {first} to {last}"


def confirmed(judgement: Judgement) -> str:
    """What is not shown."""
    return (
        "Longer averaging times are not confirmed within 5 %."
        if judgement.shown_to_tau_s
        else "The recording is too short to confirm a fit within 5 % at any averaging time. "
        "Record for longer."
    )


def small(judgement: Judgement) -> str:
    """What is left over of a model that fits within 5 %."""
    said = (
        f"no deviation above 5 % is proven. The largest proven one is {off(judgement.largest)}."
        if judgement.largest
        else f"no deviation is proven ({CONFIDENCE})."
    )
    if judgement.p_value < CHANCE.adequate_p:
        said += (
            f" Something smaller is left over: the residual is not noise alone "
            f"({p_is(judgement.p_value)})."
        )
    return said


def section(start_s: float, stop_s: float) -> str:
    """A section of a recording in s, with enough digits to tell its ends apart."""
    digits = 0 if stop_s - start_s >= 10 else 1 if stop_s - start_s >= 1 else 2
    return f"{start_s:.{digits}f} to {stop_s:.{digits}f}"


def place(deviation: Deviation) -> str:
    start, stop = deviation["start_s"], deviation["stop_s"]
    return f"at {seconds(deviation['tau_s'])}, from {section(start, stop)} s of the recording"


def off(deviation: Deviation) -> str:
    """Where and how far, and the bound of a proven deviation."""
    percent = deviation["percent"]
    bound = f" (at least {number(abs(percent), 2)} % with {CONFIDENCE})" if percent else ""
    return f"{place(deviation)}: {times(deviation['ratio'])}{bound}"


def proven(deviation: Deviation) -> str:
    """The largest deviation, as a factor by which the model is too low or too high, and its
    bound."""
    least = 1 + deviation["percent"] / 100
    return (
        f"{capital(place(deviation))}, its Allan deviation is too {'low' if least > 1 else 'high'} "
        f"by a factor of {words.factor(deviation['ratio'])} (at least {words.factor(least)} with "
        f"{CONFIDENCE})."
    )


def superfluous(kinds: Sequence[str], entries: Sequence[Entry]) -> list[str]:
    """The effects of a model that may be absent, in one sentence; none: no sentence."""
    found = [kind for kind, entry in zip(kinds, entries) if estimate.superfluous(kind, entry)]
    if not found:
        return []
    which = "them" if len(found) > 1 else "it"
    return [
        f"{capital(listed(found))} may be absent, as the 95 % interval shows. Remove {which} from "
        "the model file and fit again."
    ]


def misread_alone(judgement: Judgement) -> bool:
    """Does a model fail by its angle random walk alone, with each Allan deviation within 5 %."""
    largest = judgement.largest
    return judgement.misread and not (largest and abs(largest["percent"]) > 5)


def misread(reading: Reading) -> str:
    """By how much the record contradicts the angle random walk of a model, and what to try."""
    least = words.factor(float(np.exp(abs(reading.off))))
    away = max(reading.ratio, 1 / max(reading.ratio, 1e-9))
    far = f"{words.factor(away)} times" if away < 1000 else "more than 1000 times"
    more = reading.off > 0
    cause = (
        "An effect with the same spectrum there takes its place, such as a narrow band or short "
        "Gauss-Markov noise. Remove it, or add the filter of the sensor."
        if more
        else "The model has noise there that the recording does not have. Fit it, or remove the "
        "filter that is in front of its white noise."
    )
    return (
        f"The {'recording' if more else 'model'} has {far} the white noise of the "
        f"{'model' if more else 'recording'} (a factor of at least {least} with {CONFIDENCE}), as "
        "the Allan deviation around 1 s and the density from "
        f"{READING.low_hz:g} to {READING.high_hz:g} Hz show, both without the lines of the model. "
        f"{cause}"
    )


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
    only = "Over the whole recording, no deviation is proven, but in a part of it"
    if comparison.where:
        local = comparison.where[0]
        return (
            f"{only}: from {section(local.start_s, local.stop_s)} s, the measured Allan "
            f"deviation is {times(local.ratio)} at {seconds(local.tau_s)}."
        )
    if comparison.judgement.largest:  # in a window that the map does not show
        return f"{only}: {off(comparison.judgement.largest)}."
    return f"No deviation is proven at any averaging time or in any part ({CONFIDENCE})."


def failed_tests(tests: Mapping[str, float]) -> str | None:
    """What each failed test detects, the smallest p-value first; None when no test fails."""
    bad = [
        TESTS.get(what, what)
        for p, what in sorted((p, what) for what, p in tests.items())
        if p * JUDGE.independent_tests < CHANCE.adequate_p
    ]
    return "; ".join(bad) or None


def checks_after(p_value: float) -> str:
    """Whether the residual of the final model passes, in front of its p."""
    passes = p_value >= CHANCE.adequate_p
    return "With the added effects, " + (
        "every check of the residual passes" if passes else "the checks of the residual still fail"
    )


def observation(one: Observation) -> str:
    """A disturbance in the recording that is not an error of the sensor."""
    return f"In the recording: {name(one.kind)}. {one.detail}"


def of_comparison(comparison: Comparison, against: Sequence[Candidate] = ()) -> tuple[str, str]:
    """(tone, sentences) of a comparison. against: of a search beside this model."""
    tone = "bad" if not comparison.adequate else "missing" if against else "good"
    return tone, contested(comparison.judgement, against)


# What is missing?


def against_given(found: Improvement) -> list[Candidate]:
    """What the search has against the given model, if that fits: what is beyond chance with this
    model alone, what was added first; or what speaks against the final one."""
    alone = evidence.contradicting(found.diagnosis.ranking)
    in_front = sorted(alone, key=lambda one: one.kind not in found.added)
    return in_front if found.added else found.against


def answer(found: Improvement) -> str:
    """Which answer a diagnosis is: "fits" (nothing is missing), "contested" (it fits, but an effect
    that it lacks is beyond chance), "values" (those of the
    model file are off), "effects" (named ones are missing), "unknown" (something is missing that
    davarlab does not know), "implausible", "spoiled" or "untestable" (the recording permits no
    verdict)."""
    if found.judgement.spoiled_by:
        return "implausible" if found.judgement.spoiled_by == plausible.KIND else "spoiled"
    if not found.judgement.adequate:
        return "unknown" if found.judgement.testable else "untestable"
    if found.added:
        return "effects"
    if not found.comparison.adequate:
        return "values"
    return "contested" if found.against else "fits"


def missing(found: Improvement) -> str:
    """The answer in a few words, for a table."""
    given = answer(found)
    added = [kind_said(kind, found.model.column) for kind in found.added]
    against = lacks(found.against) if found.against else ""
    return {
        "fits": "nothing",
        "contested": f"nothing above 5 %, but {against}",
        "values": "nothing (with the values of the model file refitted)",
        "effects": ", ".join(added),
        "unknown": "something that davarlab does not know"
        + (f" (added: {', '.join(added)})" if added else ""),
        "implausible": "not tested: the recording is implausible",
        "spoiled": "not tested: the samples are not what the sensor measures",
        "untestable": "not tested: too few neighbouring samples",
    }[given]


def helpful(found: Improvement) -> bool:
    """Whether the added effects reduce the error."""
    return found.last.error < found.base.error


def of_unknown(found: Improvement) -> str:
    """The answer "unknown": something is missing, and where."""
    unexplained = found.unexplained
    assert unexplained is not None  # improve.improved() gives it to every model that fails
    added = ""
    if found.added:
        errors = f"the error from {found.base.error:.3f} to {found.last.error:.3f}"
        added = (
            f" Adding {listed(found.added)} lowers {errors}, but that is not enough."
            if helpful(found)
            else f" Adding {listed(found.added)} does not help: it changes {errors}."
        )
    return f"{UNKNOWN}{added} {final(found)}{beside(unexplained)}"


def beside(unexplained: Unexplained) -> str:
    """The frequency of a misfit and the column that moves with it, after the averaging time."""
    said = ""
    if unexplained.frequency_hz is not None and unexplained.power is not None:
        said += (
            f" At {number(unexplained.frequency_hz, 3)} Hz, the residual has "
            f"{number(unexplained.power, 2)} times the model's power."
        )
    if unexplained.column is not None and unexplained.correlation is not None:
        said += (
            f" The residual moves with {unexplained.column} (correlation "
            f"{unexplained.correlation:+.2g})."
        )
    return said


def excluded(unexplained: Unexplained) -> list[str]:
    """What was excluded, by which evidence, and what could not be tested."""

    def called(one: Excluded) -> str:
        return ("another " if one.kind in unexplained.effects else "") + name(one.kind)

    by_chance = [one for one in unexplained.excluded if one.evidence == "chance"]
    shown = [f"{called(one)} ({p_is(one.p_value or 0.0)})" for one in by_chance]
    rest = len(shown) - SHOWN_EXCLUDED
    more = f", and {rest} other{'s' * (rest > 1)}" if rest > 0 else ""
    lines = []
    if shown:
        lines.append(
            f"Excluded, because the gain is not significant: {', '.join(shown[:SHOWN_EXCLUDED])}"
            f"{more}. Each p counts all candidates."
        )
    for given, why in (
        ("no better fit", "Excluded, because the fit to the Allan deviation is not better"),
        ("worse", "Excluded, because the error rises"),
        ("untried", "Significant, but not resolved, because the search has ended"),
    ):
        kinds = [called(one) for one in unexplained.excluded if one.evidence == given]
        lines += [f"{why}: {', '.join(kinds)}."] if kinds else []
    if unexplained.untested:
        lines.append(
            f"Not tested, because the columns are absent or constant: "
            f"{', '.join(map(name, unexplained.untested))}."
        )
    return lines


def next_steps(unexplained: Unexplained) -> list[str]:
    """What to log or to try, the most promising first. Never empty."""
    deviation = unexplained.deviation
    said: dict[Hint, str] = {
        "stretch": (
            f"Look at {section(deviation['start_s'], deviation['stop_s'])} s of the recording, "
            "where something differs. Log what is switched or moved there, or exclude this "
            "section in davarlab open and fit the rest."
        ),
        "column": f"Change {unexplained.column} in steps, and record again.",
        "line": (
            f"Search for a source at {number(unexplained.frequency_hz, 3)} Hz: switch off fans, "
            "motors and supplies one at a time. At another sample rate, an alias moves."
        ),
        "quiet": (
            "Record the raw output of the sensor. The recording is quieter than the model there, "
            "as after a filter, a subtracted bias, or repeated samples."
        ),
        "slow": (
            "Record for longer at a constant temperature, and log temperature and supply voltage."
        ),
        "fast": (
            "Record at a higher sample rate, and log vibration. Take the filter of the sensor from "
            "its data sheet."
        ),
    }
    lines = [said[hint] for hint in unexplained.hints]
    needs = {need: None for needed in unexplained.untested.values() for need in needed}
    lines += [
        f"Log {LOGGED.get(need, need)}. Without it, davarlab cannot test "
        f"{listed([kind for kind, own in unexplained.untested.items() if need in own])}."
        for need in needs
    ]
    return lines or [
        "Compare the failure map and the residual spectrum with the events during the recording, "
        "and repeat the recording."
    ]


def fails_held_out(error: float | None, floor: float | None) -> bool:
    """Does a model not fit the held-out recording, by its error there; False without one."""
    return error is not None and floor is not None and error > CHANCE.held_out_above_floor * floor


def held_out_fails(found: Improvement) -> bool:
    return fails_held_out(found.last.error_held_out, found.last.error_floor_held_out)


def of_held_out(found: Improvement) -> str | None:
    """A sentence on how well the final model fits the held-out recording; None without one."""
    error, floor = found.last.error_held_out, found.last.error_floor_held_out
    if error is None or floor is None:
        return None
    sizes = f"its error there is {error:.3f}, and a true model would give about {floor:.3f}"
    return (
        f"The final model does not fit the held-out recording: {sizes}. Something differs between "
        "the two recordings. To find it, run diagnose with this model on the held-out recording."
        if held_out_fails(found)
        else f"The final model also fits the held-out recording: {sizes}."
    )


def of_missing(found: Improvement) -> str:
    added, column = found.added, found.model.column
    sizes = as_shown(found.estimates[-len(added) :], found.judgement.adequate)
    if len(added) == 1:
        rivals = [one.kind for one in undecided(found)]
        if rivals:
            return (
                f"The model lacks {listed([*added, *rivals], joint=' or ')}. This recording does "
                "not decide between them."
            )
        return (
            f"The model lacks {name(added[0])}: {words.clause(added[0])} "
            f"({words.strength(added[0], sizes[0], column)})."
        )
    named = listed(
        zip(added, sizes),
        lambda one: (
            f"{name(one[0])} ({words.strength(one[0], one[1], column, words.bare_value)})"
        ),
    )
    return f"The model lacks {named}."


def of_improvement(found: Improvement) -> tuple[str, str]:
    """(tone, sentences) of a diagnosis or an improvement."""
    tone, sentence = of_recording(found)
    outside = of_held_out(found)
    if held_out_fails(found):
        tone = "missing" if tone == "good" else tone
    return tone, f"{sentence} {outside}" if outside else sentence


def of_final_model(found: Improvement) -> str:
    """The sentences of of_improvement() for the file of the final model, which lacks nothing of
    what was added."""
    said = of_improvement(found)[1]
    if not found.added:
        return said
    return said.replace(of_missing(found), f"Added to the given model: {listed(found.added)}.")


def final(found: Improvement) -> str:
    """The verdict on the final model."""
    said = contested(found.judgement, found.against)
    if found.added:
        said = said.replace("The model ", "With the added effects, the model ", 1)
    return said


def decapitalised(text: str) -> str:
    return text[:1].lower() + text[1:]


def of_recording(found: Improvement) -> tuple[str, str]:
    given = answer(found)
    if given in WITHHELD:
        return "bad", adequacy(found.judgement)
    if given == "unknown":
        return "bad", of_unknown(found)
    if given == "effects":
        return "missing", f"{of_missing(found)} {final(found)}"
    if given == "contested":
        return "missing", final(found)
    if given == "values":
        return "missing", (
            "The model does not fit, because the values in the model file are off. With the same "
            f"effects refitted, {decapitalised(final(found))}"
        )
    whole = found.judgement.adequacy == "statistical" and not held_out_fails(found)
    return "good", f"{NOTHING} {final(found)}" if whole else final(found)


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


# What to do next?


def undecided(found: Improvement) -> list[Alternative]:
    """Alternatives to effects that the final model contains."""
    return [
        one
        for one in found.diagnosis.alternatives
        if one.named in found.added and one.kind not in found.added
    ]


def confirmations(found: Improvement) -> list[str]:
    """How to confirm each effect that was found, how to distinguish it from similar ones, and what
    is not reported, with the reason."""
    added = found.added if found.judgement.adequate or helpful(found) else []
    lines = [f"Confirm {name(kind)}: {table.find(kind).confirm}" for kind in dict.fromkeys(added)]
    lines += [one.confirm for one in undecided(found) if added]
    return lines + [
        f"Not reported as missing: {name(kind)}. Reason: {why}."
        for kind, why in found.diagnosis.doubtful.items()
    ]


def what_next(found: Improvement, run: FollowUp) -> list[Action]:
    """Actions in order: (what to do, the command that does it or None)."""
    given, added = answer(found), found.added
    lines: list[Action] = []
    if given in WITHHELD:
        return []
    if found.unexplained:
        lines += [(sentence, None) for sentence in next_steps(found.unexplained)]
    lines += [(sentence, None) for sentence in confirmations(found)]
    if found.unexplained:
        lines.append((OWN_EFFECT, "--effects FILE.py"))
    if added and run.output:
        lines.append((f"The model with {listed(added)} was written to", run.output))
    elif given == "effects":
        lines.append(
            (f"Add {listed(added)} to the model:", run.follow_up("improve", "-o", "BETTER.toml"))
        )
    elif given == "values":
        lines.append(("Refit the values:", run.follow_up("fit", "-o", "FITTED.toml")))
    return lines


def after_comparison(comparison: Comparison, state: Judged, run: FollowUp) -> list[Action]:
    """The next actions after `davarlab compare`. state: the refitted effects."""
    if comparison.adequate or not comparison.judgement.testable:
        return []
    if state.judgement.adequate:
        return [
            (
                "The same effects fit with other values. Refit them:",
                run.follow_up("fit", "-o", "FITTED.toml"),
            )
        ]
    return [(TO_FIND, run.follow_up("diagnose", "--report", "DIAGNOSIS.html"))]


def to_find(judgement: Judgement, refitted: Judgement | None = None) -> list[str]:
    """What to do before any effect was tried: about a model that fails, or that fits so far.
    refitted: the verdict on the same effects with other values."""
    if not judgement.testable:
        return []
    if judgement.adequate:
        return [UNTRIED]
    return [TO_REFIT if refitted and refitted.adequate else TO_FIND]


def no_candidate(judgement: Judgement, unexplained: Unexplained | None) -> list[str]:
    """The page, when no candidate beside a fitted model is significant."""
    if unexplained:
        return [
            f"{UNKNOWN} {adequacy(judgement)}{beside(unexplained)}",
            *excluded(unexplained),
            *next_steps(unexplained),
        ]
    if judgement.adequacy == "statistical":
        return ["No candidate is significant: no effect of the table is missing."]
    if judgement.adequate:
        return ["No candidate is significant. The rest is below 5 %."]
    return [adequacy(judgement)]
