"""Models as the parameters of other programs: one entry of FORMATS for each. Values in rad and m, the noise densities two-sided (DESIGN 1)."""

import math
import textwrap
from collections.abc import Callable
from dataclasses import dataclass

from ..effects import table
from ..errors import BadInput

FLAT = math.sqrt(
    2 * math.log(2) / math.pi
)  # 0.664: the Allan deviation of flicker noise over its coefficient (IEEE Std 952)
PX4_S, ARDUPILOT_S = 0.010, 0.012  # step of the prediction: EKF2_PREDICT_US, EKF_TARGET_DT
KALIBR_WIKI = "kalibr wiki (github.com/ethz-asl/kalibr/wiki), IMU Noise Model"


@dataclass
class Noise:
    """One axis of a sensor. white: rad/s/sqrt(Hz) or m/s^2/sqrt(Hz); flicker: B in rad/s or m/s^2; walk: rad/s^2/sqrt(Hz) or m/s^3/sqrt(Hz),
    found from `walk_from`."""

    quantity: str
    axis: str
    white: float
    flicker: float
    walk: float
    walk_from: str
    rate_hz: float


@dataclass
class Parameter:
    """A number of another program. value(noise): what it is for one axis; several: a number for each axis, else the largest; formula, meaning:
    for the comment."""

    name: str
    quantity: str
    unit: str
    formula: str
    value: Callable
    several: bool = False
    meaning: str = ""


@dataclass
class Format:
    """what: for --help. comment: how a comment begins. line(name, values): an assignment. around(lines, noises): the lines
    of the file, made of those. inflate: the reason for or against larger numbers than measured. source: where the formulas are from."""

    what: str
    comment: str
    parameters: tuple
    line: Callable
    source: str
    inflate: str
    around: Callable = lambda lines, noises: lines


def sized(model, kind):
    """Root of the sum of the squares of all effects of a kind, in deg and seconds."""
    return math.hypot(
        *(table.find(kind).dps(term.parameters) for term in model.terms if term.kind == kind)
    )


def noise_of(model, where, bias_time_s):
    """The Noise in a model. Where it has no walk of the bias, one that does what its slow noise does within bias_time_s."""
    words = model.column.split("_")
    if words[0] not in ("gyro", "accel") or len(words) < 2 or words[1] not in ("x", "y", "z"):
        raise BadInput(
            f"{where}: column {model.column}: no axis of a gyro or an accelerometer (gyro_x_dps .. accel_z_g)"
        )
    if not model.rate_hz:
        raise BadInput(f"{where}: the model has no rate_hz")
    scale = math.pi / 180 if words[0] == "gyro" else 1.0
    white, flicker, walk = (
        scale * sized(model, kind)
        for kind in ("angle_random_walk", "bias_instability", "rate_random_walk")
    )
    if not white:
        raise BadInput(f"{where}: no angle_random_walk in the model, which every filter needs")
    said = "rate_random_walk"
    slow = [term.parameters for term in model.terms if term.kind == "gauss_markov"]
    if not walk and slow:
        walk = scale * math.sqrt(
            sum(2 * one["std_dps"] ** 2 / one["correlation_time_s"] for one in slow)
        )
        said = "gauss_markov: sigma sqrt(2 / correlation time), the walk that it is within its correlation time"
    elif not walk and flicker:
        walk = FLAT * flicker * math.sqrt(3 / bias_time_s)
        said = f"bias_instability: 0.664 B sqrt(3 / T), the walk with its Allan deviation at T = {bias_time_s:g} s (--bias-time)"
    elif not walk:
        said = "nothing: the model has no slow noise, and a filter will hold the bias for constant"
    return Noise(words[0], words[1], white, flicker, walk, said, model.rate_hz)


def sensor(gyro, accel, unit_gyro, unit_accel, formula, value, several=False, meaning=""):
    """The same parameter of both sensors."""
    return (
        Parameter(gyro, "gyro", unit_gyro, formula, value, several, meaning),
        Parameter(accel, "accel", unit_accel, formula, value, several, meaning),
    )


