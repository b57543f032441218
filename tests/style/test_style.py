"""The style rules that a script can check: includes, calls that lib/ must not make, function
length.

Reads only the text of the tree; nothing is built.
"""

import re
import statistics
import subprocess
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FUNCTION_LINES_MAX = 60
HANG_S = 300
VERSION_HEADER = "lib/include/davar/version.h"
# Folders in which an included name is searched, after the includer's own folder.
INCLUDE_PATH = (
    "lib/include",
    "lib/src",
    "port/include",
    "port/node",
    "port/linux",
    "port/job",
    "port/wire",
    "port/bare_metal",
    "host_sim",
    "python",
    "tests/support",
    "tests/tracking",
)
# The star: folder (first match) -> folders whose headers it may include, besides its own.
MAY_INCLUDE = {
    "examples/": ("lib/include",),
    "lib/include": (),
    "lib/src": ("lib/include", "lib/src"),
    "port/include": ("lib/include",),
    "port/node": ("lib/include", "port/include"),
    "port/wire": ("lib/include", "lib/src"),  # the frame layout
    "port/": ("port/include", "port/wire", "lib/include"),
    "firmware": (
        "lib/include",
        "port/include",
        "port/node",
        "port/job",
        "port/wire",
        "port/bare_metal",
    ),
    "gateway": ("lib/include", "port/include", "port/node", "port/linux"),
    "host_sim": ("lib/include", "port/include", "port/node", "port/job", "host_sim"),
    "tests/unit": (
        "lib/include",
        "lib/src",
        "port/include",
        "port/node",
        "port/wire",
        "host_sim",
        "tests/support",
    ),
    "tests/tracking": (
        "lib/include",
        "lib/src",
        "port/bare_metal",
        "port/include",
        "tests/support",
    ),
    "tests/proofs": ("lib/include", "lib/src", "port/wire"),
    "tests/target": ("lib/include", "port/bare_metal", "port/include"),
    "tests/port": (
        "lib/include",
        "port/include",
        "port/linux",
        "port/node",
        "port/template",
        "tests/support",
    ),
    "tests/fuzz": (
        "lib/include",
        "port/include",
        "port/wire",
        "gateway",
        "host_sim",
        "tests/support",
        "tests/tracking",
    ),
    "tests/statistics": ("host_sim", "lib/include", "tests/support"),
    "tests/": ("lib/include", "port/include", "port/node", "port/wire", "tests/support"),
    "tools/": ("lib/include", "port/include"),
    "python": ("lib/include", "port/include", "host_sim"),
}
LIB_SYSTEM_HEADERS = {
    "assert.h",
    "float.h",
    "limits.h",
    "math.h",
    "stdatomic.h",
    "stdbool.h",
    "stddef.h",
    "stdint.h",
    "string.h",
}
LIB_FORBIDDEN_CALLS = (
    r"\b(malloc|calloc|realloc|free|alloca|\w*printf|puts|putchar|\w*scanf|fopen|exit|abort|time|"
    r"clock|signal|setjmp|longjmp)\s*\("
)
MARKS = tuple(
    "".join(halves) for halves in [("TO", "DO"), ("FIX", "ME"), ("XX", "X"), ("HA", "CK")]
)


def listed():
    """The files that are committed or would be; names relative to the root."""
    try:
        done = subprocess.run(
            ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            check=True,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        names = done.stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):  # no git, or not a clone: an unpacked archive
        below = (path.relative_to(ROOT) for path in ROOT.rglob("*"))
        names = [
            str(path)
            for path in below
            if path.parts[0] not in ("build", ".git") and "__pycache__" not in path.parts
        ]
    return sorted(name for name in names if (ROOT / name).is_file())


def text_of(name):
    """The text of a file; empty if it is not text."""
    try:
        return (ROOT / name).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return ""


def c_files(*folders):
    return [
        name
        for name in listed()
        if name.endswith((".c", ".h", ".inc")) and name.startswith(folders)
    ]


