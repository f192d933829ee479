"""The server of the studio: access control, files, start and end."""

from __future__ import annotations

import asyncio
import secrets
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache, partial
from importlib.resources import files
from typing import Any
from weakref import WeakKeyDictionary

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from gelcone.errors import InputError
from gelcone.studio import look
from gelcone.studio.page import Page
from gelcone.studio.pool import Pool
from gelcone.studio.setting import Setting, Shelf

LOCAL = "127.0.0.1"
IDLE_SECONDS = 5.0
"""Time after which a connection without a request is closed."""
LARGEST_MESSAGE = 65_536
MOST_PAGES = 32
FAREWELL_SECONDS = 0.05
"""Time in which pages receive the end of their connection."""
LEAVING_SECONDS = 0.3
"""Time after which unfinished answers are abandoned."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self' http://127.0.0.1:* http://localhost:*"
)
"""Content security policy: the page's files only; notebooks of this machine may show it in a frame."""
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml"}


@dataclass
class Studio:
    """One server: its address and token, the devices that pages may name, its workers and pages."""

    shelf: Shelf
    host: str = LOCAL
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    tickets: set[str] = field(default_factory=set, repr=False)
    """Keys that open the page once, and are worthless afterwards."""
    pool: Pool = field(init=False)
    saving: Pool = field(init=False)
    pages: set[Page] = field(default_factory=set)
    port: int = 0
    _server: _Server | None = None
    _stopped: bool = False

    def __post_init__(self) -> None:
        self.pool = Pool(names=self.shelf.names)
        self.saving = Pool(1, background=False, names=self.shelf.names)

    def listen(self, port: int = 0) -> socket.socket:
        """The bound socket, so that the address is known before the server runs; `InputError` if the port is taken."""
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        # asyncio sets TCP_NODELAY only if the protocol is named; without it answers wait 40 ms for an acknowledgement
        listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)  # detects browsers that vanished without closing
        try:
            listener.bind((self.host, port))
        except (OSError, OverflowError) as error:
            listener.close()
            raise InputError(
                f"--port {port}: cannot listen on {self.host} ({error}); choose another or leave it out"
            ) from None
        listener.listen(128)  # connections made before the server runs wait
        self.port = listener.getsockname()[1]
        return listener

    def address(self, state: str = "") -> str:
        """The page's address with its token; ``state`` follows the ``#``."""
        return self._address(f"token={self.token}", state)

    def _address(self, key: str, state: str) -> str:
        shown = {"0.0.0.0": socket.gethostname(), "::": socket.gethostname()}.get(self.host, self.host)
        host = f"[{shown}]" if ":" in shown else shown
        return f"http://{host}:{self.port}/?{key}" + (f"#{state}" if state else "")

    def ticket(self, state: str = "") -> str:
        """An address that opens the page once, see `tickets`."""
        self.tickets.add(new := secrets.token_urlsafe(24))
        return self._address(f"ticket={new}", state)

    def hosts(self, reached: str) -> set[str]:
        """Accepted values of the header Host; ``reached`` is the address at which a connection came in.

        This defeats DNS rebinding: a foreign name that resolves to this machine still appears in the header, and is
        refused.
        """
        names = {LOCAL, "localhost", "::1"}
        if self.host != LOCAL:
            names |= {self.host, socket.gethostname(), socket.getfqdn(), reached, reached.removeprefix("::ffff:")}
        return {f"[{name}]:{self.port}" if name.count(":") > 1 else f"{name.lower()}:{self.port}" for name in names}

    def app(self) -> ASGIApp:
        """The studio's routes, behind its guard."""
        routes = [
            Route("/", self._page),
            Route("/static/{name}", self._static),
            WebSocketRoute("/ws", self._talk),
        ]
        return Guard(Starlette(routes=routes), self)

    async def serve(self, listening: socket.socket) -> None:
        """Serves until `stop`, which may have been called before, and releases everything."""
        if self._stopped:
            listening.close()
            return
        config = uvicorn.Config(
            self.app(),
            log_level="warning",
            access_log=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=LARGEST_MESSAGE,
            ws_per_message_deflate=False,
            ws_ping_interval=None,  # a busy page answers pings late, and would be disconnected
        )
        self._server = _Server(config)
        try:
            await self._server.serve(sockets=[listening])
        finally:
            self.stop()

    def load(self, setting: Setting) -> None:
        """Loads what the first picture needs while the browser starts; errors in the setting are left to the page."""
        with suppress(InputError):
            self.shelf.at_once(setting, partial(look.response, periods=look.PERIODS))

    def stop(self) -> None:
        """Ends all work and the server; from another thread call it by the loop's `call_soon_threadsafe`."""
        self._stopped = True
        for page in list(self.pages):
            page.end()
        self.pool.close()
        self.saving.close()
        if self._server is not None:
            self._server.should_exit = True

    def is_ours(self, token: str | None) -> bool:
        """Whether a token is this studio's, compared in constant time."""
        return secrets.compare_digest((token or "").encode(), self.token.encode())

    async def _page(self, request: Request) -> Response:
        ticket = request.query_params.get("ticket")
        if ticket in self.tickets:
            self.tickets.remove(ticket)
            return RedirectResponse(f"/?token={self.token}", 303)
        if ticket is not None:  # a reloaded frame has the token in its session storage
            return _file("index.html")
        if not self.is_ours(request.query_params.get("token")):
            return PlainTextResponse(
                "The address lacks its token; open the whole address that gelcone studio printed.", 403
            )
        return _file("index.html")

    async def _static(self, request: Request) -> Response:
        return _file(request.path_params["name"])

    async def _talk(self, socket: WebSocket) -> None:
        ours = {f"http://{host}" for host in self.hosts(socket.scope["server"][0])}
        origin = socket.headers.get("origin", "").lower()
        if origin not in ours or not self.is_ours(socket.query_params.get("token")):
            await socket.send_denial_response(PlainTextResponse("This page may not connect to the studio.", 403))
            return
        await socket.accept()
        if len(self.pages) >= MOST_PAGES:
            await socket.close(1013, "too many pages")
            return
        page = Page(socket, self.shelf, self.pool, self.saving)
        self.pages.add(page)
        try:
            await page.run()
        finally:
            page.end()
            self.pages.discard(page)


