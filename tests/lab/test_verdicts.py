"""Whatever the state of a diagnosis, its text is honest: nothing is said to be missing only where
the model fits, a misfit that nothing explains comes with its place and a next step, and no sentence
is about an effect that is not there. States are generated; a few are reached by real searches."""

import functools
import json
import os
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Made

import asking
import lab_bench
import numpy as np
import pytest
from davarlab import model as models
from davarlab.candidates.candidate import Candidate
from davarlab.candidates.identifiable import undecided
from davarlab.data import plausible
from davarlab.data import recording as recordings
from davarlab.data.recording import Recording
from davarlab.diagnosis import evidence, improve, judge, unexplained
from davarlab.diagnosis.compare import Comparison
from davarlab.diagnosis.judge import Cell
from davarlab.effects import table
from davarlab.inference.estimate import Estimate
from davarlab.inference.parts import Part
from davarlab.model import Model, Term
from davarlab.report import terminal, values, verdict, words
from davarlab.workbench import views
from davarlab.workbench.dataset import Dataset
from davarlab.workbench.steps import Selection

GIVEN = ["angle_random_walk", "bias_instability"]
RATE, SPAN_S = 50.0, 7200.0
NONE_MISSING = re.compile(
    r"(nothing|none|no effects?|no effect of the table|not anything) (is|are) missing",
    re.IGNORECASE,
)
PLACE = re.compile(
    r"at [-+.\de·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ s( \([\d.e+]+ (min|h)\))?, from \d+ to \d+ s of the", re.I
)
KINDS = sorted(set(table.TABLE) - set(GIVEN))


def cells(rng, scale):
    """Cells of a record and of its quarters, off by about `scale`."""
    found = []
    for parts, part in ((1, 0), *((4, part) for part in range(4))):
        for octave in range(rng.integers(1, 8)):
            ratio = float(np.exp(scale * rng.normal()))
            freedom = float(rng.choice([3.0, 30.0, 3000.0]))
            z = float(np.log(ratio) * np.sqrt(2 * freedom))
            span = (SPAN_S * part / parts, SPAN_S * (part + 1) / parts)
            found.append(Cell(2.0**octave / RATE, *span, 0.01 * ratio, 0.01, ratio, z, freedom))
    return found


def state(rng, kinds, scale):
    """A comparison as any recording and model may give it."""
    there = [] if rng.random() < 0.05 else cells(rng, scale)
    p = float(rng.choice([1e-300, 1e-5, 0.02, 0.5, 1.0]))
    spoiled_by = str(rng.choice(["", plausible.KIND, "dead_zone"], p=[0.8, 0.1, 0.1]))
    made = judge.judged(there, [], p, spoiled_by)
    counts = rng.integers(0, 400, 80)
    ratio = rng.chisquare(np.maximum(counts, 1)) / np.maximum(counts, 1)
    if rng.random() < 0.5:
        ratio[rng.integers(80)] *= rng.choice([0.1, 4.0])
    names = [name for name in ("temp_degC", "accel_x_g", "supply_V") if rng.random() < 0.5]
    return Comparison(
        360000,
        RATE,
        list(kinds),
        made,
        there,
        {name: float(rng.choice([1e-9, 0.5])) for name in verdict.TESTS},
        [cell for cell, off in zip(there, judge.proven(there)) if off],
        (np.geomspace(1e-3, RATE / 2, 80), ratio, counts),
        {name: (float(rng.normal() / 10), float(rng.choice([1e-9, 0.3]))) for name in names},
        [],
        0,
        SPAN_S,
    )


def some(rng, kinds, most):
    return [str(one) for one in rng.choice(kinds, rng.integers(0, most + 1), replace=False)]


def ranking(rng):
    return [
        Candidate(
            kind,
            Part(kind, {"frequency_hz": 2.0, "column": "supply_V"}),
            1.0,
            float(rng.choice([-50.0, -5.0, -1.0, 0.0])),
        )
        for kind in some(rng, KINDS, 12)
    ]


