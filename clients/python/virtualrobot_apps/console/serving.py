"""The console's server as it runs: sockets, certificates, and the link that is told."""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from threading import Thread

import uvicorn
import virtualrobot
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.session import is_loopback

from virtualrobot_apps.asgi import server_config
from virtualrobot_apps.console.door import Door, Token
from virtualrobot_apps.console.editing import PageEditors
from virtualrobot_apps.console.invitation import ALONE, NAMELESS, Reach
from virtualrobot_apps.console.page_files import AUTHORITY, is_built
from virtualrobot_apps.console.server import Server
from virtualrobot_apps.console.tls import tls_context
from virtualrobot_apps.console.tools import PageTools
from virtualrobot_apps.console.upstream import Upstream
from virtualrobot_apps.console.wires import Limit

FIRST_PORT, TRIED_PORTS = 8090, 10
"""Ports that are tried before any free one is taken."""

ANYWHERE = "0.0.0.0", "::"
"""Addresses to listen on that stand for all of the machine's."""

_FRAME_BYTES = 1024
"""Bytes that a frame of a WebSocket may have besides its message."""


@dataclass(frozen=True, slots=True)
class Kernel:
    """The kernel that is served.

    token: tells the token of the console; what pages that come in by the printed link may do is what it may.
    message_bytes: the greatest message that it takes.
    connections: a file of connections that run with that token from the begin; None: none.
    """

    address: str
    token: Token
    certificate: Path | None
    message_bytes: int
    connections: Path | None = None

    def connect(self, token: str) -> virtualrobot.Client:
        """Return a client of its own with a token, "" for a kernel that wants none."""
        return virtualrobot.connect(
            self.address, token or None, root_certificate=self.certificate, name="console", on_progress=None
        )


@dataclass(frozen=True, slots=True)
class Place:
    """Address of the console, its names and its certificate, and the origins of pages that may call.

    port: 0 is any free one, None the first free one from 8090.
    tls_key: None for a certificate whose file has its key, too.
    authority: the certificate of the installation's own authority, which devices get from the console.
    """

    host: str
    port: int | None
    names: Sequence[str]
    origins: Sequence[str]
    tls_certificate: Path | None
    tls_key: Path | None
    authority: Path | None = None

    def with_own_certificate(self) -> Place:
        """Return the same place with a certificate by the installation's own authority, and a name that it is for.

        Raises:
            InvalidArgumentError: for names that the authority doesn't sign for.
        """
        from virtualrobot_apps.console.authority import own_certificate

        names = [*self.names, *([] if self.host in ANYWHERE else [self.host])]
        own = own_certificate(names, version=6 if ":" in self.host else 4)
        names = self.names or ([own.address] if self.host in ANYWHERE else ())
        return replace(self, names=names, tls_certificate=own.file, tls_key=None, authority=own.authority)


def run(
    kernel: Kernel,
    place: Place,
    say: Callable[[str], object],
    show: Callable[[str], object] | None = None,
    end_with_input: bool = False,
) -> None:
    """Serve until Ctrl-C; `say` is told the link, and the next one when it has been used.

    Args:
        kernel: what is served.
        place: where.
        say: is told each line for people.
        show: is told a link of its own, once it serves.
        end_with_input: end when the standard input does, as it does however its other end died.

    Raises:
        InvalidArgumentError: when nothing can listen there, or the certificate doesn't fit.
    """
    with _listen(place) as listening:
        asyncio.run(_serve(kernel, place, listening, say, show, end_with_input))


def _listen(place: Place) -> socket.socket:
    if place.port is not None:
        return listen(place.host, place.port)
    for port in range(FIRST_PORT, FIRST_PORT + TRIED_PORTS):
        with suppress(InvalidArgumentError):
            return listen(place.host, port)
    return listen(place.host, 0)


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; small frames that come through it aren't held back for 40 ms.

    Raises:
        InvalidArgumentError: when nothing can listen there.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listening = socket.create_server((host, port), family=family)
    except OSError as error:
        said = f"the console can't listen at {host}, port {port}: {error.strerror or error}"
        raise InvalidArgumentError(f"{said}; --port takes another one, 0 any free one") from None
    # asyncio sets this for sockets that were made for TCP by name alone, which this one wasn't.
    listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listening


async def _serve(
    kernel: Kernel,
    place: Place,
    listening: socket.socket,
    say: Callable[[str], object],
    show: Callable[[str], object] | None,
    end_with_input: bool,
) -> None:
    port = listening.getsockname()[1]
    door = Door([place.host, *place.names], place.origins, port, place.tls_certificate is not None)
    scheme = "http" if place.tls_certificate is None else "https"
    name = next(iter(place.names), socket.gethostname() if place.host in ANYWHERE else place.host)
    base = f"{scheme}://{f'[{name}]' if ':' in name else name}:{port}"

    def link() -> str:
        return f"{base}/?key={door.new_link(kernel.token)}"

    def tell(words: str) -> None:
        say(f"{words} {link()}")

    upstream = Upstream(kernel.address, kernel.certificate)
    limit = Limit(kernel.message_bytes)
    tools = PageTools(upstream, limit, kernel.connect)
    editors = PageEditors(upstream, limit, kernel.address, kernel.certificate)
    another = partial(tell, "a link for another browser:")
    reach = Reach(base, place.authority is not None, ALONE if is_loopback(place.host) else NAMELESS)
    server = Server(upstream, door, limit, tools, editors, another, place.authority, reach)
    config = server_config(
        server,
        # Larger ones are refused by name, so that they must come in.
        2 * kernel.message_bytes + _FRAME_BYTES,
    )
    config.load()
    try:
        if place.tls_certificate is not None:
            config.ssl = tls_context(place.tls_certificate, place.tls_key, base)
    except OSError as error:
        raise InvalidArgumentError(f"--tls-certificate and --tls-key are no certificate and its key: {error}") from None
    if kernel.connections is not None:
        await tools.begin(kernel.token(), kernel.connections)
    tell("console at")
    say(f"the link is good once; programs call {base}/virtualrobot.v1.SERVICE/METHOD")
    if place.authority is not None:
        say(f"each device trusts {place.authority} once, which it gets at {base}{AUTHORITY}")
        if reach.is_alone and not is_loopback(place.host):
            say(reach.fault)
    if not is_built():
        say("its page is not built: in a clone of the repository, make console")
    if show is not None:
        show(link())
    uvicorn_server = uvicorn.Server(config)
    if end_with_input:
        Thread(target=_await_end_of_input, args=(uvicorn_server,), name="input", daemon=True).start()
    try:
        await uvicorn_server.serve([listening])
    finally:
        await tools.close()
        await upstream.close()


def _await_end_of_input(server: uvicorn.Server) -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    server.should_exit = True
