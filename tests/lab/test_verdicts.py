"""Whatever the state of a diagnosis, its text is honest: nothing is said to be missing only where
the model fits, a misfit that nothing explains comes with its place and a next step, and no sentence
is about an effect that is not there. States are generated; a few are reached by real searches."""

import functools
import json
import re
import unittest
from types import SimpleNamespace as Made

import asking
import numpy as np
from davarlab import model as models
from davarlab.candidates.candidate import Candidate
from davarlab.candidates.identifiable import undecided
from davarlab.data import plausible
from davarlab.data import recording as recordings
from davarlab.data.recording import Recording
from davarlab.diagnosis import improve, judge, unexplained
from davarlab.diagnosis.cells import Cell
from davarlab.diagnosis.compare import Comparison
from davarlab.effects import table
from davarlab.inference.estimate import Estimate
from davarlab.inference.parts import Part
from davarlab.model import Model, Term
from davarlab.report import terminal, values, verdict, words
from davarlab.workbench import views
from davarlab.workbench.desk import Desk
from davarlab.workbench.steps import Sight
from test_lab import Folder

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
    for parts in (1, 4):
        for part in range(parts):
            for octave in range(rng.integers(1, 8)):
                ratio = float(np.exp(scale * rng.normal()))
                freedom = float(rng.choice([3.0, 30.0, 3000.0]))
                z = float(np.log(ratio) * np.sqrt(2 * freedom))
                start, stop = SPAN_S * part / parts, SPAN_S * (part + 1) / parts
                found.append(
                    Cell(2.0**octave / RATE, start, stop, 0.01 * ratio, 0.01, ratio, z, freedom)
                )
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
        Candidate(kind, Part(kind), 1.0, float(rng.choice([-50.0, -5.0, -1.0, 0.0])))
        for kind in some(rng, KINDS, 12)
    ]


def recording(rng):
    time = np.arange(1000) / RATE
    columns = {"gyro_z_dps": time, **dict.fromkeys(("temp_degC", "accel_x_g"), time)}
    if rng.random() < 0.5:
        del columns["temp_degC"]
    if rng.random() < 0.5:
        columns["accel_x_g"] = 0 * time
    return Recording(columns, RATE)


def step(rng, made, added=None, outside=True):
    held = float(rng.choice([0.02, 0.5])) if outside else None
    floor = 0.03 if outside else None
    return improve.Step(
        added, [], made.judgement.error, made.judgement.floor, held, 0.5, floor, "no"
    )


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


class Generated(unittest.TestCase):
    def test_every_answer_is_generated(self):
        answers = [verdict.answer(generated(seed)) for seed in SEEDS]
        for one in ("fits", "values", "effects", "unknown", "implausible", "spoiled", "untestable"):
            self.assertGreater(answers.count(one), 5, one)

    def test_a_model_that_fails_is_never_said_to_lack_nothing(self):
        for seed in SEEDS:
            found = generated(seed)
            given, last = found.comparison.judgement, found.judgement
            said = texts(seed)
            for where, text in said.items():
                if where == "workbench":  # only the fitted model is shown there
                    fails = not last.adequate
                else:
                    fails = not (given.adequate or found.added) or not last.adequate
                if fails or verdict.held_out_fails(found) and where != "workbench":
                    self.assertNotRegex(text, NONE_MISSING, (seed, where))
            if not last.adequate:
                self.assertNotIn("nothing", said["table"], seed)
                self.assertNotIn("The model fits", said["page"], seed)

    def test_something_unknown_comes_with_its_place_and_a_next_step(self):
        for seed in SEEDS:
            found = generated(seed)
            unknown = not found.judgement.adequate and found.judgement.testable
            self.assertEqual(verdict.answer(found) == "unknown", unknown, seed)
            self.assertEqual(found.unexplained is not None, unknown, seed)
            said = texts(seed)
            for where in ("terminal", "page", "json", "workbench"):
                self.assertEqual(verdict.UNKNOWN in said[where], unknown, (seed, where))
                if unknown:
                    self.assertRegex(said[where], PLACE, (seed, where))
            if unknown:
                self.assertTrue(said["json, next"].strip(), seed)
                for one in said["json, next"].splitlines():
                    self.assertIn(one, said["terminal"], seed)
                    self.assertIn(one, words.in_ascii(said["page, next"]), seed)
                    self.assertIn(one, words.in_ascii(said["workbench"]), seed)
                    self.assertRegex(one, r"^[A-Z].*\.$")

    def test_every_kind_that_was_tried_is_excluded_with_its_evidence(self):
        for seed in SEEDS:
            found = generated(seed)
            if not found.unexplained:
                continue
            tried = {one.kind for one in found.diagnosis.remaining}
            tried |= set(found.diagnosis.doubtful) | {p.kind for p in found.diagnosis.useless}
            tried |= set(found.diagnosis.added[len(found.added) :])
            rows = values.plain(values.unexplained(found.unexplained))["excluded"]
            self.assertEqual(sorted(row["kind"] for row in rows), sorted(tried), seed)
            for row in rows:
                self.assertEqual(
                    row["p_value"] is not None, row["evidence"] in ("chance", "untried")
                )
                self.assertEqual(bool(row["why"]), row["evidence"] == "doubtful")
            absent = found.unexplained.untested
            self.assertFalse(set(absent) & set(found.model.kinds), seed)

    def test_no_sentence_is_about_an_effect_that_is_absent(self):
        for seed in SEEDS:
            found = generated(seed)
            said = texts(seed)["terminal"]
            for one in found.diagnosis.alternatives:
                there = one.named in found.added and one.kind not in found.added
                self.assertTrue(there or one.confirm not in said, seed)
            for kind in set(KINDS) - set(found.added):
                self.assertNotIn(f"Confirm {words.name(kind)}:", said, seed)

    def test_how_far_is_said_of_every_model_that_is_not_perfect(self):
        for seed in SEEDS:
            found = generated(seed).judgement
            if found.testable and not found.adequate:
                self.assertRegex(verdict.adequacy(found), PLACE, seed)
                self.assertRegex(verdict.adequacy(found), r"factor of|times|% (above|below)", seed)