def includes(name):
    return re.findall(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', text_of(name), re.MULTILINE)


def resolve(name, included):
    """The file of the tree that an include means; None if it is not in the tree."""
    for folder in (str(Path(name).parent), *INCLUDE_PATH):
        if (ROOT / folder / included).is_file():
            return f"{folder}/{included}"
    return None


def bare(text):
    """C text without comments, strings and preprocessor lines; line numbers stay the same."""

    def blank(match):
        return "\n" * match.group().count("\n") or " "

    text = re.sub(
        r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'',
        blank,
        text,
        flags=re.DOTALL,
    )
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", blank, text, flags=re.MULTILINE)


def functions(text):
    """Yields (line, name, lines) of every function definition: a brace at file level after a
    parenthesis.
    """
    text, depth, start = bare(text), 0, None
    for brace in re.finditer(r"[{}]", text):
        at = brace.start()
        if brace.group() == "{":
            head = text[:at].rstrip()
            if depth == 0 and head.endswith(")"):
                names = re.findall(
                    r"\b(\w+)\s*\(", head[max(head.rfind(";"), head.rfind("}")) + 1 :]
                )
                start = (at, names[0] if names else "?")
            depth += 1
        else:
            depth -= 1
            if depth == 0 and start:
                # one line for the signature, then brace to brace
                yield (
                    text.count("\n", 0, start[0]) + 1,
                    start[1],
                    text.count("\n", start[0], at) + 2,
                )
                start = None


# The rooms: which others each may include, besides itself. The entry functions lie beside them. Of
# lib/src, filter, fit, cascade, monitor, select, state and wire include public headers and number
# alone, and fit also filter (tests/consumer/test_rooms.py builds each of them without the rest).
ROOMS = {
    "lib/src": {
        "number": set(),
        "filter": {"number"},
        "core": {"number"},
        "pipeline": {"number", "core"},
        "detector": {"number", "core"},
        "fit": {"number", "filter"},
        "cascade": {"number"},
        "monitor": {"number"},
        "select": {"number"},
        "state": {"number"},
        "wire": {"number"},
    },
    "host_sim": {
        "common": set(),
        "options": {"common"},
        "recording": {"common", "options"},
        "learning": {"common", "options", "recording"},
        "instances": {"common", "options", "recording", "learning"},
        "output": {"common", "options", "recording", "learning", "instances"},
        "replay": {"common", "options", "recording", "learning", "instances", "output"},
    },
}
# A file may include this one header of another directory, for the reason given.
ROOM_EXCEPTIONS = {
    (
        "lib/src/state/state.c",
        "lib/src/core/instance.h",
    ): "it saves the core's memory and lays it out again"
}
ROOM_FILES_MAX = {"lib/src": 12, "host_sim": 24}  # host_sim: a dozen pairs


class Rooms(unittest.TestCase):
    def test_rooms_import_one_way_and_have_few_files(self):
        for house, rooms in ROOMS.items():
            with self.subTest(house=house):
                self.check_house(house, rooms)

    def check_house(self, house, rooms):
        wrong, files = [], {}
        for name in c_files(f"{house}/"):
            room = Path(name).parent.name
            if room == Path(house).name:
                continue
            files[room] = files.get(room, 0) + 1
            for included in includes(name):
                target = resolve(name, included)
                other = (
                    Path(target).parent.name if target and target.startswith(f"{house}/") else room
                )
                if (
                    other != room
                    and other not in rooms[room]
                    and (name, target) not in ROOM_EXCEPTIONS
                ):
                    wrong.append(f"{name} includes {target}")
        self.assertEqual([], wrong)
        self.assertEqual(set(rooms), set(files))
        self.assertLessEqual(max(files.values()), ROOM_FILES_MAX[house], files)


class Manifest(unittest.TestCase):
    def test_every_source_of_the_library_belongs_to_one_room(self):
        rooms = re.findall(
            r"^davar_room\(\s*(\w+)([^)]*)\)", text_of("lib/CMakeLists.txt"), re.MULTILINE
        )
        listed_there = [f"lib/{name}" for _, names in rooms for name in names.split()]
        self.assertEqual(
            sorted(name for name in c_files("lib/src/") if name.endswith(".c")),
            sorted(listed_there),
        )
        for room, names in rooms:
            if room not in ("core", "detector"):
                self.assertEqual(
                    {f"src/{room}"}, {str(Path(name).parent) for name in names.split()}
                )


class Names(unittest.TestCase):
    def test_a_function_of_one_file_has_a_name_of_its_own(self):
        """All sources become one file, where the names of *_q15.c and *_q31.c get their type
        (tools/support/amalgamate.py).
        """
        places = {}
        for name in c_files("lib/src/"):
            if name.endswith(".c"):
                for _, function, _ in functions(text_of(name)):
                    places.setdefault(function, set()).add(re.sub(r"_q(15|31)\.c$", "", name))
        self.assertGreater(len(places), 500)
        self.assertEqual([], [where for where in places.items() if len(where[1]) > 1])


class Includes(unittest.TestCase):
    def test_everyone_includes_only_what_the_star_allows(self):
        wrong = []
        for name in c_files(""):
            allowed = next(
                (folders for prefix, folders in MAY_INCLUDE.items() if name.startswith(prefix)),
                None,
            )
            if allowed is None:
                wrong.append(f"{name}: a folder that the star does not know")
                continue
            own = str(Path(name).parent)
            for included in includes(name):
                target = resolve(name, included)
                folder = target and target[: -len(included) - 1]
                inside_own = target and (folder == own or target.startswith(own + "/"))
                if target and not inside_own and folder not in allowed:
                    wrong.append(f"{name} includes {target}")
        self.assertEqual(wrong, [])

    def test_lib_includes_nothing_but_itself_and_a_few_standard_headers(self):
        wrong = [
            f"{name} includes {included}"
            for name in c_files("lib/")
            for included in includes(name)
            if not resolve(name, included) and included not in LIB_SYSTEM_HEADERS
        ]
        self.assertEqual(wrong, [])

    def test_public_headers_name_each_other_in_full(self):
        wrong = [
            f"{name} includes {included}"
            for name in c_files("lib/include/")
            for included in includes(name)
            if resolve(name, included) and not included.startswith("davar/")
        ]
        self.assertEqual(wrong, [])

    def test_no_header_includes_itself_by_a_detour(self):
        graph = {
            name: [
                target
                for target in (resolve(name, included) for included in includes(name))
                if target
            ]
            for name in c_files("")
        }
        done, cycles = set(), []

        def visit(name, way):
            if name in way:
                cycles.append(" -> ".join([*way[way.index(name) :], name]))
            elif name not in done:
                for target in graph.get(name, ()):
                    visit(target, [*way, name])
                done.add(name)

        for name in graph:
            visit(name, [])
        self.assertEqual(cycles, [])


# Loops over samples and records are in these folders. A loop without its own counter asserts in its
# body that it ends. The assertion uses a name in the loop's head, or of a value added to one (which
# grows or shrinks with every iteration). Otherwise the loop is listed here with the reason.
LOOPING = ("lib/src/core/", "lib/src/pipeline/", "lib/src/detector/", "lib/src/cascade/")
BOUNDED = {
    (
        "lib/src/pipeline/type_q31.inc",
        "while ((top > 1U) && (wide->limb[top] == 0U))",
    ): "top falls to 1",
    ("lib/src/pipeline/type_q15.inc", "while (n > 0U)"): "n falls by SMALL_RUN or to 0",
    ("lib/src/pipeline/type_q15.inc", "while (count > 0U)"): "count falls by POWERS_RUN or to 0",
    (
        "lib/src/pipeline/type_q15.inc",
        "for (const sample_t *const end = sample + count; sample != end;)",
    ): "sample rises by POWERS_RUN or to end",
    ("lib/src/core/gaps.c", "while (low < high)"): "what lies between halves",
    (
        "lib/src/core/gaps.c",
        "while ((gone < gaps->count) && ((int32_t)(gaps->position[gone] - oldest) <= 0))",
    ): "gone rises to the count",
    (
        "lib/src/detector/glr_queue.inc",
        "while ((queue->accepted > 0U) && !complete)",
    ): "pass_on() takes one at least",
    (
        "lib/src/pipeline/push.inc",
        "while ((window->received - window->end) < (half - 1U))",
    ): "received rises by one",
    (
        "lib/src/core/f32.c",
        "while ((run < most) && davar_is_finite(rates[run]))",
    ): "run rises by one",
    ("lib/src/core/window.h", "while ((step * power) <= (*back >> 1U))"): "power doubles",
    (
        "lib/src/detector/glr.c",
        "while ((levels < GLR_LEVELS) && (((GLR_RECORDS - 1U) << (levels - 1U)) < longest))",
    ): "levels rises",
    (
        "lib/src/cascade/cascade.c",
        "while (cascade->ready != 0U)",
    ): "each event serves a hop; stages pass on at most one",
    (
        "lib/src/detector/scan.c",
        "while ((level < levels) && (((at >> (level - 1U)) & 1U) == 0U))",
    ): "level rises",
}


def closed(text, at, pair):
    """The position where the bracket at `at` is closed."""
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] == pair[0]) - (text[i] == pair[1])
        if depth == 0:
            return i
    raise AssertionError(text[at : at + 60])


