"""What went wrong, in one line: by a person, or by this program."""

import errno
import os
import sys
import sysconfig
import traceback
from pathlib import Path

from davar.errors import BadInput as BadInput
from davar.errors import NotInstalled as NotInstalled
from davar.errors import forget_output as forget_output
from davar.errors import of_extra as of_extra
from davar.errors import shown as shown

TRACEBACK = "DAVAR_LAB_TRACEBACK"


class Moving(BadInput):
    """A recording that moves most of the time."""


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
