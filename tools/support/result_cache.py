"""A cache of test results: a passed check is skipped until something that it reads has changed.
Standard library only.
"""

import hashlib
import os
import shlex
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path


class ResultCache:
    """Results of checks, one file each. The key of a result is a hash of everything that the check
    reads, so the result cannot differ. Only passes are stored. With DAVAR_AGAIN in the environment
    (tools/test --again) no result is found.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder, self.hits = Path(folder), 0

    def cases(self, key: str) -> int:
        """The number of cases that passed with this key; 0 if none is stored."""
        stamp = self.folder / key
        if os.environ.get("DAVAR_AGAIN") or not stamp.exists():
            return 0
        self.hits += 1
        return int(stamp.read_text() or 1)

    def store(self, key: str, cases: int = 1) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / key).write_text(str(cases))

    def check(self, key: str, work: Callable[[], bool]) -> bool:
        """True if work() is true, or was true with this key."""
        if self.cases(key):
            return True
        done = work()
        if done:
            self.store(key)
        return done


def content_key(*parts: object) -> str:
    """SHA-256 of texts and of the files (Path) among them, including their names."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.read_bytes() if isinstance(part, Path) else str(part).encode()
        digest.update(f"{part if isinstance(part, Path) else ''} {len(data)}\n".encode() + data)
    return digest.hexdigest()


def compiled_from(entry: Mapping[str, str]) -> list[Path]:
    """Every file that one entry of compile_commands.json reads: the source and its headers,
    including system headers.
    """
    words = shlex.split(entry["command"])
    at = words.index("-o")
    command = [*words[:at], *words[at + 2 :], "-M", "-MT", "x"]
    rule = subprocess.run(
        command, cwd=entry["directory"], text=True, stdout=subprocess.PIPE, check=True
    ).stdout
    return [
        Path(entry["directory"], name)
        for name in rule.replace("\\\n", " ").split(":", 1)[1].split()
    ]
