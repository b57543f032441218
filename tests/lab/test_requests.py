"""The workbench's server answers only the page that has its token, from its own origin, on this
machine. Requests of the wrong type, made from its own schema, and sessions and paths of other
people: 400, never 500, never a wait. In this process; one test ends a server that computes.
"""

import asyncio
import contextlib
import hashlib
import hmac
import json
import os
import re
import signal
import subprocess
import sys
import threading
import typing
import urllib.parse
import urllib.request

import numpy as np
import pytest
from asking import ROOT, run
from davarlab.errors import BadInput
from davarlab.workbench import schema
from davarlab.workbench.server import Server
from davarlab.workbench.session import session
from davarlab.workbench.steps import Steps
from lab_bench import write_csv
from websockets.sync.client import connect

HOST, TOKEN = "127.0.0.1:8000", "t" * 22
LIMIT_S = 300  # after which a server hangs; a busy machine is no fault
POSTED = (session.ACTION, session.CODE)
QUERIES = {name for name, (kind, _) in session.CALLS.items() if kind not in POSTED}
CALLED = [name for name in session.CALLS if name != "tutorial"]
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
PLACES = {  # token, origin, host
    "no token": (None, f"http://{HOST}", HOST),
    "another token": ("u" * 22, f"http://{HOST}", HOST),
    "the beginning of the token": (TOKEN[:-1], f"http://{HOST}", HOST),
    "an empty token": ("", f"http://{HOST}", HOST),
    "another origin": (TOKEN, "http://example.invalid", HOST),
    "another port of this machine": (TOKEN, "http://127.0.0.1:8001", HOST),
    "another host": (TOKEN, None, "example.invalid"),
}


class Page:
    """A page that was opened with the token, on a server whose ASGI application is called as a web
    server would call it. code: as if a person at a terminal had started it.
    """

    def __init__(self, folder, code=True):
        self.folder, self.session = folder, session.Session(folder, code=code)
        self.server = Server(self.session)
        self.server.token = TOKEN
        self.app = self.server.app()
        self.loop = self.server.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        self.headers = {"host": HOST, "origin": f"http://{HOST}", "x-davar-token": TOKEN}

    def close(self):
        for pool in (self.server.worker, self.server.reader, self.server.planner):
            pool.shutdown(wait=True)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()

    def scope(self, kind, path, headers, **more):
        """headers: in place of the page's; None: without."""
        where, _, query = path.partition("?")
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        there = {name: one for name, one in {**self.headers, **named}.items() if one is not None}
        return {
            "type": kind,
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": "http" if kind == "http" else "ws",
            "path": urllib.parse.unquote(where),
            "raw_path": where.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [(name.lower().encode(), value.encode()) for name, value in there.items()],
            "client": ("127.0.0.1", 50000),
            "server": ("127.0.0.1", 8000),
            **more,
        }

    def request(self, path, data=None, **headers):
        """(status, body)."""
        sent = [{"type": "http.request", "body": data or b"", "more_body": False}]
        scope = self.scope("http", path, headers, method="GET" if data is None else "POST")
        answers = []

        async def receive():
            return sent.pop(0) if sent else await asyncio.Event().wait()

        async def send(message):
            answers.append(message)

        coroutine = self.app(scope, receive, send)
        asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(LIMIT_S)
        return answers[0]["status"], b"".join(one.get("body", b"") for one in answers[1:])

    def call(self, what, fields, query=False):
        """(status, the answer of an API call)."""
        if query:
            return self.request(f"/api/{what}?{urllib.parse.urlencode(fields)}")
        return self.request(f"/api/{what}", json.dumps(fields).encode())

    def all(self):
        return json.loads(self.request("/api/all")[1])

    @contextlib.contextmanager
    def tab(self, path, **headers):
        """A websocket: a function that waits for the n-th message to it, and one that sends to the
        server. The first message: accepted or refused, with the code.
        """
        got, arrived, outbox = [], threading.Condition(), asyncio.Queue()

        async def send(message):
            with arrived:
                got.append(message)
                arrived.notify_all()

        def put(**message):
            self.loop.call_soon_threadsafe(outbox.put_nowait, message)

        def wait_for(count):
            with arrived:
                assert arrived.wait_for(lambda: len(got) >= count, LIMIT_S), got
                return got[count - 1]

        put(type="websocket.connect")
        scope = self.scope("websocket", path, {"x_davar_token": None, **headers}, subprotocols=[])
        ended = asyncio.run_coroutine_threadsafe(self.app(scope, outbox.get, send), self.loop)
        try:
            yield wait_for, put
        finally:
            put(type="websocket.disconnect", code=1000)
            ended.result(LIMIT_S)


