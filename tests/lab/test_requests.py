"""The workbench's server on requests of the wrong type, made from its own schema, and on sessions
and paths of other people: 400, never 500, never a wait.
"""

import json
import os
import pty
import re
import signal
import socket
import subprocess
import sys
import tempfile
import typing
import unittest
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import numpy as np
from asking import ROOT
from davarlab.workbench import schema
from davarlab.workbench.visit import visit
from websockets.sync.client import connect

LIMIT_S = 300  # behind which a server hangs; a busy machine is no fault
STATE = tempfile.TemporaryDirectory()  # of the tests, not the user's
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(ROOT / "tools/lab"),
    "XDG_STATE_HOME": STATE.name,
}
POSTED = (visit.ACTION, visit.CODE)
QUERIES = {name for name, (kind, _) in visit.CALLS.items() if kind not in POSTED}
WRONG = (
    None,
    True,
    5,
    -1,
    1.5,
    1e300,
    10**30,
    "",
    "x",
    "5",
    "nan",
    "\0",
    "a" * 5000,
    [],
    [1],
    [[]],
    [["a", 2]],
    {},
    {"a": 1},
    {"a": [1]},
    [None],
    [True],
)
RAW = (
    b"",
    b"[1]",
    b"5",
    b'"x"',
    b"null",
    b"{",
    b"[" * 100_000,
    b'{"a": 1}',
    b'{"number": 1e999}',
    b'{"number": NaN}',
    b"{}{}",
    b"\xff\xfe",
    b'{"path": "\xff"}',
    b'{"path": "\\ud800"}',
    b'{"number": ' + b"9" * 5000 + b"}",
    b'{"path": "' + b"a" * (5 << 20) + b'"}',
)


def recording(path, seconds=60):
    rng = np.random.default_rng(3)
    path.write_text(
        "time_s,gyro_z_dps,temp_degC\n"
        + "".join(
            f"{i / 50:.2f},{rng.normal(0, 0.05):.5f},{20 + i / 1000}\n" for i in range(50 * seconds)
        )
    )
    return path