def recording(rng):
    time = np.arange(1000) / RATE
    columns = {"gyro_z_dps": time, "accel_x_g": time * (rng.random() < 0.5)}
    return Recording(columns | ({"temp_degC": time} if rng.random() < 0.5 else {}), RATE)


def step(rng, made, added=None, outside=True):
    held, floor = (float(rng.choice([0.02, 0.5])), 0.03) if outside else (None, None)
    off = made.judgement
    return improve.Step(added, [], off.error, off.floor, held, 0.5, floor, "no")


def entries(model):
    return [
        {p.name: Estimate(1.0, 0.9, 1.1) for p in table.find(term.kind).parameters if not p.values}
        for term in model.terms
    ]


@functools.cache
def generated(seed):
    """An improvement in a state that a search may end in; what it does not compute is left out."""
    rng = np.random.default_rng(seed)
    taken = some(rng, KINDS, 4)
    added = taken[: rng.integers(0, len(taken) + 1)]
    outside = rng.random() < 0.3
    given = state(rng, GIVEN, rng.choice([0.001, 0.05, 1.0]))
    last = state(rng, [*GIVEN, *added], rng.choice([0.001, 0.05, 1.0]))
    ranked, useless = ranking(rng), some(rng, KINDS, 2)
    doubtful = dict.fromkeys(some(rng, KINDS, 2), "a column is its own noise")
    named, other = (str(one) for one in rng.choice(KINDS, 2, replace=False))
    named = str(rng.choice(taken)) if taken and rng.random() < 0.7 else named
    found = Made(
        added=taken,
        alternatives=[undecided(named, other, table.find(other).confirm)],
        ranking=ranked,
        remaining=ranked,
        useless=[Part(kind) for kind in useless],
        doubtful=doubtful,
        outdone=some(rng, sorted(set(KINDS) - set(taken)), 1),
    )
    model = Model(RATE, "gyro_z_dps", [Term(kind, {}) for kind in [*GIVEN, *added]])
    tried = unexplained.Tried(ranked, useless, doubtful, taken[len(added) :])
    return improve.Improvement(
        given,
        found,
        [step(rng, given, None, outside), *(step(rng, last, kind, outside) for kind in added)],
        improve.verdict_of(found, added, last.judgement),
        added,
        last.judgement,
        model,
        entries(model),
        [],
        [given, last] if added else [given],
        step(rng, last, None, outside) if rng.random() < 0.5 else None,
        unexplained=unexplained.unexplained_by(last, recording(rng), tried),
        against=evidence.contradicting(ranked) if last.judgement.adequate else [],
    )


def run():
    return Made(output=None, follow_up=lambda command, *options: f"tools/davarlab {command}")


@functools.cache
def texts(seed):
    """Everything that is said of a diagnosis, by where it is said."""
    found = generated(seed)
    data = json.loads(json.dumps(values.plain(values.answered(found))))
    return {
        "terminal": terminal.verdict(found),
        "page": verdict.of_improvement(found)[1],
        "page, next": "\n".join(text for text, _ in verdict.what_next(found, run())),
        "json": data["answer_said"],
        "json, next": "\n".join(data["unknown"]["next"]) if data["unknown"] else "",
        "table": f"missing is {data['missing_said']}",
        "workbench": "\n".join(verdict.no_candidate(found.judgement, found.unexplained)),
    }


SEEDS = range(400)


def test_every_answer_is_generated():
    answers = [verdict.answer(generated(seed)) for seed in SEEDS]
    kinds = ("fits", "contested", "values", "effects", "unknown", "implausible", "spoiled")
    for one in (*kinds, "untestable"):
        assert answers.count(one) > 5, one


