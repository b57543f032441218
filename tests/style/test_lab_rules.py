"""The rules of davarlab that a script can check: its rooms import one way and have at most a dozen
files, files.py alone opens paths, and the numbers that decide are in thresholds.py: frozen, once,
with unit and source. davarfleet, beside it, is a room too.
"""

import ast
import os
import re
from collections import Counter
from functools import cache
from pathlib import Path

from c_text import ROOT

LAB = ROOT / "python/davarlab"
FLEET, DAVAR = LAB.with_name("davarfleet"), LAB.with_name("davar")
# From the data to the page; a module may import from its own room and from those before it.
ROOMS = re.findall(
    r"\w+",
    """errors arrays distributions arithmetic thresholds files tables data logs
    effects model simulate kalibr inference axes candidates diagnosis report workbench
    commands cli""",
)
FILES_MAX = 12
# What they hold is frozen.
SEARCHING = ("diagnosis/state.py", "diagnosis/fitting.py", "diagnosis/search.py")
# The functions that import a package that builds on theirs.
BACK = {
    ("commands/logs.py", "run_fleet"),
    ("../davar/lab.py", "main"),
    ("../davar/_read.py", "of_log"),
}

# Everything that opens a file by its path: functions of Python and of the readers of logs.
OPENS = re.compile(
    r"(^|\.)(open|read_text|read_bytes|fromfile|loadtxt|genfromtxt|loadmat|memmap|mmap|run_path|File|FileIO|ZipFile|ParquetFile|read_table|DFReader_\w+|AnyReader)$"
    r"|^(np|numpy)\.load$"
)
SHOWN_WHOLE = ("load", "open", "ZipFile")  # their arguments decide what the call may do
APPENDING = "os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 438)"
# Exceptions besides files.py: of a module, the calls or the functions that it calls, each as often,
# and the reason. logs/formats.py has opened a log through files.reading to see what it is.
OPENED = {
    "../davar/_read.py": [
        "gzip.open(path, 'rb')",
        "loadtxt",
        "open(name, 'rb')",
        "open(path, 'rb')",
        "open(path, 'rb')",
    ],
    "../davar/errors.py": ["os.open(os.devnull, os.O_WRONLY)"],
    "../davarfleet/page.py": ["read_text"],  # of the package
    "report/page.py": ["read_text"],
    "report/contents.py": ["read_text"],
    "workbench/plans.py": ["zipfile.ZipFile(made, 'w', zipfile.ZIP_DEFLATED)"],  # in memory
    "workbench/session/details.py": ["zipfile.ZipFile(made, 'w', zipfile.ZIP_DEFLATED)"],
    "workbench/arrivals.py": ["open(part, 'xb')"],  # under a name that nothing has
    "logs/arrays.py": [
        "np.load(path, mmap_mode='r', allow_pickle=False)",
        "np.load(file, allow_pickle=False)",
        "ParquetFile",
    ],
    "logs/dataflash.py": ["DFReader_binary", "DFReader_text", "fromfile"],
    "logs/matlab.py": ["loadmat", "File", "File"],
    "logs/ros.py": ["AnyReader", "super().open(mode, *how, **more)", "FileIO"],  # check_regular
    "../davar/wire/record.py": [
        APPENDING,
        f"open({APPENDING}, 'rb+', buffering=0)",
        "open(self.path, encoding='utf-8', errors='replace')",  # where it is a regular file
    ],
}
OPENING = ("session.intake.open", "self.open")  # in workbench/: Intake.open, which reads through it


def modules(*packages):
    every = (path for package in packages for path in sorted(package.rglob("*.py")))
    return [path for path in every if path.name not in ("__init__.py", "__main__.py")]


@cache
def tree_of(path):
    return ast.parse(path.read_text())


@cache
def nodes_of(path):
    return list(ast.walk(tree_of(path)))


def name_of(path):
    """Of a module, from davarlab on."""
    return Path(os.path.relpath(path, LAB)).as_posix()


# --- rooms ---


def room_of(path):
    """The place in the list of the room that a file of the package is in."""
    first = path.relative_to(LAB).parts[0].removesuffix(".py")
    return ROOMS.index(first) if first in ROOMS else len(ROOMS)


