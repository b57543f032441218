"""davar.dynamic and davar.Stream give the output of davar-sim, digit by digit, and have its
options.
"""

import inspect
import os
import re
import subprocess
import unittest
from pathlib import Path

import allantools
import davar
import numpy as np
import together

RATE_HZ = 100.0


def noise(seed, count=4000):
    made = np.random.default_rng(seed)
    x = made.normal(0.3, 0.2, count)
    x[count // 2 : count // 2 + 300] *= 4
    return x + np.cumsum(made.normal(0, 1e-3, count))


class Same(unittest.TestCase):
    def expect(self, epochs, printed):
        self.assertEqual(list(epochs), list(printed))
        for name, column in epochs.items():
            self.assertEqual(together.as_text(name, column), printed[name], name)

    def test_rates_with_every_policy_and_mode(self):
        x = noise(1)
        for options in (
            {},
            {"policy": "fixed", "window_max": 500, "stride": 7},
            {"policy": "kurtosis", "mode": "trailing", "details": True},
            {
                "policy": "and",
                "kurtosis": (2.6, 3.2),
                "contribution": (0, 0.05),
                "window_max": 300,
                "grow": 0,
            },
            {
                "policy": "glr",
                "stride": 10,
                "false_alarms_per_hour": 0.5,
                "cut_interval": 60,
                "block": 8,
                "shock_blocks": 1,
            },
            {"arith": "float"},
            {"arith": "float", "full_scale": 2.0, "clusters": [1, 3, 9, 27]},
            {"taus": "geometric:9", "shrink": 0},
            {"engine": "grid", "stride": 10, "mode": "trailing"},
            {"policy": "glr", "stride": 10, "long_cluster": 80},
            {"bandwidth": 40, "stride": 10, "details": True},
            {"bandwidth": "20:1:5+average:2", "stride": 10},
            {"bandwidth": "none", "stride": 10},
            {"policy": "glr", "stride": 10, "bandwidth": 20},
            {"policy": "kurtosis", "unstable_rate": 0.02, "bandwidth": "20:1"},
            {"longest_tau_s": 9, "stride": 10, "details": True},
            {"longest_tau_s": 9, "stride": 10, "policy": "glr", "clusters": [1, 5, 31]},
            {"longest_tau_s": 6.5, "stride": 10, "arith": "float", "bandwidth": 40},
        ):
            with self.subTest(options):
                words = []
                for name, value in options.items():
                    pair = (
                        ":".join(map(str, value))
                        if isinstance(value, tuple)
                        else ",".join(map(str, value))
                        if isinstance(value, list)
                        else value
                    )
                    option = {"clusters": "taus", "longest_tau_s": "longest-tau"}.get(name, name)
                    words += [
                        "--" + option.replace("_", "-"),
                        *([] if value is True else [pair]),
                    ]
                self.expect(
                    davar.dynamic(x, RATE_HZ, **options),
                    together.simulator(
                        together.recording({"gyro_z_dps": x}), "--rate", RATE_HZ, *words
                    ),
                )

    def test_averaging_times_in_seconds(self):
        x = noise(12)
        found = davar.dynamic(x, RATE_HZ, taus_s=[0.01, 0.1, 0.301], stride=10)
        self.assertEqual(found.clusters.tolist(), [1, 10, 30])
        np.testing.assert_allclose(found.taus_s, [0.01, 0.1, 0.3], rtol=1e-15)
        self.expect(
            found,
            together.simulator(
                together.recording({"gyro_z_dps": x}),
                "--rate",
                RATE_HZ,
                "--taus",
                "1,10,30",
                "--stride",
                10,
            ),
        )

    def test_an_error_model(self):
        x = noise(13)
        with together.elsewhere():
            Path("table.csv").write_text(
                "m,adev_dps,relative_tolerance,tau_s\n1,0.2,0.02,0.01\n4,0.1,0.02,0.04\n5,0.1,0.02,0.05\n"
                "128,0.02,0.1,1.28\n"
            )
            for details in (False, True):
                self.expect(
                    davar.dynamic(
                        x,
                        RATE_HZ,
                        model_table=Path("table.csv"),
                        stride=10,
                        details=details,
                        longest_tau_s=5,
                    ),
                    together.simulator(
                        together.recording({"gyro_z_dps": x}),
                        "--rate",
                        RATE_HZ,
                        "--model-table",
                        "table.csv",
                        "--stride",
                        10,
                        "--longest-tau",
                        5,
                        *(["--details"] if details else []),
                    ),
                )

    def test_counts(self):
        counts = np.round(noise(2) / 0.01).astype(np.int32)
        for bits, factor in ((16, 1), (24, 1), (24, 1000), (32, 100_000)):
            with self.subTest(bits=bits, factor=factor):
                text = together.recording({"gyro_z_counts": counts * factor})
                self.expect(
                    davar.dynamic(
                        counts * factor, RATE_HZ, lsb=0.01, bits=bits, stride=10, longest_tau_s=9
                    ),
                    together.simulator(
                        text,
                        *("--rate", RATE_HZ, "--lsb", 0.01, "--bits", bits, "--stride", 10),
                        *("--longest-tau", 9),
                    ),
                )

    def test_time_stamps_and_their_gaps(self):
        x, time_s = noise(3), np.arange(4000) / RATE_HZ + 1000
        time_s[1500:] += 0.5
        time_s[1502:] += 0.02
        time_s[3000:] += 77.7
        text = together.recording({"time_s": time_s, "gyro_z_dps": x})
        self.expect(
            davar.dynamic(x, time_s=time_s, stride=9, details=True, longest_tau_s=5.2),
            together.simulator(text, "--stride", 9, "--details", "--longest-tau", 5.2),
        )
        self.expect(
            davar.dynamic(x, RATE_HZ, time_s=time_s, gap=3.5, mode="trailing"),
            together.simulator(text, "--rate", RATE_HZ, "--gap", 3.5, "--mode", "trailing"),
        )

    def test_a_missing_sample_is_a_gap_in_the_time_stamps(self):
        x, there = noise(4), np.ones(4000, bool)
        there[[0, 700, 701, 2000, 3999]] = False
        holes = np.where(there, x, np.nan)
        time_s = np.arange(4000) / 128.0  # a double represents this period exactly
        found = davar.dynamic(holes, 128.0, details=True)
        printed = together.simulator(
            together.recording({"time_s": time_s[there], "gyro_z_dps": x[there]}), "--details"
        )
        places = np.flatnonzero(there)
        printed["epoch"] = [str(places[int(epoch)]) for epoch in printed["epoch"]]
        self.expect(found, printed)
        listed = davar.dynamic(x[there], 128.0, gaps=[699, 1997], details=True)
        for name in set(found) - {"epoch", "time_s"}:
            np.testing.assert_array_equal(listed[name], found[name], name)

    def test_a_learned_filter(self):
        made = np.random.default_rng(5)
        x = np.convolve(made.normal(0, 0.4, 20_001), (0.5, 0.5), "valid")
        time_s = np.arange(20_000) / 128.0
        time_s[9000:] += 1.0
        found = davar.dynamic(x, time_s=time_s, lsb=0.001, bandwidth="auto", stride=100)
        self.assertEqual("average1:2", found.bandwidth)
        self.expect(
            found,
            together.simulator(
                together.recording({"time_s": time_s, "gyro_z_dps": x}),
                *("--lsb", 0.001, "--bandwidth", "auto", "--stride", 100),
            ),
        )
        with self.assertWarnsRegex(UserWarning, "withheld: the short cluster sizes read low"):
            short = davar.dynamic(x[:4000], 128.0, lsb=0.001, bandwidth="auto", stride=100)
        self.assertIsNone(short.bandwidth)
        with self.assertWarnsRegex(UserWarning, "withheld: the short cluster sizes contradict"):
            found = davar.dynamic(x, 128.0, lsb=0.001, bandwidth="50:2:0", stride=100)
        self.assertGreater(found.filtered.mean(), 0.05)

    def test_torn_reads(self):
        made = np.random.default_rng(6)
        time_s = np.arange(6000) / 128.0
        time_s[3000:] += 1.0
        counts = np.round(made.normal(-250, 3, 6000)).astype(np.int32)
        torn = np.arange(150, 6000, 371)
        counts[torn] += made.choice([-256, 256], len(torn))
        counts[[3000, 5999]] += 256  # beside a gap and at the end
        for options in ({}, {"bandwidth": "auto"}, {"policy": "glr", "stride": 10}):
            with self.subTest(options):
                found = davar.dynamic(
                    counts, time_s=time_s, lsb=0.01, skip_torn_reads=True, **options
                )
                self.assertEqual(len(torn), found.torn_reads)
                words = [word for name, value in options.items() for word in (f"--{name}", value)]
                printed = together.simulator(
                    together.recording({"time_s": time_s, "gyro_z_counts": counts}),
                    *("--lsb", 0.01, "--skip-torn-reads", *words),
                )
                places = np.setdiff1d(np.arange(6000), torn)
                printed["epoch"] = [str(places[int(epoch)]) for epoch in printed["epoch"]]
                self.expect(found, printed)
        whole = davar.dynamic(counts, time_s=time_s, lsb=0.01)
        self.assertEqual(0, whole.torn_reads)
        holes = counts.astype(float) * 0.01
        holes[torn] = np.nan
        missing = davar.dynamic(holes, time_s=time_s, lsb=0.01)
        found = davar.dynamic(counts * 0.01, time_s=time_s, lsb=0.01, skip_torn_reads=True)
        for name, column in missing.items():
            np.testing.assert_array_equal(found[name], column, name)


class Options(unittest.TestCase):
    """Every option of davar-sim --help is an argument, or is listed here with a reason; and every
    argument is an option.
    """

    renamed = {"rate": "rate_hz", "longest-tau": "longest_tau_s"}
    of_the_program = {
        "column": "x is the column",
        "out": "arrays",
        "can-base": "frames",
        "can-content": "frames",
        "raw": "frames",
        "baud": "a serial line",
        "device": "another program",
        "pace": "arrays",
        "progress": "arrays",
        "help": "help(davar.dynamic)",
        "version": "importlib.metadata",
    }
    of_python = {
        "x",
        "time_s",
        "gaps",
        "clusters",
        "taus_s",
        "fit_every",
    }  # gaps are absent rows, clusters a form of --taus; a row of davar-sim is fitted
    not_of_a_stream = {
        "gap": "Stream.gap",
        "arith": "lsb or full_scale",
        "skip_torn_reads": "each sample would come one later",
    }

    def options(self):
        text = subprocess.run(
            [os.environ["DAVAR_SIM"], "--help"], text=True, capture_output=True, check=True
        ).stdout
        return set(
            re.findall(r"(?:^  |, )--([a-z][a-z-]*)", text.split("\nExamples")[0], re.MULTILINE)
        )

    def test_every_option_is_an_argument(self):
        options = self.options()
        self.assertGreater(len(options), 30)
        self.assertLessEqual(set(self.of_the_program), options)
        wanted = {
            self.renamed.get(name, name.replace("-", "_"))
            for name in options - set(self.of_the_program)
        }
        self.assertEqual(set(inspect.signature(davar.dynamic).parameters), wanted | self.of_python)
        self.assertLessEqual(set(self.not_of_a_stream), wanted)
        self.assertEqual(
            set(inspect.signature(davar.Stream).parameters),
            (wanted | {"clusters", "taus_s", "fit_every"}) - set(self.not_of_a_stream),
        )


class Fits(unittest.TestCase):
    of_fit = ("arw_", "bi_", "rrw_", "rr_", "qn_", "filtered", "coarse", "adev_low", "adev_high")

    def test_fewer_fits_change_no_other_value(self):
        for x, options in (
            (noise(12), {}),
            (noise(13), {"policy": "glr", "stride": 10, "details": True}),
            (noise(14), {"policy": "fixed", "mode": "trailing", "details": True}),
            (np.round(noise(15) / 0.01).astype(np.int16), {"lsb": 0.01, "longest_tau_s": 8.0}),
        ):
            every = davar.dynamic(x, RATE_HZ, **options)
            for n in (0, 1, 2, 10, 10**6):
                with self.subTest(options, fit_every=n):
                    self.compare(davar.dynamic(x, RATE_HZ, fit_every=n, **options), every, n)

    def compare(self, found, every, n):
        fitted = np.arange(len(every.epoch)) % n == 0 if n else False
        of_fit = [name for name in every if name.startswith(self.of_fit)]
        self.assertEqual(list(found), [name for name in every if n or name not in of_fit])
        for name, column in found.items():
            if name in of_fit:
                absent = False if column.dtype == bool else np.nan
                np.testing.assert_array_equal(column, np.where(fitted, every[name], absent), name)
            else:
                np.testing.assert_array_equal(column, every[name], name)

    def test_blocks_of_a_stream_do_not_move_them(self):
        x = noise(16)
        whole = davar.dynamic(x, RATE_HZ, lsb=0.01, fit_every=7)
        stream, pieces = davar.Stream(RATE_HZ, lsb=0.01, fit_every=7), []
        for block in np.array_split(x, 90):
            stream.push(block)
            pieces.append(stream.results())
        stream.finish()
        pieces.append(stream.results())
        for name, column in whole.items():
            np.testing.assert_array_equal(np.concatenate([p[name] for p in pieces]), column, name)

    def test_withheld_results_are_compared_with_the_fitted_ones(self):
        smooth = np.convolve(np.random.default_rng(17).normal(0, 1, 4000), np.ones(4) / 4)
        with self.assertWarnsRegex(UserWarning, "of 31 results withheld"):
            found = davar.dynamic(smooth, RATE_HZ, policy="fixed", mode="trailing", fit_every=120)
        self.assertEqual(len(found.epoch), 120 * 30 + 4)

    def test_a_wrong_number_is_an_error(self):
        for value in (-1, 0.5, True, 2**32):
            with self.assertRaisesRegex(ValueError, "^fit_every: "):
                davar.dynamic(noise(18), RATE_HZ, fit_every=value)
        with self.assertRaisesRegex(ValueError, "^fit_every: .* model_table"):
            davar.Stream(RATE_HZ, lsb=0.01, fit_every=2, model_table=self.model())

    def model(self):
        folder = self.enterContext(together.elsewhere())
        (folder / "model.csv").write_text("m,adev_dps,relative_tolerance,tau_s\n1,0.2,0.02,0.01\n")
        return folder / "model.csv"


class Records(unittest.TestCase):
    """A complete record of counts with a fixed window is computed at once; a stream never is."""

    def stream(self, x, **options):
        stream = davar.Stream(RATE_HZ, **options)
        stream.push(x)
        stream.finish()
        return stream.results()

    def expect(self, x, **options):
        found, wanted = davar.dynamic(x, RATE_HZ, **options), self.stream(x, **options)
        self.assertEqual(list(found), list(wanted))
        for name, column in wanted.items():
            self.assertEqual(found[name].dtype, column.dtype, name)
            np.testing.assert_array_equal(found[name], column, name)

    def test_any_window_gives_the_results_of_a_stream(self):
        draw = np.random.default_rng(19)
        for _ in range(40):
            longest = 2 * int(draw.integers(2, 400))
            shortest = 2 * int(draw.integers(1, longest // 2 + 1))
            shortest = shortest if draw.random() < 0.7 else longest
            sizes = np.unique(draw.integers(1, shortest // 2 + 1, 6))
            count = int(draw.integers(longest, longest + 3000))
            noise_counts = draw.normal(draw.normal(0, 3000), draw.choice([0.3, 20, 4000]), count)
            options = {
                "lsb": float(draw.choice([0.01, 2.0**-7, 1.0])),
                "bits": int(draw.choice([16, 24])),
                "policy": "fixed",
                "segment": 0,
                "mode": str(draw.choice(["trailing", "centred"])),
                "window_max": longest,
                "window_min": shortest,
                "clusters": sizes,
                "details": bool(draw.integers(2)),
                "fit_every": int(draw.choice([0, 1, 2, 7, 1000])),
            }
            with self.subTest(options):
                self.expect(np.rint(noise_counts).clip(-(2**15), 2**15 - 1).astype(int), **options)

    def test_the_ends_of_the_range_and_of_a_sum(self):
        options = {"policy": "fixed", "segment": 0, "mode": "trailing", "lsb": 0.5, "details": True}
        alternate = np.where(np.arange(3000) % 128 < 64, 1, -1)
        # 968 000 is the largest for which every sum of squares has 63 bits.
        for largest in (2**15 - 1, 968_000, 970_000, 2**23 - 1, 2**29, 2**31 - 2):
            bits = 16 if largest < 2**15 else 24 if largest < 2**23 else 32
            self.expect(alternate * largest, bits=bits, clusters=[1, 64], **options)
        self.expect(np.full(3000, -(2**15)), bits=16, **options)

    def test_what_is_not_computed_at_once_is_the_same(self):
        x = np.round(noise(20) / 0.01).astype(np.int16)
        options = {"policy": "fixed", "mode": "trailing", "lsb": 0.01}
        self.expect(x, **options)
        self.expect(x, stride=3, segment=0, **options)
        self.expect(x, longest_tau_s=8.0, segment=0, **options)
        holes = x.astype(float)
        holes[[0, 1, -1]] = np.nan
        self.expect(holes * 0.01, segment=0, **options)
        holes[1000] = np.nan
        self.expect(holes * 0.01, segment=0, **options)

    def test_allantools_agrees(self):
        x = np.round(noise(21, 3000) / 0.01).astype(np.int16)
        for window in (600, 2000):
            found = davar.dynamic(
                x,
                RATE_HZ,
                lsb=0.01,
                policy="fixed",
                segment=0,
                mode="trailing",
                window_max=window,
                window_min=window,
                fit_every=0,
            )
            self.assertEqual(found.epoch.tolist(), list(range(window - 1, 3000)))
            for row in range(0, len(found.epoch), 97):
                part = x[row : row + window] * 0.01
                expected = allantools.oadev(
                    part, rate=RATE_HZ, data_type="freq", taus=found.taus_s
                )[1]
                np.testing.assert_allclose(found.adev[row], expected, rtol=1e-9)


class Streamed(unittest.TestCase):
    def collect(self, stream, x, seed):
        cuts = np.sort(np.random.default_rng(seed).integers(0, len(x), 60))
        pieces = []
        for block in np.split(x, cuts):
            waiting = stream.push(block)
            pieces.append(stream.results())
            self.assertEqual(waiting, len(pieces[-1].epoch))
        stream.finish()
        pieces.append(stream.results())
        return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}

    def expect(self, found, whole):
        for name, column in whole.items():
            np.testing.assert_array_equal(found[name], column, name)

    def test_any_blocks_give_the_results_of_one_call(self):
        counts = np.round(noise(5) / 0.01).astype(np.int16)
        holes = np.round(noise(6) / 0.01)
        holes[[5, 900, 901, 902, 2500]] = np.nan
        for options in ({}, {"mode": "trailing", "stride": 13}, {"policy": "glr", "stride": 10}):
            for x in (counts, holes * 0.01):
                with self.subTest(options, kind=x.dtype):
                    self.expect(
                        self.collect(davar.Stream(RATE_HZ, lsb=0.01, **options), x, 7),
                        davar.dynamic(x, RATE_HZ, lsb=0.01, **options),
                    )

    def test_floats(self):
        x = noise(8)
        self.expect(
            self.collect(davar.Stream(RATE_HZ, full_scale=4.0, details=True), x, 9),
            davar.dynamic(x, RATE_HZ, arith="float", full_scale=4.0, details=True),
        )

    def test_a_gap_that_is_told(self):
        counts = np.round(noise(10) / 0.01).astype(np.int16)
        stream = davar.Stream(RATE_HZ, lsb=0.01)
        stream.push(counts[:1500])
        stream.gap(3)
        stream.gap(2)
        stream.push(counts[1500:])
        stream.finish()
        self.expect(stream.results(), davar.dynamic(counts, RATE_HZ, lsb=0.01, gaps=[1500]))
        self.assertEqual((stream.health["gaps"], stream.health["missing"]), (1, 5))

    def test_a_rejected_block_leaves_the_stream_unchanged(self):
        counts = np.round(noise(11) / 0.01).astype(np.int32)
        stream = davar.Stream(RATE_HZ, lsb=0.01, bits=16)
        stream.push(counts[:2000])
        with self.assertRaisesRegex(
            ValueError, r"^x: value outside the count range.* at sample 1, found 40000"
        ):
            stream.push([1, 40_000])
        stream.push(counts[2000:])
        stream.finish()
        self.expect(stream.results(), davar.dynamic(counts, RATE_HZ, lsb=0.01, bits=16))


if __name__ == "__main__":
    unittest.main()