def loops_without_counter(text):
    """Yields (head, body) of each while loop, and of each for loop with an empty third part."""
    text = bare(text)
    for loop in re.finditer(r"\b(while|for) \(", text):
        end = closed(text, loop.end() - 1, "()")
        head = " ".join(text[loop.start() : end + 1].split())
        after = text[end + 1 :].lstrip()
        if after.startswith("{") and (loop[1] == "while" or head.endswith(";)")):
            start = text.index("{", end)
            yield head, text[start : closed(text, start, "{}")]


NAME = r"(?<!\w)[A-Za-z_]\w*(?:(?:->|\.)\w+)*\b(?!\()"  # with the members it names; no call


def asserts_its_end(head, body):
    """True if the body asserts something about a name in the head, or about a value that the body
    adds to it or subtracts from it.
    """
    names = set(re.findall(NAME, head.split("(", 1)[1]))
    for changed, by in re.findall(rf"({NAME}) [-+]= ([^;]+);", body):
        names |= set(re.findall(NAME, by)) if changed in names else set()
    asserted = [
        name
        for call in re.finditer(r"\bDAVAR_ASSERT\(", body)
        for name in re.findall(NAME, body[call.end() : closed(body, call.end() - 1, "()")])
    ]
    return any(
        f"{a}->".startswith(f"{b}->") or f"{b}->".startswith(f"{a}->")
        for a in asserted
        for b in names
    )


