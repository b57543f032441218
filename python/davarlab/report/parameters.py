"""Exports models as parameters of other programs, one entry of FORMATS each. Values in rad and m,
noise densities two-sided (DESIGN 1)."""

import math
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from ..effects import table
from ..errors import BadInput
from ..model import Model, rate_of
from ..tables.constants import DEG_PER_RAD

FLAT = math.sqrt(
    2 * math.log(2) / math.pi
)  # 0.664: the Allan deviation of flicker noise over its coefficient (IEEE Std 952)
PX4_S, ARDUPILOT_S = 0.010, 0.012  # step of the prediction: EKF2_PREDICT_US, EKF_TARGET_DT
KALIBR_WIKI = "kalibr wiki (github.com/ethz-asl/kalibr/wiki), IMU Noise Model"


@dataclass
class Noise:
    """One axis of a sensor. white: rad/s/sqrt(Hz) or m/s^2/sqrt(Hz). flicker: B in rad/s or m/s^2.
    walk: rad/s^2/sqrt(Hz) or m/s^3/sqrt(Hz), derived from `walk_from`."""

    quantity: str
    axis: str
    white: float
    flicker: float
    walk: float
    walk_from: str
    rate_hz: float


@dataclass
class Parameter:
    """A parameter of another program. value(noise): its value for one axis. several: one number per
    axis; otherwise the largest. formula, meaning: for the comment."""

    name: str
    quantity: str
    unit: str
    formula: str
    value: Callable[[Noise], float]
    several: bool = False
    meaning: str = ""


@dataclass
class Format:
    """what: for --help. comment: the start of a comment. line(name, values): an assignment.
    around(lines, noises): the lines of the file, made from these assignments. inflate: the reason
    for or against numbers larger than measured. source: the origin of the formulas. ending: of
    the name of the file."""

    what: str
    comment: str
    parameters: tuple[Parameter, ...]
    line: Callable[[str, Sequence[float]], str]
    source: str
    inflate: str
    around: Callable[[Sequence[str], Sequence[Noise]], Sequence[str]] = lambda lines, noises: lines
    ending: str = ".yaml"


def sized(model: Model, kind: str) -> float:
    """Root sum of squares of all effects of a kind, in deg and seconds."""
    return math.hypot(
        *(table.find(kind).dps(term.parameters) for term in model.terms if term.kind == kind)
    )


def noise_of(model: Model, where: str, bias_time_s: float) -> Noise:
    """The Noise of a model. If the model has no random walk of the bias, an equivalent one for its
    slow noise within bias_time_s."""
    words = model.column.split("_")
    if words[0] not in ("gyro", "accel") or len(words) < 2 or words[1] not in ("x", "y", "z"):
        raise BadInput(
            f"{where}: column {model.column} is not an axis of a gyro or accelerometer "
            "(gyro_x_dps .. accel_z_g)"
        )
    rate_hz = rate_of(model, where)
    scale = 1 / DEG_PER_RAD if words[0] == "gyro" else 1.0
    white, flicker, walk = (
        scale * sized(model, kind)
        for kind in ("angle_random_walk", "bias_instability", "rate_random_walk")
    )
    said = "rate_random_walk"
    slow = [term.parameters for term in model.terms if term.kind == "gauss_markov"]
    if not walk and slow:
        walk = scale * math.sqrt(
            sum(2 * one["std_dps"] ** 2 / one["correlation_time_s"] for one in slow)
        )
        said = (
            "gauss_markov: sigma sqrt(2 / correlation time), its equivalent random walk within "
            "the correlation time"
        )
    elif not walk and flicker:
        walk = FLAT * flicker * math.sqrt(3 / bias_time_s)
        said = (
            "bias_instability: 0.664 B sqrt(3 / T), the random walk with the same Allan "
            f"deviation at T = {bias_time_s:g} s (--bias-time)"
        )
    elif not walk:
        said = "nothing: the model has no slow noise, so a filter will treat the bias as constant"
    return Noise(words[0], words[1], white, flicker, walk, said, rate_hz)


