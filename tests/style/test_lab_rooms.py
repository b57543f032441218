"""The rooms of davarlab: imports run one way down the list, and a room has at most a dozen files."""

import ast
import unittest
from pathlib import Path

LAB = Path(__file__).resolve().parents[2] / "tools/lab/davarlab"
# From the data to the door; a module may import from its own room and from those before it.
ROOMS = ("errors", "places", "arithmetic", "files", "option_types", "data", "logs", "effects", "model", "simulate", "kalibr", "axes", "inference", "candidates", "diagnosis", "report", "wire", "workbench", "fleet", "cli")
FILES_MAX = 12


def room_of(path):
    """The place in the list of the room that a file of the package is in."""
    first = path.relative_to(LAB).parts[0].removesuffix(".py")
    return ROOMS.index(first) if first in ROOMS else len(ROOMS)


def imported(path):
    """The files and folders of the package that a module names in an import, wherever it stands."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for name in [base / alias.name for alias in node.names] + [base]:
                found = next((place for place in (name.with_suffix(".py"), name) if place.exists()), None)
                if found and found != LAB:
                    yield found


class TestRooms(unittest.TestCase):
    def modules(self):
        return sorted(path for path in LAB.rglob("*.py") if path.name not in ("__init__.py", "__main__.py"))

    def test_imports_run_one_way(self):
        wrong = [f"{path.relative_to(LAB)} imports {other.relative_to(LAB)}" for path in self.modules()
                 for other in imported(path) if room_of(other) > room_of(path)]
        self.assertEqual(wrong, [])

    def test_a_room_has_at_most_a_dozen_files(self):
        for room in {path.parent for path in self.modules()}:
            self.assertLessEqual(len([path for path in room.glob("*.py") if path.name != "__init__.py"]), FILES_MAX, room)


if __name__ == "__main__":
    unittest.main()