def density(noise):
    return noise.white


def walk(noise):
    return noise.walk


def sample(noise):
    return noise.white * math.sqrt(noise.rate_hz)


def per_step(step_s):
    """A continuous density as a filter takes it that adds (dt x)^2 in each of its steps."""
    return (lambda noise: noise.white / math.sqrt(step_s)), (
        lambda noise: noise.walk / math.sqrt(step_s)
    )


def real(value):
    """Six digits, with a point where there is a power of ten: 1e-05 is text to YAML 1.1."""
    text = f"{value:.6g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def listed(values):
    return "[" + ", ".join(map(real, values)) + "]"


def yaml_line(name, values):
    return f"{name}: {real(values[0])}" if len(values) == 1 else f"{name}: {listed(values)}"


def diagonal(values):
    """A 3 x 3 matrix row by row, as ROS has it."""
    return [values[row] if row == column else 0.0 for row in range(3) for column in range(3)]


RAD, ACC = "rad/s/sqrt(Hz)", "m/s^2/sqrt(Hz)"
RAD_WALK, ACC_WALK = "rad/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)"
KALIBR = (
    *sensor(
        "gyroscope_noise_density",
        "accelerometer_noise_density",
        RAD,
        ACC,
        "N, the Allan deviation of the white part at 1 s",
        density,
    ),
    *sensor(
        "gyroscope_random_walk",
        "accelerometer_random_walk",
        RAD_WALK,
        ACC_WALK,
        "K, sqrt(3) times the Allan deviation of the walk at 1 s",
        walk,
    ),
)
RATE_LINES = lambda lines, noises: [
    *lines,
    f"update_rate: {real(noises[0].rate_hz)}",
    "rostopic: /imu  # yours",
]
PX4_WHITE, PX4_WALK = per_step(PX4_S)
ARDU_WHITE, ARDU_WALK = per_step(ARDUPILOT_S)
STEP = "the filter adds ({} dt)^2 to a variance in each step of dt = {:g} s, a density of x gives x^2 dt: so x / sqrt(dt)"


def matlab_around(lines, noises):
    """One object for each sensor."""
    out = []
    for quantity, maker in (("gyro", "gyroparams"), ("accel", "accelparams")):
        own = [line.partition(" ")[2] for line in lines if line.startswith(quantity + ".")]
        if own:
            out += [f"{quantity} = {maker}(" + ", ".join(own) + ");"]
    return (
        out
        + [f"imu = imuSensor('SampleRate', {noises[0].rate_hz:g});"]
        + [
            f"imu.{'Gyroscope' if one == 'gyro' else 'Accelerometer'} = {one};"
            for one in dict.fromkeys(noise.quantity for noise in noises)
        ]
    )


MATLAB_NOTE = (
    "N is of the two-sided spectrum (NoiseType double-sided): check that the scatter of what imuSensor makes is N sqrt(SampleRate); where a "
    "release takes a one-sided one, it is sqrt(2) too small"
)

