"""The rosbridge protocol over WebSocket, and the page, on one port."""

import asyncio
import hmac
import logging
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from http import HTTPStatus
from pathlib import Path
from typing import Any, Dict, NamedTuple, Optional, Sequence, Set, Tuple
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from flatland_bridge.graph import BridgeError, Graph
from flatland_bridge.outbox import Data, Outbox
from flatland_bridge.rosbridge_session import Providers, Session

PAGE = Path(__file__).parent / "page"

_FILES = {
    "/": ("index.html", "text/html"),
    "/page.css": ("page.css", "text/css"),
    "/page.js": ("page.js", "text/javascript"),
    "/view.js": ("view.js", "text/javascript"),
    "/rosbridge.js": ("rosbridge.js", "text/javascript"),
}
"""All that the server has of the file system, by its path in the URL."""

_MOST_CLIENTS = 64
_LARGEST_MESSAGE = 1_000_000
"""Bytes of a message of a client; larger ones may come in fragments."""
_WORKERS = 8
"""Calls of services that are answered at the same time."""
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


class RosbridgeServer:
    """Serves clients on a thread of its own, until it is closed.

    Args:
        graph: the topics and services.
        port: to listen at; 0 takes a free one.
        access: who may connect.

    Raises:
        BridgeError: the port or the address cannot be used.
    """

    def __init__(self, graph: Graph, port: int = 9090, access: Access = Access()) -> None:  # noqa: B008
        self._graph = graph
        self._access = access
        self._providers = Providers()
        self._clients: Set[ServerConnection] = set()
        self._pool = ThreadPoolExecutor(_WORKERS, "service")
        self._loop = asyncio.new_event_loop()
        started: Future[int] = Future()
        self._thread = threading.Thread(
            target=lambda: self._loop.run_until_complete(self._run(port, started)),
            name="rosbridge",
            daemon=True,
        )
        self._thread.start()
        try:
            self.port = started.result()
        except (OSError, OverflowError) as error:
            raise BridgeError(f"rosbridge cannot listen at {access.host}:{port}: {error}") from None

    @property
    def url(self) -> str:
        """The address of the page."""
        host = self._access.host
        host = "localhost" if host in ("0.0.0.0", "::", "", *_LOOPBACK) else host
        token = f"/?token={self._access.token}" if self._access.token else "/"
        return f"http://{host}:{self.port}{token}"

    def close(self) -> None:
        """Disconnects all clients."""
        self._loop.call_soon_threadsafe(self._ending.set)
        self._thread.join()
        self._pool.shutdown(wait=False)

    async def _run(self, port: int, started: "Future[int]") -> None:
        self._ending = asyncio.Event()
        try:
            server = await serve(
                self._serve,
                self._access.host,
                port,
                process_request=self._check,
                compression=None,  # costs more time than it saves on this machine
                max_size=_LARGEST_MESSAGE,
                max_queue=16,
                server_header="Flatland",
                logger=_quiet_logger(),
            )
        except BaseException as error:
            started.set_exception(error)
            return
        started.set_result(server.sockets[0].getsockname()[1])
        async with server:
            await self._ending.wait()

    def _check(self, connection: ServerConnection, request: Request) -> Optional[Response]:
        """The response to a request for a file, or to one that is refused."""
        if "websocket" not in request.headers.get("Upgrade", "").lower():
            return _file(urlsplit(request.path).path)
        if not self._access.allows_origin(request.headers.get("Origin")):
            return connection.respond(HTTPStatus.FORBIDDEN, "pages of this origin may not connect\n")
        if not self._access.allows_token(request):
            return connection.respond(HTTPStatus.UNAUTHORIZED, "expected ?token=TOKEN\n")
        if len(self._clients) >= _MOST_CLIENTS:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "too many clients\n")
        return None

    async def _serve(self, connection: ServerConnection) -> None:
        self._clients.add(connection)
        outbox = Outbox(asyncio.get_running_loop())
        session = Session(self._graph, outbox, self._pool, self._providers)

        async def send(data: Data) -> None:
            await connection.send(data)

        sender = asyncio.ensure_future(outbox.send_all(send))
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
        "Content-Security-Policy": "default-src 'self'; connect-src 'self' ws: wss:",
        "Cache-Control": "no-store",
        "Connection": "close",
    }
    return Response(status.value, status.phrase, Headers(headers), content)


def _quiet_logger() -> logging.Logger:
    """A logger that keeps what clients do wrong to itself: it is they who are told."""
    logger = logging.getLogger("flatland_bridge.websockets")
    logger.setLevel(logging.CRITICAL)
    return logger
