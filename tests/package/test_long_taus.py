"""longest_tau_s: the averaging times beyond the window, compared with AllanTools and with the
definition of the cascade (addons/cascade/DESIGN.md).
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
WINDOW = {"law": "fixed", "mode": "trailing", "window_max": 200, "window_min": 200}
WINDOW |= {"clusters": [1, 4, 20], "bandwidth": "none", "details": True}
FIRST = 80  # the first octave of 20 that is at least 64 and a multiple of 4
# Epochs at the mirrored end come after the last hop has been added.
COMPLETE = WINDOW | {"mode": "centred", "stride": 50}
HOUR = 360_000  # samples


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


def expect(epochs, x, sizes, gaps=()):
    for t, m in enumerate(sizes):
        deviation, differences = by_definition(x, m, hop_of(m, t), gaps)
        assert epochs[f"differences_{m}"][-1] == differences, m
        np.testing.assert_allclose(epochs[f"adev_{m}"][-1], deviation * LSB, rtol=1e-12)


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
        expect(pushed, x, octaves(FIRST, 1300), gaps)
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


@pytest.mark.soak
def test_an_hour_agrees_with_allantools_and_with_the_simulated_noise():
    """On the emulated Cortex-M0 of docs/quality/WEEK.md."""
    chunks = list(week.counts_of(HOUR, 41))
    row = week.on_board(chunks, "cortex-m0", 600)
    lines = week.compare(row, np.concatenate(chunks))
    assert len(lines) == 7 + 9
    assert lines[-1]["tau_s"] == pytest.approx(327.68)
    assert max(abs(line["off"]) for line in lines) < 2
    # The sizes that remember the hour differ by their hops only.
    longest = [abs(line["off"]) for line in lines if line["tau_s"] >= 3600 / 34]
    assert len(longest) == 2 and max(longest) < 0.4
    low, high = (float(row[f"arw_{end}_deg_per_sqrt_h"]) for end in ("low", "high"))
    assert 0.95 * week.N < low < high < 1.05 * week.N
    if row["bi_deg_per_h"]:
        assert float(row["bi_deg_per_h"]) == pytest.approx(week.B, rel=0.5)
    else:
        assert float(row["bi_upper_deg_per_h"]) > 0.7 * week.B
    if not row["rrw_deg_per_h_per_sqrt_h"]:
        assert float(row["rrw_upper_deg_per_h_per_sqrt_h"]) > 0.7 * week.K
