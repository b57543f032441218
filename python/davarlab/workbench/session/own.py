"""Effects that a person writes in the page: one file each beside the session, which runs as whoever
started the server."""

import contextlib
import glob
import itertools
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ... import files
from ...data.recording import Recording
from ...diagnosis import search
from ...effects import own, table
from ...effects.base import Effect, Values, needed
from ...errors import BadInput
from ...report.values import Json
from .. import dataset as datasets
from ..schema import Code, Text
from ..steps import ENDING
from .standing import Standing
from .stepping import Stepping
from .survey import Survey

DENSITIES = 200  # points of a spectrum
TEMPLATE = '''import numpy as np
from davarlab.effects.base import Effect, Parameter

def bias(recording, shape):
    """One value per sample. The fit finds its factor."""
    return {course}

OWN = Effect(
    kind="own_effect", role="mean", regressor=bias,
    parameters=(Parameter("coefficient", "deg/s", -1e9, 1e9),),  # m/s^2 of an accelerometer
    physics="The bias follows {what}.", signature="",
    confirm="Keep {what} constant.")
'''


def template(column: str | None) -> str:
    """An effect to start from: of a column of the recording, or of the time alone."""
    if column is None:
        course, what = "np.sin(2 * np.pi * recording.time_s / 600)", "a cycle"
    else:
        course = f"recording.column({json.dumps(column, ensure_ascii=False)})"
        what = "".join(one for one in column if one.isalnum() or one in "_ ")
    return TEMPLATE.format(course=course, what=what)


def answers(effect: Effect, recording: Recording) -> Json:
    """What the functions of an effect return on a recording, for a page to draw. Raises BadInput
    for what is wrong with it."""
    shape: Values = {
        one.name: next(iter(effect.grid[one.name](recording)), one.default)
        for one in effect.parameters
        if one.name in effect.shape_names
    }
    if effect.role != "spectrum":
        course = needed(effect.regressor)(recording, shape)
        if not np.ptp(course):
            known = "the mean of the axis" if effect.role == "mean" else "white noise"
            raise BadInput(f"the regressor is constant, which is {known} already")
        said = f"{len(course)} values from {course.min():.4g} to {course.max():.4g}"
        return {"said": said, "course": datasets.picture(course)}
    f = np.geomspace(recording.rate_hz / recording.samples, recording.rate_hz / 2, DENSITIES)
    density = needed(effect.spectrum)(f, recording.rate_hz, shape)
    said = f"densities from {density.min():.4g} to {density.max():.4g}"
    return {"said": said, "f_hz": f.tolist(), "density": density.tolist()}


