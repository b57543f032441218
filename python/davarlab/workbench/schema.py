"""What may come in from outside: the requests of the page and the session file, each a model that
is checked in one place. A request is what the function that answers it says of its parameters."""

from collections.abc import Callable, Mapping
from functools import cache
from inspect import signature
from typing import Annotated, Any, Literal, TypedDict, get_args, get_type_hints

from pydantic import (
    AfterValidator,
    AliasChoices,
    BaseModel,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    create_model,
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
Code = Annotated[str, Field(max_length=1 << 16), AfterValidator(without_nul)]
LongText = Annotated[str, Field(max_length=1 << 20)]
Names = Annotated[list[Text], Field(min_length=1, max_length=10_000)]
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


class Sheet(TypedDict, total=False):
    """Sizes of a data sheet, in the units of a model file."""

    angle_random_walk: Number
    bias_instability: Number
    rate_random_walk: Number


class Plan(TypedDict, total=False):
    """Options of tools/davar-plan, which checks their values."""

    sensor: Text
    rate: Text
    axes: Text
    type: Text
    lsb: Text
    full_scale: Text
    bandwidth: Text
    noise: Text
    core: Text
    respond: Text
    arw_percent: Text
    longest_tau: Text
    false_alarms_per_hour: Text
    ram: Text
    flash: Text
    clock: Text


def fields_of(call: Callable[..., Any]) -> type[Given]:
    """The model of a request: the parameters of the function that answers it; `**options` are those
    of their TypedDict."""
    return _fields_of(getattr(call, "__func__", call))


@cache
def _fields_of(function: Callable[..., Any]) -> type[Given]:
    hints = get_type_hints(function, include_extras=True)
    fields: dict[str, Any] = {}
    for name, one in signature(function).parameters.items():
        if one.kind is one.VAR_KEYWORD:
            (options,) = get_args(hints[name])
            options = get_type_hints(options, include_extras=True)
            fields |= {option: (kind, None) for option, kind in options.items()}
        elif name != "self":
            fields[name] = hints[name], ... if one.default is one.empty else one.default
    return create_model(function.__name__, __base__=Given, **fields)


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
    what: str,
    call: Callable[..., Any],
    text: bytes | None = None,
    query: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """The arguments of a call, those that were given: in a JSON object, or in the query of an
    address. Raises BadInput that names the field."""
    fields = fields_of(call)
    try:
        found = (
            fields.model_validate_strings(query or {})
            if text is None
            else fields.model_validate_json(text)
        )
    except ValidationError as why:
        raise BadInput(f"{what}: {said(why)}") from None
    given = (name for name in type(found).model_fields if name in found.model_fields_set)
    return {name: getattr(found, name) for name in given}


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
