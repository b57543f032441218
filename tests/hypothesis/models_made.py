"""Strategies for models: terms within the bounds of the table of effects, values of any type, and
their text in TOML.
"""

import math

from davarlab import model as models
from davarlab.effects import table
from hypothesis import strategies as st

KINDS = sorted(table.TABLE)
SCALAR = st.one_of(
    st.floats(),
    st.integers(-(2**70), 2**70),
    st.booleans(),
    st.text(max_size=6),
    st.none(),
    st.just(10**400),
    st.just([]),
    st.just({}),
    st.sampled_from((5e-324, 1.7976931348623157e308, -0.0, 1e100, "x", "y", "bilinear")),
)
SIZES = st.one_of(  # of coefficients
    st.floats(0, 1e9, exclude_min=True), st.sampled_from((5e-324, 1e-300, 1e-5, 2e-6, 1.0, 1e6))
)
PRINTED = st.characters(blacklist_categories=("Cs",), blacklist_characters=",\n\r")
COLUMNS = st.sampled_from(("gyro_z_dps", "gyro_x_rad_s", "accel_x_mps2")) | st.text(
    PRINTED, min_size=1, max_size=8
)
COURSES = st.lists(st.floats(1e-3, 1e4), min_size=4, max_size=9).map(
    lambda knots: " ".join(map(repr, knots))
)


def toml_of(value):
    """A value as TOML, if TOML supports it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if value != value else "inf" if value > 0 else "-inf"
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(one):08x}" for one in value) + '"'
    if isinstance(value, dict):
        pairs = (f"{toml_of(key)} = {toml_of(one)}" for key, one in there(value.items()))
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml_of(one) for _, one in there(enumerate(value))) + "]"
    return repr(value)


def there(pairs):
    return [(key, one) for key, one in pairs if one is not None]


def text_of(data):
    """Lines of a TOML file."""
    return "".join(f"{name} = {toml_of(value)}\n" for name, value in there(data.items()))


@st.composite
def values(draw, parameter):
    if parameter.values:
        return draw(st.sampled_from(parameter.values))
    if parameter.form:
        return draw(COURSES if parameter.name.endswith("_hz") else COLUMNS)
    low, high = max(parameter.low, -1e99), min(parameter.high, 1e99)
    if parameter.whole:
        return float(draw(st.integers(math.ceil(low), math.floor(min(high, 1e15)))))
    return draw(st.floats(low, high))


@st.composite
def terms(draw):
    """A term within the bounds of the table."""
    effect = table.find(draw(st.sampled_from(KINDS)))
    found = {
        one.name: draw(values(one))
        for one in effect.parameters
        if one.default is None or draw(st.booleans())
    }
    if "start_s" in found:
        found["start_s"], found["stop_s"] = sorted((found["start_s"], found["stop_s"]))
    return models.Term(effect.kind, found)
