"""The model as a C table for the firmware: per tau the model's Allan deviation and how far a window may be from it."""

import numpy as np

from . import allan, parts as parts_of
from .errors import BadInput


def noise_variance(model, taus, rate_hz):
    """Allan variance of the stationary part of a model and of its ramp and lines; what a static device sees."""
    given = [parts_of.part_of(term) for term in model.terms]
    filters = [part for part in given if part.effect.role == "filter"]
    total = np.zeros(len(taus))
    for part, term in zip(given, model.terms):
        size, tau = part.effect.dps(term.parameters) if part.effect.role != "filter" else 0.0, np.array(taus) / rate_hz
        if part.effect.role in ("spectrum", "states"):
            def spectrum(f, part=part):
                value = part.effect.spectrum(f, rate_hz, part.shape)
                for cut in filters if part.kind == "angle_random_walk" else []:
                    value = value * cut.effect.spectrum(f, rate_hz, cut.shape)
                return value
            total += size ** 2 * allan.expected(spectrum, taus, rate_hz)
        elif term.kind == "rate_ramp":
            total += size ** 2 * tau ** 2 / 2
        elif term.kind == "sinusoid":
            x = np.pi * term.parameters["frequency_hz"] * tau
            total += size ** 2 * np.sin(x) ** 4 / x ** 2
    return total


def c_table(model, window):
    """Text of a C header. Tolerance: the factor within which 95 % of the windows stay, from the degrees of freedom."""
    if not model.rate_hz:
        raise BadInput("the model has no rate_hz")
    taus = allan.octaves(window)
    if not taus:
        raise BadInput(f"--window: {window} samples are too short")
    variance = noise_variance(model, taus, model.rate_hz)
    if not np.all(variance > 0):
        raise BadInput("the model has no noise that the device could be compared with")
    slopes = np.gradient(np.log(variance), np.log(taus)) if len(taus) > 1 else [-1.0]
    lines = ["/* Written by davarlab export: what the error model expects of the Allan deviation, deg/s.", " *"]
    lines += [f" *   {term.kind}: " + ", ".join(f"{k} = {v if isinstance(v, str) else format(v, '.6g')}"
                                                for k, v in term.parameters.items()) for term in model.terms]
    lines += [" *", f" * Rate {model.rate_hz:g} Hz, window {window} samples. relative_tolerance: one standard deviation of the",
              " * measured deviation over the model, from the degrees of freedom. */",
              "#ifndef DAVAR_MODEL_TABLE_H", "#define DAVAR_MODEL_TABLE_H", "", "#include <stdint.h>", "",
              f"#define DAVAR_MODEL_TAU_COUNT {len(taus)}", "",
              "static const struct {", "    uint32_t m;                /* cluster size, samples */",
              "    double adev_dps;           /* the model's Allan deviation */",
              "    double relative_tolerance; /* one standard deviation */",
              "} davar_model_table[DAVAR_MODEL_TAU_COUNT] = {"]
    for m, value, slope in zip(taus, variance, slopes):
        scatter = np.sqrt(0.5 / allan.freedom(slope, m, window))
        lines.append(f"    {{ {m}U, {np.sqrt(value):.9e}, {scatter:.6f} }},")
    return "\n".join(lines + ["};", "", "#endif"]) + "\n"
