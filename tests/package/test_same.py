"""davar.dynamic and davar.Stream give the output of davar-sim, digit by digit, and have its
options.
"""

import inspect
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from together import davar, expect_equal, expect_printed, recording, simulator

RATE_HZ = 100.0


def noise(seed, count=4000):
    made = np.random.default_rng(seed)
    x = made.normal(0.3, 0.2, count)
    x[count // 2 : count // 2 + 300] *= 4
    return x + np.cumsum(made.normal(0, 1e-3, count))


def counts_of(seed, kind=np.int16):
    return np.round(noise(seed) / 0.01).astype(kind)


def words_of(options):
    """The options of davar-sim for those of davar.dynamic."""
    words = []
    for name, value in options.items():
        option = {"clusters": "taus", "longest_tau_s": "longest-tau"}.get(name, name)
        words.append("--" + option.replace("_", "-"))
        if isinstance(value, (tuple, list)):
            words.append((":" if isinstance(value, tuple) else ",").join(map(str, value)))
        elif value is not True:
            words.append(value)
    return words


def printed(columns, options):
    return simulator(recording(columns), *words_of(options))


def streamed(x, gaps=(), cuts=(), **options):
    """The results of a stream that gets x in blocks, with gaps between some."""
    stream, pieces = davar.Stream(RATE_HZ, **options), []
    for first, block in zip([0, *gaps, *cuts], np.split(x, [*gaps, *cuts])):
        if first in gaps:
            stream.gap()
        waiting = stream.push(block)
        pieces.append(stream.results())
        assert waiting == len(pieces[-1].epoch)
    stream.finish()
    pieces.append(stream.results())
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


LIMITS = {"kurtosis": (2.6, 3.2), "contribution": (0, 0.05), "window_max": 300, "grow": 0}
ALARMS = {"false_alarms_per_hour": 0.5, "cut_interval": 60, "block": 8, "shock_blocks": 1}


@pytest.mark.parametrize(
    "options",
    (
        {},
        {"law": "fixed", "window_max": 500, "stride": 7},
        {"law": "kurtosis", "mode": "trailing", "details": True},
        {"law": "and", **LIMITS},
        {"law": "glr", "stride": 10, **ALARMS},
        {"arith": "float"},
        {"arith": "float", "full_scale": 2.0, "clusters": [1, 3, 9, 27]},
        {"taus": "geometric:9", "shrink": 0},
        {"engine": "grid", "stride": 10, "mode": "trailing"},
        {"bandwidth": 40, "stride": 10, "details": True},
        {"bandwidth": "20:1:5+average:2", "stride": 10},
        {"bandwidth": "none", "stride": 10},
        {"law": "glr", "stride": 10, "bandwidth": 20},
        {"law": "kurtosis", "unstable_rate": 0.02, "bandwidth": "20:1"},
        {"longest_tau_s": 9, "stride": 10, "details": True},
        {"longest_tau_s": 9, "stride": 10, "law": "glr", "clusters": [1, 5, 31]},
        {"longest_tau_s": 6.5, "stride": 10, "arith": "float", "bandwidth": 40},
        {"floor": True, "bandwidth": "none", "law": "fixed"},
        {"floor": True, "bandwidth": "biquad:40", "stride": 7, "mode": "trailing"},
    ),
)
def test_rates_with_every_law_and_mode(options):
    x = noise(1)
    found = davar.dynamic(x, RATE_HZ, **options)
    expect_printed(found, printed({"gyro_z_dps": x}, {"rate": RATE_HZ, **options}))


@pytest.mark.parametrize("details", ({}, {"details": True}))
def test_an_error_model(elsewhere, details):
    x = noise(13)
    Path("table.csv").write_text(
        "m,adev_dps,relative_tolerance,tau_s\n1,0.2,0.02,0.01\n4,0.1,0.02,0.04\n"
        "5,0.1,0.02,0.05\n128,0.02,0.1,1.28\n"
    )
    options = {"model_table": "table.csv", "stride": 10, "longest_tau_s": 5, **details}
    found = davar.dynamic(x, RATE_HZ, **options | {"model_table": Path("table.csv")})
    expect_printed(found, printed({"gyro_z_dps": x}, {"rate": RATE_HZ, **options}))


@pytest.mark.parametrize("bits, factor", ((16, 1), (24, 1), (24, 1000), (32, 100_000)))
def test_counts(bits, factor):
    counts = counts_of(2, np.int32) * factor
    options = {"lsb": 0.01, "bits": bits, "stride": 10, "longest_tau_s": 9}
    found = davar.dynamic(counts, RATE_HZ, **options)
    expect_printed(found, printed({"gyro_z_counts": counts}, {"rate": RATE_HZ, **options}))


def test_time_stamps_and_their_gaps():
    x, time_s = noise(3), np.arange(4000) / RATE_HZ + 1000
    time_s[1500:] += 0.5
    time_s[1502:] += 0.02
    time_s[3000:] += 77.7
    columns = {"time_s": time_s, "gyro_z_dps": x}
    options = {"stride": 9, "details": True, "longest_tau_s": 5.2}
    expect_printed(davar.dynamic(x, time_s=time_s, **options), printed(columns, options))
    options = {"stride": 9, "floor": True, "bandwidth": "none"}
    expect_printed(davar.dynamic(x, time_s=time_s, **options), printed(columns, options))
    options = {"gap": 3.5, "mode": "trailing"}
    found = davar.dynamic(x, RATE_HZ, time_s=time_s, **options)
    expect_printed(found, printed(columns, {"rate": RATE_HZ, **options}))


def moved(rows, places):
    """Rows of davar-sim whose epochs count only the samples at these places."""
    return rows | {"epoch": [str(places[int(epoch)]) for epoch in rows["epoch"]]}


def test_a_missing_sample_is_a_gap_in_the_time_stamps():
    x, there = noise(4), np.ones(4000, bool)
    there[[0, 700, 701, 2000, 3999]] = False
    time_s = np.arange(4000) / 128.0  # a double represents this period exactly
    found = davar.dynamic(np.where(there, x, np.nan), 128.0, details=True)
    rows = printed({"time_s": time_s[there], "gyro_z_dps": x[there]}, {"details": True})
    expect_printed(found, moved(rows, np.flatnonzero(there)))
    listed = davar.dynamic(x[there], 128.0, gaps=[699, 1997], details=True)
    for name in set(found) - {"epoch", "time_s"}:
        np.testing.assert_array_equal(listed[name], found[name], name)


def test_a_learned_filter():
    x = np.convolve(np.random.default_rng(5).normal(0, 0.4, 20_001), (0.5, 0.5), "valid")
    time_s = np.arange(20_000) / 128.0
    time_s[9000:] += 1.0
    options = {"lsb": 0.001, "bandwidth": "auto", "stride": 100}
    found = davar.dynamic(x, time_s=time_s, **options)
    assert found.bandwidth == "average1:2"
    expect_printed(found, printed({"time_s": time_s, "gyro_z_dps": x}, options))
    with pytest.warns(UserWarning, match="withheld: the short cluster sizes read low"):
        short = davar.dynamic(x[:4000], 128.0, **options)
    assert short.bandwidth is None
    with pytest.warns(UserWarning, match="withheld: the short cluster sizes contradict"):
        found = davar.dynamic(x, 128.0, **options | {"bandwidth": "50:2:0"})
    assert found.filtered.mean() > 0.05


def test_the_old_name_of_the_law_still_works():
    new, old = (
        davar.dynamic(noise(12), RATE_HZ, stride=50, **{name: "glr"}) for name in ("law", "policy")
    )
    assert "alarm" in new
    assert list(new) == list(old)
    for name, values in new.items():
        np.testing.assert_array_equal(values, old[name])


@pytest.mark.parametrize("options", ({}, {"bandwidth": "auto"}, {"law": "glr", "stride": 10}))
def test_torn_reads(options):
    made = np.random.default_rng(6)
    time_s = np.arange(6000) / 128.0
    time_s[3000:] += 1.0
    counts = np.round(made.normal(-250, 3, 6000)).astype(np.int32)
    torn = np.arange(150, 6000, 371)
    counts[torn] += made.choice([-256, 256], len(torn))
    counts[[3000, 5999]] += 256  # beside a gap and at the end
    options = {"lsb": 0.01, "skip_torn_reads": True, **options}
    found = davar.dynamic(counts, time_s=time_s, **options)
    assert found.torn_reads == len(torn)
    rows = printed({"time_s": time_s, "gyro_z_counts": counts}, options)
    expect_printed(found, moved(rows, np.setdiff1d(np.arange(6000), torn)))
    assert davar.dynamic(counts, time_s=time_s, lsb=0.01).torn_reads == 0
    holes = counts * 0.01
    holes[torn] = np.nan
    found = davar.dynamic(counts * 0.01, time_s=time_s, **options)
    expect_equal(found, davar.dynamic(holes, time_s=time_s, **options | {"skip_torn_reads": False}))


# Options of davar-sim that are no arguments, and the reason.
OF_THE_PROGRAM = {
    "column": "x is the column",
    **dict.fromkeys(("can-base", "can-content", "raw"), "frames"),
    **dict.fromkeys(("out", "pace", "progress"), "arrays"),
    "baud": "a serial line",
    "device": "another program",
    "help": "help(davar.dynamic)",
    "version": "importlib.metadata",
}
# gaps are absent rows, clusters a form of --taus; a row of davar-sim is fitted
OF_PYTHON = {"x", "time_s", "gaps", "clusters", "taus_s", "fit_every"}
# gap is Stream.gap, arith lsb or full_scale; without torn reads each sample would come one later
NOT_OF_A_STREAM = {"gap", "arith", "skip_torn_reads"}


def test_every_option_is_an_argument():
    words = [os.environ["DAVAR_SIM"], "--help"]
    text = subprocess.run(words, text=True, capture_output=True, check=True).stdout
    text = text.split("\nExamples")[0]
    options = set(re.findall(r"(?:^  |, )--([a-z][a-z-]*)", text, re.MULTILINE))
    assert len(options) > 30 and set(OF_THE_PROGRAM) <= options
    renamed = {"rate": "rate_hz", "longest-tau": "longest_tau_s"}
    wanted = {renamed.get(name, name.replace("-", "_")) for name in options - set(OF_THE_PROGRAM)}
    assert set(inspect.signature(davar.dynamic).parameters) == wanted | OF_PYTHON
    wanted |= {"clusters", "taus_s", "fit_every"}
    assert set(inspect.signature(davar.Stream).parameters) == wanted - NOT_OF_A_STREAM


OF_A_FIT = ("arw_", "bi_", "rrw_", "rr_", "qn_", "filtered", "coarse", "flat_")
OF_A_FIT += ("adev_low", "adev_high")


@pytest.mark.parametrize(
    "x, options",
    (
        (noise(12), {}),
        (noise(13), {"law": "glr", "stride": 10, "details": True}),
        (noise(14), {"law": "fixed", "mode": "trailing", "details": True}),
        (counts_of(15), {"lsb": 0.01, "longest_tau_s": 8.0}),
    ),
)
def test_fewer_fits_change_no_other_value(x, options):
    every = davar.dynamic(x, RATE_HZ, **options)
    of_fit = [name for name in every if name.startswith(OF_A_FIT)]
    for n in (0, 1, 2, 10, 10**6):
        found = davar.dynamic(x, RATE_HZ, fit_every=n, **options)
        fitted = np.arange(len(every.epoch)) % n == 0 if n else False
        assert list(found) == [name for name in every if n or name not in of_fit]
        for name, column in found.items():
            absent = False if column.dtype == bool else np.nan
            wanted = np.where(fitted, every[name], absent) if name in of_fit else every[name]
            np.testing.assert_array_equal(column, wanted, name)


def test_withheld_results_are_compared_with_the_fitted_ones():
    smooth = np.convolve(np.random.default_rng(17).normal(0, 1, 4000), np.ones(4) / 4)
    with pytest.warns(UserWarning, match="of 31 results withheld"):
        found = davar.dynamic(smooth, RATE_HZ, law="fixed", mode="trailing", fit_every=120)
    assert len(found.epoch) == 120 * 30 + 4


def test_a_wrong_number_of_fits_is_an_error(tmp_path):
    for value in (-1, 0.5, True, 2**32):
        with pytest.raises(ValueError, match="^fit_every: "):
            davar.dynamic(noise(18), RATE_HZ, fit_every=value)
    table = tmp_path / "model.csv"
    table.write_text("m,adev_dps,relative_tolerance,tau_s\n1,0.2,0.02,0.01\n")
    with pytest.raises(ValueError, match="^fit_every: .* model_table"):
        davar.Stream(RATE_HZ, lsb=0.01, fit_every=2, model_table=table)


def expect_streamed(x, gaps=(), **options):
    """A complete record of counts with a fixed window is computed at once; a stream never is."""
    found, wanted = davar.dynamic(x, RATE_HZ, gaps=gaps, **options), streamed(x, gaps, **options)
    assert list(found) == list(wanted)
    assert all(found[name].dtype == column.dtype for name, column in wanted.items())
    expect_equal(found, wanted)


@pytest.mark.parametrize("seed", range(40))
def test_any_window_gives_the_results_of_a_stream(seed):
    draw = np.random.default_rng([19, seed])
    longest = 2 * int(draw.integers(2, 400))
    shortest = 2 * int(draw.integers(1, longest // 2 + 1))
    shortest = shortest if draw.random() < 0.7 else longest
    count = int(draw.integers(longest, longest + 3000))
    x = draw.normal(draw.normal(0, 3000), draw.choice([0.3, 20, 4000]), count)
    x[count // 2 :] *= draw.choice([0, 1, 5])  # stuck, unchanged or louder
    gaps = np.sort(draw.choice(np.arange(1, count), draw.choice([0, 1, 9, count // 7]), False))
    expect_streamed(
        np.rint(x).clip(-(2**15), 2**15 - 1).astype(int),
        gaps,
        lsb=float(draw.choice([0.01, 2.0**-7, 1.0])),
        bits=int(draw.choice([16, 24])),
        law="fixed",
        segment=0,
        mode=str(draw.choice(["trailing", "centred"])),
        window_max=longest,
        window_min=shortest,
        clusters=np.unique(draw.integers(1, shortest // 2 + 1, 6)),
        details=bool(draw.integers(2)),
        fit_every=int(draw.choice([0, 1, 2, 7, 1000])),
    )


FIXED = {"law": "fixed", "mode": "trailing"}


# 968 000 is the largest for which every sum of squares has 63 bits.
@pytest.mark.parametrize("largest", (2**15 - 1, 968_000, 970_000, 2**23 - 1, 2**29, 2**31 - 2))
def test_the_ends_of_the_range_and_of_a_sum(largest):
    options = {"segment": 0, "lsb": 0.5, "details": True, **FIXED}
    alternate = np.where(np.arange(3000) % 128 < 64, largest, -largest)
    bits = 16 if largest < 2**15 else 24 if largest < 2**23 else 32
    expect_streamed(alternate, bits=bits, clusters=[1, 64], **options)
    expect_streamed(np.full(3000, -(2**15)), bits=16, **options)


def test_what_is_not_computed_at_once_is_the_same():
    x = counts_of(20)
    expect_streamed(x, lsb=0.01, **FIXED)
    expect_streamed(x, lsb=0.01, stride=3, segment=0, **FIXED)
    expect_streamed(x, lsb=0.01, longest_tau_s=8.0, segment=0, **FIXED)
    for holes in ([0, 1, -1], [0, 1, 1000, -1]):
        rates = x * 0.01
        rates[holes] = np.nan
        expect_streamed(rates, lsb=0.01, segment=0, **FIXED)
        expect_streamed(rates, lsb=0.01, segment=0, floor=True, bandwidth="none", **FIXED)


def with_holes():
    x = noise(6)
    x[[5, 900, 901, 902, 2500]] = np.nan
    return x


@pytest.mark.parametrize(
    "options",
    ({}, {"mode": "trailing", "stride": 13}, {"law": "glr", "stride": 10}, {"fit_every": 7}),
)
@pytest.mark.parametrize("x", (counts_of(5), with_holes()))
def test_any_blocks_give_the_results_of_one_call(x, options):
    cuts = np.sort(np.random.default_rng(7).integers(0, len(x), 60))
    whole = davar.dynamic(x, RATE_HZ, lsb=0.01, **options)
    expect_equal(streamed(x, cuts=cuts, lsb=0.01, **options), whole)


def test_blocks_of_floats():
    x, cuts = noise(8), np.sort(np.random.default_rng(9).integers(0, 4000, 60))
    whole = davar.dynamic(x, RATE_HZ, arith="float", full_scale=4.0, details=True)
    expect_equal(streamed(x, cuts=cuts, full_scale=4.0, details=True), whole)


def test_a_gap_that_is_told():
    counts, stream = counts_of(10), davar.Stream(RATE_HZ, lsb=0.01)
    stream.push(counts[:1500])
    stream.gap(3)
    stream.gap(2)
    stream.push(counts[1500:])
    stream.finish()
    expect_equal(stream.results(), davar.dynamic(counts, RATE_HZ, lsb=0.01, gaps=[1500]))
    assert (stream.health["gaps"], stream.health["missing"]) == (1, 5)


def test_a_rejected_block_leaves_the_stream_unchanged():
    counts, stream = counts_of(11), davar.Stream(RATE_HZ, lsb=0.01, bits=16)
    stream.push(counts[:2000])
    wrong = r"^x: value outside the count range.* at sample 1, found 40000"
    with pytest.raises(ValueError, match=wrong):
        stream.push([1, 40_000])
    stream.push(counts[2000:])
    stream.finish()
    expect_equal(stream.results(), davar.dynamic(counts, RATE_HZ, lsb=0.01, bits=16))