def recording(path, seconds=60):
    count = 50 * seconds
    noise = np.random.default_rng(3).normal(0, 0.05, count)
    time, warm = np.arange(count) / 50, 20 + np.arange(count) / 1000
    return write_csv(path, {"time_s": time, "gyro_z_dps": noise, "temp_degC": warm}, "%.5f")


@pytest.fixture(scope="module")
def pages():
    """Opens pages: pages(folder, ...). With a recording in the folder it is open."""
    made = []

    def start(folder, **more):
        made.append(Page(folder, **more))
        if (folder / "rec.csv").exists():
            made[-1].session.intake.open(str(folder / "rec.csv"))
        return made[-1]

    yield start
    for one in made:
        one.close()


@pytest.fixture(scope="module")
def page(tmp_path_factory, pages):
    """The page of a recording that is open, for all tests."""
    return pages(recording(tmp_path_factory.mktemp("bench") / "rec.csv").parent)


@pytest.fixture
def own(tmp_path, pages):
    """A recording; a function that opens it as a new server would."""

    def start():
        return pages(tmp_path)

    start.recording = recording(tmp_path / "rec.csv")
    start.file = tmp_path / "rec.csv.davarlab.json"
    return start


# Who is answered.


@pytest.mark.parametrize("name", PLACES)
def test_nothing_is_answered_without_token_origin_and_host(page, name):
    token, origin, host = PLACES[name]
    query = "" if token is None else f"?token={token}"
    with page.tab(f"/events{query}", origin=origin, host=host) as (got, _):
        first = got(1)
    assert first["type"] != "websocket.accept"
    assert first.get("code") == 4403 or first.get("status") == 400, first
    assert page.server.tabs == set()
    given = {"x_davar_token": token, "origin": origin, "host": host}
    for path, data in (("/", None), ("/api/all", None), ("/api/go", b"{}"), ("/api/drop", b"x")):
        assert page.request(path, data, **given)[0] in (400, 403), path


@pytest.mark.parametrize("origin", [None, f"http://{HOST}"])
def test_a_websocket_with_the_token_is_accepted_and_gets_every_event(page, origin):
    with page.tab(f"/events?token={TOKEN}", origin=origin) as (got, send):
        assert got(1)["type"] == "websocket.accept"
        send(type="websocket.receive", bytes=b"\0\1")
        send(type="websocket.receive", text="text")
        page.server.tell(changed=3)
        assert json.loads(got(2)["text"]) == {"changed": 3}
    assert page.server.tabs == set()


def test_the_token_in_a_header_or_in_the_address_opens_the_page(page):
    assert page.request("/api/all")[0] == 200
    assert page.request(f"/api/all?token={TOKEN}", x_davar_token=None)[0] == 200
    status, body = page.request(f"/?token={TOKEN}", x_davar_token=None)
    assert (status, b"<title>" in body) == (200, True)
    for path, data in (("/api/go", None), ("/api/all", b"{}"), ("/api/nothing", b"{}")):
        assert page.request(path, data)[0] == 404  # a kind of request has its method


