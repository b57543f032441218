#!/usr/bin/env python3
"""The inputs of the fuzz targets: one archive corpus/TARGET.tar.gz each, unpacked into
build/fuzz/corpus/TARGET for use.

An input whose name is its SHA-1 was found by libFuzzer, which may drop it if another input covers
the same code. Any other name was chosen by a person and stays: a first example, or the input that
showed a fault. Standard library only.
"""

import argparse
import gzip
import io
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build/fuzz"


def unpack(target):
    """Replaces build/fuzz/corpus/TARGET by the inputs of the archive and returns the folder."""
    archive, folder = HERE / f"corpus/{target}.tar.gz", BUILD / f"corpus/{target}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if archive.exists():
        with tarfile.open(archive) as inputs:
            for entry in inputs:
                (folder / Path(entry.name).name).write_bytes(inputs.extractfile(entry).read())
    return folder


def pack(target, folder):
    """Writes the archive. The same inputs give the same bytes: order, times, owners and modes are
    fixed.
    """
    inputs = io.BytesIO()
    with tarfile.open(fileobj=inputs, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path in sorted(folder.iterdir()):
            entry = tarfile.TarInfo(path.name)
            entry.size = path.stat().st_size
            archive.addfile(entry, io.BytesIO(path.read_bytes()))
    archive = HERE / f"corpus/{target}.tar.gz"
    archive.parent.mkdir(exist_ok=True)
    archive.write_bytes(gzip.compress(inputs.getvalue(), 9, mtime=0))


def add(target, files):
    """Packs these files too, under their own names."""
    folder = unpack(target)
    for file in files:
        shutil.copy(file, folder)
    pack(target, folder)


def merge(target, folders):
    """Packs the fewest inputs of the corpus and these folders that reach what all of them reach
    (libFuzzer -merge=1).
    """
    folder = unpack(target)
    with tempfile.TemporaryDirectory() as kept:
        for path in folder.iterdir():
            if not re.fullmatch("[0-9a-f]{40}", path.name):
                shutil.copy(path, kept)
        subprocess.run(
            [BUILD / f"tests/fuzz/fuzz_{target}", "-merge=1", kept, folder, *folders], check=True
        )
        pack(target, Path(kept))


def main():
    parser = argparse.ArgumentParser(
        description="Unpacks, extends and minimises the inputs of a fuzz target."
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    for verb, what in (
        ("unpack", "unpack into build/fuzz/corpus/TARGET and print that folder"),
        ("add", "add files under their own names; they stay for good"),
        (
            "merge",
            "add what libFuzzer found and drop inputs that reach nothing new (build "
            "preset fuzz first)",
        ),
    ):
        one = verbs.add_parser(verb, help=what)
        one.add_argument("target")
        if verb != "unpack":
            one.add_argument(
                "paths",
                nargs="+" if verb == "add" else "*",
                type=Path,
                metavar="FILE" if verb == "add" else "FOLDER",
            )
    options = parser.parse_args()
    if not (HERE / f"fuzz_{options.target}.c").exists():
        parser.error(
            f"no such target: {options.target} (there is no tests/fuzz/fuzz_{options.target}.c)"
        )
    if options.verb == "unpack":
        print(unpack(options.target))
    else:
        {"add": add, "merge": merge}[options.verb](options.target, options.paths)
    return 0


if __name__ == "__main__":
    sys.exit(main())
