"""Wander, levels and steps of the bias."""

import numpy as np
from elsewhere import DEG, ar1


def telegraph_three_levels(bench):
    dwell, amplitude = bench.rng.uniform(6, 30), bench.rng.uniform(0.015, 0.03)
    visits = int(20 + 3 * bench.t[-1] / dwell)
    switches = np.cumsum(bench.rng.exponential(dwell, visits))
    level = (
        np.cumsum(np.concatenate([[0], bench.rng.integers(1, 3, visits)])) % 3 - 1
    )  # to one of the other two
    bench.slow += amplitude * level[np.searchsorted(switches, bench.t)]
    bench.hide("telegraph_noise", {"mean_dwell_s": dwell})


def telegraph(bench):
    dwell, amplitude = bench.rng.uniform(6, 30), bench.rng.uniform(0.012, 0.025)
    switches = np.cumsum(bench.rng.exponential(dwell, int(20 + 3 * bench.t[-1] / dwell)))
    bench.slow += amplitude * np.where(np.searchsorted(switches, bench.t) % 2, 1.0, -1.0)
    bench.hide("telegraph_noise", {"amplitude_dps": amplitude, "mean_dwell_s": dwell})


def gauss_markov(bench):
    std, time = bench.rng.uniform(0.006, 0.015), np.exp(bench.rng.uniform(np.log(2), np.log(30)))
    bench.slow += std * ar1(bench.count, np.exp(-1 / (bench.rate * time)), bench.rng)
    bench.hide("gauss_markov", {"std_dps": std, "correlation_time_s": time})


def random_walk(bench):
    k = bench.rng.uniform(40, 100)  # deg/h/sqrt(h)
    bench.slow += (
        np.cumsum(bench.rng.standard_normal(bench.count)) * k / DEG / 60 / np.sqrt(bench.rate)
    )
    bench.hide("rate_random_walk", {"coefficient_deg_per_h_per_sqrt_h": k})


def bias_step(bench):
    when, size = (
        bench.rng.uniform(0.15, 0.85) * bench.t[-1],
        bench.sign() * bench.rng.uniform(0.01, 0.03),
    )
    bench.slow += size * (bench.t >= when)
    bench.hide("bias_step", {"time_s": when, "step_dps": size})


def bias_steps(bench):
    for low, high in ((0.1, 0.35), (0.45, 0.6), (0.7, 0.9)):
        bench.slow += (
            bench.sign()
            * bench.rng.uniform(0.01, 0.03)
            * (bench.t >= bench.rng.uniform(low, high) * bench.t[-1])
        )
    bench.truth.groups.append({"bias_step"})
