"""Constants between units, once."""

import math

DEG_PER_RAD = 180 / math.pi
GRAVITY_MPS2 = 9.80665  # m/s^2 per g: the standard acceleration
UG_PER_MPS2 = 1e6 / GRAVITY_MPS2
