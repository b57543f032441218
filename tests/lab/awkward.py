"""Recordings of awkward sensors: what real ones do and textbooks do not. Numpy and scipy only,
nothing of davarlab. 100 Hz, one hour, ARW 0.3 deg/sqrt(h), BI 5 deg/h unless a case says otherwise;
all else is drawn.

A case is a row of ingredients (ingredients/) in the order of physics: what moves the rate, then the
sensor's own filter, its counts, its clock. Each adds to the recording and to the truth.
"""

import numpy as np
from ingredients import clock, lines, logged, motion, sensor, thermal, wander
from ingredients.bench import RATE, SECONDS, B, Bench, N

# name -> (ingredients, rate, seconds)
HOUR = (RATE, SECONDS)
CASES = {
    **{
        make.__name__: ((make,), *HOUR)
        for make in (
            thermal.temperature_lag,
            thermal.temperature_hysteresis,
            thermal.temperature_squared,
            thermal.temperature_noise,
            thermal.warm_up_two,
            logged.supply_voltage,
            logged.axis_leak,
            logged.common_cause,
            lines.narrow_band,
            lines.drifting_line,
            lines.drifting_as_it_warms,
            lines.intermittent_line,
            wander.telegraph_three_levels,
            wander.bias_step,
            wander.bias_steps,
            motion.motion_turned,
            motion.motion_touched,
            motion.motion_tilt,
            motion.wild_samples,
            sensor.two_tap_average,
            sensor.butterworth,
            sensor.bias_subtracted,
            sensor.rounded_angle,
            sensor.rounded_rate,
            sensor.clipped,
            sensor.dead_zone,
            clock.repeated_each,
            clock.repeated_slower,
            clock.repeated_stale,
            clock.repeated_behind_counts,
            clock.lost_samples,
        )
    },
    "jittered_stamps + line": ((lines.line, clock.jittered_stamps), *HOUR),
    "uneven_clock + line": ((clock.uneven_clock, lines.line), *HOUR),
    "clean": ((logged.clean,), *HOUR),
    "clean decoys": ((logged.decoys, logged.clean), *HOUR),
    "clean decoys 200 Hz": ((logged.decoys, logged.clean), 200.0, 1800.0),
    "clean 10 Hz": ((logged.clean,), 10.0, 10800.0),
    "supply_voltage 25 Hz": ((logged.supply_voltage,), 25.0, 7200.0),
    "temperature_lag 10 Hz": ((thermal.temperature_lag,), 10.0, 14400.0),
    "narrow_band 200 Hz": ((lines.narrow_band,), 200.0, 1800.0),
    "butterworth 500 Hz": ((sensor.butterworth,), 500.0, 600.0),
    "bias_subtracted 1 Hz": ((sensor.bias_subtracted,), 1.0, 40000.0),
    "temperature_lag + two lines": ((thermal.temperature_lag, lines.two_lines), *HOUR),
    "gauss_markov + average_of_several": ((wander.gauss_markov, sensor.average_of_several), *HOUR),
    "low_band + butterworth": ((lines.low_band, sensor.butterworth), *HOUR),
    "line + butterworth": ((lines.line, sensor.butterworth), *HOUR),
    "narrow_band + temperature": ((lines.narrow_band, thermal.temperature), *HOUR),
    "random_walk + one_pole": ((wander.random_walk, sensor.one_pole), *HOUR),
    "temperature + rounded_rate": ((thermal.temperature, sensor.rounded_rate), *HOUR),
    "temperature + rounded_angle": ((thermal.temperature, sensor.rounded_angle), *HOUR),
    "temperature + motion_turned": ((thermal.temperature, motion.motion_turned), *HOUR),
    "line + lost_samples": ((lines.line, clock.lost_samples), *HOUR),
    "narrow_band + two_tap_average": ((lines.narrow_band, sensor.two_tap_average), *HOUR),
    "bias_step + temperature": ((wander.bias_step, thermal.temperature), *HOUR),
    "telegraph + narrow_band": ((wander.telegraph, lines.narrow_band), *HOUR),
    "supply_voltage + temperature_noise": (
        (logged.supply_voltage, thermal.temperature_noise),
        *HOUR,
    ),
    "intermittent_line + temperature_squared": (
        (lines.intermittent_line, thermal.temperature_squared),
        *HOUR,
    ),
    "narrow_band + temperature_lag + one_pole": (
        (lines.narrow_band, thermal.temperature_lag, sensor.one_pole),
        *HOUR,
    ),
}


def case(name, seed, rate=None, seconds=None):
    """(columns, Truth)."""
    ingredients, usual_rate, usual_seconds = CASES[name]
    rng = np.random.default_rng([seed, *name.encode()])
    bench = Bench(rng, rate or usual_rate, seconds or usual_seconds)
    for ingredient in ingredients:
        ingredient(bench)
    columns = bench.columns()
    if bench.truth.covers:
        bench.truth.kinds |= {
            "angle_random_walk": {"coefficient_deg_per_sqrt_h": N},
            "bias_instability": {"coefficient_deg_per_h": B},
        }
    return columns, bench.truth


def write(columns, path):
    formats = ",".join("%.6f" if name == "time_s" else "%.7g" for name in columns)
    np.savetxt(
        path,
        np.column_stack(list(columns.values())),
        fmt=formats,
        header=",".join(columns),
        comments="",
    )
