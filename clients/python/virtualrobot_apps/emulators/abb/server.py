"""Server of Robot Web Services: HTTP with authentication and sessions, and WebSockets of subscriptions.

Version 1.0 is that of IRC5: HTTP, Digest, XHTML or JSON. Version 2.0 is that of OmniCore: HTTP over TLS, Basic, XHTML
or HAL, types with `;v=2.0` behind.
"""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import parse_qs

import uvicorn
from virtualrobot.errors import VirtualRobotError

from virtualrobot_apps.asgi import server_config
from virtualrobot_apps.emulators.abb.answers import (
    HAL,
    SECOND,
    XHTML,
    Answer,
    failed,
    hal_failed,
    hal_state,
    page,
    state,
    xhtml,
)
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.emulators.abb.digest import Basic, Digest
from virtualrobot_apps.emulators.abb.refused import RETURN_CODES, Refused
from virtualrobot_apps.emulators.abb.subscriptions import Subscriptions
from virtualrobot_apps.emulators.abb.table import Call, find

Event: TypeAlias = dict[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Event]]
Send: TypeAlias = Callable[[Event], Awaitable[None]]

MOST_BYTES = 16 * 1024 * 1024
"""Size of the longest body."""
QUIET_SECONDS = 0.5
"""Time (s) without more of a body that is too long after which that is answered."""
MOST_FIELDS = 3000
MOST_SESSIONS = 70
"""Number of sessions at a time, as on a controller."""
IDLE_SECONDS = 300.0
"""Time (s) after which a session ends that nobody uses."""
LOOK_SECONDS = 0.02
"""Time (s) from one look at what is subscribed to the next."""
SESSION, NUMBER = "-http-session-", "ABBCX"
"""Cookies: the session, which nobody can guess, and its number."""
SUBPROTOCOLS = {False: "robapi2_subscription", True: "rws_subscription"}
"""Subprotocol of WebSockets by 1.0, and by 2.0 (True)."""
TAKEN = ("*/*", "application/*", HAL, XHTML + SECOND)
"""Types of answers that a client of 2.0 may ask for."""
GIVEN = ("application/x-www-form-urlencoded", "text/plain", "application/octet-stream")
"""Types of bodies that a client of 2.0 may send, each with the version behind."""


@dataclass(slots=True)
class Session:
    """A client that comes again: its number, and when it was here last (s)."""

    number: int
    seen: float