class Own:
    """The effects of a session. kept: by recording, kind -> (effect, file, text), the one that was
    written last at the end; they are in the table while that recording is open."""

    def __init__(self, session: Standing, stepping: Stepping, survey: Survey) -> None:
        self.session, self.stepping, self.survey = session, stepping, survey
        self.kept: dict[str, dict[str, tuple[Effect, str, str]]] = {}
        self.at = ""  # the recording whose effects are in the table

    @contextlib.contextmanager
    def loaded(self, path: str) -> Iterator[None]:
        """Has the effects of a recording in the table, not those of the one before; those of that
        one again where the recording cannot be opened."""
        before = self.at
        self.go(os.path.realpath(path))
        try:
            yield
        except BaseException:
            self.go(before)
            raise

    def go(self, path: str) -> None:
        """Has the effects of another recording in the table, "" for none: those that were written
        here, and those that --effects loaded from the files that Add writes."""
        for kind in self.kept.get(self.at, {}):
            own.drop(kind)
        self.at = path
        mine = self.kept.setdefault(path, {})
        for effect, file, _ in mine.values():
            own.install(effect, file)
        for kind, file in own.LOADED.items():
            if kind not in mine and os.path.realpath(file) == f"{path}.{kind}.py":
                with contextlib.suppress(BadInput, UnicodeDecodeError):
                    mine[kind] = table.find(kind), file, own.text_of(file).decode()

    def start(self, column: Text | None = None, kind: Text | None = None) -> Json:
        """What the editor begins with: a template for a column of the recording; `kind`: the code
        of this effect, under a new kind, because steps that have it keep theirs."""
        dataset = self.session.open_dataset
        others = [
            name for name in dataset.recording.columns if name not in ("time_s", dataset.column)
        ]
        free = next((name for name in others if name not in dataset.axes), None)
        what = column if column in others else free
        text = template(what) if kind is None else self.renamed(kind)
        return {"text": text, "gyro": datasets.picture(dataset.recording.rate_dps(dataset.column))}

    def kinds(self) -> list[str]:
        """Those written in the page for the open recording."""
        return list(self.kept.get(self.at, {}))

    def renamed(self, kind: str) -> str:
        """The code of an effect, under the first free kind. Raises BadInput."""
        if kind not in self.kinds():
            raise BadInput(f"{kind} was not written in the page for this recording")
        first = re.sub(r"_\d+$", "", kind)
        names = (f"{first}_{number}" for number in itertools.count(2))
        free = next(
            one for one in names if one not in table.TABLE and not os.path.lexists(self.file(one))
        )
        text = self.kept[self.at][kind][2]
        return re.sub(rf"(\bkind\s*=\s*)([\"']){kind}\2", rf"\1\g<2>{free}\2", text)

    def made(self, text: str) -> Effect:
        """The one effect of a text. Raises BadInput."""
        found = own.read("the editor", text.encode())
        if len(found) > 1:
            raise BadInput(f"{len(found)} effects; write one at a time")
        return found[0]

    def checked(self, text: str) -> tuple[Effect, Json]:
        """(the effect of a text, its answers on the recording). Raises BadInput that begins with
        what is wrong."""
        try:
            effect = self.made(text)
            return effect, answers(effect, self.session.open_dataset.recording)
        except BadInput as why:
            raise BadInput(str(why).removeprefix("--effects: the editor: ")) from None

    def check(self, text: Code) -> Json:
        """The live check: compiles, defines an effect, returns what it must on this recording."""
        try:
            effect, found = self.checked(text)
        except BadInput as why:
            return {"error": str(why)}
        return {"kind": effect.kind, "file": self.file(effect.kind), **found}

    def file(self, kind: str) -> str:
        return f"{self.session.open_steps.recording}.{kind}.py"

    def add(self, text: Code, state: Text) -> Json:
        """The effect joins the table and the model. Its file is written beside the session."""
        step = self.stepping.current(state)
        effect, _ = self.checked(text)
        with self.keeping(effect, text):
            best = self.stepping.best(step)
            found = search.ranking(best.fitted, only=[effect.kind])
            if not found:
                raise BadInput(
                    f"{effect.kind}: it is in the model already, or it needs a column that this "
                    "recording lacks"
                )
            return self.stepping.join(step, found[:1])

    @contextlib.contextmanager
    def keeping(self, effect: Effect, text: str) -> Iterator[None]:
        """Has an effect in the table and its file written, but neither where what follows fails.
        What a step uses stays as it is."""
        kind, file = effect.kind, self.file(effect.kind)
        mine, data = self.kept.setdefault(self.at, {}), text.encode()
        there = files.read_whole(file) if os.path.lexists(file) else None
        before = mine.get(kind)
        if before and there == data:
            yield
            return
        if there not in (None, data) and (not before or self.used(kind)):
            raise BadInput(
                f"{Path(file).name} exists and has other code"
                + (", which a step uses" if before else "")
                + ". Write another kind"
            )
        if not before and kind in table.TABLE:
            raise BadInput(f"kind {kind} is taken. Write another kind")
        files.write_whole(file, data, follow=False)
        self.put(kind, (effect, file, text))
        try:
            yield
        except BaseException:
            self.put(kind, before)
            if there is None:
                os.unlink(file)
            else:
                files.write_whole(file, there, follow=False)
            raise

    def put(self, kind: str, entry: tuple[Effect, str, str] | None) -> None:
        """Has this as the effect of the kind, None: no effect. No dataset keeps what it computed
        with the one before."""
        mine = self.kept[self.at]
        gone = mine.pop(kind, None)
        if gone:
            own.drop(kind)
        for dataset in (self.session.open_dataset, *self.session.datasets.values()):
            dataset.forget(fits=gone is not None)
        self.survey.beside = None
        if entry:
            own.install(entry[0], entry[1])
            mine[kind] = entry

    def used(self, kind: str) -> bool:
        """Does a step of a session of the recording have an effect of this kind: a log has one
        session for each of its sensors."""
        recording = Path(self.session.open_steps.recording)
        names = f"{glob.escape(recording.name)}*{ENDING}"
        word = re.compile(rf'"{kind}\\?"'.encode())  # in a model file of the session, or beside it
        return any(word.search(files.read_whole(one)) for one in recording.parent.glob(names))
