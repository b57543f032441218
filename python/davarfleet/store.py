"""What is done: a file for each recording in OUT/units/, written whole; and the table,
OUT/fleet.parquet.
"""

import hashlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypedDict

from davarlab import files
from davarlab.errors import BadInput

TABLE_VERSION = 2  # of the columns of the table and of the files beside it
Row = dict[str, Any]  # of the table: plain values by the names of the columns
Found = dict[str, Any]  # what a population shows: plain values, for --json and the page
PER_PARAMETER = ("", ".low", ".high")


class Done(TypedDict):
    """What a worker made of a recording. cpu_s: of its process; again: is the failure one that may
    pass.
    """

    rows: list[Row]
    seconds: float
    cpu_s: float
    again: bool


class Kept(TypedDict):
    """The file of a recording."""

    marker: str | None
    address: str
    seconds: float
    rows: list[Row]


def digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


class Store:
    """The folder of a fleet. Raises BadInput where it cannot be written."""

    def __init__(self, folder: str) -> None:
        self.folder, self.units = Path(folder), Path(folder) / "units"
        try:
            self.units.mkdir(parents=True, exist_ok=True)
        except OSError as why:
            raise BadInput(f"{folder}: {files.reason(why)}") from None
        files.check_writable(self.units / "trial")

    def holds(self, address: str) -> bool:
        """Is an address this folder, or in it: no recording, though a glob names it."""
        return "://" not in address and files.real(self.folder) in (
            files.real(address),
            *files.real(address).parents,
        )

    def path(self, address: str) -> Path:
        return self.units / f"{digest(address)[:24]}.json"

    def kept(self, address: str) -> Kept | None:
        """What is there of a recording, None: nothing that can be read."""
        try:
            found: Kept = json.loads(files.read_whole(self.path(address)))
            sound = (
                {"marker", "seconds", "rows"} <= set(found)
                and found["rows"]
                and all(isinstance(row, dict) for row in found["rows"])
            )
            return found if sound else None
        except (BadInput, ValueError, TypeError, RecursionError):
            return None

    def keep(self, address: str, marker: str | None, done: Done) -> None:
        """marker: of file, model and versions; None: to be done again next time."""
        text = json.dumps(
            {
                "marker": None if done["again"] else marker,
                "address": address,
                "seconds": done["seconds"],
                "rows": done["rows"],
            }
        )
        files.write_whole(self.path(address), text.encode())


def done(kept: Kept | None, wanted: str | None, chance: bool) -> bool:
    """Need nothing be done: the marker is the same, and what chance gives was asked if it is
    needed.
    """
    return (
        kept is not None
        and wanted is not None
        and kept["marker"] == wanted
        and not (
            chance and any("failed" not in row and "chance" not in row for row in kept["rows"])
        )
    )


def columns_of(rows: Iterable[Row]) -> tuple[list[str], list[str]]:
    """Names of the coefficients and of the gains, in the order in which they come."""
    names = dict.fromkeys(name for row in rows for name in row.get("coefficients", {}))
    return list(names), sorted({kind for row in rows for kind in row.get("gains", {})})


def write_table(rows: Sequence[Row], path: Path) -> None:
    """The rows of population.py as Parquet. A row that failed has nothing but its address, batch
    and reason.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    names, kinds = columns_of(rows)
    text, number, whole = pa.string(), pa.float64(), pa.int64()
    plain = {
        "file": text,
        "batch": text,
        "axis": text,
        "failed": text,
        "verdict": text,
        "alternatives": text,
        "adequacy": text,
        "error": number,
        "error_floor": number,
        "p_value": number,
        "samples": whole,
        "rate_hz": number,
        "temperature_degC": number,
        "observations": text,
        "limits": text,
        "why": text,
        "outlier": text,
        "seconds": number,
        "davar": text,
        "table_version": whole,
    }
    arrays = {
        name: pa.array([joined(row.get(name)) for row in rows], kind)
        for name, kind in plain.items()
    }
    stamps = [None if row.get("start_s") is None else round(row["start_s"] * 1e6) for row in rows]
    arrays["start"] = pa.array(stamps, pa.timestamp("us", tz="UTC"))
    for name in names:
        for place, ending in enumerate(PER_PARAMETER):
            arrays[name + ending] = pa.array(
                [row.get("coefficients", {}).get(name, [None] * 3)[place] for row in rows], number
            )
    for kind in kinds:
        arrays[f"gain.{kind}"] = pa.array([row.get("gains", {}).get(kind) for row in rows], number)
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table(arrays), sink)
    files.write_whole(path, sink.getvalue().to_pybytes())


def joined(value: object) -> object:
    return ", ".join(value) if isinstance(value, list) else value
