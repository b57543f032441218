"""Imported by the first lines of the mutated packages in the copy of the tree, in every process
of a test: loads a module with the mutant of DAVAR_MUTANT, or with a byte set in the file
DAVAR_MUTANTS_REACHED for each statement that runs.
"""

import builtins
import importlib.machinery
import json
import marshal
import mmap
import os
import sys
from pathlib import Path

import python_sites

TREE = Path(__file__).resolve().parents[2]
WORK = TREE.parent
FIRST = json.loads((WORK / "index.json").read_text())  # {file: number of its first mutant}
MUTANT = int(os.environ.get("DAVAR_MUTANT", "0"))
MUTATED = max((at, name) for name, at in [*FIRST.items(), ("", 0)] if at <= MUTANT)[1]


class Loader(importlib.machinery.SourceFileLoader):
    def get_code(self, fullname):
        name = str(Path(self.path).relative_to(TREE))
        stored = WORK / "recording" / name
        if not MUTANT and stored.exists():
            return marshal.loads(stored.read_bytes())
        file = python_sites.File(name, Path(self.path).read_text(), FIRST[name])
        tree = file.mutated(MUTANT) if MUTANT else file.recording()
        code = compile(tree, self.path, "exec", dont_inherit=True)
        if not MUTANT:
            stored.parent.mkdir(parents=True, exist_ok=True)
            own = stored.with_suffix(f".{os.getpid()}")
            own.write_bytes(marshal.dumps(code))
            own.replace(stored)
        return code


class Finder:
    @staticmethod
    def find_spec(fullname, path=None, target=None):
        spec = importlib.machinery.PathFinder.find_spec(fullname, path) if path else None
        origin = Path(spec.origin) if spec and spec.origin else None
        if origin is None or not origin.is_relative_to(TREE):
            return None
        name = str(origin.relative_to(TREE))
        if name in FIRST and (not MUTANT or name == MUTATED):
            spec.loader = Loader(fullname, spec.origin)
            return spec
        return None


if MUTANT or "DAVAR_MUTANTS_REACHED" in os.environ:
    sys.meta_path.insert(0, Finder)
if "DAVAR_MUTANTS_REACHED" in os.environ:
    with open(os.environ["DAVAR_MUTANTS_REACHED"], "r+b") as reached:
        builtins.davar_reached = mmap.mmap(reached.fileno(), 0)
