"""davar-sim --model-table: compares every result with the table of an error model."""

import math

import pytest
from sim_case import (
    SMALL_WINDOW,
    assert_refused,
    recording,
    results,
    sim,
    write,
)

HEAD = "m,tau_s,adev_dps,relative_tolerance"
WHITE = 0.3  # deg/s, of sim_case.noise_rows
OPTIONS = (*SMALL_WINDOW, "--stride", "60", "--law", "fixed", "--details")


def table(scale=1.0, tolerance=0.0, sizes=(1, 2, 4), rate_hz=100.0):
    rows = [f"{m},{m / rate_hz},{scale * WHITE / math.sqrt(m):.9g},{tolerance}" for m in sizes]
    return "\n".join(["# angle_random_walk: of the test", HEAD, *rows]) + "\n"


def compared(folder, text, *options):
    model = write(folder / "model.csv", text)
    rows = results(recording(folder, 3000), *OPTIONS, "--model-table", model, *options)
    return [float(row["model_health"]) for row in rows], rows


def test_a_true_model_is_healthy_and_a_false_one_is_not(tmp_path):
    healthy, rows = compared(tmp_path, table())
    assert sum(number > 1 for number in healthy) < 0.06 * len(healthy)
    assert all(abs(float(row["model_deviation_1"])) < 5 for row in rows)
    assert min(compared(tmp_path, table(0.4))[0]) > 1
    assert compared(tmp_path, table(0.85))[0][-1] > 1


def test_a_deviation_is_that_of_the_design(tmp_path):
    _, rows = compared(tmp_path, table(1.1, 0.05))
    for row in rows:
        adev, high = float(row["adev_1"]), float(row["adev_high_1"])
        # of the cube root of chi-square over edf, whose 2.5 % limit is adev^2 / high^2
        root = (math.sqrt(1.96**2 + 4 * (1 - (adev / high) ** (2 / 3))) - 1.96) / 2
        excess = (adev / (1.1 * WHITE)) ** (2 / 3) - 1 + root**2
        z = excess / math.sqrt(root**2 + (0.1 / 3) ** 2)
        assert float(row["model_deviation_1"]) == pytest.approx(z, abs=0.02 + 0.02 * abs(z))


GOOD = table()
BAD_ROWS = {
    "8,0.08,0,0": "column adev_dps: must be above 0",
    "8,0.08,-1,0": "column adev_dps: must be above 0",
    "8,0.08,0.1,-0.1": "column relative_tolerance: must not be negative",
    "8,0.08,x,0": "column adev_dps: not a number",
    "8,0.08,nan,0": "column adev_dps: not a finite number",
    "1.5,0.015,0.1,0": "column m: not a cluster size, found '1.5'",
    "0,0,0.1,0": "column m: not a cluster size",
    "-1,0,0.1,0": "column m: not a cluster size",
    "1e10,1e8,0.1,0": "column m: not a cluster size",
    "1,0.01,0.1,0": "column m: cluster size repeated",
    "8,0.08,0.1": "column relative_tolerance: row too short",
    "8,0.0809,0.1,0": "column tau_s: made for a different sample rate",
}
LONG = "\n".join([HEAD, *(f"{m},{m / 100},0.1,0" for m in range(1, 66))])
TABLES = {
    **{f"{GOOD}{row}\n": f"model.csv:6: {words}" for row, words in BAD_ROWS.items()},
    "m,adev\n1,2\n": "model.csv: no column adev_dps (found: m, adev)",
    HEAD + "\n": "model.csv: has no cluster sizes",
    "": "model.csv:0: empty recording",
    LONG: "model.csv:66: column m: too many cluster sizes",
    table(sizes=(3, 5)): "no cluster size in common with --taus",
}


@pytest.mark.parametrize("text", TABLES)
def test_a_bad_table_is_reported_with_its_place(tmp_path, text):
    model = write(tmp_path / "model.csv", text)
    done = sim(recording(tmp_path), *SMALL_WINDOW, "--model-table", model)
    assert_refused(done, TABLES[text])


@pytest.mark.parametrize(
    "text",
    [
        "m,adev_dps,relative_tolerance\n\n1,0.3,0.1\n",
        f"{GOOD}8,0.0807,0.1,0\n",  # tau_s within 1 %
        "\n".join(LONG.split("\n")[:-1]),
    ],
)
def test_a_table_without_tau_s_and_one_with_64_rows_are_accepted(tmp_path, text):
    model = write(tmp_path / "model.csv", text)
    rows = results(recording(tmp_path), *SMALL_WINDOW, "--model-table", model)
    assert rows[-1]["model_health"] != ""
