"""Reasons not to report a significant candidate: motion, software that subtracts the bias, a
coefficient that is not physical, a column that is noise, a common cause (DESIGN 4)."""

from collections.abc import Sequence

from ..arrays import Bools
from ..data.observations import Observation
from ..effects.base import INFINITE
from ..inference import estimate, images
from ..inference.parts import Bench, Part, without
from ..model import unit_said
from ..tables.constants import TO_DPS
from ..thresholds import CHANCE, DOUBT
from . import common_cause, own_noise
from .candidate import Candidate

SUDDEN = ("shocks", "noise_step", "bias_step", "telegraph_noise")
LINES = ("sinusoid", "narrow_band", "intermittent_line")


def doubt(
    bench: Bench, seen: Sequence[Observation], parts: Sequence[Part], candidate: Candidate
) -> str:
    """The reason not to report the candidate in addition to the parts; "" without one. seen: the
    observations on the recording."""
    part, rest = candidate.part, without(parts, candidate.replaces)
    why = of_turns(bench, seen, rest, candidate) or of_motion(seen, part)
    why = (
        why
        or of_software(parts, part)
        or of_size(bench, rest, part)
        or own_noise.doubt(bench, rest, part)
    )
    if why or not common_cause.on_column(part):
        return why
    judged = common_cause.judge(bench, rest, part)
    return of_rotation(seen, part, judged.coefficient) or judged.why


def was_moved(seen: Sequence[Observation]) -> bool:
    """Whether the record has so much true motion that the rest of it looks like an effect."""
    return share_of_motion(seen) > DOUBT.moved_share


def share_of_motion(seen: Sequence[Observation]) -> float:
    return sum(one.share for one in seen if one.kind == "motion")


def of_motion(seen: Sequence[Observation], part: Part) -> str:
    """Residual motion is sudden, strong, and in every sensor of the board."""
    if not was_moved(seen) or not (
        part.kind in SUDDEN or part.kind != "g_sensitivity" and common_cause.in_acceleration(part)
    ):
        return ""
    return (
        f"the sensor was moved in {100 * share_of_motion(seen):.2g} % of the recording, and "
        "residual motion looks like this effect. Record the sensor at rest"
    )


def of_turns(
    bench: Bench, seen: Sequence[Observation], parts: Sequence[Part], candidate: Candidate
) -> str:
    """An effect that gains little once the bias may have another level after each turn."""
    runs = [run for one in seen if one.kind == "motion" for run in one.stretches]
    part = candidate.part
    if part.role not in ("mean", "spectrum") or "accel" in part.effect.needs:
        return ""  # what gravity does, turning the sensor shows
    if not 0 < len(runs) <= DOUBT.turns_most:
        return ""
    steps = [Part("bias_step", {"time_s": (start + stop) / 2}) for start, stop in runs]
    before, turned, both = (
        bench.fit([*parts, *more]).log_likelihood for more in ([], steps, [*steps, part])
    )
    for step in steps:
        bench.forget(step)
    if turned - before < candidate.gain + CHANCE.tell_apart * (len(steps) - 2):
        return ""
    if both - turned > DOUBT.turns_leave * candidate.gain:
        return ""
    return (
        f"another level of the bias after each of the {len(runs)} intervals with motion explains "
        "the recording as well. A sensor that is turned over measures another part of the Earth's "
        "rotation, up to 30 deg/h apart, and of gravity. Log an accelerometer and the orientation, "
        "or do not move the sensor"
    )


def of_rotation(seen: Sequence[Observation], part: Part, coefficient: float) -> str:
    """Rotation about an axis between two gyro axes also makes them proportional. coefficient: deg/s
    per unit of the column."""
    column = part.shape.get("column", "")
    if not column.startswith("gyro_"):
        return ""
    leak = coefficient / next(
        (factor for unit, factor in TO_DPS.items() if column.endswith("_" + unit)), 1.0
    )
    if abs(leak) < (DOUBT.leak_moved if was_moved(seen) else DOUBT.leak_at_rest):
        return ""
    return (
        f"a coupling of {leak:.2g} to {column} is more than cross-axis sensitivity explains. The "
        "sensor rotates about an axis between the two, or both have a common cause that was not "
        "logged"
    )


def of_software(parts: Sequence[Part], part: Part) -> str:
    """A thermal effect, a warm-up or a ramp next to software that subtracts the bias."""
    if part.kind not in ("warm_up", "rate_ramp") and (
        part.role != "mean" or "temp_degC" not in part.effect.needs
    ):
        return ""
    if not any(one.kind == "high_pass" for one in parts):
        return ""
    return (
        "software that subtracts the bias removes slow effects, and its settling looks like this "
        "effect. Record the output of the sensor before this software"
    )


def size_of(bench: Bench, parts: Sequence[Part], part: Part) -> float:
    """The first parameter of an effect on a column, fitted in addition to the parts."""
    name, together = part.effect.size.name, [*parts, part]
    if part.role == "variance":
        entry = estimate.dynamic_estimates(bench, together, bench.fit(parts), None)
        return float(part.shape[name] if name in part.shape else entry[part.kind][name].value)
    keys = bench.keys(part)
    found = float(bench.coefficients_of(keys, together, bench.fit(together))[0])
    scale = bench.data.scale(keys[0]) * part.effect.size.scale
    return found / scale if scale else 0.0


def of_size(bench: Bench, parts: Sequence[Part], part: Part) -> str:
    """A coefficient that no gyro has."""
    limit = part.effect.limit(part.shape)
    size = size_of(bench, parts, part) if limit < INFINITE else 0.0
    if abs(size) <= limit:
        return ""
    unit = unit_said(part.effect.size.unit, bench.gyro or "").replace(
        "unit of the column", part.shape.get("column", "").rpartition("_")[2]
    )
    names = own_noise.names_of(bench.recording, part)
    return (
        f"a coefficient of {size:.3g} {unit} is not physical. Ten times the worst data sheet of a "
        f"MEMS gyro is {limit:.3g} {unit}. Check the unit of {' and '.join(names)}, and whether "
        "it is only its sensor's noise"
    )


def of_image(bench: Bench, known: Bools | None, parts: Sequence[Part], part: Part) -> str:
    """A line that regular gaps show as well at another frequency."""
    if known is None or part.kind not in LINES:
        return ""
    shifted = images.shifts(known)
    if not len(shifted):
        return ""
    rate, f_hz = bench.recording.rate_hz, part.shape["frequency_hz"]
    rest = bench.y - bench.mean_course(parts, bench.fit(parts))
    rival = images.likelier(
        images.without_slow(rest, known, shifted),
        f_hz / rate,
        part.shape.get("half_width_hz", 0.0) / rate,
        shifted,
    )
    if rival is None:
        return ""
    return (
        f"the samples come in blocks, {shifted[0] * rate:.4g} per second, so a line at "
        f"{f_hz:.4g} Hz may be the image of one at {rival * rate:.4g} Hz. Read every sample"
    )
