"""The first session of a person, with the command as it is typed and a real browser: the verdict on
a recording, an effect added, the error falling, the model saved.
"""

import re
import signal
import tomllib

import pytest
from playwright.sync_api import expect
from recordings_made import effect, simulated
from visiting import effects, error, export, ranked, told


@pytest.mark.story
def test_a_first_session_finds_what_is_missing(folder, started, tabs):
    recording = simulated(
        folder, effect("sinusoid", amplitude_dps=0.02, frequency_hz=3.0), seconds=300
    )
    bench = started(recording.name)
    page = tabs.open(bench)
    expect(page.locator("#headline h1")).to_contain_text("off by")
    before, shown = error(page), page.text_content("#error-value")
    best = ranked(page)
    assert best.get_attribute("data-kind") == "sinusoid"
    expect(page.locator(".card.best .to")).to_contain_text("→")
    best.click()
    effects(page, 3)
    expect(page.locator("#headline h1")).to_contain_text(
        re.compile("^The model fits (within 5\\s% )?from [0-9.]+ s to [0-9.]+ s$")
    )
    after, step = error(page), bench.ask("step")
    assert after < before / 2
    assert after < 1.25 * float(page.text_content("#floor-value"))
    assert after == pytest.approx(step["error"], abs=5.1e-4)

    page.keyboard.press("u")
    effects(page, 2)
    expect(page.locator("#error-value")).to_have_text(shown)  # drawn in the frame after the effects
    page.keyboard.press("r")
    effects(page, 3)
    path = export(page, "save")
    (folder / "model.toml").write_bytes(path.read_bytes())
    line = tomllib.loads(path.read_text())["effect"][2]
    assert line["frequency_hz"] == pytest.approx(3.0, abs=1e-3)
    assert line["amplitude_dps"] == pytest.approx(0.02, rel=0.1)
    typed = told("compare", recording, "-m", folder / "model.toml")
    assert typed["error"] == pytest.approx(step["error"], rel=1e-3)  # of 9 digits
    assert typed["adequacy"] == step["adequacy"]
    page.close()
    status, said = bench.stop(signal.SIGTERM)
    assert (status, said.count("\n")) == (0, 1), said
