"""The rooms of davarlab: imports run one way down the list, and a room has at most a dozen files.
davarfleet, beside it, is a room too.
"""

import ast
import os
import re
import unittest
from collections import Counter
from pathlib import Path

LAB = Path(__file__).resolve().parents[2] / "tools/lab/davarlab"
FLEET = LAB.with_name("davarfleet")
# From the data to the page; a module may import from its own room and from those before it.
ROOMS = (
    "errors",
    "arrays",
    "distributions",
    "places",
    "arithmetic",
    "thresholds",
    "files",
    "data",
    "logs",
    "effects",
    "model",
    "simulate",
    "kalibr",
    "inference",
    "axes",
    "candidates",
    "diagnosis",
    "report",
    "wire",
    "workbench",
    "commands",
    "cli",
)
FILES_MAX = 12
SEARCHING = ("diagnosis/state.py", "diagnosis/search.py")  # what they hold is frozen
COMMAND_FLEET = (
    "commands/logs.py",
    "run_fleet",
)  # the one place of davarlab that imports davarfleet

# Everything that opens a file by its path: functions of Python and of the readers of logs.
OPENS = re.compile(
    r"(^|\.)(open|read_text|read_bytes|fromfile|loadtxt|genfromtxt|loadmat|memmap|mmap|run_path|File|FileIO|ZipFile|ParquetFile|read_table|DFReader_\w+|AnyReader)$"
    r"|^(np|numpy)\.load$"
)
OWN = "a file of this package or of one that it needs"
BY_ITS_FORMAT = "logs/formats.py has opened it through files.reading to see what it is"
NEW = "made here, under a name that nothing has"
# Exceptions besides files.py: the module, the call, the reason.
OPENED = {
    ("errors.py", "os.open(os.devnull, os.O_WRONLY)"): "to write",
    (
        "../davarfleet/page.py",
        "(Path(pages.__file__).parent / 'style.css').read_text(encoding='utf-8')",
    ): OWN,
    ("report/page.py", "path.read_text(encoding='utf-8')"): OWN,
    ("report/contents.py", "VERSION_HEADER.read_text()"): OWN,
    ("workbench/plans.py", "zipfile.ZipFile(made, 'w', zipfile.ZIP_DEFLATED)"): "in memory",
    ("workbench/arrivals.py", "open(part, 'xb')"): NEW,
    ("logs/arrays.py", "np.load(path, mmap_mode='r', allow_pickle=False)"): BY_ITS_FORMAT,
    (
        "logs/arrays.py",
        "np.load(file, allow_pickle=False)",
    ): "of a file that files.reading has opened",
    ("logs/arrays.py", "parquet.ParquetFile(path)"): BY_ITS_FORMAT,
    ("logs/dataflash.py", "DFReader.DFReader_binary(str(path))"): BY_ITS_FORMAT,
    ("logs/dataflash.py", "DFReader.DFReader_text(str(path))"): BY_ITS_FORMAT,
    (
        "logs/dataflash.py",
        "np.fromfile(self.path, np.uint8, part[-1] - part[0] + self.kind.itemsize, offset=part[0])",
    ): BY_ITS_FORMAT,
    ("logs/matlab.py", "io.loadmat(path, squeeze_me=True, struct_as_record=False)"): BY_ITS_FORMAT,
    ("logs/matlab.py", "h5py.File(path, 'r')"): BY_ITS_FORMAT,
    (
        "logs/ros.py",
        "AnyReader([HeldPath(self.path)], default_typestore=self.store)",
    ): "opens through HeldPath",
    ("logs/ros.py", "super().open(mode, *how, **more)"): "behind files.check_regular",
    ("logs/ros.py", "io.FileIO(self)"): "behind files.check_regular",
    (
        "wire/record.py",
        "os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 438)",
    ): "to append",
    (
        "wire/record.py",
        "open(os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 438), "
        "'rb+', buffering=0)",
    ): "to append",
    (
        "wire/record.py",
        "open(self.path, encoding='utf-8', errors='replace')",
    ): "only where it is a regular file",
}
OPENING = (
    "visit.intake.open",
    "self.open",
)  # in workbench/: Intake.open, which reads through it


def room_of(path):
    """The place in the list of the room that a file of the package is in."""
    first = path.relative_to(LAB).parts[0].removesuffix(".py")
    return ROOMS.index(first) if first in ROOMS else len(ROOMS)


def imported(path):
    """The files and folders of the package that a module imports, at any level, when it runs."""
    tree = ast.parse(path.read_text())
    only_types = {
        node
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level and node not in only_types:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for name in [base / alias.name for alias in node.names] + [base]:
                found = next(
                    (place for place in (name.with_suffix(".py"), name) if place.exists()), None
                )
                if found and found != LAB:
                    yield found


def name_of(path):
    """Of a module, from davarlab on."""
    return Path(os.path.relpath(path, LAB)).as_posix()


def functions_that_import(path, package):
    """Names of the functions of a module that import the package; None stands for the module
    itself.
    """
    tree = ast.parse(path.read_text())
    inside = {
        node: function.name
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        names = (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom) and not node.level
            else []
        )
        if package in {name.partition(".")[0] for name in names}:
            yield inside.get(node)


class TestRooms(unittest.TestCase):
    def modules(self, *packages):
        return sorted(
            path
            for package in packages
            for path in package.rglob("*.py")
            if path.name not in ("__init__.py", "__main__.py")
        )

    def test_imports_run_one_way(self):
        wrong = [
            f"{path.relative_to(LAB)} imports {other.relative_to(LAB)}"
            for path in self.modules(LAB)
            for other in imported(path)
            if room_of(other) > room_of(path)
        ]
        self.assertEqual(wrong, [])

    def test_davarlab_imports_davarfleet_in_its_command_alone(self):
        found = [
            (name_of(path), function)
            for path in self.modules(LAB)
            for function in functions_that_import(path, "davarfleet")
        ]
        self.assertEqual(found, [COMMAND_FLEET])

    def test_the_search_never_changes_a_state(self):
        for name in SEARCHING:
            for node in ast.walk(ast.parse((LAB / name).read_text())):
                if isinstance(node, ast.ClassDef):
                    self.assertIn("frozen=True", ast.unparse(node.decorator_list[0]), node.name)
                targets = node.targets if isinstance(node, ast.Assign) else []
                self.assertFalse(
                    [one for one in targets if isinstance(one, ast.Attribute)], ast.unparse(node)
                )

    def test_nothing_is_opened_by_its_path_but_through_files(self):
        found = set()
        for path in self.modules(LAB, FLEET):
            name = name_of(path)
            for call in (
                node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)
            ):
                function = ast.unparse(call.func)
                if (
                    OPENS.search(function)
                    and name != "files.py"
                    and not (name.startswith("workbench/") and function in OPENING)
                ):
                    found.add((name, ast.unparse(call)))
        self.assertEqual(sorted(found - set(OPENED)), [], "use files.reading")
        self.assertEqual(sorted(set(OPENED) - found), [], "no longer there")

    def test_a_room_has_at_most_a_dozen_files(self):
        for room, count in Counter(path.parent for path in self.modules(LAB, FLEET)).items():
            self.assertLessEqual(count, FILES_MAX, room)


if __name__ == "__main__":
    unittest.main()
