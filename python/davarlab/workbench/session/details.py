"""The details of a step, and the files that are written of it."""

import glob
import io
import zipfile
from pathlib import Path
from typing import Literal

from ... import kalibr
from ... import model as models
from ...diagnosis import fitting
from ...diagnosis.state import spoiler_of
from ...errors import BadInput
from ...model import is_accel
from ...report import declared, export, parameters, verdict
from ...report.values import Json
from .. import typed, views
from ..schema import LongText, Number, Place, Text
from ..steps import Step
from .standing import Standing
from .stepping import Stepping

Output = Literal["toml", "h", "plan", "kalibr", "px4", "ardupilot", "ros"]
WINDOW = 6000  # samples of the device's window, as davarlab export has it


class Details:
    """Answers what needs a fit, and writes files, for a session. What needs no fit is in
    inspection.py."""

    def __init__(self, session: Standing, stepping: Stepping) -> None:
        self.session, self.stepping = session, stepping

    def against(self, column: Text, lag_s: Number = 0.0) -> Json:
        """What the model's courses leave of the gyro, beside another column."""
        step = self.stepping.here()
        if column not in self.session.open_dataset.recording.columns:
            raise BadInput(f"no column {column}")
        if (
            not 0
            <= lag_s
            <= self.session.open_dataset.recording.samples
            / self.session.open_dataset.recording.rate_hz
        ):
            raise BadInput(f"a lag of {lag_s} s: from 0 to the length of the recording")
        return views.against(self.session.open_dataset, step.text, column, lag_s)

    def moves(self) -> Json:
        """What bias and noise move with, of every logged column."""
        return {"moves": views.moves(self.session.open_dataset, self.stepping.here().text)}

    def report(self, number: Place | None = None, state: Text | None = None) -> bytes:
        """The still page of a step: that of `davarlab compare --report`, with the steps to it and
        the other effects that were tried."""
        step, dataset = self.stepping.shown(number, state), self.session.open_dataset
        if self.session.open_dataset.selection.alone or self.session.open_dataset.selection.cut:
            raise BadInput("a report is of a whole recording: look at all of it first")
        _, recording, options = typed.in_terminal(self.session.open_steps)
        way, progress = self.session.open_steps.way(step), self.session.progress
        return dataset.report(
            self.stepping.outcome(step),
            self.stepping.outcome(way[0]),
            dataset.ranked(self.stepping.fitted_step(step).text, progress),
            self.session.open_steps.recording,
            (Path(recording).name, typed.MODEL_NAME, options),
            [self.told(one) for one in way],
            progress,
        )

    def curve(self, number: Place | None = None, state: Text | None = None) -> bytes:
        """The Allan curve of a step as CSV: measured, model, its 95 % band, and each effect."""
        step = self.stepping.shown(number, state)
        found = self.stepping.step(step.number)["deviation"]
        unit = "mps2" if is_accel(self.session.open_dataset.selection.column) else "dps"
        columns = {"tau_s": found["tau_s"]}
        columns |= {f"{key}_{unit}": found[key] for key in ("measured", "model", "low", "high")}
        for place, effect in enumerate(found["effects"], 1):  # a kind may be there twice
            columns[f"{place}_{effect['kind']}_{unit}"] = effect["deviation"]
        rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns.values())]
        return "\n".join([",".join(columns), *rows, ""]).encode()

    def archive(self, number: Place | None = None, state: Text | None = None) -> bytes:
        """Session, recording and own effects as a zip archive: unpacked, `davarlab open` goes on
        where this session is."""
        self.stepping.shown(number, state)
        steps = self.session.open_steps
        recording = Path(steps.recording)
        parts = [recording, *recording.rglob("*"), Path(steps.path)]
        parts += recording.parent.glob(f"{glob.escape(recording.name)}.*.py")
        made = io.BytesIO()
        with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
            for part in filter(Path.is_file, parts):
                archive.write(part, part.relative_to(recording.parent))
        return made.getvalue()

    def told(self, step: Step) -> Json:
        """A step as the report tells it."""
        held = self.session.held and self.stepping.held_out(step)
        return {
            "label": step.did,
            "error": step.error,
            "floor": step.floor,
            "fits": step.fits,
            "held_out": held and held[0],
        }

    def save(self, what: Output, number: Place | None = None, state: Text | None = None) -> bytes:
        """The model to take home: toml, the table for the device (h), its filter (plan), or the
        parameters of another program."""
        step, dataset = self.stepping.shown(number, state), self.session.open_dataset
        spoiler = spoiler_of(fitting.observed(dataset.recording, dataset.column))
        if spoiler:
            raise BadInput(f"no model is exported. {verdict.observation(spoiler)}")
        if what == "toml":
            return step.text.encode()
        model = models.of_text(step.text, "model")
        if what == "plan":
            found = declared.declare(model, typed.MODEL_NAME, WINDOW)
            notes = declared.notes(found, model, typed.MODEL_NAME, None)
            return declared.text(found, notes).encode()
        if what == "h":
            return export.text(export.table_of(model, WINDOW, 0.02), "model.h").encode()
        return parameters.text(what, [(typed.MODEL_NAME, model)]).encode()

    def kalibr(self, text: LongText) -> Json:
        """The numbers of a kalibr file, as a data sheet's."""
        accel = self.session.dataset and is_accel(self.session.dataset.selection.column)
        kinds = kalibr.ACCEL_KINDS if accel else kalibr.KINDS
        return {"sheet": kalibr.sizes(text, "the kalibr file", kinds)}
