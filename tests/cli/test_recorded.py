"""davar-sim's rows, notes, messages and help, as recorded in recorded_runs.txt."""

import random
from pathlib import Path

import pytest
from recorded import assert_recorded, cases
from sim_case import as_text, sim, write

RUNS = Path(__file__).with_name("recorded_runs.txt")


def smoothed(values, decay):
    level, found = 0.0, []
    for value in values:
        level += (1 - decay) * (value - level)
        found.append(round(level))
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """xy.csv: counts with a gap and saturated samples; y has a change, z torn reads. rates.csv: x
    and y in other units. rest.csv: white noise, plain and after filters, and coarse.
    """
    source, made = random.Random(1), tmp_path_factory.mktemp("recorded")
    x, y = ([round(source.gauss(20, 40) * (1 + 2 * (n > late))) for n in range(3000)]
            for late in (3000, 1800))  # fmt: skip
    z = [round(source.gauss(-250, 3)) + 256 * (n in (700, 1900)) for n in range(3000)]
    x[2000:2003] = [32767] * 3
    times = [f"{(n + 7 * (n >= 1500)) / 100:.2f}" for n in range(3000)]
    names = "time_s,gyro_x_counts,gyro_y_counts,gyro_z_counts,temp_degC"
    write(made / "xy.csv", as_text(names, zip(times, x, y, z, map(abs, y))))
    rates = ([time, f"{0.05 * a:.2f}", f"{0.001 * b:.3f}"] for time, a, b in zip(times, x, y))
    write(made / "rates.csv.gz", as_text("time_s,gyro_x_dps,gyro_y_rad_s", rates))
    white = [source.gauss(0, 300) for _ in range(20_008)]
    mean = [sum(white[n : n + 8]) / 8 for n in range(20_000)]
    columns = ([round(one) for one in values] for values in (white, mean, (w / 900 for w in white)))
    rest = zip(
        (n / 100 for n in range(20_000)), *columns, smoothed(white, 0.5), smoothed(white, 0.9)
    )
    names = ("white", "average", "coarse", "wide", "narrow")
    write(made / "rest.csv", as_text("time_s," + ",".join(f"{n}_counts" for n in names), rest))
    write(made / "model.csv", "m,adev_dps,relative_tolerance\n1,2,0.1\n4,0.5,0\n")
    offset = ((n, f"{1e7 + n % 7 * 1e-4:.4f}") for n in range(700))
    write(made / "offset.csv", as_text("time_s,freq_hz", offset))
    write(made / "flat.csv", as_text('time_s,"gyro\\tx"', ((n / 100, 1.5) for n in range(700))))
    return made


@pytest.mark.parametrize("words", cases(RUNS))
def test_a_run_prints_what_is_recorded(folder, words):
    done = sim(*words.split(), cwd=folder)
    # a learned filter decides the last digits of the rows, and the C library its own
    shown = "" if "--bandwidth auto" in words else done.stdout
    assert_recorded(RUNS, words, str(done.returncode), shown, done.stderr)
