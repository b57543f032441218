"""People's own effects: a Python file that is not trusted to be right. What is wrong with it is
said in one line that names file and effect, when it is loaded or when one of its functions is first
asked."""

import contextlib
import ctypes
import sys
import threading
import types
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .. import files
from ..arrays import Floats
from ..data.recording import Recording
from ..errors import BadInput, printable
from ..files import StrPath
from . import table
from .base import Effect, Grid, Parameter, Spectrum, Values

Answer = TypeVar("Answer")


LONGEST_S = 10.0  # that a call of somebody's code takes in a server
LOADED: dict[str, str] = {}  # kind -> the file that defines it


def text_of(path: StrPath) -> bytes:
    """What is in a Python file."""
    if Path(path).suffix != ".py":
        raise BadInput(f"--effects: {path}: a Python file (.py) expected")
    try:
        return files.read_whole(path)
    except BadInput as why:
        raise BadInput(f"--effects: {why}") from None


def executed(path: StrPath, text: bytes) -> types.ModuleType:
    """The module of a Python file; what it prints goes to standard error. No bytecode is left
    beside it."""
    module = types.ModuleType(Path(path).stem)
    module.__file__ = str(path)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            within(lambda: exec(compile(text, path, "exec"), module.__dict__))
    except BadInput as why:
        raise BadInput(f"--effects: {path}: {why}") from None
    except (
        Exception,
        SystemExit,
    ) as why:  # the person's own code: whatever it raises is a mistake in that file
        raise BadInput(f"--effects: {path}: {in_one_line(why)}") from None
    return module


def in_one_line(why: BaseException) -> str:
    try:
        said = " ".join(str(why).split())
    except Exception:  # of a class in that file
        said = "no message"
    return f"{type(why).__name__}: {printable(said)}"


def within(work: Callable[[], Answer]) -> Answer:
    """What somebody's code answers. In the main thread Ctrl-C ends a loop without an end; nothing
    ends it in the worker of a server, so there the code runs in a thread that is stopped after
    LONGEST_S. Raises BadInput then, and what the code raised."""
    if threading.current_thread() is threading.main_thread():
        return work()
    found: list[Answer] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            found.append(work())
        except BaseException as why:  # of the code, or the SystemExit that stops it
            failed.append(why)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(LONGEST_S)
    if found:
        return found[0]
    for why in failed:
        raise why if isinstance(why, Exception) else BadInput(in_one_line(why))
    assert thread.ident is not None  # it has started
    ctypes.pythonapi.PyThreadState_SetAsyncExc(
        ctypes.c_ulong(thread.ident), ctypes.py_object(SystemExit)
    )
    raise BadInput(f"the code did not return within {LONGEST_S:g} s")


def unwritable(argument: Any) -> Any:
    """An argument for somebody's code, which cannot change what the program goes on with."""
    if isinstance(argument, np.ndarray):
        view = argument.view()
        view.flags.writeable = False
        return view
    if isinstance(argument, Recording):
        columns = {name: unwritable(column) for name, column in argument.columns.items()}
        return replace(argument, columns=columns, known=unwritable(argument.known))
    return dict(argument) if isinstance(argument, Mapping) else argument


def asked(where: str, function: Callable[..., Answer], *arguments: Any) -> Answer:
    """What a function of the file answers."""

    def work() -> Answer:
        with np.errstate(all="ignore"):  # the answer is looked at anyway
            return function(*map(unwritable, arguments))

    try:
        return within(work)
    except BadInput as why:
        raise BadInput(f"{where}: {why}") from None
    except (Exception, SystemExit) as why:  # as above
        raise BadInput(f"{where}: {in_one_line(why)}") from None


def numbers(where: str, value: Any, shape: tuple[int, ...]) -> Floats:
    try:
        found = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"{where}: not an array of numbers") from None
    if found.shape != shape:
        raise BadInput(
            f"{where}: {found.shape[0] if found.ndim == 1 else f'shape {found.shape}'} instead of "
            f"{shape[0]} values"
        )
    if not np.all(np.isfinite(found)):
        raise BadInput(f"{where}: not finite at index {int(np.argmin(np.isfinite(found)))}")
    return found


def checked_course(where: str, function: Callable[..., Any]) -> Callable[..., Floats]:
    """A regressor, or what simulates: one value per sample of the recording, its first argument."""

    def course(recording: Recording, *arguments: Any) -> Floats:
        return numbers(where, asked(where, function, recording, *arguments), (recording.samples,))

    return course


def checked_deviation(where: str, function: Callable[..., Any]) -> Callable[..., Floats]:
    """A standard deviation per sample of the recording."""
    course = checked_course(where, function)

    def deviation(recording: Recording, *arguments: Any) -> Floats:
        found = course(recording, *arguments)
        if np.any(found < 0):
            raise BadInput(f"{where}: negative at index {int(np.argmax(found < 0))}")
        return found

    return deviation


def checked_spectrum(where: str, function: Callable[..., Any]) -> Spectrum:
    def spectrum(f: Floats, rate_hz: float, shape: Values) -> Floats:
        found = numbers(where, asked(where, function, f, rate_hz, shape), np.shape(f))
        if np.any(found < 0) or not np.any(found > 0):
            raise BadInput(
                f"{where}: {'negative' if np.any(found < 0) else 'zero'} at "
                f"{f[int(np.argmin(found))]:.4g} Hz"
            )
        return found

    return spectrum


