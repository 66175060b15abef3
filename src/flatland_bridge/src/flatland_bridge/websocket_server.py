"""WebSockets of all protocols, and the page: who may connect, and limits for those who do."""

import asyncio
import hmac
import logging
import os
import threading
from concurrent.futures import Future
from contextlib import AsyncExitStack
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import Callable, Dict, NamedTuple, Optional, Protocol, Sequence, Set
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import Data, Send

PAGE = Path(__file__).parent / "page"

_FILES = {
    "/": ("index.html", "text/html"),
    "/page.css": ("page.css", "text/css"),
    "/page.js": ("page.js", "text/javascript"),
    "/poses.js": ("poses.js", "text/javascript"),
    "/view.js": ("view.js", "text/javascript"),
    "/rosbridge.js": ("rosbridge.js", "text/javascript"),
}
"""All that the server has of the file system, by its path in the URL."""

_MOST_CLIENTS = 64
_LARGEST_MESSAGE = 1_000_000
"""Bytes of a message of a client; larger ones may come in fragments."""
_LOOPBACK = ("localhost", "127.0.0.1", "::1")


class Access(NamedTuple):
    """Who may connect.

    Attributes:
        host: the address that the server listens at.
        token: what a URL must have as `?token=`, or a header as `Authorization: Bearer`; if any.
        origins: of other pages whose scripts may connect, such as "https://example.org"; "null" is
            a page from a file.
    """

    host: str = "127.0.0.1"
    token: Optional[str] = None
    origins: Sequence[str] = ()

    @property
    def is_local(self) -> bool:
        """True if only programs on this machine can connect."""
        return self.host in _LOOPBACK

    def allows_origin(self, origin: Optional[str]) -> bool:
        """True if scripts of a page may connect, or if it is no page.

        Args:
            origin: of the page, as its browser says; None for other programs.
        """
        if origin is None or origin in self.origins:
            return True
        return urlsplit(origin).hostname in (*_LOOPBACK, self.host)

    def allows_token(self, request: Request) -> bool:
        """True if a request has the token, or needs none.

        Args:
            request: to open a WebSocket.
        """
        if self.token is None:
            return True
        given = parse_qs(urlsplit(request.path).query).get("token", [""])[0]
        given = given or request.headers.get("Authorization", "").partition("Bearer ")[2]
        return hmac.compare_digest(given.encode(), self.token.encode())


class Session(Protocol):
    """One client of a protocol. It is used on the event loop's thread."""

    def handle(self, data: Data) -> None:
        """Obeys a message of the client."""

    async def run(self, send: Send) -> None:
        """Sends messages for ever."""

    def close(self) -> None:
        """Ends all that the client has begun."""


class Endpoint(NamedTuple):
    """A port and what is spoken there.

    Attributes:
        name: of the protocol, for errors.
        port: to listen at; 0 takes a free one.
        open_session: called for each client.
        subprotocols: of which clients must know one; without any, they need none.
        has_page: whether browsers get the page there.
    """

    name: str
    port: int
    open_session: Callable[[], Session]
    subprotocols: Sequence[str] = ()
    has_page: bool = False


