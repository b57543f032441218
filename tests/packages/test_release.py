"""tools/release: one version number in every package, correct checksums, the same bytes again,
a bill of materials, errors that give the cause.
"""

import hashlib
import io
import json
import re
import subprocess
import sys
import tarfile
import zipfile
from collections import defaultdict

import pytest
import release
from packaging_tools import ROOT, run

NO_DEB = (ROOT / "tools/release", "--draft", "--no-deb", "--out")


def contents(path):
    """{name: bytes} of the files in a package; of a Debian package those that it installs."""
    if path.suffix in (".zip", ".pack"):
        with zipfile.ZipFile(path) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    data = path.read_bytes()
    if path.suffix == ".deb":
        words = ["dpkg-deb", "--fsys-tarfile", path]
        data = subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        files = [one for one in archive if one.isfile()]
        return {one.name.removeprefix("./"): archive.extractfile(one).read() for one in files}


def versions(folder):
    """{manifest: its version}, read from the finished packages."""
    packages = [path for path in folder.iterdir() if path.is_file() and path.name != "SHA256SUMS"]
    found = {path.name: re.search(r"\d+\.\d+\.\d+", path.name)[0] for path in packages}
    for pattern, name, version in (
        ("davar-platformio-*", "library.json", r'^ *"version": "(.*)"'),
        ("davar-arduino-*", "davar/library.properties", "^version=(.*)$"),
        ("davar-esp-idf-*", "idf_component.yml", '^version: "(.*)"$'),
        ("davar-vcpkg-*", "davar/vcpkg.json", r'^ *"version": "(.*)"'),
        ("*.pack", "davar.davar.pdsc", '<release version="([^"]*)"'),
        ("*.pack", "davar.davar.pdsc", 'Cversion="([^"]*)"'),
    ):
        (package,) = folder.glob(pattern)
        text = contents(package)[name].decode()
        (found[version + name],) = re.findall(version, text, re.MULTILINE)
    return found


def sums_of(folder):
    """{file: its checksum} in SHA256SUMS."""
    return dict(line.split()[::-1] for line in (folder / "SHA256SUMS").read_text().splitlines())


def test_every_manifest_has_the_version_of_the_header(draft):
    found = versions(draft.folder)
    for deb in draft.folder.glob("*.deb"):
        found[f"control of {deb.name}"] = run("dpkg-deb", "-f", deb, "Version").strip()
    assert set(found.values()) == {release.version()}, found
    assert len(found) >= 14
    manifest = json.loads(contents(draft.package("davar-vcpkg-*"))["davar/vcpkg.json"])
    assert manifest["name"] == "davar"
    needed = {one["name"] for one in manifest["dependencies"]}
    assert needed == {"vcpkg-cmake", "vcpkg-cmake-config"}


def test_another_version_takes_another_number_in_the_header_only(tmp_path):
    tree, out = tmp_path / "tree", tmp_path / "out"
    for name in release.tree():
        release.copy(ROOT / name, tree / name)
    header, changes = tree / "lib/include/davar/version.h", tree / "CHANGELOG.md"
    text = header.read_text(encoding="utf-8")
    for part, number in (("MAJOR", 9), ("MINOR", 8), ("PATCH", 7)):
        text = re.sub(rf"(#define DAVAR_VERSION_{part}) \d+", rf"\1 {number}", text)
    header.write_text(text, encoding="utf-8")
    command = [sys.executable, "-B", tree / "tools/support/release.py", "--no-deb", "--out"]
    said = run(*command, out, status=2)
    assert "CHANGELOG.md: no section '## [9.8.7] - YYYY-MM-DD'" in said
    assert not out.exists()
    with changes.open("a", encoding="utf-8") as file:
        file.write("\n## [9.8.7] - 2026-12-01\n")
    run(*command, out)
    assert set(versions(out).values()) == {"9.8.7"}
    run(*command, tmp_path / "again")  # the same tree gives the same bytes
    assert sums_of(tmp_path / "again") == sums_of(out)


def test_the_checksums_are_right_and_cover_everything(draft):
    run("sha256sum", "--check", "--strict", "SHA256SUMS", folder=draft.folder)
    files = {path.name for path in draft.folder.iterdir() if path.is_file()}
    assert {*sums_of(draft.folder), "SHA256SUMS"} == files


def test_the_bill_of_materials_lists_every_file_of_every_package(draft):
    bill = json.loads(draft.package("*.spdx.json").read_text())
    named = {one["packageFileName"]: one for one in bill["packages"] if "packageFileName" in one}
    assert {*named, draft.package("*.spdx.json").name} == set(sums_of(draft.folder))
    inside = defaultdict(set)
    for one in bill["relationships"]:
        if one["relationshipType"] == "CONTAINS":
            inside[one["spdxElementId"]].add(one["relatedSpdxElement"])
    sha = {
        one["SPDXID"]: (
            one["fileName"].removeprefix("./"),
            next(sum["checksumValue"] for sum in one["checksums"] if sum["algorithm"] == "SHA256"),
        )
        for one in bill["files"]
    }
    for name, package in named.items():
        files = contents(draft.folder / name)
        there = {(file, hashlib.sha256(data).hexdigest()) for file, data in files.items()}
        assert {sha[one] for one in inside[package["SPDXID"]]} == there, name
    needs = {one["name"].split()[0] for one in bill["packages"] if "packageFileName" not in one}
    assert {"libc6", "zlib1g"} <= needs


@pytest.mark.soak
def test_the_bill_of_materials_is_valid(draft, tools):
    run(tools / "pyspdxtools", "-i", draft.package("*.spdx.json"))


@pytest.mark.parametrize("seconds", ("soon", "-1", "1"))
def test_a_wrong_time_is_rejected(tmp_path, seconds):
    said = run(*NO_DEB, tmp_path / "new", status=2, SOURCE_DATE_EPOCH=seconds)
    assert "SOURCE_DATE_EPOCH: " in said
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    "changes, draft, is_good",
    (
        ("# Changelog\n\n## [Unreleased]\n\n## [1.2.3] - 2026-12-01\n", False, True),
        ("# Changelog\n\n## [Unreleased]\n\n## [1.2.2] - 2026-12-01\n", True, True),
        ("## [Unreleased]\n", False, False),
        ("## [1.2.30] - 2026-12-01\n", False, False),
        ("## [1.2] - 2026-12-01\n", True, False),
        ("## [1.2.3]\n", False, False),
        ("## [1x2.3] - 2026-12-01\n", False, False),
        ("## Unreleased\n", True, False),
    ),
)
def test_the_list_of_changes_has_the_version(changes, draft, is_good):
    if is_good:
        release.check_changes(changes, "1.2.3", draft)
    else:
        with pytest.raises(release.Refused):
            release.check_changes(changes, "1.2.3", draft)


def test_rejected_calls(tmp_path):
    assert "already exists" in run(*NO_DEB, tmp_path, status=2)
    with pytest.raises(release.Refused, match="@NOBODY@"):
        release.fill("version @NOBODY@", {"VERSION": "1.2.3"})
