"""WebSockets of all protocols, and the page: access, and limits for clients."""

import asyncio
import hmac
import logging
import os
import threading
from concurrent.futures import Future
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Protocol, Sequence, Set
from urllib.parse import parse_qs, quote, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from flatland_bridge.budget import CLIENT_MEMORY, Budget, Budgets
from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import Data, Send
from flatland_server.exceptions import shortened

logger = logging.getLogger(__name__)

PAGE = Path(__file__).parent / "page"

_KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript"}
_FILES = {f"/{file.name}": file for file in PAGE.iterdir() if file.suffix in _KINDS}
_FILES["/"] = _FILES.pop("/index.html")
"""All that the server has of the file system, by its path in the URL."""

MOST_CLIENTS = 64
"""Clients of all protocols. One that has left counts until its last call has ended."""
_MOST_CONNECTIONS = 256
"""Connections, with those that have not asked for anything yet."""
_LARGEST_REQUEST = 64_000
"""Bytes of the request to open a WebSocket."""
_LARGEST_READ = 32_000
"""Bytes that are read of a client before it is the others' turn."""
_LARGEST_UNREAD = 64_000
"""Bytes of answers to pings that a client leaves unread."""
_CLOSE_TIMEOUT = 1.0
"""Real time for the last message to a client that has to go [s]."""
_TOO_MUCH = 1008
"""A code of RFC 6455: the client has broken a rule."""
_LARGEST_MESSAGE = 1_000_000
"""Bytes of a message of a client; larger ones may come in fragments."""
_GONE = (ConnectionClosed, ConnectionError)
_LOOPBACK = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class Access:
    """The clients that may connect.

    Attributes:
        host: the address that the server listens at.
        token: what a URL must have as `?token=`, or a header as `Authorization: Bearer`; if any.
        origins: of other pages with scripts that may connect, such as "https://example.org"; "null"
            is a page from a file.

    Raises:
        BridgeError: the token is empty.
    """

    host: str = "127.0.0.1"
    token: Optional[str] = None
    origins: Sequence[str] = ()

    def __post_init__(self) -> None:
        if self.token == "":
            raise BridgeError("token: expected one character or more, found an empty text")

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
            request: HTTP request that opens a WebSocket.
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

    def status(self, text: str) -> Data:
        """A message that tells the client of an error."""

    def close(self) -> None:
        """Ends all that the client has begun, and closes its budget once nothing of it goes on."""


class Endpoint(NamedTuple):
    """A port and what is spoken there.

    Attributes:
        name: of the protocol, for errors.
        port: to listen at; 0 takes a free one.
        open_session: called for each client, with its budget.
        subprotocols: of which clients must know one; without any, they need none.
        has_page: whether browsers get the page there.
    """

    name: str
    port: int
    open_session: Callable[[Budget], Session]
    subprotocols: Sequence[str] = ()
    has_page: bool = False