class Library(unittest.TestCase):
    def test_an_assertion_of_something_else_ends_no_loop(self):
        head = "while ((done < count) && !window->complete)"
        for body, ends in (
            ("const size_t n = f(done); DAVAR_ASSERT(n > 0U); done += n;", True),
            ("DAVAR_ASSERT(done < g(x)); done = h(done);", True),
            ("DAVAR_ASSERT(window != NULL);", True),
            ("DAVAR_ASSERT(n > 0U); other += n;", False),
            ("DAVAR_ASSERT(window->length > 0U);", False),
            ("DAVAR_ASSERT(done(x) && undone);", False),
            ("done += n;", False),
        ):
            with self.subTest(body=body):
                self.assertEqual(ends, asserts_its_end(head, body))

    def test_every_loop_over_records_asserts_what_ends_it(self):
        seen, wrong = set(), []
        for name in c_files(*LOOPING):
            for head, body in loops_without_counter(text_of(name)):
                seen.add((name, head))
                if not asserts_its_end(head, body) and (name, head) not in BOUNDED:
                    wrong.append(f"{name}: {head}")
        self.assertEqual([], wrong)
        self.assertEqual([], sorted(set(BOUNDED) - seen), "no such loop any more")
        self.assertGreater(len(seen), 15, "the loops were not recognised")

    def test_lib_has_no_heap_no_output_and_no_clock(self):
        wrong = [
            f"{name}: {call.group()}"
            for name in c_files("lib/")
            for call in re.finditer(LIB_FORBIDDEN_CALLS, bare(text_of(name)))
        ]
        self.assertEqual(wrong, [])

    def test_a_function_fits_on_a_page(self):
        found = [
            (lines, f"{name}:{line} {function}")
            for name in c_files("lib/")
            for line, function, lines in functions(text_of(name))
        ]
        self.assertGreater(len(found), 50, "the functions of lib/ were not recognised")
        lengths = sorted(lines for lines, _ in found)
        print(
            f"lib/: {len(found)} functions, median {statistics.median(lengths):g} lines, "
            "nine in ten within "
            f"{lengths[len(lengths) * 9 // 10]}, longest {max(found)[0]} ({max(found)[1]})",
            flush=True,
        )
        self.assertEqual(
            [f"{where}: {lines} lines" for lines, where in found if lines > FUNCTION_LINES_MAX], []
        )


