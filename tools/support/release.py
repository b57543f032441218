"""Makes every package of davar from the tree, with one version number, the bill of materials of all
of them, and SHA256SUMS.

A package is a layout: files of packaging/NAME and folders of the tree, packed. Files that end in
.in have @VERSION@ and similar names replaced. Nothing is downloaded, and the same commit gives the
same bytes. docs/PACKAGES.md describes the use of each package. Standard library only.
"""

import argparse
import gzip
import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import tomllib
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import materials

ROOT = Path(__file__).resolve().parents[2]
FIRST_DAY = 315532800  # 1980-01-01, the first date that a zip file supports
PARTS = sorted(path.name for path in (ROOT / "addons").iterdir() if path.is_dir())
# Folder (or file) of the tree -> of the package, in which core and parts share include and src. The
# manifests of packaging/NAME are added, with licence and README.
SOURCES = {"lib/src": "src", **{f"addons/{part}/src": f"src/{part}" for part in PARTS}}
HEADERS = ["lib/include/davar", *(f"addons/{part}/include/davar" for part in PARTS)]
LIBRARY = {**SOURCES, **dict.fromkeys(HEADERS, "include/davar")}
LAYOUTS = {
    "platformio": {**LIBRARY, "examples/platformio": "examples/arw"},
    "arduino": {**SOURCES, **dict.fromkeys(HEADERS, "src/davar"), "examples/arduino": "examples"},
    "esp-idf": {**LIBRARY, "packaging/common/Kconfig": "Kconfig.options"},
    "cmsis-pack": LIBRARY,
    "vcpkg": {},
}


class Refused(Exception):
    """The tree is not ready for a release; the text states the fix."""


def version() -> str:
    """MAJOR.MINOR.PATCH, from the header that defines it."""
    header = (ROOT / "lib/include/davar/version.h").read_text(encoding="utf-8")
    return ".".join(
        re.findall(rf"#define DAVAR_VERSION_{part} (\d+)", header)[0]
        for part in ("MAJOR", "MINOR", "PATCH")
    )


def project() -> dict[str, str]:
    """Address, maintainer, licence and copyright of every package, from the project table of
    pyproject.toml and from LICENSE, by their names in the manifests.
    """
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    author = table["authors"][0]
    licence = (ROOT / "LICENSE").read_text(encoding="utf-8")
    return {
        "HOMEPAGE": table["urls"]["Homepage"],
        "LICENSE": table["license"],
        "AUTHOR": author["name"],
        "MAINTAINER": f"{author['name']} <{author['email']}>",
        "COPYRIGHT": re.findall(r"^Copyright .*$", licence, re.MULTILINE)[0],
    }


def check_changes(changes: str, number: str, draft: bool) -> None:
    """CHANGELOG.md must have a dated section of this version, in the form of Keep a Changelog; for
    a draft, [Unreleased] is enough.
    """
    wanted = [rf"\[{re.escape(number)}\] - \d{{4}}-\d\d-\d\d"] + (
        [r"\[Unreleased\]"] if draft else []
    )
    if not any(re.search(rf"^## {title}$", changes, re.MULTILINE) for title in wanted):
        raise Refused(
            f"CHANGELOG.md: no section '## [{number}] - YYYY-MM-DD'"
            + (
                " and no '## [Unreleased]'"
                if draft
                else " (with --draft, '## [Unreleased]' is enough)"
            )
        )


def git(*words: str) -> str:
    """The output of git. Raises OSError without git, CalledProcessError outside a repository."""
    return subprocess.run(
        ["git", *words],
        cwd=ROOT,
        check=True,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ).stdout


def tree() -> list[str]:
    """The files of the tree that are, or would be, committed; names relative to the root."""
    try:
        if Path(git("rev-parse", "--show-toplevel").strip()) != ROOT:
            raise FileNotFoundError  # another repository
        names = git("ls-files", "-z", "--cached", "--others", "--exclude-standard").split("\0")
    except (OSError, subprocess.CalledProcessError):  # an unpacked archive
        below = (path.relative_to(ROOT) for path in ROOT.rglob("*"))
        names = [
            str(path)
            for path in below
            if path.parts[0] not in ("build", ".git") and "__pycache__" not in path.parts
        ]
    return sorted(name for name in names if (ROOT / name).is_file())


