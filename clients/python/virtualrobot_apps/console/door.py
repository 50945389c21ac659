"""Door of the console's port: names of the host, origins of pages, and links that are good once."""

from __future__ import annotations

import ipaddress
import secrets
import socket
from collections.abc import Callable, Iterable
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

Headers = dict[str, str]
Token = Callable[[], str]
"""Tells a token of the kernel as it is now: one that is started anew may have another one."""

MOST_LINKS, MOST_SESSIONS = 100, 1000
"""Links and sessions that are remembered; the oldest go first."""


class Door:
    """The rules for requests of browsers.

    A request must name the console by an address or by one of its names, since a page of others can have its own name
    lead here (DNS rebinding). A page must be the console's own or of an origin that was allowed. The browser's session
    stands for the token that its link was made with, and counts for the console's own page alone.
    """

    def __init__(self, names: Iterable[str], origins: Iterable[str], port: int, secure: bool) -> None:
        """Allow these names besides addresses and the machine's, and pages of these origins besides the console's."""
        self._names = {"localhost", socket.gethostname().lower(), *(name.lower() for name in names)}
        self._origins = {origin.lower() for origin in origins}
        self._scheme = "https" if secure else "http"
        # Cookies are for all ports of a host, so that the names of two consoles' differ.
        self._cookie = f"virtualrobot-{port}"
        self._links: dict[str, Token] = {}
        self._sessions: dict[str, Token] = {}

    def fault(self, headers: Headers) -> str:
        """Return why a request may not come in, "" when it may."""
        host = headers.get("host", "")
        if not self._is_ours(host):
            return f"the console has no name {host!r}: --host-name gives it one"
        origin = headers.get("origin", "")
        if origin and not self.is_own(headers) and not self.is_allowed(origin):
            return f"pages of {origin} may not call: --origin allows them"
        return ""

    def is_own(self, headers: Headers) -> bool:
        """Return whether a request is of the console's own page, or of no page."""
        own = f"{self._scheme}://{headers.get('host', '')}"
        return headers.get("origin", own).lower() == own.lower()

    def is_allowed(self, origin: str) -> bool:
        """Return whether pages of another origin may call."""
        return origin.lower() in self._origins

    def new_link(self, token: Token) -> str:
        """Return the key of a link that lets one browser in with a token of the kernel."""
        return _kept(self._links, token, MOST_LINKS)

    def enter(self, key: str) -> str | None:
        """Return the cookie of the session that a link begins; None when the link is unknown or used."""
        token = self._links.pop(key, None)
        if token is None:
            return None
        session = _kept(self._sessions, token, MOST_SESSIONS)
        secure = "; Secure" if self._scheme == "https" else ""
        return f"{self._cookie}={session}; Path=/; HttpOnly; SameSite=Strict{secure}"

    def token(self, headers: Headers) -> Token | None:
        """Return the token of the browser's session; None without one."""
        if not self.is_own(headers):
            return None
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self._cookie)
        except CookieError:
            return None
        return None if cookie is None else self._sessions.get(cookie.value)

    def _is_ours(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        if name in self._names:
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return True


def _kept(table: dict[str, Token], token: Token, most: int) -> str:
    key = secrets.token_urlsafe(24)
    table[key] = token
    while len(table) > most:
        del table[next(iter(table))]
    return key