class Tree(unittest.TestCase):
    def test_whoever_selects_c_files_by_suffix_selects_the_pages_too(self):
        """A tool that lists ".c" and ".h" but not ".inc" silently skips the pipeline."""
        wrong = [
            f"{name}: {found}"
            for name in listed()
            if name.endswith(".py")
            for found in re.findall(r"\([^()]*\"\.c\", ?\"\.h\"[^()]*\)", text_of(name))
            if '".inc"' not in found
        ]
        self.assertEqual(wrong, [])

    def test_no_unfinished_work_is_marked_in_a_file(self):
        marks = re.compile(r"\b(" + "|".join(MARKS) + r")\b")
        wrong = [
            f"{name}:{number}: {line.strip()}"
            for name in listed()
            for number, line in enumerate(text_of(name).splitlines(), 1)
            if marks.search(line)
        ]
        self.assertEqual(wrong, [])

    def test_no_test_waits_for_a_deadline_that_a_busy_machine_misses(self):
        """Those of tests/kernel run in virtual time. fetch() of a browser has a default of 30 s."""
        found = []
        for path in sorted((ROOT / "tests").rglob("*.py")):
            if not path.relative_to(ROOT / "tests").parts[0].startswith("kernel"):
                text = path.read_text("utf-8")
                for limit in re.findall(r"\btimeout=([1-9][\d_]*)\b", text):
                    seconds = int(limit) / (1000 if int(limit) >= 1000 else 1)  # a browser's
                    if seconds < HANG_S:
                        found.append((str(path.relative_to(ROOT)), limit))
                if re.search(r"\.fetch\(\)", text):
                    found.append((str(path.relative_to(ROOT)), "fetch"))
        self.assertEqual([], found)

    def test_every_test_program_is_built(self):
        built = set(
            re.findall(r"^ *davar_test\((\w+ \w+)", text_of("tests/CMakeLists.txt"), re.MULTILINE)
        )
        there = re.findall(r"^tests/(\w+)/test_(\w+)\.c$", "\n".join(listed()), re.MULTILINE)
        self.assertEqual(
            [f"{folder} {name}" for folder, name in there if f"{folder} {name}" not in built], []
        )

    def test_every_public_function_is_called_by_a_fuzz_target(self):
        """An endless loop was once in the one corner that fuzzing had left out."""
        headers = [name for name in listed() if name.startswith("lib/include/")]
        declared = {
            found
            for name in headers
            for found in re.findall(
                r"^(?!typedef|static|#)\w[\w\s*]*?\b(davar_\w+)\(",
                bare(text_of(name)),
                re.MULTILINE,
            )
        }
        targets = [name for name in listed() if re.match(r"tests/fuzz/\w+\.c$", name)]
        called = set(re.findall(r"\b(davar_\w+)", "".join(bare(text_of(name)) for name in targets)))
        self.assertGreater(len(declared), 70)
        self.assertEqual(sorted(declared - called), [])

    def test_every_fuzz_target_has_inputs(self):
        """A target without any began at one byte, and in minutes it reached a fifth of its code."""
        names = "\n".join(listed())
        targets = re.findall(r"^tests/fuzz/fuzz_(\w+)\.c$", names, re.MULTILINE)
        archives = re.findall(r"^tests/fuzz/corpus/(\w+)\.tar\.gz$", names, re.MULTILINE)
        self.assertGreater(len(targets), 10)
        self.assertEqual(sorted(targets), sorted(archives))

    def test_no_statement_of_a_fuzz_target_reads_two_values_of_its_input(self):
        """The order of two reads in one expression is a choice of the compiler, and with it the
        meaning of an input.
        """
        reads = re.compile(r"\b(?:byte|between|word|magnitude|any|number|setting)\(&?bytes\b")
        found = []
        for name in listed():
            if re.match(r"tests/fuzz/\w+\.c$", name):
                whole = r"=\s*(?:\(\w+\))?\{[^;]*;"  # an initialiser is one statement
                code = re.sub(whole, lambda row: row[0].replace("{", "("), bare(text_of(name)))
                found += [
                    (name, " ".join(statement.split()))
                    for statement in re.split(r"[;{}]", code)
                    if len(reads.findall(statement)) > 1
                ]
        self.assertEqual(found, [])

    def test_the_version_has_one_definition(self):
        numbers = re.findall(r"#define DAVAR_VERSION_\w+ (\d+)", text_of(VERSION_HEADER))
        self.assertEqual(len(numbers), 3)
        version = re.compile(
            r"(?<![\d.])" + r"\.".join(numbers) + r"(?![\d.])|#define DAVAR_VERSION_\w+ \d"
        )
        wrong = [
            f"{name}:{number}: {line.strip()}"
            for name in listed()
            if name not in (VERSION_HEADER, "CHANGELOG.md")
            and not Path(name).name.startswith("requirements")
            for number, line in enumerate(text_of(name).splitlines(), 1)
            if version.search(line)
        ]
        self.assertEqual(wrong, [])

    def test_address_maintainer_and_licence_of_all_packages_stand_in_one_file(self):
        table = tomllib.loads(text_of("pyproject.toml"))["project"]
        author = table["authors"][0]
        values = [table["urls"]["Homepage"], author["name"], author["email"], table["license"]]
        wrong = [
            f"{name}: {value}"
            for name in listed()
            if name.startswith("packaging/")
            for value in values
            if re.search(rf"\b{re.escape(value)}\b", text_of(name))
        ]
        self.assertEqual([], wrong, "write @HOMEPAGE@, @AUTHOR@, @MAINTAINER@ or @LICENSE@")

    def test_a_page_begins_with_what_it_answers_and_no_table_has_more_than_eight_columns(self):
        pages = [
            name
            for name in listed()
            if name.endswith(".md")
            and name != "tools/lab/DESIGN.md"
            and not name.startswith(".github/")
        ]
        self.assertGreater(len(pages), 20)
        for name in pages:
            with self.subTest(page=name):
                self.assertRegex(text_of(name), r"\A# .*\n\nThis page answers: ")
                rows = re.findall(r"^ *\|(?: ?---+ ?\|)+$", text_of(name), re.MULTILINE)
                self.assertEqual([], [row for row in rows if row.count("---") > 8])

    def test_every_path_that_the_pages_name_exists(self):
        for name in listed():
            if name.endswith(".md") and not name.startswith("packaging/"):
                with self.subTest(page=name):
                    self.check_paths(ROOT / name)

    def check_paths(self, page):
        text = re.sub(
            r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
        )
        folders = {path.name for path in ROOT.iterdir() if path.is_dir()} - {"build", ".git"}
        codes = (code.split()[0] for code in re.findall(r"`([^`\n]+)`", text) if code.strip())
        paths = [code for code in codes if "/" in code and code.split("/")[0] in folders]
        wrong = [path for path in paths if not list(ROOT.glob(path.strip("/")))]
        links = [link for link in re.findall(r"\]\(([^)\s]+)", text) if not re.match(r"\w+:", link)]
        self.assertEqual(
            wrong + [link for link in links if not self.leads_somewhere(page, link)], []
        )

    def leads_somewhere(self, page, link):
        """True if the file of a link exists and has the heading of the link, if any."""
        path, _, heading = link.partition("#")
        target = page.parent / path if path else page
        if not heading:
            return target.exists()
        titles = (
            re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            if target.is_file()
            else []
        )
        return heading in {
            re.sub(r"[^\w\- ]", "", title).lower().replace(" ", "-") for title in titles
        }


if __name__ == "__main__":
    unittest.main()