def sensor(
    gyro: str,
    accel: str,
    unit_gyro: str,
    unit_accel: str,
    formula: str,
    value: Callable[[Noise], float],
    several: bool = False,
    meaning: str = "",
) -> tuple[Parameter, Parameter]:
    """The same parameter of both sensors."""
    return (
        Parameter(gyro, "gyro", unit_gyro, formula, value, several, meaning),
        Parameter(accel, "accel", unit_accel, formula, value, several, meaning),
    )


def density(noise: Noise) -> float:
    return noise.white


def walk(noise: Noise) -> float:
    return noise.walk


def sample(noise: Noise) -> float:
    return noise.white * math.sqrt(noise.rate_hz)


def per_step(step_s: float) -> tuple[Callable[[Noise], float], Callable[[Noise], float]]:
    """Converts a continuous density for a filter that adds (dt x)^2 in each step."""
    return (lambda noise: noise.white / math.sqrt(step_s)), (
        lambda noise: noise.walk / math.sqrt(step_s)
    )


def real(value: float) -> str:
    """Six digits, with a decimal point before an exponent, because YAML 1.1 reads 1e-05 as text."""
    text = f"{value:.6g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def listed(values: Iterable[float]) -> str:
    return "[" + ", ".join(map(real, values)) + "]"


def yaml_line(name: str, values: Sequence[float]) -> str:
    return f"{name}: {real(values[0])}" if len(values) == 1 else f"{name}: {listed(values)}"


def diagonal(values: Sequence[float]) -> list[float]:
    """A 3 x 3 diagonal matrix in row-major order, as in ROS."""
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
        "K, sqrt(3) times the Allan deviation of the random walk at 1 s",
        walk,
    ),
)


def rate_lines(lines: Sequence[str], noises: Sequence[Noise]) -> list[str]:
    """The assignments, then the rate and the topic of a kalibr file."""
    return [
        *lines,
        f"update_rate: {real(noises[0].rate_hz)}",
        "rostopic: /imu  # set your topic",
    ]


def chain_lines(lines: Sequence[str], noises: Sequence[Noise]) -> list[str]:
    """The members of imu0 in kalibr_imu_chain.yaml of OpenVINS."""
    return ["imu0:", *(f"  {line}" for line in rate_lines(lines, noises))]


PX4_WHITE, PX4_WALK = per_step(PX4_S)
ARDU_WHITE, ARDU_WALK = per_step(ARDUPILOT_S)
STEP = (
    "the filter adds ({} dt)^2 to a variance in each step of dt = {:g} s. A density x must add "
    "x^2 dt, so the value is x / sqrt(dt)"
)


def matlab_around(lines: Sequence[str], noises: Sequence[Noise]) -> list[str]:
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
    "N is the root of the two-sided spectrum (NoiseType double-sided). Check that the standard "
    "deviation of imuSensor's output is N sqrt(SampleRate). A release that expects a one-sided "
    "spectrum gives a value too small by sqrt(2)"
)

