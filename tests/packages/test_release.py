"""tools/release: one version number in every package, correct checksums, the same bytes again,
errors that give the cause.
"""

import json
import re
import subprocess
import sys
import tarfile
import unittest
import zipfile
from pathlib import Path
from unittest import mock

from package_case import RELEASE, ROOT, PackageCase, run
from spdx_tools.spdx.model import RelationshipType
from spdx_tools.spdx.parser import parse_anything
from spdx_tools.spdx.validation.document_validator import validate_full_spdx_document

sys.path.insert(0, str(ROOT / "tools/support"))
import release


def text_of(archive, member):
    if archive.suffix in (".zip", ".pack"):
        return zipfile.ZipFile(archive).read(member).decode()
    with tarfile.open(archive) as packed:
        return packed.extractfile(member).read().decode()


def versions(folder):
    """{manifest: its version}, read from the finished packages."""
    one = {
        path.name.split("-")[1] if path.name.count("-") > 1 else path.suffix: path
        for path in folder.iterdir()
        if path.is_file()
    }
    pdsc = text_of(one[".pack"], "davar.davar.pdsc")
    return {
        "platformio": json.loads(text_of(one["platformio"], "library.json"))["version"],
        "arduino": re.search(
            r"^version=(.*)$", text_of(one["arduino"], "davar/library.properties"), re.MULTILINE
        )[1],
        "esp-idf": re.search(
            r'^version: "(.*)"$', text_of(one["esp"], "idf_component.yml"), re.MULTILINE
        )[1],
        "vcpkg": json.loads(text_of(one["vcpkg"], "davar/vcpkg.json"))["version"],
        "cmsis release": re.search(r'<release version="([^"]*)"', pdsc)[1],
        "cmsis component": re.search(r'Cversion="([^"]*)"', pdsc)[1],
        **{
            f"name of {path.name}": re.search(r"\d+\.\d+\.\d+", path.name)[0]
            for path in folder.iterdir()
            if path.is_file() and path.name != "SHA256SUMS"
        },
    }


def copy_of_tree(folder):
    for name in release.tree():
        release.copy(ROOT / name, folder / name)
    return folder