def test_code_runs_only_for_a_person_at_this_machine(page, pages, tmp_path):
    """Not through a proxy, not without an origin, and not on a server that nobody at a terminal
    has started."""
    for headers in (
        {"origin": None},
        *({name: "10.0.0.1"} for name in ("forwarded", "x_forwarded_for", "x_real_ip", "via")),
    ):
        assert page.request("/api/check_own", b"{}", **headers)[0] == 403, headers
    assert page.request("/api/check_own", b"{}")[0] == 400  # it lacks its fields
    assert pages(tmp_path, code=False).request("/api/check_own", b"{}")[0] == 403


def test_a_tab_that_comes_back_can_test_the_server_first(page):
    proof = hmac.new(TOKEN.encode(), b"n" * 16, hashlib.sha256).hexdigest().encode()
    for nonce, answer in (("n" * 16, (200, proof)), *((n, None) for n in ("n" * 15, "n" * 65, ""))):
        got = page.request(f"/proof?nonce={nonce}", x_davar_token=None)
        assert got == answer if answer else got[0] == 400


# What is asked.


def fields_of(page, what):
    return schema.fields_of(page.session.calls[what].run).model_fields


def plain(field):
    """Is the type of a field one of these, or None beside it."""
    return set(kinds_of(field)) <= {str, int, float, bool, type(None)}


def kinds_of(field):
    return typing.get_args(field.annotation) or (field.annotation,)


def accepts(field, value, query):
    """Does the schema take this value, by itself, for the field? An oracle of its own for the plain
    types, so that a lax schema is found.
    """
    kinds = kinds_of(field)
    if query:
        text = str(value)
        number = re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", text)
        return str in kinds or float in kinds and number or int in kinds and text.isdigit()
    none = type(None) in kinds and value is None
    return none or type(value) in kinds or float in kinds and type(value) is int


def check(status, answer, asked):
    assert status in (200, 400, 409), (asked, answer[:300])
    assert status == 200 or "\n" not in json.loads(answer)["error"], asked


def limited(kind):
    """Has every text and number in this type a limit?"""
    if kind in (bool, type(None)) or typing.get_origin(kind) in (typing.Annotated, typing.Literal):
        return True
    if typing.get_origin(kind):
        return all(one is ... or limited(one) for one in typing.get_args(kind))
    return issubclass(kind, schema.Given)


@pytest.mark.parametrize("what", session.CALLS)
def test_every_argument_of_a_request_has_a_limit(page, what):
    """Of the limits that pydantic keeps beside a type."""
    for name, one in fields_of(page, what).items():
        assert one.metadata or limited(one.annotation), name


@pytest.mark.parametrize("what", CALLED)
def test_a_field_of_the_wrong_type_is_named(page, what):
    fields, query = fields_of(page, what), what in QUERIES
    required = {
        name: 0 if name in ("place", "number", "channel") else "x"
        for name, one in fields.items()
        if one.is_required()
    }
    for name, field in fields.items():
        for value in WRONG:
            text = isinstance(value, str)
            if query and not isinstance(value, (str, int, float)):
                continue
            if what in ("open", "listen") and text:
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


@pytest.mark.parametrize("what", [name for name in CALLED if name not in QUERIES])
def test_what_is_no_object_is_refused(page, what):
    for text in RAW:
        status, answer = page.request(f"/api/{what}", text)
        check(status, answer, text[:20])
        assert status == 400


# What stands beside the recording.


def refused(own):
    done = run("open", "--no-browser", own.recording)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert own.file.name in done.stderr
    return done.stderr


def test_a_link_in_place_of_a_session_is_neither_read_nor_written_through(own):
    target = own.file.with_name("target")
    own.file.symlink_to(target)
    assert "symbolic link" in refused(own)
    assert not target.exists()
    target.write_text("{}")
    refused(own)
    assert target.read_text() == "{}"
    own.file.unlink()
    own.file.symlink_to(own.file)
    refused(own)
    own.file.unlink()
    os.mkfifo(own.file)
    assert "FIFO" in refused(own)


