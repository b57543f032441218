"""What is in a record and no error of the sensor, on recordings made by formulas of this file."""

import os
import warnings
from dataclasses import replace
from pathlib import Path

import elsewhere
import lab_bench
import numpy as np
import pytest
from davarlab.data import clock, events, observations, recording
from davarlab.data.recording import Recording
from davarlab.diagnosis import fitting, improve
from davarlab.errors import BadInput
from davarlab.model import Model, Term

REAL = Path(
    os.environ.get("DAVAR_REAL_DATA", Path(__file__).resolve().parents[3] / "shared/data/real")
)
POSES = "xsens_mti_hand_poses.csv.gz"
RATE = 100.0
TIME = np.arange(40000) / RATE
GYROS = [f"gyro_{axis}_dps" for axis in "xyz"]
WHITE = "coefficient_deg_per_sqrt_h"
QUIET = (
    *("clean sum", "clean coarse lsb", "noise_step", "vibration_noise band", "shocks sample"),
    *("vibration_rectification band", "g_sensitivity band", "telegraph fast", "shocks ring"),
    *("sinusoid fan", "warm_up", "rate_random_walk", "quantization"),
)


def white(rate, n, column="gyro_x_dps"):
    return Model(rate, column, [Term("angle_random_walk", {WHITE: n})])


def still(seconds=400, seed=1, axes="xyz", sigma=0.1):
    """Three axes of white noise beside an accelerometer that stands still."""
    rng, count = np.random.default_rng(seed), int(seconds * RATE)
    columns = {f"gyro_{a}_dps": 0.3 + sigma * rng.standard_normal(count) for a in axes}
    columns |= {f"accel_{a}_g": (a == "z") + 0.003 * rng.standard_normal(count) for a in "xyz"}
    return columns


def said(columns, column="gyro_x_dps"):
    """(observations by kind, which samples are kept)."""
    made = Recording(columns, RATE)
    found = observations.find(made, column)
    return {entry.kind: entry for entry in found}, observations.kept(made, column, found)


def read(columns):
    """A recording with stamps, as from a file."""
    return recording.of_columns(columns, None, "r.csv", {}, 1)


def said_of(columns):
    return {entry.kind: entry for entry in observations.find(read(columns), "gyro_x_dps")}


def shaken(columns, start_s, stop_s, size_dps, size_g, rng):
    """The recording, moved by hand for a while: slow waves in every axis."""
    t = np.arange(len(columns["gyro_x_dps"])) / RATE
    ramp = np.clip((t - start_s) / 0.3, 0, 1) * np.clip((stop_s - t) / 0.3, 0, 1)
    for name in columns:
        size = size_dps if name.startswith("gyro") else size_g
        for f in rng.uniform(0.5, 4, 4):
            wave = np.sin(2 * np.pi * f * t + rng.uniform(0, 6))
            columns[name] = columns[name] + size / 2 * ramp * wave
    return (t > start_s) & (t < stop_s)


@pytest.mark.slow
def test_errors_of_the_sensor_are_not_motion():
    for case in QUIET:
        made = Recording(elsewhere.recording(case, 301), elsewhere.RATE)
        kinds = {entry.kind for entry in observations.find(made, "gyro_z_dps")}
        assert not kinds & {"motion", "repeated_samples"}, case


def test_a_turn_is_cut_out_and_little_beside_it():
    columns = still()
    columns["gyro_z_dps"] += 15 * np.exp(-0.5 * ((TIME - 200) / 0.7) ** 2)
    found, kept = said(columns)
    ((start, stop),) = found["motion"].stretches
    assert 190 < start < 198 and 202 < stop < 210, (start, stop)
    assert abs(kept.mean() - (1 - (stop - start) / 400)) <= 1e-3


@pytest.mark.parametrize("felt", [0.15, 0.0])
def test_a_knock_that_the_accelerometer_felt_is_motion_and_one_that_it_did_not_is_none(felt):
    decay, columns = np.exp(-np.arange(80) / 20), still()
    for axis, size in zip("xyz", (1, -0.6, 0.8)):
        columns[f"gyro_{axis}_dps"][20000:20080] += size * 1.5 * decay * np.sin(np.arange(80))
        columns[f"accel_{axis}_g"][20000:20080] += felt * decay * np.cos(1.7 * np.arange(80))
    found, kept = said(columns)
    assert ("motion" in found) == (felt > 0)
    assert not (felt and kept[20002:20025].any())


