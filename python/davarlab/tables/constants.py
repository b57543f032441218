"""Constants between units, once."""

import math

DEG_PER_RAD = 180 / math.pi
GRAVITY_MPS2 = 9.80665  # m/s^2 per g: the standard acceleration
UG_PER_MPS2 = 1e6 / GRAVITY_MPS2
# Units of the columns of a recording, by the end of their names.
TO_DPS = {"dps": 1.0, "rad_s": DEG_PER_RAD}
# Before the name of an accelerometer's column: in the analysis, its values are in m/s^2 (axes.py).
FORCE = "force_"
# Data sheets of MEMS gyros, deg/s per count.
LSB_DPS = (
    tuple(scale / 32768 for scale in (125, 250, 500, 1000, 2000, 4000))
    + (0.004375, 0.00875, 0.0175, 0.035, 0.07, 0.14)
    + tuple(1 / per for per in (262, 131, 65.5, 32.8, 16.4))
)