FORMATS = {
    "kalibr": Format(
        "kalibr imu.yaml",
        "#",
        KALIBR,
        yaml_line,
        f"{KALIBR_WIKI} and YAML formats: continuous time",
        'Its wiki: numbers of a record at rest make kalibr trust the IMU too much; "for lowest-cost sensors, increasing the noise model parameters by '
        'a factor of 10x or more may be necessary". What is missing then is scale, alignment, temperature and vibration: a record of the mounted, '
        "running robot measures the last two, a factor guesses them.",
        RATE_LINES,
    ),
    "allan_variance_ros": Format(
        "the imu.yaml that allan_variance_ros writes",
        "#",
        KALIBR,
        yaml_line,
        "allan_variance_ros, scripts/analysis.py: the worst axis; fits of slope "
        "-1/2 at 1 s and of slope 1/2 at 3 s",
        "Not inflated there either. Its walk is the intercept of a line of slope 1/2 through the whole curve and stands too high where the curve is "
        "flat; this one is of the fitted model.",
        RATE_LINES,
    ),
    "px4": Format(
        "PX4 EKF2 (param set lines)",
        "#",
        (
            Parameter(
                "EKF2_GYR_NOISE",
                "gyro",
                "rad/s",
                "N / sqrt(dt)",
                PX4_WHITE,
                meaning=STEP.format("EKF2_GYR_NOISE", PX4_S),
            ),
            Parameter(
                "EKF2_GYR_B_NOISE",
                "gyro",
                "rad/s^2",
                "K / sqrt(dt)",
                PX4_WALK,
                meaning="process noise of the gyro bias, " + STEP.format("EKF2_GYR_B_NOISE", PX4_S),
            ),
            Parameter(
                "EKF2_ACC_NOISE",
                "accel",
                "m/s^2",
                "N / sqrt(dt)",
                PX4_WHITE,
                meaning=STEP.format("EKF2_ACC_NOISE", PX4_S),
            ),
            Parameter(
                "EKF2_ACC_B_NOISE",
                "accel",
                "m/s^3",
                "K / sqrt(dt)",
                PX4_WALK,
                meaning="process noise of the accelerometer bias",
            ),
        ),
        lambda name, values: f"param set {name} {values[0]:.6g}",
        "PX4-Autopilot, src/modules/ekf2/EKF/covariance.cpp, predictCovariance; dt: EKF2_PREDICT_US",
        "The defaults, 0.015 rad/s and 0.001 rad/s^2, are ten times and more above a quiet MEMS gyro on purpose: they also hold vibration, aliasing, "
        "scale and alignment errors of a flying vehicle, and EKF2 refuses less than 0.0001 rad/s. Take these numbers for a floor; go below the defaults "
        "only with innovations of a flight that allow it.",
    ),
    "ardupilot": Format(
        "ArduPilot EKF3 (.param)",
        "#",
        (
            Parameter(
                "EK3_GYRO_P_NSE",
                "gyro",
                "rad/s",
                "N / sqrt(dt)",
                ARDU_WHITE,
                meaning=STEP.format("EK3_GYRO_P_NSE", ARDUPILOT_S),
            ),
            Parameter(
                "EK3_GBIAS_P_NSE",
                "gyro",
                "rad/s^2",
                "K / sqrt(dt)",
                ARDU_WALK,
                meaning="the state is bias times dt and gets (x dt^2)^2 in each step of dt: so K / sqrt(dt)",
            ),
            Parameter(
                "EK3_ACC_P_NSE",
                "accel",
                "m/s^2",
                "N / sqrt(dt)",
                ARDU_WHITE,
                meaning=STEP.format("EK3_ACC_P_NSE", ARDUPILOT_S),
            ),
            Parameter(
                "EK3_ABIAS_P_NSE",
                "accel",
                "m/s^3",
                "K / sqrt(dt)",
                ARDU_WALK,
                meaning="as of the gyro",
            ),
        ),
        lambda name, values: f"{name},{values[0]:.6g}",
        "ArduPilot, libraries/AP_NavEKF3/AP_NavEKF3_core.cpp, CovariancePrediction; dt: EKF_TARGET_DT",
        "The defaults, 0.015 rad/s and 0.001 rad/s^2 on copters, hold vibration, aliasing and scale errors in flight too. Take these numbers for a floor.",
    ),
    "ros": Format(
        "covariances of ROS sensor_msgs/Imu",
        "#",
        sensor(
            "angular_velocity_covariance",
            "linear_acceleration_covariance",
            "rad^2/s^2",
            "m^2/s^4",
            "N^2 rate on the diagonal, row by row",
            lambda noise: sample(noise) * sample(noise),
            True,
            "the variance of one message: white noise alone, of a driver that sends every sample and has "
            "averaged none; correlations are not measured, so 0",
        ),
        lambda name, values: f"{name}: {listed(diagonal(values))}",
        "sensor_msgs/msg/Imu.msg",
        "Not inflated: a filter that reads the message takes it for the scatter of this sample, and has its own place for the bias. The first element "
        "-1 would say that there is none, all 0 that it is unknown.",
    ),
    "gtsam": Format(
        "GTSAM preintegration (Python)",
        "#",
        (
            *sensor(
                "setGyroscopeCovariance",
                "setAccelerometerCovariance",
                "rad^2/s^2/Hz",
                "m^2/s^4/Hz",
                "N^2, continuous",
                lambda noise: noise.white * noise.white,
                True,
                "per sample: N^2 rate, which preintegration makes of it itself by dividing by dt",
            ),
            *sensor(
                "setBiasOmegaCovariance",
                "setBiasAccCovariance",
                "rad^2/s^4/Hz",
                "m^2/s^6/Hz",
                "K^2, continuous",
                lambda noise: noise.walk * noise.walk,
                True,
                "of PreintegrationCombinedParams; for a BetweenFactor of the bias over t seconds: K sqrt(t)",
            ),
        ),
        lambda name, values: f"params.{name}(numpy.diag({listed(values)}))",
        "GTSAM, navigation/PreintegrationParams.h and CombinedImuFactor: continuous-time covariances",
        "Not inflated. Where the IMU is driven hard, its scale and alignment errors are what is missing, and they are no white noise: 3 to 10 times N "
        "is the usual stand-in.",
    ),
    "basalt": Format(
        "Basalt calibration (members of value0)",
        "//",
        (
            *sensor(
                "gyro_noise_std",
                "accel_noise_std",
                RAD,
                ACC,
                "N, continuous",
                density,
                True,
                "Basalt makes the discrete N sqrt(imu_update_rate) of it itself",
            ),
            *sensor(
                "gyro_bias_std", "accel_bias_std", RAD_WALK, ACC_WALK, "K, continuous", walk, True
            ),
        ),
        lambda name, values: f'"{name}": {listed(values)},',
        "basalt-headers, calibration.hpp: continuous time",
        "Not inflated: the estimator weighs the IMU against the camera by these alone. Raise N, not K, where vibration or scale errors of a moving IMU "
        "are to be held by it too.",
        lambda lines, noises: [*lines, f'"imu_update_rate": {noises[0].rate_hz:g}'],
    ),
    "vins": Format(
        "VINS-Mono and VINS-Fusion (config yaml)",
        "#",
        (
            *sensor(
                "gyr_n",
                "acc_n",
                "rad/s",
                "m/s^2",
                "N sqrt(rate), discrete",
                sample,
                meaning="the scatter of a sample; continuous: divide by sqrt(rate)",
            ),
            *sensor(
                "gyr_w",
                "acc_w",
                "rad/s^2",
                "m/s^3",
                "K sqrt(rate), discrete",
                lambda noise: noise.walk * math.sqrt(noise.rate_hz),
                meaning="the bias gets (x dt)^2 in each step of dt = 1 / rate. Many configurations hold K itself, which holds the bias sqrt(rate) "
                "times too still",
            ),
        ),
        yaml_line,
        "VINS-Mono, vins_estimator/src/factor/integration_base.h: midpoint steps with the noise of both ends",
        "Its examples reach from twice (EuRoC, gyr_n 0.004) to tens of times that (0.1): for vibration, and for time stamps that are late. Raise N "
        "first where the estimate jumps with motion, never K.",
    ),
    "matlab": Format(
        "MATLAB gyroparams and accelparams (.m)",
        "%",
        (
            *sensor(
                "gyro.NoiseDensity",
                "accel.NoiseDensity",
                "(rad/s)/sqrt(Hz)",
                "(m/s^2)/sqrt(Hz)",
                "N",
                density,
                True,
                MATLAB_NOTE,
            ),
            *sensor(
                "gyro.BiasInstability",
                "accel.BiasInstability",
                "rad/s",
                "m/s^2",
                "B, the coefficient: the flat of the Allan deviation is 0.664 B",
                lambda noise: noise.flicker,
                True,
            ),
            *sensor(
                "gyro.RandomWalk",
                "accel.RandomWalk",
                "(rad/s) sqrt(Hz)",
                "(m/s^2) sqrt(Hz)",
                "K",
                walk,
                True,
                "a walk of the rate, not ARW, whatever its name",
            ),
        ),
        lambda name, values: f"{name.split('.')[0]}. '{name.split('.')[1]}', {listed(values)}",
        "MathWorks, gyroparams and imuSensor",
        "Not inflated: a simulation is to be like the sensor.",
        matlab_around,
    ),
}


