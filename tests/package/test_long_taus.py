"""longest_tau_s: the averaging times beyond the window, compared with AllanTools and with the
definition of the cascade (lib/src/cascade/DESIGN.md).
"""

import allantools
import numpy as np
import pytest
import week
from hypothesis import given, settings
from hypothesis import strategies as st
from together import davar, expect_equal

RATE_HZ = 100.0
LSB = 0.01
CLUSTERS = 32  # remembered by each size, and up to twice as many
WINDOW = {
    "policy": "fixed",
    "mode": "trailing",
    "window_max": 200,
    "window_min": 200,
    "clusters": [1, 4, 20],
    "bandwidth": "none",
    "details": True,
}
FIRST = 80  # the first octave of 20 that is at least 64 and a multiple of 4
HOP = FIRST // 4  # the shortest
# Epochs at the mirrored end come after the last hop has been added.
COMPLETE = WINDOW | {"mode": "centred", "stride": 50}
HOUR = 360_000  # samples
ALL_REMEMBERED_S = 3600 / 34  # from here on, a size has seen less than its memory holds


def octaves(first, longest):
    found = [first]
    while 2 * found[-1] <= longest:
        found.append(2 * found[-1])
    return found


def hop_of(m, t):
    """Samples from one difference of the t-th size to the next: m / 4 and m / 8 in turn."""
    return m // (4, 8)[t % 2]


