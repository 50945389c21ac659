"""Server of the viewer's page: on the first free port, and only for pages that it has served itself.

The page has no password: on this machine every program may look. A page of another site may not, though the browser
that shows it runs on this machine: browsers let any page open a websocket to any address, so the server looks at the
Origin that they send; and at the Host, since a foreign name may be made to point to this machine (DNS rebinding).
"""

from __future__ import annotations

import contextlib
import http
import io
import socket
import threading
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import viser
import websockets.asyncio.server as websocket_server
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from virtualrobot_kernel.errors import KernelError, Reason

PORTS_TRIED = 50
"""Number of ports that are tried, from the one that was asked for."""

THIS_MACHINE = ("localhost", "127.0.0.1", "::1")

_starting = threading.Lock()


def serve(host: str, port: int) -> viser.ViserServer:
    """Return a running server on the first free port from `port` on; raise KernelError when there is none."""
    last = port + PORTS_TRIED - 1 if port else 0
    for candidate in range(port, last + 1):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, candidate))
            except (OSError, OverflowError):
                continue
            free = probe.getsockname()[1]
        with quiet(), _checking(frozenset((*THIS_MACHINE, host))):
            return _LocalServer(host=host, port=free, verbose=False)
    raise KernelError(
        f"the viewer can listen on no port from {port} to {last} of {host}; choose another one, or 0 for any free port",
        reason=Reason.INVALID_ARGUMENT,
        host=host,
        port=port,
    )


def quiet() -> contextlib.AbstractContextManager[object]:
    """Return a context without output: viser prints when it starts and stops, whatever `verbose` says."""
    return contextlib.redirect_stdout(io.StringIO())


def refused(request: Request, names: frozenset[str]) -> Response | None:
    """Return the refusal (403) of a request from elsewhere; None when it may pass.

    Its Host must be one of `names`, with any port (it may be forwarded); its Origin, when there is one, the same place.
    """
    hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
    if len(hosts) != 1 or _name(f"//{hosts[0]}") not in names:
        said = f"this page is at {' or '.join(sorted(names))}, not at {', '.join(hosts) or 'an unnamed host'}"
    elif any(urlsplit(origin).netloc != hosts[0] for origin in origins):
        said = f"pages of {', '.join(origins)} may not look; open http://{hosts[0]}"
    else:
        return None
    body = f"{said}\n".encode()
    headers = Headers({"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))})
    return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", headers, body)


def _name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None


@contextlib.contextmanager
def _checking(names: frozenset[str]) -> Iterator[None]:
    """Have the server that is made in this context ask `refused` first.

    viser has no hook for that, so the function that it serves with is another one meanwhile.
    """
    original = websocket_server.serve

    def checked(*arguments: Any, process_request: Any, **options: Any) -> websocket_server.serve:  # noqa: ANN401 viser's
        def process(connection: websocket_server.ServerConnection, request: Request) -> Response | None:
            return refused(request, names) or process_request(connection, request)

        return original(*arguments, process_request=process, **options)

    with _starting:
        websocket_server.serve = checked
        try:
            yield
        finally:
            websocket_server.serve = original


class _LocalServer(viser.ViserServer):
    """A viser server that never reaches out: its page can ask for a public tunnel, and gets none."""

    def request_share_url(self, verbose: bool = True) -> None:
        """Refuse to be reached from outside."""
        del verbose
