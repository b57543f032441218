"""Every effect that a model lacks, tried: the gain in likelihood and what chance would give (DESIGN 4)."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from . import changes, modulation, refine, signals, states
from .effects import table
from .parts import Part

# What chance does with a free shape: the null tail is taken as TRIALS times that of one chi-square (DESIGN 4). Estimates, not
# yet measured by bootstrap; those of the correlated noises were raised when one recording needed it.
TRIALS = {"quantization": 0.5, "angle_random_walk": 0.5, "bias_instability": 1.0, "rate_random_walk": 1.0,
          "gauss_markov": 20.0, "telegraph_noise": 20.0, "low_pass": 2.0, "warm_up": 4.0, "rate_ramp": 1.0,
          "temperature": 1.0, "temperature_rate": 2.0, "g_sensitivity": 6.0, "vibration_rectification": 6.0,
          "vibration_noise": 1.5, "noise_step": 2e4, "sinusoid": 1.5}


@dataclass
class Candidate:
    """`gain` in log-likelihood, `log_p` of that gain by chance, the part as it would join."""
    kind: str
    part: Part
    gain: float
    log_p: float
    state: object = None


def shapes_of(effect, recording):
    """The product of an effect's grids."""
    found = [{}]
    for name in effect.shape_names:
        values = effect.grid.get(name, lambda _: [])(recording)
        found = [{**shape, name: value if isinstance(value, str) else float(value)} for shape in found for value in values]
    return found


def available(effect, recording):
    return all(any(name.startswith(need) for name in recording.columns) for need in effect.needs)


def log_tail(gain, trials):
    x = max(2 * gain, 0.0)
    tail = stats.chi2.logsf(x, 1) if x < 500 else -x / 2 - 0.5 * np.log(np.pi * x / 2)
    return min(0.0, float(np.log(trials) + tail))


def robust_gain(bench, parts, part):
    """The gain with the scatter of the products themselves: vibration must not pass for correlation with vibration."""
    full = bench.fit(parts + [part])
    white = np.sqrt(np.interp(np.log(bench.data.f), np.log(bench.data.f_bin), full.level))
    x = signals.inverse(np.concatenate([[0.0], bench.data.columns[bench.keys(part)[0]][0] / white]))
    spread = np.sum((x * bench.residual(parts + [part], full)) ** 2)
    return float((full.coefficients[-1] * np.sum(x ** 2)) ** 2 / max(spread, 1e-300) / 2)


def stationary(bench, parts, fit, effect, scatter=None):
    """Spectra, filters and regressors: the best of their shapes. `scatter`: of the energies where the white level changes."""
    best = None
    forms = ("raw", "smooth") if "accel" in effect.needs and effect.role == "mean" else ("raw",)
    for shape in shapes_of(effect, bench.recording):
        for form in forms:
            part = Part(effect.kind, shape, form)
            full = bench.fit(parts + [part])
            gain = full.log_likelihood - fit.log_likelihood
            if scatter is not None and part.role != "mean":
                gain = modulation.discounted(gain, fit.level, full.level, bench.data.counts, scatter)
            if effect.kind == "g_sensitivity" and form == "raw":
                gain = min(gain, robust_gain(bench, parts, part))
            if part.role == "mean" and (best is None or gain <= best.gain) and len(part.shape) and effect.kind == "warm_up":
                bench.forget(part)
            if best is None or gain > best.gain:
                best = Candidate(effect.kind, part, gain, 0.0)
    if best:
        best.log_p = log_tail(best.gain, TRIALS.get(effect.kind, 3.0))
    return best


def line(bench, parts, fit):
    """The strongest line of the whitened residual, twice oversampled."""
    w = bench.residual(parts, fit)
    power = np.abs(np.fft.rfft(w, 2 * len(w))) ** 2 / len(w)
    power[:6] = 0
    power[-4:] = 0
    peak = int(np.argmax(power))
    f = peak * bench.recording.rate_hz / (2 * len(w))
    part = Part("sinusoid", {"frequency_hz": float(f)})
    part = refine.refined(bench, parts + [part], only=("sinusoid",))[-1]
    gain = bench.fit(parts + [part]).log_likelihood - fit.log_likelihood
    return Candidate("sinusoid", part, gain, min(0.0, float(np.log(TRIALS["sinusoid"] * len(w)) - max(gain, 0))))


def variance_shapes(parts, recording, blocks):
    """Rows of the variance of the blocks that the parts say: the constant first."""
    rows = [np.ones(len(blocks.energy))]
    for part in parts:
        if part.kind == "vibration_noise":
            rows.append(changes.vibration_square(recording, part.shape["axis"], blocks))
        if part.kind == "noise_step":
            time = (np.arange(len(blocks.energy)) + 0.5) * blocks.period_s
            rows.append(((time >= part.shape["start_s"]) & (time < part.shape["stop_s"])).astype(float))
    return np.array(rows)


