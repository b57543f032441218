"""A model and a recording: the parts of the model, what they are fitted on, and the judgement."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..arrays import Bools, Floats
from ..data import plausible
from ..data.events import Shocks
from ..data.observations import Observation
from ..inference.adequacy import Adequacy
from ..inference.changes import Blocks
from ..inference.parts import Bench, Part
from ..inference.whittle import Fit
from ..model import kind_said
from .judge import Cell, Judgement

Progress = Callable[[str], None]  # receives what is being done


@dataclass(frozen=True, eq=False)
class State:
    """A model at its best on one recording; what changes it returns another. known: True where a
    sample was measured and may be used, None: everywhere; the others are drawn. seen: the
    observations on the recording."""

    bench: Bench
    parts: tuple[Part, ...]
    fit: Fit
    shocks: Shocks
    blocks: Blocks | None = None
    adequacy: Adequacy | None = None
    cells: tuple[Cell, ...] = ()
    judgement: Judgement | None = None
    known: Bools | None = None
    seen: tuple[Observation, ...] = ()

    @property
    def spoiled_by(self) -> str:
        """The observation for which no model of the recording is adequate, "" without one: it is
        implausible, or its samples are not what the sensor measures."""
        return spoiler.kind if (spoiler := spoiler_of(self.seen)) else ""

    @property
    def spoiled(self) -> bool:
        """Are the samples not what the sensor measures."""
        return any(one.spoils for one in self.seen)

    @property
    def model_kinds(self) -> list[str]:
        return [part.kind for part in self.parts]

    @property
    def kinds_said(self) -> str:
        """The kinds, as a model file of the column has them."""
        return ", ".join(kind_said(kind, self.bench.gyro or "") for kind in self.model_kinds)

    @property
    def record(self) -> Floats:
        """What the Allan deviation is measured of: the gyro, without the shocks that the model
        has."""
        return self.shocks.clean if "shocks" in self.model_kinds else self.shocks.raw


@dataclass(frozen=True, eq=False, kw_only=True)
class Judged(State):
    """A state whose adequacy and judgement are computed."""

    adequacy: Adequacy
    judgement: Judgement


def spoiler_of(seen: Sequence[Observation]) -> Observation | None:
    """The first observation for which no model is adequate."""
    return next((one for one in seen if one.kind == plausible.KIND or one.spoils), None)
