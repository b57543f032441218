"""What may come in from outside: the requests of the page and the session file, each a model that
is checked in one place."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    AliasChoices,
    BaseModel,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
)

from ..errors import BadInput

SHOWN = 80  # characters of a message


def without_nul(text: str) -> str:
    if "\0" in text:
        raise ValueError("holds a NUL character")
    return text


Number = Annotated[float, Field(allow_inf_nan=False, ge=-1e100, le=1e100)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e100)]
Place = Annotated[int, Field(ge=0, lt=1 << 31)]  # in a list: of an effect, a candidate, a step
Text = Annotated[str, Field(max_length=4096), AfterValidator(without_nul)]
FilePath = Annotated[str, Field(min_length=1, max_length=4096), AfterValidator(without_nul)]
MARKUP = "<>&%{}"
Words = Annotated[
    str, Field(max_length=4096, pattern=rf"^[^{MARKUP}\x00-\x1f\x7f]*$")
]  # of a step, which a page shows: no markup
Stretch = tuple[Number, Number]
Values = Annotated[
    dict[Text, Number | Text], Field(max_length=100)
]  # of the parameters of an effect
Selection = tuple[
    Text, tuple[()] | Stretch, list[Stretch]
]  # as in a session file: column, the stretch alone, those cut out


class Given(BaseModel):
    """Nothing but its fields, and these of their own type: no number in place of a text, no text in
    place of a number."""

    model_config = ConfigDict(extra="forbid", strict=True)


class Nothing(Given):
    pass


class Open(Given):
    path: FilePath
    model: FilePath | None = None
    sensor: Text | None = None


class Tutorial(Given):
    exercise: Text | None = None


class Sensor(Given):
    name: Text


class Names(Given):
    names: Annotated[list[Text], Field(min_length=1, max_length=10_000)]


class Skip(Given):
    lines: Place


class Column(Given):
    """A column of a log as somebody named it, or a guess of the page about it, which brings more
    along."""

    model_config = ConfigDict(extra="ignore")
    name: Text
    quantity: Literal["time", "gyro", "accel", "temp", "other"]
    axis: Literal["", "x", "y", "z"]
    unit: Text
    factor: Number
    doubt: str = ""
    unused: str = ""


class Confirmed(Column):
    """sure: its unit was chosen by somebody, or needs no guess."""

    sure: bool = False


class Read(Given):
    columns: list[Confirmed]
    rate_hz: Positive | None = None
    as_recorded: bool = False


class SelectionRequest(Given):
    column: Text | None = None
    alone: tuple[()] | Stretch = ()
    cut: list[Stretch] = []


class OfStep(Given):
    number: Place | None = None


class Shown(Given):
    """What is done to the step that a page shows: `state` names it."""

    state: Text


class OfPlace(Shown):
    """What stands at a place of it, and of what kind that is."""

    place: Place
    kind: Text


class Join(OfPlace):
    """A candidate, perhaps with another one that joins with it."""

    also: Place | None = None
    also_kind: Text = ""


class Line(Shown):
    f_hz: Number
    wide: bool = False


class Set(OfPlace):
    parameters: Values


class Refit(Shown):
    held: list[Place] = []


class Go(Shown):
    number: Place


class Listen(Given):
    source: Text


class Freeze(Given):
    channel: Place


class Kalibr(Given):
    text: Annotated[str, Field(max_length=1 << 20)]


class Axis(Given):
    column: Text
    sensor: Text | None = None


class SensorAxes(Given):
    sensor: Text


class Against(Given):
    column: Text
    lag_s: Number = 0.0


class Preview(OfPlace):
    name: Text
    value: Number


class Report(OfStep):
    state: Text | None = None


class Save(Report):
    what: Literal["toml", "h", "plan", "kalibr", "px4", "ardupilot", "ros"]


class StretchRequest(Given):
    start_s: Number
    stop_s: Number
    every: bool = False


class Spectrogram(Given):
    column: Text = "time_s"


class OwnStart(Given):
    column: Text | None = None
    kind: Text | None = None


class OwnCheck(Given):
    text: Annotated[str, Field(max_length=1 << 16), AfterValidator(without_nul)]


class OwnAdd(Shown, OwnCheck):
    pass


class Sheet(Given):
    """Sizes of a data sheet, in the units of a model file."""

    angle_random_walk: Number = 0.0
    bias_instability: Number = 0.0
    rate_random_walk: Number = 0.0


class Plan(Given):
    """Options of tools/davar-plan, which checks their values."""

    sensor: Text | None = None
    rate: Text | None = None
    axes: Text | None = None
    type: Text | None = None
    lsb: Text | None = None
    full_scale: Text | None = None
    bandwidth: Text | None = None
    noise: Text | None = None
    core: Text | None = None
    respond: Text | None = None
    arw_percent: Text | None = None
    longest_tau: Text | None = None
    false_alarms_per_hour: Text | None = None
    ram: Text | None = None
    flash: Text | None = None
    clock: Text | None = None


class Drop(Given):
    """Beside the file that is dropped."""

    model_config = ConfigDict(populate_by_name=True)
    name: Annotated[str, Field(max_length=4096)]
    purpose: Annotated[Literal["recording", "held-out"], Field(alias="as")] = "recording"


REQUESTS: dict[str, type[Given]] = {
    "open": Open,
    "tutorial": Tutorial,
    "sensor": Sensor,
    "names": Names,
    "skip": Skip,
    "read": Read,
    "selection": SelectionRequest,
    "add": Join,
    "line": Line,
    "set": Set,
    "refit": Refit,
    "remove": OfPlace,
    "restore": OfPlace,
    "go": Go,
    "let_go": Nothing,
    "listen": Listen,
    "stop_listening": Nothing,
    "freeze": Freeze,
    "kalibr": Kalibr,
    "close": Nothing,
    "own": OwnStart,
    "check_own": OwnCheck,
    "add_own": OwnAdd,
    "step": OfStep,
    "candidates": OfStep,
    "axis": Axis,
    "sensors": Nothing,
    "sensor_axes": SensorAxes,
    "candidate_preview": Join,
    "against": Against,
    "moves": Nothing,
    "preview": Preview,
    "held_out": OfStep,
    "report": Report,
    "curve": Report,
    "archive": Report,
    "all": Nothing,
    "live": Nothing,
    "save": Save,
    "stretch": StretchRequest,
    "spectrogram": Spectrogram,
    "axes": Nothing,
    "sheet": Sheet,
    "planner": Nothing,
    "plan": Plan,
    "setup": Plan,
    "drop": Drop,
}


class KeptStep(Given):
    """A step of a session file."""

    number: Place
    parent: Place | None
    did: Words
    text: str
    fitted: bool = True
    off: list[Values] = []
    error: Number | None = None
    floor: Number | None = None
    rejected: bool = False
    fits: bool | None = None


class Tree(Given):
    steps: Annotated[list[KeptStep], Field(min_length=1)]
    current: Place


class KeptColumn(Column):
    model_config = ConfigDict(extra="forbid")


class Log(Given):
    """How the columns of a log are to be read."""

    columns: list[KeptColumn]
    rate_hz: Positive | None
    sensor: Text | None = None
    as_recorded: bool = False
    names: list[Text] | None = None
    skip: Place = 0


class SessionFile(Given):
    version: Literal[1]
    sha256: str
    log: Log | None
    held_out: FilePath | None = None
    selection: str = Field(validation_alias=AliasChoices("selection", "sight"))
    trees: dict[str, Tree]


SELECTION = TypeAdapter(Selection, config=ConfigDict(strict=True))


def said(why: ValidationError) -> str:
    """The first thing that is wrong, in one line that names the field."""
    first = why.errors(include_url=False, include_input=False)[0]
    field = ".".join(map(str, first["loc"]))
    return " ".join(
        f"{field}: {first['msg'][:1].lower()}{first['msg'][1:]}".removeprefix(": ").split()
    )[: 4 * SHOWN]


def request(
    what: str, text: bytes | None = None, query: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """The fields of a request, those that were given: of a JSON object, or of the query of an
    address. Raises BadInput that names the field."""
    try:
        found = (
            REQUESTS[what].model_validate_strings(query or {})
            if text is None
            else REQUESTS[what].model_validate_json(text)
        )
    except ValidationError as why:
        raise BadInput(f"{what}: {said(why)}") from None
    return found.model_dump(exclude_unset=True)


def session(data: bytes) -> SessionFile:
    """The file in these bytes. Raises ValueError, of which said() is the reason."""
    try:
        return SessionFile.model_validate_json(data)
    except ValidationError as why:
        raise ValueError(said(why)) from None


def selection(text: str) -> tuple[str, tuple[()] | tuple[float, float], list[tuple[float, float]]]:
    """(column, stretch alone, stretches cut out) in the text of a selection. Raises ValueError."""
    try:
        return SELECTION.validate_json(text)
    except ValidationError as why:
        raise ValueError(f"selection: {said(why)}") from None
