"""The workbench's own web server: this machine only, a token in the address, one worker that
computes, every change told to all tabs."""

import argparse
import asyncio
import contextlib
import os
import secrets
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, Literal

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import ClientDisconnect, HTTPConnection, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from .. import files
from ..errors import BadInput, internal_error
from ..report import values
from . import arrivals, schema
from .session import tokens
from .session.session import ACTION, CODE, INSPECTION, PLAN, QUESTION, Call, Session
from .session.standing import Stale, Wish

PAGE = Path(__file__).resolve().parent / "page"
SERVED = {
    path.relative_to(PAGE).as_posix(): path for path in PAGE.rglob("*") if path.is_file()
}  # these, whatever is asked for
HOST = "127.0.0.1"
LARGEST_DROP, LARGEST_REQUEST = 1 << 31, 4 << 20
PROMPT = ("preview", "report", "without", "moves", "against")  # questions that a person asks
PLANS = 2  # at once: the newest does not wait for the one before it
TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".json": "application/json",
}
POLICY = (
    "default-src 'self'; connect-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' "
    "data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
    "sandbox allow-scripts allow-same-origin allow-downloads allow-forms"
)
# The sandbox leaves out allow-popups. Without allow-forms no form of the page would hear that it
# was submitted, and its dialogs would not close; none may be sent anywhere: form-action.
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
NO_CODE = (
    "this server does not run code from the page. Start tools/davarlab open in a terminal, and "
    "open its page on the same machine"
)
FLAGS = {"model": "-m", "sensor": "--sensor", "names": "--names", "skip": "--skip-lines"}
# Of a request that came through another program on this machine.
FORWARDED = ("forwarded", "x-forwarded-for", "x-forwarded-host", "x-real-ip", "via")

Work = Callable[[], Any]