def test_a_tilt_there_and_back_is_cut_out_whole():
    columns, t = still(seconds=4000), np.arange(400000) / RATE
    there, back = (np.exp(-0.5 * ((t - at) / 3) ** 2) for at in (1500, 1700))
    turn = 1.5 * (there - back) / (3 * np.sqrt(2 * np.pi))  # degrees per second
    columns["gyro_x_dps"] += turn
    columns["accel_y_g"] += np.sin(np.radians(np.cumsum(turn) / RATE))
    _, kept = said(columns)
    assert not kept[150000:170000].any()
    assert kept.mean() > 0.93


@pytest.mark.parametrize(
    "course",
    [
        0.5 * (TIME > 170),
        0.3 * np.sin(2 * np.pi * 7 * TIME) * ((TIME > 100) & (TIME < 180)),
        0.2 * (TIME > 90) * (TIME < 270),
    ],
    ids=["a step", "a machine for a while", "two steps"],
)
def test_what_moves_one_axis_only_is_no_motion_and_noise_of_any_size_is_nothing(course):
    columns = still()
    columns["gyro_x_dps"] += course
    assert "motion" not in said(columns)[0]
    for sigma in (0.1, 1.0, 5.0, 20.0):
        found, kept = said(still(60, 81, sigma=sigma))
        assert (set(found), kept.all()) == ({"implausible"} if sigma > 10 else set(), True), sigma


def test_touches_beside_each_other_and_the_pause_between_are_cut_out():
    for seed in (61, 62, 63):
        rng, columns = np.random.default_rng(seed), still(seed=seed)
        a = rng.uniform(100, 150)
        moving = shaken(columns, a, a + 18, 0.4, 0.01, rng)
        moving |= shaken(columns, a + 18.7, a + 33, 0.4, 0.01, rng)
        _, kept = said(columns)
        assert np.count_nonzero(kept & moving) / RATE < 0.5, seed
        assert np.count_nonzero(~kept) / RATE < 50, seed


def test_motion_is_the_same_in_every_unit_and_a_short_rest_counts_only_at_an_end():
    """Four seconds between two motions are excluded with them. Before the first and after the last,
    some of them are rest.
    """
    columns = still(seed=64)
    for start, stop in ((4, 30), (34, 60), (370, 396)):
        shaken(columns, start, stop, 5.0, 0.1, np.random.default_rng(start))
    _, kept = said(columns)
    assert kept[:150].all()
    assert kept[-150:].all()
    assert not kept[int(5 * RATE) : int(59 * RATE)].any()
    turned = {
        name.replace("_dps", "_rad_s"): course * (np.pi / 180 if "dps" in name else 1.0)
        for name, course in columns.items()
    }
    found, same = said(turned, "gyro_x_rad_s")
    assert "motion" in found
    assert (same == kept).all()
    counted = {
        name.replace("_dps", "_counts"): np.round(course * 65.5) if "dps" in name else course
        for name, course in columns.items()
    }
    found, same = said(counted, "accel_x_g")
    assert "motion" in found
    assert np.mean(same != said(columns, "accel_x_g")[1]) < 0.005


@pytest.mark.parametrize(
    "seed, seconds, start, rests",
    [(71, 25, 0, 0), (72, 25, 1, 0), (73, 200, 80, 0), (74, 200, 130, 1)],
)
def test_a_record_that_moves_most_of_the_time_is_refused(seed, seconds, start, rests):
    columns, model = still(seconds, seed), lab_bench.model(RATE, 0.6, 1.0, "gyro_x_dps")
    shaken(columns, start, seconds, 30, 0.2, np.random.default_rng(seed))
    made = Recording(columns, RATE, "r.csv")
    if rests:
        fitting.start(made, model)
    else:
        with pytest.raises(BadInput, match="not a recording at rest .*record again"):
            fitting.start(made, model)


