"""NumPy files and Parquet tables."""

from typing import Any

import numpy as np
import pyarrow
from pyarrow import parquet

from .. import files
from ..errors import BadInput
from ..files import StrPath
from . import named
from .options import Options
from .sensor import Numbers

ORDERS = {
    3: ["gyro_x", "gyro_y", "gyro_z"],
    4: ["time", "gyro_x", "gyro_y", "gyro_z"],
}  # of the columns of an array without names


def npy(path: StrPath, options: Options) -> named.Log:
    """A structured array by its fields; an array without names of 3 or 4 columns as (time,) gyro x,
    y, z; others must be named."""
    array = np.load(path, mmap_mode="r", allow_pickle=False)
    if array.dtype.names:
        found = {name: array[name] for name in array.dtype.names}
    else:
        if array.ndim != 2:
            raise BadInput(
                f"{path}: an array of {array.ndim} dimensions. One row per sample is expected"
            )
        array = array if array.shape[0] >= array.shape[1] else array.T
        names = options.names or ORDERS.get(array.shape[1])
        if names is None or len(names) != array.shape[1]:
            raise BadInput(
                f"{path}: {array.shape[1]} columns without names. Use --names "
                "(time,gyro_x,gyro_y,gyro_z,temp ..)"
            )
        found = {name: array[:, place] for place, name in enumerate(names)}
    return named.Log(
        path,
        {name: one.shape for name, one in found.items()},
        found.get,
        options.units,
        "NumPy",
        True,
    )


def npz(path: StrPath, options: Options) -> named.Log:
    with files.reading(path) as file, np.load(file, allow_pickle=False) as archive:
        found = {
            name: archive[name] for name in archive.files if member_kind(archive, name) in "iufM"
        }
    return named.Log(
        path, {name: one.shape for name, one in found.items()}, found.get, options.units, "NumPy"
    )


def member_kind(archive: Any, name: str) -> str:
    """The kind of an array in the archive; of one that only pickle could read, O."""
    try:
        found: str = archive[name].dtype.kind
        return found
    except ValueError:
        return "O"


def table(path: StrPath, options: Options) -> named.Log:
    file = parquet.ParquetFile(path)
    fields = [field for field in file.schema_arrow if numeric(field.type)]
    count = file.metadata.num_rows
    if not count:
        raise BadInput(f"{path}: no samples")
    return named.Log(
        path,
        {field.name: (count,) for field in fields},
        lambda name: column(file, path, name),
        options.units,
        "Parquet",
        True,
    )


def numeric(kind: Any) -> bool:
    types = pyarrow.types
    found: bool = (
        types.is_integer(kind)
        or types.is_floating(kind)
        or types.is_timestamp(kind)
        or types.is_decimal(kind)
    )
    return found


def column(file: Any, path: StrPath, name: str) -> Numbers:
    """One column, in pieces: stamps as whole nanoseconds."""
    out: Numbers | None = None
    place = 0
    for batch in file.iter_batches(columns=[name]):
        piece = batch.column(0)
        if piece.null_count:
            raise BadInput(
                f"{path}: column {name}: empty at row "
                f"{place + int(np.flatnonzero(piece.is_null().to_numpy(False))[0]) + 1}"
            )
        if pyarrow.types.is_timestamp(piece.type):
            piece = piece.cast(pyarrow.timestamp("ns")).cast(pyarrow.int64())
        elif pyarrow.types.is_decimal(piece.type):
            piece = piece.cast(pyarrow.float64())
        values = piece.to_numpy(zero_copy_only=False)
        out = np.empty(file.metadata.num_rows, values.dtype) if out is None else out
        out[place : place + len(values)] = values
        place += len(values)
    assert out is not None  # a table without rows was refused
    return out
