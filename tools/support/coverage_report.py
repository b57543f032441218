"""Lists lines and branches of lib/ that did not run, from gcovr's JSON, without the listed
exceptions.
"""

import json
from pathlib import Path
from typing import Any


def read_exceptions(path: Path) -> set[tuple[str, str]]:
    """Lines `file | source line | reason`; # starts a comment. Returns {(file, source line)}."""
    exceptions: set[tuple[str, str]] = set()
    for text in path.read_text().splitlines():
        if text.strip() and not text.startswith("#"):
            name, source, reason = (field.strip() for field in text.split(" | "))
            assert reason, f"{path}: an exception needs a reason: {text}"
            exceptions.add((name, source))
    return exceptions


def gaps(line: dict[str, Any]) -> str:
    """The missing coverage of one line of the report, as text; empty if complete."""
    if line["count"] == 0:
        return "never ran"
    untaken = sum(branch["count"] == 0 for branch in line["branches"])
    return f"{untaken} of {len(line['branches'])} branches not taken" if untaken else ""


def missing(report: Path, exceptions_path: Path) -> tuple[str, list[str]]:
    """Returns (summary line, list of missing lines)."""
    excepted, found, lines, branches = read_exceptions(exceptions_path), [], 0, 0
    for entry in json.loads(report.read_text())["files"]:
        source = Path(entry["file"]).read_text().splitlines()
        for line in entry["lines"]:
            if line["gcovr/noncode"] or line["gcovr/excluded"]:
                continue
            lines += 1
            branches += len(line["branches"])
            text = source[line["line_number"] - 1].strip()
            why = gaps(line)
            if why and (entry["file"], text) not in excepted:
                found.append(f"{entry['file']}:{line['line_number']}: {why}: {text}")
    if not lines:
        found.append("the report has no line of lib/")
    return (
        f"lib/: {lines} lines, {branches} branches, {len(found)} lines with something missing",
        found,
    )