def moment() -> int:
    """The time in the archives, in seconds since 1970: that of the newest commit, so that the same
    commit gives the same bytes.
    """
    said = os.environ.get("SOURCE_DATE_EPOCH")
    if said:
        if not (said.isascii() and said.isdigit() and int(said) >= FIRST_DAY):
            raise Refused(
                f"SOURCE_DATE_EPOCH: at least {FIRST_DAY} seconds expected, found {said!r}"
            )
        return int(said)
    try:
        return max(int(git("log", "-1", "--format=%ct")), FIRST_DAY)
    except (OSError, subprocess.CalledProcessError):
        return FIRST_DAY


def fill(text: str, values: Mapping[str, str]) -> str:
    for name, value in values.items():
        text = text.replace(f"@{name}@", value)
    left = re.search(r"@[A-Z0-9_]+@", text)
    if left:
        raise Refused(f"unknown name {left[0]} in a manifest")
    return text


def copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, target)


def file_list() -> str:
    """The lines of a .pdsc that list every source."""
    names = sorted(
        f"{target}/{path.relative_to(ROOT / source).as_posix()}"
        for source, target in SOURCES.items()
        for path in (ROOT / source).rglob("*.c")
    )
    return "\n".join(f'        <file category="source" name="{name}"/>' for name in names)


def lay_out(name: str, folder: Path, values: Mapping[str, str]) -> None:
    """Writes the layout of package `name` into `folder`, which must not exist."""
    for source, target in LAYOUTS[name].items():
        for name_here in tree():
            if (
                name_here == source or name_here.startswith(source + "/")
            ) and not name_here.endswith(".md"):  # the pages stay in the tree
                copy(ROOT / name_here, folder / (target + name_here[len(source) :]))
    if LAYOUTS[name]:
        copy(ROOT / "packaging/common/README.md", folder / "README.md")
        copy(ROOT / "LICENSE", folder / "LICENSE")
    for path in sorted((ROOT / "packaging" / name).rglob("*")):
        if path.is_file():
            place = folder / path.relative_to(ROOT / "packaging" / name)
            if path.suffix == ".in":
                place.parent.mkdir(parents=True, exist_ok=True)
                place.with_suffix("").write_text(
                    fill(path.read_text(encoding="utf-8"), values), encoding="utf-8"
                )
            else:
                copy(path, place)
    if name == "arduino":  # Arduino's library finder searches only src, not its subfolders
        both = '#include "davar/davar.h"\n#include "davar/fit.h"\n'
        (folder / "src/davar.h").write_text(both, encoding="utf-8")


def members(folder: Path) -> list[tuple[str, Path]]:
    """(name, path) of every file below a folder, in one order on every machine."""
    return sorted(
        (path.relative_to(folder).as_posix(), path) for path in folder.rglob("*") if path.is_file()
    )


def write_tar(target: Path, files: Iterable[tuple[str, Path]], seconds: int) -> None:
    """A .tar.gz of [(name, path)] without an author or a time of creation."""
    raw = io.BytesIO()
    with tarfile.open(fileobj=raw, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, path in files:
            entry = tarfile.TarInfo(name)
            entry.size, entry.mtime, entry.mode = (
                path.stat().st_size,
                seconds,
                0o755 if os.access(path, os.X_OK) else 0o644,
            )
            with path.open("rb") as content:
                archive.addfile(entry, content)
    with target.open("wb") as file, gzip.GzipFile("", "wb", mtime=seconds, fileobj=file) as packed:
        packed.write(raw.getvalue())


def write_zip(target: Path, files: Iterable[tuple[str, Path]], seconds: int) -> None:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, path in files:
            entry = zipfile.ZipInfo(name, time.gmtime(seconds)[:6])
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, path.read_bytes())


def run(*command: object, folder: Path = ROOT, variables: Mapping[str, str] | None = None) -> None:
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, **(variables or {})},
    )
    if done.returncode:
        raise Refused(f"{' '.join(map(str, command))}:\n{done.stdout}")


