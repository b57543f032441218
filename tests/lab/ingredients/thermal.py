"""What the temperature does to the rate and its noise."""

import numpy as np
from heat import loop


def temperature(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.02)
    bench.slow += coefficient * (bench.temperature - 25)
    bench.hide("temperature", {"coefficient_dps_per_degC": coefficient})


def temperature_lag(bench):
    how = str(bench.rng.choice(["walk", "cycles", "chamber"]))
    bench.temperature = bench.celsius(how)
    coefficient, lag = bench.sign() * bench.rng.uniform(0.01, 0.02), bench.rng.uniform(45, 75)
    bench.slow += coefficient * (bench.lagged(bench.temperature, lag) - 25)
    bench.hide("temperature", {"coefficient_dps_per_degC": coefficient, "lag_s": lag})
    bench.truth.shape["temperature", "lag_s"] = (lag / 2.5, lag * 2.5)


def temperature_hysteresis(bench):
    bench.temperature = bench.celsius(str(bench.rng.choice(["walk", "cycles"])))
    width = bench.rng.uniform(0.15, 0.4) * np.ptp(bench.temperature)
    coefficient = bench.sign() * bench.rng.uniform(0.01, 0.02)
    every = np.arange(0, bench.count, int(bench.rate))
    felt = np.interp(bench.t, bench.t[every], loop(bench.temperature[every], width))
    bench.slow += coefficient * (felt - 25)
    bench.hide(
        "temperature_hysteresis", {"coefficient_dps_per_degC": coefficient, "width_degC": width}
    )


def temperature_squared(bench):
    coefficient = bench.sign() * bench.rng.uniform(0.0015, 0.004)
    bench.slow += coefficient * (bench.temperature - 25) ** 2
    bench.hide("temperature_squared", {"coefficient_dps_per_degC2": coefficient})
    bench.truth.extra.add("temperature")  # where the parabola has its vertex is a straight term


def temperature_noise(bench):
    bench.temperature = bench.celsius(
        str(bench.rng.choice(["walk", "cycles", "chamber", "warming"]))
    )
    kappa = bench.sign() * np.exp(bench.rng.uniform(np.log(0.0087), np.log(0.082)))
    bench.white = bench.white * np.exp(kappa * (bench.temperature - bench.temperature.mean()))
    bench.hide("temperature_noise", {"relative_per_degC": kappa})


def warm_up_two(bench):
    rng, size = bench.rng, bench.sign()
    bench.slow += size * (
        rng.uniform(0.04, 0.1) * np.exp(-bench.t / rng.uniform(20, 60))
        + rng.uniform(0.04, 0.1) * np.exp(-bench.t / rng.uniform(400, 900))
    )
    bench.truth.groups.append({"warm_up"})
    bench.truth.unknown_is_right = True