def test_a_model_that_fails_is_never_said_to_lack_nothing():
    for seed in SEEDS:
        found, said = generated(seed), texts(seed)
        given, last = found.comparison.judgement, found.judgement
        fails = not (given.adequate or found.added) or not last.adequate
        for where, text in said.items():
            # only the fitted model is shown on the workbench
            if (
                not last.adequate
                if where == "workbench"
                else fails or verdict.held_out_fails(found)
            ):
                assert not re.search(NONE_MISSING, text), (seed, where)
        if not last.adequate:
            assert "nothing" not in said["table"], seed
            assert "The model fits" not in said["page"], seed


def test_what_speaks_against_a_model_that_fits_is_said_everywhere():
    for seed in SEEDS:
        found, said = generated(seed), texts(seed)
        if not (against := found.against):
            continue
        first = words.title(against[0].kind, against[0].part.shape)
        for where in ("terminal", "page", "json"):
            assert first in said[where], (seed, where)
            assert verdict.NOTHING not in said[where], (seed, where)
        assert verdict.of_improvement(found)[0] != "good"
        assert said["table"] != "missing is nothing"
        assert first in verdict.lacks(against)
        assert verdict.headline(found.judgement, 1.0, True)[1] == "fits"


def test_of_each_kind_the_likeliest_speaks_against_a_model():
    found = [
        Candidate(kind, Part(kind, {"column": "a"}), 1.0, log_p)
        for kind, log_p in (("follows", -20.0), ("temperature", -90.0), ("follows", -100.0))
    ]
    found.append(Candidate("rate_ramp", Part("rate_ramp"), 1.0, -6.0))  # may be chance
    against = evidence.contradicting(found)
    assert [(one.kind, one.log_p) for one in against] == [("follows", -100), ("temperature", -90)]


def test_a_model_is_contested_only_if_it_fits():
    for seed in SEEDS:
        found = generated(seed)
        given = verdict.answer(found)
        assert given != "contested" or found.comparison.adequate
        said = verdict.of_improvement(found)[1]
        if found.against and given in ("contested", "values", "effects"):
            assert f"but lacks {verdict.lacks(found.against)}" in said


def test_a_given_model_that_lacks_something_is_not_said_to_fit_without_it():
    """diagnose begins with the given model, as compare judges it before anything was tried."""
    for seed in SEEDS:
        found = generated(seed)
        against = verdict.against_given(found)
        first = terminal.diagnosis(found).split("\n\n")[0]
        if found.comparison.adequate and against:
            assert f"but lacks {words.in_ascii(verdict.lacks(against))}" in first, seed
            assert "no check rejects it" not in first, seed


def test_something_unknown_comes_with_its_place_and_a_next_step():
    for seed in SEEDS:
        found, said = generated(seed), texts(seed)
        unknown = not found.judgement.adequate and found.judgement.testable
        assert (verdict.answer(found) == "unknown") == unknown, seed
        assert (found.unexplained is not None) == unknown, seed
        for where in ("terminal", "page", "json", "workbench"):
            assert (verdict.UNKNOWN in said[where]) == unknown, (seed, where)
            assert not unknown or re.search(PLACE, said[where]), (seed, where)
        assert bool(said["json, next"].strip()) == unknown, seed
        for one in said["json, next"].splitlines():
            assert one in said["terminal"], seed
            for where in ("page, next", "workbench"):
                assert one in words.in_ascii(said[where]), (seed, where)
            assert re.search(r"^[A-Z].*\.$", one)


def test_every_kind_that_was_tried_is_excluded_with_its_evidence():
    for found in (one for one in map(generated, SEEDS) if one.unexplained):
        done = found.diagnosis
        tried = {one.kind for one in [*done.remaining, *done.useless]}
        tried |= {*done.doubtful, *done.added[len(found.added) :]}
        rows = values.plain(values.unexplained(found.unexplained))["excluded"]
        assert sorted(row["kind"] for row in rows) == sorted(tried)
        for row in rows:
            assert (row["p_value"] is not None) == (row["evidence"] in ("chance", "untried"))
            assert bool(row["why"]) == (row["evidence"] == "doubtful")
        assert not set(found.unexplained.untested) & set(found.model.kinds)


