"""What davar-sim and davar-node send is what davar-sim prints: every value of every frame, decoded
by cantools, equals the field of the CSV. The settings of davar-node are given to davar-sim in full.
"""

import csv
import io
import math
import subprocess

import pytest
from senders import NODE, SIM, counters, dbc, health_of, on_a_line, seeded

UNIT = 0.05
SMALL = ("--window-max", 200, "--window-min", 100, "--segment", 30, "--stride", 50)
COEFFICIENTS = ("qn", "arw", "bi", "rrw", "rr")  # in the order of DAVAR_Coefficient
UNITS = ("deg", "deg_per_sqrt_h", "deg_per_h", "deg_per_h_per_sqrt_h", "deg_per_h2")
FLOOR = {
    f"Floor{limit}DegPerSqrtH": f"floor{limit and '_' + limit.lower()}_deg_per_sqrt_h"
    for limit in ("", "Low", "High")
} | {"FloorWhy": "floor_why"}
CHANGES = ("change_older", "change_newer", "change_gain")


def noise(number, factor_after=None):
    source = seeded("sent")
    level = [1 if factor_after is None or n < factor_after else 3 for n in range(number)]
    return [str(round(source.gauss(7, 40) * level[n])) for n in range(number)]


def csv_of(columns, *words, steps=None):
    """Rows of davar-sim for counts; steps: {sample: periods since the one before}."""
    done = subprocess.run(
        [SIM, "-", "--lsb", str(UNIT), "--details", *map(str, words)],
        input=text_of(columns, steps),
        text=True,
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    return list(csv.DictReader(io.StringIO(done.stdout)))


def text_of(columns, steps=None):
    names = ["gyro_x_counts", "gyro_y_counts", "gyro_z_counts"][: len(columns)]
    tick, lines = -1, [",".join(["time_s", *names])]
    for n, row in enumerate(zip(*columns)):
        tick += (steps or {}).get(n, 1)
        lines.append(",".join([repr(tick / 100), *row]))
    return "\n".join(lines) + "\n"


def assembled(sent, base=0x5D0):
    """[the values of a result] of each channel, and the items of DAVAR_Setup."""
    channels, setup = {}, {}
    for identifier, data in sent:
        channel, kind = divmod(identifier - base, 16)
        signals = dbc().decode_message(0x5D0 + kind, data)
        rows = channels.setdefault(channel, [])
        if "Epoch" in signals:
            rows.append({})
        if "Item" in signals:
            setup[signals["Item"]] = [value for name, value in signals.items()][-1]
        elif "TauIndex" in signals:
            rows[-1]["adev", signals["TauIndex"]] = signals["AdevDps"]
            rows[-1]["u", signals["TauIndex"]] = signals["AdevRelativeUncertainty"]
        elif "Kind" in signals:
            rows[-1]["c", signals["Kind"].value] = signals[str(signals["Kind"])]
        elif "MonitorIndex" in signals and signals["MonitorIndex"] < 32:
            rows[-1]["monitor", signals["MonitorIndex"]] = signals["ModelDeviation"]
        elif "ChangeItem" in signals and signals["ChangeItem"] > 0:
            name = CHANGES[signals["ChangeItem"] - 1]
            rows[-1][name] = [
                value for name, value in signals.items() if name.startswith("Change")
            ][-1]
        elif rows and "HealthIndex" not in signals:
            rows[-1].update(signals)
    return channels, setup


def same(field, value, relative=1.2e-7, absolute=0.0):
    """A field of the CSV, and a value of a frame."""
    if value == math.inf:  # no limit
        return field == ""
    if isinstance(value, str) or not isinstance(value, (int, float)) or math.isnan(value):
        return field == "" or str(value) == "beyond"
    return field != "" and math.isclose(float(field), value, rel_tol=relative, abs_tol=absolute)


def assert_rows(rows, found, sizes, coefficients=5):
    assert [row["epoch"] for row in rows] == [str(one["Epoch"]) for one in found]
    for row, one in zip(rows, found):
        assert int(row["window_samples"]) == one["WindowSamples"]
        assert int(row["unstable"]) == one["Unstable"]
        assert same(row["kurtosis"], one["Kurtosis"], 0, 0.00051)
        assert same(row["contribution"], one["Contribution"], 0, 0.0000051)
        assert same(row["arw_deg_per_sqrt_h"], one["ArwDegPerSqrtH"])
        for t, m in enumerate(sizes):
            assert same(row[f"adev_{m}"], one["adev", t]), (row["epoch"], m)
            low, high = row[f"adev_low_{m}"], row[f"adev_high_{m}"]
            # Of white noise: frames have no batches for other noise.
            is_white = row[f"arw_{UNITS[1]}"] and not row["flat_from"]
            if is_white and low and high and not isinstance(one["u", t], str):
                wide = (float(high) - float(low)) / 2 / float(row[f"adev_{m}"])
                assert one["u", t] == pytest.approx(wide, abs=0.00051) or wide > 2
        for signal, column in FLOOR.items() if "floor_why" in row else ():
            value = one[signal]
            assert same(row[column], getattr(value, "value", value)), (row["epoch"], column)
        for kind in range(coefficients):
            name, unit = COEFFICIENTS[kind % 5], UNITS[kind % 5]
            limit = ("", "_low", "_high")[kind // 5]
            field, upper = row[f"{name}{limit}_{unit}"], row[f"{name}_upper_{unit}"]
            value = one["c", kind]
            if limit and not row[f"{name}_{unit}"]:
                assert limit == "_low" or same(upper, value), (row["epoch"], kind)
            else:
                assert same(field, value), (row["epoch"], kind)


OCTAVES = (1, 2, 4, 8, 16)
SETTINGS = {
    "or": ("--mode", "trailing", *SMALL),
    "and, centred": ("--law", "and", *SMALL),
    "fixed, list": ("--law", "fixed", "--taus", "1,3,9", *SMALL),
    "longest tau": ("--mode", "trailing", *SMALL, "--longest-tau", 2.6),
    "floor": ("--mode", "trailing", *SMALL, "--bandwidth", "none", "--floor"),
}
SIZES = {"fixed, list": (1, 3, 9), "longest tau": (*OCTAVES, 64, 128, 256)}


@pytest.mark.parametrize("name", SETTINGS)
def test_davar_sim_sends_what_it_prints(name):
    columns, steps = [noise(900), noise(900, 400)], {300: 4, 301: 2.7, 640: 60}
    words = (*SETTINGS[name], "--column", "gyro_y_counts,gyro_x_counts")
    sizes = SIZES.get(name, OCTAVES)
    rows = csv_of(columns, *words, steps=steps)
    frames = ("--can-content", "intervals", "--can-base", "0x610", "--progress", "never")
    sent, told = on_a_line(SIM, "-", "--lsb", UNIT, *words, *frames, text=text_of(columns, steps))
    found, setup = assembled(sent, 0x610)
    assert sorted(found) == [0, 1]
    for channel, column in enumerate(("gyro_y_counts", "gyro_x_counts")):
        mine = [row for row in rows if row["channel"] == column]
        assert_rows(mine, found[channel], sizes, 15)
    assert (setup[0], setup[1]) == (pytest.approx(100), 50)
    assert {item - 32: m for item, m in setup.items() if item >= 32} == dict(enumerate(sizes))
    assert "3 gaps (64 samples missing)" in told
    health = health_of(sent)
    expected = {"gaps": 3, "missing samples": 64}
    assert {item: n for item, n in health.items() if n and item != "send retries"} == expected


def test_davar_sim_sends_the_deviations_of_a_model(tmp_path):
    table = tmp_path / "model.csv"
    table.write_text("m,adev_dps,relative_tolerance\n1,2,0\n4,1,0.1\n")
    words = ("--law", "fixed", *SMALL, "--model-table", table)
    columns = [noise(600), noise(600, 100)]
    both = ("--column", "gyro_x_counts,gyro_y_counts")
    rows = csv_of(columns, *words, *both)
    found, _ = assembled(
        on_a_line(SIM, "-", "--lsb", UNIT, *words, *both, text=text_of(columns))[0]
    )
    for channel in (0, 1):
        for row, one in zip(rows[channel::2], found[channel], strict=True):
            assert same(row["model_health"], one["ModelHealth"])
            for t, m in enumerate(OCTAVES):
                assert same(row[f"model_deviation_{m}"], one["monitor", t])


def node_and_sim(counts, words, wanted, text=None, steps=None, sizes=OCTAVES):
    """Results of davar-node, equal to those of davar-sim with settings `wanted`."""
    source = ("--source", "-", "--rate", 100, "--lsb", UNIT)
    text = "\n".join(text or counts) + "\n"
    rows = csv_of([counts], "--mode", "trailing", *wanted, steps=steps)
    epochs = [int(row["epoch"]) for row in rows]
    sent, told = on_a_line(NODE, *source, *words, text=text, epochs=epochs)
    found, setup = assembled(sent)
    assert_rows(rows, found[0], sizes)
    said, health = counters(told), health_of(sent)
    assert (said.pop("samples"), said.pop("results")) == (len(counts), len(rows))
    said.pop("send retries", None), health.pop("send retries", None)
    assert {name: count for name, count in health.items() if count} == said
    assert setup[0] == pytest.approx(100)
    return rows, found[0], said


LONG = (1, 2, 4, 8, 16, 32, 64)
DEFAULT = ("--window-max", 600, "--window-min", 400, "--segment", 100, "--stride", 100)
GLR = ("--law", "glr", "--window-max", 6000, "--window-min", 20, "--segment", 0, "--stride", 100)
FREQUENT = (*GLR, "--cut-interval", 2, "--false-alarms-per-hour", 1)
CUTOFF = ("--bandwidth", "20:1:5")
WINDOW = ("--law", "and", "--window-max", 80, "--window-min", 40, "--segment", 9, "--taus", "1,3,9")
WINDOW += ("--grow", 3, "--shrink", 5, "--stride", 20, "--engine", "grid")
BOUNDS = ("--kurtosis", "2.3:3.5", "--contribution", "0:0.2")
NODES = {
    "default": ((), DEFAULT, LONG),
    "small": (SMALL, SMALL, OCTAVES),
    "stride": (
        ("--window-max", 80, "--window-min", 40, "--segment", 9),
        ("--window-max", 80, "--window-min", 40, "--segment", 9, "--stride", 80),
        (1, 2, 4, 8),
    ),
    "filter": (CUTOFF, (*DEFAULT, *CUTOFF), LONG),
    "window": 2 * ((*WINDOW, *BOUNDS),) + ((1, 3, 9),),
    "floor": (
        (*SMALL, "--bandwidth", "none", "--floor"),
        (*SMALL, "--bandwidth", "none", "--floor"),
        OCTAVES,
    ),
    "unstable rate": 2 * ((*WINDOW, "--unstable-rate", 0.05),) + ((1, 3, 9),),
    "longest window": (
        ("--window-max", 60),
        ("--window-max", 60, "--window-min", 40, "--segment", 10, "--stride", 60),
        (1, 2, 4),
    ),
    "longest tau": (
        (*SMALL, "--longest-tau", 1.3),
        (*SMALL, "--longest-tau", 1.3),
        (*OCTAVES, 64, 128),
    ),
}


@pytest.mark.parametrize("name", NODES)
def test_davar_node_sends_what_davar_sim_prints(name):
    words, wanted, sizes = NODES[name]
    node_and_sim(noise(1100, 500), words, wanted, sizes=sizes)


@pytest.mark.slow
@pytest.mark.parametrize("words", [("--law", "glr"), FREQUENT])
def test_davar_node_reports_changes(words):
    wanted = FREQUENT if words == FREQUENT else GLR
    octaves = tuple(1 << k for k in range(10))
    given = words if words != FREQUENT else (*FREQUENT[:2], *FREQUENT[-4:])
    rows, found, said = node_and_sim(noise(8000, 6500), given, wanted, sizes=octaves)
    assert (said["noise alarms"], said["alarms"]) == (1, 1)
    assert said["window cuts"] >= 1
    for row, one in zip(rows, found):
        assert (row["alarm"], row["young"]) == (str(one["Alarm"]), str(one["Young"]))
        assert int(row["cut_age_samples"]) == one["CutAge"]
        assert (row["change_m"] or "0") == str(one["ChangeClusterSamples"])
        assert same(row["dispersion"], one["Dispersion"], 0, 0.0051)
        for name in CHANGES:
            assert same(row[name], one[name])


def test_lines_that_are_no_counts_are_gaps_of_the_results():
    counts = noise(900)
    text, steps = list(counts), {100: 3, 500: 2, 501: 2, 700: 41}
    for at in sorted(steps, reverse=True):
        text[at:at] = ["nan"] * (steps[at] - 1)
    _, _, said = node_and_sim(counts, SMALL, SMALL, text, steps)
    assert (said["gaps"], said["missing samples"], said["source faults"]) == (4, 44, 44)


@pytest.mark.parametrize(
    ("bits", "value", "expected"),
    [
        *((bits, 2 ** (bits - 1) - 1, 1) for bits in (12, 16, 24, 32)),
        *((bits, -(2 ** (bits - 1)), 1) for bits in (16, 24)),
        *((16, 32766, 0), (24, 32767, 0), (24, 8388606, 0), (32, 8388607, 0)),
    ],
)
def test_only_the_full_scale_of_the_width_is_saturated(bits, value, expected):
    counts = [*noise(200)[:100], str(value), *noise(200)[100:]]
    for words in (("--bits", bits), *([()] if bits == 24 else [])):
        text = "\n".join(counts) + "\n"
        source = ("--source", "-", "--rate", 100, "--lsb", 1e-4, *SMALL, *words)
        _, told = on_a_line(NODE, *source, text=text)
        assert counters(told).get("saturated samples", 0) == expected


@pytest.mark.parametrize("words", [(), ("--alarm-on", 1), ("--alarm-on", 0.5, "--alarm-off", 3)])
def test_alarms_are_counted_by_their_times(words):
    """The level rises after unstable results for --alarm-on seconds, and falls after stable ones
    for --alarm-off.
    """
    source = seeded("alarms")
    counts = [str(round(source.gauss(0, 40 if n // 500 % 2 else 9))) for n in range(6000)]
    limits = {"--alarm-on": 0, "--alarm-off": 1, **dict(zip(words[::2], words[1::2]))}
    rows, _, said = node_and_sim(counts, (*SMALL, *words), SMALL)
    high, since, alarms = False, None, 0
    for row in rows:
        epoch, unstable = int(row["epoch"]), row["unstable"] == "1"
        since = epoch if since is None or unstable == high else since
        if (
            unstable != high
            and epoch - since >= 100 * limits["--alarm-off" if high else "--alarm-on"]
        ):
            high, since = unstable, epoch
            alarms += high
    assert said["alarms"] == alarms > 3


def test_every_run_has_a_session_and_no_raw_samples_unless_asked_for():
    words = ("--source", "-", "--rate", 100, "--lsb", UNIT, *SMALL)
    sent, _ = on_a_line(NODE, *words, text="\n".join(noise(300)) + "\n")
    sessions = {dbc().decode_message(0x5D5, data)["Session"] for one, data in sent if one == 0x5D5}
    assert len(sessions) == 1
    assert 0 not in sessions
    assert 9 not in {identifier - 0x5D0 for identifier, _ in sent}
