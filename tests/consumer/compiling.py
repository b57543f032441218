"""Compiles C for the tests of this folder, with ccache if there is one."""

import shutil
import subprocess
from pathlib import Path

import c_library
from c_library import ROOT, SOURCES  # noqa: F401 for the tests of this folder

INCLUDE = c_library.FLAGS
OPTIONS = ROOT / "tests/consumer/options.c"
PROGRAM_INCLUDE = [*c_library.PROGRAM_FLAGS, "-I", ROOT / "tests/support"]  # of OPTIONS
WARN = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


def attempt(*command, folder=None):
    """(exit status, output) of a command."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    return done.returncode, done.stdout


def run(*command, folder=None):
    """The output of a command that must succeed."""
    status, output = attempt(*command, folder=folder)
    assert status == 0, f"{command}:\n{output}"
    return output


def objects(folder, flags, sources, compiler=("gcc",)):
    """The object of each source, in `folder`."""
    Path(folder).mkdir(exist_ok=True)
    launcher = ["ccache"] if shutil.which("ccache") else []
    made = []
    for source in map(Path, sources):
        made.append(Path(folder) / f"{'-'.join(source.parts[-3:])}.o")
        run(
            *launcher, *compiler, *flags, "-c", source.name, "-o", made[-1], folder=source.parent
        )  # the folder's name does not affect the object
    return made


def program(folder, flags, sources):
    """Compiles and links the sources for this machine."""
    made = objects(folder, flags, sources)
    run("gcc", *made, "-o", Path(folder) / "program", "-lm")
    return Path(folder) / "program"