class Guard:
    """Refuses requests to other hosts, and adds security headers to every answer."""

    def __init__(self, app: ASGIApp, studio: Studio) -> None:
        self.app, self.studio = app, studio

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:

        async def with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                message["headers"] = [*message.get("headers", []), *_HEADERS]
            await send(message)

        app = self.app
        if Headers(scope=scope).get("host", "").lower() not in self.studio.hosts(scope["server"][0]):
            app = PlainTextResponse(
                "The studio does not answer under this host name; open the address that gelcone studio printed.", 421
            )
        await app(scope, receive, with_headers)


_HEADERS = [
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cache-control", b"no-cache"),
]


@cache
def _files() -> dict[str, bytes]:
    """The page's files by name."""
    return {path.name: path.read_bytes() for path in files("gelcone.studio").joinpath("static").iterdir()}


def _file(name: str) -> Response:
    """The response with one of the page's files."""
    if name not in _files():
        return PlainTextResponse("There is no such file.", 404)
    return Response(_files()[name], media_type=KINDS[name[name.rindex(".") :]])


class _Server(uvicorn.Server):
    """A server that leaves signals to its caller, closes idle connections, and does not wait for pages when it ends."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self._waiting: WeakKeyDictionary[Any, float] = WeakKeyDictionary()
        """Idle connections, and since when."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield

    async def on_tick(self, counter: int) -> bool:
        now = time.monotonic()
        for connection in list(self.server_state.connections):
            if isinstance(connection, WebSocketsSansIOProtocol) or not _is_idle(connection):
                self._waiting.pop(connection, None)
            elif now - self._waiting.setdefault(connection, now) > IDLE_SECONDS:
                connection.transport.close()
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        for listening in sockets or []:
            with suppress(OSError):  # a starting worker may briefly hold it open, too
                listening.shutdown(socket.SHUT_RDWR)
        for server in self.servers:
            server.close()
        for connection in list(self.server_state.connections):
            connection.shutdown()
        await asyncio.sleep(FAREWELL_SECONDS)
        for connection in list(self.server_state.connections):
            connection.transport.abort()  # a page that does not read would block the end
        if self.server_state.tasks:
            await asyncio.wait(self.server_state.tasks, timeout=LEAVING_SECONDS)


def _is_idle(connection: Any) -> bool:
    """Whether a connection has no unanswered request."""
    return connection.cycle is None or connection.cycle.response_complete


def run(studio: Studio, listening: socket.socket, first: Setting, ready: Callable[[], None]) -> None:
    """Serves until Ctrl-C; ``first`` is the setting shown first, and ``ready`` is called once the server runs."""

    async def main() -> None:
        loop = asyncio.get_running_loop()

        def stop(number: int, frame: object) -> None:
            loop.call_soon_threadsafe(studio.stop)

        before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
        threading.Thread(target=studio.load, args=(first,), daemon=True).start()
        loop.call_soon(ready)
        try:
            await studio.serve(listening)
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    asyncio.run(main())
