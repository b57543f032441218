"""Files: only regular ones are read, and they are written whole or not at all."""

import contextlib
import hashlib
import io
import os
import secrets
import shlex
import signal
import stat
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from .errors import BadInput

StrPath = str | os.PathLike[str]
WRITING = threading.RLock()  # held while a file is written: whoever ends the process takes it first
OTHERS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
)  # any other is a device


def check_regular(path: StrPath, found: os.stat_result | None = None) -> os.stat_result:
    """Raises BadInput unless `path` is a regular file; symbolic links are followed. Opens nothing:
    a FIFO or a device may wait for ever, or act, when it is opened. found: its os.stat_result,
    where that is known. Returns it."""
    try:
        found = found or os.stat(path)
    except (OSError, ValueError) as why:
        raise BadInput(f"{path}: {getattr(why, 'strerror', None) or why}") from None
    if not stat.S_ISREG(found.st_mode):
        kind = next((words for test, words in OTHERS if test(found.st_mode)), "a device")
        raise BadInput(f"{path}: is {kind}; a file is needed")
    return found


def reading(path: StrPath) -> io.BufferedReader:
    """A regular file, open to read its bytes. One whose size is 0 is empty and is not asked for
    more: those of /proc would wait. Raises BadInput that names the path."""
    check_regular(path)
    flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY
    try:
        file = open(os.open(path, flags), "rb")  # noqa: SIM115 the caller closes it
    except (OSError, ValueError) as why:
        raise BadInput(f"{path}: {getattr(why, 'strerror', None) or why}") from None
    try:
        size = check_regular(path, os.fstat(file.fileno())).st_size
    except BadInput:
        file.close()
        raise
    if size:
        return file
    file.close()
    return io.BufferedReader(io.BytesIO())


def read_whole(path: StrPath) -> bytes:
    """The bytes of a regular file. Raises BadInput that names the path."""
    try:
        with reading(path) as file:
            return file.read()
    except OSError as why:
        raise BadInput(f"{path}: {reason(why)}") from None


def real(path: StrPath) -> Path:
    """The path without symbolic links. Path.resolve() raises RuntimeError of a link that leads to
    itself."""
    return Path(os.path.realpath(path))


@contextlib.contextmanager
def unbroken() -> Iterator[list[int]]:
    """A signal that would end the program does so behind the block, and is in the list meanwhile.
    Handlers, not a mask: other threads have masks of their own."""
    came: list[int] = []
    before: dict[signal.Signals, Any] = {}
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if threading.current_thread() is threading.main_thread() and signal.getsignal(
            number
        ) not in (signal.SIG_IGN, None):
            before[number] = signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for first in came[:1]:
            signal.raise_signal(first)


def sha256(path: StrPath) -> str:
    """Of a file's bytes. Raises BadInput."""
    try:
        with reading(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as why:
        raise BadInput(f"{path}: {reason(why)}") from None


def place_of(path: StrPath, follow: bool = True) -> Path:
    """Where a file that is written to a path comes to lie: not follow: in place of a symbolic link,
    not where it leads."""
    return real(path) if follow else real(Path(path).parent) / Path(path).name


def partial(path: StrPath, follow: bool = True) -> Path:
    path = place_of(path, follow)
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")


def check_writable(path: StrPath) -> None:
    """Raises BadInput when `path` could not be written; leaves nothing behind. For commands that
    work long before they write."""
    try:
        with contextlib.suppress(FileNotFoundError):
            if not stat.S_ISREG(os.stat(path).st_mode):
                raise OSError(None, "is not a file")
        trial = partial(path)
        with unbroken():
            trial.touch(exist_ok=False)
            trial.unlink()
    except (OSError, ValueError) as why:
        raise BadInput(f"{path}: cannot be written ({reason(why)})") from None


def check_outputs(outputs: Iterable[StrPath], inputs: Iterable[StrPath]) -> None:
    """Raises BadInput unless every output could be written and is neither another output nor an
    input."""
    seen = {real(path) for path in inputs}
    for path in outputs:
        check_writable(path)
        if real(path) in seen:
            raise BadInput(f"{path}: cannot be written (this command also reads or writes it)")
        seen.add(real(path))


def check_ending(path: StrPath, endings: tuple[str, ...]) -> None:
    """Raises BadInput unless the name ends in one of these."""
    if not str(path).lower().endswith(endings):
        raise BadInput(f"{path}: the name must end in {' or '.join(endings)}")


def reason(why: Exception) -> str:
    return (why.strerror or str(why)).lower() if isinstance(why, OSError) else str(why)


def write_whole(path: StrPath, data: bytes | Iterable[bytes], follow: bool = True) -> None:
    """Writes bytes, or pieces of them as they come, to a file beside `path`, then takes its place.
    What was there stays until then; a signal ends it between two pieces. follow: as of place_of().
    Raises BadInput."""
    trial = partial(path, follow)
    with WRITING, unbroken() as came:
        try:
            with open(trial, "xb") as file:
                for piece in [data] if isinstance(data, bytes) else data:
                    file.write(piece)
                    if came:
                        return
                file.flush()
                os.fsync(file.fileno())
            os.replace(trial, place_of(path, follow))
        except OSError as why:
            raise BadInput(f"{path}: cannot be written ({reason(why)})") from None
        finally:
            with contextlib.suppress(OSError):
                trial.unlink()


def without_end(path: StrPath, size: int) -> str:
    """What to type for a file whose end, after so many bytes, is not whole."""
    ending = Path(path).suffix
    return f"Type head -c {size} {shlex.quote(str(path))} > NEW{ending}, and use NEW{ending}"
