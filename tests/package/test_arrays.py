"""Any kind of array: the results match the definition over the present samples, or one error gives
the argument's name. Any content of a file: columns of finite numbers, or one error with its name.
"""

from pathlib import Path
from unittest import mock

import numpy as np
import pandas
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from together import by_definition, davar, expect_equal

RATE_HZ = 8.0
SIZES = (1, 2, 5)
TYPES = (
    *(np.int8, np.uint8, np.int16, np.uint16, np.int32, np.int64),
    *(np.float16, np.float32, np.float64, np.longdouble),
)
ANY = st.one_of(arrays.scalar_dtypes(), st.just(np.dtype(object)))


def strided(x):
    wide = np.zeros((len(x), 3), x.dtype)
    wide[:, 1] = x
    return wide[:, 1]


def read_only(x):
    x.flags.writeable = False
    return x


LAYOUTS = (
    np.asarray,
    strided,
    read_only,
    lambda x: x[::-1].copy()[::-1],
    lambda x: x.astype(x.dtype.newbyteorder()),
    lambda x: x.tolist(),
)


def examples(count):
    fixture = HealthCheck.function_scoped_fixture
    return settings(
        max_examples=count, deadline=None, derandomize=True, suppress_health_check=[fixture]
    )


@st.composite
def series(draw):
    """(input of the user, the samples with NaN for missing ones, lsb or None)."""
    kind = np.dtype(draw(st.sampled_from(TYPES)))
    whole = st.integers(0 if kind.kind == "u" else -100, 100)
    x = np.array(draw(st.lists(whole, min_size=12, max_size=60)), kind)
    layout = draw(st.sampled_from(LAYOUTS))
    mask = np.array(draw(st.lists(st.booleans(), min_size=len(x), max_size=len(x))))
    mask &= draw(st.booleans())
    there = np.where(mask, np.nan, np.asarray(x, np.float64))
    if draw(st.booleans()):
        largest = np.inf if kind.kind == "f" else np.iinfo(kind).max
        handed = np.ma.masked_array(np.where(mask, np.asarray(largest, kind), x), mask=mask)
    elif kind.kind == "f":
        handed = layout(np.where(mask, np.asarray(np.nan, kind), x))
    else:
        handed, there = layout(x.copy()), np.asarray(x, np.float64)
    return handed, there, (0.5 if kind.kind in "iu" else None)


@examples(300)
@given(series())
def test_values_use_the_present_samples(drawn):
    handed, there, lsb = drawn
    if np.isfinite(there).sum() < 2 * max(SIZES):
        with pytest.raises(ValueError, match="^(x|clusters): "):
            davar.adev(handed, RATE_HZ, clusters=SIZES, lsb=lsb)
        return
    found = davar.adev(handed, RATE_HZ, clusters=SIZES, lsb=lsb)
    wanted = [by_definition(there * (lsb or 1), m) for m in SIZES]
    assert found.n.tolist() == [n for _, n in wanted]
    np.testing.assert_allclose(found.adev, [value for value, _ in wanted], rtol=1e-7, atol=1e-7)
    np.testing.assert_array_equal(found.taus_s, np.array(SIZES) / RATE_HZ)


@examples(60)
@given(series())
def test_windows_and_streams_see_the_same_samples(drawn):
    handed, there, lsb = drawn
    options = {"law": "fixed", "mode": "trailing", "segment": 0, "clusters": SIZES, "lsb": 0.5}
    options |= {"window_max": 12, "window_min": 12}
    if np.isfinite(there).sum() < 12:
        with pytest.raises(ValueError, match="^x: "):
            davar.dynamic(handed, RATE_HZ, **options)
        return
    wanted = davar.dynamic(there * (lsb or 1), RATE_HZ, **options)
    expect_equal(davar.dynamic(handed, RATE_HZ, **options), wanted)
    stream = davar.Stream(RATE_HZ, **options)
    stream.push(handed)
    expect_equal(stream.results(), wanted)


@examples(200)
@given(arrays.arrays(ANY, arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=20)))
def test_nothing_is_flattened_and_the_error_gives_the_name(x):
    for call in (
        lambda: davar.adev(x, RATE_HZ, clusters=[1]),
        lambda: davar.dynamic(x, RATE_HZ, stride=2),
        lambda: davar.Stream(RATE_HZ, full_scale=1.0).push(x),
    ):
        try:
            call()
        except ValueError as why:
            assert str(why).startswith(("x: ", "lsb: "))
        else:
            assert x.ndim < 2 and x.dtype.kind == "f"


@examples(200)
@given(
    st.sampled_from(("time_s", "gaps", "clusters", "taus_s")),
    arrays.arrays(ANY, arrays.array_shapes(min_dims=0, max_dims=2, min_side=0, max_side=20)),
)
def test_so_does_that_of_the_other_arrays(name, value):
    x = np.random.default_rng(1).normal(0, 1, 20)
    try:
        davar.adev(x, RATE_HZ, **{name: value})
    except ValueError as why:
        assert str(why).startswith(f"{name}: ")
    else:
        assert value.ndim < 2 and value.dtype.kind in "iuf"


FIELDS = st.one_of(
    st.floats().map(repr),
    st.integers().map(str),
    st.text(max_size=4),
    st.sampled_from(("1_0", "\uff11", "\u0661", "0x1", "1e9999", "nan", "")),
)
TEXTS = st.tuples(
    st.sampled_from(("time_s,gyro_z_dps\n", "a\n", "# k: v\na,b,c\n", "")),
    st.lists(st.lists(FIELDS, min_size=1, max_size=3).map(",".join), max_size=5),
    st.sampled_from(("\n", "\r\n", "\r")),
).map(lambda parts: (parts[0] + parts[2].join(parts[1])).encode(errors="surrogatepass"))


@examples(400)
@given(content=st.one_of(TEXTS, TEXTS, TEXTS, st.binary(max_size=60)))
def test_any_file(elsewhere, content):
    Path("rec.csv").write_bytes(content)
    with mock.patch("davar.errors.missing", lambda: ["rosbags"]):
        try:
            found = davar.read("rec.csv").columns.values()
            assert all(np.isfinite(column).all() and column.ndim == 1 for column in found)
        except ValueError as why:
            assert str(why).startswith(("rec.csv: ", "rec.csv:"))
        except ImportError:  # another log
            assert b"\0" in content or content.startswith(davar._read.LOGS)


def test_columns_of_tables():
    x = np.random.default_rng(2).normal(0, 1, 100)
    x[40] = np.nan
    wanted = davar.adev(x, RATE_HZ, clusters=SIZES)
    for column in (pandas.Series(x, index=range(100, 0, -1)), pandas.DataFrame({"a": x})["a"]):
        np.testing.assert_array_equal(davar.adev(column, RATE_HZ, clusters=SIZES), wanted)
    for table in (pandas.DataFrame({"a": x}), pandas.Series(x, dtype=object)):
        with pytest.raises(ValueError, match="^x: "):
            davar.adev(table, RATE_HZ)
