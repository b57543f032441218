"""The rules of this project that a script can check and no linter knows. Reads only the text of the
tree; nothing is built.
"""

import re
import tomllib
from pathlib import Path

import pytest
from c_text import (
    PARTS,
    ROOT,
    bare,
    c_files,
    functions,
    functions_in,
    includes,
    listed,
    resolve,
    text_of,
)

FUNCTION_LINES_MAX = 60
COMPLEXITY_MAX = 10
DEPTH_MAX = 6
HANG_S = 300
VERSION_HEADER = "lib/include/davar/version.h"
# The star: folder (first match) -> folders whose headers it may include, besides its own. public:
# the headers of core and parts; addons/src: the private ones of the parts.
MAY_INCLUDE = {
    "examples/": "public",
    "lib/": "lib/include lib/src",
    "addons/": "public lib/src",  # of lib/src only number, see below
    "port/include": "public",
    "port/node": "public port/include",
    "port/": "port/include public",
    "firmware": "public port/include port/node port/job port/bare_metal",
    "gateway": "public port/include port/node port/linux host_sim",
    "host_sim/centred": "public lib/src port/include host_sim",  # the library's arithmetic
    "host_sim": "public port/include port/node port/job host_sim",
    "tests/unit": "public addons/src lib/src port/include port/node host_sim tests/support",
    "tests/tracking": "public lib/src port/bare_metal port/include tests/support",
    "tests/proofs": "public lib/src",
    "tests/target": "public port/bare_metal port/include",
    "tests/port": "public port/include port/linux port/node port/template tests/support",
    "tests/property": "public port/include host_sim tests/support",
    "tests/published": "public port/include host_sim tests/support",
    "tests/bench": "public port/include host_sim tests/support",
    "tests/fuzz": "public port/include gateway host_sim tests/support tests/tracking",
    "tests/statistics": "host_sim public lib/src tests/support",
    "tests/": "public port/include port/node tests/support",
    "tools/": "public host_sim",
    "python": "public lib/src port/include host_sim",
    "bench/": "public",
}
LIB_SYSTEM_HEADERS = {
    *("assert.h", "float.h", "limits.h", "math.h", "stdatomic.h", "stdbool.h", "stddef.h"),
    *("stdint.h", "string.h"),
    "immintrin.h",  # of number/q15_avx2.inc, on x86 alone
}
LIB_FORBIDDEN_CALLS = (
    r"\b(malloc|calloc|realloc|free|alloca|\w*printf|puts|putchar|\w*scanf|fopen|exit|abort|time|"
    r"clock|signal|setjmp|longjmp)\s*\("
)
MARKS = tuple(
    "".join(halves) for halves in [("TO", "DO"), ("FIX", "ME"), ("XX", "X"), ("HA", "CK")]
)

# The rooms: which others each may include, besides itself. The entry functions lie beside them. Of
# lib/src, filter and fit include public headers and number alone, and fit also filter. So does each
# part of addons.
SIM_ROOMS = (
    *("common", "setup", "options", "recording", "learning", "centred"),
    *("instances", "output", "replay"),
)
SHARED_ROOMS = {"common", "setup", "learning"}  # of host_sim, for davar-node, planner and lab
ROOMS = {
    "lib/src": {
        "number": set(),
        "filter": {"number"},
        "core": {"number"},
        "engines": {"number", "core"},
        "laws": {"number", "core"},
        "fit": {"number", "filter"},
    },
    "host_sim": {room: set(SIM_ROOMS[:at]) for at, room in enumerate(SIM_ROOMS)},
}
# The parts: which others each may include.
PARTS_USE = {"can": {"floor", "monitor"}, "state": {"cascade"}, "telemetry": {"floor"}}
STORIES_MAX = {"lib/src": 18, "host_sim": 12}  # of a room: a header and its source are one


# --- includes ---


@pytest.mark.parametrize("house", ROOMS)
def test_rooms_import_one_way_and_have_few_stories(house):
    rooms, wrong, stories = ROOMS[house], [], {}
    for name in c_files(f"{house}/"):
        room = Path(name).parent.name
        if room == Path(house).name:
            continue
        stories.setdefault(room, set()).add(Path(name).stem)
        for included in includes(name):
            target = resolve(name, included)
            is_inside = target and target.startswith(f"{house}/")
            other = Path(target).parent.name if is_inside else room
            allowed = {room, *rooms[room]}
            if other not in allowed:
                wrong.append(f"{name} includes {target}")
    assert wrong == []
    assert set(stories) == set(rooms)
    assert {room: n for room, n in stories.items() if len(n) > STORIES_MAX[house]} == {}


