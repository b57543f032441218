"""examples/betaflight in the real firmware: SITL on a virtual clock, its telemetry read by yamspy
and pymavlink. The true noise is that of the samples which the gyro gets.

Each bound is for the statistics of that many independent windows, and was set before the runs.
"""

import csv
import gzip
import io
import json
import math
import os
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
import pytest

import firmware

pytestmark = pytest.mark.soak

RATE_HZ = 8000
LSB_DPS = 2000 / 32800  # of Betaflight's virtual gyro
SIGMAS = np.array([8.0, 12.0, 16.0])  # counts of each axis
ARW = 60 * SIGMAS * LSB_DPS / math.sqrt(RATE_HZ)  # deg/sqrt(h)
POLL = 800  # periods between two requests over MSP: 0.1 s
POLL_S = POLL / RATE_HZ
STEP_S = 10  # from one change of the noise to the next
FULL_S, FULL_FILTERED_S = 1.5, 10.0  # until the windows are full
RESULTS, ALARMS = 6, 7  # in MSP_DEBUG
# In the CLI. The filters are Betaflight's defaults: a low-pass that follows the throttle, notches.
SETTINGS = ("serial UART2 512 115200 57600 0 115200", "set serial_update_rate_hz = 1000")


def noise(seed: int, factors: np.ndarray) -> np.ndarray:
    """Counts of three axes; factors: of each sample."""
    white = np.random.default_rng(seed).standard_normal((len(factors), 3))
    return np.rint(white * SIGMAS * factors[:, None]).astype("<i2")


def steady(seconds: int) -> np.ndarray:
    return np.ones(seconds * RATE_HZ)


def doublings(count: int) -> np.ndarray:
    """Noise that doubles and falls back again, `count` times."""
    return np.repeat(np.tile([1.0, 2.0], count), STEP_S * RATE_HZ)


PROGRAMS: dict[str, Path] = {}


def setUpModule():
    try:
        firmware.source()
    except firmware.Missing as why:
        raise unittest.SkipTest(str(why)) from None
    if subprocess.run(["unshare", "-rn", "true"], capture_output=True).returncode:
        raise unittest.SkipTest("unshare -rn is not permitted on this machine")
    PROGRAMS.update({plan: firmware.sitl(plan) for plan in ("off", *firmware.PLANS)})
    fly("set", "fixed", *SETTINGS)