def test_a_link_that_comes_later_is_not_written_through(own):
    page, target = own(), own.file.with_name("target")
    kept = own.file.read_bytes()
    own.file.unlink()
    own.file.symlink_to(target)
    for _ in range(2):  # there is no target; there is one
        status, answer = page.call("refit", {"state": page.all()["state"]})
        assert (status, "symbolic link" in json.loads(answer)["error"]) == (400, True)
        target.write_bytes(kept)
    assert target.read_bytes() == kept


def test_markup_in_the_words_of_a_session_is_refused(own):
    own()
    whole = json.loads(own.file.read_text())
    step = whole["trees"][whole["selection"]]["steps"][0]
    step["did"] = '<a href="https://example.invalid/">x</a>'
    own.file.write_text(json.dumps(whole))
    with pytest.raises(BadInput, match="did"):
        Steps.beside(own.recording)


def test_a_session_with_the_old_word_for_a_selection_is_read(own):
    own()
    whole = json.loads(own.file.read_text())
    old = {name: value for name, value in whole.items() if name != "selection"}
    own.file.write_text(json.dumps({**old, "sight": whole["selection"]}))
    assert Steps.beside(own.recording).seen == whole["selection"]


def test_a_session_that_names_a_program_runs_none_and_says_that_it_is_one(own):
    """Somebody sent the recording, the session and the program beside it."""
    own()
    whole, ran = json.loads(own.file.read_text()), own.file.with_name("ran")
    program = own.file.with_name("rec.csv.heater_fix.py")
    program.write_text(f"open({str(ran)!r}, 'w')\n")
    step = whole["trees"][whole["selection"]]["steps"][0]
    step["text"] += '[[effect]]\nkind = "heater_fix"\ncoefficient = 1.0\n'
    own.file.write_text(json.dumps(whole))
    said = refused(own)
    assert f"{program} is a program that runs with your rights" in said
    assert said.index("only if you know where it is from") < said.index("--effects")
    assert not ran.exists()


def test_a_held_out_recording_of_a_session_that_is_no_file_is_left(own):
    own()
    whole, fifo = json.loads(own.file.read_text()), own.file.with_name("fifo.csv")
    os.mkfifo(fifo)
    for path in ("/proc/kmsg", "/dev/zero", str(fifo), "nowhere"):
        own.file.write_text(json.dumps({**whole, "held_out": path}))
        there = own().all()
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
    environment = {"PYTHONPATH": str(ROOT / "python"), "XDG_STATE_HOME": str(tmp_path / "state")}
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
    asked = urllib.request.Request(
        f"http://{place.netloc}/api/open",
        json.dumps({"path": str(made), "model": str(model)}).encode(),
        {"X-Davar-Token": token},
    )

    def ask():
        with contextlib.suppress(OSError):  # the server ends meanwhile
            urllib.request.urlopen(asked, timeout=LIMIT_S).close()

    pending = threading.Thread(target=ask)
    with connect(f"ws://{place.netloc}/events?token={token}") as events:
        pending.start()
        assert "progress" in json.loads(events.recv(timeout=LIMIT_S))  # it has begun
        assert pending.is_alive()
    server.send_signal(signal.SIGINT)
    said = server.communicate(timeout=LIMIT_S)[1]
    pending.join()
    told = [line for line in said.splitlines() if "the workbench is open" not in line]
    assert (server.returncode, told) == (0, [])
    assert not list(tmp_path.glob("*.partial"))


def test_the_options_of_a_plan_keep_the_order_of_the_planner():
    """Whatever the order of a set is, which differs from one start of Python to the next."""
    script = (
        "from davarlab.workbench import plans, schema\n"
        "given = {'core': 'cortex-m4f', 'bandwidth': '33:2', 'lsb': '0.05', 'rate': '1000'}\n"
        "print(*schema.request('plan', plans.plan, query=given))"
    )
    printed = {
        subprocess.run(
            [sys.executable, "-c", script],
            env=os.environ | {"PYTHONHASHSEED": seed},
            text=True,
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "2", "3", "4")
    }
    assert printed == {"rate lsb bandwidth core\n"}
