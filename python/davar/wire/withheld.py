"""Why a result has no angle random walk, in words, for `davarlab live` and the page.

The reasons are those of davar_noise_t, as tools/davar.dbc names them. davar-sim reports the same on
standard error (host_sim/output/report.c)."""

from collections import Counter

REASONS = {
    "mixed": "white noise cannot be separated from the other noise of the window, a drift for "
    "example. Use a longer window, and davar_fit where the firmware calls davar_fit_white",
    "constant": "no count changes: the noise is below one count, or the sensor is stuck. Check the "
    "sensor, or use a finer count (a smaller range, or more bits)",
    "coarse": "the noise, or its step from sample to sample, is below half a count, so rounding "
    "hides the angle random walk. Use a "
    "finer count (a smaller range, or more bits). Content intervals also sends the upper limit",
    "filtered": "the short cluster sizes read low, as after a low-pass that is not declared, or "
    "they contradict the declared one. Give the gyro's bandwidth (data sheet: LPF, -3 dB) to the "
    "sender: --bandwidth HZ[:ORDER] (davar-sim, davar-node), or davar_filter_low_pass and "
    "davar_plan_init_filtered in firmware. davar-sim --bandwidth auto learns it from a recording "
    "at rest. For samples without a filter: --bandwidth none, or davar_plan_init_white",
}
# Chance withholds fewer than one result in so many; davar-sim has the same limit.
FEW = 20


class Explained:
    """Which reasons of one run of a sender have been explained."""

    def __init__(self) -> None:
        self.results = 0
        self.withheld: Counter[str] = Counter()
        self.done: set[str] = set()

    def add(self, reason: str | None) -> str | None:
        """Takes the reason of the next result; None: it has an angle random walk, or no reason was
        sent. Returns the sentence, once, when more results are withheld than by chance."""
        self.results += 1
        if reason is None:
            return None
        self.withheld[reason] += 1
        if reason in self.done or self.withheld[reason] * FEW <= self.results:
            return None
        self.done.add(reason)
        return f"no angle random walk ({reason}): {REASONS[reason]}"