def make_debian(out: Path, work: Path, seconds: int) -> None:
    """libdavar-dev and davar-tools."""
    when = {"SOURCE_DATE_EPOCH": str(seconds)}
    run(
        "cmake",
        "-S",
        ROOT,
        "-B",
        work,
        "-DCMAKE_INSTALL_PREFIX=/usr",
        "-DCMAKE_BUILD_TYPE=Release",
        "-DDAVAR_BUILD_TESTS=OFF",
        variables=when,
    )
    run("cmake", "--build", work, "--parallel", os.cpu_count() or 1)
    run("cpack", "-G", "DEB", folder=work, variables=when)
    for path in work.glob("*.deb"):
        shutil.copy(path, out)


def make(out: Path, number: str, debian: bool) -> list[Path]:
    """All packages, into the empty folder `out`; the layouts stay in out/layout."""
    seconds, layout = moment(), out / "layout"
    source = out / f"davar-{number}.tar.gz"
    write_tar(source, [(f"davar-{number}/{name}", ROOT / name) for name in tree()], seconds)
    values = {
        **project(),
        "VERSION": number,
        "DATE": time.strftime("%Y-%m-%d", time.gmtime(seconds)),
        "FILES": file_list(),
    }
    for name in LAYOUTS:
        if (ROOT / "packaging" / name).is_dir():
            lay_out(name, layout / name, values)
    if (layout / "vcpkg").is_dir():
        shutil.copy(source, layout / "vcpkg/davar")
    for name in sorted(path.name for path in layout.iterdir()):
        files = members(layout / name)
        if name == "cmsis-pack":  # Vendor.Name.Version.pack
            write_zip(out / f"davar.davar.{number}.pack", files, seconds)
        elif name in ("arduino", "vcpkg"):
            inside = {"arduino": "davar/", "vcpkg": ""}[name]
            write_zip(
                out / f"davar-{name}-{number}.zip",
                [(inside + member, path) for member, path in files],
                seconds,
            )
        else:
            write_tar(out / f"davar-{name}-{number}.tar.gz", files, seconds)
    amalgamate = ROOT / "tools/support/amalgamate.py"
    if amalgamate.is_file():
        run(sys.executable, amalgamate, layout / "amalgamation")
        write_zip(
            out / f"davar-amalgamation-{number}.zip", members(layout / "amalgamation"), seconds
        )
    else:
        print("skipped: the amalgamation (tools/support/amalgamate.py does not exist)")
    if debian:
        make_debian(out, out / "layout/debian-build", seconds)
        shutil.rmtree(out / "layout/debian-build")
    packages = sorted(path for path in out.iterdir() if path.is_file())
    bill = out / f"davar-{number}.spdx.json"
    found = materials.document(packages, number, project(), seconds)
    bill.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    sums = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in [*packages, bill]
    ]
    (out / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")
    return packages


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="tools/release",
        description="Makes every package of davar, with the version number of "
        "davar/version.h, their bill of materials (SPDX) and SHA256SUMS. Exit status 2: the tree "
        "is not ready for a release.",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help="new folder for the packages (default: build/release-VERSION, which is replaced)",
    )
    parser.add_argument(
        "--draft",
        action="store_true",
        help="accept a CHANGELOG.md that has only an Unreleased section",
    )
    parser.add_argument(
        "--no-deb", action="store_true", help="skip the Debian packages, which must be compiled"
    )
    options = parser.parse_args()
    number = version()
    out = options.out or ROOT / f"build/release-{number}"
    try:
        check_changes((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), number, options.draft)
        if options.out and out.exists():
            raise Refused(f"--out: {out} already exists; choose a new folder")
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        try:
            packages = make(out.resolve(), number, not options.no_deb)
        except BaseException:
            shutil.rmtree(out, ignore_errors=True)  # an incomplete release must not remain
            raise
    except (Refused, OSError) as why:
        print(f"tools/release: {why}", file=sys.stderr)
        return 2
    print("\n".join(f"{path.stat().st_size:>9} {path.name}" for path in packages))
    print(
        f"{len(packages)} packages of davar {number}, with bill of materials and SHA256SUMS: {out}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