class WebSocketServer:
    """Serves clients on a thread of its own, until it is closed.

    Args:
        endpoints: what to serve, each with a port.
        access: the clients that may connect.
        client_memory: bytes that are kept for each client.

    Attributes:
        ports: of the endpoints, by their names.

    Raises:
        BridgeError: a port or the address cannot be used.
    """

    def __init__(
        self,
        endpoints: Sequence[Endpoint],
        access: Access = Access(),
        client_memory: int = CLIENT_MEMORY,
    ) -> None:
        self._access = access
        self._budgets = Budgets(client_memory)
        self._loop = asyncio.new_event_loop()
        self._loop.set_exception_handler(self._note_error)
        self._has_warned = False  # of a lack of open files
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
            name: the endpoint's name.
            scheme: "http" or "ws".
        """
        host = self._access.host
        host = "localhost" if host in ("0.0.0.0", "::", "", *_LOOPBACK) else host
        token = f"/?token={quote(self._access.token, safe='')}" if self._access.token else "/"
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
                except Exception as error:  # of any kind, or the program would wait for ever
                    number = getattr(error, "errno", None) or 0
                    found = os.strerror(number) if number > 0 else getattr(error, "strerror", None)
                    reason = found or shortened(str(error))
                    where = f"{shortened(self._access.host)}:{endpoint.port}"
                    message = f"{endpoint.name} cannot listen at {where}: {reason}"
                    started.set_exception(BridgeError(message))
                    return
                ports[endpoint.name] = server.sockets[0].getsockname()[1]
            started.set_result(ports)
            await self._ending.wait()
            # Clients that do not read would hold up the end until they time out.
            self._loop.call_later(_CLOSE_TIMEOUT, self._abort_all)

    def _note_error(self, loop: asyncio.AbstractEventLoop, context: Dict[str, Any]) -> None:
        """Logs an error of the event loop: a lack of open files once, as a line.

        The loop accepts connections again after a second.
        """
        error = context.get("exception")
        if not isinstance(error, OSError):
            loop.default_exception_handler(context)
        elif not self._has_warned:
            self._has_warned = True
            logger.warning("no further client can connect for now: %s", error)

    def _abort_all(self) -> None:
        for each in list(_connections):
            if each.loop is self._loop:
                each.transport.abort()

    def _open(self, endpoint: Endpoint) -> serve:
        return serve(
            partial(self._serve, endpoint),
            self._access.host,
            endpoint.port,
            process_request=partial(self._check, endpoint),
            subprotocols=[Subprotocol(name) for name in endpoint.subprotocols] or None,
            compression=None,  # costs more time than it saves on this machine
            max_size=_LARGEST_MESSAGE,
            max_queue=1,  # a client's next message; further ones wait in its own socket
            close_timeout=_CLOSE_TIMEOUT,  # the server ends even if clients do not read
            server_header="Flatland",
            logger=_quiet_logger(),
            create_connection=_Connection,
        )

    def _check(
        self, endpoint: Endpoint, connection: ServerConnection, request: Request
    ) -> Optional[Response]:
        """The response to a request for a file, or to one that is refused."""
        try:
            if "websocket" not in request.headers.get("Upgrade", "").lower():
                return _file(urlsplit(request.path).path if endpoint.has_page else "")
            if not self._access.allows_origin(request.headers.get("Origin")):
                text = "pages of this origin may not connect; --origin allows it\n"
                return connection.respond(HTTPStatus.FORBIDDEN, text)
            if not self._access.allows_token(request):
                return connection.respond(HTTPStatus.UNAUTHORIZED, "expected ?token=TOKEN\n")
        except (LookupError, ValueError):  # a path that is none, or a header that comes twice
            return connection.respond(HTTPStatus.BAD_REQUEST, "expected another request\n")
        except OSError:  # too many files are open
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "try again\n")
        if len(self._budgets) >= MOST_CLIENTS:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "too many clients\n")
        return None

    async def _serve(self, endpoint: Endpoint, connection: ServerConnection) -> None:
        excess: asyncio.Future[str] = self._loop.create_future()

        def dismiss(reason: str) -> None:
            with suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(excess.set_result, reason)

        budget = self._budgets.open(dismiss)
        try:
            session = endpoint.open_session(budget)
        except BaseException:
            budget.close()
            raise
        tasks: List[asyncio.Future[None]] = [
            asyncio.ensure_future(_receive(connection, session, budget)),
            asyncio.ensure_future(session.run(connection.send)),
        ]
        try:
            ends: List[asyncio.Future[Any]] = [excess, *tasks]
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            session.close()
            for task in tasks:
                task.cancel()
            for error in await asyncio.gather(*tasks, return_exceptions=True):
                if isinstance(error, Exception) and not isinstance(error, _GONE):
                    logger.error("a client is disconnected", exc_info=error)
        if excess.done():
            await _dismiss(connection, session, excess.result())


async def _receive(connection: ServerConnection, session: Session, budget: Budget) -> None:
    """Passes a client's messages on, until it leaves or has to go."""
    async for data in connection:
        try:
            session.handle(data)
        except Exception as error:  # of any kind; the others go on, and so does it
            logger.exception("a message of a client has failed")
            await connection.send(session.status(f"failed: {shortened(repr(error))}"))
        await asyncio.sleep(0)  # the other clients' turn
        if budget.goes:
            return


async def _dismiss(connection: ServerConnection, session: Session, reason: str) -> None:
    """Tells a client why it has to go, if it reads, and disconnects it."""

    async def tell() -> None:
        await connection.send(session.status(reason))
        await connection.close(_TOO_MUCH, reason)

    async def discard() -> None:  # up to its own goodbye
        async for _ in connection:
            pass

    both = asyncio.gather(tell(), discard(), return_exceptions=True)
    with suppress(asyncio.TimeoutError):
        await asyncio.wait_for(both, _CLOSE_TIMEOUT)
    connection.transport.abort()


_connections: Set[ServerConnection] = set()
"""The connections of all servers of this process."""


class _Connection(ServerConnection):  # type: ignore[misc]
    """A connection with limits for what comes before and besides messages."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._received = self._unread = 0
        super().connection_made(transport)
        _connections.add(self)
        limited: Any = transport
        limited.max_size = _LARGEST_READ
        if len(_connections) > _MOST_CONNECTIONS:
            self.transport.abort()

    def connection_lost(self, exc: Optional[Exception]) -> None:
        _connections.discard(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        before = self.transport.get_write_buffer_size()
        super().data_received(data)
        # It has sent nothing but answers to pings, for which it does not wait.
        self._unread = self.transport.get_write_buffer_size() - before + self._unread * (before > 0)
        self._received += len(data) * (self.request is None)
        if self._unread > _LARGEST_UNREAD or self._received > _LARGEST_REQUEST:
            self.transport.abort()

    def resume_writing(self) -> None:
        self._unread = 0
        super().resume_writing()


def _file(path: str) -> Response:
    status, content, kind = HTTPStatus.NOT_FOUND, b"there is no such page\n", "text/plain"
    if path in _FILES:
        status, content = HTTPStatus.OK, _FILES[path].read_bytes()
        kind = _KINDS[_FILES[path].suffix]
    headers: Dict[str, str] = {
        "Content-Type": f"{kind}; charset=utf-8",
        "Content-Length": str(len(content)),
        "Content-Security-Policy": "default-src 'self'; img-src data:; "
        "connect-src 'self' ws: wss:; frame-ancestors 'none'",
        "Cache-Control": "no-store",
        "Connection": "close",
    }
    return Response(status.value, status.phrase, Headers(headers), content)


def _quiet_logger() -> logging.Logger:
    """A logger that does not log the errors of clients: the clients are told."""
    logger = logging.getLogger("flatland_bridge.websockets")
    logger.setLevel(logging.CRITICAL)
    return logger
