"""The one table that everything which lists effects reads; people's own effects join it
(own.py)."""

from ..errors import BadInput
from . import changes, columns, filters, means, spectra
from .base import Effect

TABLE = {
    effect.kind: effect
    for effect in (
        spectra.QUANTIZATION,
        spectra.ANGLE_RANDOM_WALK,
        spectra.BIAS_INSTABILITY,
        spectra.RATE_RANDOM_WALK,
        means.RATE_RAMP,
        spectra.GAUSS_MARKOV,
        means.SINUSOID,
        spectra.NARROW_BAND,
        filters.LOW_PASS,
        filters.MOVING_AVERAGE,
        filters.HIGH_PASS,
        columns.TEMPERATURE,
        columns.TEMPERATURE_RATE,
        means.G_SENSITIVITY,
        changes.VIBRATION_NOISE,
        means.VIBRATION_RECTIFICATION,
        means.WARM_UP,
        changes.TELEGRAPH_NOISE,
        changes.NOISE_STEP,
        changes.SHOCKS,
        columns.TEMPERATURE_SQUARED,
        columns.TEMPERATURE_HYSTERESIS,
        columns.TEMPERATURE_NOISE,
        columns.FOLLOWS,
        columns.NOISE_FOLLOWS,
        columns.LINE_FOLLOWS,
        means.INTERMITTENT_LINE,
        means.DRIFTING_LINE,
        means.BIAS_STEP,
    )
}

BUILT_IN = tuple(TABLE)


def find(kind: object, where: str = "") -> Effect:
    if not isinstance(kind, str) or kind not in TABLE:
        raise BadInput(
            f"{where + ': ' if where else ''}unknown kind {kind!r} (known: {', '.join(TABLE)})"
        )
    return TABLE[kind]
