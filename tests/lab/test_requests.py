"""The workbench's server on requests of the wrong type, made from its own schema, and on sessions
and paths of other people: 400, never 500, never a wait. In this process; one test ends a server
that computes.
"""

import json
import os
import re
import signal
import subprocess
import sys
import typing
import urllib.parse
import urllib.request

import numpy as np
import pytest
from asking import ROOT, run
from davarlab.errors import BadInput
from davarlab.workbench import schema
from davarlab.workbench.steps import Steps
from davarlab.workbench.visit import visit
from lab_asgi import TOKEN, Page
from websockets.sync.client import connect

LIMIT_S = 300  # after which a server hangs; a busy machine is no fault
POSTED = (visit.ACTION, visit.CODE)
QUERIES = {name for name, (kind, _) in visit.CALLS.items() if kind not in POSTED}
WRONG = (
    *(None, True, 5, -1, 1.5, 1e300, 10**30, "", "x", "5", "nan", "\0", "a" * 5000),
    *([], [1], [[]], [["a", 2]], {}, {"a": 1}, {"a": [1]}, [None], [True]),
)
RAW = (
    *(b"", b"[1]", b"5", b'"x"', b"null", b"{", b"[" * 100_000, b'{"a": 1}', b"{}{}"),
    *(b'{"number": 1e999}', b'{"number": NaN}', b"\xff\xfe", b'{"path": "\xff"}'),
    *(b'{"path": "\\ud800"}', b'{"number": ' + b"9" * 5000 + b"}"),
    b'{"path": "' + b"a" * (5 << 20) + b'"}',
)
SKIPPED = ("drop", "tutorial")


def recording(path, seconds=60):
    rng = np.random.default_rng(3)
    rows = (
        f"{i / 50:.2f},{rng.normal(0, 0.05):.5f},{20 + i / 1000}\n" for i in range(50 * seconds)
    )
    path.write_text("time_s,gyro_z_dps,temp_degC\n" + "".join(rows))
    return path


