"""Why a candidate beyond chance is not what it seems: motion, a software that subtracts the bias, a common cause (DESIGN 4)."""

from . import common_cause

SUDDEN = ("shocks", "noise_step", "bias_step", "telegraph_noise")
MOVED = 0.01  # of the samples that true motion takes, from where on what is left of it in the others passes for an effect


LEAK, LEAK_AT_REST = 0.1, 0.3  # of another axis at most; data sheets say 0.01 to 0.05
LINES = ("sinusoid", "narrow_band", "intermittent_line")
SLOWEST_HZ = 0.1  # of what turns: harmonics of anything slower are no lines
HARMONICS = 3  # lines, from which on they are one


def doubt(bench, seen, parts, candidate):
    """Why the candidate is not to be named beside the parts; "" where nothing speaks against it. seen: the observations on the recording."""
    part = candidate.part
    rest = [one for one in parts if one is not candidate.replaces]
    why = of_motion(seen, part) or of_software(parts, part) or of_one_wave(bench, parts, part)
    if not why and part.shape.get("column", "").startswith("gyro_"):
        why = of_rotation(seen, common_cause.coefficient(bench, rest, part))
    if not why and common_cause.on_column(part):
        why = common_cause.judge(bench, rest, part).why
    return why


def moved(seen):
    """Is so much of the record true motion that what is left of it passes for an effect."""
    return share_of_motion(seen) > MOVED


def share_of_motion(seen):
    return sum(one.share for one in seen if one.kind == "motion")


def of_motion(seen, part):
    """What motion leaves behind is sudden, loud, and in every sensor of the board."""
    if not moved(seen) or not (part.kind in SUDDEN or part.kind != "g_sensitivity" and common_cause.in_acceleration(part)):
        return ""
    return f"the sensor was moved in {100 * share_of_motion(seen):.2g} % of the record, and what is left of motion looks the same: record it at rest"


def of_rotation(seen, coefficient):
    """Two axes of a sensor that is turned about neither of them are proportional too."""
    return "" if abs(coefficient) < (LEAK if moved(seen) else LEAK_AT_REST) else f"the coefficient is {coefficient:.2g}, more than an axis leaks into another: the sensor turns about an axis between "\
        "them, or both share a cause that was not logged"


def of_software(parts, part):
    """Slow courses beside a software that subtracts the bias."""
    if part.kind not in ("warm_up", "rate_ramp") and (part.role != "mean" or "temp_degC" not in part.effect.needs):
        return ""
    if not any(one.kind == "high_pass" for one in parts):
        return ""
    return "a software that subtracts the bias takes slow effects away, and how it settles looks the same: record what the sensor gives before it"


def harmonics(bench, parts):
    """The lines among the parts that are harmonics of the slowest of them, with it."""
    lines = sorted((part for part in parts if part.kind in LINES), key=lambda part: part.shape["frequency_hz"])
    base = lines[0].shape["frequency_hz"] if lines else 0.0
    width = bench.recording.rate_hz / len(bench.y)
    if not 2 * width < base < SLOWEST_HZ:
        return []
    order = [(part, part.shape["frequency_hz"], max(1, round(part.shape["frequency_hz"] / base))) for part in lines]
    return [part for part, f, times in order if abs(f - times * base) < (1 + times) * width / 4]


def of_one_wave(bench, parts, part):
    """A line that is one more harmonic of something slow."""
    if part.kind not in LINES:
        return ""
    found = harmonics(bench, [*parts, part])
    if part not in found or len(found) < HARMONICS:
        return ""
    period = 1 / min(one.shape["frequency_hz"] for one in found)
    return f"lines at harmonics of {1 / period:.4g} Hz are one course that repeats every {period:.4g} s and is no sine wave: look for what switches or moves so often"