def checked_grid(where: str, parameter: Parameter, function: Grid) -> Grid:
    """The values of a shape parameter that are worth trying, within its bounds."""

    def values(recording: Recording) -> list[Any] | None:
        found = function(recording)
        return list(found) if isinstance(found, Iterable) else None

    def grid(recording: Recording) -> list[Any]:
        found = asked(where, values, recording)
        if found is None:
            raise BadInput(f"{where}: not a list of values")
        for value in found:
            if not (
                value in parameter.values
                if parameter.values
                else isinstance(value, (int, float, np.number))
                and parameter.low <= value <= parameter.high
            ):
                raise BadInput(f"{where}: {value!r} is not a value that {parameter.name} may have")
        return found

    return grid


def bounded(parameter: Parameter) -> bool:
    return (
        all(isinstance(end, (int, float)) for end in (parameter.low, parameter.high))
        and parameter.low < parameter.high
    )


def positive(value: object) -> bool:
    return isinstance(value, (int, float)) and value > 0


def check_form(effect: Effect, where: str) -> None:
    """The fields that the table and the search rely on."""
    needed = {
        "mean": effect.regressor,
        "variance": effect.regressor,
        "spectrum": effect.spectrum,
    }
    if effect.role not in needed or not callable(needed[effect.role]):
        raise BadInput(
            f"{where} needs a regressor (role mean or variance) or a spectrum (role spectrum)"
        )
    if not isinstance(effect.kind, str) or not effect.kind.isidentifier():
        raise BadInput(f"{where}: its kind must be a word of letters, digits and _")
    for name, form in (("needs", tuple), ("grid", dict), ("variants", dict), ("most", dict)):
        if not isinstance(getattr(effect, name), form):
            raise BadInput(
                f"{where}: {name} must be a {form.__name__}"
                + (': ("column",)' if form is tuple else "")
            )
    if effect.most and (effect.role != "mean" or not all(map(positive, effect.most.values()))):
        raise BadInput(f"{where}: most needs the role mean and numbers above 0")
    parameters = effect.parameters
    if (
        not isinstance(parameters, tuple)
        or not parameters
        or not all(isinstance(one, Parameter) for one in parameters)
    ):
        raise BadInput(
            f"{where}: its parameters must be a tuple of Parameter, the size first: "
            "(Parameter(...),)"
        )
    for one in parameters:
        if (
            not (one.values or one.form or bounded(one))
            or not str(one.name).isidentifier()
            or one.name == "kind"
        ):
            raise BadInput(f"{where}: parameter {one.name}: a word and bounds low < high expected")
        if one.name in effect.shape_names and not callable(effect.grid.get(one.name)):
            raise BadInput(
                f"{where}: shape parameter {one.name} needs a grid: a function of the recording "
                "that gives values to try"
            )


def checked(effect: Effect, path: StrPath) -> Effect:
    """The effect with functions that say what is wrong with their answers."""
    where = f"--effects: {path}: {effect.kind}"
    check_form(effect, where)
    by_name = {parameter.name: parameter for parameter in effect.parameters}
    course = checked_deviation if effect.role == "variance" else checked_course
    return replace(
        effect,
        regressor=effect.regressor and course(f"{where}: regressor", effect.regressor),
        simulate=effect.simulate and checked_course(f"{where}: simulate", effect.simulate),
        spectrum=effect.spectrum and checked_spectrum(f"{where}: spectrum", effect.spectrum),
        variants={
            name: course(f"{where}: variant {name}", one) for name, one in effect.variants.items()
        },
        grid={
            name: checked_grid(f"{where}: grid of {name}", by_name[name], one)
            for name, one in effect.grid.items()
            if name in by_name
        },
    )


def read(path: StrPath, text: bytes) -> list[Effect]:
    """The effects that the text of a Python file defines, checked. Raises BadInput that names the
    file and the effect."""
    found = {
        id(value): value
        for value in vars(executed(path, text)).values()
        if isinstance(value, Effect)
    }
    own = [effect for effect in found.values() if table.TABLE.get(effect.kind) is not effect]
    if not own:
        raise BadInput(f"--effects: {path}: no Effect in it")
    return [checked(effect, path) for effect in own]


def install(effect: Effect, path: StrPath) -> None:
    """Adds an effect of read() to the table."""
    if effect.kind in table.TABLE:
        raise BadInput(f"--effects: {path}: kind {effect.kind} is taken")
    table.TABLE[effect.kind] = effect
    LOADED[effect.kind] = str(path)


def drop(kind: str) -> None:
    """Takes an effect of install() out of the table."""
    del table.TABLE[kind], LOADED[kind]


def load(path: StrPath) -> None:
    """Adds every Effect of a Python file to the table. Raises BadInput that names the file and the
    effect."""
    for effect in read(path, text_of(path)):
        install(effect, path)


def options() -> list[str]:
    """What loads the same files in a terminal: words to type."""
    return [word for path in dict.fromkeys(LOADED.values()) for word in ("--effects", path)]
