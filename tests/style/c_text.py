"""Reads the text of the tree: its files, the includes of C and the functions that C defines."""

import re
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# The parts around the core.
PARTS = sorted(path.name for path in (ROOT / "addons").iterdir() if path.is_dir())
# Folders in which an included name is searched, after the includer's own folder.
INCLUDE_PATH = (
    "lib/include",
    *(f"addons/{part}/{kind}" for part in PARTS for kind in ("include", "src")),
    "lib/src",
    "port/include",
    "port/node",
    "port/linux",
    "port/job",
    "port/bare_metal",
    "host_sim",
    "python",
    "tests/support",
    "tests/tracking",
)


@cache
def listed():
    """The files that are committed or would be; names relative to the root."""
    words = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(words, cwd=ROOT, check=True, text=True, capture_output=True)
        names = done.stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):  # no git, or not a clone: an unpacked archive
        paths = [path.relative_to(ROOT) for path in ROOT.rglob("*")]
        kept = [path for path in paths if path.parts[0] not in ("build", ".git")]
        names = [str(path) for path in kept if "__pycache__" not in path.parts]
    return sorted(name for name in names if (ROOT / name).is_file())


@cache
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


@cache
def includes(name):
    return re.findall(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', text_of(name), re.MULTILINE)


@cache
def resolve(name, included):
    """The file of the tree that an include means; None if it is not in the tree."""
    for folder in (str(Path(name).parent), *INCLUDE_PATH):
        if (ROOT / folder / included).is_file():
            return f"{folder}/{included}"
    return None


@cache
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


@cache
def functions(name):
    """[(line, function, lines)] of every definition in a file."""
    return list(functions_in(text_of(name)))


def functions_in(text):
    """(line, name, lines) of every function definition: a brace at file level after a
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
                line = text.count("\n", 0, start[0]) + 1
                yield line, start[1], text.count("\n", start[0], at) + 2  # with the signature
                start = None
