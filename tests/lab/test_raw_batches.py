"""Raw samples that autopilots log in batches: the batch sampler of ArduPilot, with pauses between
its batches, and the FIFO of PX4. Each sample has its own time, and the noise comes out.
"""

import json
import struct

import numpy as np
import pytest
import writing_logs as writing
from asking import run, said
from davarlab.logs import formats

COUNTS_PER_RAD_S, COUNTS_PER_M_S2 = 939, 208  # 2000 deg/s and 16 g in 16 bits
ARW = 0.6  # deg/sqrt(h)
RATE_HZ, PER_BATCH, PAUSE_US = 1000, 1024, 2_400_000


def counts_of(rng, rate_hz, shape, counts_per_dps, arw=ARW):
    """White noise and a bias that is not whole in counts."""
    noise = arw / 60 * rate_hz**0.5 * rng.standard_normal(shape) + 0.37
    return np.round(noise * counts_per_dps)


def sampled(seed, count):
    """What the batch sampler logs by turns: the accelerometer and the gyro of two units, the second
    one turned around. The rate is 1001.5 Hz, so that no step is a whole number of us."""
    rng, found = np.random.default_rng(seed), []
    per_dps = COUNTS_PER_RAD_S * np.pi / 180
    for place in range(count):
        start = 3_000_000 + place * PAUSE_US
        for one in (0, 1):
            force = np.round(rng.normal([[0.0], [0.0], [9.8]], 0.05, (3, 256)) * COUNTS_PER_M_S2)
            gyro = counts_of(rng, 1001.5, (3, PER_BATCH), per_dps * (1 - 2 * one))
            found += [
                (0, one, COUNTS_PER_M_S2, start + one * 7, 500.0, force),
                (1, one, COUNTS_PER_RAD_S, start + 600_000 + one * 7, 1001.5, gyro),
            ]
    return found


def check_noise(found):
    """Every model fits, and its ARW is the one of the sensor."""
    assert list(found["fits"].values()) == [True] * 3
    for name in (*(f"gyro_{axis}_dps" for axis in "xyz"), "gyro pooled"):
        assert abs(found["axes"][name]["ARW [deg/sqrt(h)]"]["value"] / ARW - 1) < 0.03, name


def of(found, kind, one):
    return [batch for batch in found if batch[:2] == (kind, one)]


def test_the_sensors_of_the_batch_sampler_are_listed_and_read(logs):
    log, found = logs.work / "log.bin", sampled(1, 3)
    writing.batches(log, found)
    listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
    assert [(one["name"], one["gives"], one["samples"]) for one in listed] == [
        ("ISB_ACC:0", ["accel"], 768),
        ("ISB_ACC:1", ["accel"], 768),
        ("ISB_GYR:0", ["gyro"], 3 * PER_BATCH),
        ("ISB_GYR:1", ["gyro"], 3 * PER_BATCH),
    ]
    logs.rejected(log, "--sensor", "ISB_GYR:0 (gyro", "ISB_GYR:1 (gyro")
    for one in (0, 1):
        columns = logs.imported(log, "--sensor", f"ISB_GYR:{one}")[1]
        assert list(columns) == ["time_s", *(f"gyro_{axis}_dps" for axis in "xyz")]
        batches = of(found, 1, one)
        ns = [us * 1000 + np.round(np.arange(PER_BATCH) * 1e9 / 1001.5) for *_, us, _, _ in batches]
        logs.check_stamps(columns, np.concatenate(ns))
        for axis, name in enumerate("xyz"):
            rates = np.concatenate([batch[-1][axis] for batch in batches]) / COUNTS_PER_RAD_S
            np.testing.assert_allclose(
                np.float64(columns[f"gyro_{name}_dps"]), np.degrees(rates), rtol=1e-7, atol=1e-8
            )
    columns = logs.imported(log, "--sensor", "ISB_ACC:1")[1]
    assert abs(np.mean(np.float64(columns["accel_z_g"])) - 9.8 / 9.80665) < 0.002


def only_gyro(seed, rate_hz, count, pause_us):
    rng = np.random.default_rng(seed)
    per_dps = COUNTS_PER_RAD_S * np.pi / 180
    for place in range(count):
        counts = counts_of(rng, rate_hz, (3, PER_BATCH), per_dps)
        yield 1, 0, COUNTS_PER_RAD_S, 3_000_000 + place * pause_us, rate_hz, counts


