"""An hour on an emulated Cortex-M0 beside AllanTools, from 10 ms to 5 min. week.py does the same
with a week, for docs/FIRMWARE.md.
"""

import unittest

import numpy as np
from curve import B, K, N, compare, counts_of, on_board

HOUR = 360_000  # samples
ALL_REMEMBERED_S = 3600 / 34  # from here on, a size has seen less than its memory holds


class Curve(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.chunks = list(counts_of(HOUR, 41))
        cls.row = on_board(cls.chunks, "cortex-m0", 600)
        cls.lines = compare(cls.row, np.concatenate(cls.chunks))

    def test_every_size_agrees_with_allantools(self):
        self.assertEqual(7 + 9, len(self.lines))
        self.assertAlmostEqual(327.68, self.lines[-1]["tau_s"])
        for line in self.lines:
            self.assertLess(abs(line["off"]), 2, line)

    def test_sizes_that_remember_the_hour_differ_by_their_hops_only(self):
        longest = [line for line in self.lines if line["tau_s"] >= ALL_REMEMBERED_S]
        self.assertEqual(2, len(longest))
        for line in longest:
            self.assertLess(abs(line["off"]), 0.4, line)

    def test_the_coefficients_are_true(self):
        low, high = (float(self.row[f"arw_{end}_deg_per_sqrt_h"]) for end in ("low", "high"))
        self.assertLess(0.95 * N, low)
        self.assertGreater(1.05 * N, high)
        if self.row["bi_deg_per_h"]:
            self.assertAlmostEqual(1, float(self.row["bi_deg_per_h"]) / B, delta=0.5)
        else:
            self.assertGreater(float(self.row["bi_upper_deg_per_h"]), 0.7 * B)
        if not self.row["rrw_deg_per_h_per_sqrt_h"]:
            self.assertGreater(float(self.row["rrw_upper_deg_per_h_per_sqrt_h"]), 0.7 * K)


if __name__ == "__main__":
    unittest.main()