def test_other_programs_use_of_davar_sim_what_is_for_all():
    wrong = []
    for name in c_files("gateway/", "tools/"):
        for target in filter(None, (resolve(name, included) for included in includes(name))):
            if target.startswith("host_sim/") and target.split("/")[1] not in SHARED_ROOMS:
                wrong.append(f"{name} includes {target}")
    assert wrong == []


def test_images_of_boards_include_no_stdio():
    names = [name for name in c_files("firmware/", "port/") if "/linux/" not in name]
    kept = [name for name in names if not name.startswith("port/none/")]
    assert [name for name in kept if "stdio.h" in includes(name)] == []


def test_a_part_includes_only_public_headers_and_number():
    wrong = []
    for name in c_files("addons/"):
        part = name.split("/")[1]
        others = "|".join(sorted(PARTS_USE.get(part, set()))) or "-"
        allowed = rf"addons/{part}/|addons/({others})/include/|lib/include/|lib/src/number/"
        for target in filter(None, (resolve(name, included) for included in includes(name))):
            if not re.match(allowed, target):
                wrong.append(f"{name} includes {target}")
    assert wrong == []


def test_the_core_knows_no_part():
    """Neither its sources and headers nor its manifest name one."""
    names = [*c_files("lib/"), "lib/CMakeLists.txt"]
    words = "|".join(rf"davar_{part}\w*|DAVAR_{part.upper()}_\w+" for part in PARTS)
    assert lines_with(rf"\b({words}|addons)\b", names) == []


def test_every_source_of_the_library_belongs_to_one_room():
    parts = re.findall(
        r"^davar_part\((\w+)([^)]*)\)", text_of("addons/CMakeLists.txt"), re.MULTILINE
    )
    in_parts = [f"addons/{part}/{name}" for part, names in parts for name in names.split()]
    assert sorted(in_parts) == [name for name in c_files("addons/") if name.endswith(".c")]
    assert sorted(part for part, _ in parts) == PARTS
    manifest = text_of("lib/CMakeLists.txt")
    rooms = re.findall(r"^davar_room\(\s*(\w+)([^)]*)\)", manifest, re.MULTILINE)
    in_manifest = [f"lib/{name}" for _, names in rooms for name in names.split()]
    assert sorted(in_manifest) == [name for name in c_files("lib/src/") if name.endswith(".c")]
    for room, names in rooms:
        assert {str(Path(name).parent) for name in names.split()} == {f"src/{room}"}


def expanded(folders):
    """The folders of a row of the star."""
    words = folders.split()
    found = [*words, *(["lib/include"] if "public" in words else [])]
    for word, kind in (("public", "include"), ("addons/src", "src")):
        found += [f"addons/{part}/{kind}" for part in PARTS if word in words]
    return found


def test_everyone_includes_only_what_the_star_allows():
    wrong = []
    for name in c_files(""):
        folders = (may for prefix, may in MAY_INCLUDE.items() if name.startswith(prefix))
        allowed = next(folders, None)
        if allowed is None:
            wrong.append(f"{name}: a folder that the star does not know")
            continue
        allowed = expanded(allowed)
        own = str(Path(name).parent)
        for included in includes(name):
            target = resolve(name, included)
            folder = target and target[: -len(included) - 1]
            is_own = target and (folder == own or target.startswith(own + "/"))
            if target and not is_own and folder not in allowed:
                wrong.append(f"{name} includes {target}")
    assert wrong == []


def test_lib_includes_itself_in_full_and_a_few_standard_headers():
    wrong = []
    for name in c_files("lib/", "addons/"):
        for included in includes(name):
            is_ours = resolve(name, included) is not None
            is_short = "/include/" in name and not included.startswith("davar/")
            if (is_ours and is_short) or (not is_ours and included not in LIB_SYSTEM_HEADERS):
                wrong.append(f"{name} includes {included}")
    assert wrong == []


def depth(name, below, way=()):
    """Number of files in the longest chain of includes that begins with this one."""
    assert name not in way, f"{name} includes itself"
    if name not in below:
        own = [resolve(name, included) for included in includes(name)]
        depths = [depth(target, below, (*way, name)) for target in own if target]
        below[name] = 1 + max(depths, default=0)
    return below[name]


def test_no_chain_of_includes_is_long_or_a_circle():
    below = {}
    depths = {name: depth(name, below) for name in c_files("")}
    long = [name for name in c_files("lib/", "addons/") if depths[name] > DEPTH_MAX]
    assert long == []