def opened(folder):
    page = Page(folder)
    page.visit.intake.open(str(folder / "rec.csv"))
    return page


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of a recording that is open, for all tests."""
    folder = tmp_path_factory.mktemp("bench")
    recording(folder / "rec.csv")
    made = opened(folder)
    made.folder = folder
    yield made
    made.close()


@pytest.fixture
def own(tmp_path):
    """A recording; a function that opens it as a new server would."""
    recording(tmp_path / "rec.csv")
    pages = []

    def start():
        pages.append(opened(tmp_path))
        return pages[-1]

    start.session = tmp_path / "rec.csv.davarlab.json"
    start.recording = tmp_path / "rec.csv"
    yield start
    for one in pages:
        one.close()


def accepts(field, value, query):
    """Does the schema take this value, by itself, for the field? An oracle of its own for the plain
    types, so that a lax schema is found.
    """
    kinds = typing.get_args(field.annotation) or (field.annotation,)
    if query:
        text = str(value)
        number = re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", text)
        return str in kinds or float in kinds and number or int in kinds and text.isdigit()
    none = type(None) in kinds and value is None
    return none or any(
        kind is type(value) or kind is float and type(value) is int for kind in kinds
    )


def plain(field):
    """Is the type of a field one of these, or None beside it."""
    kinds = typing.get_args(field.annotation) or (field.annotation,)
    return set(kinds) <= {str, int, float, bool, type(None)}


def test_every_request_of_the_server_has_a_schema(tmp_path):
    assert set(schema.REQUESTS) == {*visit.Visit(tmp_path).calls, "drop"}


def check(status, answer, asked):
    assert status in (200, 400, 409), (asked, answer[:300])
    if status != 200:
        assert "\n" not in json.loads(answer)["error"], asked


@pytest.mark.parametrize("what", [name for name in schema.REQUESTS if name not in SKIPPED])
def test_a_field_of_the_wrong_type_is_named(page, what):
    fields = schema.REQUESTS[what].model_fields
    query = what in QUERIES
    required = {
        name: 0 if name in ("place", "number", "channel") else "x"
        for name, one in fields.items()
        if one.is_required()
    }
    for name, field in fields.items():
        for value in WRONG:
            text = isinstance(value, str)
            if (
                query
                and not isinstance(value, (str, int, float))
                or what in ("open", "listen")
                and text
            ):
                continue
            status, answer = page.call(what, {**required, name: value}, query)
            check(status, answer, (what, name, value))
            if plain(field) and not accepts(field, value, query):
                assert status == 400, (name, value)
                assert f"{what}: " in json.loads(answer)["error"]
                others = ((fields[one], given) for one, given in required.items() if one != name)
                if all(plain(one) and accepts(one, given, query) for one, given in others):
                    assert name in json.loads(answer)["error"], value
    status, answer = page.call(what, {**required, "unheard_of": 1}, query)
    assert status == 400
    assert "unheard_of" in json.loads(answer)["error"] or "x" in required.values()
    assert page.call("step", {}, True)[0] == 200


@pytest.mark.parametrize(
    "what", [name for name in schema.REQUESTS if name not in {*QUERIES, *SKIPPED}]
)
def test_what_is_no_object_is_refused(page, what):
    for text in RAW:
        status, answer = page.request(f"/api/{what}", text)
        check(status, answer, text[:20])
        assert status == 400


def refused(own):
    done = run("open", "--no-browser", own.recording)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert own.session.name in done.stderr
    return done.stderr


def test_a_link_in_place_of_a_session_is_neither_read_nor_written_through(own):
    target = own.session.with_name("target")
    own.session.symlink_to(target)
    assert "symbolic link" in refused(own)
    assert not target.exists()
    target.write_text("{}")
    refused(own)
    assert target.read_text() == "{}"
    own.session.unlink()
    own.session.symlink_to(own.session)
    refused(own)
    own.session.unlink()
    os.mkfifo(own.session)
    assert "FIFO" in refused(own)


def test_a_link_that_comes_later_is_not_written_through(own):
    page, target = own(), own.session.with_name("target")
    kept = own.session.read_bytes()
    own.session.unlink()
    own.session.symlink_to(target)
    status, answer = page.act("refit")
    assert (status, "symbolic link" in json.loads(answer)["error"]) == (400, True)
    target.write_bytes(kept)
    assert page.act("refit")[0] == 400
    assert target.read_bytes() == kept


def test_markup_in_the_words_of_a_session_is_refused(own):
    own()
    whole = json.loads(own.session.read_text())
    step = whole["trees"][whole["sight"]]["steps"][0]
    step["did"] = '<a href="https://example.invalid/">x</a>'
    own.session.write_text(json.dumps(whole))
    with pytest.raises(BadInput, match="did"):
        Steps.beside(own.recording)


def test_a_held_out_recording_of_a_session_that_is_no_file_is_left(own):
    own()
    whole = json.loads(own.session.read_text())
    fifo = own.session.with_name("fifo.csv")
    os.mkfifo(fifo)
    for path in ("/proc/kmsg", "/dev/zero", str(fifo), "nowhere"):
        own.session.write_text(json.dumps({**whole, "held_out": path}))
        there = json.loads(own().request("/api/all")[1])
        assert (there["held_out"], path in there["not_held"]) == (None, True)


@pytest.mark.slow
def test_ctrl_c_ends_it_while_it_computes(tmp_path):
    """600 effects take minutes to fit. A server of its own, as a person starts it."""
    model, made = tmp_path / "model.toml", recording(tmp_path / "rec.csv", 600)
    line = '[[effect]]\nkind = "sinusoid"\nfrequency_hz = {:.4f}\namplitude_dps = 0.001\n'
    model.write_text(
        '[sensor]\ncolumn = "gyro_z_dps"\n[[effect]]\nkind = "angle_random_walk"\n'
        "coefficient_deg_per_sqrt_h = 0.3\n"
        + "".join(line.format(0.5 + k / 25) for k in range(600))
    )
    environment = {"PYTHONPATH": str(ROOT / "tools/lab"), "XDG_STATE_HOME": str(tmp_path / "state")}
    server = subprocess.Popen(
        [sys.executable, "-B", "-m", "davarlab", "open", "--no-browser", str(made)],
        cwd=tmp_path,
        env={**os.environ, **environment},
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    place = urllib.parse.urlsplit(server.stdout.readline().strip())
    token = urllib.parse.parse_qs(place.query)["token"][0]
    assert len(token) == len(TOKEN)
    code = (
        "import sys, urllib.request as u; u.urlopen(u.Request(sys.argv[1], sys.argv[2].encode(), "
        "{'X-Davar-Token': sys.argv[3]}))"
    )
    asked = json.dumps({"path": str(made), "model": str(model)})
    words = [sys.executable, "-c", code, f"http://{place.netloc}/api/open", asked, token]
    with connect(f"ws://{place.netloc}/events?token={token}") as events:
        pending = subprocess.Popen(words, stderr=subprocess.DEVNULL)
        assert "progress" in json.loads(events.recv(timeout=LIMIT_S))  # it has begun
        assert pending.poll() is None
    server.send_signal(signal.SIGINT)
    said = server.communicate(timeout=LIMIT_S)[1]
    pending.wait()
    told = [line for line in said.splitlines() if "the workbench is open" not in line]
    assert (server.returncode, told) == (0, [])
    assert not list(tmp_path.glob("*.partial"))