class Searched(Folder):
    """What commands and page really say of a recording that no effect describes: the level of its
    noise changes forty times."""

    def test_everywhere(self):
        rng = np.random.default_rng(11)
        level = np.repeat(rng.choice([1.0, 4.0], 40), 500)
        time = np.arange(len(level)) / RATE
        path = self.work / "rec.csv"
        rows = zip(time, 0.02 * level * rng.normal(size=len(level)))
        path.write_text("time_s,gyro_z_dps\n" + "".join(f"{t:.2f},{y:.9f}\n" for t, y in rows))
        start, better, page = (self.work / name for name in ("a.toml", "b.toml", "page.html"))
        asking.run("fit", path, "-o", start)
        self.assertIn("# The model does not fit.", start.read_text())
        done = asking.run("improve", path, "-m", start, "-o", better, "--report", page)
        self.assertEqual(done.returncode, 1, done.stderr)
        table_of_axes = asking.run("diagnose", path, "-m", start, "--axes", "gyro")
        plain = json.loads(asking.run("diagnose", path, "-m", start, "--json").stdout)
        self.assertEqual((plain["answer"], plain["verdict"]), ("unknown", "unknown"))
        self.assertTrue(plain["unknown"]["next"] and plain["unknown"]["excluded"])
        observed = {one["kind"]: one for one in plain["observations"]}["unknown"]
        where = plain["unknown"]["where"]
        self.assertEqual(observed["stretches"], [[where["start_s"], where["stop_s"]]])
        self.assertIn(plain["unknown"]["next"][0], observed["detail"])
        comments = " ".join(line[2:] for line in better.read_text().splitlines() if line[:1] == "#")
        shown = page.read_text()
        for text in (done.stdout, comments, shown, table_of_axes.stdout, plain["answer_said"]):
            self.assertIn(verdict.UNKNOWN, text)
            self.assertRegex(text, PLACE)
            self.assertNotRegex(text, NONE_MISSING)
        for text in (done.stdout, comments, shown, table_of_axes.stdout):
            self.assertIn(plain["unknown"]["next"][0], text)
        again = asking.run("compare", path, "-m", better, "--json")
        self.assertEqual(again.returncode, 1)  # comments do no harm

        desk = Desk(recordings.read(path), Sight("gyro_z_dps"))
        first = models.first(desk.recording.rate_hz, desk.column)
        for text in (models.text_of(first), better.read_text()):
            outcome = desk.of(text, True)
            ranked = desk.ranked(text, lambda said: None)
            found = views.ranking(outcome, desk.recording, ranked)
            said = "\n".join(found["nothing"])
            self.assertNotRegex(said, NONE_MISSING)
            significant = any(one["beyond_chance"] for one in views.candidates(ranked))
            self.assertEqual(found["unknown"] is None, significant)
            self.assertEqual(verdict.UNKNOWN in said, not significant)


if __name__ == "__main__":
    unittest.main()
