"""Makes the API reference in build/reference with every warning an error: Doxygen for the public C
headers, pdoc for the Python package. An undocumented symbol is an error in both.
"""

import importlib
import inspect
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import warnings
from pathlib import Path
from typing import Generic, NewType, TypeVar
from unittest import mock
from xml.etree import ElementTree

import numpy.typing as npt
import pdoc

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "build/reference"
DOXYFILE = (ROOT / "docs/Doxyfile").read_text(encoding="utf-8")
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


def doxygen(out, *settings):
    """What Doxygen reports with docs/Doxyfile and these settings; pages and XML go to `out`."""
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as xml:
        more = [f"OUTPUT_DIRECTORY = {out}", "GENERATE_XML = YES", f"XML_OUTPUT = {xml}", *settings]
        done = subprocess.run(
            ["doxygen", "-"],
            cwd=ROOT,
            input="\n".join([DOXYFILE, *more]),
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        missing = {name for page in Path(xml).glob("*.xml") for name in without_text(page)}
    assert bool(done.returncode) == bool(done.stdout), done.stdout
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


def headers():
    """The public headers that docs/Doxyfile lists."""
    places = re.search(r"^INPUT = (.*)$", DOXYFILE, re.MULTILINE)[1].split()
    return [path for place in places for path in sorted((ROOT / place).rglob("*.h"))]


class C(unittest.TestCase):
    def test_every_symbol_of_the_headers_is_documented(self):
        self.assertEqual("", doxygen(OUT))

    def test_every_header_has_a_page_and_is_in_the_index(self):
        index = (ROOT / "docs/reference.dox").read_text(encoding="utf-8")
        self.assertGreater(len(headers()), 10)
        for path in headers():
            with self.subTest(header=path.name):
                # without it, Doxygen ignores the header's functions and macros and does not warn
                self.assertTrue(path.read_text(encoding="utf-8").startswith("/** @file\n"))
                self.assertRegex(index, rf"[ ,]{re.escape(path.name)}[ ,]")

    def reported(self, header):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "header.h").write_text(header, encoding="utf-8")
            return doxygen(Path(folder, "out"), f"INPUT = {folder}/header.h")

    def test_a_symbol_without_its_comment_is_an_error(self):
        self.assertEqual("", self.reported(HEADER))
        comments = list(re.finditer(r"/\*\*(?=<? \w)", HEADER))
        self.assertEqual(13, len(comments))
        for place in comments:
            plain = f"{HEADER[: place.start()]}/*{HEADER[place.end() :]}"
            with self.subTest(HEADER[place.start() :].split("*/")[0], at=place.start()):
                self.assertIn(" is not documented", self.reported(plain))


Scalar = TypeVar("Scalar")
ArrayLike = NewType("ArrayLike", object)


class NDArray(Generic[Scalar]):
    pass


def undocumented(space):
    """The public members of a module or class without a docstring, with their full names."""
    members = space.own_members if isinstance(space, pdoc.doc.Class) else space.members.values()
    for member in members:
        if not member.name.startswith("_"):
            yield from [] if member.docstring.strip() else [member.fullname]
            yield from undocumented(member) if isinstance(member, pdoc.doc.Class) else []


class Python(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """Imports davar with numpy's types as names; pdoc would print their definitions."""
        for one in (ArrayLike, NDArray):
            one.__module__ = "numpy.typing"
        with mock.patch.multiple(npt, ArrayLike=ArrayLike, NDArray=NDArray):
            cls.davar = importlib.import_module("davar")

    def test_the_pages_are_made_without_a_warning(self):
        pdoc.render.configure(docformat="google", show_source=False, search=False)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pdoc.pdoc("davar", "!davar.lab", output_directory=OUT / "python")
        page = (OUT / "python/davar.html").read_text(encoding="utf-8")
        self.assertIn("numpy.typing.ArrayLike", re.sub("<[^>]+>", "", page))
        index = (ROOT / "docs/reference.dox").read_text(encoding="utf-8")
        for link in re.findall(r'href="([^"]+)"', index):
            self.assertTrue((OUT / link).is_file(), link)

    def test_every_public_symbol_has_a_docstring(self):
        self.assertEqual([], list(undocumented(pdoc.doc.Module(self.davar))))

    def test_every_argument_is_documented(self):
        for function in (self.davar.adev, self.davar.dynamic, self.davar.read):
            section = re.search(r"^Args:\n(.*?)^$", inspect.getdoc(function), re.DOTALL | re.M)[1]
            named = re.findall(r"^    (\w+):", section, re.MULTILINE)
            self.assertEqual(sorted(inspect.signature(function).parameters), sorted(named))

    def test_an_undocumented_symbol_is_found(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(sys, "path", [folder]):
            texts = [MODULE] + [
                MODULE[: place.start()] + "pass" + MODULE[place.end() :]
                for place in re.finditer('"""[^"]+"""', MODULE)
            ][1:]
            found = []
            for number, text in enumerate(texts):
                Path(folder, f"page{number}.py").write_text(text, encoding="utf-8")
                module = importlib.import_module(f"page{number}")
                found.append([name[6:] for name in undocumented(pdoc.doc.Module(module))])
        self.assertEqual(
            [[], ["function"], ["Class"], ["Class.field"], ["Class.method"], ["Class.read_only"]],
            found,
        )


if __name__ == "__main__":
    unittest.main()
