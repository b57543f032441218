"""What the last runs of tools/test left behind: which answers of a tool or an emulator are known, and how long each job took. Standard
library only."""

import hashlib
import json
import os
import shlex
import subprocess
from pathlib import Path


class Passed:
    """Checks that need not be done again: their key is the content of everything that they depend on, so their answer cannot be
    another. Only passes are kept. With DAVAR_AGAIN in the environment (tools/test --again) all are done."""

    def __init__(self, folder):
        self.folder, self.known = Path(folder), 0

    def cases(self, key):
        """How many cases passed for this key; 0: not known."""
        stamp = self.folder / key
        if os.environ.get("DAVAR_AGAIN") or not stamp.exists():
            return 0
        self.known += 1
        return int(stamp.read_text() or 1)

    def keep(self, key, cases=1):
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / key).write_text(str(cases))

    def check(self, key, work):
        """True if `work` is true, or was for this key."""
        if self.cases(key):
            return True
        done = work()
        if done:
            self.keep(key)
        return done


def content_key(*parts):
    """SHA-256 of texts and of the files (Path) among them, names included."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.read_bytes() if isinstance(part, Path) else str(part).encode()
        digest.update(f"{part if isinstance(part, Path) else ''} {len(data)}\n".encode() + data)
    return digest.hexdigest()


def compiled_from(entry):
    """Every file that one entry of compile_commands.json reads: the source and its headers, the system's too."""
    words = shlex.split(entry["command"])
    at = words.index("-o")
    rule = subprocess.run([*words[:at], *words[at + 2:], "-M", "-MT", "x"], cwd=entry["directory"], text=True, stdout=subprocess.PIPE, check=True).stdout
    return [Path(entry["directory"], name) for name in rule.replace("\\\n", " ").split(":", 1)[1].split()]


class Seconds:
    """How long each job took the last time; of unknown ones what `guess` says of the name, or else of its first word."""

    def __init__(self, path, guess):
        self.path, self.guess = Path(path), guess
        try:
            self.known = {str(name): float(value) for name, value in json.loads(self.path.read_text()).items()}
        except (OSError, ValueError, AttributeError, TypeError):  # none yet, or cut short
            self.known = {}

    def expected(self, name):
        return self.known.get(name, self.guess.get(name, self.guess.get(name.split()[0], 0.0)))

    def keep(self, taken):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.known | taken, indent=0, sort_keys=True))