@pytest.mark.skipif(not (REAL / POSES).exists(), reason=f"{POSES} is absent")
def test_hand_poses_are_no_recording_at_rest():
    made = recording.read(REAL / POSES)
    with pytest.raises(BadInput, match="moves in [56]. % of the recording"):
        fitting.start(made, white(made.rate_hz, 2.0))


@pytest.mark.parametrize("lsb, chance", [(0.0, 0.0), (0.01, 0.03)])
def test_repeats_are_found_and_their_share_is_right(lsb, chance):
    rng, columns = np.random.default_rng(3), still(axes="x")
    x = columns["gyro_x_dps"] if not lsb else np.round(columns["gyro_x_dps"] / lsb) * lsb
    again = rng.random(len(x)) < 0.1
    columns["gyro_x_dps"] = x[np.maximum.accumulate(np.where(again, 0, np.arange(len(x))))]
    found, kept = said(columns)
    assert abs(found["repeated_samples"].share - again.mean()) <= chance + 0.002
    assert not kept[1:][again[1:]].any()
    columns = still()
    for name in GYROS:
        columns[name][9::10] = columns[name][8::10]
    assert "every 10th" in said(columns)[0]["repeated_samples"].detail


def polled(own, rng, count, low, high):
    """(times of polls, by periods of the sensor, and which of its samples each reads)."""
    time = np.cumsum(rng.uniform(low, high, count)) / own
    return time, (time * own).astype(int)


def test_a_sensor_polled_unevenly_is_analysed_at_its_own_rate():
    """Each poll reads the newest sample of an even clock; no sample is missed."""
    rng = np.random.default_rng(4)
    for own in (31.7, 50.63, 77.1, 96.3):
        for longest in (0.6, 0.97):
            for digits in (3, 9):  # of the stamps
                time, at = polled(own, rng, 11250, 0.3, longest)
                y = 0.2 * rng.standard_normal((at[-1] + 2, 3))
                made = read({"time_s": np.round(time, digits), **dict(zip(GYROS, y[at].T))})
                assert abs(made.rate_hz / own - 1) <= 1e-3
                x = made.columns["gyro_x_dps"]
                np.testing.assert_allclose(x, y[at[0] : at[0] + len(x), 0], rtol=1e-6)


def test_a_grid_with_a_wrong_rate_is_never_adequate():
    """What was read is compared with the model by its stamps, whatever the grid was."""
    rng = np.random.default_rng(5)
    time, at = polled(50.63, rng, 60000, 0.4, 0.8)
    made = read({"time_s": time, "gyro_x_dps": 0.2 * rng.standard_normal(at[-1] + 2)[at]})
    for factor, adequate in ((1.0, True), (1.3, False), (0.8, False)):
        rate = factor * made.rate_hz
        other = replace(made, rate_hz=rate, clock=clock.Clock(rate), measured={})
        judged = fitting.judged(fitting.start(other, white(rate, 1.0))).judgement
        assert judged.adequate == adequate


def test_counts_by_themselves_are_no_repeats():
    for lsb, coarse in ((0.08, True), (0.02, False)):
        found, _ = said({name: np.round(x / lsb) * lsb for name, x in still().items()})
        assert ("coarse_counts" in found) == coarse
        assert "repeated_samples" not in found
    x = still(seconds=1200, axes="x")["gyro_x_dps"]
    for lsb in (1e-5, 2e-5, 1e-4):
        assert "repeated_samples" not in said({"gyro_x_dps": np.round(x / lsb) * lsb})[0], lsb


@pytest.mark.parametrize("size", [3.0, 2.56])
def test_clipping_and_lone_wild_samples(size):
    """Without counts they are not torn reads, whatever their size."""
    columns = still()
    columns["gyro_x_dps"] = np.clip(columns["gyro_x_dps"], None, 0.5)
    columns["gyro_x_dps"][[5000, 12345, 30000]] -= size
    found, kept = said(columns)
    assert set(found) == {"outliers", "clipped"}
    assert abs(found["outliers"].share * 40000 - 3) < 5e-8
    assert abs(found["clipped"].share - 0.02275) <= 0.003  # beyond two standard deviations
    assert not kept[12345]