def by_definition(x, m, hop, gaps=()):
    """(deviation, differences) of all samples x: the differences at multiples of the hop, without
    those that span a gap, of the newest generation and the one before it.
    """
    total = np.concatenate([[0], np.cumsum(x)])
    length = CLUSTERS * m // hop  # hops of a generation
    squares, newest = [], (len(x) // hop - 1) // length
    for number in range(1, len(x) // hop + 1):
        end = number * hop
        whole = end >= 2 * m and not any(end - 2 * m < gap < end for gap in gaps)
        if whole and (number - 1) // length >= newest - 1:
            squares.append(float(total[end] - 2 * total[end - m] + total[end - 2 * m]) ** 2)
    return (np.sqrt(np.mean(squares) / 2) / m if squares else np.nan), len(squares)


def counts_of(seed, count):
    made = np.random.default_rng(seed)
    x = made.normal(30, 20, count) + np.cumsum(made.normal(0, 0.2, count))
    return np.round(x).astype(np.int16)


def expect(epochs, row, x, sizes, gaps=(), unit=LSB, rtol=1e-12):
    for t, m in enumerate(sizes):
        deviation, differences = by_definition(x, m, hop_of(m, t), gaps)
        assert epochs[f"differences_{m}"][row] == differences, (m, row)
        np.testing.assert_allclose(epochs[f"adev_{m}"][row], deviation * unit, rtol=rtol)


@pytest.mark.parametrize(
    "clusters, first", (([1, 2, 64], 128), ([1, 20], 80), ([3], 96), ([7], 112), ([32], 64))
)
def test_the_sizes_continue_those_of_the_window(clusters, first):
    x, options = counts_of(1, 1000), {"lsb": LSB, "clusters": clusters, "stride": 100}
    found = davar.dynamic(x, RATE_HZ, longest_tau_s=20, **options)
    assert found.clusters.tolist() == clusters + octaves(first, 2000)
    np.testing.assert_allclose(found.taus_s, found.clusters / RATE_HZ, rtol=1e-15)
    alone = davar.dynamic(x, RATE_HZ, **options)
    np.testing.assert_array_equal(found.adev[:, : len(clusters)], alone.adev)


def test_counts_at_every_epoch_through_two_generations():
    x, sizes = counts_of(2, 45_000), octaves(FIRST, 1300)
    found = davar.dynamic(x, RATE_HZ, lsb=LSB, longest_tau_s=13, stride=131, **WINDOW)
    # A difference is in its sum a few samples after its hop.
    rows = [row for row, epoch in enumerate(found.epoch) if (epoch + 1) % HOP > len(sizes) + 3]
    assert len(rows) > 150
    for row in rows[::5]:
        expect(found, row, x[: found.epoch[row] + 1], sizes)
    newest = found[f"differences_{FIRST}"]
    assert newest[-1] < 2 * CLUSTERS * 4 + 1  # generations were dropped
    assert newest.argmax() < len(newest) - 1


@pytest.mark.parametrize("options, rtol", (({}, 1e-8), ({"arith": "float", "full_scale": 4}, 1e-5)))
def test_floats(options, rtol):
    x = counts_of(3, 9_000) * 1e-3
    found = davar.dynamic(x, RATE_HZ, longest_tau_s=13, **COMPLETE, **options)
    expect(found, -1, x, octaves(FIRST, 1300), (), 1, rtol)


def test_gaps_in_every_form():
    x, sizes = counts_of(4, 30_000), octaves(FIRST, 1300)
    holes = np.r_[5_000:5_003, 5_100, 17_777, 29_000:29_020]
    there = np.delete(x, holes)
    gaps = [int(hole - before) for before, hole in enumerate(holes)]
    masked = np.ma.masked_array(x, np.isin(np.arange(len(x)), holes))
    rates = np.where(masked.mask, np.nan, x * LSB)
    time_s = np.delete(np.arange(len(x)) / 128.0, holes)
    options = {"lsb": LSB, "longest_tau_s": 10.5, **COMPLETE}
    for found in (
        davar.dynamic(masked, 128.0, **options),
        davar.dynamic(rates, 128.0, **options),
        davar.dynamic(there, 128.0, gaps=sorted(set(gaps)), **options),
        davar.dynamic(there, time_s=time_s, **options),
    ):
        expect(found, -1, there, sizes, gaps)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.data())
def test_any_lengths_gaps_and_blocks(data):
    count = data.draw(st.integers(200, 3000))
    places = st.sets(st.integers(1, count - 1), max_size=5)
    x = counts_of(data.draw(st.integers(0, 2**32 - 1)), count)
    gaps, cuts = data.draw(places), data.draw(places)
    ends = sorted({0, *gaps, *cuts, count})
    options = {"lsb": LSB, "longest_tau_s": 13, **COMPLETE}
    stream = davar.Stream(RATE_HZ, **options)
    for first, last in zip(ends, ends[1:]):
        if first in gaps:
            stream.gap()
        stream.push(x[first:last])
    stream.finish()
    pushed = stream.results()
    if len(pushed.epoch):
        expect(pushed, -1, x, octaves(FIRST, 1300), gaps)
        expect_equal(pushed, davar.dynamic(x, RATE_HZ, gaps=sorted(gaps), **options))


def test_the_deviations_are_allantools_own_of_the_means_over_a_hop():
    """While a size remembers all samples, its differences are those of the means."""
    x = counts_of(6, 20_000)
    found = davar.dynamic(x, RATE_HZ, lsb=LSB, longest_tau_s=52, **COMPLETE)
    compared = 0
    for t, m in enumerate(octaves(FIRST, 5200)):
        hop = hop_of(m, t)
        if len(x) <= CLUSTERS * m:
            means = LSB * x[: len(x) // hop * hop].reshape(-1, hop).mean(axis=1)
            _, deviation, _, n = allantools.oadev(
                means, rate=RATE_HZ / hop, data_type="freq", taus=[m / RATE_HZ]
            )
            assert found[f"differences_{m}"][-1] == n[0]
            np.testing.assert_allclose(found[f"adev_{m}"][-1], deviation[0], rtol=1e-9)
            compared += 1
    assert compared == 4


def test_a_random_walk_that_the_window_cannot_see():
    """Its deviation equals that of the white noise at 20 s; the window ends at 2 s."""
    white = 0.05
    step = white / RATE_HZ * np.sqrt(3) / 20.0  # per sample
    truth = {
        "arw_deg_per_sqrt_h": white / np.sqrt(RATE_HZ) * 60,
        "rrw_deg_per_h_per_sqrt_h": step * np.sqrt(RATE_HZ) * 3600 * 60,
    }
    options = {**WINDOW, "lsb": 0.0005, "bits": 16, "stride": 200}
    for seed in range(5):
        made = np.random.default_rng(seed)
        rates = made.normal(0, white, 1_000_000) + np.cumsum(made.normal(0, step, 1_000_000))
        x = np.round(rates / options["lsb"]).astype(np.int16)
        curve = davar.dynamic(x, RATE_HZ, longest_tau_s=2000, **options)
        window = davar.dynamic(x[-50_000:], RATE_HZ, **options)
        assert np.isfinite(window.rrw_deg_per_h_per_sqrt_h).mean() < 0.2
        for name, value in truth.items():
            # The standard errors are 4 % and 9 %; by chance, 1 % of the results are withheld.
            estimate = np.nanmedian(curve[name][-100:])
            assert abs(estimate / value - 1) < (0.45 if "rrw" in name else 0.2), name
        np.testing.assert_array_equal(
            curve.adev[:250, :3], davar.dynamic(x[:50_000], RATE_HZ, **options).adev[:250]
        )


def test_limits_enclose_every_deviation():
    x = counts_of(7, 60_000)
    found = davar.dynamic(x, RATE_HZ, lsb=LSB, longest_tau_s=52, stride=200, **WINDOW)
    withheld = found.filtered | found.coarse  # 0 to infinity
    assert withheld.mean() < 0.1
    for m in found.clusters:
        there = found[f"differences_{m}"] > 0
        np.testing.assert_array_equal(there, np.isfinite(found[f"adev_{m}"]))
        low, adev, high = (found[f"{name}_{m}"] for name in ("adev_low", "adev", "adev_high"))
        assert np.all((low < adev) & (adev < high) | withheld | ~there), m


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    st.one_of(
        st.floats(),
        st.integers(),
        st.text(max_size=8),
        st.booleans(),
        st.lists(st.floats(), max_size=3),
    )
)
def test_it_is_a_number_of_seconds_or_an_error(value):
    x = counts_of(8, 700)
    try:
        found = davar.dynamic(x, RATE_HZ, lsb=LSB, longest_tau_s=value, stride=100, **WINDOW)
    except ValueError as why:
        assert str(why).startswith("longest_tau_s: ") and "found" in str(why)
    else:
        assert found.clusters.tolist()[:4] == [1, 4, 20, FIRST]
        assert found.taus_s[-1] <= float(value) < 2 * found.taus_s[-1]


@pytest.mark.parametrize(
    "options, reason",
    (
        ({"longest_tau_s": 0.5}, "from 0.8 s to less than"),
        ({"longest_tau_s": 1e9}, "from 0.8 s to less than"),
        ({"longest_tau_s": 50, "clusters": range(1, 33)}, "at most 31 cluster sizes"),
        ({"longest_tau_s": 50, "clusters": range(1, 32)}, "from 1.24 s to less than 2.48 s"),
    ),
)
def test_the_reason_is_given(options, reason):
    options = {"lsb": LSB, **WINDOW, **options}
    with pytest.raises(ValueError, match=f"^longest_tau_s: {reason}"):
        davar.dynamic(counts_of(9, 3000), RATE_HZ, **options)
    with pytest.raises(ValueError, match=f"^longest_tau_s: {reason}"):
        davar.Stream(RATE_HZ, **options)


def here(chunks):
    """The newest row of davar.dynamic, as text, with the options of the week."""
    found = davar.dynamic(
        np.concatenate(chunks),
        week.RATE_HZ,
        lsb=week.LSB_DPS,
        longest_tau_s=600,
        engine="grid",
        segment=0,
        **WINDOW
        | {"clusters": [1, 2, 4, 8, 16, 32, 64], "bits": 16, "stride": week.WINDOW}
        | {"window_max": week.WINDOW, "window_min": week.WINDOW},
    )
    last = {name: float(column[-1]) for name, column in found.items()}
    return {name: "" if np.isnan(value) else repr(value) for name, value in last.items()}


@pytest.mark.parametrize(
    "run",
    (here, pytest.param(lambda x: week.on_board(x, "cortex-m0", 600), marks=pytest.mark.soak)),
)
def test_an_hour_agrees_with_allantools_and_with_the_simulated_noise(run):
    chunks = list(week.counts_of(HOUR, 41))
    row = run(chunks)
    lines = week.compare(row, np.concatenate(chunks))
    assert len(lines) == 7 + 9
    assert lines[-1]["tau_s"] == pytest.approx(327.68)
    assert max(abs(line["off"]) for line in lines) < 2
    # The sizes that remember the hour differ by their hops only.
    longest = [abs(line["off"]) for line in lines if line["tau_s"] >= ALL_REMEMBERED_S]
    assert len(longest) == 2 and max(longest) < 0.4
    low, high = (float(row[f"arw_{end}_deg_per_sqrt_h"]) for end in ("low", "high"))
    assert 0.95 * week.N < low < high < 1.05 * week.N
    if row["bi_deg_per_h"]:
        assert float(row["bi_deg_per_h"]) == pytest.approx(week.B, rel=0.5)
    else:
        assert float(row["bi_upper_deg_per_h"]) > 0.7 * week.B
    if not row["rrw_deg_per_h_per_sqrt_h"]:
        assert float(row["rrw_upper_deg_per_h_per_sqrt_h"]) > 0.7 * week.K
