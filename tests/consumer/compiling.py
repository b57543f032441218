"""Compiles C for the tests of this folder: a file at a time, with ccache if tools/test has it."""

import os
import subprocess
from pathlib import Path

LAUNCHER = os.environ.get("CMAKE_C_COMPILER_LAUNCHER", "").split()


def run(*command, folder=None):
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, f"{command}:\n{done.stdout}"
    return done.stdout


def objects(folder, flags, sources, compiler=("gcc",)):
    """The object of each source, in `folder`."""
    Path(folder).mkdir(exist_ok=True)
    made = []
    for source in map(Path, sources):
        made.append(Path(folder) / f"{'-'.join(source.parts[-3:])}.o")
        run(
            *LAUNCHER, *compiler, *flags, "-c", source.name, "-o", made[-1], folder=source.parent
        )  # the folder's name does not affect the object
    return made