class Server:
    """Answers one session. What computes goes one after the other in the worker; what needs no fit
    does not wait for it."""

    def __init__(self, session: Session) -> None:
        self.session, self.token = session, ""  # run() sets it: it goes with the port
        self.tabs: set[WebSocket] = set()
        self.worker, self.reader = ThreadPoolExecutor(1), ThreadPoolExecutor(1)
        self.planner = ThreadPoolExecutor(PLANS)
        self.loop: asyncio.AbstractEventLoop | None = None
        # Calls that a person waits for and the worker has not begun.
        self.waiting: dict[Work, Wish] = {}
        self.computing: set[Work] = set()  # calls that have begun and not ended
        session.tell, session.superseded = self.tell, self.superseded

    def superseded(self, but: Wish | None = None) -> bool:
        """Does a person wait for something else than this."""
        return any(wish != but for wish in list(self.waiting.values()))

    def app(self) -> Starlette:
        routes = [
            Route("/", self.index),
            Route("/page/{name:path}", self.page),
            Route("/proof", self.proof),
            Route("/api/{what}", self.ask, methods=["GET"]),
            Route("/api/{what}", self.do, methods=["POST"]),
            WebSocketRoute("/events", self.events),
        ]
        return Starlette(
            routes=routes,
            middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])],
        )

    def allowed(self, request: HTTPConnection) -> bool:
        """Only the page that was opened with the token, from this origin."""
        given = request.headers.get("x-davar-token") or request.query_params.get("token", "")
        origin = request.headers.get("origin")
        return secrets.compare_digest(given.encode(), self.token.encode()) and origin in (
            None,
            f"http://{request.headers['host']}",
        )

    def runs_code(self, request: Request) -> bool:
        """May this request run Python: it has the token, the origin is this server, it comes from
        127.0.0.1 and has no header of a proxy, and a person at a terminal has started the server. A
        tunnel (ssh -L) by which somebody has the token looks the same."""
        return (
            self.session.code
            and self.allowed(request)
            and request.headers.get("origin") == f"http://{request.headers['host']}"
            and request.client is not None
            and request.client.host == HOST
            and not any(name in request.headers for name in FORWARDED)
        )

    async def index(self, request: Request) -> Response:
        if not self.allowed(request):
            return PlainTextResponse(
                "The address has no token, or an old one. Use the address that tools/davarlab "
                "open printed.",
                403,
            )
        return self.file(PAGE / "index.html")

    async def proof(self, request: Request) -> Response:
        """To a tab that lost its server, before it sends its token again."""
        nonce = request.query_params.get("nonce", "")
        if not 16 <= len(nonce) <= 64:
            return PlainTextResponse("a nonce of 16 to 64 characters expected", 400)
        return PlainTextResponse(tokens.proof(self.token, nonce), headers=HEADERS)

    async def page(self, request: Request) -> Response:
        name = request.path_params["name"]
        if name not in SERVED:
            return PlainTextResponse("no such file", 404)
        return self.file(SERVED[name])

    def file(self, path: Path) -> FileResponse:
        return FileResponse(
            path, media_type=TYPES[path.suffix], headers=HEADERS | {"Cache-Control": "no-store"}
        )

    async def ask(self, request: Request) -> Response:
        return await self.answer(request, (INSPECTION, PLAN, QUESTION), query=self.query(request))

    async def do(self, request: Request) -> Response:
        if not self.allowed(request):
            return PlainTextResponse("no token", 403)
        if request.path_params["what"] == "drop":
            return await self.drop(request)
        text = await self.body(request)
        if text is None:
            return JSONResponse(
                {
                    "error": f"{request.path_params['what']}: the request is larger than "
                    f"{LARGEST_REQUEST >> 20} MB. Open the file by its path instead"
                },
                400,
            )
        return await self.answer(request, (ACTION, CODE), text)

    @staticmethod
    def query(request: Request) -> dict[str, str]:
        """What an address asks with, but for the token."""
        return {name: value for name, value in request.query_params.items() if name != "token"}

    @staticmethod
    async def body(request: Request) -> bytes | None:
        """The body of a request; None if it is too large. A client reads the error only after it
        has sent its body, so the rest is read and dropped, up to the size of a dropped file."""
        text, size = bytearray(), 0
        async for block in request.stream():
            size += len(block)
            if size <= LARGEST_REQUEST:
                text += block
            elif size > LARGEST_DROP:
                break
        return bytes(text) if size <= LARGEST_REQUEST else None

    def taker(
        self, name: schema.Text, purpose: Literal["recording", "held-out"] = "recording"
    ) -> Callable[[str], values.Json]:
        """What is done with a file that was dropped on the page under this name."""
        return self.session.hold.hold_out if purpose == "held-out" else self.session.intake.open

    async def drop(self, request: Request) -> Response:
        """A file that was dropped on the page, as it comes."""
        try:
            given = schema.request("drop", self.taker, query=self.query(request))
            name, taken = given["name"], self.taker(**given)
            with self.session.arrivals.receive(name) as dropped:
                size = 0
                async for block in request.stream():
                    size += len(block)
                    if size > LARGEST_DROP:
                        raise BadInput(
                            f"{name}: larger than {LARGEST_DROP >> 30} GB. Start davarlab open "
                            "with its path"
                        )
                    dropped.file.write(block)
        except BadInput as why:
            return JSONResponse({"error": self.said(why)}, 400)
        except ClientDisconnect:
            return JSONResponse({"error": "the dropped file arrived incomplete"}, 400)
        return await self.computed(Call(ACTION, partial(taken, str(dropped.path))), "drop", {})

    async def answer(
        self,
        request: Request,
        kinds: Sequence[str],
        text: bytes | None = None,
        query: Mapping[str, str] | None = None,
    ) -> Response:
        """Runs a call of the session, of one of these kinds, on what was given with the request, in
        JSON or in the query, once it is what the signature of the call says."""
        what = request.path_params["what"]
        if not self.allowed(request):
            return PlainTextResponse("no token", 403)
        call = self.session.calls.get(what)
        if call is None or call.kind not in kinds:
            return JSONResponse({"error": f"unknown request {what}"}, 404)
        if call.kind == CODE and not self.runs_code(request):
            return JSONResponse({"error": NO_CODE}, 403)
        try:
            given = schema.request(what, call.run, text, query)
        except BadInput as why:
            return JSONResponse({"error": str(why)}, 400)
        return await self.computed(call, what, given)

    async def computed(self, call: Call, what: str, given: dict[str, Any]) -> Response:
        """The answer of a call, from the worker."""
        assert self.loop is not None  # run() has set it
        try:
            found = await self.loop.run_in_executor(
                {INSPECTION: self.reader, PLAN: self.planner}.get(call.kind, self.worker),
                self.begun(call, what, given),
            )
        except BadInput as why:
            return JSONResponse({"error": self.said(why)}, 409 if isinstance(why, Stale) else 400)
        except Exception as why:
            return self.fault(why)
        if isinstance(found, bytes):
            return Response(found, media_type="application/octet-stream")
        return JSONResponse(values.plain(found))

    def end(self) -> None:
        """Ends the workers; what is still being computed, perhaps for minutes, is given up with the
        process, but no file in the middle."""
        for pool in (self.worker, self.reader, self.planner):
            pool.shutdown(wait=False, cancel_futures=True)
        if self.computing:
            with files.WRITING:
                os._exit(0)

    def begun(self, call: Call, what: str, given: dict[str, Any]) -> Work:
        """What the worker runs; one that a person is waiting for is visible until it
        begins, for a ranking gives way to it."""

        def work() -> Any:
            self.waiting.pop(work, None)
            self.computing.add(work)
            try:
                return call.run(**given)
            finally:
                self.computing.discard(work)

        if what in PROMPT or call.kind in (ACTION, CODE):
            self.waiting[work] = what, given
        return work

    def said(self, why: BadInput) -> str:
        """A message of davarlab on the page: a file that came by the page has its name alone."""
        return str(why).replace(f"{self.session.arrivals.folder}{os.sep}", "")

    def fault(self, why: Exception) -> JSONResponse:
        """What nobody foresaw: said, and the session goes on."""
        internal_error(why)
        return JSONResponse(
            {
                "error": f"an internal error: {type(why).__name__}: {why}. "
                "The steps so far are saved"
            },
            500,
        )

    def tell(self, **event: Any) -> None:
        """Sends an event to every tab; may be called from the worker."""

        async def send() -> None:
            for tab in list(self.tabs):
                try:
                    await tab.send_json(values.plain(event))
                except (WebSocketDisconnect, RuntimeError):
                    self.tabs.discard(tab)

        if self.loop and self.loop.is_running():
            asyncio.run_coroutine_threadsafe(send(), self.loop)

    async def events(self, tab: WebSocket) -> None:
        if not self.allowed(tab):
            await tab.close(4403)
            return
        await tab.accept()
        self.tabs.add(tab)
        try:
            while (await tab.receive())[
                "type"
            ] != "websocket.disconnect":  # a tab has nothing to say
                pass
        finally:
            self.tabs.discard(tab)