class Server:
    """The server, an ASGI application."""

    def __init__(self, controller: Controller, users: dict[str, str], *, second: bool = False) -> None:
        """Serve a controller to these users, by name and password, by 1.0 or 2.0 (`second`)."""
        self._controller, self._second = controller, second
        self._door = Basic(users) if second else Digest(users)
        self._subscriptions = Subscriptions(controller, second=second)
        self._sessions: dict[str, Session] = {}
        self._numbers = 0

    async def __call__(self, scope: Event, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] == "http":
            await self._http(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._websocket(scope, receive, send)

    # Who it is.

    def _who(self, scope: Event, method: str) -> tuple[str, list[tuple[str, str]]]:
        """Return the session of a request and the headers that tell it to the client; raises Denied."""
        given = _headers(scope)
        target = scope["raw_path"].decode("latin-1") + ("?" if scope["query_string"] else "")
        target += scope["query_string"].decode("latin-1")
        try:
            cookies = {name: morsel.value for name, morsel in SimpleCookie(given.get("cookie", "")).items()}
        except CookieError:
            cookies = {}
        now = time.monotonic()
        for key in [key for key, one in self._sessions.items() if now - one.seen > IDLE_SECONDS]:
            del self._sessions[key]
        key = cookies.get(SESSION, "")
        if key not in self._sessions:
            verdict = self._door.accepts(given.get("authorization", ""), method, target)
            if verdict != "yes":
                raise Denied(self._door.challenge(verdict == "stale"))
            number = cookies.get(NUMBER, "")
            key = next((one for one, held in self._sessions.items() if str(held.number) == number), "")
        if key:
            self._sessions[key].seen = now
            return key, []
        if len(self._sessions) >= MOST_SESSIONS:
            said = f"there are {MOST_SESSIONS} sessions already; keep the cookies, or end one by GET /logout"
            raise Refused("MAX_LIMIT_REACHED", said, 503)
        self._numbers += 1
        key = secrets.token_hex(16)
        self._sessions[key] = Session(self._numbers, now)
        return key, [
            ("set-cookie", f"{SESSION}={key}; path=/; httponly"),
            ("set-cookie", f"{NUMBER}={self._numbers}; path=/; httponly"),
        ]

    # Calls.

    async def _http(self, scope: Event, receive: Receive, send: Send) -> None:
        given = _headers(scope)
        base = f"{scope['scheme']}://{given.get('host', 'localhost')}{scope['path'].rpartition('/')[0]}/"
        cookies: list[tuple[str, str]] = []
        as_json = self._second and HAL in given.get("accept", "").replace("; ", ";")
        try:
            body = await _body(receive, int(given.get("content-length", "0")))
            key, cookies = self._who(scope, scope["method"])
            query = _fields(scope["query_string"])
            as_json = as_json or query.get("json", [""])[0] == "1"
            if self._second:
                _look_at_types(given, body)
            answer = await asyncio.to_thread(self._answer, scope, query, body, key, base, as_json)
        except Denied as denied:
            way = "Basic" if self._second else "Digest"
            words = f"{way} authentication is needed: a user of this controller, and the password"
            answer = self._failed(401, RETURN_CODES["SYS_CTRL_E_FAIL"], words, base, as_json)
            cookies = [("www-authenticate", denied.challenge)]
        except Refused as refused:
            answer = self._failed(refused.status, refused.code, refused.words, base, as_json)
        kind = answer.kind + (SECOND if self._second and answer.kind == XHTML else "")
        headers = [("content-type", kind), ("content-length", str(len(answer.body))), *answer.headers, *cookies]
        if answer.status == 204:
            headers = [one for one in headers if not one[0].startswith("content-")]
        encoded = [(name.encode(), value.encode("latin-1", "replace")) for name, value in headers]
        await send({"type": "http.response.start", "status": answer.status, "headers": encoded})
        await send({"type": "http.response.body", "body": answer.body})

    def _answer(
        self, scope: Event, query: Mapping[str, list[str]], body: bytes, key: str, base: str, as_json: bool
    ) -> Answer:
        method, path = scope["method"], scope["path"]
        if path.rstrip("/") == "/logout" and method == "GET":
            self._sessions.pop(key, None)
            return Answer(204)
        form = {} if method == "PUT" and path.startswith("/fileservice/") else _fields(body)
        if path == "/subscription" or path.startswith("/subscription/"):
            return self._subscribe(method, path, form, base)
        action = query.get("action", form.get("action", [""]))[0]
        found, names = find(method, path, action, second=self._second)
        call = Call(self._controller, names, _firsts(query), _firsts(form), body, self._second)
        try:
            handled = found.run(call)
        except VirtualRobotError as error:
            raise Refused("FAIL", str(error), 500) from error
        if isinstance(handled, Answer):
            return handled
        if handled is None:
            return Answer(204)
        return hal_state(handled, base) if as_json and self._second else state(handled, base, as_json)

    def _failed(self, status: int, code: int, words: str, base: str, as_json: bool) -> Answer:
        second = as_json and self._second
        return hal_failed(status, code, words, base) if second else failed(status, code, words, base, as_json)

    # Subscriptions.

    def _subscribe(self, method: str, path: str, form: Mapping[str, list[str]], base: str) -> Answer:
        if path.rstrip("/") == "/subscription":
            if method != "POST":
                raise Refused("UNRESOLVED_URL", f"/subscription takes POST, not {method}", 405)
            number = self._subscriptions.make(form)
            scheme, _, rest = base.partition("://")
            poll = f"{'wss' if scheme == 'https' else 'ws'}://{rest.partition('/')[0]}/poll/{number}"
            links = f'<a href="subscription/{number}" rel="group"></a><a href="{poll}" rel="self"></a>'
            return Answer(201, page("", base, links), headers=(("location", poll),))
        number = _number(path.removeprefix("/subscription/"))
        if method == "DELETE":
            self._subscriptions.of(number)
            self._subscriptions.close(number)
        elif method == "PUT":
            self._subscriptions.add(number, form)
        else:
            raise Refused("UNRESOLVED_URL", f"{path} takes DELETE, PUT, not {method}", 405)
        return Answer(200)

    async def _websocket(self, scope: Event, receive: Receive, send: Send) -> None:
        await receive()  # websocket.connect
        try:
            self._who(scope, "GET")
            number = _number(scope["path"].removeprefix("/poll/"))
            self._subscriptions.of(number)
        except (Denied, Refused):
            await send({"type": "websocket.close", "code": 1008})  # before the handshake: 403
            return
        self._subscriptions.claim(number)
        known = SUBPROTOCOLS[self._second]
        chosen = known if known in scope["subprotocols"] else None
        await send({"type": "websocket.accept", "subprotocol": chosen})
        gone = asyncio.create_task(_gone(receive))
        try:
            while not gone.done():
                links = f'<a href="subscription/{number}" rel="group"></a>'
                for item in await asyncio.to_thread(self._subscriptions.changes, number):
                    # Clients look at the first event of a message alone.
                    await send({"type": "websocket.send", "text": page(xhtml(item), "/", links).decode()})
                await asyncio.wait([gone], timeout=LOOK_SECONDS)
        except Refused:  # the subscription was deleted
            await send({"type": "websocket.close", "code": 1000})
        except (VirtualRobotError, OSError):  # the kernel or the client is gone
            pass
        finally:
            gone.cancel()
            self._subscriptions.close(number)


class Denied(Exception):
    """A request of nobody who may come in; `challenge` is what the client has to answer."""

    def __init__(self, challenge: str) -> None:
        """Keep the challenge."""
        super().__init__(challenge)
        self.challenge = challenge


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "websocket.disconnect":
        pass


async def _body(receive: Receive, announced: int) -> bytes:
    """Return the body; of one that is too long all is taken that comes, since a client that sends hears no answer."""
    body, more, long = b"", True, announced > MOST_BYTES
    while more:
        try:
            event = await asyncio.wait_for(receive(), QUIET_SECONDS if long else None)
        except TimeoutError:
            break
        if event["type"] == "http.disconnect":
            raise Refused("INVALIDARG", "the body is cut off")
        long = long or len(body) + len(event.get("body", b"")) > MOST_BYTES
        body = b"" if long else body + event.get("body", b"")
        more = event.get("more_body", False)
    if long:
        raise Refused("MAX_LIMIT_REACHED", f"a body has at most {MOST_BYTES} bytes", 413)
    return body


def _look_at_types(given: Mapping[str, str], body: bytes) -> None:
    """Refuse types without the version of 2.0, as its controllers do."""
    wanted = [one.partition(";q=")[0].strip() for one in given.get("accept", "*/*").replace("; ", ";").split(",")]
    if not set(wanted) & set(TAKEN):
        said = f"Accept is {HAL} or {XHTML}{SECOND}, not {given['accept']!r}"
        raise Refused("INVALIDARG", said, 406)
    kind, _, version = given.get("content-type", "").replace("; ", ";").partition(";")
    if body and (kind not in GIVEN or "v=2.0" not in version.split(";")):
        said = f"Content-Type is {', '.join(GIVEN)}, each with {SECOND!r} behind, not {given.get('content-type', '')!r}"
        raise Refused("INVALIDARG", said, 415)


def _headers(scope: Event) -> dict[str, str]:
    return {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}


def _fields(data: bytes) -> dict[str, list[str]]:
    try:
        return parse_qs(data.decode(), keep_blank_values=True, max_num_fields=MOST_FIELDS, errors="strict")
    except ValueError as error:
        raise Refused("INVALIDARG", f"this is no form in UTF-8 of at most {MOST_FIELDS} fields: {error}") from None


def _firsts(fields: Mapping[str, list[str]]) -> dict[str, str]:
    return {name: values[0] for name, values in fields.items()}


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise Refused("UNRESOLVED_URL", f"there is no subscription {text!r}", 404)
    return int(text)


def made(application: Server, certificate: tuple[Path, Path] | None = None) -> uvicorn.Server:
    """Return what serves it, HTTP by h11 and WebSockets by websockets; over TLS with certificate and key, PEM files."""
    file, key = certificate if certificate is not None else (None, None)
    return uvicorn.Server(server_config(application, 64 * 1024, ssl_certfile=file, ssl_keyfile=key))
