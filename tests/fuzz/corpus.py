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
    """Packs these files too, under their own names; they stay for good."""
    folder = unpack(target)
    for file in files:
        shutil.copy(file, folder)
    pack(target, folder)


def merge(target, folders):
    """Packs the fewest inputs of the corpus and these folders that reach what all of them reach
    (libFuzzer -merge=1; build preset fuzz first).
    """
    folder = unpack(target)
    with tempfile.TemporaryDirectory() as kept:
        for path in folder.iterdir():
            if not re.fullmatch("[0-9a-f]{40}", path.name):
                shutil.copy(path, kept)
        program = BUILD / f"tests/fuzz/fuzz_{target}"
        subprocess.run([program, "-merge=1", kept, folder, *folders], check=True)
        pack(target, Path(kept))


def main():
    verbs = {"unpack": lambda target, _: print(unpack(target)), "add": add, "merge": merge}
    parser = argparse.ArgumentParser(
        description="Unpacks, extends and minimises the inputs of a fuzz target. unpack prints "
        "the folder; add takes files, merge the folders in which libFuzzer found inputs."
    )
    parser.add_argument("verb", choices=verbs)
    parser.add_argument("target", choices=[path.stem[5:] for path in HERE.glob("fuzz_*.c")])
    parser.add_argument("paths", nargs="*", type=Path, metavar="FILE or FOLDER")
    options = parser.parse_args()
    verbs[options.verb](options.target, options.paths)


if __name__ == "__main__":
    main()
