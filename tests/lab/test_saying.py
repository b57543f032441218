"""What davarlab says of a result, on made-up results."""

import unittest
from types import SimpleNamespace as Made

import numpy as np
from davarlab.candidates.candidate import Candidate
from davarlab.cli import parser
from davarlab.data.recording import Recording
from davarlab.diagnosis import evidence
from davarlab.diagnosis.cells import Cell
from davarlab.diagnosis.improve import Improvement, Step
from davarlab.diagnosis.judge import Judgement
from davarlab.diagnosis.unexplained import Unexplained
from davarlab.effects import table
from davarlab.inference.estimate import Estimate
from davarlab.inference.parts import Part
from davarlab.model import Model, Term
from davarlab.report import terminal, verdict, words

MODEL = Model(50.0, "gyro_z_dps", [Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3})])

OFF = {"percent": 12.0, "ratio": 1.5, "tau_s": 2.0, "start_s": 0.0, "stop_s": 7200.0}


def cell(tau_s, ratio, z):
    return Cell(tau_s, 0.0, 7200.0, 0.01 * ratio, 0.01, ratio, z, 10.0)


def comparison(p, cells=(), tests=None):
    return Made(
        cells=list(cells) or [cell(1.0, 1.0, 0.0)],
        samples=360000,
        rate_hz=50.0,
        duration_s=7200.0,
        effects=MODEL.kinds,
        error=0.13,
        error_floor=0.03,
        p_value=p,
        adequate=p >= 0.01,
        judgement=judgement(p),
        where=[one for one in cells if abs(one.z) > 4],
        correlations={},
        tests=tests or {},
        observations=[],
    )


def judgement(p):
    return Judgement(
        "statistical" if p >= 0.01 else "no", 0.03 if p >= 0.01 else 0.13, 0.03, p, None, 1.0
    )


def step(error, p, added=None, outside=None):
    return Step(added, MODEL.kinds, error, 0.03, outside, p, outside and 0.03)


def result(verdict="none", added=(), steps=(), refitted=None, given=None, outdone=()):
    given = given or comparison(0.0)
    found = Made(
        added=list(added),
        alternatives=[],
        ranking=[],
        remaining=[],
        useless=[],
        doubtful={},
        outdone=list(outdone),
    )
    estimates = [
        {p.name: Estimate(1.0, 0.9, 1.1) for p in table.find(kind).parameters if not p.values}
        for kind in [*MODEL.kinds, *added]
    ]
    model = Model(50.0, MODEL.column, MODEL.terms + [Term(kind, {}) for kind in added])
    last = judgement(0.0 if verdict == "unknown" else 0.5)
    return Improvement(
        given,
        found,
        list(steps) or [step(0.13, 0.0)],
        verdict,
        list(added),
        last,
        model,
        estimates,
        [],
        [given],
        refitted,
        unexplained=Unexplained(OFF, 7200.0) if verdict == "unknown" else None,
    )


class Verdicts(unittest.TestCase):
    def test_sizes_that_are_off_are_said_and_shown(self):
        found = result(refitted=step(0.031, 0.2))
        self.assertIn("the values in the model file are off", terminal.verdict(found))
        self.assertNotIn("Nothing is missing", terminal.verdict(found))
        self.assertRegex(terminal.steps(found), r"\(refitted\) +0\.0310 .* 0\.2$")

    def test_every_effect_that_was_found_is_to_be_confirmed(self):
        said = terminal.verdict(
            result(
                "warm_up",
                ("telegraph_noise", "warm_up"),
                [step(0.13, 0.0), step(0.1, 0.0), step(0.03, 0.3)],
            )
        )
        for kind in ("telegraph_noise", "warm_up"):
            self.assertIn(table.find(kind).confirm, said)

    def test_an_effect_that_a_later_one_made_useless_is_said_in_one_sentence(self):
        steps = [step(0.13, 0.0), step(0.03, 0.3)]
        said = terminal.verdict(
            result("rate_ramp", ("rate_ramp",), steps, outdone=["rate_random_walk"])
        )
        self.assertIn(
            "rate random walk was added on the way and removed again, because later effects "
            "explain it.",
            said,
        )
        self.assertNotIn(
            "removed again", terminal.verdict(result("rate_ramp", ("rate_ramp",), steps))
        )

    def test_what_makes_the_error_worse_does_not_help(self):
        for after, helps in ((0.1786, False), (0.05, True)):
            said = terminal.verdict(
                result("unknown", ("warm_up",), [step(0.1382, 0.0), step(after, 0.0, "warm_up")])
            )
            self.assertEqual("Adding warm-up lowers the error" in said, helps, said)
            self.assertEqual("does not help" in said, not helps, said)
            self.assertEqual("Confirm warm-up" in said, helps, said)

    def test_the_check_that_fails_is_named(self):
        said = terminal.verdict(
            result("unknown", given=comparison(0.0, tests={"narrow band": 1e-9, "spectrum": 0.5}))
        )
        self.assertIn("The failed checks detect: a narrow band with too much power.", said)

    def test_a_held_out_recording_that_is_not_explained_is_said(self):
        for error, sentence in (
            (0.2, "does not fit the held-out recording"),
            (0.033, "also fits the held-out recording"),
        ):
            found = result(steps=[step(0.03, 0.5, outside=error)], given=comparison(0.5))
            self.assertIn(sentence, terminal.verdict(found))
            self.assertEqual(verdict.of_improvement(found)[0], "good" if error < 0.1 else "missing")


