"""No module of tools/ imports itself by way of others, and no source of lib/ calls itself by way
of others, so that each can be read after what it uses. An import counts in a function, and for the
type checker only.
"""

import re
from pathlib import Path

from c_text import ROOT, bare, c_files, text_of

BASES = ("tools/lab", "tools/plan", "tools/support")  # what Python finds packages in
# The three forms of an import; the names of the second may stand in brackets, on several lines.
PLAIN = re.compile(r"^[ \t]*import ([\w., \t]+)", re.MULTILINE)
NAMES = re.compile(r"^[ \t]*from (\.*)([\w.]*) import (?:\(([^)]*)\)|([^\n#(]+))", re.MULTILINE)


def modules(root):
    """{path without its suffix, or folder of a package: its file} below a folder."""
    found = {}
    for path in root.rglob("*.py"):
        found[path.parent if path.name == "__init__.py" else path.with_suffix("")] = path
    return found


def imports(path, bases):
    """The places that a module may import: each name of an import may be a module, or be in one."""
    text = path.read_text()
    for line in PLAIN.findall(text):
        names = [one.split()[0] for one in line.split(",") if one.strip()]
        yield from (base.joinpath(*name.split(".")) for base in bases for name in names)
    for dots, module, several, one in NAMES.findall(text):
        origins = [path.parents[len(dots) - 1]] if dots else bases
        for name in (several or one).split(","):
            words = name.split()
            for origin in origins:
                place = origin.joinpath(*module.split("."))
                yield place / words[0] if words else place
                yield place


def graph(root, bases):
    """{module: the modules that it imports}. A package counts as imported only by its name, because
    Python has begun to import it before any module in it."""
    known = modules(root)
    found = {}
    for place, path in known.items():
        there = [one for one in imports(path, bases) if one in known]
        within = {one for one in there if one in place.parents}
        found[place] = set(there) - within - {place}
    return found


def circles(edges):
    """The modules on a circle, or on a path between two: what is left when modules that import
    none of the rest, and modules that none of the rest imports, are removed until none is left."""
    left = dict(edges)
    while True:
        wanted = {other for others in left.values() for other in others}
        kept = {
            one: {other for other in others if other in left}
            for one, others in left.items()
            if one in wanted and any(other in left for other in others)
        }
        if kept == left:
            return sorted(kept)
        left = kept


def calls(names):
    """{file: the files with functions that it calls}, of C files."""
    texts = {name: bare(text_of(name)) for name in names}
    defined = re.compile(r"^(?!static)[A-Za-z][\w *]*?\b(davar_\w+)\([^;{]*\)\s*\{", re.MULTILINE)
    home = {one: name for name, text in texts.items() for one in defined.findall(text)}
    return {
        name: {home[one] for one in re.findall(r"\b(davar_\w+)\(", text) if one in home} - {name}
        for name, text in texts.items()
    }


def test_no_module_of_tools_imports_itself_by_way_of_others():
    edges = graph(ROOT / "tools", [ROOT / base for base in BASES])
    assert sum(map(len, edges.values())) > 500  # it sees the imports
    assert [str(one.relative_to(ROOT)) for one in circles(edges)] == []


def test_no_source_of_the_library_calls_itself_by_way_of_others():
    edges = calls(
        [name for name in c_files("lib/src/", "addons/") if name.endswith((".c", ".inc"))]
    )
    assert sum(map(len, edges.values())) > 60
    assert circles(edges) == []


def test_a_circle_is_found_wherever_its_imports_are(tmp_path):
    package = tmp_path / "package"
    package.mkdir()
    for name, text in {
        "__init__": "",
        "first": "from . import second",
        "second": "def late():\n    from package.third import (\n        one,\n        two,\n    )",
        "third": "if TYPE_CHECKING:\n    import package.first",
        "above": "from .first import one",
        "below": "import re",
    }.items():
        Path(package, f"{name}.py").write_text(text)
    edges = graph(tmp_path, [tmp_path])
    assert [one.name for one in circles(edges)] == ["first", "second", "third"]
