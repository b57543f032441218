"""The one table that everything which lists effects reads; people's own effects join it."""

import importlib.util
from pathlib import Path

from ..errors import BadInput
from . import changes, means, spectra
from .base import Effect

TABLE = {effect.kind: effect for effect in (
    spectra.QUANTIZATION, spectra.ANGLE_RANDOM_WALK, spectra.BIAS_INSTABILITY, spectra.RATE_RANDOM_WALK,
    means.RATE_RAMP, spectra.GAUSS_MARKOV, means.SINUSOID, spectra.LOW_PASS, means.TEMPERATURE, means.TEMPERATURE_RATE,
    means.G_SENSITIVITY, changes.VIBRATION_NOISE, means.VIBRATION_RECTIFICATION, means.WARM_UP, changes.TELEGRAPH_NOISE,
    changes.NOISE_STEP, changes.SHOCKS)}


def find(kind, where=""):
    if kind not in TABLE:
        raise BadInput(f"{where + ': ' if where else ''}unknown kind {kind!r} (known: {', '.join(TABLE)})")
    return TABLE[kind]


def load(path):
    """Adds every Effect of a Python file to the table."""
    if not Path(path).is_file():
        raise BadInput(f"{path}: no such file")
    specification = importlib.util.spec_from_file_location(Path(path).stem, path)
    module = importlib.util.module_from_spec(specification)
    try:
        specification.loader.exec_module(module)
    except Exception as why:  # the person's own code: whatever it raises is a mistake in that file
        raise BadInput(f"{path}: {type(why).__name__}: {why}") from None
    found = [value for value in vars(module).values() if isinstance(value, Effect)]
    if not found:
        raise BadInput(f"{path}: no Effect in it")
    for effect in found:
        if effect.kind in TABLE and TABLE[effect.kind] is not effect:
            raise BadInput(f"{path}: kind {effect.kind} is taken")
        if effect.role not in ("mean", "spectrum") or not (effect.regressor or effect.spectrum):
            raise BadInput(f"{path}: {effect.kind} needs a regressor (role mean) or a spectrum (role spectrum)")
        TABLE[effect.kind] = effect
