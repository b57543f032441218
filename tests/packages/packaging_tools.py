"""Shared by the tests of the packages: commands that must succeed."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests/packages"
CONSUMER = ROOT / "tests/consumer/consumer.c"
PARTS = ROOT / "tests/consumer/parts.c"
PARTS_SAY = "parts ok ok ok ok 1 1 0 6 0 0 8.72665e-05\n"
SAYS = r"davar \d+\.\d+\.\d+ epoch 99 window 60\n"  # printed by the consumer


def run(*command, folder=None, status=0, **variables):
    """The output of a command that must end with this status; a failure shows all of it."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, **variables},
    )
    assert done.returncode == status, (
        f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stdout}"
    )
    return done.stdout


def build(source, binary, *settings):
    run("cmake", "-S", source, "-B", binary, *settings)
    run("cmake", "--build", binary)


def consume(work, folder, source=CONSUMER, packages=("davar",)):
    """Builds a program with the .pc files in this folder. Returns the flags and its output."""
    words = ["pkg-config", "--cflags", "--libs", *packages]
    flags = run(*words, PKG_CONFIG_PATH=str(folder)).split()
    run("gcc", source, "-o", work / source.stem, *flags)
    return flags, run(work / source.stem)


def files_below(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