class Release(PackageCase):
    def test_every_manifest_has_the_version_of_the_header(self):
        found = versions(RELEASE)
        for deb in RELEASE.glob("*.deb"):
            found[deb.name] = subprocess.run(
                ["dpkg-deb", "-f", deb, "Version"], text=True, stdout=subprocess.PIPE, check=True
            ).stdout.strip()
        self.assertEqual({release.version()}, set(found.values()), found)
        self.assertGreaterEqual(len(found), 14)

    def test_another_number_in_the_header_is_the_only_change_that_another_version_takes(self):
        tree, out = copy_of_tree(self.work / "tree"), self.work / "out"
        header = tree / "lib/include/davar/version.h"
        text = header.read_text(encoding="utf-8")
        for part, number in (("MAJOR", 9), ("MINOR", 8), ("PATCH", 7)):
            text = re.sub(rf"(#define DAVAR_VERSION_{part}) \d+", rf"\1 {number}", text)
        header.write_text(text, encoding="utf-8")
        command = [sys.executable, tree / "tools/support/release.py", "--no-deb", "--out", out]
        said = run(*command, status=2)
        self.assertIn("CHANGELOG.md: no section '## [9.8.7] - YYYY-MM-DD'", said)
        self.assertFalse(out.exists())
        changes = tree / "CHANGELOG.md"
        changes.write_text(
            changes.read_text(encoding="utf-8") + "\n## [9.8.7] - 2026-12-01\n", encoding="utf-8"
        )
        run(*command)
        self.assertEqual({"9.8.7"}, set(versions(out).values()))

    def test_the_checksums_are_right_and_cover_everything(self):
        run("sha256sum", "--check", "--strict", "SHA256SUMS", folder=RELEASE)
        named = {line.split()[1] for line in (RELEASE / "SHA256SUMS").read_text().splitlines()}
        self.assertEqual(
            named | {"SHA256SUMS"}, {path.name for path in RELEASE.iterdir() if path.is_file()}
        )

    def test_the_same_tree_gives_the_same_bytes(self):
        run(ROOT / "tools/release", "--draft", "--no-deb", "--out", self.work / "again")
        wanted = dict(
            line.split()[::-1] for line in (RELEASE / "SHA256SUMS").read_text().splitlines()
        )
        for line in (self.work / "again/SHA256SUMS").read_text().splitlines():
            if not line.endswith(".spdx.json"):  # it lists the Debian packages too
                self.assertEqual(wanted[line.split()[1]], line.split()[0], line.split()[1])

    def test_the_bill_of_materials_is_valid_and_lists_every_file_of_every_package(self):
        (bill,) = RELEASE.glob("*.spdx.json")
        found = parse_anything.parse_file(str(bill))
        self.assertEqual([], validate_full_spdx_document(found))
        named = {one.file_name: one for one in found.packages if one.file_name}
        sums = {line.split()[1] for line in (RELEASE / "SHA256SUMS").read_text().splitlines()}
        self.assertEqual(sums - {bill.name}, set(named))
        inside = {
            one.spdx_element_id: set()
            for one in found.relationships
            if one.relationship_type is RelationshipType.CONTAINS
        }
        files = {one.spdx_id: one for one in found.files}
        for one in found.relationships:
            if one.relationship_type is RelationshipType.CONTAINS:
                file = files[one.related_spdx_element_id]
                sha = next(sum.value for sum in file.checksums if sum.algorithm.name == "SHA256")
                inside[one.spdx_element_id].add((sha, file.name))
        for name, package in named.items():
            folder = self.work / name
            folder.mkdir()
            unpack = {".gz": "tar -xf", ".deb": "dpkg-deb -x"}
            command = unpack.get(Path(name).suffix, "python3 -m zipfile -e").split()
            run(*command, RELEASE / name, *([] if "tar" in command else ["."]), folder=folder)
            said = run("find", ".", "-type", "f", "-exec", "sha256sum", "{}", "+", folder=folder)
            there = {tuple(line.split(None, 1)) for line in said.splitlines()}
            self.assertEqual(there, inside[package.spdx_id], name)
        needs = {one.name.split()[0] for one in found.packages if not one.file_name}
        self.assertTrue({"libc6", "zlib1g"} <= needs, needs)

    def test_a_tree_inside_another_repository_is_read_completely(self):
        run("git", "init", "-q", self.work)
        inner = self.work.resolve() / "davar"
        inner.mkdir()
        (inner / "a.c").write_text("int a;\n")
        (self.work / ".gitignore").write_text("davar\n")
        with mock.patch.object(release, "ROOT", inner):
            self.assertEqual(release.tree(), ["a.c"])

    def test_rejected_calls(self):
        for seconds in ("soon", "-1", "1"):
            self.assertIn(
                "SOURCE_DATE_EPOCH: ",
                run(
                    ROOT / "tools/release",
                    "--draft",
                    "--no-deb",
                    "--out",
                    self.work / "new",
                    status=2,
                    SOURCE_DATE_EPOCH=seconds,
                ),
            )
        self.assertIn(
            "already exists",
            run(ROOT / "tools/release", "--draft", "--no-deb", "--out", self.work, status=2),
        )
        release.check_changes(
            "# Changelog\n\n## [Unreleased]\n\n## [1.2.3] - 2026-12-01\n", "1.2.3", False
        )
        release.check_changes(
            "# Changelog\n\n## [Unreleased]\n\n## [1.2.2] - 2026-12-01\n", "1.2.3", True
        )
        for changes, draft in (
            ("## [Unreleased]\n", False),
            ("## [1.2.30] - 2026-12-01\n", False),
            ("## [1.2] - 2026-12-01\n", True),
            ("## [1.2.3]\n", False),
            ("## [1x2.3] - 2026-12-01\n", False),
            ("## Unreleased\n", True),
        ):
            with self.assertRaises(release.Refused):
                release.check_changes(changes, "1.2.3", draft)
        with self.assertRaisesRegex(release.Refused, "@NOBODY@"):
            release.fill("version @NOBODY@", {"VERSION": "1.2.3"})

    def test_no_package_holds_a_build_or_a_cache(self):
        for path in (RELEASE / "layout").rglob("*"):
            self.assertNotIn(path.name, ("__pycache__", ".pio", "build", ".git"), path)
            self.assertNotEqual(".in", Path(path).suffix)


if __name__ == "__main__":
    unittest.main()
