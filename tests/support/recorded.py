"""Digests of outputs, so that no byte changes unnoticed. The oracles beside them test whether the
bytes are right.

A list has a line "digest  words" for each case. After a change on purpose, copy the new digests
from the list in build/log.
"""

import hashlib
from pathlib import Path

LOGS = Path(__file__).resolve().parents[2] / "build/log"


def cases(path):
    """{words: digest} of a list."""
    pairs = (line.split("  ", 1) for line in path.read_text(encoding="utf-8").splitlines())
    return {words: digest for digest, words in pairs}


def assert_recorded(path, words, *texts):
    """The texts of a case have the digest of the list."""
    found = hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]
    if found != cases(path)[words]:
        LOGS.mkdir(parents=True, exist_ok=True)
        with open(LOGS / path.name, "a", encoding="utf-8") as file:
            file.write(f"{found}  {words}\n")
    assert found == cases(path)[words], texts