def test_no_sentence_is_about_an_effect_that_is_absent():
    for seed in SEEDS:
        found, said = generated(seed), texts(seed)["terminal"]
        for one in found.diagnosis.alternatives:
            there = one.named in found.added and one.kind not in found.added
            assert there or one.confirm not in said, seed
        for kind in set(KINDS) - set(found.added):
            assert f"Confirm {words.name(kind)}:" not in said, seed


# What commands and page really say of a recording that no effect describes: the level of its
# noise changes forty times.


def test_everywhere(lab):
    rng = np.random.default_rng(11)
    level = np.repeat(rng.choice([1.0, 4.0], 40), 500)
    made = lab_bench.of_gyro(0.02 * level * rng.normal(size=len(level)))
    path = lab_bench.write_csv(lab.work / "rec.csv", made.columns)
    start, better, page = (lab.work / name for name in ("a.toml", "b.toml", "page.html"))
    asking.run("fit", path, "-o", start)
    assert "# The model does not fit." in start.read_text()
    done = asking.run("improve", path, "-m", start, "-o", better, "--report", page)
    assert done.returncode == 1, done.stderr
    table_of_axes = asking.run("diagnose", path, "-m", start, "--axes", "gyro")
    plain = json.loads(asking.run("diagnose", path, "-m", start, "--json").stdout)
    assert (plain["answer"], plain["verdict"]) == ("unknown", "unknown")
    assert plain["unknown"]["next"] and plain["unknown"]["excluded"]
    observed = {one["kind"]: one for one in plain["observations"]}["unknown"]
    where = plain["unknown"]["where"]
    assert observed["stretches"] == [[where["start_s"], where["stop_s"]]]
    assert plain["unknown"]["next"][0] in observed["detail"]
    comments = " ".join(line[2:] for line in better.read_text().splitlines() if line[:1] == "#")
    shown = page.read_text()
    for text in (done.stdout, comments, shown, table_of_axes.stdout, plain["answer_said"]):
        assert verdict.UNKNOWN in text
        assert re.search(PLACE, text)
        assert not re.search(NONE_MISSING, text)
    for text in (done.stdout, comments, shown, table_of_axes.stdout):
        assert plain["unknown"]["next"][0] in text
    fitted = asking.run("fit", path)
    for text in (done.stdout, fitted.stdout, table_of_axes.stdout):
        assert not re.search(r"95 %: -?\d|\(-?[\d.e+]+ \.\. ", text), (
            text
        )  # no interval of such a model
    assert not plain["intervals_hold"]
    assert verdict.NOT_VALID in fitted.stdout
    again = asking.run("compare", path, "-m", better, "--json")
    assert again.returncode == 1  # comments do no harm

    dataset = Dataset(recordings.read(path), Selection("gyro_z_dps"))
    first = models.first(dataset.recording.rate_hz, dataset.column)
    for text in (models.text_of(first), better.read_text()):
        outcome = dataset.outcome_of(text, True)
        ranked = dataset.ranked(text, lambda said: None)
        found = views.ranking(outcome, dataset.recording, ranked)
        said = "\n".join(found["nothing"])
        assert not re.search(NONE_MISSING, said)
        significant = any(one["beyond_chance"] for one in views.candidates(ranked))
        assert (found["unknown"] is None) == significant
        assert (verdict.UNKNOWN in said) == (not significant)


