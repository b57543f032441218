"""Names of the array types that the annotations of the lab share, and when they are narrow."""

from typing import Any

import numpy as np
import numpy.typing as npt

# Double precision, but for the columns of long recordings: those are single. The stubs of numpy
# give the result of arithmetic no width, so none is written here.
Floats = npt.NDArray[np.floating[Any]]
Complexes = npt.NDArray[np.complexfloating[Any, Any]]
Ints = npt.NDArray[np.integer[Any]]
Bools = npt.NDArray[np.bool_]
# Samples from which columns and ordinates are kept in single precision, but for the time; a gyro is
# transformed in double precision all the same.
NARROW_FROM = 2_000_000