def imported(path):
    """The files and folders of the package that a module imports, at any level, when it runs."""
    only_types = {
        node
        for block in nodes_of(path)
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and node.level and node not in only_types:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for name in [base / alias.name for alias in node.names] + [base]:
                places = [place for place in (name.with_suffix(".py"), name) if place.exists()]
                if places and places[0] != LAB:
                    yield places[0]


def test_imports_run_one_way():
    wrong = [
        f"{name_of(path)} imports {name_of(other)}"
        for path in modules(LAB)
        for other in imported(path)
        if room_of(other) > room_of(path)
    ]
    assert wrong == []


def test_packages_import_one_way():
    """davarfleet imports davarlab, and davarlab imports davar; back, only a few functions do."""
    found = []
    for package, above in ((DAVAR, ("davarlab", "davarfleet")), (LAB, ("davarfleet",))):
        for path in modules(package):
            functions = [node for node in nodes_of(path) if isinstance(node, ast.FunctionDef)]
            inside = {node: function.name for function in functions for node in ast.walk(function)}
            for node in nodes_of(path):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                if isinstance(node, ast.ImportFrom) and not node.level:
                    names = [node.module or ""]
                if {name.partition(".")[0] for name in names} & set(above):
                    found.append((name_of(path), inside.get(node)))
    assert set(found) == BACK


def test_a_room_has_at_most_a_dozen_files():
    counts = Counter(path.parent for path in modules(LAB, FLEET, DAVAR))
    assert {room: count for room, count in counts.items() if count > FILES_MAX} == {}


def test_the_search_never_changes_a_state():
    for name in SEARCHING:
        for node in nodes_of(LAB / name):
            if isinstance(node, ast.ClassDef):
                assert "frozen=True" in ast.unparse(node.decorator_list[0]), node.name
            targets = node.targets if isinstance(node, ast.Assign) else []
            assert not any(isinstance(one, ast.Attribute) for one in targets), ast.unparse(node)


def test_nothing_is_opened_by_its_path_but_through_files():
    found = {}
    for path in modules(LAB, FLEET, DAVAR):
        name = name_of(path)
        own = OPENING if name.startswith("workbench/") else ()
        for call in (node for node in nodes_of(path) if isinstance(node, ast.Call)):
            function = ast.unparse(call.func)
            if OPENS.search(function) and name != "files.py" and function not in own:
                short = function.rpartition(".")[2]
                shown = ast.unparse(call) if short in SHOWN_WHOLE else short
                found.setdefault(name, []).append(shown)
    found = {name: sorted(calls) for name, calls in found.items()}
    assert found == {name: sorted(calls) for name, calls in OPENED.items()}, "files.reading?"


# --- thresholds ---

TABLE = LAB / "thresholds.py"
# Rooms whose numbers decide.
DECIDING = ("tables", "data", "effects", "inference", "candidates", "diagnosis", "report")
# Numbers on which no verdict depends: sizes of buffers and of input, units and formulas, formats of
# other programs, and how much is shown.
OTHER_NUMBERS = {
    "data/events.py": "PIECE",
    "data/recording.py": "WRITTEN",
    "data/signals.py": "PIECE WAVE_PIECE",
    "tables/constants.py": "DEG_PER_RAD GRAVITY_MPS2 LSB_DPS TO_DPS UG_PER_MPS2",
    "tables/dialect.py": "COLUMNS_MOST LISTED_MOST SHOWN",
    "tables/guess.py": "DEGREES FORCES RATES SECONDS",
    "tables/missing.py": "LISTED",
    "tables/sentences.py": "DAY_S SHOWN",
    "tables/table.py": "BLOCK_BYTES DAY_S FAR HEAD_LINES LARGEST LINE_BYTES LONG_BYTES SAFE SHOWN "
    "UNPACKED_BYTES UNPACKED_TIMES",
    "tables/tagged.py": "TAGS_MOST",
    "effects/columns.py": "REFERENCE_DEGC",
    "effects/device.py": "BINS_MOST POLES TEXT_BYTES ZEROS",
    # Each with its data sheet.
    "effects/limits.py": "FOLLOWED NOISE_PER_DEGC PER_DEGC PER_DEGC2 PER_DEGC_PER_S PER_G PER_G2 "
    "PER_G_OF_NOISE PER_V TIMES",
    "effects/own.py": "LONGEST_S",
    "effects/sheets.py": "HALF KINDS LONGEST ONE PER PREFIXES QUANTITIES ZERO",
    "report/contents.py": "WHERE_MAX",
    "report/curves.py": "BAND COLUMNS ENVELOPE",
    "report/declared.py": "AVERAGES_MOST CUTOFFS FLUCTUATIONS SIZES_MOST SPAN_MOST WIDTH WINDOW "
    "WINDOW_MOST",
    "report/noise.py": "FAMILIAR",
    "report/parameters.py": "ARDUPILOT_S FLAT FORMATS PX4_S",
    "report/plot.py": "FADED FULL MARKED",
    "report/terminal.py": "CANDIDATES_MAX WHERE_MAX",
    "report/verdict.py": "CONFIDENCE SHOWN_AGAINST SHOWN_EXCLUDED",
    "report/words.py": "TINY",
}
SOURCE = re.compile(
    r"DESIGN \d|choice|measured|chi-square|normal distribution|null recordings|Vuong|true models"
)


def is_number(node):
    value = node.value if isinstance(node, ast.Constant) else None
    return isinstance(value, int | float) and not isinstance(value, bool)


def numeric_constants(tree):
    """Upper-case names that a module gives a value with a number in it. The bounds of a parameter
    are part of its effect."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        walked = [name for target in targets for name in ast.walk(target)]
        names = [one.id for one in walked if isinstance(one, ast.Name) and one.id.isupper()]
        made = ast.unparse(getattr(getattr(node, "value", None), "func", ast.Constant("")))
        if (
            names
            and made not in ("Effect", "Parameter")
            and any(map(is_number, ast.walk(node.value)))
        ):
            yield from names


def fields():
    """[(class, field, arguments of its threshold())] of the table."""
    groups = [node for node in tree_of(TABLE).body if isinstance(node, ast.ClassDef)]
    return [
        (group, node.target.id, node.value.args)
        for group in groups
        for node in group.body
        if isinstance(node, ast.AnnAssign)
    ]


def test_the_name_of_a_function_says_what_it_returns():
    """of(x) reads well where it is called with its module, and nowhere else."""
    found = [
        f"{name_of(path)}:{node.lineno}"
        for path in sorted(LAB.rglob("*.py"))
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.FunctionDef) and node.name == "of"
    ]
    assert found == []


def test_the_deciding_rooms_have_no_numbers_of_their_own():
    paths = [path for room in DECIDING for path in sorted((LAB / room).glob("*.py"))]
    found = [
        f"{name_of(path)}: {name}" for path in paths for name in numeric_constants(tree_of(path))
    ]
    others = [f"{path}: {name}" for path, names in OTHER_NUMBERS.items() for name in names.split()]
    assert sorted(found) == sorted(others), "belongs in thresholds.py"
    text = "A, B = (1, 2)\nC = {'x': 0.5}\nD = 'text'\ne = 3\n"
    assert list(numeric_constants(ast.parse(text))) == ["A", "B", "C"]


def test_each_threshold_is_frozen_used_and_has_unit_source_and_meaning_once():
    paths = [path for package in (LAB, FLEET) for path in package.rglob("*.py") if path != TABLE]
    used = set(re.findall(r"\b[A-Z_]+\.\w+", "".join(path.read_text() for path in paths)))
    assert len({group for group, *_ in fields()}) > 5
    for group, name, arguments in fields():
        assert ast.unparse(group.decorator_list[0]) == "dataclass(frozen=True)", group.name
        assert len(arguments) == 4, name
        texts = [ast.literal_eval(text).strip() for text in arguments[1:]]
        assert all(texts), name
        assert SOURCE.search(texts[1]), f"{group.name}.{name}"
        assert f"{group.name.upper()}.{name}" in used, f"{group.name}.{name} is not used"
    for stated in (
        [name for _, name, _ in fields()],
        [ast.unparse(arguments[3]) for _, _, arguments in fields()],
    ):
        assert [one for one, count in Counter(stated).items() if count > 1] == []