def vibration(bench, parts, blocks):
    rows = variance_shapes(parts, bench.recording, blocks)
    before, best = changes.fit(blocks, rows)[2], None
    for shape in shapes_of(table.find("vibration_noise"), bench.recording):
        square = changes.vibration_square(bench.recording, shape["axis"], blocks)
        if square.max() <= 0:
            continue
        gain = changes.fit(blocks, np.vstack([rows, square]))[2] - before
        if best is None or gain > best.gain:
            best = Candidate("vibration_noise", Part("vibration_noise", shape), gain, log_tail(gain, TRIALS["vibration_noise"]))
    return best


def noise_step(bench, parts, blocks):
    rows = variance_shapes(parts, bench.recording, blocks)
    _, variance, before = changes.fit(blocks, rows)
    low, high, _, _ = changes.best_interval(blocks, variance)
    part = Part("noise_step", {"start_s": low * blocks.period_s, "stop_s": high * blocks.period_s})
    gain = changes.fit(blocks, variance_shapes(parts + [part], bench.recording, blocks))[2] - before
    return Candidate("noise_step", part, gain, log_tail(gain, TRIALS["noise_step"]))


def with_states(bench, parts, fit, found):
    """Tells telegraph noise from Gauss-Markov: moves the gain of two levels over a continuum to the one that has it."""
    telegraph = next((c for c in found if c.kind == "telegraph_noise"), None)
    if telegraph is not None and telegraph.log_p < np.log(1e-4):
        decode_states(bench, parts, telegraph)


def decode_states(bench, parts, telegraph):
    """Two levels against a continuum on the residual of the other parts; decoded when the levels can be seen."""
    trial = refine.refined(bench, parts + [telegraph.part], only=("telegraph_noise",))
    joint = bench.fit(trial)
    telegraph.part = trial[-1]
    index = [p.kind for p in trial if p.role == "spectrum"].index("telegraph_noise")
    std = float(np.sqrt(max(joint.sizes[index], 1e-30)))
    rest = bench.y - bench.y.mean() - mean_course(bench, trial, joint)
    white = np.sqrt(joint.level[-1] / bench.recording.rate_hz)
    rate = bench.recording.rate_hz
    more, level, dwell = states.compare(rest, rate, std, telegraph.part.shape["mean_dwell_s"], white)
    part = Part("telegraph_noise", {"mean_dwell_s": float(dwell)}, "decoded")
    bench.decoded[part.key] = states.decoded(rest, rate, level, dwell, white)
    if more > 8 and not states.like_chance(bench.decoded[part.key]):
        more = -more  # a single step or a clock: two levels, but not telegraph noise
    telegraph.gain += more
    telegraph.log_p = min(0.0, telegraph.log_p - more)
    if more > 8:
        telegraph.part = part


def mean_course(bench, parts, fit):
    """The sum of the mean parts, deg/s."""
    total, keys = np.zeros(len(bench.y)), bench.all_keys(parts)
    courses = [course for part in parts if part.role == "mean" for course in bench.courses(part)]
    for key, value, course in zip(keys, fit.coefficients, courses):
        scale = bench.data.scale(key)
        if scale:
            total += value / scale * (course - course.mean())
    return total


def scatter_of(bench, parts, fit, blocks):
    """Of the energies per bin, when the model lets the white level change; None: chi-square."""
    rows = variance_shapes(parts, bench.recording, blocks)
    if len(rows) == 1:
        return None
    return modulation.dispersion(bench, modulation.white_share(bench, parts, fit), blocks, changes.fit(blocks, rows)[1])


def ranked(bench, parts, fit, skip=()):
    """All candidates, least likely by chance first."""
    blocks = changes.blocks_of(bench.residual(parts, fit), bench.recording.rate_hz)
    have, found = {part.kind for part in parts} | set(skip), []
    scatter = scatter_of(bench, parts, fit, blocks)
    for effect in table.TABLE.values():
        if effect.kind in have or effect.kind == "shocks" or not available(effect, bench.recording):
            continue
        if effect.kind == "sinusoid":
            found.append(line(bench, parts, fit))
        elif effect.kind == "vibration_noise":
            found.append(vibration(bench, parts, blocks))
        elif effect.kind == "noise_step":
            found.append(noise_step(bench, parts, blocks))
        else:
            found.append(stationary(bench, parts, fit, effect, scatter))
    found = [candidate for candidate in found if candidate]
    with_states(bench, parts, fit, found)
    return sorted(found, key=lambda candidate: candidate.log_p - 1e-9 * candidate.gain)
