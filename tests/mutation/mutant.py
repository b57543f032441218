"""A mutant, its name, and the operators that both languages have."""

import hashlib
import re
from collections import Counter
from dataclasses import dataclass

# Operators by kind, each with its replacement.
OPERATORS = {
    "arithmetic": {"+": "-", "-": "+", "*": "+", "/": "*", "//": "*", "%": "*", "**": "*"},
    "shift": {"<<": ">>", ">>": "<<"},
    "bitwise": {"&": "|", "|": "&", "^": "&"},
    "logical": {"&&": "||", "||": "&&"},
    "relational": {"==": "!=", "!=": "=="},
}
SWAPS = {before: after for kind in OPERATORS.values() for before, after in kind.items()}
CLASSES = {before: name for name, kind in OPERATORS.items() for before in kind}
RELATIONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<")}


@dataclass
class Mutant:
    file: str  # from the repository's root
    function: str
    line: int
    kind: str
    before: str
    after: str
    where: str = ""  # the surrounding line
    number: int = 0  # of several equal ones in a function
    id: int = 0
    first_id: int = 0  # of the mutants at its place

    @property
    def key(self):
        """Identifies the mutant while the text of its function is unchanged."""
        return self.named(self.after or "nothing")

    def named(self, after):
        return f"{self.file} | {self.function} | {self.where} | {self.before} -> {after}" + (
            f" | {self.number}" if self.number else ""
        )

    def draw(self, seed):
        """A number for sampling, independent of other changes."""
        return hashlib.sha256(f"{seed} {self.named(self.after)}".encode()).hexdigest()


def one_line(text):
    return re.sub(r"\s+", " ", text).strip()


def number(places, first=1):
    """Numbers the mutants of one file, in lists by place, from `first`; returns them."""
    mutants, same = [], Counter()
    for place in places:
        for mutant in place:
            mutant.number = 0
            seen = same[mutant.key]
            same[mutant.key] += 1
            mutant.number = seen + 1 if seen else 0
            mutant.id = first + len(mutants)
            mutant.first_id = place[0].id
            mutants.append(mutant)
    return mutants