class Sentences(unittest.TestCase):
    def test_what_there_is_more_than_one_of_is_said_once(self):
        self.assertEqual(
            words.listed(["narrow_band", "narrow_band", "shocks"]),
            "narrow band (2 times) and shocks",
        )
        several = result(
            "narrow_band",
            ["narrow_band", "narrow_band"],
            [step(0.13, 0.0), step(0.03, 0.5, "narrow_band")],
        )
        self.assertEqual(len(verdict.confirmations(several)), 1)

    def test_the_misfit_names_the_farthest(self):
        said = verdict.misfit(
            comparison(0.0, [cell(0.08, 1.01, 3.5), cell(1.28, 1.2, 26.0), cell(655.0, 3.8, 10.3)])
        )
        self.assertIn(
            "deviates from the model between 1.28 and 655 s (11 min). "
            "The largest deviation is at 655 s (11 min): 3.8 times the model, +10",
            said,
        )

    def test_the_judge_has_one_sentence_for_each_word(self):
        off = {**OFF, "stop_s": 600.0}
        below = {**off, "percent": -50.0, "ratio": 0.4, "tau_s": 7200.0}
        for word, largest, sentence in (
            ("statistical", None, "The model fits: no check rejects it (p = 0.20)."),
            ("practical", None, "The model fits: no deviation is proven (99 % confidence). "),
            (
                "practical",
                {**off, "percent": -3.0, "ratio": 0.94},
                "no deviation above 5 % is proven. The largest proven one is at 2 s, from 0 to "
                "600 s of the recording: 6 % below the model (at least 3 % with 99 % confidence).",
            ),
            (
                "no",
                off,
                "The model does not fit. At 2 s, from 0 to 600 s of the recording, its "
                "Allan deviation is too low by a factor of 1.5 (at least 1.12 with 99 % "
                "confidence).",
            ),
            (
                "no",
                below,
                "At 7200 s (2 h), from 0 to 600 s of the recording, its Allan "
                "deviation is too high",
            ),
            ("no", below, "by a factor of 2.5 (at least 2 with 99 % confidence)"),
            ("no", None, "4.33 times that of a true model"),
        ):
            self.assertIn(
                sentence, verdict.adequacy(Judgement(word, 0.13, 0.03, 0.2, largest, 1.0))
            )

    def test_a_candidate_is_credited_with_what_it_takes_from_the_refit(self):
        self.assertIsNone(evidence.share(float("nan"), step(0.13, 0.0)))
        self.assertIsNone(evidence.share(0.02, step(0.031, 0.2)))
        self.assertAlmostEqual(evidence.share(0.13, step(0.13, 0.0)), 0)
        self.assertAlmostEqual(evidence.share(0.08, step(0.13, 0.0)), 50)

    def test_gains_and_odds_are_written_as_they_are_meant(self):
        def said(gain, log_p):
            return evidence.why(Candidate("warm_up", Part("warm_up"), gain, log_p), None)

        for gain in (-604.1, -0.04):
            self.assertTrue(said(gain, 0.0).startswith("no likelihood gain. "))
        self.assertIn("(p < 1e-300)", said(4000.0, -4000.0))
        self.assertIn("(p = 1e-10)", said(25.0, -10 * np.log(10)))
        self.assertNotIn("%", said(25.0, -20.0))

    def test_an_interval_shows_its_ends(self):
        self.assertEqual(
            terminal.interval(Estimate(0.35, 0.3499996, 0.3500004)), "95 %: 0.3499996 .. 0.3500004"
        )
        self.assertEqual((terminal.p_text(0.0), terminal.p_text(0.25)), ("< 1e-12", "= 0.25"))

    def test_a_terminal_of_any_encoding_can_show_it(self):
        said = words.in_ascii(f"{words.number(-1.5e-7)} {words.chance(0.0)}, 95\u00a0%")
        self.assertEqual(said, "-1.50e-7 below 1e-12, 95 %")

    def test_help_shows_one_percent_sign(self):
        fit = next(a for a in parser()._actions if a.dest == "command").choices["fit"]
        self.assertIn("95 % intervals", fit.format_help())


class Notes(unittest.TestCase):
    def setUp(self):
        self.noise = 0.4 + 0.035 * np.random.default_rng(3).normal(size=50000)

    def test_a_column_that_does_not_move_is_named(self):
        for moving in (False, True):
            temperature = 25 + moving * np.arange(50000) / 5e4
            notes = evidence.notes(
                Recording({"gyro_z_dps": self.noise, "temp_degC": temperature}, 50.0), MODEL
            )
            self.assertEqual(
                [note for note in notes if "temp_degC is constant: temperature, " in note] == [],
                moving,
            )


if __name__ == "__main__":
    unittest.main()
