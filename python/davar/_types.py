"""Names of types, for the annotations."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Array = npt.NDArray[Any]
Taus = str | Sequence[int] | npt.NDArray[Any]
Pair = tuple[float, float]
