"""Session files (.davarlab.json), the cache of a fleet, captures of `live --record`: with any
bytes, and correct ones with a changed value, they are accepted or rejected. Existing data are never
lost.
"""

import copy
import json
import math
from types import SimpleNamespace

import pytest
from davar.wire import record
from davarfleet import store
from davarlab import model as models
from davarlab.errors import BadInput
from davarlab.workbench import steps as sessions
from davarlab.workbench.session.session import Session
from hypothesis import example, given
from hypothesis import strategies as st
from lawful import damaged, examples

ROWS = "time_s,gyro_z_dps,temp_degC\n" + "".join(
    f"{place / 50:.2f},{math.sin(place * place % 997):.6g},{place % 7}\n" for place in range(1000)
)
WHITE = models.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3})
LINE = models.Term("sinusoid", {"frequency_hz": 0.7, "amplitude_dps": 0.02})
MODEL = models.Model(50.0, "gyro_z_dps", [WHITE])
TEXTS = (
    *("gyro_z_dps", "nowhere.csv", "x", "time_s", "[]", models.text_of(MODEL)),
    *('["gyro_z_dps", [], []]', '["gyro_z_dps", [0, 30], []]', '["temp_degC", [], []]'),
)
KEYS = st.sampled_from(
    ("columns", "rate_hz", "sensor", "name", "quantity", "axis", "unit", "factor", "odd")
)
JSON = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(-3, 3),
        st.integers(),
        st.floats(),
        st.text(max_size=5),
        st.sampled_from(TEXTS),
    ),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=6,
)


def places_in(value, way=()):
    """The paths to every value in a JSON text."""
    yield way
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places_in(value[key], (*way, key))


@st.composite
def changed(draw, data):
    """The same data with some values changed or removed."""
    data = copy.deepcopy(data)
    for _ in range(draw(st.integers(1, 2))):
        way = draw(st.sampled_from([way for way in places_in(data) if way]))
        inner = data
        for key in way[:-1]:
            inner = inner[key]
        if draw(st.integers(0, 4)) == 0:
            del inner[way[-1]]
        else:
            inner[way[-1]] = draw(JSON)
    return data


def session(path):
    """A session of two steps and two views, as the program writes it."""
    steps = sessions.Steps(path)
    columns = (
        ("time_s", "time", "", "s"),
        ("gyro_z_dps", "gyro", "z", "deg/s"),
        ("temp_degC", "temp", "", "degC"),
    )
    names = ("name", "quantity", "axis", "unit", "factor", "doubt", "unused")
    steps.log = {
        "columns": [dict(zip(names, (*column, 1.0, "", ""))) for column in columns],
        "rate_hz": None,
        "sensor": None,
        "as_recorded": False,
        "names": None,
        "skip": 0,
    }
    steps.held_out = str(path)
    warm = {"kind": "warm_up", "amplitude_dps": 0.01, "time_constant_s": 100.0}
    for selection in (
        sessions.Selection("gyro_z_dps", (), ((1.0, 2.0),)),
        sessions.Selection("gyro_z_dps"),
    ):
        steps.selection = selection
        steps.grow("a first model", MODEL, root=True, error=0.1, floor=0.03)
        steps.grow("a line", models.Model(50.0, "gyro_z_dps", [WHITE, LINE]), off=[warm])
    return json.loads(steps.path.read_bytes())


class Opening:
    """A recording, a valid session of it, and opened(): the session on the page with other bytes
    beside the recording, or None if they are rejected.
    """

    def __init__(self, work):
        self.folder = work.folder
        self.recording = work.file("r.csv", ROWS)
        self.path = work / "r.csv.davarlab.json"
        self.valid = session(self.recording)

    def opened(self, text):
        written = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
        self.path.write_bytes(written)
        seen = Session(self.folder)
        try:
            seen.intake.open(str(self.recording))
            seen.stepping.step()
            return seen.everything()
        except BadInput as why:
            assert len(str(why)) < 2000
            assert self.path.read_bytes() == written
            return None


