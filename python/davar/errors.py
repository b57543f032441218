"""What a person can put right (input, packages that are not installed), and output that cannot be
written."""

import contextlib
import os
import re
import sys
from collections.abc import Iterator

OURS = ("", "davar", "davarlab", "davarfleet")


class BadInput(Exception):
    """A file, line, column or option that cannot be used; the command line prints it and exits with
    status 2."""


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


def wanted(requirement: str) -> str:
    """The package name of a requirement of the extra lab; "" for others."""
    name, _, marker = requirement.partition(";")
    of_lab = re.search(r"""extra == ["']lab["']""", marker)
    return re.split(r"[^\w.-]", name)[0] if of_lab else ""


def missing() -> list[str]:
    """Requirements of the extra lab that are not installed."""
    from importlib.metadata import PackageNotFoundError, requires, version

    found = []
    for name in filter(None, map(wanted, requires("davar") or [])):
        try:
            version(name)
        except PackageNotFoundError:
            found.append(name)
    return found


def not_installed(absent: list[str]) -> str:
    """The message for missing packages."""
    return (
        f"not installed: {', '.join(absent[:3])}{' ...' if absent[3:] else ''}; "
        'pip install "davar[lab]"'
    )


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