FORMATS = {
    "kalibr": Format(
        "kalibr imu.yaml",
        "#",
        KALIBR,
        yaml_line,
        f"{KALIBR_WIKI} and YAML formats: continuous time",
        "The kalibr wiki warns that values from a recording at rest give the IMU too much weight: "
        '"for lowest-cost sensors, increasing the '
        'noise model parameters by a factor of 10x or more may be necessary". Such values omit '
        "errors of scale and alignment, temperature "
        "and vibration. A recording on the running robot measures the last two, a factor only "
        "guesses them.",
        rate_lines,
    ),
    "allan_variance_ros": Format(
        "the imu.yaml that allan_variance_ros writes",
        "#",
        KALIBR,
        yaml_line,
        "allan_variance_ros, scripts/analysis.py: the worst axis; fits of slope "
        "-1/2 at 1 s and of slope 1/2 at 3 s",
        "allan_variance_ros does not inflate the values either. Its random walk is the intercept "
        "of a line of slope 1/2 through the whole curve, which is too high where the curve is "
        "flat. The value here comes from the fitted model.",
        rate_lines,
    ),
    "openvins": Format(
        "OpenVINS (members of imu0 in kalibr_imu_chain.yaml)",
        "#",
        KALIBR,
        yaml_line,
        "OpenVINS, Propagator.cpp: continuous time, divided by the root of the step",
        "OpenVINS recommends values 10 to 20 times those at rest. They stand for vibration, scale "
        "and time errors. A recording on the running robot measures the vibration, a factor only "
        "guesses it.",
        chain_lines,
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
        "PX4-Autopilot, src/modules/ekf2/EKF/covariance.cpp, predictCovariance; dt: "
        "EKF2_PREDICT_US",
        "The defaults, 0.015 rad/s and 0.001 rad/s^2, are at least ten times the noise of a quiet "
        "MEMS gyro on purpose. They also cover vibration, aliasing, scale and alignment errors of "
        "a flying vehicle. EKF2 accepts no value below 0.0001 rad/s. Use the numbers here as a "
        "lower bound. Go below the defaults only if the innovations of a flight allow it.",
        ending=".params",
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
                meaning="the state is bias times dt, and the filter adds (x dt^2)^2 in each step "
                "of dt, so the value is K / sqrt(dt)",
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
                meaning="same as for the gyro",
            ),
        ),
        lambda name, values: f"{name},{values[0]:.6g}",
        "ArduPilot, libraries/AP_NavEKF3/AP_NavEKF3_core.cpp, CovariancePrediction; dt: "
        "EKF_TARGET_DT",
        "The defaults, 0.015 rad/s and 0.001 rad/s^2 on copters, also cover vibration, aliasing "
        "and scale errors in flight. Use the numbers here as a lower bound.",
        ending=".param",
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
            "the variance of one message from white noise alone, for a driver that sends every "
            "sample without averaging. Correlations are not measured and set to 0",
        ),
        lambda name, values: f"{name}: {listed(diagonal(values))}",
        "sensor_msgs/msg/Imu.msg",
        "Not inflated: a filter that reads the message uses it as the variance of this sample, "
        "and has separate parameters for the bias. In this message, -1 as first element means no "
        "measurement, and all zeros mean an unknown covariance.",
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
                "per sample: N^2 rate. Preintegration computes it itself by dividing by dt",
            ),
            *sensor(
                "setBiasOmegaCovariance",
                "setBiasAccCovariance",
                "rad^2/s^4/Hz",
                "m^2/s^6/Hz",
                "K^2, continuous",
                lambda noise: noise.walk * noise.walk,
                True,
                "a member of PreintegrationCombinedParams. For a BetweenFactor of the bias over t "
                "seconds, use K sqrt(t)",
            ),
        ),
        lambda name, values: f"params.{name}(numpy.diag({listed(values)}))",
        "GTSAM, navigation/PreintegrationParams.h and CombinedImuFactor: continuous-time "
        "covariances",
        "Not inflated. Under strong motion, scale and alignment errors of the IMU dominate, and "
        "they are not white noise. Users often approximate them with 3 to 10 times N.",
        ending=".py",
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
                "Basalt computes the discrete value N sqrt(imu_update_rate) itself",
            ),
            *sensor(
                "gyro_bias_std", "accel_bias_std", RAD_WALK, ACC_WALK, "K, continuous", walk, True
            ),
        ),
        lambda name, values: f'"{name}": {listed(values)},',
        "basalt-headers, calibration.hpp: continuous time",
        "Not inflated: the estimator weights the IMU against the camera by these values alone. To "
        "cover vibration or scale errors of a moving IMU, increase N, not K.",
        lambda lines, noises: [*lines, f'"imu_update_rate": {noises[0].rate_hz:g}'],
        ending=".jsonc",
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
                meaning="the standard deviation of a sample. For the continuous value, divide by "
                "sqrt(rate)",
            ),
            *sensor(
                "gyr_w",
                "acc_w",
                "rad/s^2",
                "m/s^3",
                "K sqrt(rate), discrete",
                lambda noise: noise.walk * math.sqrt(noise.rate_hz),
                meaning="the filter adds (x dt)^2 to the variance of the bias in each step of "
                "dt = 1 / rate. Many configurations contain K itself, which is too small by "
                "sqrt(rate)",
            ),
        ),
        yaml_line,
        "VINS-Mono, vins_estimator/src/factor/integration_base.h: midpoint steps with the noise "
        "of both ends",
        "The VINS examples use from twice the measured value (EuRoC, gyr_n 0.004) to tens of "
        "times it (0.1), to cover vibration and delayed time stamps. If the estimate jumps with "
        "motion, increase N first, never K.",
    ),
    "betaflight": Format(
        "Betaflight (comments for a CLI file)",
        "#",
        (
            Parameter(
                "gyro noise density",
                "gyro",
                "deg/s/sqrt(Hz)",
                "N",
                lambda noise: math.degrees(noise.white),
                True,
                "Betaflight has no parameter for it: its attitude filter has fixed gains. Behind a "
                "low-pass of f Hz, the gyro scatters by about N sqrt(3.1 f) with one pole, and "
                "by N sqrt(2.2 f) with two",
            ),
        ),
        lambda name, values: f"# {name}, deg/s/sqrt(Hz): {listed(values)}",
        "Betaflight, src/main/flight/imu.c: no noise density",
        "Not inflated. In flight, the rotors dominate: give imu the blackbox log.",
        ending=".txt",
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
                "B, the coefficient. The flat part of the Allan deviation is at 0.664 B",
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
                "the random walk of the rate, not the angle random walk, in spite of its name",
            ),
        ),
        lambda name, values: f"{name.split('.')[0]}. '{name.split('.')[1]}', {listed(values)}",
        "MathWorks, gyroparams and imuSensor",
        "Not inflated: a simulation must behave like the sensor.",
        matlab_around,
        ending=".m",
    ),
}


