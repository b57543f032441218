"""Makes the API reference in build/reference with every warning an error: Doxygen for the public C
headers, pdoc for the Python package. An undocumented symbol is an error in both.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "build/reference"
DOXYFILE = (ROOT / "docs/Doxyfile").read_text(encoding="utf-8")
INDEX = (ROOT / "docs/reference.dox").read_text(encoding="utf-8")
# Every kind of symbol.
HEADER = """/** @file
 * A header. */
/** A struct. */
typedef struct {
    int field; /**< a field */
    struct {
        int inner; /**< a field */
    } nested; /**< a field */
    void (*call)(int x); /**< a field */
    /** @privatesection */
    int hidden;
} struct_t;
/** An enum. */
typedef enum {
    VALUE = 1 /**< a value */
} enum_t;
/** A variable. */
extern const int variable;
/** A macro. */
#define MACRO 1
/** A function. */
int function(int x);
/** An inline function. */
static inline int inlined(void) { return 1; }
/** @{ */
/** Two functions. */
int one(void);
int two(void);
/** @} */
/** A function with its size in its name. */
#define davar_sized DAVAR_SIZED(davar_sized)
int davar_sized(void);
"""
COMMENTS = list(re.finditer(r"/\*\*(?=<? \w)", HEADER))
MODULE = '''"""A module."""

def function():
    """A function."""

class Class:
    """A class."""

    field: int
    """A field."""

    def method(self):
        """A method."""

    @property
    def read_only(self):
        """A property."""

    def _private(self):
        pass
'''


def doxygen(out, xml, *settings):
    """What Doxygen reports with docs/Doxyfile and these settings."""
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    more = [f"OUTPUT_DIRECTORY = {out}", "GENERATE_XML = YES", f"XML_OUTPUT = {xml}", *settings]
    done = subprocess.run(
        ["doxygen", "-"],
        cwd=ROOT,
        input="\n".join([DOXYFILE, *more]),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert bool(done.returncode) == bool(done.stdout), done.stdout
    missing = {name for page in xml.glob("*.xml") for name in without_text(page)}
    return done.stdout + "".join(f"{name} is not documented\n" for name in sorted(missing))


def without_text(page):
    """The public members and enum values in an XML page that have no description. Doxygen 1.9.4
    does not warn about enum values, nor about members of a nested struct.
    """
    tree = ElementTree.parse(page)
    for member in [*tree.iter("memberdef"), *tree.iter("enumvalue")]:
        texts = [member.find(f"{kind}description").itertext() for kind in ("brief", "detailed")]
        if member.get("prot") == "public" and not "".join(map("".join, texts)).strip():
            yield member.findtext("qualifiedname") or member.findtext("name")


def test_every_symbol_of_the_headers_is_documented(tmp_path):
    assert doxygen(OUT, tmp_path) == ""


def test_every_header_has_a_page_and_is_in_the_index():
    places = re.search(r"^INPUT = (.*)$", DOXYFILE, re.MULTILINE)[1].split()
    headers = [path for place in places for path in sorted((ROOT / place).rglob("*.h"))]
    assert len(headers) > 10
    for path in headers:
        # without it, Doxygen ignores the header's functions and macros and does not warn
        assert path.read_text(encoding="utf-8").startswith("/** @file\n"), path
        assert re.search(rf"[ ,]{re.escape(path.name)}[ ,]", INDEX), path


@pytest.mark.parametrize("place", range(-1, len(COMMENTS)))
def test_a_symbol_without_its_comment_is_an_error(tmp_path, place):
    """-1: with all comments."""
    assert len(COMMENTS) == 13
    at = COMMENTS[place].start()
    text = HEADER if place < 0 else f"{HEADER[:at]}/*{HEADER[at + 3 :]}"
    (tmp_path / "header.h").write_text(text)
    said = doxygen(tmp_path / "out", tmp_path / "xml", f"INPUT = {tmp_path}/header.h")
    assert (" is not documented" in said) == (place >= 0), said
    assert (said == "") == (place < 0)


# Runs in a process of its own, because it replaces types of numpy by their names: pdoc would print
# their definitions. Prints the undocumented members and arguments of a module.
PDOC = """
import importlib, inspect, re, sys, warnings
from pathlib import Path
from typing import Generic, NewType, TypeVar
import numpy.typing
import pdoc

name, out = sys.argv[1:3]

class NDArray(Generic[TypeVar("Scalar")]):
    pass

for one in (NewType("ArrayLike", object), NDArray):
    one.__module__ = "numpy.typing"
    setattr(numpy.typing, one.__name__, one)

def undocumented(space):
    members = space.own_members if isinstance(space, pdoc.doc.Class) else space.members.values()
    for member in members:
        if not member.name.startswith("_"):
            yield from [] if member.docstring.strip() else [member.fullname]
            yield from undocumented(member) if isinstance(member, pdoc.doc.Class) else []

module = importlib.import_module(name)
print(*undocumented(pdoc.doc.Module(module)), sep="\\n")
if name == "davar":
    for function in (module.adev, module.dynamic, module.read):
        text = inspect.getdoc(function)
        section = re.search(r"^Args:\\n(.*?)^$", text, re.DOTALL | re.MULTILINE)[1]
        named = set(re.findall(r"^    (\\w+):", section, re.MULTILINE))
        print(*named ^ set(inspect.signature(function).parameters), sep="\\n")
    pdoc.render.configure(docformat="google", show_source=False, search=False)
    warnings.simplefilter("error")
    pdoc.pdoc("davar", "!davar.lab", output_directory=Path(out))
"""


def undocumented(module, path, out=""):
    done = subprocess.run(
        [sys.executable, "-c", PDOC, module, str(out)],
        env={"PYTHONPATH": str(path)},
        text=True,
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_every_public_symbol_and_argument_of_the_package_is_documented():
    assert undocumented("davar", ROOT / "python", OUT / "python") == []
    page = (OUT / "python/davar.html").read_text(encoding="utf-8")
    assert "numpy.typing.ArrayLike" in re.sub("<[^>]+>", "", page)
    for link in re.findall(r'href="([^"]+)"', INDEX):
        assert (OUT / link).is_file(), link


def test_undocumented_symbols_are_found(tmp_path):
    (tmp_path / "good.py").write_text(MODULE)
    (tmp_path / "bad.py").write_text(re.sub('(?<= )"""[^"]+"""', "pass", MODULE))
    assert undocumented("good", tmp_path) == []
    names = ("function", "Class", "Class.field", "Class.method", "Class.read_only")
    assert undocumented("bad", tmp_path) == [f"bad.{name}" for name in names]
