"""davar.adev compared with published values, AllanTools, and the definition."""

import math
import unittest

import allantools
import davar
import numpy as np
import together

# NIST SP 1065 (Riley 2008), table 31: 1000 points, overlapping Allan deviation at tau 1, 10, 100 s;
# table 30: 9 points, tau 1, 2 s.
POINTS_1000 = {1: "2.922319e-01", 10: "9.159953e-02", 100: "3.241343e-02"}
POINTS_9 = {1: "91.22945", 2: "85.95287"}
NINE = np.array([892.0, 809, 823, 798, 671, 644, 883, 903, 677])


def by_definition(x, m, gaps=()):
    """(deviation, differences) of x. No difference may contain NaN or span a gap."""
    squares = []
    for i in range(len(x) - 2 * m + 1):
        part = x[i : i + 2 * m]
        if not np.isnan(part).any() and not any(i < gap < i + 2 * m for gap in gaps):
            squares.append((part[m:].mean() - part[:m].mean()) ** 2)
    return (np.sqrt(np.mean(squares) / 2) if squares else np.nan), len(squares)


class Published(unittest.TestCase):
    def test_the_thousand_points(self):
        found = davar.adev(together.thousand_points(), 1.0, clusters=list(POINTS_1000))
        self.assertEqual([f"{value:.6e}" for value in found.adev], list(POINTS_1000.values()))
        self.assertEqual(found.n.tolist(), [999, 981, 801])
        self.assertEqual(found.taus_s.tolist(), [1, 10, 100])

    def test_the_nine_points(self):
        found = davar.adev(NINE, 1.0, clusters=list(POINTS_9))
        self.assertEqual([f"{value:.5f}" for value in found.adev], list(POINTS_9.values()))


class AllanTools(unittest.TestCase):
    def test_every_octave_and_count_of_differences(self):
        noise = np.random.default_rng(1)
        for name, x in {
            "white": noise.normal(0.3, 0.2, 20_001),
            "walk": np.cumsum(noise.normal(0, 1e-3, 20_000)) + 1e4,
            "clock": noise.normal(0, 1e-12, 5000),
        }.items():
            with self.subTest(name):
                found = davar.adev(x, 50.0)
                taus, expected, _, n = allantools.oadev(
                    x, rate=50.0, data_type="freq", taus=found.taus_s
                )
                np.testing.assert_allclose(found.taus_s, taus, rtol=1e-12)
                np.testing.assert_allclose(found.adev, expected, rtol=2e-8)
                np.testing.assert_array_equal(found.n, n)
                self.assertTrue(np.all((found.low < found.adev) & (found.adev < found.high)))

    def test_its_words_and_its_seconds_mean_the_same_here(self):
        x = np.random.default_rng(9).normal(0.3, 0.2, 3000)
        for rate_hz in (1.0, 50.0, 99.37):
            for taus in ("octave", "decade", "all"):
                with self.subTest(rate_hz=rate_hz, taus=taus):
                    found = davar.adev(x, rate_hz, taus=taus)
                    theirs = allantools.oadev(x, rate=rate_hz, data_type="freq", taus=taus)
                    there = (
                        theirs[0] * rate_hz < 3000 // 9 + 0.5
                    )  # AllanTools continues until one difference remains
                    np.testing.assert_allclose(found.taus_s, theirs[0][there], rtol=1e-12)
                    np.testing.assert_allclose(found.adev, theirs[1][there], rtol=2e-8)
                    np.testing.assert_array_equal(found.n, theirs[3][there])
            seconds = np.geomspace(1.2 / rate_hz, 1000 / rate_hz, 40)
            found, theirs = (
                davar.adev(x, rate_hz, taus_s=seconds),
                allantools.oadev(x, rate=rate_hz, data_type="freq", taus=seconds),
            )
            np.testing.assert_allclose(found.taus_s, theirs[0], rtol=1e-12)
            np.testing.assert_allclose(found.adev, theirs[1], rtol=2e-8)
        self.assertEqual(davar.adev(x, 50.0, taus_s=[1, 10]).taus_s.tolist(), [1, 10])
        np.testing.assert_array_equal(
            davar.adev(x, 50.0, clusters=[50, 500]), davar.adev(x, 50.0, taus_s=[1, 10])
        )

    def test_phase(self):
        noise = np.random.default_rng(10)
        for rate_hz in (1.0, 64.0, 12.5):
            phase = (
                np.cumsum(np.cumsum(noise.normal(0, 1e-9, 4000)) + noise.normal(0, 1e-8, 4000))
                / rate_hz
            )
            found = davar.adev(phase, rate_hz, data_type="phase")
            theirs = allantools.oadev(phase, rate=rate_hz, data_type="phase", taus=found.taus_s)
            np.testing.assert_allclose(found.adev, theirs[1], rtol=1e-7)
            np.testing.assert_array_equal(found.n, theirs[3])

    def test_dynamic_is_its_value_per_window(self):
        x = np.random.default_rng(2).normal(0.3, 0.2, 3000)
        epochs = davar.dynamic(
            x, 100.0, policy="fixed", mode="trailing", window_max=600, window_min=600, stride=97
        )
        for row, epoch in enumerate(epochs.epoch):
            expected = allantools.oadev(
                x[epoch - 599 : epoch + 1], rate=100.0, data_type="freq", taus=epochs.taus_s
            )[1]
            np.testing.assert_allclose(epochs.adev[row], expected, rtol=1e-7)
        self.assertEqual(epochs.epoch.tolist(), list(range(679 - 1, 3000, 97)))