def show(address: str, folder: str | Path) -> None:
    """Opens the address in the user's browser, by way of a file in a folder that nobody else can
    read: command lines are seen by all."""
    page = Path(folder) / "open.html"
    page.write_text(
        f'<!doctype html><meta http-equiv="refresh" content="0;url={address}">', encoding="ascii"
    )
    threading.Thread(target=webbrowser.open, args=(page.as_uri(),), daemon=True).start()


def run(options: argparse.Namespace) -> int:
    """`davarlab open`: until interrupted."""
    here = Path.cwd()
    session = Session(here, sys.stdin is not None and sys.stdin.isatty(), arrivals.kept(here))
    given = {
        "model": options.model,
        "sensor": options.sensor,
        "names": options.names,
        "skip": options.skip_lines,
    }
    if options.recording:
        session.intake.open(options.recording, **given)
    elif wrong := [name for name, value in given.items() if value]:
        raise BadInput(f"{FLAGS[wrong[0]]} needs a recording")
    server = Server(session)
    # asyncio sets TCP_NODELAY only on a socket whose protocol is named. Without, an answer waits
    # for 40 ms.
    tcp = socket.IPPROTO_TCP
    with socket.socket(proto=tcp) as listener, tempfile.TemporaryDirectory() as folder:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((HOST, options.port))
            listener.listen()
        except OSError as why:
            raise BadInput(f"--port {options.port}: {files.reason(why)}") from None
        session.port = listener.getsockname()[1]
        server.token = tokens.of_port(session.port)
        address = f"http://{HOST}:{session.port}/?token={server.token}"
        web = uvicorn.Server(
            uvicorn.Config(
                server.app(),
                log_level="critical",
                access_log=False,
                timeout_graceful_shutdown=1,
                proxy_headers=False,  # a client is who sent the request
            )
        )

        async def serve() -> None:
            server.loop = asyncio.get_running_loop()
            print(address, flush=True)
            print(
                "davarlab: the workbench is open at this address, on this machine only. Ctrl-C "
                "stops it. Every step is saved next to the recording.",
                file=sys.stderr,
                flush=True,
            )
            if not options.no_browser:
                show(address, folder)
            try:
                await web.serve(sockets=[listener])
            finally:
                await server.loop.run_in_executor(None, session.listener.quiet)

        signal.signal(signal.SIGTERM, signal.default_int_handler)
        with contextlib.suppress(KeyboardInterrupt):
            asyncio.run(serve())
    server.end()
    return 0
