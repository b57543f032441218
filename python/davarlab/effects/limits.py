"""Coefficients that no MEMS gyro has: ten times the worst case of data sheets.

A candidate with a larger coefficient is not reported (candidates/doubts.py). The sources are here
and nowhere else:

MPU-6000 product specification (PS-MPU-6000A-00, revision 3.4, section 6.1):
    zero-rate output up to 20 deg/s off, over temperature 20 deg/s from 25 to 85 degC;
    supply ripple of 0.1 V: 0.2 deg/s up to 250 Hz, 4 deg/s above.
ADXRS150 data sheet: linear acceleration effect 0.2 deg/s/g.

Data sheets of consumer gyros state no more than that. The other limits follow from these:

PER_G_OF_NOISE   resonances of package and board amplify vibration up to ten times
PER_G2           1 g rms of vibration shifts the bias by the tolerance of the zero-rate output,
                 which is generous without the factor of ten
PER_DEGC2        the parabola reaches 20 deg/s at 85 degC, 60 degC away from its vertex
PER_DEGC_PER_S   a package is up to 10 s late
NOISE_PER_DEGC   the white noise changes tenfold from 25 to 85 degC; an LSM9DS1 at rest showed 0.145
                 per degC of its thermometer, which is not at the die
"""

from math import log

TIMES = 10
PER_G = TIMES * 0.2  # deg/s/g
PER_G_OF_NOISE = 10 * PER_G  # deg/s per g rms
PER_G2 = 20.0  # deg/s/g^2
PER_DEGC = TIMES * 20 / 60  # deg/s/degC
PER_DEGC2 = TIMES * 20 / 60**2  # deg/s/degC^2
PER_DEGC_PER_S = 10 * PER_DEGC  # deg/s/(degC/s)
NOISE_PER_DEGC = TIMES * log(10) / 60  # 1/degC
PER_V = TIMES * 4 / 0.1  # deg/s/V

# Of a column that `follows` uses, by the unit at the end of its name. Other gyro axes have their
# own limit (thresholds.DOUBT).
FOLLOWED = {"V": PER_V, "mV": PER_V / 1000, "degC": PER_DEGC, "g": PER_G}