def counted(rng, noise=3.0, count=12000):
    """Six axes in whole counts, of gyro and accelerometer."""
    names = [f"{kind}_{unit}" for kind in ("gyro", "accel") for unit in "xyz"]
    return {name: np.round(noise * rng.standard_normal(count)) for name in names}


def in_units(columns, gyro_q=0.00875, accel_q=0.000061):
    return {
        f"{name}_{'dps' if name[0] == 'g' else 'g'}": x * (gyro_q if name[0] == "g" else accel_q)
        for name, x in columns.items()
    }


def torn_in(columns):
    found = in_units(columns)
    return events.torn(found, np.ones(len(found["gyro_x_dps"]), bool))


def test_half_of_an_old_value_is_a_torn_read_and_nothing_else():
    for seed in range(10):
        rng = np.random.default_rng(seed)
        columns = counted(rng)
        at = 50 + 100 * rng.choice(118, 6, replace=False)
        signs = rng.choice([-1, 1], 6)
        for name in ("gyro_z", "accel_x"):
            columns[name][at] += 256 * signs
        for column in ("gyro_z_dps", "gyro_x_dps"):
            found, kept = said(in_units(columns), column)
            assert set(found) == {"torn_reads"}
            np.testing.assert_array_equal(np.flatnonzero(~kept), np.sort(at))
            text = found["torn_reads"].detail
            for words in (
                *("6 single samples jump", "gyro_z_dps 6 times by 256 counts"),
                *(f"at {at.min() / RATE:.6g}, ", "block data update"),
            ):
                assert words in text
    made = Recording(in_units(columns), RATE)
    judged = fitting.judged(fitting.start(made, model := white(RATE, 1.0, "gyro_z_dps")))
    assert [one.kind for one in judged.seen] == ["torn_reads"]
    assert judged.judgement.adequate
    assert judged.shocks.count == 0
    fitted = improve.fitted_model(judged, model)[0].terms[0].parameters[WHITE]
    assert abs(fitted / (60 * 3 * 0.00875 / np.sqrt(RATE)) - 1) <= 0.03


def test_one_jump_is_a_torn_read_only_if_it_is_far_beyond_the_noise():
    for size, times in ((8192, 1), (256, 0)):
        columns = counted(np.random.default_rng(1), noise=2.0)
        columns["gyro_y"][5000] -= size
        assert len(torn_in(columns)) == times, size


SHOCKS = {  # law of their sizes -> (draw, recordings of 150 that may be called torn)
    "student": (lambda rng, n: np.abs(rng.standard_t(2, n)), 5),
    "cauchy": (lambda rng, n: np.abs(rng.standard_cauchy(n)), 5),
    "pareto": (lambda rng, n: 1 + rng.pareto(1, n), 5),
    "lognormal": (lambda rng, n: np.exp(rng.standard_normal(n)), 5),
    "exponential": (lambda rng, n: rng.exponential(1, n), 5),
    "one size": (lambda rng, n: np.ones(n), 14),
}


@pytest.mark.slow
@pytest.mark.parametrize("law", SHOCKS)
def test_shocks_are_rarely_torn_reads(law):
    """Less than 1 % of recordings, of shocks of one size less than 10 % (DESIGN 13.5): of 150, by
    chance at most 5 (probability above 0.99)."""
    draw, most = SHOCKS[law]
    rng, called = np.random.default_rng([8, *law.encode()]), 0
    for _ in range(150):
        columns = counted(rng, rng.uniform(0.5, 8))
        at = rng.choice(12000, rng.integers(1, 40), replace=False)
        size = 10 ** rng.uniform(1.2, 4) * draw(rng, len(at)) * rng.choice([-1, 1], len(at))
        columns["gyro_x"] += np.round(np.bincount(at, size, 12000))
        if law != "one size":
            felt = size * rng.uniform(0.1, 1, len(at))
            columns["accel_z"] += np.round(np.bincount(at, felt, 12000))
        called += bool(torn_in(columns))
    assert called <= most


