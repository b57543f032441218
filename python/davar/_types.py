"""Type names for annotations."""

import os
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Array = npt.NDArray[Any]
Path = str | os.PathLike[str]
Pair = tuple[float, float]
