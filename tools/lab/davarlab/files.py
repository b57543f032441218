"""Files that are written whole or not at all."""

import contextlib
import hashlib
import os
import secrets
import signal
import threading
from pathlib import Path

from .errors import BadInput


@contextlib.contextmanager
def unbroken():
    """A signal that would end the program does so behind the block, and is in the list meanwhile. Handlers, not a mask: other threads have
    masks of their own."""
    came, before = [], {}
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if threading.current_thread() is threading.main_thread() and signal.getsignal(number) not in (signal.SIG_IGN, None):
            before[number] = signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in came[:1]:
            signal.raise_signal(number)


def sha256(path):
    """Of a file's bytes. Raises BadInput."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as why:
        raise BadInput(f"{path}: {reason(why)}") from None


def partial(path):
    path = Path(path).resolve()
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")


def check_writable(path):
    """Raises BadInput when `path` could not be written; leaves nothing behind. For commands that work long before they write."""
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise OSError(None, "is not a file")
        trial = partial(path)
        with unbroken():
            trial.touch(exist_ok=False)
            trial.unlink()
    except (OSError, ValueError) as why:
        raise BadInput(f"{path}: cannot be written ({reason(why)})") from None


def check_outputs(outputs, inputs):
    """Raises BadInput unless every output could be written and is neither another output nor an input."""
    seen = {Path(path).resolve() for path in inputs}
    for path in outputs:
        check_writable(path)
        if Path(path).resolve() in seen:
            raise BadInput(f"{path}: cannot be written (this command also reads or writes it)")
        seen.add(Path(path).resolve())


def check_ending(path, endings):
    """Raises BadInput unless the name ends in one of these."""
    if not str(path).lower().endswith(endings):
        raise BadInput(f"{path}: the name must end in {' or '.join(endings)}")


def reason(why):
    return (why.strerror or str(why)).lower() if isinstance(why, OSError) else str(why)


def write_whole(path, data):
    """Writes bytes, or pieces of them as they come, to a file beside `path`, then takes its place. What was there stays until then; a signal
    ends it between two pieces. Raises BadInput."""
    trial = partial(path)
    with unbroken() as came:
        try:
            with open(trial, "xb") as file:
                for piece in [data] if isinstance(data, bytes) else data:
                    file.write(piece)
                    if came:
                        return
                file.flush()
                os.fsync(file.fileno())
            os.replace(trial, Path(path).resolve())
        except OSError as why:
            raise BadInput(f"{path}: cannot be written ({reason(why)})") from None
        finally:
            with contextlib.suppress(OSError):
                trial.unlink()