def values_of(parameter: Parameter, noises: Sequence[Noise], inflate: float) -> list[float]:
    """One number per axis x, y, z, or only the largest."""
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


def said_of(parameter: Parameter, noises: Sequence[Noise]) -> list[str]:
    """The comment lines of a parameter: unit, formula, axis."""
    own = [noise for noise in noises if noise.quantity == parameter.quantity]
    axes = "".join(noise.axis for noise in own)
    which = (
        f"for x, y, z ({axes} "
        f"measured{'' if len(axes) == 3 else ', the others set to the largest'})"
        if parameter.several
        else f"the largest of {', '.join(axes)}"
    )
    return [
        f"{parameter.name} [{parameter.unit}] = {parameter.formula}; {which}"
        + (f". {parameter.meaning[0].upper()}{parameter.meaning[1:]}" if parameter.meaning else "")
    ]


def text(
    name: str,
    models: Sequence[tuple[str, Model]],
    inflate: float = 1.0,
    bias_time_s: float = 300.0,
    remarks: Sequence[str] = (),
) -> str:
    """A file in the format FORMATS[name]. models: (path, Model), one per axis; remarks: what its
    user must know first. Raises BadInput."""
    form, noises = FORMATS[name], [noise_of(model, path, bias_time_s) for path, model in models]
    for (path, _), noise in zip(models, noises):
        if not noise.white:
            raise BadInput(f"{path}: the model has no angle_random_walk, which every filter needs")
    keys = [(noise.quantity, noise.axis) for noise in noises]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice:
        raise BadInput(
            f"{models[0][0]}: two models of {twice[0]} {twice[1]}. Give one model per axis"
        )
    if len({noise.rate_hz for noise in noises}) > 1 and max(
        noise.rate_hz for noise in noises
    ) > 1.05 * min(noise.rate_hz for noise in noises):
        raise BadInput(
            f"{models[0][0]}: the models have different rates: "
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
        "N: density of the white noise (root of the two-sided spectrum). B: bias instability. K: "
        "random walk of the bias. In rad, m, s:",
    ]
    head += [
        f"  {one.quantity} {one.axis}: N = {one.white:.6g}, B = {one.flicker:.6g}, K = "
        f"{one.walk:.6g}, K from {one.walk_from}"
        for one in noises
    ]
    head[1:1] = remarks
    head += [
        form.inflate,
        "These numbers are "
        f"{'as measured' if inflate == 1 else f'{inflate:g} times the measured ones (--inflate)'}.",
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
            f"{models[0][0]}: the model, --inflate and --bias-time give numbers out of range"
        )
    lines = [form.line(name, values) for name, values in numbers.items()]
    return (
        "\n".join(
            [*(f"{form.comment} {line}" for line in comments), "", *form.around(lines, noises)]
        )
        + "\n"
    )
