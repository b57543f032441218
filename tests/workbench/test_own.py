"""An effect of one's own: the conditions under which a server runs code, what the code may do, and
the editor of the page.
"""

import json
import re
import shlex

import pytest
from davarlab.effects import own
from playwright.sync_api import expect
from recordings_made import gimbal, model_file, noise
from visiting import accessible, altered, files_in, ranked, told, unfold

UNKNOWN = {
    "tau_s": 2.6,
    "ratio": 1.5,
    "frequency_hz": None,
    "start_s": 0,
    "stop_s": 40,
    "column": "motor_deg",
    "correlation": 0.3,
}
PUMP = """import numpy as np
from davarlab.effects.base import Effect, Parameter

def bias(recording, shape):
    return (recording.time_s % 11) < {seconds}

OWN = Effect(
    kind="pump", role="mean", regressor=bias,
    parameters=(Parameter("coefficient", "deg/s", -1e9, 1e9),),
    physics="A pump.", signature="", confirm="Stop it.")
"""
TOPS = "['own', 'own-code'].map((id) => document.getElementById(id).scrollTop)"
# Texts of an effect -> a word of the error.
WRONG = {
    "import numpy as": "SyntaxError",
    "x = 1": "no Effect in it",
    "while True: pass": "did not return within",
    "raise SystemExit": "SystemExit",
    "raise KeyboardInterrupt": "KeyboardInterrupt",
    "raise type('Mute', (Exception,), {'__str__': lambda self: 1 / 0})": "Mute",
    "raise ValueError('\\ud800')": "ValueError",
}
TYPED = """import numpy as np
from davarlab.effects.base import Effect, Parameter

calls = []

def bias(recording, shape):
    calls.append(1)
    motor = recording.column("motor_deg")
    {body}
    return np.sin(np.radians(motor))

OWN = Effect(
    kind="{kind}", role="mean", regressor=bias,
    parameters=(Parameter("coefficient", "deg/s", -1e9, 1e9),),
    physics="The bias follows the motor.", signature="",
    confirm="Keep it constant.", needs={needs})
"""


def typed(kind="mine", body="pass", needs="()"):
    return TYPED.format(kind=kind, body=body, needs=needs)


@pytest.mark.parametrize("text", WRONG, ids=str)
def test_a_mistake_in_code_is_named_and_the_worker_goes_on(folder, opened, monkeypatch, text):
    monkeypatch.setattr(own, "LONGEST_S", 1.0)
    bench = opened(gimbal(folder / "rec.csv", 2000), code=True)
    status, answer = bench.coded("check_own", {"text": text})
    assert (status, WRONG[text] in json.loads(answer)["error"]) == (200, True), answer
    assert bench.tried("step")[0] == 200


def test_code_changes_neither_the_recording_nor_files(folder, opened, monkeypatch):
    monkeypatch.setattr(own, "LONGEST_S", 1.0)
    bench = opened(gimbal(folder / "rec.csv", 2000), code=True)
    step, files = bench.ask("step"), files_in(folder)
    _, answer = bench.coded("check_own", {"text": typed(body="motor -= motor.mean()")})
    assert "read-only" in json.loads(answer)["error"]
    for body, needs, words in (
        ("while len(calls) > 1: pass", "()", "did not return within"),
        ("pass", '("supply_V",)', "needs a column"),
        ("if len(calls) > 1: raise ValueError('late')", "()", "late"),
    ):
        given = {"text": typed(body=body, needs=needs), "state": step["state"]}
        status, answer = bench.coded("add_own", given)
        assert (status, words in answer) == (400, True), answer
        assert files_in(folder) == files
        assert bench.ask("step") == step  # the data are as read
    status, answer = bench.coded("add_own", {"text": typed(), "state": step["state"]})
    assert status == 200, answer


def test_an_effect_that_is_added_explains_the_data_and_stays_with_them(folder, opened):
    recording = gimbal(folder / "my rec.csv")
    bench = opened(recording, code=True)
    before = bench.ask("step")
    given = {"text": typed("gimbal"), "state": before["state"]}
    status, answer = bench.coded("add_own", given)
    assert status == 200, answer
    step = bench.ask("step")
    assert step["error"] < before["error"] / 2
    size = step["cards"][2]["parameters"][0]
    assert size["low"] < 0.06 < size["high"]
    assert (folder / "my rec.csv.gimbal.py").read_text() == given["text"]
    # the command on the page gives the same in a terminal
    commands, again = (bench.ask("all")[key] for key in ("commands", "again"))
    command = next(one for one in commands if " compare " in one)
    model = bench.saved()
    changed = {"text": given["text"].replace("np.sin", "np.cos"), "state": step["state"]}
    status, answer = bench.coded("add_own", changed)
    assert (status, "which a step uses" in answer) == (400, True), answer
    assert (folder / "my rec.csv.gimbal.py").read_text() == given["text"]
    bench.done("open", path=str(gimbal(folder / "other.csv", 2000)))
    assert "--effects" not in bench.ask("all")["again"]
    bench.done("open", path=str(recording))
    assert "--effects" in bench.ask("all")["again"]
    bench.done("close")
    for kind in list(own.LOADED):
        own.drop(kind)
    model_file(folder, model)
    compared = told(*shlex.split(command)[1:], cwd=folder)
    assert compared["error"] == pytest.approx(step["error"], rel=1e-3)
    own.drop("gimbal")
    status, answer = opened().act("open", path=str(recording))  # says what to type
    assert (status, again[again.index("--effects") :] in answer["error"]) == (400, True), answer


