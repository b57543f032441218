"""Lists conditions of lib/ that never decided an outcome alone (MC/DC), from llvm-cov's JSON."""

import json
import re
from pathlib import Path

Decision = tuple[str, int, int, int, int]  # file, first line and column, last line and column


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


def constants(text: str, conditions: int) -> set[int]:
    """The conditions of a decision, from 0, that are a constant of the build or of the target
    (DAVAR_GRID): no test can turn them. None if the text has another number of conditions.
    """
    parts = [part.strip(" ()") for part in re.split(r"&&|\|\|", text)]
    if len(parts) != conditions:
        return set()
    return {i for i, part in enumerate(parts) if re.fullmatch(r"!?DAVAR_[A-Z0-9_]+", part)}


def missing(report: str, root: Path) -> tuple[str, list[str]]:
    """Returns (summary line, list of the conditions that are not covered)."""
    found, count, wrong = decisions(report, root), 0, []
    for key, conditions in sorted(found.items()):
        text = text_of(key, root)
        variable = set(range(len(conditions))) - constants(text, len(conditions))
        count += len(variable)
        wrong += [f"{key[0]}: C{i + 1} never turned: {text}" for i in variable if not conditions[i]]
    if not found:
        wrong.append("the report has no decision of lib/")
    return (
        f"lib/: MC/DC of {count - len(wrong)} of {count} conditions, {len(found)} decisions",
        wrong,
    )
