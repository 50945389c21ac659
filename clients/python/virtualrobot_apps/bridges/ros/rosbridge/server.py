"""The server: connections by WebSocket, of whom only those are let in who may."""

from __future__ import annotations

import hmac
import logging
from collections.abc import Sequence
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.http11 import Request, Response

from virtualrobot_apps.bridges.ros.hub import Hub
from virtualrobot_apps.bridges.ros.rosbridge.connections import WebSocketConnection
from virtualrobot_apps.bridges.ros.rosbridge.session import Session
from virtualrobot_apps.bridges.ros.rosbridge.wire import MOST_BYTES
from virtualrobot_apps.bridges.ros.transport import Transport, in_address, no_server

PORT = 9090
"""The port that clients of rosbridge take."""

_log = logging.getLogger(__name__)
# Who looks at ports says nothing, or nothing of HTTP: that is no fault here, and not worth a page of words.
_log.addFilter(lambda one: not (one.exc_info and isinstance(one.exc_info[1], InvalidHandshake)))

_HERE = ("localhost", "127.0.0.1", "::1")


class RosbridgeServer(Transport):
    """Server of rosbridge on one address; `url` is where it serves once it is open."""

    def __init__(
        self, host: str = "127.0.0.1", port: int = PORT, *, token: str = "", origins: Sequence[str] = ()
    ) -> None:
        """Serve nothing yet.

        A page of a browser tells its origin: those of this machine and `origins` are let in. A token is in the
        address (`/?token=...`), in the header `Authorization: Bearer ...`, or said by the operation `auth`.
        """
        self._host, self._port, self._token, self._origins = host, port, token, origins
        self._hub = Hub()
        self._server: Server | None = None
        self.url = ""

    async def open(self, hub: Hub) -> str:
        """Serve a hub."""
        self._hub = hub
        try:
            # Messages are small, and what is large is packed as the client asks: deflating them costs too much.
            # Pings find out who has gone, but a client such as MATLAB answers them only while a program of it waits.
            self._server = await serve(
                self._handle,
                self._host,
                self._port,
                process_request=self._check,
                logger=_log,
                max_size=MOST_BYTES,
                max_queue=64,
                ping_timeout=None,
                compression=None,
            )
        except OSError as error:
            raise no_server("rosbridge can't serve", self._host, self._port, error) from error
        self.url = f"ws://{in_address(self._host)}:{self._server.sockets[0].getsockname()[1]}"
        return f"rosbridge at {self.url}"

    async def close(self) -> None:
        """Cut all clients off."""
        if self._server is not None:
            self._server.close()
            await self._server.wait_closed()

    def _check(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the refusal of a client that may not come in, before it is one."""
        origin = request.headers.get("Origin")
        if origin is not None and urlsplit(origin).hostname not in _HERE and origin not in self._origins:
            words = f"pages of {origin} are not let in; --origin {origin} lets them in\n"
            return connection.respond(HTTPStatus.FORBIDDEN, words)
        given = _token_of(request)
        if self._token and given and not hmac.compare_digest(given.encode(), self._token.encode()):
            return connection.respond(HTTPStatus.UNAUTHORIZED, "the token is another one\n")
        return None

    async def _handle(self, connection: ServerConnection) -> None:
        request = connection.request
        known = bool(self._token) and request is not None and bool(_token_of(request))
        try:
            await Session(self._hub, WebSocketConnection(connection), "" if known else self._token).run()
        except ConnectionClosed:
            pass  # however it has ended, the session is over


def _token_of(request: Request) -> str:
    scheme, _, word = request.headers.get("Authorization", "").partition(" ")
    if scheme.lower() == "bearer" and word:
        return word.strip()
    return (parse_qs(urlsplit(request.path).query).get("token") or [""])[0]
