"""Units and numbers at the limits of a double: factors against the name of the unit, exports
against formulas, printed numbers against float().
"""

import argparse
import json
import math
import re
import struct
from decimal import Decimal

import pytest
from davar.wire import raw
from davarlab import kalibr
from davarlab import model as models
from davarlab.commands import option_types
from davarlab.effects import table
from davarlab.inference.estimate import Estimate
from davarlab.report import parameters, terminal, values, words
from davarlab.tables import guess
from hypothesis import assume, given
from hypothesis import strategies as st
from lawful import examples, run
from models_made import SIZES

# deg, m and s
ANGLES = {"deg": 1.0, "mdeg": 1e-3, "rad": 180 / math.pi, "m": 1.0, "sqrt": math.sqrt}
OTHERS = {"degC": 1.0, "samples": 1.0}
SECONDS = {"s": 1.0, "h": 3600.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
GRAVITIES = {"ug": 9.80665e-6, "mg": 9.80665e-3, "g": 9.80665}
# power of a second in the unit of a coefficient of a gyro; of an accelerometer one less
KINDS = {-0.5: "angle_random_walk", -1.0: "bias_instability", -1.5: "rate_random_walk"}
SHEETS = {
    "gyro_z_dps": (
        *("deg/sqrt(h)", "deg/s/sqrt(Hz)", "mdeg/s/sqrt(Hz)", "rad/s/sqrt(Hz)", "rad/sqrt(s)"),
        *("deg/h/sqrt(Hz)", "dps/sqrt(Hz)", "deg/h", "deg/s", "rad/s", "deg/h/sqrt(h)"),
        *("rad/s^2/sqrt(Hz)", "deg/s^2/sqrt(Hz)", "dps/sqrt(s)", "deg/(s*sqrt(Hz))"),
    ),
    "accel_z_g": (
        *(
            "m/s/sqrt(h)",
            "m/s^2/sqrt(Hz)",
            "ug/sqrt(Hz)",
            "mg/sqrt(Hz)",
            "g/sqrt(Hz)",
            "mg/sqrt(h)",
        ),
        *("ug", "mg", "m/s^2", "m/s^3/sqrt(Hz)"),
    ),
}
DOUBLES = st.one_of(
    st.floats(),
    st.sampled_from((5e-324, 1.7976931348623157e308, -0.0, 1e-4, 9999.5, 999999.5, 1e6)),
)
PLAIN = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")


def meaning(unit, second=1.0):
    """A unit in deg, m and s, computed from its name; second: the size of a second."""
    times = {name: size * second for name, size in SECONDS.items()}
    forces = {name: size / second**2 for name, size in GRAVITIES.items()}
    names = {**ANGLES, **OTHERS, **times, **forces, "Hz": 1 / second, "dps": 1 / second}
    times_of = re.sub(r"^([\d.]+)(?=[a-z])", r"\1*", unit)  # 0.1ms
    return eval(times_of.replace("^", "**"), {"__builtins__": {}}, names)


def units():
    """(what, factor, factor by the name) of each unit of a data sheet, a model and a log."""
    for column, sheet in SHEETS.items():
        for unit in sheet:
            (term,) = kalibr.of_sheet([f"3.5{unit}"], column, None).terms
            yield unit, table.find(term.kind).dps(term.parameters) / 3.5, meaning(unit)
    for effect in table.TABLE.values():
        for one in effect.parameters:
            if re.fullmatch(r"deg/(s|h|sqrt\(h\)|h/sqrt\(h\)|h\^2)", one.unit):
                yield f"{effect.kind} {one.name}", one.scale, meaning(one.unit)
    for quantity, base in (("time", "s"), ("gyro", "deg/s"), ("accel", "g")):
        for unit, factor in guess.UNITS[quantity].items():
            yield unit, factor, meaning(unit) / meaning(base)


def test_every_unit_matches_its_name():
    found = list(units())
    assert len(found) > 30
    for what, factor, wanted in found:
        assert factor == pytest.approx(wanted, rel=1e-12), what


@pytest.mark.parametrize("column, less", [("gyro_z_dps", 0), ("accel_z_g", 1)])
def test_the_kind_of_a_number_of_a_data_sheet_is_that_of_its_unit(column, less):
    for unit in SHEETS[column]:
        power = math.log2(meaning(unit, 2.0) / meaning(unit)) + less
        (kind,) = kalibr.of_sheet([f"1{unit}"], column, None).kinds
        assert kind == KINDS[round(power, 9)], unit


def exported(work, sizes, rate_hz, *options):
    """The text of an exported model; "" if it is rejected."""
    models.write(kalibr.model_of(sizes, "gyro_z_dps", rate_hz), work / "m.toml")
    done = work.lawful("out.h", "export", work / "m.toml", "-o", "OUT", *options)
    text = (work / "out.h").read_text() if done.status == 0 else ""
    assert not re.search(r"(?i)(?<![a-z])(nan|inf)(?![a-z])", text)
    return text


@given(
    white=SIZES,
    walk=SIZES,
    rate_hz=st.floats(1e-300, 1e300),
    form=st.sampled_from(sorted(parameters.FORMATS)),
    inflate=DOUBLES,
    seconds=DOUBLES,
    kind=st.sampled_from(("rate_random_walk", "bias_instability")),
)
@examples(100)
def test_no_format_prints_bad_numbers(work, white, walk, rate_hz, form, inflate, seconds, kind):
    assume(0 < inflate < math.inf and 0 < seconds < math.inf)
    options = ("--to", form, "--bias-time", repr(seconds), "--inflate", repr(inflate))
    sizes = {"angle_random_walk": white, kind: walk}
    exported(work, sizes, rate_hz, *options[: 6 if kind == "rate_random_walk" else 4])


@given(white=SIZES, walk=SIZES, rate_hz=st.floats(1e-9, 1e9), window=st.integers(100, 4000))
@examples(40)
def test_the_table_for_the_device_is_that_of_the_formulas(work, white, walk, rate_hz, window):
    sizes = {"angle_random_walk": white, "rate_random_walk": walk}
    text = exported(work, sizes, rate_hz, "--window", str(window))
    if not text:
        return
    rows = re.findall(r"\{ (\d+)U, ([^ ,]+?)f?, ([^ ,]+?)f? \}", text)
    assert len(rows) == int(re.search(r"TAU_COUNT (\d+)", text)[1]) > 0
    for m, adev, _ in rows:
        n = int(m)  # a sampled walk has (2 n^2 + 1) / (6 n) instead of n / 3
        walked = (walk / 216000 / rate_hz) ** 2 * (2 * n * n + 1) / (6 * n)
        variance = (white / 60) ** 2 / n + walked
        exact = math.sqrt(variance * rate_hz)
        if 1e-37 < exact < 1e38:  # a float
            assert float(adev) == pytest.approx(exact, rel=1e-5), m


@given(
    value=DOUBLES.map(repr),
    option=st.sampled_from(("--scale gyro_z_dps=", "--scale time_s=", "--rate ")),
)
@examples(80)
def test_factors_and_rates_of_any_size(work, value, option):
    rows = "".join(f"{place / 50},{place % 7 - 3}\n" for place in range(20))
    path, out = work.file("r.csv", f"time_s,gyro_z_dps\n{rows}"), work / "out.csv"
    out.unlink(missing_ok=True)
    done = run("import", path, "-o", out, *(option + value).split())
    assert done.status in (0, 2), done.err
    assert out.exists() == (done.status == 0)
    if out.exists():
        assert not re.search("nan|inf", out.read_text())


def is_close(text, value, relative):
    """True if the text of a number gives the same double."""
    if not math.isfinite(value):
        return float(text) == value or value != value and float(text) != float(text)
    allowed = abs(Decimal(value)) * Decimal(relative) + Decimal("5e-324")
    return abs(Decimal(text) - Decimal(value)) <= allowed


@given(value=DOUBLES, digits=st.integers(3, 9))
@examples(300)
def test_a_number_for_people_is_that_number(value, digits):
    said = words.number(value, digits)
    if value != value:
        assert said == "–"
    elif math.isinf(value):
        assert said == ("−∞" if value < 0 else "∞")
    else:
        mantissa, _, power = said.replace("·10", "e").translate(PLAIN).partition("e")
        number = f"{mantissa}e{power or 0}"
        assert is_close(number, value, 0.51 * 10 ** (2 - digits)), (said, value)


@given(value=DOUBLES, low=DOUBLES, high=DOUBLES)
@examples(100)
def test_intervals_of_any_numbers(value, low, high):
    said = terminal.interval(Estimate(value, low, high))
    for end, was in zip(re.fullmatch(r"95 %: (\S+) \.\. (\S+)", said).groups(), (low, high)):
        assert is_close(end, was, 1e-4), said
    words.bounds(Estimate(value, low, high))
    words.chance(value)


NESTED = st.recursive(
    DOUBLES,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3)
    ),
)


@given(value=NESTED)
@examples(100)
def test_json_has_no_infinity(value):
    plain = values.plain(value)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain


@given(single=st.floats(width=32, allow_nan=False))
@examples(300)
def test_a_single_is_written_as_it_was_meant(single):
    assert struct.pack("<f", raw.written(single)) == struct.pack("<f", single)


OPTIONS = {  # what reads it -> what it is
    option_types.whole: int,
    option_types.natural: int,
    option_types.positive: float,
    option_types.identifier: lambda text: int(text, 16),
    option_types.channel: int,
    option_types.port: int,
}


@given(
    text=st.one_of(
        st.text(max_size=12), DOUBLES.map(repr), st.integers().map(str), st.just("9" * 5000)
    ),
    kind=st.sampled_from(list(OPTIONS)),
)
@examples(300)
def test_options_are_numbers_or_rejected(text, kind):
    try:
        value = kind(text)
    except (argparse.ArgumentTypeError, ValueError):
        return
    assert math.isfinite(value) and value >= 0
    assert value == OPTIONS[kind](text)
