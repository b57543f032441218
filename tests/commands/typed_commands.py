"""The commands in the pages and in the examples of --help, as typed there.

In a block (fenced or indented) a command is a line that begins with a program. In a block of shell
every line is a command. A line that ends in a backslash continues. In running text a command is
code (`like this`) that begins with a program and has more words.
"""

import re
import subprocess
from typing import NamedTuple

OURS = r"(?:tools|tests|build|data|examples)/[\w./-]+|davar-\w+|davarlab"
PROGRAM = re.compile(
    r"(?:(?:[A-Z_]+=\S+|nice|sudo|time) )*"
    rf"(?:{OURS}|cmake|ctest|cpack|pip|python3?|conan|pio|dpkg|cpackget|idf\.py|vcpkg|west|ip"
    r"|candump|cantools|slcand|git|gcc|[\w-]+-gcc|zcat|mkdir|cp|cd)(?= )|^\w+=\$\("
)
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?:(?<=\n\n)|(?<=:\n))((?:(?: {3,}|\t)\S.*\n)+)")
INLINE = re.compile(r"`([^`\n]+)`")
SHELL = ("sh", "bash", "shell", "console")
TEXT = ("", "text", *SHELL)


class Typed(NamedTuple):
    page: str
    text: str
    block: bool  # from a block; otherwise from running text


def lines_of(block, every):
    """The commands of a block: each line that begins with a program, or every line."""
    for line in re.sub(r"\\\n\s*", "", block).splitlines():
        line = re.sub(r"\s+#\s.*$", "", re.sub(r"^\$ ", "", line.strip()))
        if line and not line.startswith("#") and (every or PROGRAM.match(line + " ")):
            yield re.split(r" {3,}(?=[a-z])", line)[0] if not every else line


def of_page(page, text):
    """Every command of a page, in its order."""
    found = []
    for match in FENCE.finditer(text):
        if match[2] in TEXT:
            found += [
                (match.start(), Typed(page, line, True))
                for line in lines_of(match[3], match[2] in SHELL)
            ]
    rest = FENCE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    for match in INDENTED.finditer(rest):
        found += [(match.start(), Typed(page, line, True)) for line in lines_of(match[1], False)]
    for match in INLINE.finditer(
        re.sub(r"(?m)^(?: {4,}|\t).*$", lambda line: " " * len(line[0]), rest)
    ):
        if PROGRAM.match(match[1]) and " " in match[1]:
            found.append((match.start(), Typed(page, match[1], False)))
    return [one for _, one in sorted(found, key=lambda pair: pair[0])]


def of_help(name, text):
    """The examples of a help text: lines that begin with a program, except the usage, which is the
    first paragraph.
    """
    usage, _, rest = text.partition("\n\n")
    return [
        Typed(f"{name} --help", line.strip(), True)
        for line in (rest if usage.startswith("usage:") else text).splitlines()
        if line.startswith("  ") and PROGRAM.match(line.strip() + " ")
    ]


def tree(root):
    """The files that are, or would be, committed; names relative to the root."""
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    said = subprocess.run(words, cwd=root, check=True, text=True, stdout=subprocess.PIPE).stdout
    return [name for name in said.split("\0") if (root / name).is_file()]


def pages(root):
    """{name: text} of the tree's pages, except the list of changes, which describes the past."""
    names = sorted(name for name in tree(root) if name.endswith(".md"))
    return {name: (root / name).read_text() for name in names if name != "CHANGELOG.md"}
