"""All axes of the recording beside each other: of each the verdict, the missing effect and the
parameters, as its own page shows them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ... import axes
from ...candidates.candidate import Candidate
from ...errors import BadInput
from ...report import words
from ...report.values import Json
from .. import views
from ..desk import Desk
from ..steps import Sight, Tree, fit_of
from .stepping import Stale, Superseded

if TYPE_CHECKING:
    from .visit import Visit


class Survey:
    """Computes the rows of all axes for a visit."""

    def __init__(self, visit: "Visit") -> None:
        self.visit = visit

    def axis(self, column: str) -> Json:
        """The row of an axis, computed on the desk on which it is opened later, at the step where
        its last visit ended; given up as a ranking is."""
        here, sight = self.visit.open_desk, Sight(column)
        if column not in here.axes:
            raise Stale(f"{column}: not a gyro or accelerometer of the open recording")
        try:
            desk = self.visit.intake.desk_at(here.whole, sight)
            row: Json = axes.spoken(self.row(desk, self.visit.open_steps.tree(sight)), column)
            return {"column": column, **row}
        except Superseded:
            return {"column": column, "superseded": True}
        except BadInput as why:  # of this axis; the others have their rows
            return {"column": column, "error": axes.in_units(str(why), column)}

    def row(self, desk: Desk, tree: Tree | None) -> Json:
        def trying(text: str) -> None:
            self.visit.stepping.give_way()
            self.visit.tell(axis=desk.sight.column, trying=text)

        def partly(kind: str, found: Sequence[Candidate | None]) -> None:
            trying(words.name(kind))

        step = tree["steps"][tree["current"]] if tree else None
        outcome = desk.of(step.text, step.fitted, trying) if step else desk.first(trying)
        fit = fit_of(step, tree["steps"]).text if tree and step else desk.text(outcome.model)
        ranked = desk.ranked(fit, trying, partly)
        return {
            **views.headline(outcome, step is None or step.parent is None),
            "adequate": outcome.state.judgement.adequate,
            "adequacy": outcome.state.judgement.adequacy,
            "cards": [views.card(outcome, place, None) for place in range(len(outcome.estimates))],
            **views.ranking(desk.of(fit, True, trying), desk.recording, ranked),
        }