# --- functions of the library ---


def complexities_in(text):
    """(name, cyclomatic complexity) of every function; assertions do not count."""
    code = bare(text).splitlines()
    for line, name, lines in functions_in(text):
        kept = [part for part in code[line - 1 : line + lines - 2] if part.lstrip()[:1] != "#"]
        body = re.sub(r"DAVAR_ASSERT\([^;]*;", "", "\n".join(kept))
        yield name, 1 + len(re.findall(r"\b(?:if|for|while|case)\b|&&|\|\||\?", body))


def test_a_function_fits_on_a_page_and_has_few_branches():
    found = [
        (f"{name}: {function}", lines, branches)
        for name in c_files("lib/", "addons/")
        for (_, function, lines), (_, branches) in zip(
            functions(name), complexities_in(text_of(name)), strict=True
        )
    ]
    assert len(found) > 500, "the functions were not recognised"
    assert [one for one in found if one[1] > FUNCTION_LINES_MAX or one[2] > COMPLEXITY_MAX] == []


def test_a_function_of_one_file_has_a_name_of_its_own():
    """All sources become one file, where the names of *_q15.c and *_q31.c get their type
    (tools/support/amalgamate.py).
    """
    places = {}
    for name in c_files("lib/src/", "addons/"):
        if name.endswith(".c"):
            for _, function, _ in functions(name):
                places.setdefault(function, set()).add(re.sub(r"_q(15|31)\.c$", "", name))
    assert len(places) > 500
    assert [where for where in places.items() if len(where[1]) > 1] == []


def test_lib_has_no_heap_no_output_and_no_clock():
    wrong = [
        f"{name}: {call.group()}"
        for name in c_files("lib/", "addons/")
        for call in re.finditer(LIB_FORBIDDEN_CALLS, bare(text_of(name)))
    ]
    assert wrong == []


# --- the tree ---


def lines_with(pattern, names):
    found = re.compile(pattern)
    return [
        f"{name}:{number}: {line.strip()}"
        for name in names
        if found.search(text_of(name))
        for number, line in enumerate(text_of(name).splitlines(), 1)
        if found.search(line)
    ]


def test_no_unfinished_work_is_marked_in_a_file():
    assert lines_with(r"\b(" + "|".join(MARKS) + r")\b", listed()) == []


def test_no_test_waits_for_a_deadline_that_a_busy_machine_misses():
    """Those of tests/kernel run in virtual time. fetch() of a browser has a default of 30 s."""
    found = []
    for name in listed():
        if name.startswith("tests/") and name.endswith(".py") and "/kernel" not in name:
            for limit in re.findall(r"\btimeout=([1-9][\d_]*)\b", text_of(name)):
                seconds = int(limit) / (1000 if int(limit) >= 1000 else 1)  # a browser's
                found += [(name, limit)] if seconds < HANG_S else []
            found += [(name, "fetch")] if re.search(r"\.fetch\(\)", text_of(name)) else []
    assert found == []


def test_every_test_program_is_built():
    manifest = text_of("tests/CMakeLists.txt")
    built = set(re.findall(r"^ *davar_test\((\w+ \w+)", manifest, re.MULTILINE))
    names = "\n".join(listed())
    there = re.findall(r"^tests/(\w+)/test_(\w+)\.c$", names, re.MULTILINE)
    assert {f"{folder} {name}" for folder, name in there} - built == set()


FUZZ_TARGETS = [name for name in listed() if re.match(r"tests/fuzz/\w+\.c$", name)]


STARTS = {f"davar{room}_init_{type}" for room in ("", "_cascade") for type in ("q15", "q31", "f32")}
STARTS |= {f"davar_{room}_init" for room in ("monitor", "select", "encoder", "telemetry")}


def test_a_start_that_can_fail_cannot_be_ignored():
    """A program that goes on after a start that failed crashes later, without a message."""
    headers = [name for name in listed() if re.match(r"(lib|addons/\w+)/include/", name)]
    text = "\n".join(bare(text_of(name)) for name in headers)
    may_fail = r"(?:bool|\w+_status_t)\s+(davar_\w*init\w*)\("
    assert set(re.findall(may_fail, text)) == STARTS
    assert set(re.findall(r"DAVAR_NODISCARD\s+" + may_fail, text)) == STARTS


