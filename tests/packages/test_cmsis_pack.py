"""The CMSIS-Pack. Its schema (PACK.xsd of Open-CMSIS-Pack) is not in a package of Debian, PyPI or
npm. This test implements the rules for the elements that the description uses. It compiles the
listed files with the listed paths, from the finished pack.
"""

import re
import unittest
import xml.etree.ElementTree
import zipfile

from package_case import CONSUMER, ROOT, PackageCase, package, run

PACK = package("*.pack")
# PACK.xsd: element -> (required children, optional children, required attributes, optional
# attributes)
RULES = {
    "package": (
        {"name", "vendor", "description", "url", "releases"},
        {"license", "keywords", "components"},
        {"schemaVersion"},
        set(),
    ),
    "releases": ({"release"}, set(), set(), set()),
    "release": (set(), set(), {"version"}, {"date"}),
    "keywords": ({"keyword"}, set(), set(), set()),
    "components": ({"component"}, set(), set(), set()),
    "component": (
        {"description", "files"},
        {"RTE_Components_h"},
        {"Cclass", "Cgroup", "Cversion"},
        {"Csub"},
    ),
    "files": ({"file"}, set(), set(), set()),
    "file": (set(), set(), {"category", "name"}, {"scope"}),
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
    must, may, needed, allowed = RULES.get(element.tag, (set(), set(), set(), set()))
    children, attributes = {child.tag for child in element}, set(element.attrib) - {LOCATION}
    said = [f"{element.tag}: without {name}" for name in (must - children) | (needed - attributes)]
    said += [
        f"{element.tag}: {name} has no place in it"
        for name in (children - must - may) | (attributes - needed - allowed)
    ]
    said += [
        f"{name}: {value}"
        for name, value in element.attrib.items()
        if name in VALUES and not re.fullmatch(VALUES[name], value)
    ]
    if element.tag in ("package", "component"):  # xs:all
        said += [
            f"{element.tag}: {name} twice" for name in children if len(element.findall(name)) > 1
        ]
    return said + [line for child in element for line in wrong(child)]


class CmsisPack(PackageCase):
    def setUp(self):
        super().setUp()
        with zipfile.ZipFile(PACK) as archive:
            self.assertIsNone(archive.testzip())
            archive.extractall(self.work)
        (description,) = self.work.glob("*.pdsc")
        self.tree = xml.etree.ElementTree.parse(description).getroot()

    def names(self, category):
        return [
            file.get("name") for file in self.tree.iter("file") if file.get("category") == category
        ]

    def test_the_description_is_as_the_schema_says(self):
        self.assertEqual([], wrong(self.tree))
        spoiled = (
            ("release", {"version": "1"}),
            ("component", {"Cgroup": "x"}),
            ("file", {"colour": "red"}),
        )
        for found, (element, attributes) in enumerate(spoiled, 1):  # the check can fail
            next(self.tree.iter(element)).attrib.update(attributes)
            self.assertEqual(found, len(wrong(self.tree)), attributes)

    def test_the_names_agree(self):
        vendor, name = self.tree.findtext("vendor"), self.tree.findtext("name")
        self.assertRegex(vendor + name, r"^[-_A-Za-z0-9]+$")
        self.assertTrue((self.work / f"{vendor}.{name}.pdsc").is_file())
        self.assertEqual(
            f"{vendor}.{name}.{self.tree.find('releases/release').get('version')}.pack", PACK.name
        )

    def test_every_file_exists_and_every_source_is_listed(self):
        for file in self.tree.iter("file"):
            there = self.work / file.get("name")
            self.assertTrue(
                there.is_dir() if file.get("category") == "include" else there.is_file(), there
            )
            self.assertEqual(file.get("category") == "include", file.get("name").endswith("/"))
        self.assertTrue((self.work / self.tree.findtext("license")).is_file())
        self.assertEqual(
            sorted(
                path.relative_to(ROOT / "lib").as_posix()
                for path in (ROOT / "lib/src").rglob("*.c")
            ),
            self.names("source"),
        )

    def test_the_listed_files_compile_and_link_for_a_cortex_m4(self):
        core = ["-mcpu=cortex-m4", "-mthumb", "-std=c11", "-Os", "-Wall", "-Wextra", "-Werror"]
        paths = [f"-I{self.work / name}" for name in self.names("include")]
        run(
            "arm-none-eabi-gcc",
            *core,
            *paths,
            "-c",
            *(self.work / name for name in self.names("source")),
            folder=self.work,
        )
        public = [
            f"-I{self.work / file.get('name')}"
            for file in self.tree.iter("file")
            if file.get("category") == "include" and file.get("scope") is None
        ]
        run(
            "arm-none-eabi-gcc",
            *core,
            *public,
            CONSUMER,
            *self.work.glob("*.o"),
            "-o",
            self.work / "consumer.elf",
            "--specs=nosys.specs",
            "-lm",
        )


if __name__ == "__main__":
    unittest.main()
