"""What a page may ask of the open recording alone: it needs no fit, and waits for none."""

from typing import Unpack

from ... import model as models
from ...effects import table
from ...errors import BadInput
from ...report.values import Json
from .. import views
from ..dataset import Dataset
from ..schema import Number, Sheet, Text
from .standing import Standing


class Inspection:
    """Answers what needs no fit of the recording that a session has open."""

    def __init__(self, session: Standing) -> None:
        self.session = session

    def stretch(self, start_s: Number, stop_s: Number, every: bool = False) -> Json:
        start, stop, dataset = start_s, stop_s, self.there()
        span = dataset.recording.samples / dataset.recording.rate_hz
        if not 0 <= start < stop <= span * 1.001 or (stop - start) * dataset.recording.rate_hz < 16:
            raise BadInput(f"{start:g} to {stop:g} s: not a part of this recording")
        return views.stretch(dataset, start, min(stop, span), every)

    def there(self) -> Dataset:
        """The dataset, for what needs no fit: it may be cleared meanwhile."""
        return self.session.open_dataset

    def spectrogram(self, column: Text = "time_s") -> Json:
        """The spectrum over the time, or over the value of a column."""
        dataset = self.there()
        if column not in dataset.recording.columns and column != "time_s":
            raise BadInput(f"no column {column}")
        return views.spectrogram(dataset, column)

    def axes(self) -> Json:
        """The curve of every axis, and of this one in the recording that is held out; null where
        that does not have it."""
        dataset, held = self.there(), self.session.held
        column, found = dataset.selection.column, views.axes(dataset)
        there = held if held and column in held.columns else None
        return {"axes": found, "held": there and views.measured(there, column)}

    def sheet(self, **given: Unpack[Sheet]) -> Json:
        """A data sheet's numbers as a curve: kind = size, in the units of a model file."""
        dataset = self.there()
        if not given:
            raise BadInput(f"a data sheet must give at least one of {', '.join(views.SHEET)}")
        terms = [
            models.checked_term({"kind": kind, table.find(kind).size.name: value}, kind)
            for kind, value in given.items()
        ]
        return views.sheet(terms, dataset.whole.rate_hz, dataset.whole.samples)
