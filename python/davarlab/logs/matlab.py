"""MATLAB files: version 5 read by scipy, version 7.3 (an HDF5 file, as others are too) by h5py.
Arrays in structs go by STRUCT.FIELD."""

import faulthandler
import os
import resource
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import h5py
import numpy as np
from scipy import io

from ..errors import BadInput
from ..files import StrPath
from . import named
from .options import Options
from .sensor import Numbers


def check_survived(path: StrPath, load: Callable[[StrPath], object]) -> None:
    """Raises BadInput where reading a file kills the process that does it: one of its own, because
    scipy takes a damaged type for an address."""
    child = os.fork()
    if not child:
        status = 1
        try:
            faulthandler.disable()
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            load(path)
            status = 0
        finally:
            os._exit(status)  # what is raised meets the caller again
    if os.WIFSIGNALED(os.waitpid(child, 0)[1]):
        raise BadInput(f"{path}: damaged, or not MATLAB 5 (scipy crashes on it)")


def numeric(found: Mapping[str, Any]) -> Iterator[tuple[str, Numbers]]:
    """name -> array of what is in a file or a struct of version 5."""
    for name, value in found.items():
        if name.startswith("__"):
            continue
        if isinstance(value, io.matlab.mat_struct):
            yield from (
                (f"{name}.{field}", one)
                for field, one in numeric(
                    {field: getattr(value, field) for field in value._fieldnames}
                )
            )
        elif (
            isinstance(value, np.ndarray)
            and value.dtype.kind in "iuf"
            or isinstance(value, (int, float))
        ):
            yield name, np.asarray(value)


def loaded_5(path: StrPath) -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about objects, which are not read
        found: dict[str, Any] = io.loadmat(path, squeeze_me=True, struct_as_record=False)
    return found


def version_5(path: StrPath, options: Options) -> named.Log:
    check_survived(path, loaded_5)
    found = dict(numeric(loaded_5(path)))
    if not found:
        raise BadInput(
            f"{path}: no arrays of numbers. Objects such as a timetable are not read. In MATLAB, "
            "type writetimetable(NAME, 'log.csv'), and use log.csv"
        )
    return named.Log(
        path,
        {name: array.shape for name, array in found.items()},
        found.get,
        options.units,
        "MATLAB 5",
    )


def hdf5(path: StrPath, options: Options) -> named.Log:
    shapes = {}
    with h5py.File(path, "r") as file:
        file.visititems(
            lambda name, one: (
                shapes.update({name.replace("/", "."): one.shape})
                if isinstance(one, h5py.Dataset)
                and one.dtype.kind in "iuf"
                and not name.startswith("#")
                else None
            )
        )
    return named.Log(
        path, shapes, lambda name: loaded(path, name), options.units, "MATLAB 7.3 or HDF5"
    )


def loaded(path: StrPath, name: str) -> Numbers:
    with h5py.File(path, "r") as file:
        found: Numbers = file[name if name in file else name.replace(".", "/")][()]
        return found
