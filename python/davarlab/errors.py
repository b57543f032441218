"""What went wrong, in one line: by a person, or by this program."""

import contextlib
import errno
import os
import sys
import sysconfig
import traceback
from collections.abc import Iterator
from pathlib import Path

TRACEBACK = "DAVAR_LAB_TRACEBACK"
OURS = ("", "davar", "davarlab", "davarfleet")


class BadInput(Exception):
    """A file, line, column or option that cannot be used; the command line prints it and exits with
    status 2."""


class Moving(BadInput):
    """A recording that moves most of the time."""


class NotInstalled(BadInput):
    """A library of an extra of the Python distribution that is not installed."""


@contextlib.contextmanager
def of_extra(extra: str) -> Iterator[None]:
    """For the import of a library of an extra. Raises NotInstalled where it is absent."""
    try:
        yield
    except ModuleNotFoundError as why:
        root = (why.name or "").split(".")[0]
        if root in OURS:
            raise
        raise NotInstalled(f'{root} is not installed; pip install "davar[{extra}]"') from None


def printable(text: object) -> str:
    """A text in one line that any terminal shows as it is: what it would act upon, and what is no
    character, as Python writes it."""
    return "".join(
        one if one.isprintable() else one.encode("unicode_escape", "surrogatepass").decode()
        for one in str(text)
    )


WORLD = (
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EFBIG,
    errno.EIO,
    errno.EMFILE,
    errno.ENFILE,
    errno.ENOMEM,
)


def is_installed(name: int | str | bytes) -> bool:
    """Is a file one of this package or of the Python that runs it."""
    if isinstance(name, int):
        return False
    places = [
        os.path.dirname(__file__),
        *(sysconfig.get_path(one) for one in ("stdlib", "platstdlib", "purelib", "platlib")),
    ]
    return any(
        Path(os.path.realpath(os.fsdecode(name))).is_relative_to(os.path.realpath(place))
        for place in places
    )


def outside_error(why: OSError) -> int:
    """An OSError that is the machine's, or names a file that is not of an installation: one line,
    status 2. Any other is a fault of this program."""
    if why.errno not in WORLD and (
        why.errno is None or why.filename is None or is_installed(why.filename)
    ):
        return internal_error(why)
    print(
        "davarlab: "
        f"{printable(why.filename) + ': ' if why.filename else ''}{os.strerror(why.errno).lower()}",
        file=sys.stderr,
    )
    return 2


def shown(text: object) -> None:
    """Prints to standard output. What cannot be written is not tried again at the end."""
    try:
        print(text, flush=True)
    except OSError as why:
        forget_output()
        why.filename = "standard output"
        raise


def forget_output() -> None:
    """Whatever standard output still has to say goes nowhere."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def internal_error(why: BaseException) -> int:
    """What nobody foresaw: one line, and where it happened for whoever asks."""
    place = traceback.extract_tb(why.__traceback__)[-1]
    said = " ".join(str(why).split())[:200]
    print(
        f"davarlab: internal error: {type(why).__name__}: {printable(said)} "
        f"({os.path.basename(place.filename)}:{place.lineno}); please report it, with the files "
        f"and the output under {TRACEBACK}=1",
        file=sys.stderr,
    )
    if os.environ.get(TRACEBACK):
        traceback.print_exception(why)
    return 3