@pytest.mark.parametrize("dps", (0.0008, 0.0012))
def test_an_effect_within_the_tolerance_is_named_by_terminal_and_page(dps):
    """The bias follows the temperature, by less than an Allan deviation shows."""
    for seed in range(3):
        rng, course = np.random.default_rng([seed, 12]), np.sin(np.linspace(0, 8, 100_000))
        made = lab_bench.of_gyro(0.02 * rng.normal(size=len(course)) + dps * course)
        made.columns["temp_degC"] = 25 + 5 * course + 0.01 * rng.normal(size=len(course))
        first = models.first(made.rate_hz, "gyro_z_dps")
        found = improve.improve(made, first)
        assert verdict.answer(found) in ("effects", "contested")
        assert "temp" in verdict.of_improvement(found)[1]
        dataset, text = Dataset(made, Selection("gyro_z_dps")), models.text_of(first)
        page = views.ranking(
            dataset.outcome_of(text, True), made, dataset.ranked(text, lambda said: None)
        )
        assert "follows temp_degC" in page["lacks"]
        assert page["against"][0].startswith("temperature")


REAL = Path(os.environ.get("DAVAR_REAL_DATA", asking.ROOT.parent / "shared/data/real"))
RECORDED = [  # an axis of each that takes seconds
    (path, f"gyro_{axis}_dps")
    for axis, path in zip(
        "zxyzxy", sorted([*REAL.glob("mpu*"), *REAL.glob("rimu*"), *REAL.glob("sense*")])
    )
]


@pytest.mark.slow
@pytest.mark.skipif(not RECORDED, reason="the real recordings are absent")
@pytest.mark.parametrize(
    "path, column",
    # turntables have many lines, and take as long as all others together
    [
        pytest.param(path, column, marks=[pytest.mark.soak] * ("40deg" in path.name))
        for path, column in RECORDED
    ],
    ids=lambda one: str(getattr(one, "name", one))[:18],
)
def test_terminal_and_page_give_the_same_answer(path, column):
    made = recordings.read(path)
    first = improve.fit(made, models.first(made.rate_hz, column))[1]
    found = improve.improve(made, first)
    dataset, text = Dataset(made, Selection(column)), models.text_of(first)
    outcome = dataset.outcome_of(text, True)
    page = views.ranking(outcome, made, dataset.ranked(text, lambda said: None))
    fits = outcome.state.judgement.adequate
    given = verdict.answer(found)
    assert (given == "fits") == (fits and not page["against"]), (given, page["against"])
    if given == "contested":
        assert page["against"][0] == found.against[0].kind


OFF = {"percent": 12.0, "ratio": 1.5, "tau_s": 2.0, "start_s": 0.0, "stop_s": 600.0}
BELOW = {**OFF, "percent": -50.0, "ratio": 0.4, "tau_s": 7200.0}
NO = "The model does not fit. At 2 s, from 0 to 600 s of the recording, its Allan deviation is too "
SENTENCES = [  # adequacy, largest deviation, words
    (
        "statistical",
        None,
        "The model fits from 0.02 s to 1 s averaging time: no check rejects it (p = 0.20). Longer "
        "averaging times are not confirmed within 5 %.",
    ),
    (
        "practical",
        None,
        "The model fits from 0.02 s to 1 s averaging time: no deviation is proven (99 % ",
    ),
    (
        "practical",
        {**OFF, "percent": -3.0, "ratio": 0.94},
        "no deviation above 5 % is proven. The largest proven one is at 2 s, from 0 to 600 s of "
        "the recording: 6 % below the model (at least 3 % with 99 % confidence).",
    ),
    ("no", OFF, NO + "low by a factor of 1.5 (at least 1.12 with 99 % confidence)."),
    ("no", BELOW, "At 7200 s (2 h), from 0 to 600 s of the recording, its"),
    ("no", BELOW, "too high by a factor of 2.5 (at least 2 with 99 % confidence)"),
    ("no", None, "4.33 times that of a true model"),
]


@pytest.mark.parametrize("word, largest, sentence", SENTENCES)
def test_the_judge_has_one_sentence_for_each_word(word, largest, sentence):
    judged = judge.Judgement(word, 0.13, 0.03, 0.2, largest, 1.0, shown_from_tau_s=0.02)
    assert sentence in verdict.adequacy(judged)
    short = replace(judged, shown_to_tau_s=0.0)
    assert "averaging time:" not in verdict.adequacy(short)
    assert word == "no" or "Record for longer" in verdict.adequacy(short)