class Definition(unittest.TestCase):
    sizes = (1, 2, 3, 7, 16, 50)

    def expect(self, found, x, gaps=(), rtol=1e-8):
        expected = [by_definition(x, m, gaps) for m in self.sizes]
        np.testing.assert_allclose(found.adev, [value for value, _ in expected], rtol=rtol)
        self.assertEqual(found.n.tolist(), [n for _, n in expected])

    def test_gaps_in_every_form(self):
        x = np.random.default_rng(3).normal(0, 1, 700)
        holes = x.copy()
        holes[[0, 100, 101, 102, 350, 699]] = np.nan
        self.expect(davar.adev(holes, 10.0, clusters=self.sizes), holes)
        self.expect(
            davar.adev(x, 10.0, clusters=self.sizes, gaps=[200, 201, 450]), x, [200, 201, 450]
        )
        time_s = np.arange(700) / 10.0
        time_s[300:] += 0.7
        self.expect(davar.adev(x, clusters=self.sizes, time_s=time_s), x, [300])
        self.expect(
            davar.adev(x, 10.0, clusters=self.sizes, gaps=[200], time_s=time_s), x, [200, 300]
        )
        self.expect(davar.adev(holes, 10.0, clusters=self.sizes, gaps=[101, 200]), holes, [200])

    def test_counts_are_exact_at_the_ends_of_their_range(self):
        counts = np.random.default_rng(4).choice([-(2**31), 2**31 - 1], 400)
        found = davar.adev(counts, 10.0, clusters=self.sizes, lsb=0.5)
        self.expect(found, counts * 0.5, rtol=1e-14)

    def test_long_records_have_every_bit_of_the_exact_sums(self):
        """Whole numbers without a limit, over many blocks, with gaps and sums above 64 bits."""
        draw = np.random.default_rng(12)
        sizes = [1, 2, 3, 64, 1000, 4095, 4096, 4097, 8192, 10_000, 15_000]
        for largest in (1, 2**15, 2**31, 2**41):
            for gaps in ([], [7, 8191, 8192, 8193]):
                counts = draw.integers(-largest, largest, 40_000, endpoint=True)
                counts[:200] = largest
                found = davar.adev(counts, 10.0, clusters=sizes, lsb=1.0, gaps=gaps)
                squares, number = [0] * len(sizes), [0] * len(sizes)
                for run in np.split(counts, gaps):
                    total = np.concatenate([[0], np.cumsum(run)])
                    for t, m in enumerate(sizes):
                        differences = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
                        squares[t] += sum(d * d for d in map(int, differences))
                        number[t] += max(len(differences), 0)
                self.assertEqual(found.n.tolist(), number)
                self.assertEqual(
                    found.adev.tolist(),
                    [
                        math.sqrt(float(s) / (2.0 * n)) / m
                        for s, n, m in zip(squares, number, sizes)
                    ],
                )

    def test_phase_is_the_rate_form_of_its_differences(self):
        noise = np.random.default_rng(11)
        phase = noise.integers(-1000, 1000, 700)
        time_s = np.arange(700) / 8.0
        time_s[400:] += 3
        for options in ({}, {"gaps": [300, 301]}, {"time_s": time_s}):
            given = {"rate_hz": 8.0, "clusters": self.sizes, **options}
            rates = np.diff(phase) * 8.0
            broken = [300, 301] if "gaps" in options else [400] if "time_s" in options else []
            rates[np.array(broken, int) - 1] = np.nan  # between two samples that are not neighbours
            wanted = davar.adev(rates, 8.0, clusters=self.sizes)
            self.expect(davar.adev(phase.astype(float), data_type="phase", **given), rates)
            for one, other in zip(
                davar.adev(phase.astype(float), data_type="phase", **given), wanted
            ):
                np.testing.assert_array_equal(one, other)
            self.expect(
                davar.adev(phase, data_type="phase", lsb=0.25, **given), rates * 0.25, rtol=1e-14
            )
        holes = phase.astype(float)
        holes[100] = np.nan
        self.expect(
            davar.adev(holes, 8.0, clusters=self.sizes, data_type="phase"), np.diff(holes) * 8.0
        )

    def test_only_gaps_give_no_values(self):
        found = davar.adev(np.arange(6.0), 1.0, clusters=[1, 2], gaps=[1, 2, 3, 4, 5])
        self.assertEqual(found.n.tolist(), [0, 0])
        self.assertTrue(np.isnan(found.adev).all() and np.isnan(found.low).all())

    def test_a_constant_has_no_kurtosis(self):
        self.assertEqual(davar.adev(np.full(100, 7.25), 1.0).adev.tolist(), [0.0] * 4)


