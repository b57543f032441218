"""A visit to the workbench: which recording lies on the desk, which step one stands on, and everything that a page may ask or do."""

import contextlib
import shlex
from pathlib import Path

from .. import files, model as models, simulate
from ..data import guess, recording as recordings
from ..diagnosis import compare
from ..effects import table
from ..errors import BadInput
from ..report import export, words
from . import desk as desks, views
from .steps import Sight, Steps

ROOT = Path(__file__).resolve().parents[4]
TUTORIAL = ROOT / "data/tutorial_sensor.toml"
FOLDER = "davarlab-files"  # of what was dropped on the page, in the folder where it was opened
MODEL = "model.toml"  # as the commands that would do the same call it


class Superseded(Exception):
    """What was being computed is not wanted now."""


class Visit:
    """questions, looks and actions: name -> function of plain values that returns plain values. Questions need the bench of a fit, looks only what is
    there; actions change something."""

    def __init__(self, folder):
        self.folder, self.desk, self.steps, self.log = Path(folder), None, None, None
        self.tell = lambda **event: None
        self.hurried = lambda: False  # is an action waiting for what is being computed
        self.questions = {"step": self.step, "candidates": self.candidates, "ghost": self.ghost, "against": self.against, "preview": self.preview}
        self.looks = {"all": self.everything, "stretch": self.stretch, "spectrogram": self.spectrogram, "axes": self.axes, "sheet": self.sheet, "effects": self.effects,
                      "save": self.save}
        self.actions = {"open": self.open, "tutorial": self.tutorial, "read": self.read, "sight": self.sight, "add": self.add, "line": self.line, "set": self.set, "refit": self.refit,
                        "remove": self.remove, "restore": self.restore, "go": self.go, "close": self.close}

    def progress(self, text):
        self.tell(progress=text)

    def changed(self):
        self.tell(changed=True)
        return self.everything()

    # what lies on the desk

    def everything(self):
        """Where the visit stands; `step` gives what a step looks like."""
        if not self.desk:
            return {"recording": None, "log": self.log and desks.preview(self.log) | {"path": str(self.log), "units": guess.UNITS},
                    "folder": str(self.folder / FOLDER)}
        recording = self.desk.recording
        return {"recording": str(recording.name), "samples": recording.samples, "rate_hz": recording.rate_hz, "gaps": len(recording.gaps),
                "duration_s": recording.samples / recording.rate_hz, "column": self.desk.column,
                "columns": [name for name in recording.columns if name not in ("time_s", self.desk.column)], "gyros": self.desk.gyros,
                "sights": [{"text": text, "column": one.column, "alone": one.alone, "cut": one.cut, "here": one == self.desk.sight}
                           for text, one in ((text, Sight.of_text(text)) for text in self.steps.trees)], "current": self.steps.current, "session": str(self.steps.path),
                "steps": [{"number": s.number, "parent": s.parent, "did": s.did, "error": s.error, "floor": s.floor,
                           "adequacy": s.adequacy, "fitted": s.fitted} for s in self.steps.steps],
                "commands": [s.command for s in self.steps.way() if s.command]}

    def open(self, path, model=None):
        """A recording by its path. Columns that are not called as davarlab calls them are asked about first."""
        steps = Steps.beside(path)
        if steps.log is None and not model:
            _, columns, _ = desks.tables.read(path, ";\t,")
            found = guess.of(columns)
            if any(one.column != one.name or one.factor != 1 for one in found) or not any(one.quantity == "gyro" for one in found):
                self.desk, self.steps, self.log = None, None, Path(path)
                return self.changed()
        return self.begin(path, steps, model and models.read(model))

    def begin(self, path, steps, given=None):
        """Puts a recording on the desk and goes on where the last visit to it ended."""
        log = steps.log or {}
        recording = desks.read(path, [guess.Guess(**one) for one in log.get("columns", [])], log.get("rate_hz"))
        gyros = desks.gyro_columns(recording)
        if not gyros:
            raise BadInput(f"{path}: no column is a gyro in deg/s or rad/s")
        sight = Sight(given.column) if given else steps.sight or Sight(gyros[-1])
        self.look_at(recording, steps, sight, given)
        return self.changed()

    def look_at(self, recording, steps, sight, given=None):
        """A sight of the recording, with a first step where there is none."""
        desk = desks.Desk(recording, sight)
        before = self.desk, self.steps, self.log, steps.sight
        self.desk, self.steps, self.log, steps.sight = desk, steps, None, sight
        try:
            if given:
                self.grow("the model as given", "", given, fitted=False)
            elif not steps.steps:
                self.grow("a first model: white noise and bias instability", "", desk.first_model())
            else:
                steps.save()
        except BaseException:
            self.desk, self.steps, self.log, steps.sight = before
            raise

    def sight(self, column=None, alone=(), cut=()):
        """Another sight of the same recording: a gyro column, a stretch alone, all but what was cut out; each has steps of its own."""
        self.here()
        span, column = self.desk.whole.samples / self.desk.whole.rate_hz, column or self.desk.column
        if column not in self.desk.gyros:
            raise BadInput(f"{column}: not a gyro column of this recording")
        edges = [tuple(float(edge) for edge in pair) for pair in ([alone] if alone else []) + list(cut)]
        for pair in edges:
            if len(pair) != 2 or not 0 <= pair[0] < pair[1] <= span * 1.001:
                raise BadInput(f"{pair}: not a stretch of this recording, in seconds from 0 to {span:g}")
        self.look_at(self.desk.whole, self.steps, Sight(column, edges[0] if alone else (), () if alone else tuple(sorted(edges))))
        return self.changed()

    def read(self, columns, rate_hz=None):
        """The log as its columns were named by whoever looked at them: dicts of guess.Guess."""
        if not self.log:
            raise BadInput("no log waits to be read")
        steps = Steps.beside(self.log)
        plain = [{name: one[name] for name in ("name", "quantity", "axis", "unit", "factor")} for one in columns]
        steps.log = {"columns": plain, "rate_hz": rate_hz}
        return self.begin(self.log, steps)

    def tutorial(self):
        """The bundled sensor: made once, then opened like any recording."""
        path = self.folder / FOLDER / "tutorial_sensor.csv"
        if not path.exists():
            self.progress("making the tutorial's recording: two hours of a simulated sensor")
            path.parent.mkdir(parents=True, exist_ok=True)
            recordings.write(simulate.from_scenario(TUTORIAL, self.progress), path)
        return self.open(str(path))

    @contextlib.contextmanager
    def receive(self, name):
        """The file that a drop goes into, under its own name; there only when it came whole."""
        if not name or name != Path(name).name or name.startswith(".") or not name.isprintable():
            raise BadInput(f"{name!r}: not a name for a file")
        path = self.folder / FOLDER / name
        path.parent.mkdir(parents=True, exist_ok=True)
        part = files.partial(path)
        try:
            with open(part, "xb") as file:
                yield file
            part.replace(path)
        except OSError as why:
            raise BadInput(f"{path}: cannot be written ({files.reason(why)})") from None
        finally:
            part.unlink(missing_ok=True)

    def dropped(self, name):
        return self.open(str(self.folder / FOLDER / name))

    def close(self):
        """Back to the first page; the session stays beside its recording."""
        self.desk, self.steps, self.log = None, None, None
        return self.changed()

    # steps

    def here(self, number=None):
        if not self.desk:
            raise BadInput("no recording is open")
        return self.steps.here if number is None else self.steps.steps[self.known(number)]

    def known(self, number):
        number = int(number)
        if not 0 <= number < len(self.steps.steps):
            raise BadInput(f"there is no step {number}")
        return number

    def outcome(self, step):
        return self.desk.of(step.text, step.fitted, self.progress)

    def grow(self, did, command, model, outcome=None, fitted=True, off=()):
        """A new step. Its model file is that of the fitted values, so that a terminal gives the same."""
        outcome = outcome or self.desk.of(models.text_of(model), fitted, self.progress)
        if fitted:
            self.desk.keep(outcome)
        judgement = outcome.state.judgement
        self.steps.grow(did, command, outcome.model, fitted=fitted, off=list(off), error=judgement.error, floor=judgement.floor,
                        adequacy=judgement.adequacy)

    def command(self, name, *words_):
        return shlex.join(["tools/davarlab", name, *words_])

    @property
    def fitting(self):
        return self.command("fit", self.steps.recording, "-m", MODEL, "-o", MODEL)

    def adding(self, term):
        said = [f"{name}={value if isinstance(value, str) else format(value, '.6g')}" for name, value in term.parameters.items()]
        return self.command("add", MODEL, term.kind, *said, "-o", MODEL) + "\n" + self.fitting

    def step(self, number=None):
        """A step as the page draws it."""
        step = self.here(number)
        outcome = self.outcome(step)
        return {"number": step.number, "did": step.did, "fitted": step.fitted, "off": step.off,
                **views.model(outcome, self.desk.recording), "text": models.text_of(outcome.model)}

    def candidates(self, number=None):
        """The ranking beside a step; given up, and said so, when somebody does something meanwhile."""
        step = self.here(number)

        def partly(kind, found):
            if self.hurried():
                raise Superseded
            so_far = sorted(filter(None, found), key=lambda candidate: candidate.log_p)
            self.tell(ranking=step.number, trying=words.name(kind), candidates=views.candidates(so_far))

        try:
            return {"number": step.number, "candidates": views.candidates(self.desk.ranked(step.text, self.progress, partly))}
        except Superseded:
            return {"number": step.number, "superseded": True}

    def candidate(self, step, place):
        ranked = self.desk.ranked(step.text, self.progress)
        if not 0 <= int(place) < len(ranked):
            raise BadInput(f"there is no candidate {place}")
        return ranked[int(place)]

    def ghost(self, place, number=None):
        """The curve and the error with a candidate, before it is added."""
        step = self.here(number)
        found = self.joined(step, self.candidate(step, place))
        judgement = found.state.judgement
        return {"place": int(place), "deviation": views.deviation(found, self.desk.recording), "error": judgement.error, "floor": judgement.floor,
                "said": words.adequacy(judgement), "parameters": views.card(found, len(found.model.terms) - 1, None)["parameters"]}

    def preview(self, place, name, value):
        """The curve with one value moved, while a slider is held."""
        step = self.here()
        model = self.moved(step, place, {name: float(value)})
        return views.preview(compare.as_given(self.best(step).fitted, model))

    def moved(self, step, place, parameters):
        """The model of a step with some values of an effect set by hand."""
        model = models.of_text(step.text, "model")
        term = self.term(model, place)
        model.terms[int(place)] = models.checked_term({"kind": term.kind, **term.parameters, **parameters}, term.kind)
        models.check_lines(model.terms, model.rate_hz, term.kind)
        return model

    def joined(self, step, candidate):
        key = (step.text, candidate.kind, str(candidate.part.key))
        return self.desk.remembered(key, lambda: self.desk.with_candidate(step.text, candidate, self.progress))

    def add(self, place, number=None):
        """A candidate joins the model."""
        step = self.here(number)
        return self.join(step, self.candidate(step, place))

    def line(self, f_hz):
        """A line where somebody saw a peak; the fit moves it by less than one over the record's length."""
        step = self.here()
        return self.join(step, self.desk.line_at(float(f_hz)))

    def join(self, step, candidate):
        found = self.joined(step, candidate)
        self.steps.go(step.number)
        self.grow(f"added {words.name(candidate.kind)}", self.adding(found.model.terms[-1]), None, found, off=step.off)
        return self.changed()

    def set(self, place, parameters):
        """Values of an effect by hand; they are judged as they stand."""
        step = self.here()
        model = self.moved(step, place, parameters)
        self.grow(f"set {words.name(model.kinds[int(place)])}", "", model, self.desk.as_set(self.best(step), model), fitted=False, off=step.off)
        return self.changed()

    def best(self, step):
        """The fit that a step came from; of a model as given, the fit of its effects."""
        while not step.fitted and step.parent is not None:
            step = self.steps.steps[step.parent]
        return self.desk.of(step.text, True, self.progress)

    def term(self, model, place):
        if not 0 <= int(place) < len(model.terms):
            raise BadInput(f"there is no effect {place}")
        return model.terms[int(place)]

    def refit(self):
        """All values at their best, from where they stand."""
        step = self.here()
        self.grow("fitted", self.fitting, models.of_text(step.text, "model"),
                  off=step.off)
        return self.changed()

    def remove(self, place):
        """Switches an effect off: it stays in sight and can be switched on again."""
        step = self.here()
        model = models.of_text(step.text, "model")
        term = self.term(model, place)
        if len(model.terms) == 1:
            raise BadInput("a model needs an effect: the last one stays")
        del model.terms[int(place)]
        self.grow(f"without {words.name(term.kind)}", "", model, off=[*step.off, {"kind": term.kind, **term.parameters}])
        return self.changed()

    def restore(self, place):
        """Switches an effect on again."""
        step = self.here()
        if not 0 <= int(place) < len(step.off):
            raise BadInput(f"no effect {place} is switched off")
        model = models.of_text(step.text, "model")
        term = models.checked_term(step.off[int(place)], "an effect that was switched off")
        model.terms.append(term)
        off = [one for index, one in enumerate(step.off) if index != int(place)]
        self.grow(f"with {words.name(term.kind)} again", "", model, off=off)
        return self.changed()

    def go(self, number):
        """To another step of the tree: undo, redo, a branch."""
        self.here()
        self.steps.go(self.known(number))
        return self.changed()

    # looking closer, taking home

    def stretch(self, start_s, stop_s):
        start, stop = float(start_s), float(stop_s)
        self.here()
        span = self.desk.recording.samples / self.desk.recording.rate_hz
        if not 0 <= start < stop <= span * 1.001 or (stop - start) * self.desk.recording.rate_hz < 16:
            raise BadInput(f"{start:g} to {stop:g} s: not a stretch of this recording")
        return views.stretch(self.desk, start, min(stop, span))

    def against(self, column, lag_s=0.0):
        """What the model's courses leave of the gyro, beside another column."""
        step = self.here()
        if column not in self.desk.recording.columns:
            raise BadInput(f"no column {column}")
        if not 0 <= float(lag_s) <= self.desk.recording.samples / self.desk.recording.rate_hz:
            raise BadInput(f"a lag of {lag_s} s: from 0 to the length of the recording")
        return views.against(self.desk, step.text, column, float(lag_s))

    def spectrogram(self, column="time_s"):
        """The spectrum over the time, or over the value of a column."""
        self.here()
        if column not in self.desk.recording.columns and column != "time_s":
            raise BadInput(f"no column {column}")
        return views.spectrogram(self.desk, column)

    def axes(self):
        self.here()
        return {"axes": views.axes(self.desk)}

    def sheet(self, **given):
        """A data sheet's numbers as a curve: kind = size, in the units of a model file."""
        self.here()
        if not given or not set(given) <= set(views.SHEET):
            raise BadInput(f"a data sheet gives some of {', '.join(views.SHEET)}")
        terms = []
        for kind, value in given.items():
            try:
                terms.append(models.checked_term({"kind": kind, table.find(kind).size.name: float(value)}, kind))
            except ValueError:
                raise BadInput(f"{kind}: not a number: {value}") from None
        return views.sheet(terms, self.desk.whole.rate_hz, self.desk.whole.samples)

    def effects(self):
        return {"effects": [{"kind": e.kind, "physics": e.physics, "confirm": e.confirm} for e in table.TABLE.values()]}

    def save(self, what, number=None):
        """The model to take home: toml, or the table for the device."""
        step = self.here(number)
        if what == "toml":
            return step.text.encode()
        if what == "h":
            return export.text(export.table_of(models.of_text(step.text, "model"), 6000, 0.02), "model.h").encode()
        raise BadInput(f"{what}: toml or h")
