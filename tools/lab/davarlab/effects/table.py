"""The one table that everything which lists effects reads; people's own effects join it (own.py)."""

from ..errors import BadInput
from . import changes, means, spectra

TABLE = {effect.kind: effect for effect in (
    spectra.QUANTIZATION, spectra.ANGLE_RANDOM_WALK, spectra.BIAS_INSTABILITY, spectra.RATE_RANDOM_WALK,
    means.RATE_RAMP, spectra.GAUSS_MARKOV, means.SINUSOID, spectra.LOW_PASS, means.TEMPERATURE, means.TEMPERATURE_RATE,
    means.G_SENSITIVITY, changes.VIBRATION_NOISE, means.VIBRATION_RECTIFICATION, means.WARM_UP, changes.TELEGRAPH_NOISE,
    changes.NOISE_STEP, changes.SHOCKS, means.INTERMITTENT_LINE, means.BIAS_STEP)}


def find(kind, where=""):
    if not isinstance(kind, str) or kind not in TABLE:
        raise BadInput(f"{where + ': ' if where else ''}unknown kind {kind!r} (known: {', '.join(TABLE)})")
    return TABLE[kind]
