"""A visit to the workbench: which recording lies on the desk, which step one stands on, and everything that a page may ask or do."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from .. import kalibr
from .. import model as models
from ..data import guess, plausible
from ..errors import BadInput
from ..report import export, words
from . import desk as desks
from . import typed, views
from .arrivals import Arrivals
from .ears import Ears
from .looks import Looks
from .steps import Sight, Steps


class Superseded(Exception):
    """What was being computed is not wanted now."""


class Stale(BadInput):
    """An action on something that the page showed and that is not so any more."""


@dataclass
class Waiting:
    """A log that waits to be read. shown: what the page shows of it; guesses: for its columns, none while the sensor is to be chosen."""

    path: Path
    shown: dict
    guesses: list = field(default_factory=list)
    sensor: str | None = None
    model: str | None = None  # a model file to look at, once the sensor is known


class Visit:
    """questions, looks and actions: name -> function of plain values that returns plain values. Questions need the bench of a fit, looks only what is
    there; actions change something."""

    def __init__(self, folder):
        self.arrivals, self.desk, self.steps, self.held = (
            Arrivals(folder),
            None,
            None,
            None,
        )  # held: the recording that is held out
        self.not_held = ""  # why what was held out in an earlier visit is not now
        self.revision = 0  # counts the changes
        self.log = None  # one that is Waiting
        self.tell = lambda **event: None
        self.ears = Ears(self.arrivals, lambda **event: self.tell(**event))
        self.hurried = lambda: False  # is somebody waiting for what is being computed
        self.questions = {
            "step": self.step,
            "candidates": self.candidates,
            "ghost": self.ghost,
            "against": self.against,
            "preview": self.preview,
            "held_out": self.held_out,
            "report": self.report,
        }
        self.looks = {
            "all": self.everything,
            "live": self.ears.so_far,
            "save": self.save,
            **Looks(self).table,
        }
        self.actions = {
            "open": self.open,
            "tutorial": self.tutorial,
            "sensor": self.sensor,
            "read": self.read,
            "sight": self.sight,
            "add": self.add,
            "line": self.line,
            "set": self.set,
            "refit": self.refit,
            "remove": self.remove,
            "restore": self.restore,
            "go": self.go,
            "let_go": self.let_go,
            "listen": self.listen,
            "deafen": self.deafen,
            "freeze": self.freeze,
            "kalibr": self.kalibr,
            "close": self.close,
        }

    def progress(self, text):
        self.tell(progress=text)

    def changed(self):
        self.revision += 1
        self.tell(changed=self.revision)
        return self.everything()

    # what lies on the desk

    def everything(self):
        """Where the visit stands; `step` gives what a step looks like."""
        desk, steps, log, held, live = self.desk, self.steps, self.log, self.held, self.ears.where()
        if not desk:
            return {
                "again": "tools/davarlab open",
                "revision": self.revision,
                "recording": None,
                "live": live,
                "log": log and log.shown,
                "folder": str(self.arrivals.folder),
            }
        recording = desk.recording
        return {
            "revision": self.revision,
            "recording": str(recording.name),
            "live": live,
            "samples": recording.measured_samples,
            "missing": recording.samples - recording.measured_samples,
            "rate_hz": recording.rate_hz,
            "gaps": len(recording.gaps),
            "state": self.state(),
            "again": typed.again(self.steps),
            "duration_s": recording.samples / recording.rate_hz,
            "column": desk.column,
            "columns": [name for name in recording.columns if name not in ("time_s", desk.column)],
            "gyros": desk.gyros,
            "alone": desk.sight.alone,
            "cut": desk.sight.cut,
            "sights": [vars(one) | {"here": one == desk.sight} for one in steps.sights],
            "held_out": held and str(held.name),
            "not_held": self.not_held,
            "current": steps.current,
            "session": str(steps.path),
            "commands": typed.commands(steps, desk.sight),
            "steps": [
                {
                    "number": s.number,
                    "parent": s.parent,
                    "did": s.did,
                    "error": s.error,
                    "floor": s.floor,
                }
                for s in steps.steps
            ],
        }

    def open(self, path, model=None, sensor=None):
        """A recording by its path. Which sensor is meant, and columns that are not called as davarlab calls them, are asked about first."""
        steps = Steps.beside(path, sensor)
        if steps.log is None and not sensor:
            gyros = desks.gyros_in(path)
            if gyros:
                return self.ask_about(
                    Waiting(
                        Path(path),
                        {
                            "path": str(path),
                            "sensors": [{"name": one.name, "said": one.said} for one in gyros],
                        },
                        model=model,
                    )
                )
        if steps.log is None and not model:
            guesses, shown = desks.preview(path, sensor)
            if any(one.column != one.name or one.factor != 1 for one in guesses) or not {
                "gyro",
                "time",
            } <= {one.quantity for one in guesses}:
                return self.ask_about(Waiting(Path(path), shown, guesses, sensor))
        if steps.log is None and sensor:
            steps.log = {"columns": [], "rate_hz": None, "sensor": sensor}
        return self.begin(path, steps, model)

    def ask_about(self, waiting):
        self.desk, self.steps, self.log = None, None, waiting
        return self.changed()

    def waits(self):
        if not self.log:
            raise BadInput("no log waits to be read")
        return self.log

    def sensor(self, name):
        """One of the sensors of the log that waits."""
        return self.open(str(self.waits().path), self.log.model, name)

    def begin(self, path, steps, model=None):
        """Puts a recording on the desk and goes on where the last visit to it ended; `model`: a model file to look at."""
        recording = self.as_named(path, steps)
        gyros = desks.gyro_columns(recording)
        if not gyros:
            raise BadInput(
                f"{path}: no column is a gyro in deg/s or rad/s; the workbench shows gyros (for an accelerometer: tools/davarlab fit --axes accel)"
            )
        doubts = plausible.of(recording)
        if doubts:
            return self.ask_about(self.doubted(path, steps, doubts, model))
        given = model and models.read(model)
        if given:
            models.check_fits(given, recording, model)
            models.check_noise(given, model)
        sight = Sight(given.column) if given else steps.sight or Sight(gyros[-1])
        held, self.not_held = None, ""
        if steps.held_out:
            try:
                held = self.held_beside(steps.held_out, steps, sight.column)
            except BadInput as why:
                steps.held_out, self.not_held = None, f"not held out any more: {why}"
        self.look_at(recording, steps, sight, given)
        self.held = held
        return self.changed()

    @staticmethod
    def doubted(path, steps, doubts, model):
        """A recording whose rate, units or levels are implausible waits until somebody corrects or confirms them."""
        log = steps.log or {}
        guesses, shown = desks.preview(
            path, log.get("sensor"), [guess.Guess(**one) for one in log.get("columns", [])]
        )
        return Waiting(Path(path), shown | {"doubts": doubts}, guesses, log.get("sensor"), model)

    def look_at(self, recording, steps, sight, given=None):
        """A sight of the recording, with a first step where there is none. It is on the desk when all of it is there."""
        desk, before = desks.Desk(recording, sight), steps.sight
        steps.sight = sight
        try:
            if given or not steps.steps:
                model = given or desk.first_model()
                outcome = desk.of(models.text_of(model), given is None, self.progress)
                took = (
                    "the model as given"
                    if given
                    else "a first model: white noise and bias instability"
                )
                self.grown(steps, desk, took, outcome, fitted=given is None, root=True)
            else:
                steps.save()
        except BaseException:
            steps.sight = before
            raise
        self.desk, self.steps, self.log = desk, steps, None

    def sight(self, column=None, alone=(), cut=()):
        """Another sight of the same recording: a gyro column, a stretch alone, all but what was cut out; each has steps of its own."""
        self.here()
        span, column = self.desk.whole.samples / self.desk.whole.rate_hz, column or self.desk.column
        if column not in self.desk.gyros:
            raise BadInput(f"{column}: not a gyro column of this recording")
        edges = [tuple(pair) for pair in ([alone] if alone else []) + list(cut)]
        for pair in edges:
            if not 0 <= pair[0] < pair[1] <= span * 1.001:
                raise BadInput(
                    f"{pair}: not a stretch of this recording, in seconds from 0 to {span:g}"
                )
        self.look_at(
            self.desk.whole,
            self.steps,
            Sight(column, edges[0] if alone else (), () if alone else tuple(sorted(edges))),
        )
        return self.changed()

    def read(self, columns, rate_hz=None, as_recorded=False):
        """The log as its columns were named by whoever looked at them: dicts of guess.Guess; as_recorded: what was doubted is right."""
        path, guesses = self.waits().path, self.log.guesses
        if [one["name"] for one in columns] != [one.name for one in guesses]:
            raise BadInput(
                f"{path}: each of its {len(guesses)} columns must be named, in their order"
            )
        steps = Steps.beside(path, self.log.sensor)
        steps.log = {
            "columns": columns,
            "rate_hz": rate_hz,
            "sensor": self.log.sensor,
            "as_recorded": as_recorded,
        }
        return self.begin(path, steps, self.log.model)

    def tutorial(self):
        """The bundled sensor, opened like any recording."""
        return self.open(str(self.arrivals.tutorial(self.progress)))

    def hold_out(self, path):
        """A second recording of the same sensor: every step is judged on it too, and fitted on the first one only."""
        self.here()
        held = self.held_beside(path, self.steps, self.desk.column)
        self.steps.hold_out(path)
        self.held, self.not_held = held, ""
        return self.changed()

    def held_beside(self, path, steps, column):
        """A recording to hold out. Raises BadInput where it has not the gyro column."""
        held = self.as_named(path, steps)
        held.rate_dps(column)
        doubts = plausible.of(held, [column])
        if doubts:
            raise BadInput(f"{path}: doubtful: {'; '.join(doubts)}")
        return held

    def as_named(self, path, steps):
        """A recording whose columns are those that the session's log was read with."""
        log = steps.log or {}
        return desks.read(
            path,
            [guess.Guess(**one) for one in log.get("columns", [])],
            log.get("rate_hz"),
            log.get("sensor"),
            log.get("as_recorded", False),
        )

    def let_go(self):
        """No recording is held out any more."""
        self.here()
        self.steps.hold_out(None)
        self.held, self.not_held = None, ""
        return self.changed()

    def close(self):
        """Back to the first page; the session stays beside its recording."""
        self.desk, self.steps, self.log, self.held, self.not_held = None, None, None, None, ""
        return self.changed()

    # a sensor on the wire

    def listen(self, source):
        """Shows and records what a sensor sends: can:IFACE or slcan:PATH."""
        self.ears.listen(source)
        return self.changed()

    def deafen(self):
        """Nothing is listened to any more; what came is in the file."""
        self.ears.quiet()
        return self.changed()

    def freeze(self, channel):
        """The raw samples of a channel that have come so far, opened as a recording; more may come meanwhile."""
        return self.open(str(self.ears.freeze(channel)))

    # steps

    def here(self, number=None):
        """The current step; `number`: that step."""
        if not self.desk:
            raise BadInput("no recording is open")
        return self.steps.here if number is None else self.steps.steps[self.known(number)]

    def state(self, step=None):
        """Names what a page shows: the recording, the sight of it, the step and its model."""
        step = step or self.here()
        return hashlib.sha256(
            "\0".join(
                [str(self.steps.path), self.steps.sight.text, str(step.number), step.text]
            ).encode()
        ).hexdigest()[:16]

    def current(self, state):
        """The current step, if it is the one that the page showed. Raises Stale."""
        step = self.here()
        if state != self.state(step):
            raise Stale(
                "this was shown for another axis, stretch or step; nothing was changed, look at the page as it is now and try again"
            )
        return step

    def known(self, number):
        if not 0 <= number < len(self.steps.steps):
            raise BadInput(f"there is no step {number}")
        return number

    def outcome(self, step):
        return self.desk.of(step.text, step.fitted, self.progress)

    def grown(self, steps, desk, did, outcome, fitted=True, **more):
        """A new step. Its model file is that of the fitted values, so that a terminal gives the same."""
        if fitted:
            desk.keep(outcome)
        judgement = outcome.state.judgement
        steps.grow(
            did, outcome.model, fitted=fitted, error=judgement.error, floor=judgement.floor, **more
        )

    def grow(self, did, outcome, **more):
        self.grown(self.steps, self.desk, did, outcome, **more)
        return self.changed()

    def fit(self, model):
        return self.desk.of(models.text_of(model), True, self.progress)

    def step(self, number=None):
        """A step as the page draws it."""
        step = self.here(number)
        outcome = self.outcome(step)
        return {
            "number": step.number,
            "state": self.state(step),
            "did": step.did,
            "fitted": step.fitted,
            "off": step.off,
            **views.model(outcome, self.desk.recording),
            "text": models.text_of(outcome.model),
        }

    def candidates(self, number=None):
        """The ranking beside a step; given up, and said so, when somebody does something or holds a slider."""
        step = self.here(number)
        state = self.state(step)

        def partly(kind, found):
            if self.hurried():
                raise Superseded
            so_far = sorted(filter(None, found), key=lambda candidate: candidate.log_p)
            self.tell(ranking=state, trying=words.name(kind), candidates=views.candidates(so_far))

        try:
            return {
                "number": step.number,
                "state": state,
                "candidates": views.candidates(self.desk.ranked(step.text, self.progress, partly)),
            }
        except Superseded:
            return {"number": step.number, "state": state, "superseded": True}

    def candidate(self, step, place, kind):
        ranked = self.desk.ranked(step.text, self.progress)
        if place >= len(ranked):
            raise BadInput(f"there is no candidate {place}")
        return self.of_kind(ranked[place], kind)

    @staticmethod
    def of_kind(found, kind):
        """What stands at a place, if it is of the kind that the page showed there. Raises Stale."""
        if found.kind != kind:
            raise Stale(
                f"{words.name(found.kind)} stands there now, not {words.name(kind)}; nothing was changed"
            )
        return found

    def ghost(self, place, kind, state):
        """The curve and the error with a candidate, before it is added."""
        step = self.current(state)
        found = self.joined(step, self.candidate(step, place, kind))
        judgement = found.state.judgement
        return {
            "deviation": views.deviation(found, self.desk.recording),
            "error": judgement.error,
            "floor": judgement.floor,
        }

    def preview(self, place, kind, name, value, state):
        """The curve with one value moved, while a slider is held."""
        step = self.current(state)
        model = self.moved(step, place, kind, {name: value})
        return views.preview(self.desk.given(self.best(step), model))

    def moved(self, step, place, kind, parameters):
        """The model of a step with some values of an effect set by hand."""
        model = models.of_text(step.text, "model")
        term = self.of_kind(self.term(model, place), kind)
        model.terms[place] = models.checked_term(
            {"kind": term.kind, **term.parameters, **parameters}, term.kind
        )
        models.check_lines(model.terms, model.rate_hz, term.kind)
        return model

    def joined(self, step, candidate):
        key = (step.text, candidate.kind, str(candidate.part.key))
        return self.desk.remembered(
            key, lambda: self.desk.with_candidate(step.text, candidate, self.progress)
        )

    def add(self, place, kind, state):
        """A candidate joins the model."""
        step = self.current(state)
        return self.join(step, self.candidate(step, place, kind))

    def line(self, f_hz, state, wide=False):
        """A line where somebody saw a peak; the fit moves a sharp one by less than one over the record's length."""
        step = self.current(state)
        return self.join(step, self.desk.line_at(step.text, f_hz, wide))

    def join(self, step, candidate):
        found = self.joined(step, candidate)
        self.steps.go(step.number)
        return self.grow(f"added {words.name(candidate.kind)}", found, off=step.off)

    def set(self, place, kind, parameters, state):
        """Values of an effect by hand; they are judged as they stand."""
        step = self.current(state)
        model = self.moved(step, place, kind, parameters)
        return self.grow(
            f"set {words.name(model.kinds[place])}",
            self.desk.as_set(self.best(step), model),
            fitted=False,
            off=step.off,
        )

    def best(self, step):
        """The fit that a step came from; of a model as given, the fit of its effects."""
        while not step.fitted and step.parent is not None:
            step = self.steps.steps[step.parent]
        return self.desk.of(step.text, True, self.progress)

    def term(self, model, place):
        if place >= len(model.terms):
            raise BadInput(f"there is no effect {place}")
        return model.terms[place]

    def refit(self, state, held=()):
        """All values at their best, from where they stand; those of the effects at the places `held` stay."""
        step = self.current(state)
        if held:
            model = models.of_text(step.text, "model")
            places = sorted({place for place in held if self.term(model, place)})
            outcome = self.desk.around(self.best(step), model, places)
            names = ", ".join(words.name(model.kinds[place]) for place in places)
            return self.grow(f"fitted around {names}", outcome, fitted=False, off=step.off)
        return self.grow("fitted", self.fit(models.of_text(step.text, "model")), off=step.off)

    def remove(self, place, kind, state):
        """Switches an effect off: it stays in sight and can be switched on again."""
        step = self.current(state)
        model = models.of_text(step.text, "model")
        term = self.of_kind(self.term(model, place), kind)
        if len(model.terms) == 1:
            raise BadInput("a model needs an effect: the last one stays")
        del model.terms[place]
        return self.grow(
            f"without {words.name(term.kind)}",
            self.fit(model),
            off=[*step.off, {"kind": term.kind, **term.parameters}],
        )

    def restore(self, place, kind, state):
        """Switches an effect on again."""
        step = self.current(state)
        if place >= len(step.off):
            raise BadInput(f"no effect {place} is switched off")
        model = models.of_text(step.text, "model")
        term = self.of_kind(
            models.checked_term(step.off[place], "an effect that was switched off"), kind
        )
        model.terms.append(term)
        off = [one for index, one in enumerate(step.off) if index != place]
        return self.grow(f"with {words.name(term.kind)} again", self.fit(model), off=off)

    def go(self, number, state):
        """To another step of the tree: undo, redo, a branch."""
        self.current(state)
        self.steps.go(self.known(number))
        return self.changed()

    def held_out(self, number=None):
        """The error of a step on the recording that is held out, and its floor; None without one."""
        step = self.here(number)
        error, floor = self.desk.held_out(step.text, self.outcome(step).model, self.held)
        return {"number": step.number, "error": error, "floor": floor}

    # looking closer, taking home; what needs no fit is in looks.py

    def against(self, column, lag_s=0.0):
        """What the model's courses leave of the gyro, beside another column."""
        step = self.here()
        if column not in self.desk.recording.columns:
            raise BadInput(f"no column {column}")
        if not 0 <= lag_s <= self.desk.recording.samples / self.desk.recording.rate_hz:
            raise BadInput(f"a lag of {lag_s} s: from 0 to the length of the recording")
        return views.against(self.desk, step.text, column, lag_s)

    def kalibr(self, text):
        """The numbers of a kalibr file, as a data sheet's."""
        return {"sheet": kalibr.sizes(text, "the kalibr file")}

    def report(self, number=None, state=None):
        """The still page of a step: that of `davarlab compare --report`."""
        step = self.here(number) if state is None else self.current(state)
        if self.desk.sight.alone or self.desk.sight.cut:
            raise BadInput("a report is of a whole recording: look at all of it first")
        _, recording, rate = typed.in_terminal(self.steps)
        return self.desk.report(
            self.outcome(step),
            self.steps.recording,
            (recording, typed.MODEL_NAME, rate),
            self.progress,
        )

    def save(self, what, number=None, state=None):
        """The model to take home: toml, or the table for the device."""
        step = self.here(number) if state is None else self.current(state)
        if what == "toml":
            return step.text.encode()
        return export.text(
            export.table_of(models.of_text(step.text, "model"), 6000, 0.02), "model.h"
        ).encode()