def test_a_candidate_is_credited_with_what_it_takes_from_the_refit():
    def base(error):
        return improve.Step(None, [], error, 0.03, None, 0.2)

    assert evidence.share(float("nan"), base(0.13)) is None
    assert evidence.share(0.02, base(0.031)) is None
    assert [evidence.share(after, base(0.13)) for after in (0.13, 0.08)] == pytest.approx([0, 50])


def held(found, errors, outside=None):
    """The same with other errors of its steps, and of the last one on the held-out recording."""
    more = {"error_floor": 0.03, "error_held_out": outside, "error_floor_held_out": 0.03}
    ends = found.steps[:1] + found.steps[-1:]
    steps = [replace(one, error=error, **more) for one, error in zip(ends, errors)]
    return replace(found, steps=steps, refitted=None)


def answering(word, added):
    """Generated improvements with this answer and so many effects."""
    found = [one for one in map(generated, SEEDS) if len(one.added) == added]
    found = [one for one in found if verdict.answer(one) == word]
    assert len(found) > 5
    return found


@pytest.mark.parametrize("after, helps", [(0.1786, False), (0.05, True)])
def test_what_makes_the_error_worse_does_not_help(after, helps):
    for one in answering("unknown", 1):
        said = terminal.verdict(held(one, (0.1382, after)))
        confirm = f"Confirm {words.name(one.added[0])}"
        seen = [text in said for text in ("lowers the error", "does not help", confirm)]
        assert seen == [helps, not helps, helps], said


@pytest.mark.parametrize("outside, word", [(0.2, "does not fit"), (0.033, "also fits")])
def test_a_held_out_recording_that_is_not_explained_is_said(outside, word):
    for one in answering("fits", 0):
        found = held(one, (0.03,), outside)
        assert f"{word} the held-out recording" in terminal.verdict(found)
        assert verdict.of_improvement(found)[0] == ("good" if outside < 0.1 else "missing")


@pytest.mark.parametrize("moving", [False, True])
def test_a_column_that_does_not_move_is_named(moving):
    columns = {"gyro_z_dps": 0.4 + 0.035 * np.random.default_rng(3).normal(size=50000)}
    columns["temp_degC"] = 25 + moving * np.arange(50000) / 5e4
    notes = evidence.notes(Recording(columns, RATE), Model(RATE, "gyro_z_dps", []))
    assert any("temp_degC is constant: temperature, " in note for note in notes) != moving


def test_the_largest_deviation_of_a_misfit_is_named():
    there = [
        Cell(tau_s, 0.0, SPAN_S, 0.01 * ratio, 0.01, ratio, z, 10.0)
        for tau_s, ratio, z in ((1.28, 1.2, 26.0), (655.0, 3.8, 10.3))
    ]
    misfit = verdict.misfit(Made(where=there, duration_s=SPAN_S))
    assert "between 1.28 and 655 s (11 min). The largest deviation is at 655 s (11 min)" in misfit


def test_a_loss_is_no_gain_and_p_below_the_smallest_double_is_a_bound():
    for gain, log_p, why in (
        (-604.1, 0.0, "no likelihood gain. "),
        (4000.0, -4000.0, "likelihood gain 4000.0 (p < 1e-300)"),
        (25.0, -10 * np.log(10), "likelihood gain 25.0 (p = 1e-10)"),
    ):
        said = evidence.why(Candidate("warm_up", Part("warm_up"), gain, log_p), None)
        assert said.startswith(why)


def test_a_terminal_of_any_encoding_can_show_a_number():
    said = words.in_ascii(f"{words.number(-1.5e-7)} {words.chance(0.0)}, 95\u00a0%")
    assert said == "-1.50e-7 below 1e-12, 95 %"
