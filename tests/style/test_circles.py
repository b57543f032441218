"""No module of python/ or tools/ imports itself by way of others, and no source of lib/ calls
itself by way of others, so that each can be read after what it uses. An import counts in a
function, and for the type checker only.
"""

import ast
import graphlib
import re

from c_text import ROOT, bare, c_files, text_of

BASES = [ROOT / name for name in ("python", "tools/support")]


def imports(path):
    """The places that a module may import: each name of an import may be a module, or be in one."""
    for node in ast.walk(ast.parse(path.read_text())):
        names = [alias.name for alias in getattr(node, "names", ()) if isinstance(alias, ast.alias)]
        if isinstance(node, ast.Import):
            yield from (base.joinpath(*name.split(".")) for base in BASES for name in names)
        elif isinstance(node, ast.ImportFrom):
            origins = [path.parents[node.level - 1]] if node.level else BASES
            for origin in origins:
                place = origin.joinpath(*(node.module or "").split("."))
                yield from (place, *(place / name for name in names))


def calls(names):
    """{file: the files with functions that it calls}, of C files."""
    texts = {name: bare(text_of(name)) for name in names}
    defined = re.compile(r"^(?!static)[A-Za-z][\w *]*?\b(davar_\w+)\([^;{]*\)\s*\{", re.MULTILINE)
    home = {one: name for name, text in texts.items() for one in defined.findall(text)}
    return {
        name: {home[one] for one in re.findall(r"\b(davar_\w+)\(", text) if one in home} - {name}
        for name, text in texts.items()
    }


def test_no_module_of_python_or_tools_imports_itself_by_way_of_others():
    """A package counts as imported only by its name, because Python has begun to import it before
    any module in it.
    """
    modules = {
        path.parent if path.name == "__init__.py" else path.with_suffix(""): path
        for base in BASES
        for path in base.rglob("*.py")
    }
    edges = {
        place: {one for one in imports(path) if one in modules} - {place, *place.parents}
        for place, path in modules.items()
    }
    assert sum(map(len, edges.values())) > 500  # it sees the imports
    graphlib.TopologicalSorter(edges).prepare()  # or it names a circle


def test_no_source_of_the_library_calls_itself_by_way_of_others():
    edges = calls(
        [name for name in c_files("lib/src/", "addons/") if name.endswith((".c", ".inc"))]
    )
    assert sum(map(len, edges.values())) > 60
    graphlib.TopologicalSorter(edges).prepare()
