"""The recordings of other people's sensors that benchmark_real.py asks davarlab about: what an
expert sees, and which words of davarlab that makes right or plainly wrong. Their README is the
source. Whole recordings, but of Xsens its first 48 s: the rests after that last 2 to 10 s.
"""

from dataclasses import dataclass

SLOW = {"rate_random_walk", "gauss_markov", "rate_ramp", "bias_step"}  # its cause was not logged
LINES = {"narrow_band", "sinusoid", "intermittent_line"}
MEMORY = {"low_pass", "moving_average"}
WARMTH = {"temperature", "temperature_squared", "temperature_hysteresis", "warm_up"}
MOVED, LOST, JITTER = {"motion"}, {"lost_samples"}, {"jitter"}
KNOCKED = {"motion", "outliers", "shocks"}
# Nobody shook, warmed, tilted or wired these sensors: a cause that is named so was made up.
MADE_UP = {
    *("g_sensitivity", "vibration_noise", "vibration_rectification", "telegraph_noise"),
    *("follows", "temperature_rate", *WARMTH, "temperature_noise"),
}


@dataclass
class Real:
    file: str
    sees: dict  # axis -> what an expert sees ("" for every axis)
    must: dict  # axis -> groups: of each, one must be named or observed ("" for every axis)
    accepts: set
    wrong: frozenset = frozenset({*MADE_UP, "noise_step"})
    first_s: float | None = None  # the stretch: from the start for so long
    events: tuple = ()  # (start_s, stop_s) that the plain reading leaves out, from the README
    apart_s: float | None = None  # a longer step between samples is a gap for the plain reading
    turns: bool = False  # the plain reading leaves out what moves
    even: bool = False  # an even clock below the stamps: the mean step is the true one

    def for_axis(self, what, axis):
        return what.get(axis, what.get("", ()))


RECORDINGS = {
    "ADIS16405 run 1": Real(
        "adis16405_run1_static.csv.gz",
        {
            "": "filtered (slope -0.31 at m = 1..2), slow bias, small knocks",
            "z": "line at 20 to 21 Hz, 1 Hz wide, drifting",
        },
        {"": (MEMORY,), "z": ({"narrow_band"},)},
        SLOW | LINES | MEMORY | {"shocks"},
    ),
    "ADIS16405 run 4": Real(
        "adis16405_run4_knocks.csv.gz",
        {
            "": "knocks, a tilt of 0.4 degree from 3555 to 3990 s, filtered",
            "z": "the same, and the line at 20 Hz",
        },
        {"": (MEMORY, KNOCKED), "z": ({"narrow_band"}, KNOCKED)},
        SLOW | LINES | MEMORY | {"shocks"},
        events=((107, 128), (3335, 3337), (3555, 3993), (4039, 4060), (5145, 5168), (9636, 9639)),
    ),
    "MPU-6050 ramp": Real(
        "mpu6050_temp_ramp_gaps.csv.gz",
        {
            "": "gaps, warming by 18 degC, counts of about one sigma",
            "y": "0.028 deg/s per degC; gaps; counts of about one sigma",
        },
        {"": (LOST,), "y": ({"temperature"}, LOST)},
        SLOW | WARMTH | {"temperature_noise"},
        MADE_UP - WARMTH - {"temperature_noise"},
        apart_s=0.5,
    ),
    "MPU-6050 11 min": Real(
        "mpu6050_static_11min_jitter.csv.gz",
        {
            "": "line near 20 Hz, stamps jitter",
            "x": "lines near 20 Hz, slow drift, stamps jitter",
            "z": "line at 31.4 Hz, stamps jitter",
        },
        {"": ({"narrow_band", "sinusoid"}, JITTER)},
        SLOW | LINES | {"warm_up"},
        MADE_UP - {"warm_up"} | {"noise_step"},
        even=True,
    ),
    "LSM9DS1 bench": Real(
        "sensehat_lsm9ds1_bench_3days.csv.gz",
        {
            "": "library subtracts a bias; jolt, turn, gap",
            "y": "the same; noise falls from 0.084 to 0.030 deg/s as it warms",
        },
        {
            "": ({"high_pass"}, {"motion", "outliers"}, LOST),
            "y": ({"temperature_noise"}, {"motion", "outliers"}, LOST),
        },
        {"high_pass", "rate_random_walk", "temperature_noise"},
        MADE_UP - {"temperature_noise"},
        events=((32600, 32700), (38300, 38500)),
        apart_s=100.0,
    ),
    "LSM9DS1 orbit": Real(
        "sensehat_lsm9ds1_iss_3h.csv.gz",
        {
            "": "flicker, a slow cycle of the orbit, uneven steps",
            "x": "cycle of about 92 min, 0.036 deg/s, beside flicker; uneven steps",
        },
        {"": (JITTER,), "x": (LINES | {"gauss_markov"}, JITTER)},
        SLOW | LINES,
        even=True,
    ),
    "MIMU 20 poses": Real(
        "mimu4444_20poses_exp1_imu1.csv.gz",
        {"": "20 rests with turns between, up to clipping; white below 6 to 16 lines"},
        {"": (MOVED, {"narrow_band"})},
        SLOW | LINES,
        MADE_UP | {"noise_step", "shocks", "low_pass"},
        turns=True,
    ),
    "Xsens 48 s": Real(
        "xsens_mti_hand_poses.csv.gz",
        {"": "white of about 2 deg/sqrt(h), band-limited (slope -0.40 at m = 1..2)"},
        {"": (MEMORY,)},
        SLOW | LINES | MEMORY,
        first_s=48.0,
    ),
    "LSM6DS33 turntable": Real(
        "rimu_lsm_40deg_steps.csv.gz",
        {"": "nine turns; low-passed well below half the rate"},
        {"": (MOVED, MEMORY)},
        SLOW | LINES | MEMORY,
        MADE_UP | {"noise_step", "shocks"},
        turns=True,
    ),
    "BNO055 turntable": Real(
        "rimu_bno055_40deg_steps.csv.gz",
        {
            "": "nine turns; bias subtracted, counts of 0.8 sigma; hump at 0.76 Hz",
            "z": "nine turns; bias subtracted, counts of 0.8 sigma",
        },
        {"": (MOVED, {"narrow_band"}), "z": (MOVED,)},
        SLOW | LINES | {"high_pass"},
        MADE_UP | {"noise_step", "shocks"},
        turns=True,
    ),
}


def judgement(real, axis, named, observed):
    """(agrees: yes, partly or no; the kinds that are plainly wrong; why not)."""
    wrong = sorted(set(named) & real.wrong)
    must = real.for_axis(real.must, axis)
    lacking = [" or ".join(sorted(group)) for group in must if not group & {*named, *observed}]
    strange = sorted(set(named) - real.accepts - real.wrong)
    why = [f"{kind}: wrong" for kind in wrong] + [f"no {group}" for group in lacking]
    why += [f"{kind}: not seen by an expert" for kind in strange]
    return "no" if wrong else "partly" if why else "yes", wrong, why
