"""The recorder of davarlab live: rows are written on arrival, memory does not grow, columns have
names.
"""

import csv

import pytest
from davar.wire import frames as wire
from davar.wire import record


def result(n, channel=0, taus=3):
    values = {"arw_deg_per_sqrt_h": 0.1 + n, "kurtosis": float("nan")}
    deviations = {index: 1e-3 * (index + n) for index in range(taus)}
    return wire.Result(channel, n % 16, n, values, deviations)


def known(*clusters):
    channel = wire.Channel()
    channel.setup["rate_hz"] = 100.0
    channel.clusters = dict(enumerate(clusters))
    return channel


@pytest.fixture
def recorder(tmp_path):
    found = record.Recorder(tmp_path / "arw.csv")
    found.rows = lambda: list(csv.DictReader((tmp_path / "arw.csv").read_text().splitlines()))
    yield found
    found.output.file.close()


def test_each_row_is_in_the_file_when_add_returns(recorder):
    channel = known(1, 2, 16)
    for n in range(100):
        recorder.add(result(n), channel)
        assert len(recorder.rows()) == n + 1
    last = recorder.rows()[-1]
    names = ("epoch", "time_s", "arw_deg_per_sqrt_h", "kurtosis", "adev_16")
    assert [last[name] for name in names] == ["99", "0.99", "99.1", "", "0.101"]
    assert [*last][-3:] == ["adev_1", "adev_2", "adev_16"]


def test_rows_wait_for_the_names_of_their_columns(recorder):
    channel = wire.Channel()
    for n in range(9):
        recorder.add(result(n), channel)
    assert recorder.rows() == []
    channel.setup["rate_hz"], channel.clusters = 100.0, {0: 1, 1: 2, 2: 4}
    recorder.add(result(9), channel)
    assert [row["time_s"] for row in recorder.rows()] == [f"{0.01 * n:.9g}" for n in range(10)]


def test_they_do_not_wait_for_ever(recorder):
    for n in range(1000):
        recorder.add(result(n), wire.Channel())
        assert len(recorder.waiting) < record.WAITING_MAX
    assert len(recorder.rows()) == 1000
    assert "adev_tau2" in recorder.rows()[0]


def test_rows_of_a_new_section_wait_and_delay_no_others(recorder):
    of_old, of_new = known(1), wire.Channel(2)
    recorder.add(wire.Result(0, 0, 99, {}, {0: 1.0}), of_old)
    for n in range(500):
        recorder.add(wire.Result(1, 0, n, {}, {0: 1.0}, stretch=2), of_new)
        recorder.add(wire.Result(0, 0, 100 + n, {}, {0: 1.0}), of_old)
        assert len(recorder.waiting) < record.WAITING_MAX
    recorder.close()
    assert len(recorder.rows()) == 1001


def test_values_without_a_column_are_counted(recorder):
    recorder.add(result(0), known(1, 2, 4))
    recorder.add(result(0, channel=1), known(1, 3, 5))
    assert recorder.left_out == 2
    first, second = recorder.rows()
    assert (second["channel"], first["adev_2"], second["adev_2"]) == ("1", "0.001", "")


def test_rows_that_wait_for_their_names_in_hundreds_of_stretches(recorder):
    stretches = range(1, 500)
    for stretch in stretches:
        one = wire.Result(0, 0, 99, {}, {0: 1.0}, stretch=stretch)
        recorder.add(one, wire.Channel(stretch))
    assert len(recorder.patient) <= record.WAITING_MAX + 1
    recorder.close()
    assert [int(row["stretch"]) for row in recorder.rows()] == list(stretches)