def test_nothing_that_a_file_may_hold_is_too_much():
    rng, t = np.random.default_rng(7), np.arange(1000) / RATE
    for x in (
        np.sin(2 * np.pi * 5 * t),
        20000 / 3600**2 * t,
        np.where(t < 5, rng.standard_normal(1000), 0.1),
        np.round(t),
        np.zeros(1000),
        np.where(t == 3, 1e6, 0),
        rng.standard_normal(1000) ** 9,
        np.arange(1000) % 2.0,
    ):
        noisy, dead = rng.standard_normal(1000), np.zeros(1000)
        for others in ({}, {"accel_x_g": noisy}, {"accel_x_g": dead, "gyro_y_dps": x}):
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                found, kept = said({"gyro_x_dps": x} | others)
            assert len(kept) == 1000
            assert all(np.isfinite(entry.share) and entry.detail for entry in found.values())


# Stamps: which samples are lost, and what the clock is.


def stamped(keep, jitter=0.0, seed=2):
    """A recording at RATE of which only some samples are there, with stamps that stray."""
    rng = np.random.default_rng(seed)
    time = np.arange(len(keep)) / RATE + jitter / RATE * rng.standard_normal(len(keep))
    time, y = np.maximum.accumulate(time - time[0]), rng.standard_normal(len(keep))
    return {"time_s": time[keep], "gyro_x_dps": y[keep]}


def test_lost_samples_keep_their_places():
    rng = np.random.default_rng(4)
    for share, jitter in ((0.03, 0), (0.03, 0.05), (0.5, 0)):
        keep = rng.random(20000) > share
        keep[0] = keep[-1] = True
        columns = stamped(keep, jitter)
        made = read(columns)
        np.testing.assert_array_equal(made.known, keep)
        np.testing.assert_allclose(made.columns["gyro_x_dps"][keep], columns["gyro_x_dps"])
        assert abs(made.rate_hz - RATE) <= 1e-3
        found = said_of(columns)
        assert abs(found["lost_samples"].share - (1 - keep.mean())) < 5e-10
    bursts = np.arange(20000) % 400 < 150
    made = read(stamped(bursts))
    np.testing.assert_array_equal(made.known, bursts[: made.samples])


def test_regular_blocks_are_named_with_what_to_do():
    rng, place = np.random.default_rng(8), (np.arange(3000)[:, None] * 24 + np.arange(4)).ravel()
    y = rng.standard_normal(len(place))
    detail = said_of({"time_s": place / RATE, "gyro_x_dps": y})["bursts"].detail
    for words in ("blocks of 4", "every 0.24 s", "4.17 per second", "FIFO"):
        assert words in detail
    assert "bursts" not in said_of(stamped(rng.random(20000) > 0.3))


def clock_of(time):
    return clock.analysed(clock.found(time, None, "r", 1), "r")


def test_gaps_that_recur_keep_their_length_however_many_samples_are_lost():
    rng = np.random.default_rng(7)
    for length, every in ((4, 24), (10, 100), (50, 1000)):
        start = np.arange(0, 200_000, every)
        start += length * (rng.random(len(start)) < 0.2)
        place = (start[:, None] + np.arange(length)).ravel()
        found = clock_of(place / RATE)
        assert found.cut == ()
        np.testing.assert_array_equal(found.places, place - place[0])
    place = (np.arange(400)[:, None] * 4000 + np.arange(10)).ravel()
    with pytest.raises(BadInput, match="r: column time_s: 399 gaps of up to 39.9 s"):
        clock_of(place / RATE)


def test_stamps_that_stray_lose_nothing():
    rng = np.random.default_rng(5)
    late = clock_of(np.sort(np.arange(20000) / RATE + rng.exponential(0.05, 20000)))
    assert (late.kind, late.places) == ("late", None)
    assert abs(late.rate_hz - RATE) <= 0.05
    assert clock_of(np.cumsum(rng.gamma(4, 0.25, 20000))).kind == "uneven"  # waits anew
    assert clock_of(np.round(np.arange(20000) / 58.3, 2)).places is None


def test_a_gap_of_a_fortnight_is_cut_short():
    time = np.arange(5000) / RATE
    time[2500:] += 1.2e6
    found = clock_of(time)
    assert found.places[-1] <= 4 * 5000
    ((_, seconds),) = found.cut
    assert abs(found.places[-1] / RATE + seconds - time[-1]) <= 0.02
