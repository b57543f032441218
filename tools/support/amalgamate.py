"""Makes one davar.c and one davar.h from lib/ and addons/, for projects that prefer two files to
folders.

    python3 tools/support/amalgamate.py FOLDER     writes FOLDER/davar.h and FOLDER/davar.c

lib/CMakeLists.txt and addons/CMakeLists.txt are the manifests: they list the sources. The .inc
files are compiled once per number type, each time with different types for the same names. In one
file each of those names gets its type as a suffix: tau_t becomes tau_t_q15 and tau_t_q31. Standard
library only.
"""

import re
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIB, ADDONS = ROOT / "lib", ROOT / "addons"
FIELDS = LIB / "include/davar/config_fields.inc"  # a list, expanded at each include
TYPES = ("q15", "q31")
INCLUDE = re.compile(r'^#include "(.+)"\n', re.MULTILINE)
APART = re.compile(
    r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL
)  # comments and strings
PUBLIC = [LIB / "include", *sorted(ADDONS.glob("*/include"))]


def listed(folder: Path, call: str) -> list[tuple[str, str]]:
    """(name, source) of each source in the calls of a manifest."""
    manifest = (folder / "CMakeLists.txt").read_text()
    return [
        (name, source)
        for name, sources in re.findall(rf"^{call}\(\s*(\w+)([^)]*)\)", manifest, re.MULTILINE)
        for source in sources.split()
    ]


SOURCES = [LIB / source for _, source in listed(LIB, "davar_room")]
SOURCES += [ADDONS / name / source for name, source in listed(ADDONS, "davar_part")]
STARTS = {
    number: [path for path in SOURCES if path.stem.endswith(number)] for number in TYPES
}  # core/q15.c, laws/glr_q15.c
PER_TYPE = {*(LIB / "src").rglob("*.inc"), *STARTS["q15"], *STARTS["q31"]}


def find(name: str, includer: Path) -> Path:
    folders = (includer.parent, *PUBLIC, LIB / "src")
    return next(path for path in (folder / name for folder in folders) if path.is_file())


def needed(path: Path) -> list[Path]:
    """The project files that a file includes, by their names in the include."""
    return [find(name, path) for name in INCLUDE.findall(path.read_text())]


def all_needed(path: Path) -> set[Path]:
    return {path}.union(*map(all_needed, needed(path)))


def inner(text: str) -> str:
    """C text at file level: no comments and strings, and nothing in braces."""
    text, depth, kept = APART.sub(" ", text), 0, []
    for part in re.split(r"([{}])", text):
        depth -= part == "}"
        if depth == 0:
            kept.append(part)
        depth += part == "{"
    return "".join(kept)


def names(text: str) -> tuple[set[str], set[str]]:
    """What a file defines at file level: (types, functions, constants and macros; tags)."""
    level = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", "", inner(text), flags=re.MULTILINE)
    found = set(re.findall(r"^#define (\w+)", text, re.MULTILINE))
    found.update(
        re.findall(r"\b(\w+)\([^;{}]*\)\s*\{", level),
        re.findall(r"\btypedef\b[^;]*?(\w+);", level),
        re.findall(r"\bstatic const [\w ]+?(\w+)(?:\[\w*\])* =", level),
    )
    for body in re.findall(r"\benum(?: \w+)? \{(.*?)\}", APART.sub(" ", text), re.DOTALL):
        found.update(re.findall(r"\b([A-Z]\w+)\b(?=\s*[,=}]|\s*$)", body))
    public = {
        name
        for name in found
        if name.startswith(("davar_", "DAVAR_SRC_", "__")) or name == "NUMBER"
    }
    return (found - public) | ({"NUMBER"} & found), set(
        re.findall(r"\b(?:struct|enum|union) (\w+) \{", level)
    )


def typed(text: str, found: set[str], tags: set[str], number: str) -> str:
    """The text with the number type appended to each of those names; members of structs keep their
    names.
    """
    pattern = re.compile(
        rf"{APART.pattern}|(?<![.>])\b(?:{'|'.join(sorted(found))})\b"
        rf"|(?<=struct )(?:{'|'.join(sorted(tags)) or '$^'})\b",
        re.DOTALL,
    )
    return pattern.sub(
        lambda match: match.group() if match.group()[0] in "/\"'" else f"{match.group()}_{number}",
        text,
    )


def flat(
    path: Path, seen: set[Path], change: Callable[[Path, str], str] = lambda path, text: text
) -> str:
    """A file without its guard, with the project's includes expanded, each file only once."""
    if path in seen:
        return ""
    if path != FIELDS:
        seen.add(path)
    text = path.read_text()
    guard = re.search(r"^#ifndef (\w+)\n#define \1\n", text, re.MULTILINE)
    if guard:
        text = text[: guard.start()] + text[guard.end() : text.rindex("#endif")]
    text = (
        f"/* ---- {path.relative_to(ROOT).as_posix()} ---- */\n\n{change(path, text).strip()}\n\n"
    )
    return INCLUDE.sub(lambda match: flat(find(match.group(1), path), seen, change), text)


def header(seen: set[Path]) -> str:
    headers = (path for folder in PUBLIC for path in sorted((folder / "davar").glob("*.h")))
    text = "".join(flat(path, seen) for path in headers)
    return (
        "/* davar - all public headers in one, made by tools/support/amalgamate.py. "
        "MIT licence. */\n"
        f"#ifndef DAVAR_ONE_H\n#define DAVAR_ONE_H\n\n{text}#endif\n"
    )


def typed_once(number: str, seen: set[Path]) -> str:
    """The files that are compiled with this number type, with the type appended to each name.
    `seen` collects the files that both types share.
    """
    starts = STARTS[number]
    own = PER_TYPE & set().union(*map(all_needed, starts))
    found, tags = (set().union(*each) for each in zip(*(names(path.read_text()) for path in own)))
    text = "".join(
        flat(
            start,
            seen,
            lambda path, text: typed(text, found, tags, number) if path in own else text,
        )
        for start in starts
    )
    seen -= own
    return text


def source(seen: set[Path]) -> str:
    """davar.c: one pipeline after the other, then the rest."""
    text = "".join(typed_once(number, seen) for number in STARTS)
    seen |= PER_TYPE
    text += "".join(flat(path, seen) for path in SOURCES)
    return (
        "/* davar - the library in one file, made by tools/support/amalgamate.py. MIT licence. */\n"
        '#include "davar.h"\n\n'
        "#ifdef __GNUC__ /* not every type uses all that a header offers */\n"
        f'#pragma GCC diagnostic ignored "-Wunused-function"\n#endif\n\n{text}'
    )


def main() -> None:
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    seen: set[Path] = set()
    (folder / "davar.h").write_text(header(seen), encoding="utf-8")
    (folder / "davar.c").write_text(source(seen), encoding="utf-8")


if __name__ == "__main__":
    main()