def test_every_public_function_is_called_by_a_fuzz_target():
    """An endless loop was once in the one corner that fuzzing had left out."""
    declaration = re.compile(r"^(?!typedef|static|#)\w[\w\s*]*?\b(davar_\w+)\(", re.MULTILINE)
    headers = [name for name in listed() if re.match(r"(lib|addons/\w+)/include/", name)]
    declared = {one for name in headers for one in declaration.findall(bare(text_of(name)))}
    targets = "".join(bare(text_of(name)) for name in FUZZ_TARGETS)
    assert len(declared) > 70
    assert declared - set(re.findall(r"\b(davar_\w+)", targets)) == set()


def test_every_fuzz_target_has_inputs():
    """A target without any began at one byte, and in minutes it reached a fifth of its code."""
    names = "\n".join(listed())
    targets = re.findall(r"^tests/fuzz/fuzz_(\w+)\.c$", names, re.MULTILINE)
    archives = re.findall(r"^tests/fuzz/corpus/(\w+)\.tar\.gz$", names, re.MULTILINE)
    assert len(targets) == 10
    assert sorted(targets) == sorted(archives)


def test_no_statement_of_a_fuzz_target_reads_two_values_of_its_input():
    """The order of two reads in one expression is a choice of the compiler, and with it the meaning
    of an input.
    """
    reads = re.compile(r"\b(?:byte|between|word|magnitude|any|number|setting)\(&?bytes\b")
    whole = r"=\s*(?:\(\w+\))?\{[^;]*;"  # an initialiser is one statement
    found = []
    for name in FUZZ_TARGETS:
        code = re.sub(whole, lambda row: row[0].replace("{", "("), bare(text_of(name)))
        statements = re.split(r"[;{}]", code)
        found += [(name, one) for one in statements if len(reads.findall(one)) > 1]
    assert found == []


def test_the_version_has_one_definition():
    numbers = re.findall(r"#define DAVAR_VERSION_\w+ (\d+)", text_of(VERSION_HEADER))
    assert len(numbers) == 3
    version = r"(?<![\d.])" + r"\.".join(numbers) + r"(?![\d.])|#define DAVAR_VERSION_\w+ \d"
    names = [
        name
        for name in listed()
        if name not in (VERSION_HEADER, "CHANGELOG.md")
        and not Path(name).name.startswith("requirements")
    ]
    assert lines_with(version, names) == []


def test_address_maintainer_and_licence_of_all_packages_stand_in_one_file():
    table = tomllib.loads(text_of("pyproject.toml"))["project"]
    author = table["authors"][0]
    values = [table["urls"]["Homepage"], author["name"], author["email"], table["license"]]
    names = [name for name in listed() if name.startswith("packaging/")]
    found = lines_with("|".join(rf"\b{re.escape(value)}\b" for value in values), names)
    assert found == [], "write @HOMEPAGE@, @AUTHOR@, @MAINTAINER@ or @LICENSE@"


# --- pages ---

PAGES = [name for name in listed() if name.endswith(".md") and not name.startswith(".github/")]


@pytest.mark.parametrize("name", [name for name in PAGES if name != "python/davarlab/DESIGN.md"])
def test_a_page_begins_with_what_it_answers_and_no_table_has_more_than_eight_columns(name):
    assert re.match(r"# .*\n\nThis page answers: ", text_of(name))
    rows = re.findall(r"^ *\|(?: ?---+ ?\|)+$", text_of(name), re.MULTILINE)
    assert [row for row in rows if row.count("---") > 8] == []


def leads_somewhere(page, link):
    """True if the file of a link exists and has the heading of the link, if any."""
    path, _, heading = link.partition("#")
    target = page.parent / path if path else page
    if not heading or not target.is_file():
        return not heading and target.exists()
    titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
    return heading in {re.sub(r"[^\w\- ]", "", one).lower().replace(" ", "-") for one in titles}


@pytest.mark.parametrize("name", [name for name in PAGES if not name.startswith("packaging/")])
def test_every_path_that_a_page_names_exists(name):
    text = re.sub(r"^```.*?^```$", "", text_of(name), flags=re.DOTALL | re.MULTILINE)
    folders = {path.name for path in ROOT.iterdir() if path.is_dir()} - {"build", ".git"}
    codes = (code.split()[0] for code in re.findall(r"`([^`\n]+)`", text) if code.strip())
    paths = [code for code in codes if "/" in code and code.split("/")[0] in folders]
    links = [link for link in re.findall(r"\]\(([^)\s]+)", text) if not re.match(r"\w+:", link)]
    assert [path for path in paths if not list(ROOT.glob(path.strip("/")))] == []
    assert [link for link in links if not leads_somewhere(ROOT / name, link)] == []
