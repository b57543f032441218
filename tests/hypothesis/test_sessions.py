"""Session files (.davarlab.json), the cache of a fleet, captures of `live --record`: with any
bytes, and correct ones with a changed value, they are accepted or rejected. Existing data are never
lost.
"""

import copy
import json
import math
import unittest
from profile import examples
from types import SimpleNamespace

import asked
from damage import damaged
from davarfleet import store
from davarlab import model as models
from davarlab.errors import BadInput
from davarlab.wire import record
from davarlab.workbench import steps as sessions
from davarlab.workbench.visit import visit
from hypothesis import example, given
from hypothesis import strategies as st

ROWS = "time_s,gyro_z_dps,temp_degC\n" + "".join(
    f"{place / 50:.2f},{math.sin(place * place % 997):.6g},{place % 7}\n" for place in range(1000)
)
MODEL = models.Model(
    50.0, "gyro_z_dps", [models.Term("angle_random_walk", {"coefficient_deg_per_sqrt_h": 0.3})]
)
JSON = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(-3, 3),
        st.integers(),
        st.floats(),
        st.text(max_size=5),
        st.sampled_from(
            (
                "gyro_z_dps",
                "nowhere.csv",
                "x",
                "time_s",
                "[]",
                '["gyro_z_dps", [], []]',
                '["gyro_z_dps", [0, 30], []]',
                '["temp_degC", [], []]',
                models.text_of(MODEL),
            )
        ),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from(
                (
                    "columns",
                    "rate_hz",
                    "sensor",
                    "name",
                    "quantity",
                    "axis",
                    "unit",
                    "factor",
                    "odd",
                )
            ),
            inner,
            max_size=4,
        ),
    ),
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
    steps.log = {
        "columns": [
            {"name": name, "quantity": quantity, "axis": axis, "unit": unit, "factor": 1.0}
            for name, quantity, axis, unit in (
                ("time_s", "time", "", "s"),
                ("gyro_z_dps", "gyro", "z", "deg/s"),
                ("temp_degC", "temp", "", "degC"),
            )
        ],
        "rate_hz": None,
        "sensor": None,
        "as_recorded": False,
        "names": None,
        "skip": 0,
    }
    steps.held_out = str(path)
    for sight in (sessions.Sight("gyro_z_dps", (), ((1.0, 2.0),)), sessions.Sight("gyro_z_dps")):
        steps.sight = sight
        steps.grow("a first model", MODEL, root=True, error=0.1, floor=0.03)
        steps.grow(
            "a line",
            models.Model(
                50.0,
                "gyro_z_dps",
                [
                    *MODEL.terms,
                    models.Term("sinusoid", {"frequency_hz": 0.7, "amplitude_dps": 0.02}),
                ],
            ),
            off=[{"kind": "warm_up", "amplitude_dps": 0.01, "time_constant_s": 100.0}],
        )
    return json.loads(steps.path.read_bytes())


class Sessions(asked.Lawful):
    def setUp(self):
        super().setUp()
        self.recording = self.file("r.csv", ROWS)
        self.path = self.work / "r.csv.davarlab.json"
        self.valid = session(self.recording)

    def opened(self, text):
        """Opens the recording with such a session: returns the session on the page, or None if it
        was rejected.
        """
        written = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
        self.path.write_bytes(written)
        seen = visit.Visit(self.work)
        try:
            seen.intake.open(str(self.recording))
            seen.stepping.step()
            return seen.everything()
        except BadInput as why:
            self.assertLess(len(str(why)), 2000)
            self.assertEqual(self.path.read_bytes(), written)
            return None

    def test_the_session_that_was_written_is_opened_as_it_was(self):
        shown = self.opened(json.dumps(self.valid))
        self.assertEqual(
            (shown["current"], len(shown["steps"]), len(shown["sights"]), shown["held_out"]),
            (1, 2, 2, str(self.recording)),
        )
        self.assertEqual(json.loads(self.path.read_bytes()), self.valid)

    @given(st.data())
    @examples(120)
    def test_values_that_are_others(self, data):
        made = data.draw(changed(self.valid))
        shown = self.opened(json.dumps(made))
        if shown is not None:
            self.assertEqual(
                json.loads(self.path.read_bytes()).keys() - made.keys(),
                set() if "held_out" in made else {"held_out"},
            )

    @given(st.data())
    @examples(100)
    def test_any_bytes(self, data):
        self.opened(
            data.draw(
                st.one_of(
                    st.binary(max_size=60),
                    damaged(json.dumps(self.valid).encode()),
                    JSON.map(json.dumps),
                )
            )
        )

    def test_too_deep_nesting(self):
        for text in (
            "[" * 100_000,
            '{"a":' * 100_000,
            '{"sha256": "x", "version": ' + "9" * 10_000 + "}",
        ):
            self.assertIsNone(self.opened(text))