def apart(*words, **variables):
    """Runs a command in a network of its own, because SITL listens on every interface."""
    done = subprocess.run(
        ["unshare", "-rn", *map(str, words)],
        cwd=firmware.WORK,
        env={**os.environ, **variables},
        text=True,
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def fly(verb, plan, *words):
    script = Path(__file__).with_name("fly.py")
    return apart(sys.executable, "-B", script, verb, PROGRAMS[plan], firmware.WORK, *words)


def record(samples):
    """A file of counts for the gyro."""
    counts = firmware.WORK / "counts.bin"
    samples.tofile(counts)
    return counts


def flight(plan, samples):
    """(MSP_DEBUG of every poll, {name: [seconds, value] of every MAVLink message})."""
    read = json.loads(fly("read", plan, record(samples), POLL))
    named = {}
    for seconds, name, value in read["mavlink"]:
        named.setdefault(name, []).append((seconds, value))
    return np.array(read["msp"]), {name: np.array(values) for name, values in named.items()}


def after(values, seconds):
    return values[values[:, 0] > seconds][:, 1]


def interval(mavlink, name, since):
    """Value, low and high where there is a value; the upper limit comes without one, too."""
    times, high = mavlink[name][:, 0], dict(mavlink[name + "_HI"])
    found = [after(mavlink[name + end], since) for end in ("", "_LO")]
    return [*found, np.array([high[one] for one in times[times > since]])]


class Steady(unittest.TestCase):
    """Ten minutes of white noise."""

    SECONDS = 600

    @classmethod
    def setUpClass(cls):
        cls.msp, cls.mavlink = flight("fixed", noise(11, steady(cls.SECONDS)))

    def interval(self, signal, axis, since):
        """Value, low and high of one axis in every message that has a value."""
        return interval(self.mavlink, f"{signal}_{'XYZ'[axis]}", since)

    def test_arw_over_msp_is_within_2_percent_rms(self):
        msp = self.msp[int(FULL_S / POLL_S) :, :3] / 1e3
        assert (msp > 0).mean() > 0.98
        for axis in range(3):
            error = msp[msp[:, axis] > 0, axis] / ARW[axis] - 1
            assert np.sqrt(np.mean(error**2)) < 0.02

    def test_arw_over_mavlink_is_within_2_percent_rms_and_in_its_interval(self):
        for axis in range(3):
            value, low, high = self.interval("ARW", axis, FULL_S)
            assert len(value) > 3 * self.SECONDS
            assert np.sqrt(np.mean((value / ARW[axis] - 1) ** 2)) < 0.02
            # 95 % of 680 independent windows, less three standard errors
            assert np.mean((low <= ARW[axis]) & (ARW[axis] <= high)) > 0.925

    def test_the_floor_is_the_noise_and_in_its_interval(self):
        for axis in range(3):
            value, low, high = self.interval("FLR", axis, FULL_S)
            assert len(value) > 3 * self.SECONDS
            assert abs(np.mean(value / ARW[axis]) - 1) < 0.04
            # 90 % of 580 independent windows, less three standard errors
            assert np.mean((low <= ARW[axis]) & (ARW[axis] <= high)) > 0.86
            shown = self.msp[int(FULL_S / POLL_S) :, 3 + axis] / 1e3
            assert np.mean(np.abs(shown / ARW[axis] - 1) < 0.35) > 0.99

    def test_filtered_arw_is_that_of_the_gyro_before_the_filters(self):
        means = []
        for axis in range(3):
            value, low, high = self.interval("ARWF", axis, FULL_FILTERED_S)
            assert len(value) > 2 * self.SECONDS
            means.append(np.mean(value / ARW[axis]) - 1)
            # 95 % of 74 independent windows, less three standard errors
            assert np.mean((low <= ARW[axis]) & (ARW[axis] <= high)) > 0.87
        # three standard errors of the mean of 3 x 74 independent windows
        assert abs(np.mean(means)) < 0.005

    def test_no_sample_is_lost(self):
        """A result of 888 samples each, in every poll."""
        expected = (np.arange(len(self.msp)) * POLL - 7104) // 888 + 1
        late = np.maximum(expected, 0) - self.msp[:, RESULTS]
        assert np.all((late == 0) | (late == 1)), late


class Doubled(unittest.TestCase):
    """The noise doubles and falls back every ten seconds."""

    COUNT = 6

    def ups(self, msp):
        """The first poll after each doubling, and the polls until it falls back."""
        polls = int(STEP_S / POLL_S)
        return [msp[start : start + polls] for start in range(polls, len(msp), 2 * polls)]

    def test_a_doubling_shows_within_1_1_seconds(self):
        msp, _ = flight("fixed", noise(12, doublings(self.COUNT)))
        # the poll of index i is i * POLL_S after the doubling
        shown = np.array([polls[int(1.1 / POLL_S), :3] / 1e3 for polls in self.ups(msp)])
        known = shown > 0  # one window in 60 is reported as mixed, with -1
        assert known.mean() > 0.8
        assert np.all((shown > 0.9 * 2 * ARW) | ~known), shown / ARW
        floors = np.array([polls[int(1.4 / POLL_S), 3:6] / 1e3 for polls in self.ups(msp)])
        assert np.all(floors > 0.75 * 2 * ARW), floors / ARW

    def test_an_alarm_within_half_a_second(self):
        msp, _ = flight("alarm", noise(13, doublings(self.COUNT)))
        for polls in self.ups(msp):
            raised = polls[int(0.5 / POLL_S), ALARMS] - polls[0, ALARMS]
            assert raised == 3  # one of each axis


FLOWN = Path(
    os.environ.get("DAVAR_FLIGHTS", firmware.ROOT.parent / "shared/data/flight"),
    "betaflight_hover_17s_1khz.csv.gz",
)


@unittest.skipUnless(FLOWN.exists(), f"{FLOWN.name} is absent")
class Flown(unittest.TestCase):
    """A real flight: the gyro of a hovering craft at 1 kHz, each sample held for eight periods."""

    def test_the_floor_is_there_where_arw_is_not(self):
        with gzip.open(FLOWN, "rt") as text:
            rows = [line for line in text if line[0] != "#"]
        rates = np.genfromtxt(rows[1:], delimiter=",")[:, 1:4]  # deg/s
        counts = np.rint(np.repeat(rates, 8, axis=0) / LSB_DPS).astype("<i2")
        msp, mavlink = flight("fixed", counts)
        flying = np.array([one.std() > 1 for one in np.array_split(rates[:, 0], len(msp))])
        flying[: int(FULL_S / POLL_S)] = False
        assert flying.sum() > 50
        assert (msp[flying][:, 3:6] > 0).mean() >= 0.95
        assert (msp[flying][:, :3] > 0).mean() < 0.1
        for axis, name in enumerate("XYZ"):
            value, low, high = interval(mavlink, f"FLR_{name}", FULL_S)
            assert np.all((low < value) & (value < high))
            done = self.simulated(rates[:, axis])
            assert abs(np.median(value) / np.median(done) - 1) < 0.25, (name, value, done)

    @staticmethod
    def simulated(rates):
        """The floors that davar-sim prints of the samples as they were recorded."""
        text = "gyro_x_counts\n" + "\n".join(str(int(one)) for one in np.rint(rates / LSB_DPS))
        words = [
            "--rate",
            1000,
            "--lsb",
            LSB_DPS,
            "--bandwidth",
            "none",
            "--floor",
            "--law",
            "fixed",
        ]
        done = subprocess.run(
            [str(firmware.ROOT / "tools/davar-sim"), "-", *map(str, words), "--stride", "256"],
            input=text,
            text=True,
            capture_output=True,
            check=True,
        )
        rows = csv.DictReader(io.StringIO(done.stdout))
        return [float(row["floor_deg_per_sqrt_h"]) for row in rows if row["floor_why"] == "0"]


class OtherRate(unittest.TestCase):
    def test_a_plan_for_another_sample_rate_gives_no_value(self):
        msp, mavlink = flight("other-rate", noise(16, steady(4)))
        since = msp[int(1 / POLL_S) :]  # before the first call of the task, debug is 0
        assert np.all(since[:, :6] == -1) and np.all(since[:, 6:] == 0), since
        assert list(mavlink) == ["ARW_ALARMS"]


class Motors(unittest.TestCase):
    def test_motor_outputs_are_identical_with_and_without_davar(self):
        """Armed for 18 s, in noise that doubles."""
        counts = record(noise(15, doublings(1)))
        outputs = []
        for plan in ("off", "fixed", "alarm"):
            motors = firmware.WORK / "motors.bin"
            apart(
                PROGRAMS[plan],
                "127.0.0.1",
                LOCKSTEP_COUNTS=str(counts),
                LOCKSTEP_MOTORS=str(motors),
            )
            outputs.append(motors.read_bytes())
        values = np.frombuffer(outputs[0], np.float32).reshape(-1, 4)
        assert len(values) == 2 * STEP_S * RATE_HZ
        assert values[3 * RATE_HZ :].std(axis=0).min() > 0.1
        assert outputs[0] == outputs[1]
        assert outputs[0] == outputs[2]


class Flash(unittest.TestCase):
    def test_arw_and_floor_take_less_than_26_kib_of_an_stm32f405(self):
        """It counts parts of libgcc that the firmware has anyway; `firmware.py image` does not."""
        assert firmware.added_flash() < 26 * 1024
