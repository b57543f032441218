"""Files that come in by the page: what was dropped on it, the simulated recordings of the first
page, and what a sensor sent. They are kept with the user's data, because the workbench is often
opened in a folder under version control."""

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from davar import places

from .. import files, simulate
from .. import model as models
from ..data import recording as recordings
from ..diagnosis.state import Progress
from ..errors import BadInput
from ..report import words
from ..report.values import Json
from .steps import ENDING

TUTORIAL = places.shared("data/tutorial_sensor.toml")
EXERCISES = {path.stem: path for path in sorted(places.shared("data/exercises").glob("*.toml"))}
SIMULATED = [f"{name}.csv" for name in (TUTORIAL.stem, *EXERCISES)]
LIVE_NAME, RAW_NAME = "live.csv", "raw.csv"  # of what was heard on a wire: results, samples
FROZEN_NAME = "frozen.csv"  # samples so far
FOLDER = "davarlab-files"
Tell = Callable[..., None]  # receives what is new, by name


def kept(here: Path) -> Path:
    """Where the files of a workbench that is opened in this folder are kept: each folder has its
    own place."""
    data = os.environ.get("XDG_DATA_HOME", "")
    try:
        base = Path(data) if os.path.isabs(data) else Path.home() / ".local/share"
    except RuntimeError:  # no home
        return here
    return base / "davarlab" / here.relative_to(here.anchor)


def exercises() -> list[Json]:
    """The simulated recordings beside the tutorial: name, where the sensor is (the comment in the
    first line), and the answer: what is in it beyond white noise and bias instability."""
    found = []
    for name, path in EXERCISES.items():
        model = models.from_toml(models.load_toml(path), path)
        hidden = [words.title(term.kind, term.parameters) for term in model.terms[2:]]
        story = files.read_whole(path).decode().partition("\n")[0].removeprefix("# ")
        found.append({"name": name, "story": story, "answer": words.listed(hidden, str)})
    return found


def free_name(path: Path, sha256: str) -> Path:
    """The path, or the first of path-2, path-3 ... that no other file has."""
    first, count = path, 1
    while path.exists() and files.sha256(path) != sha256:
        count += 1
        path = first.with_name(f"{first.stem}-{count}{first.suffix}")
    return path


class Drop:
    """What is being dropped: the file that it is written to, and the path where it is once it came
    whole."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.path: Path | None = None


class Arrivals:
    """folder: where they are kept."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder) / FOLDER

    def made(self) -> Path:
        """The folder, there."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as why:
            raise BadInput(f"{self.folder}: cannot be made ({files.reason(why)})") from None
        return self.folder

    def simulated(self, exercise: str | None, progress: Progress) -> Path:
        """The path of the recording of an exercise, or of the tutorial, made once."""
        if exercise is not None and exercise not in EXERCISES:
            raise BadInput(f"no exercise {exercise}")
        scenario = EXERCISES[exercise] if exercise else TUTORIAL
        path = self.made() / f"{scenario.stem}.csv"
        if not path.exists():
            progress("Simulating the recording")
            recordings.write(simulate.from_scenario(scenario, progress), path)
        return path

    @contextlib.contextmanager
    def receive(self, name: str) -> Iterator[Drop]:
        """A Drop; its file is there only when it came whole. It bears its own name, or a numbered
        one where another file has that."""
        if (
            not name
            or name != Path(name).name
            or name.startswith(".")
            or not name.isprintable()
            or name.endswith(ENDING)
            or name in (*SIMULATED, LIVE_NAME, RAW_NAME)
        ):
            raise BadInput(f"{name!r}: not a name for a recording")
        part = files.partial(self.made() / "drop")
        try:
            with open(part, "xb") as file:
                drop = Drop(file)
                yield drop
            drop.path = free_name(self.folder / name, files.sha256(part))
            if not drop.path.exists():
                part.replace(drop.path)
        except OSError as why:
            raise BadInput(f"{name}: cannot be written ({files.reason(why)})") from None
        finally:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