class Intervals(unittest.TestCase):
    def test_as_davar_sim_gives_them_for_one_window(self):
        x = np.random.default_rng(5).normal(0, 1, 5000) + 0.1 * np.cumsum(
            np.random.default_rng(6).normal(0, 1, 5000)
        )
        found = davar.adev(x, 100.0)
        there = davar.dynamic(
            x,
            100.0,
            bandwidth="none",
            policy="fixed",
            mode="trailing",
            window_max=5000,
            window_min=5000,
            segment=0,
            grow=1,
            stride=5000,
            details=True,
        )
        for name, values in {
            "adev": found.adev,
            "adev_low": found.low,
            "adev_high": found.high,
            "differences": found.n,
        }.items():
            np.testing.assert_allclose(
                values, [there[f"{name}_{m}"][0] for m in there.clusters], rtol=1e-6
            )

    def test_of_more_sizes_than_one_fit_takes_cover_it_too(self):
        noise, inside = np.random.default_rng(12), []
        for _ in range(300):
            found = davar.adev(noise.normal(0, 1, 1000), 1.0, taus="all")
            truth = 1 / np.sqrt(found.taus_s)
            inside.append((found.low <= truth) & (truth <= found.high))
        share = np.mean(inside, axis=0)
        self.assertEqual(share.size, 111)
        self.assertTrue(
            np.all((share > 0.95 - 0.05) & (share < 0.95 + 0.05)), share
        )  # four of sqrt(0.95 0.05 / 300), for 111 sizes

    def test_cover_the_truth_in_white_noise(self):
        noise, inside = np.random.default_rng(7), []
        for _ in range(600):
            found = davar.adev(noise.normal(0, 1, 1000), 1.0)
            truth = 1 / np.sqrt(found.taus_s)
            inside.append((found.low <= truth) & (truth <= found.high))
        share = np.mean(inside, axis=0)
        self.assertTrue(
            np.all((share > 0.92) & (share < 0.98)), share
        )  # 0.95 within three of sqrt(0.95 0.05 / 600)


if __name__ == "__main__":
    unittest.main()
