"""The console's server as an ASGI application: its page, links, the contract over HTTP, and the calls of pages."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from urllib.parse import parse_qs

from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.console.door import Door
from virtualrobot_apps.console.editing import EDITOR, PageEditors
from virtualrobot_apps.console.http_calls import PREFIX, Caller, Event, HttpCalls, Receive, Send, refuse
from virtualrobot_apps.console.invitation import Reach
from virtualrobot_apps.console.page_calls import PageCalls
from virtualrobot_apps.console.page_files import page_files
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.tools import PageTools
from virtualrobot_apps.console.upstream import Upstream
from virtualrobot_apps.console.wires import Limit

# Textures of meshes come as parts of files that the page has loaded: addresses of its own memory.
_SOURCES = "default-src 'self'; connect-src 'self' blob:; img-src 'self' blob: data:"
_POLICY = f"{_SOURCES}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
_OF_PAGES = [
    (b"content-security-policy", _POLICY.encode()),
    # The address has the key of a link.
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
]
_UNKEPT = (b"cache-control", b"no-store")
_ALLOWED_HEADERS = ", ".join(
    (
        *("authorization", "client-name", "connect-protocol-version", "connect-timeout-ms", "content-type"),
        *("grpc-timeout", "virtualrobot-lease", "x-grpc-web", "x-user-agent"),
    )
)
_EXPOSED_HEADERS = "grpc-message, grpc-status, grpc-status-details-bin"


class Server:
    """The application; `link_used` is called when a browser has come in by a link."""

    def __init__(
        self,
        upstream: Upstream,
        door: Door,
        limit: Limit,
        tools: PageTools,
        editors: PageEditors,
        link_used: Callable[[], None] = lambda: None,
        authority: Path | None = None,
        reach: Reach | None = None,
    ) -> None:
        """Serve one kernel through one door, and to anybody the certificate of an authority.

        `reach` is how others get here; without it, as the browser that asks does.
        """
        self._upstream, self._door, self._limit, self._tools = upstream, door, limit, tools
        self._editors = editors
        self._calls = HttpCalls(upstream, limit)
        self._link_used = link_used
        self._files = page_files(authority)
        self._reach = reach

    async def __call__(self, scope: Event, receive: Receive, send: Send) -> None:
        """Answer a request, or all calls of a page."""
        headers: dict[str, str] = {}
        for name, value in scope["headers"]:
            name, value = name.decode("latin-1").lower(), value.decode("latin-1")
            headers[name] = f"{headers[name]}, {value}" if name in headers else value
        place = (scope.get("client") or ("unknown",))[0]
        caller = Caller(headers, self._door.token(headers), place)
        fault = self._door.fault(headers)
        if scope["type"] == "websocket":
            if not fault and scope["path"] == EDITOR:
                await self._editors.run(caller, receive, send)
            elif not fault and scope["path"] == "/calls":
                await PageCalls(self._upstream, self._limit, caller, receive, send).run()
            else:
                await receive()
                reason = fault or f"calls go to /calls, and messages of editors to {EDITOR}"
                await send({"type": "websocket.close", "code": 1008, "reason": reason})
        elif fault:
            await refuse(send, Refusal("permission_denied", fault))
        else:
            await self._http(scope, caller, receive, self._crossing(headers, send))

    def _crossing(self, headers: dict[str, str], send: Send) -> Send:
        """Return how answers are sent, so that pages of an allowed origin may read them."""
        origin = headers.get("origin", "")
        if not origin or not self._door.is_allowed(origin):
            return send
        more = {
            "access-control-allow-origin": origin,
            "access-control-allow-headers": _ALLOWED_HEADERS,
            "access-control-allow-methods": "POST",
            "access-control-expose-headers": _EXPOSED_HEADERS,
            "access-control-max-age": "7200",
            "vary": "origin",
        }
        encoded = [(name.encode(), value.encode("latin-1")) for name, value in more.items()]

        async def sent(event: Event) -> None:
            if event["type"] == "http.response.start":
                event["headers"] = [*event["headers"], *encoded]
            await send(event)

        return sent

    async def _http(self, scope: Event, caller: Caller, receive: Receive, send: Send) -> None:
        path, verb = scope["path"], scope["method"]
        if verb == "OPTIONS":
            await _respond(send, 204, b"", [])
        elif path.startswith(PREFIX):
            await self._calls.serve(path, verb, caller, receive, send)
        elif path in ("/link", "/invitation") and verb == "POST":
            await self._link(scope["scheme"], caller, send, coded=path == "/invitation")
        elif self._tools.knows(path):
            await self._tools.serve(path, verb, caller, receive, send)
        elif verb not in ("GET", "HEAD") or path not in self._files:
            await refuse(send, Refusal("not_found", f"there is no {path}; methods are POST to {PREFIX}SERVICE/METHOD"))
        elif path == "/" and (key := parse_qs(scope["query_string"].decode("latin-1")).get("key")):
            await self._enter(key[0], send)
        else:
            file = self._files[path]
            headers = [(b"content-type", file.type.encode()), (b"cache-control", file.caching.encode())]
            await _respond(send, 200, file.data, [*headers, *_OF_PAGES])

    async def _link(self, scheme: str, caller: Caller, send: Send, *, coded: bool) -> None:
        """Answer with a link for one more browser, which is good for what the caller's token is good for.

        `coded` wants it for another device, as a code that it reads.
        """
        metadata, host = caller.metadata(), caller.headers["host"]
        try:
            await self._upstream.info(metadata)
            key, own = self._door.new_link(caller.carried), f"{scheme}://{host}"
            told = (self._reach or Reach(own)).invited(host, key) if coded else {"url": f"{own}/?key={key}"}
        except Refusal as refusal:
            await refuse(send, refusal)
        except VirtualRobotError as error:
            await refuse(send, Refusal.of_client(error))
        else:
            await _respond(send, 200, json.dumps(told).encode(), [(b"content-type", b"application/json"), _UNKEPT])

    async def _enter(self, key: str, send: Send) -> None:
        cookie = self._door.enter(key)
        # The browser forgets the key, and a page that is loaded again does not ask with it. A used link leads to
        # the page, too: who has a session goes on there, and who has none is told so.
        begun = [(b"set-cookie", cookie.encode())] if cookie else []
        await _respond(send, 303, b"", [(b"location", b"/"), *begun, _UNKEPT, *_OF_PAGES])
        if cookie:
            self._link_used()


async def _respond(send: Send, status: int, data: bytes, headers: list[tuple[bytes, bytes]]) -> None:
    length = (b"content-length", str(len(data)).encode())
    await send({"type": "http.response.start", "status": status, "headers": [*headers, length]})
    await send({"type": "http.response.body", "body": data})