class Kept(asked.Lawful):
    """The cache entry of a unit. With any other content the unit counts as not done."""

    @given(
        st.one_of(
            st.binary(max_size=60),
            JSON.map(json.dumps),
            changed(
                {
                    "marker": "m",
                    "address": "a",
                    "seconds": 1.0,
                    "rows": [
                        {
                            "verdict": "none",
                            "chance": {"warm_up": 1.0},
                            "coefficients": {"a.b": [1.0, 0.5, 2.0]},
                        }
                    ],
                }
            ).map(json.dumps),
        )
    )
    @example("[" * 100_000)
    @example('{"marker": "m"}')
    @examples(200)
    def test_any_text(self, text):
        kept = store.Store(self.work / "fleet")
        kept.path("a").write_bytes(text if isinstance(text, bytes) else text.encode())
        store.done(kept.kept("a"), "m", True)


CAPTURE = (
    ",".join(record.FIELDS)
    + ",adev_1,adev_2\n"
    + "".join(
        f"0,{1 + place // 4},{100 * place},"
        + ",".join(["1.5"] * (len(record.FIELDS) - 3))
        + ",0.5,0.25\n"
        for place in range(9)
    )
)


class Captures(asked.Lawful):
    """`live --record FILE` with an existing FILE."""

    @given(
        st.one_of(st.binary(max_size=300), damaged(CAPTURE.encode()), st.just(CAPTURE.encode())),
        st.integers(1, 3),
    )
    @examples(120)
    def test_existing_files_stay(self, data, results):
        for path in self.work.iterdir():
            path.unlink()
        path = self.file("live.csv", data)
        said = []
        recorder = record.Recorder(path, said.append)
        made = [
            SimpleNamespace(
                channel=0,
                stretch=1 + place // 2,
                epoch=7 + place,
                values={"window_samples": 600},
                adev={0: 0.5},
                deviation={},
            )
            for place in range(results)
        ]
        setup = SimpleNamespace(setup={"rate_hz": 100.0}, clusters={0: 1})
        for one in made:
            recorder.add(one, setup)
        recorder.close()
        written = recorder.path.read_bytes()
        if recorder.path == path:
            whole = data[: data.rfind(b"\n") + 1]
            self.assertTrue(written.startswith(whole), "what was there")
            rows = written[len(whole) :].decode().splitlines()
        else:
            self.assertEqual(path.read_bytes(), data)
            rows = written.decode().splitlines()
        self.assertEqual(len(rows) - rows[0].startswith("channel,"), results)
        header = written.decode(errors="replace").split("\n")[0].strip().split(",")
        found = [dict(zip(header, row.split(","))) for row in rows[-results:]]
        self.assertEqual(
            [(one["epoch"], one["window_samples"], one["adev_1"]) for one in found],
            [(str(7 + place), "600", "0.5") for place in range(results)],
        )
        stretches = [int(one["stretch"]) for one in found]
        self.assertEqual(
            [one - stretches[0] for one in stretches], [one.stretch - 1 for one in made]
        )


if __name__ == "__main__":
    unittest.main()
