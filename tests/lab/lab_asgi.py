"""Requests to the workbench's server in this process: its ASGI application, called as a web server
would call it."""

import asyncio
import contextlib
import json
import threading
import urllib.parse

from davarlab.workbench.server import Server
from davarlab.workbench.visit.visit import Visit

HOST = "127.0.0.1:8000"
TOKEN = "t" * 22


def scope_of(kind, path, headers, **more):
    where, _, query = path.partition("?")
    return {
        "type": kind,
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "scheme": "http" if kind == "http" else "ws",
        "path": urllib.parse.unquote(where),
        "raw_path": where.encode(),
        "query_string": query.encode(),
        "root_path": "",
        "headers": [(name.lower().encode(), value.encode()) for name, value in headers.items()],
        "client": ("127.0.0.1", 50000),
        "server": ("127.0.0.1", 8000),
        **more,
    }


class Page:
    """A page that was opened with the token; code: as if a person at a terminal had started it."""

    def __init__(self, folder, code=True):
        self.visit = Visit(folder, code=code)
        self.server = Server(self.visit)
        self.server.token = TOKEN
        self.app = self.server.app()
        self.loop = asyncio.new_event_loop()
        self.server.loop = self.loop
        self.thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        self.headers = {"host": HOST, "origin": f"http://{HOST}", "x-davar-token": TOKEN}

    def close(self):
        for pool in (self.server.worker, self.server.reader, self.server.planner):
            pool.shutdown(wait=True)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()

    def run(self, coroutine, seconds=300):
        return asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(seconds)

    def request(self, path, data=None, method=None, **headers):
        """(status, body). headers: in place of the page's; None: without."""
        return self.run(
            self.asked(path, data, method or ("GET" if data is None else "POST"), headers)
        )

    async def asked(self, path, data, method, headers):
        sent = [{"type": "http.request", "body": data or b"", "more_body": False}]
        answers = []

        async def receive():
            return sent.pop(0) if sent else await asyncio.Event().wait()

        async def send(message):
            answers.append(message)

        scope = scope_of("http", path, self.with_headers(headers), method=method)
        await self.app(scope, receive, send)
        body = b"".join(one.get("body", b"") for one in answers[1:])
        return answers[0]["status"], body

    def with_headers(self, headers):
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        return {
            name: value for name, value in {**self.headers, **named}.items() if value is not None
        }

    def call(self, what, fields, query=False):
        """(status, the answer of an API call)."""
        if query:
            return self.request(f"/api/{what}?{urllib.parse.urlencode(fields)}")
        return self.request(f"/api/{what}", json.dumps(fields).encode())

    def act(self, what, **fields):
        """An action on what is shown now."""
        return self.call(
            what, {"state": json.loads(self.request("/api/all")[1])["state"], **fields}
        )

    @contextlib.contextmanager
    def tab(self, path, **headers):
        """A websocket: what it got so far as a list, and a function that sends to the server. The
        first entry: accepted or refused, with the code."""
        got, arrived, outbox = [], threading.Condition(), asyncio.Queue()

        async def send(message):
            with arrived:
                got.append(message)
                arrived.notify_all()

        def put(**message):
            self.loop.call_soon_threadsafe(outbox.put_nowait, message)

        def wait_for(count):
            with arrived:
                assert arrived.wait_for(lambda: len(got) >= count, 300), got
                return got[count - 1]

        put(type="websocket.connect")
        scope = scope_of("websocket", path, self.with_headers(headers), subprotocols=[])
        ended = asyncio.run_coroutine_threadsafe(self.app(scope, outbox.get, send), self.loop)
        try:
            yield wait_for, put
        finally:
            put(type="websocket.disconnect", code=1000)
            ended.result(300)
