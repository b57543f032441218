"""MATLAB files: version 5 read by scipy, version 7.3 (an HDF5 file, as others are too) by h5py. Arrays in structs go by STRUCT.FIELD."""

import h5py
import numpy as np
from scipy import io

from . import named


def numeric(found):
    """name -> array of what is in a file or a struct of version 5."""
    for name, value in found.items():
        if name.startswith("__"):
            continue
        if isinstance(value, io.matlab.mat_struct):
            yield from ((f"{name}.{field}", one) for field, one in numeric({field: getattr(value, field) for field in value._fieldnames}))
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" or isinstance(value, (int, float)):
            yield name, np.asarray(value)


def version_5(path, options):
    found = dict(numeric(io.loadmat(path, squeeze_me=True, struct_as_record=False)))
    return named.Log(path, {name: array.shape for name, array in found.items()}, found.get, options.units, "MATLAB 5")


def hdf5(path, options):
    shapes = {}
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, one: shapes.update({name.replace("/", "."): one.shape})
                        if isinstance(one, h5py.Dataset) and one.dtype.kind in "iuf" and not name.startswith("#") else None)
    return named.Log(path, shapes, lambda name: loaded(path, name), options.units, "MATLAB 7.3 or HDF5")


def loaded(path, name):
    with h5py.File(path, "r") as file:
        return file[name if name in file else name.replace(".", "/")][()]
