"""The program davarlab of this distribution: the workbench, where what it needs is installed."""

import sys
from importlib.metadata import PackageNotFoundError, requires, version


def wanted(requirement: str) -> str:
    """The name in a requirement that belongs to the extra lab; "" for another."""
    name, _, marker = requirement.partition(";")
    return name.split("=")[0].split(">")[0].strip() if "extra" in marker and "lab" in marker else ""


def missing() -> list[str]:
    """What the extra lab names and is not installed."""
    found = []
    for name in filter(None, map(wanted, requires("davar") or [])):
        try:
            version(name)
        except PackageNotFoundError:
            found.append(name)
    return found


def said(absent: list[str]) -> str:
    """What is missing, for a message."""
    return f'not installed: {", ".join(absent[:3])}{" ..." if absent[3:] else ""}; pip install "davar[lab]"'


def main() -> int:
    """davarlab with the arguments of the command line; its exit status."""
    absent = missing()
    if absent:
        print(f"davarlab: {said(absent)}", file=sys.stderr)
        return 2
    from davarlab import cli  # type: ignore[import-untyped, unused-ignore]

    return int(cli.main(sys.argv[1:]))