def values_of(parameter, noises, inflate):
    """One number for each axis x, y, z, or the largest alone."""
    own = {
        noise.axis: parameter.value(noise)
        for noise in noises
        if noise.quantity == parameter.quantity
    }
    factor = inflate * inflate if parameter.formula[1:].startswith("^2") else inflate
    largest = max(own.values())
    return (
        [factor * own.get(axis, largest) for axis in "xyz"]
        if parameter.several
        else [factor * largest]
    )


def said_of(parameter, noises):
    """The comment lines of a parameter: unit, formula, which axis."""
    own = [noise for noise in noises if noise.quantity == parameter.quantity]
    axes = "".join(noise.axis for noise in own)
    which = (
        f"for x, y, z ({axes} measured{'' if len(axes) == 3 else '; the others as the largest'})"
        if parameter.several
        else f"the largest of {', '.join(axes)}"
    )
    return [
        f"{parameter.name} [{parameter.unit}] = {parameter.formula}; {which}"
        + (f". {parameter.meaning}" if parameter.meaning else "")
    ]


def text(name, models, inflate=1.0, bias_time_s=300.0):
    """A file of the format FORMATS[name]. models: (path, Model), one for each axis. Raises BadInput."""
    form, noises = FORMATS[name], [noise_of(model, path, bias_time_s) for path, model in models]
    keys = [(noise.quantity, noise.axis) for noise in noises]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice:
        raise BadInput(f"{models[0][0]}: two models of {twice[0]} {twice[1]}: one for each axis")
    if len({noise.rate_hz for noise in noises}) > 1 and max(
        noise.rate_hz for noise in noises
    ) > 1.05 * min(noise.rate_hz for noise in noises):
        raise BadInput(
            f"{models[0][0]}: models of different rates: "
            + ", ".join(f"{path} {model.rate_hz:g} Hz" for path, model in models)
        )
    there = [
        parameter
        for parameter in form.parameters
        if parameter.quantity in {noise.quantity for noise in noises}
    ]
    head = [
        f"{form.what}, by davarlab export of "
        + ", ".join(f"{noise.quantity} {noise.axis}" for noise in noises)
        + f" at {noises[0].rate_hz:g} Hz",
        f"Source of the formulas: {form.source}.",
        "N: density of the white noise, root of the two-sided spectrum; B: bias instability; K: random walk of the bias. In rad, m, s:",
    ]
    head += [
        f"  {one.quantity} {one.axis}: N = {one.white:.6g}, B = {one.flicker:.6g}, K = {one.walk:.6g}, K from {one.walk_from}"
        for one in noises
    ]
    head += [
        form.inflate,
        f"These numbers are {'as measured' if inflate == 1 else f'{inflate:g} times those measured (--inflate)'}.",
    ]
    comments = [
        wrapped
        for line in head + [line for parameter in there for line in said_of(parameter, noises)]
        for wrapped in textwrap.wrap(
            line,
            116,
            subsequent_indent="    ",
            initial_indent=" " * (len(line) - len(line.lstrip())),
        )
    ]
    numbers = {parameter.name: values_of(parameter, noises, inflate) for parameter in there}
    if not all(
        math.isfinite(value)
        for values in [*numbers.values(), [one.walk for one in noises]]
        for value in values
    ):
        raise BadInput(
            f"{models[0][0]}: with these sizes, --inflate and --bias-time, numbers beyond what a program can hold"
        )
    lines = [form.line(name, values) for name, values in numbers.items()]
    return (
        "\n".join(
            [*(f"{form.comment} {line}" for line in comments), "", *form.around(lines, noises)]
        )
        + "\n"
    )