def test_code_runs_only_for_the_person_at_the_terminal(folder, opened):
    """Which requests are refused: tests/lab/test_requests.py."""
    recording, mark = gimbal(folder / "rec.csv", 2000), folder / "ran"
    given = {"text": f"open({str(mark)!r}, 'w').close()"}
    served = opened(recording)  # by a service, for anyone who reaches it
    assert served.coded("check_own", given)[0] == 403
    assert served.coded("add_own", {**given, "state": served.ask("step")["state"]})[0] == 403
    assert not served.ask("all")["code"]
    bench = opened(recording, code=True)
    for headers in ({"Origin": "https://elsewhere.example"}, {"X-Forwarded-For": "127.0.0.1"}):
        assert bench.coded("check_own", given, **headers)[0] in (400, 403), headers
    assert not mark.exists()
    assert bench.coded("check_own", given)[0] == 200
    assert mark.exists()


def test_a_pump_is_written_edited_and_gone_from_the_residual(folder, opened, tabs):
    """White noise and a pump that shifts the bias for 4 s of every 11."""
    pump = lambda i: 0.05 if (i / 50) % 11 < 4 else 0.0  # noqa: E731
    bench = opened(noise(folder / "rec.csv", "time_s,gyro_z_dps", pump, rows=15000), code=True)
    page = tabs.open(bench, 1280, 577)
    ranked(page)
    assert any(abs(f * 11 - 1) < 0.1 for f in bench.flagged())
    page.click("#next button.write")
    said, add = page.locator("#own-said"), page.locator("#own-add")
    expect(add).to_be_enabled()
    template = page.input_value("#own-code")
    page.fill("#own-code", PUMP.format(seconds=3).replace("% 11", "% period"))
    expect(said).to_contain_text("Not yet: pump: regressor: NameError")
    expect(add).to_be_disabled()
    page.get_by_role("button", name="Cancel").click()
    page.click("#next button.write")
    assert page.input_value("#own-code") == template
    assert page.evaluate(TOPS) == [0, 0]
    page.fill("#own-code", PUMP.format(seconds=3))
    expect(said).to_contain_text("✓ pump returns 15000 values from 0 to 1")
    add.click()
    expect(page.locator(".effect[data-kind=pump]")).to_be_visible()
    assert bench.flagged() != []  # of a second that it lacks
    unfold(page, "pump")
    page.get_by_role("button", name="Edit").click()
    expect(add).to_be_enabled()
    text = page.input_value("#own-code")
    assert text == PUMP.format(seconds=3).replace('"pump"', '"pump_2"')
    page.fill("#own-code", text.replace("< 3", "< 4"))
    expect(add).to_be_enabled()
    add.click()
    expect(page.locator(".effect[data-kind=pump_2]")).to_be_visible()
    expect(page.locator(".effect[data-kind=pump]")).to_have_count(0)
    assert bench.flagged() == []
    page.click("#home")
    expect(page.locator("#tutorial")).to_be_visible()


def test_code_is_offered_only_by_a_server_at_a_terminal(folder, opened, tabs):
    """Where no known effect explains the misfit."""
    gimbal(folder / "rec.csv", 2000)

    def unexplained(_, found):
        unknown = {"where": UNKNOWN, "next": ["Log the motor's current."]}
        return {**found, "candidates": [], "nothing": ["", "All were tried."], "unknown": unknown}

    def shown(bench):
        page = tabs.open(bench)
        altered(page, re.compile("/api/candidates"), unexplained)
        page.reload()
        expect(page.locator("#nothing")).to_contain_text("motor_deg")
        return page

    page = shown(opened("rec.csv"))
    expect(page.locator("#next button.write")).to_have_count(0)
    expect(page.locator("#next pre").last).to_contain_text("--effects effect.py")
    accessible(page)
    page.close()
    page = shown(opened("rec.csv", code=True))
    page.click("#next button.write")
    expect(page.locator("#own-said")).to_contain_text("own_effect returns 2000 values")
    assert 'recording.column("motor_deg")' in page.input_value("#own-code")
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator("#next button.write")).to_be_focused()
