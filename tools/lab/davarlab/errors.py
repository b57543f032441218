"""What went wrong, in one line: by a person, or by this program."""

import os
import sys
import traceback

TRACEBACK = "DAVAR_LAB_TRACEBACK"


class BadInput(Exception):
    """A file, line, column or option that cannot be used; the command line prints it and exits with status 2."""


def printable(text):
    """A text in one line that any terminal shows as it is: what it would act upon, and what is no character, as Python writes it."""
    return "".join(one if one.isprintable() else one.encode("unicode_escape", "surrogatepass").decode() for one in str(text))


def internal_error(why):
    """What nobody foresaw: one line, and where it happened for whoever asks."""
    place = traceback.extract_tb(why.__traceback__)[-1]
    said = " ".join(str(why).split())[:200]
    print(f"davarlab: internal error: {type(why).__name__}: {printable(said)} ({os.path.basename(place.filename)}:{place.lineno}); please report it, "
          f"with the files and the output under {TRACEBACK}=1", file=sys.stderr)
    if os.environ.get(TRACEBACK):
        traceback.print_exception(why)
    return 3