# At 8 kHz, where three units take turns, 6 % of the time is known.
@pytest.mark.parametrize(
    "seed, rate_hz, count, pause_us",
    [
        (2, 1001.5, 16, PAUSE_US),
        pytest.param(3, 8000.0, 24, 2_000_000, marks=pytest.mark.slow),
        pytest.param(4, 8000.0, 60, 500_000, marks=pytest.mark.slow),
    ],
)
def test_the_noise_of_batches_is_that_of_the_sensor(seed, rate_hz, count, pause_us, logs):
    log = logs.work / "log.bin"
    writing.batches(log, list(only_gyro(seed, rate_hz, count, pause_us)))
    check_noise(said("imu", log, statuses=(0, 1)))
    assert abs(formats.read(log).rate_hz / rate_hz - 1) < 1e-5


def without_a_message(data, name):
    """A log that lost the third message of this kind."""
    mark = {"ISBH": b"\xa3\x95\x82", "ISBD": b"\xa3\x95\x83"}[name]
    size = {"ISBH": 31, "ISBD": 207}[name]
    place = data.index(mark)
    for _ in range(2):
        place = data.index(mark, place + size)
    return data[:place] + data[place + size :]


def test_few_batches_are_imported_and_an_analysis_says_what_to_log(logs):
    """Batches of 0.128 s, every 10.4 s: 1.3 % of a grid of 1.1 million."""
    rng, log = np.random.default_rng(8), logs.work / "log.bin"
    starts = [int(3e6 + 10.4e6 * place) for place in range(14)]
    counts = [counts_of(rng, 8000, (3, PER_BATCH), 16.4) for _ in starts]
    writing.batches(
        log, [(1, 2, COUNTS_PER_RAD_S, us, 8000.0, one) for us, one in zip(starts, counts)]
    )
    columns = logs.imported(log)[1]
    own = np.round(np.arange(PER_BATCH) * 1e9 / 8000)
    logs.check_stamps(columns, np.concatenate([us * 1000 + own for us in starts]))
    rates = np.degrees(np.concatenate(counts, axis=1)[0] / COUNTS_PER_RAD_S)
    np.testing.assert_allclose(np.float64(columns["gyro_x_dps"]), rates, rtol=1e-7, atol=1e-8)
    logs.refused("1.3 % of the samples", "imu", log)
    assert "INS_LOG_BAT_MASK" in run("imu", log).stderr


@pytest.mark.parametrize("name, lost", [("ISBD", 32), ("ISBH", PER_BATCH)])
def test_a_message_that_was_lost_is_a_gap(logs, name, lost):
    log = logs.work / "log.bin"
    writing.batches(log, of(sampled(3, 4), 1, 0))
    whole = logs.imported(log)[1]["time_s"]
    log.write_bytes(without_a_message(log.read_bytes(), name))
    found = logs.imported(log)[1]["time_s"]
    assert set(found) < set(whole)
    assert len(whole) - len(found) == lost


def test_a_batch_without_a_rate_or_with_shorter_messages_is_rejected(logs):
    log, found = logs.work / "log.bin", of(sampled(4, 1), 1, 0)
    writing.batches(log, [(*batch[:4], 0.0, batch[-1]) for batch in found])
    logs.rejected(log, "ISB_GYR:0: smp_rate or mul")
    writing.batches(log, found)
    head = struct.pack("<BBHH", 1, 0, COUNTS_PER_RAD_S, PER_BATCH)
    shorter = struct.pack("<BBHH", 1, 0, COUNTS_PER_RAD_S, PER_BATCH // 2)
    log.write_bytes(log.read_bytes().replace(head, shorter))
    logs.rejected(log, "INS_LOG_BAT_LGCT = 32")


def test_each_sample_of_a_fifo_of_px4_has_its_time(logs):
    """Messages of 8, 9 and 7 samples, scale in rad/s per count."""
    rng, rate_hz, scale = np.random.default_rng(5), 2000.0, float(np.float32(np.pi / 180 / 16.4))
    counts = counts_of(rng, rate_hz, (3, 24_000), 16.4)
    log = logs.work / "log.ulg"
    writing.fifo(log, counts, rate_hz, scale, (8, 9, 7))
    listed = json.loads(run("import", log, "--list", "--json").stdout)["sensors"]
    assert [one["name"] for one in listed] == ["sensor_gyro_fifo:0"]
    columns = logs.imported(log)[1]
    logs.check_stamps(columns, 5_000_000_000 + np.arange(counts.shape[1]) * 500_000)
    for axis, name in enumerate("xyz"):
        np.testing.assert_allclose(
            np.float64(columns[f"gyro_{name}_dps"]), np.degrees(counts[axis] * scale), rtol=1e-7
        )
    check_noise(said("imu", log, statuses=(0, 1)))
    assert abs(formats.read(log).rate_hz / rate_hz - 1) < 1e-5