class WebSocketServer:
    """Serves clients on a thread of its own, until it is closed.

    Args:
        endpoints: what to serve.
        access: who may connect.

    Attributes:
        ports: of the endpoints, by their names.

    Raises:
        BridgeError: a port or the address cannot be used.
    """

    def __init__(self, endpoints: Sequence[Endpoint], access: Access = Access()) -> None:  # noqa: B008
        self._access = access
        self._clients: Set[ServerConnection] = set()
        self._loop = asyncio.new_event_loop()
        started: Future[Dict[str, int]] = Future()
        self._thread = threading.Thread(
            target=lambda: self._loop.run_until_complete(self._run(endpoints, started)),
            name="websockets",
            daemon=True,
        )
        self._thread.start()
        self.ports = started.result()

    def url(self, name: str, scheme: str) -> str:
        """The address of an endpoint, for a program on this machine.

        Args:
            name: of the endpoint.
            scheme: "http" or "ws".
        """
        host = self._access.host
        host = "localhost" if host in ("0.0.0.0", "::", "", *_LOOPBACK) else host
        token = f"/?token={self._access.token}" if self._access.token else "/"
        return f"{scheme}://{host}:{self.ports[name]}{token}"

    def close(self) -> None:
        """Disconnects all clients."""
        self._loop.call_soon_threadsafe(self._ending.set)
        self._thread.join()

    async def _run(self, endpoints: Sequence[Endpoint], started: "Future[Dict[str, int]]") -> None:
        self._ending = asyncio.Event()
        async with AsyncExitStack() as stack:
            ports = {}
            for endpoint in endpoints:
                try:
                    server = await stack.enter_async_context(self._open(endpoint))
                except (OSError, OverflowError) as error:
                    number = getattr(error, "errno", None)
                    reason = os.strerror(number) if number else error
                    where = f"{self._access.host}:{endpoint.port}"
                    message = f"{endpoint.name} cannot listen at {where}: {reason}"
                    started.set_exception(BridgeError(message))
                    return
                ports[endpoint.name] = server.sockets[0].getsockname()[1]
            started.set_result(ports)
            await self._ending.wait()

    def _open(self, endpoint: Endpoint) -> serve:
        return serve(
            partial(self._serve, endpoint),
            self._access.host,
            endpoint.port,
            process_request=partial(self._check, endpoint),
            subprotocols=[Subprotocol(name) for name in endpoint.subprotocols] or None,
            compression=None,  # costs more time than it saves on this machine
            max_size=_LARGEST_MESSAGE,
            max_queue=16,
            close_timeout=1.0,  # the server ends even if clients do not read
            server_header="Flatland",
            logger=_quiet_logger(),
        )

    def _check(
        self, endpoint: Endpoint, connection: ServerConnection, request: Request
    ) -> Optional[Response]:
        """The response to a request for a file, or to one that is refused."""
        if "websocket" not in request.headers.get("Upgrade", "").lower():
            return _file(urlsplit(request.path).path if endpoint.has_page else "")
        if not self._access.allows_origin(request.headers.get("Origin")):
            text = "pages of this origin may not connect; --origin allows it\n"
            return connection.respond(HTTPStatus.FORBIDDEN, text)
        if not self._access.allows_token(request):
            return connection.respond(HTTPStatus.UNAUTHORIZED, "expected ?token=TOKEN\n")
        if len(self._clients) >= _MOST_CLIENTS:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "too many clients\n")
        return None

    async def _serve(self, endpoint: Endpoint, connection: ServerConnection) -> None:
        self._clients.add(connection)
        session = endpoint.open_session()
        sender = asyncio.ensure_future(session.run(connection.send))
        try:
            async for data in connection:
                session.handle(data)
                await asyncio.sleep(0)  # the other clients' turn
        except (ConnectionClosed, ConnectionError):
            pass
        finally:
            self._clients.discard(connection)
            sender.cancel()
            session.close()


def _file(path: str) -> Response:
    status, content, kind = HTTPStatus.NOT_FOUND, b"there is no such page\n", "text/plain"
    if path in _FILES:
        name, kind = _FILES[path]
        status, content = HTTPStatus.OK, (PAGE / name).read_bytes()
    headers: Dict[str, str] = {
        "Content-Type": f"{kind}; charset=utf-8",
        "Content-Length": str(len(content)),
        "Content-Security-Policy": "default-src 'self'; img-src data:; connect-src 'self' ws: wss:",
        "Cache-Control": "no-store",
        "Connection": "close",
    }
    return Response(status.value, status.phrase, Headers(headers), content)


def _quiet_logger() -> logging.Logger:
    """A logger that keeps what clients do wrong to itself: it is they who are told."""
    logger = logging.getLogger("flatland_bridge.websockets")
    logger.setLevel(logging.CRITICAL)
    return logger