class Bench:
    """davarlab open in a folder, started by a person in a terminal, and requests of its page."""

    def __init__(self, folder, *arguments):
        self.terminal, its = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-B", "-m", "davarlab", "open", "--no-browser", *map(str, arguments)],
            cwd=folder,
            env=ENVIRONMENT,
            text=True,
            stdin=its,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        os.close(its)
        place = urllib.parse.urlsplit(self.process.stdout.readline().strip())
        self.origin, self.token = (
            f"http://{place.netloc}",
            urllib.parse.parse_qs(place.query)["token"][0],
        )

    def request(self, path, data=None):
        """(status, the answer)."""
        try:
            with urllib.request.urlopen(
                urllib.request.Request(
                    self.origin + path,
                    data,
                    {"X-Davar-Token": self.token, "Origin": self.origin},
                ),
                timeout=LIMIT_S,
            ) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as why:
            with why:
                return why.code, why.read()

    def ask(self, what, fields):
        if what in QUERIES:
            return self.request(f"/api/{what}?{urllib.parse.urlencode(fields)}")
        return self.request(f"/api/{what}", json.dumps(fields).encode())

    def act(self, what, **fields):
        """An action on what is shown now."""
        return self.ask(what, {"state": json.loads(self.ask("all", {})[1])["state"], **fields})

    def stop(self, number=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(number)
        said = self.process.communicate(timeout=LIMIT_S)[1]
        if self.terminal is not None:
            os.close(self.terminal)
            self.terminal = None
        return self.process.returncode, said


def accepts(field, value, query):
    """Does the schema take this value, by itself, for the field? An oracle of its own for the plain
    types, so that a lax schema is found.
    """
    kinds = typing.get_args(field.annotation) or (field.annotation,)
    if query:
        text = str(value)
        return (
            str in kinds
            or float in kinds
            and re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", text)
            or int in kinds
            and text.isdigit()
        )
    return any(
        kind is type(value)
        or kind is type(None)
        and value is None
        or kind is float
        and type(value) is int
        for kind in kinds
    )


def plain(field):
    """Is the type of a field one of these, or None beside it."""
    kinds = typing.get_args(field.annotation) or (field.annotation,)
    return set(kinds) <= {str, int, float, bool, type(None)}


class Requests(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.bench = Bench(cls.folder, recording(cls.folder / "rec.csv"))
        cls.addClassCleanup(cls.bench.stop)

    def check(self, status, answer, asked):
        self.assertIn(status, (200, 400, 409), (asked, answer[:300]))
        if status != 200:
            self.assertNotIn("\n", json.loads(answer)["error"], asked)

    def test_every_request_of_the_server_has_a_schema(self):
        there = visit.Visit(self.folder)
        self.assertEqual(
            set(schema.REQUESTS),
            set(there.calls) | {"drop"},
        )

    def test_a_field_of_the_wrong_type_is_named(self):
        refused = 0
        for what, model in schema.REQUESTS.items():
            if what in ("drop", "tutorial"):
                continue
            required = {
                name: 0 if name in ("place", "number", "channel") else "x"
                for name, one in model.model_fields.items()
                if one.is_required()
            }
            for name, field in model.model_fields.items():
                for value in WRONG:
                    if (
                        what in QUERIES
                        and not isinstance(value, (str, int, float))
                        or what in ("open", "listen")
                        and isinstance(value, str)
                    ):
                        continue
                    with self.subTest(what, field=name, value=str(value)[:30]):
                        status, answer = self.bench.ask(what, {**required, name: value})
                        self.check(status, answer, (what, name, value))
                        if plain(field) and not accepts(field, value, what in QUERIES):
                            self.assertEqual(status, 400)
                            self.assertIn(f"{what}: ", json.loads(answer)["error"])
                            refused += name in json.loads(answer)["error"]
            status, answer = self.bench.ask(what, {**required, "unheard_of": 1})
            self.assertEqual(
                (status, "unheard_of" in json.loads(answer)["error"] or "x" in required.values()),
                (400, True),
                what,
            )
        self.assertGreater(refused, 100)
        self.assertEqual(self.bench.ask("step", {})[0], 200)

    def test_what_is_no_object_is_refused(self):
        for what in schema.REQUESTS:
            if what not in QUERIES and what not in ("drop", "tutorial"):
                for text in RAW:
                    with self.subTest(what, text=text[:20]):
                        status, answer = self.bench.request(f"/api/{what}", text)
                        self.check(status, answer, text[:20])
                        self.assertEqual(status, 400)

    def test_a_binary_message_of_a_tab_ends_nothing(self):
        with connect(f"ws{self.bench.origin[4:]}/events?token={self.bench.token}") as tab:
            tab.send(b"\0\1")
            tab.send("text")
            self.bench.act("go", number=0)
            self.assertIn("changed", json.loads(tab.recv(timeout=LIMIT_S)))

    def test_paths_that_are_no_files_are_refused_by_name(self):
        os.mkfifo(self.folder / "fifo.csv")
        (self.folder / "loop.csv").symlink_to("loop.csv")
        with socket.socket(socket.AF_UNIX) as there:
            there.bind(str(self.folder / "socket.csv"))
            for path in (
                "fifo.csv",
                "loop.csv",
                "socket.csv",
                ".",
                "/dev/zero",
                "/proc/kmsg",
                "nowhere.csv",
                "a" * 3000,
                "a/" * 2000,
            ):
                for what, fields in (
                    ("open", {"path": path}),
                    ("open", {"path": str(self.folder / "rec.csv"), "model": path}),
                ):
                    with self.subTest(what, path=path[:20]):
                        status, answer = self.bench.ask(what, fields)
                        self.assertEqual(
                            (status, path in json.loads(answer)["error"]), (400, True), answer[:300]
                        )
        self.assertEqual(self.bench.ask("open", {"path": str(self.folder / "rec.csv")})[0], 200)


class Sessions(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = Path(kept.name)
        self.recording = recording(self.folder / "rec.csv")
        self.session = self.folder / "rec.csv.davarlab.json"

    def refused(self, *arguments):
        done = subprocess.run(
            [
                sys.executable,
                "-B",
                "-m",
                "davarlab",
                "open",
                "--no-browser",
                self.recording,
                *arguments,
            ],
            env=ENVIRONMENT,
            text=True,
            capture_output=True,
            timeout=LIMIT_S,
        )
        self.assertEqual(
            (done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1), done.stderr
        )
        self.assertIn(self.session.name, done.stderr)
        return done.stderr

    def test_a_link_in_place_of_a_session_is_neither_read_nor_written_through(self):
        target = self.folder / "target"
        self.session.symlink_to(target)
        self.assertIn("symbolic link", self.refused())
        self.assertFalse(target.exists())
        target.write_text("{}")
        self.refused()
        self.assertEqual(target.read_text(), "{}")
        self.session.unlink()
        self.session.symlink_to(self.session)
        self.refused()
        self.session.unlink()
        os.mkfifo(self.session)
        self.assertIn("FIFO", self.refused())

    def test_a_link_that_comes_later_is_not_written_through(self):
        bench, target = Bench(self.folder, self.recording), self.folder / "target"
        self.addCleanup(bench.stop)
        kept = self.session.read_bytes()
        self.session.unlink()
        self.session.symlink_to(target)
        status, answer = bench.act("refit")
        self.assertEqual((status, "symbolic link" in json.loads(answer)["error"]), (400, True))
        target.write_bytes(kept)
        self.assertEqual(bench.act("refit")[0], 400)
        self.assertEqual(target.read_bytes(), kept)

    def test_every_field_of_a_session_that_is_of_another_type_is_refused(self):
        bench = Bench(self.folder, self.recording)
        bench.act("remove", place=1, kind="bias_instability")
        self.assertEqual(bench.stop()[0], 0)
        whole = json.loads(self.session.read_text())
        whole["log"] = {"columns": [], "rate_hz": None, "sensor": None}

        def places(value, way=()):
            for key, inside in (
                value.items()
                if isinstance(value, dict)
                else enumerate(value)
                if isinstance(value, list)
                else ()
            ):
                yield (*way, key)
                yield from places(inside, (*way, key))

        def with_value(way, value):
            made = json.loads(json.dumps(whole))
            inside = made
            for key in way[:-1]:
                inside = inside[key]
            inside[way[-1]] = value
            return made

        from davarlab.errors import BadInput
        from davarlab.workbench.steps import Steps

        tried = 0
        for way in places(whole):
            for value in (5, -1, "", "<b>x</b>", [[]], {"a": [1]}, True):
                made = with_value(way, value)
                self.session.write_text(json.dumps(made))
                try:
                    found = Steps.beside(self.recording)
                except BadInput as why:
                    self.assertIn(self.session.name, str(why))
                    tried += 1
                    continue
                self.assertFalse([one.did for one in found.steps if "<" in one.did], (way, value))
        self.assertGreater(tried, 100)
        self.session.write_text(
            json.dumps(
                with_value(
                    ("trees", whole["sight"], "steps", 0, "did"),
                    '<a href="https://example.invalid/">x</a>',
                )
            )
        )
        self.assertIn("did", self.refused())

    def test_a_held_out_recording_of_a_session_that_is_no_file_is_left(self):
        Bench(self.folder, self.recording).stop()
        whole = json.loads(self.session.read_text())
        os.mkfifo(self.folder / "fifo.csv")
        for path in ("/proc/kmsg", "/dev/zero", str(self.folder / "fifo.csv"), "nowhere"):
            self.session.write_text(json.dumps({**whole, "held_out": path}))
            bench = Bench(self.folder, self.recording)
            try:
                there = json.loads(bench.ask("all", {})[1])
                self.assertEqual((there["held_out"], path in there["not_held"]), (None, True))
            finally:
                bench.stop()


class Interrupted(unittest.TestCase):
    def test_ctrl_c_ends_it_while_it_computes(self):
        """600 effects take minutes to fit."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            model = folder / "model.toml"
            lines = "".join(
                (
                    f'[[effect]]\nkind = "sinusoid"\nfrequency_hz = {0.5 + k * 0.04:.4f}\n'
                    "amplitude_dps = 0.001\n"
                )
                for k in range(600)
            )
            model.write_text(
                (
                    '[sensor]\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
                    "coefficient_deg_per_sqrt_h = 0.3\n"
                )
                + lines
            )
            bench = Bench(folder, recording(folder / "rec.csv", 600))
            events = connect(f"ws{bench.origin[4:]}/events?token={bench.token}")
            with events:
                pending = subprocess.Popen(
                    [
                        sys.executable,
                        "-c",
                        "import sys, urllib.request as u; u.urlopen(u.Request(sys.argv[1], "
                        "sys.argv[2].encode(), "
                        "{'X-Davar-Token': sys.argv[3]}))",
                        f"{bench.origin}/api/open",
                        json.dumps({"path": str(folder / "rec.csv"), "model": str(model)}),
                        bench.token,
                    ],
                    stderr=subprocess.DEVNULL,
                )
                self.addCleanup(pending.wait)
                self.assertIn("progress", json.loads(events.recv(timeout=LIMIT_S)))  # it has begun
                self.assertIsNone(pending.poll())
            status, said = bench.stop()
            self.assertEqual(
                (
                    status,
                    [line for line in said.splitlines() if "the workbench is open" not in line],
                ),
                (0, []),
            )
            self.assertEqual(
                [path.name for path in folder.iterdir() if path.name.endswith(".partial")], []
            )


if __name__ == "__main__":
    unittest.main()
