"""Any kind of array: the results match the definition over the present samples, or one error gives
the argument's name.
"""

import unittest
from pathlib import Path

import davar
import numpy as np
import together
from davar import _read
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

RATE_HZ = 8.0
SIZES = (1, 2, 5)


def by_definition(x, m):
    """Overlapping Allan deviation and number of differences, sample by sample; NaN is missing."""
    squares = []
    for i in range(len(x) - 2 * m + 1):
        first, second = x[i : i + m], x[i + m : i + 2 * m]
        if not (np.isnan(first).any() or np.isnan(second).any()):
            squares.append((second.mean() - first.mean()) ** 2)
    return (np.sqrt(sum(squares) / (2 * len(squares))) if squares else np.nan), len(squares)


def strided(x):
    wide = np.zeros((len(x), 3), x.dtype)
    wide[:, 1] = x
    return wide[:, 1]


def backwards(x):
    return x[::-1].copy()[::-1]


def read_only(x):
    x.flags.writeable = False
    return x


LAYOUTS = (
    np.asarray,
    strided,
    backwards,
    read_only,
    lambda x: x.astype(x.dtype.newbyteorder()),
    lambda x: x.tolist(),
)
TYPES = (
    np.int8,
    np.uint8,
    np.int16,
    np.uint16,
    np.int32,
    np.int64,
    np.float16,
    np.float32,
    np.float64,
    np.longdouble,
)


@st.composite
def series(draw):
    """(input of the user, the samples with NaN for missing ones, lsb or None)."""
    kind = np.dtype(draw(st.sampled_from(TYPES)))
    whole = draw(
        st.lists(st.integers(0 if kind.kind == "u" else -100, 100), min_size=12, max_size=60)
    )
    x = np.array(whole, kind)
    layout = draw(st.sampled_from(LAYOUTS))
    mask = np.array(draw(st.lists(st.booleans(), min_size=len(x), max_size=len(x)))) & draw(
        st.booleans()
    )
    there = np.where(mask, np.nan, np.asarray(x, np.float64))
    if draw(st.booleans()):
        hidden = np.where(
            mask, np.asarray(np.inf if kind.kind == "f" else np.iinfo(kind).max, kind), x
        )
        handed = np.ma.masked_array(hidden, mask=mask)
    elif kind.kind == "f":
        handed = layout(np.where(mask, np.asarray(np.nan, kind), x))
    else:
        handed, there = layout(x.copy()), np.asarray(x, np.float64)
    return handed, there, (0.5 if kind.kind in "iu" else None)


class Column:
    """What numpy gets from a column of pandas, polars, pyarrow or xarray: not an array, but an
    object that converts to one.
    """

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return self.values if dtype is None else self.values.astype(dtype)


def series_of_pandas(x):
    try:
        import pandas
    except ImportError:  # the pins do not include it
        return []
    return [
        pandas.Series(x),
        pandas.Series(x, index=range(len(x), 0, -1)),
        pandas.DataFrame({"a": x, "b": x})["b"],
    ]


