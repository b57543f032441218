"""The requirements of the workbench: which of them are not installed."""

import re
from importlib.metadata import PackageNotFoundError, requires, version


def wanted(requirement: str) -> str:
    """The package name of a requirement of the extra lab; "" for others."""
    name, _, marker = requirement.partition(";")
    of_lab = re.search(r"""extra == ["']lab["']""", marker)
    return re.split(r"[^\w.-]", name)[0] if of_lab else ""


def missing() -> list[str]:
    """Requirements of the extra lab that are not installed."""
    found = []
    for name in filter(None, map(wanted, requires("davar") or [])):
        try:
            version(name)
        except PackageNotFoundError:
            found.append(name)
    return found


def said(absent: list[str]) -> str:
    """The message for missing packages."""
    return (
        f"not installed: {', '.join(absent[:3])}{' ...' if absent[3:] else ''}; "
        'pip install "davar[lab]"'
    )
