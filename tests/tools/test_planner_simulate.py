"""The planner keeps its word: random wishes for every gyro of the table, run with --simulate."""

import json
import random

import pytest
from planner import choice, costs, sensors, simulate, wishes
from planner.choice import Impossible
from planner_case import run

pytestmark = pytest.mark.slow
GROUPS, BY_DAY, WISHES = 20, 4, 10
RATES = (25, 50, 60, 100, 104, 200, 240, 400, 500, 833, 960, 1000, 2000, 4000, 8000)
SHARES = (0.05, 0.1, 0.25, 0.4)


def rate_of(part, draw):
    if "bandwidth_at_rate" in part:
        return float(draw.choice(list(part["bandwidth_at_rate"])))
    within = [hz for hz in RATES if part["rate_least_hz"] <= hz <= part["rate_most_hz"]]
    return draw.choice([*within, part["rate_most_hz"]])


def filter_of(rate, draw):
    share = draw.choice(SHARES)
    known = (
        f"{rate * share:g}:{draw.choice((1, 2))}",
        f"biquad:{rate * share:g}",
        f"pt1:{rate * share:g}",
    )
    return draw.choice(["none", *known, "average:4", "cic3:4"])


def wish(draw):
    name = draw.choice(sorted(sensors.PARTS))
    part = sensors.PARTS[name]
    rate = rate_of(part, draw)
    words = [f"--sensor {name}@{rate:g} --core {draw.choice(costs.cores())}"]
    words += [f"--axes {draw.choice((1, 1, 3))}"]
    optional = {
        "--lsb": (0.6, f"{part['lsb_dps'] / draw.choice((1, 2, 4, 8, 16)):.6g}"),
        "--bandwidth": (0.4, filter_of(rate, draw)),
        "--respond": (0.5, draw.choice((0.5, 1, 2, 5, 10, 20))),
        "--arw-percent": (0.4, draw.choice((3, 5, 8, 10, 20))),
        "--false-alarms-per-hour": (0.2, draw.choice((0.01, 0.1, 1))),
        "--longest-tau": (0.2, draw.choice((10, 100))),
        "--motion": (0.2, "none"),
    }
    words += [
        f"{name} {value}" for name, (share, value) in optional.items() if draw.random() < share
    ]
    return " ".join(words)


def judged(words):
    """What a plan promises and does not keep; None: the wish is impossible."""
    try:
        plan = choice.plan(wishes.read(words.split(), costs.cores()).wishes)
    except Impossible:
        return None
    found, promise = simulate.simulate(plan), plan.promise
    later = found.respond_s / promise.respond_s
    wide = 1.3 if plan.design.law == "glr" else 1.2  # the mean length of its windows is a guess
    failed = {
        "present": found.present < 0.95,
        "holds": found.holds < 0.92,
        "arw_percent": not 0.8 <= found.arw_percent / promise.arw_percent <= wide,
        # the later tail of alarms has few trials on both sides
        "respond_s": not (0.6 if plan.design.law == "glr" else 0.8)
        <= later
        <= (1.35 if plan.design.law == "glr" else 1.2),
        "moving": bool(found.moving_present)
        and found.moving_present > 0.5
        and found.moving_holds < 0.9,
    }
    return [f"{name} of {words}: {found}, {promise}" for name, is_so in failed.items() if is_so]


@pytest.mark.parametrize(
    "group",
    [pytest.param(group, marks=[pytest.mark.soak] * (group >= BY_DAY)) for group in range(GROUPS)],
)
def test_promises_are_kept(group):
    draw = random.Random(f"wishes {group}")
    results = [judged(wish(draw)) for _ in range(WISHES)]
    plans = [result for result in results if result is not None]
    assert len(plans) >= WISHES // 3
    assert not [failed for result in plans for failed in result]


def test_the_report_has_what_came_out():
    words = ["--sensor", "icm42688@1000", "--core", "cortex-m4f", "--simulate"]
    done = run([*words, "--json"])
    found = json.loads(done.out)["simulated"]
    assert found["present"] > 0.97
    assert 0.92 < found["holds"] <= 1
    assert found["arw_percent"] == pytest.approx(json.loads(done.out)["arw_percent"], rel=0.1)
    assert "of the intervals contain it" in run(words).out


def test_a_simulation_needs_a_compiler(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    done = run(["--rate", "100", "--lsb", "0.05", "--core", "cortex-m0", "--simulate"])
    assert done.status == 2
    assert done.err == "davar-plan: --simulate: needs no-such-compiler: install a C compiler\n"
