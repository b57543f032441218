"""What a page may ask of the recording on the desk alone: it needs no fit, and waits for none."""

from ... import axes
from ... import model as models
from ...effects import table
from ...errors import BadInput
from ...report.values import Json
from .. import views
from ..desk import Desk
from .standing import Standing


class Looks:
    """Answers what needs no fit of the recording that a visit has open."""

    def __init__(self, visit: Standing) -> None:
        self.visit = visit

    def stretch(self, start_s: float, stop_s: float, every: bool = False) -> Json:
        start, stop, desk = start_s, stop_s, self.there()
        span = desk.recording.samples / desk.recording.rate_hz
        if not 0 <= start < stop <= span * 1.001 or (stop - start) * desk.recording.rate_hz < 16:
            raise BadInput(f"{start:g} to {stop:g} s: not a part of this recording")
        found = views.stretch(desk, start, min(stop, span), every)
        said: Json = axes.spoken(found, desk.sight.column)
        return said

    def there(self) -> Desk:
        """The desk, for what only looks: it may be cleared meanwhile."""
        return self.visit.open_desk

    def spectrogram(self, column: str = "time_s") -> Json:
        """The spectrum over the time, or over the value of a column."""
        desk = self.there()
        if column not in desk.recording.columns and column != "time_s":
            raise BadInput(f"no column {column}")
        return views.spectrogram(desk, column)

    def axes(self) -> Json:
        return {"axes": views.axes(self.there())}

    def sheet(self, **given: float) -> Json:
        """A data sheet's numbers as a curve: kind = size, in the units of a model file."""
        desk = self.there()
        if not given:
            raise BadInput(f"a data sheet must give at least one of {', '.join(views.SHEET)}")
        terms = [
            models.checked_term({"kind": kind, table.find(kind).size.name: value}, kind)
            for kind, value in given.items()
        ]
        return views.sheet(terms, desk.whole.rate_hz, desk.whole.samples)
