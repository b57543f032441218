"""The CMSIS-Pack. Its schema (PACK.xsd of Open-CMSIS-Pack) is not in a package of Debian, PyPI or
npm. This test implements the rules for the elements that the description uses. It compiles the
listed files with the listed paths, from the finished pack.
"""

import re
import xml.etree.ElementTree
import zipfile

import pytest
from packaging_tools import CONSUMER, ROOT, run

# PACK.xsd: element -> required children, optional children, required attributes, optional ones
RULES = {
    "package": (
        "name vendor description url releases",
        "license keywords components",
        "schemaVersion",
        "",
    ),
    "releases": ("release", "", "", ""),
    "release": ("", "", "version", "date"),
    "keywords": ("keyword", "", "", ""),
    "components": ("component", "", "", ""),
    "component": ("description files", "RTE_Components_h", "Cclass Cgroup Cversion", "Csub"),
    "files": ("file", "", "", ""),
    "file": ("", "", "category name", "scope"),
}
VALUES = {
    "schemaVersion": r"\d+\.\d+(\.\d+)?",
    "version": r"\d+\.\d+\.\d+",
    "Cversion": r"\d+\.\d+(\.\d+)?",
    "date": r"\d{4}-\d\d-\d\d",
    "Cclass": r".{3,32}",
    "Cgroup": r".{3,32}",
    "Csub": r".{3,32}",
    "category": r"doc|header|include|source",
    "scope": "private",
}
LOCATION = "{http://www.w3.org/2001/XMLSchema-instance}noNamespaceSchemaLocation"


def wrong(element):
    """The errors that the schema would report, for an element and its descendants."""
    rule = (set(names.split()) for names in RULES.get(element.tag, ("", "", "", "")))
    must, may, needed, allowed = rule
    children, attributes = {child.tag for child in element}, set(element.attrib) - {LOCATION}
    said = [f"without {name}" for name in (must - children) | (needed - attributes)]
    said += [f"with {name}" for name in (children - must - may) | (attributes - needed - allowed)]
    said += [
        f"{name}: {value}"
        for name, value in element.attrib.items()
        if name in VALUES and not re.fullmatch(VALUES[name], value)
    ]
    if element.tag in ("package", "component"):  # xs:all
        said += [f"{name} twice" for name in children if len(element.findall(name)) > 1]
    return [f"{element.tag}: {one}" for one in said] + [
        x for child in element for x in wrong(child)
    ]


@pytest.fixture(scope="module")
def pack(draft, tmp_path_factory):
    """(the pack, unpacked; its description)"""
    folder = tmp_path_factory.mktemp("pack")
    with zipfile.ZipFile(draft.package("*.pack")) as archive:
        assert archive.testzip() is None
        archive.extractall(folder)
    (description,) = folder.glob("*.pdsc")
    return folder, xml.etree.ElementTree.parse(description).getroot()


def files_of(tree, category):
    return [file for file in tree.iter("file") if file.get("category") == category]


def test_the_description_is_as_the_schema_says(pack):
    _, tree = pack
    assert wrong(tree) == []
    tree = xml.etree.ElementTree.fromstring(xml.etree.ElementTree.tostring(tree))
    spoiled = {"release": ("version", "1"), "component": ("Cgroup", "x"), "file": ("colour", "red")}
    for found, (element, attribute) in enumerate(spoiled.items(), 1):  # the check can fail
        next(tree.iter(element)).set(*attribute)
        assert len(wrong(tree)) == found


def test_names_and_files_agree(pack, draft):
    folder, tree = pack
    vendor, name = tree.findtext("vendor"), tree.findtext("name")
    assert re.fullmatch(r"[-_A-Za-z0-9]+", vendor + name)
    version = tree.find("releases/release").get("version")
    assert draft.package("*.pack").name == f"{vendor}.{name}.{version}.pack"
    wanted = {f"{vendor}.{name}.pdsc", tree.findtext("license")}
    wanted |= {file.get("name") for file in tree.iter("file")}
    for path in wanted:
        assert (folder / path).is_dir() if path.endswith("/") else (folder / path).is_file(), path
    assert all(file.get("name").endswith("/") for file in files_of(tree, "include"))
    sources = (path.relative_to(ROOT / "lib") for path in (ROOT / "lib/src").rglob("*.c"))
    assert [file.get("name") for file in files_of(tree, "source")] == sorted(map(str, sources))


def test_the_listed_files_compile_and_link_for_a_cortex_m4(pack, tmp_path):
    folder, tree = pack
    core = ["-mcpu=cortex-m4", "-mthumb", "-std=c11", "-O0", "-Wall", "-Wextra", "-Werror"]
    include = {file.get("name"): file.get("scope") for file in files_of(tree, "include")}
    sources = [folder / file.get("name") for file in files_of(tree, "source")]
    paths = [f"-I{folder / name}" for name in include]
    run("arm-none-eabi-gcc", *core, *paths, "-c", *sources, folder=tmp_path)
    public = [f"-I{folder / name}" for name, scope in include.items() if scope is None]
    words = [*public, CONSUMER, *tmp_path.glob("*.o"), "-o", tmp_path / "consumer.elf"]
    run("arm-none-eabi-gcc", *core, *words, "--specs=nosys.specs", "-lm")
