"""bench/run: every method gives answers for a short record of each signal, the measures are right
on answers that are known, and the page has the methods and signals that bench/ has.
"""

import re
import subprocess

import measures
import numpy as np
import page
import pytest
import runners
import signals
from c_text import ROOT

PAGE = (ROOT / "docs/quality" / page.NAME).read_text()
DETECTORS = {"FusionBias", "VQF rest"}  # they report no noise
RIGHT = 0.5  # the least accurate, Betaflight, scatters by 0.26


@pytest.fixture(scope="module")
def methods():
    built = subprocess.run(
        ["bash", "-c", ". tools/support/setup.sh && build tools"], cwd=ROOT, capture_output=True
    )
    assert built.returncode == 0, built.stderr
    return {method.name: method for method in runners.every()}


def check(method):
    """Of white noise, its mean error is small, and it has an answer every STRIDE samples."""
    record = signals.simulated("rest", 0, 20)
    try:
        answers = method.answers(record)
    except signals.NotHere:
        return
    assert len(answers) == record.counts.size // signals.STRIDE
    has_values = not np.isnan(answers[:, 0]).all()
    assert has_values == (method.name not in DETECTORS)
    assert not has_values or abs(np.nanmean(measures.errors(answers, record))) < RIGHT


def test_every_method_is_right_in_white_noise(methods):
    assert len(methods) >= 17
    for method in methods.values():
        if method.file.name != "with_crate.py":
            check(method)


@pytest.mark.slow
def test_the_crate_is_right_in_white_noise(methods):
    """Apart, because cargo downloads it."""
    check(methods["crate allan"])


@pytest.mark.parametrize("name", signals.SIGNALS)
def test_every_method_in_c_runs_on_every_signal(name, methods):
    record = signals.simulated(name, 0, 20)
    for method in methods.values():
        if method.program:
            assert len(method.answers(record)) == record.counts.size // signals.STRIDE, method.name


def test_the_25_lines_and_allantools_agree(methods):
    record = signals.simulated("drift", 0, 20)
    ours, theirs = (methods[name].answers(record) for name in ("25 lines of C", "AllanTools"))
    np.testing.assert_allclose(ours[60:, 0], theirs[60:, 0], rtol=1e-9)


def test_costs_are_counted(methods):
    method, record = methods["PX4"], signals.simulated("rest", 0, 200)
    assert 0 < method.nanoseconds(record, with_answers=False) < 1000
    counted = method.instructions(record)
    assert counted is None or 5 < counted < 100


# What the answers know about steps of 60 s: (delay of the doublings, s; rms error; coverage).
KNOWN = {
    "the truth": (lambda sigma: sigma, 0.1, 0.0, 1.0),
    "the truth 2 s ago": (lambda sigma: np.roll(sigma, 20), 2.1, None, None),
    "the data sheet": (lambda sigma: np.full_like(sigma, sigma[0]), np.nan, None, None),
    "twice the truth": (lambda sigma: 2 * sigma, 0.1, np.log(2), 0.0),
}


@pytest.mark.parametrize("what", KNOWN)
def test_measures(what):
    values_of, delay_s, error, coverage = KNOWN[what]
    record = signals.simulated("steps", 0, 360)
    answers = np.full((len(record.sigma_dps), 4), np.nan)
    values = values_of(record.sigma_dps)
    answers[:, :3] = np.column_stack([values, 0.9 * values, 1.1 * values])
    found = measures.delays_s(answers, record)
    assert found.shape == (3,)
    np.testing.assert_allclose(found, delay_s, rtol=1e-9)
    if error is not None:
        assert page.rms(measures.errors(answers, record)) == pytest.approx(error, abs=1e-12)
        assert np.mean(measures.covered(answers, record)) == coverage


def test_a_stuck_alarm_is_one_alarm():
    record = signals.simulated("rest", 0, 60)
    answers = np.full((len(record.sigma_dps), 4), np.nan)
    answers[:, 3] = 0.0
    answers[200:300, 3] = 1.0
    assert list(measures.alarms(answers, record)) == [200]


def test_simulated_records_are_the_same_each_time():
    first, again = (signals.simulated("flight", 3, 2) for _ in range(2))
    other = signals.simulated("flight", 4, 2)
    assert (first.counts == again.counts).all() and (first.counts != other.counts).any()


def sections():
    """{title: the rows of the tables of this section, without heads}."""
    parts = re.split(r"^## (.*)$", PAGE, flags=re.MULTILINE)[1:]
    return {
        title: re.findall(r"^\| (?!---)([^|]+?) \|", text, re.MULTILINE)
        for title, text in zip(parts[::2], parts[1::2])
    }


def test_the_page_has_every_method_and_every_signal(methods):
    names = list(methods)
    every_signal = [one.replace("_", " ") for one in [*signals.SIGNALS, *signals.recordings()]]
    found = sections()
    assert found["How wrong is the noise?"] == names * 2
    assert found["How soon does a doubling show?"] == names
    assert found["What does it cost?"] == names
    assert found["Do the intervals contain the truth?"] == every_signal
    assert [row for row in found["The signals"] if row != "signal"] == every_signal
    heads = re.findall(r"^\|  \| (.*) \|$", PAGE.split("## Do the")[0], re.MULTILINE)
    assert " | ".join(heads).split(" | ") == every_signal
    for method in methods.values():
        assert f"(../../bench/methods/{method.file.name})" in PAGE