@pytest.fixture
def opening(work):
    return Opening(work)


def test_the_session_that_was_written_is_opened_as_it_was(opening):
    shown = opening.opened(json.dumps(opening.valid))
    assert (shown["current"], len(shown["steps"]), len(shown["selections"])) == (1, 2, 2)
    assert shown["held_out"] == str(opening.recording)
    assert json.loads(opening.path.read_bytes()) == opening.valid


@given(data=st.data())
@examples(80)
def test_a_session_with_changed_values(opening, data):
    made = data.draw(changed(opening.valid))
    if opening.opened(json.dumps(made)) is not None:
        kept = json.loads(opening.path.read_bytes())
        assert kept.keys() - made.keys() == (set() if "held_out" in made else {"held_out"})


@given(data=st.data())
@examples(60)
def test_a_session_of_any_bytes(opening, data):
    valid = json.dumps(opening.valid).encode()
    opening.opened(data.draw(st.binary(max_size=60) | damaged(valid) | JSON.map(json.dumps)))


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"a":' * 100_000, '{"sha256": "x", "version": ' + "9" * 10_000 + "}"],
    ids=["lists", "objects", "number"],
)
def test_a_session_that_is_nested_too_deep(opening, text):
    assert opening.opened(text) is None


ROW = {"verdict": "none", "chance": {"warm_up": 1.0}, "coefficients": {"a.b": [1.0, 0.5, 2.0]}}
UNIT = {"marker": "m", "address": "a", "seconds": 1.0, "rows": [ROW]}


@given(text=st.binary(max_size=60) | JSON.map(json.dumps) | changed(UNIT).map(json.dumps))
@example("[" * 100_000)
@example('{"marker": "m"}')
@examples(150)
def test_the_cache_entry_of_a_unit_with_any_content(work, text):
    """With other content the unit counts as not done."""
    kept = store.Store(work / "fleet")
    kept.path("a").write_bytes(text if isinstance(text, bytes) else text.encode())
    store.done(kept.kept("a"), "m", True)


OTHERS = ",".join(["1.5"] * (len(record.FIELDS) - 3))
CAPTURE = ",".join(record.FIELDS) + ",adev_1,adev_2\n"
CAPTURE += "".join(f"0,{1 + place // 4},{100 * place},{OTHERS},0.5,0.25\n" for place in range(9))


@given(
    data=st.binary(max_size=300) | damaged(CAPTURE.encode()) | st.just(CAPTURE.encode()),
    results=st.integers(1, 3),
)
@examples(100)
def test_a_file_that_exists_stays_when_results_are_recorded(work, data, results):
    """`live --record FILE`."""
    for path in work.folder.iterdir():
        path.unlink()
    path = work.file("live.csv", data)
    recorder = record.Recorder(path, lambda text: None)
    setup = SimpleNamespace(setup={"rate_hz": 100.0}, clusters={0: 1})
    for place in range(results):
        result = {"channel": 0, "stretch": 1 + place // 2, "epoch": 7 + place}
        result |= {"values": {"window_samples": 600}, "adev": {0: 0.5}, "deviation": {}}
        recorder.add(SimpleNamespace(**result), setup)
    recorder.close()
    written = recorder.path.read_bytes()
    if recorder.path == path:
        whole = data[: data.rfind(b"\n") + 1]
        assert written.startswith(whole)
        rows = written[len(whole) :].decode().splitlines()
    else:
        assert path.read_bytes() == data
        rows = written.decode().splitlines()
    assert len(rows) - rows[0].startswith("channel,") == results
    header = written.decode(errors="replace").split("\n")[0].strip().split(",")
    found = [dict(zip(header, row.split(","))) for row in rows[-results:]]
    shown = [(one["epoch"], one["window_samples"], one["adev_1"]) for one in found]
    assert shown == [(str(7 + place), "600", "0.5") for place in range(results)]
    stretches = [int(one["stretch"]) for one in found]
    assert [one - stretches[0] for one in stretches] == [place // 2 for place in range(results)]
