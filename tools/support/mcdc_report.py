"""Lists conditions of lib/ that never decided an outcome alone (MC/DC), from llvm-cov's JSON,
without the listed exceptions.
"""

import json
from collections import Counter
from pathlib import Path

Decision = tuple[str, int, int, int, int]  # file, first line and column, last line and column
Condition = tuple[str, str, str]  # file, text of the decision, C and a number


def decisions(report: str, root: Path) -> dict[Decision, list[bool]]:
    """{(file below root, first line, column, last line, column): [condition covered?, ...]} of
    lib/. A header's decision is covered if any source that includes it covers it.
    """
    found: dict[Decision, list[bool]] = {}
    for entry in json.loads(report)["data"][0]["files"]:
        name = Path(entry["filename"])
        if not (name.is_relative_to(root / "lib") or name.is_relative_to(root / "port/wire")):
            continue
        for record in entry.get("mcdc_records", []):
            first, column, last, end = record[:4]
            key = (str(name.relative_to(root)), first, column, last, end)
            covered = record[-1]
            found[key] = [a or b for a, b in zip(found.get(key, covered), covered)]
    return found


def text_of(key: Decision, root: Path) -> str:
    """The source text of the decision, in one line."""
    name, first, column, last, end = key
    lines = (root / name).read_text().splitlines()[first - 1 : last]
    lines[-1] = lines[-1][: end - 1]
    lines[0] = lines[0][column - 1 :]
    return " ".join(" ".join(lines).split())


def read_exceptions(path: Path) -> Counter[Condition]:
    """Lines `file | decision | C1 C3 .. | reason`; # starts a comment. Returns a Counter of (file,
    decision, condition).
    """
    exceptions: Counter[Condition] = Counter()
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            fields = [field.strip() for field in line.split(" | ")]
            assert len(fields) == 4 and fields[3], (
                f"{path}: file | decision | conditions | reason: {line}"
            )
            exceptions.update((fields[0], fields[1], number) for number in fields[2].split())
    return exceptions


def missing(report: str, root: Path, exceptions_path: Path) -> tuple[str, list[str]]:
    """Returns (summary line, list of faults: a condition that is not covered, an exception that is
    not needed).
    """
    found, count = decisions(report, root), 0
    uncovered: Counter[Condition] = Counter()
    for key, conditions in found.items():
        count += len(conditions)
        uncovered.update(
            (key[0], text_of(key, root), f"C{i}")
            for i, covered in enumerate(conditions, 1)
            if not covered
        )
    excepted = read_exceptions(exceptions_path)
    wrong = [
        f"{name}: {number} never turned: {text}"
        for name, text, number in sorted((uncovered - excepted).elements())
    ]
    wrong += [
        f"{name}: {number} is covered; remove its exception: {text}"
        for name, text, number in sorted((excepted - uncovered).elements())
    ]
    if not found:
        wrong.append("the report has no decision of lib/")
    covered = count - uncovered.total()
    return (
        f"lib/: MC/DC of {covered} of {count} conditions, {len(found)} decisions; "
        f"{excepted.total()} named exceptions",
        wrong,
    )
