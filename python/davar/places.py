"""Files that the package shares with the rest of the repository: beside it where pip installed it,
else where they stand there."""

from pathlib import Path

HERE = Path(__file__).resolve().parent
INSTALLED = HERE / "shared"  # made by python/CMakeLists.txt


def tests() -> Path | None:
    """The folder of the lab's tests; None where pip installed the package, because they are not in
    it."""
    folder = HERE.parents[1] / "tests/lab"
    return folder if folder.is_dir() and not INSTALLED.is_dir() else None


def shared(path: str) -> Path:
    """The file that is `path` in the repository."""
    return INSTALLED / Path(path).name if INSTALLED.is_dir() else HERE.parents[1] / path
