"""davar-sim --device COMMAND: faults of a device (tools/davar-mcu tests correct devices)."""

import pytest
from device_answer import HEALTH, head, result, words
from sim_case import assert_refused, recording, sim

INCOMPLETE = {
    "empty": b"",
    "cut in a head": result()[:40],
    "cut in a result": result()[:-8],
    "no health": result(),
    "foreign channel": result(channel=10**9),
    "foreign taus": result(taus=33),
    "more taus": result(taus=2) + words(*[0] * 6) + head(HEALTH),
    "no taus": result(taus=0) + head(HEALTH),
    "cut health": result() + words(HEALTH, 0),
}


def on_device(folder, answer, *options):
    """Runs davar-sim with a device that writes `answer` (bytes) and ends with a status (number)."""
    command = f"sh -c 'exit {answer}' device"
    if isinstance(answer, bytes):
        (folder / "answer").write_bytes(answer)
        command = f"sh -c 'cp {folder}/answer $2' device"
    path = recording(folder, 1000)
    return sim(path, "--lsb", "0.01", "--taus", "1", *options, "--device", command)


@pytest.mark.parametrize("name", INCOMPLETE)
def test_incomplete_results_are_rejected(tmp_path, name):
    for options in ((), ("--out", "jsonl")):
        done = on_device(tmp_path, INCOMPLETE[name], *options)
        assert_refused(done, "results: the device's results are incomplete\n")


@pytest.mark.parametrize(
    ("status", "why"),
    [
        (0, "the device wrote no results"),
        (1, "the device failed (exit status 1)"),
        (4, "the device supports fewer cluster sizes or channels (exit status 4)"),
        (5, "the device has too little memory for this window and these channels (exit status 5)"),
        (6, "the device rejected the settings (exit status 6)"),
    ],
)
def test_a_device_that_fails_is_reported(tmp_path, status, why):
    assert_refused(on_device(tmp_path, status), why)


def test_the_counters_are_the_device_s(tmp_path):
    done = on_device(tmp_path, result() + head(HEALTH, 0, 3, 17, 5))
    assert (done.returncode, done.stdout.count("\n")) == (0, 2)
    assert "davar-sim: 3 gaps (17 samples missing), 5 samples saturated, " in done.stderr