class Kinds(unittest.TestCase):
    @settings(max_examples=300, deadline=None, derandomize=True)
    @given(series())
    def test_values_use_the_present_samples(self, drawn):
        handed, there, lsb = drawn
        wanted = [by_definition(there * (lsb or 1), m) for m in SIZES]
        if np.isfinite(there).sum() < 2 * max(SIZES):
            with self.assertRaisesRegex(ValueError, "^(x|clusters): "):
                davar.adev(handed, RATE_HZ, clusters=SIZES, lsb=lsb)
            return
        found = davar.adev(handed, RATE_HZ, clusters=SIZES, lsb=lsb)
        self.assertEqual(found.n.tolist(), [n for _, n in wanted])
        np.testing.assert_allclose(found.adev, [value for value, _ in wanted], rtol=1e-7, atol=1e-7)
        np.testing.assert_array_equal(found.taus_s, np.array(SIZES) / RATE_HZ)

    @settings(max_examples=60, deadline=None, derandomize=True)
    @given(series())
    def test_windows_and_streams_see_the_same_samples(self, drawn):
        handed, there, lsb = drawn
        options = {
            "policy": "fixed",
            "mode": "trailing",
            "window_max": 12,
            "window_min": 12,
            "segment": 0,
            "clusters": SIZES,
            "lsb": 0.5,
        }
        if np.isfinite(there).sum() < 12:
            with self.assertRaisesRegex(ValueError, "^x: "):
                davar.dynamic(handed, RATE_HZ, **options)
            return
        wanted = davar.dynamic(there * (lsb or 1), RATE_HZ, **options)
        found, stream = davar.dynamic(handed, RATE_HZ, **options), davar.Stream(RATE_HZ, **options)
        stream.push(handed)
        pushed = stream.results()
        for name, column in wanted.items():
            np.testing.assert_array_equal(found[name], column, name)
            np.testing.assert_array_equal(pushed[name], column, name)

    @settings(max_examples=200, deadline=None, derandomize=True)
    @given(
        arrays.arrays(
            st.one_of(arrays.scalar_dtypes(), st.just(np.dtype(object))),
            arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=20),
        )
    )
    def test_nothing_is_flattened_and_the_error_gives_the_name(self, x):
        for call in (
            lambda: davar.adev(x, RATE_HZ, clusters=[1]),
            lambda: davar.dynamic(x, RATE_HZ, stride=2),
            lambda: davar.Stream(RATE_HZ, full_scale=1.0).push(x),
        ):
            try:
                call()
            except ValueError as why:
                self.assertRegex(str(why), "^(x|lsb): ")
            else:
                self.assertTrue(x.ndim == 1 or x.ndim == 0, x.shape)
                self.assertEqual(x.dtype.kind, "f")

    @settings(max_examples=200, deadline=None, derandomize=True)
    @given(
        st.sampled_from(("time_s", "gaps", "clusters", "taus_s")),
        arrays.arrays(
            st.one_of(arrays.scalar_dtypes(), st.just(np.dtype(object))),
            arrays.array_shapes(min_dims=0, max_dims=2, min_side=0, max_side=20),
        ),
    )
    def test_so_does_that_of_the_other_arrays(self, name, value):
        x = np.random.default_rng(1).normal(0, 1, 20)
        try:
            davar.adev(x, RATE_HZ, **{name: value})
        except ValueError as why:
            self.assertRegex(str(why), f"^{name}: ")
        else:
            self.assertTrue(value.ndim < 2 and value.dtype.kind in "iuf", value)

    def test_columns_of_tables(self):
        x = np.random.default_rng(2).normal(0, 1, 100)
        x[40] = np.nan
        wanted = davar.adev(x, RATE_HZ, clusters=SIZES)
        for column in (Column(x), *series_of_pandas(x)):
            np.testing.assert_array_equal(davar.adev(column, RATE_HZ, clusters=SIZES), wanted)
        for table in (Column(x.reshape(-1, 1)), Column(x.astype(object))):
            with self.assertRaisesRegex(ValueError, "^x: "):
                davar.adev(table, RATE_HZ)


class Files(unittest.TestCase):
    """Any content of a file gives columns of finite numbers, or one error with the file's name."""

    fields = st.one_of(
        st.floats().map(repr),
        st.integers().map(str),
        st.text(max_size=4),
        st.sampled_from(("1_0", "\uff11", "\u0661", "0x1", "1e9999", "nan", "")),
    )
    rows = st.lists(st.lists(fields, min_size=1, max_size=3).map(",".join), max_size=5)

    def read(self, content):
        with together.elsewhere():
            Path("rec.csv").write_bytes(content)
            try:
                found = davar.read("rec.csv")
            except ValueError as why:
                self.assertRegex(str(why), r"^rec\.csv(:\d+)?: ")
            except ImportError as why:  # not text: another log
                self.assertTrue(b"\0" in content, why)
            else:
                self.assertTrue(
                    all(
                        np.isfinite(column).all() and column.ndim == 1
                        for column in found.columns.values()
                    )
                )

    @settings(max_examples=300, deadline=None, derandomize=True)
    @given(
        st.sampled_from(("time_s,gyro_z_dps\n", "a\n", "# k: v\na,b,c\n", "")),
        rows,
        st.sampled_from(("\n", "\r\n", "\r")),
    )
    def test_texts(self, head, rows, end):
        self.read((head + end.join(rows)).encode(errors="surrogatepass"))

    @settings(max_examples=100, deadline=None, derandomize=True)
    @given(st.binary(max_size=60).filter(lambda content: not content.startswith(_read.LOGS)))
    def test_bytes(self, content):
        self.read(content)


if __name__ == "__main__":
    unittest.main()
