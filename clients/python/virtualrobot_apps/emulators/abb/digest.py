"""Authentication of HTTP: Digest (RFC 7616) with MD5 and `qop=auth`, as Robot Web Services 1.0 asks for, and Basic."""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
import time
from urllib.request import parse_http_list, parse_keqv_list

REALM = "validusers@robapi.abb"
NONCE_SECONDS = 300.0
"""Time (s) after which a client is asked to sign anew, which it does by itself."""


class Digest:
    """Users who may come in, by name, with their passwords."""

    def __init__(self, users: dict[str, str]) -> None:
        """Let these users in."""
        self._users, self._secret = users, secrets.token_bytes(32)

    def challenge(self, stale: bool = False) -> str:
        """Return the header `WWW-Authenticate`; `stale`: the client signs anew, and needs no other password."""
        again = ", stale=true" if stale else ""
        return f'Digest realm="{REALM}", qop="auth", algorithm=MD5, nonce="{self._nonce(time.time())}"{again}'

    def accepts(self, header: str, method: str, target: str) -> str:
        """Return "yes", "stale" where the signature is right and too old, or "no", for a header `Authorization`.

        `target` is path and query, as the client has asked for them.
        """
        kind, _, rest = header.partition(" ")
        if kind.lower() != "digest":
            return "no"
        try:
            given = parse_keqv_list(parse_http_list(rest))
            user, nonce, uri = given["username"], given["nonce"], given["uri"]
            count, once, response = given["nc"], given["cnonce"], given["response"]
        except (IndexError, KeyError, ValueError):  # parse_keqv_list has no word for an empty value
            return "no"
        password = self._users.get(user)
        if password is None or given.get("qop") != "auth" or given.get("realm") != REALM or uri != target:
            return "no"
        who, what = f"{user}:{REALM}:{password}", f"{method}:{uri}"
        wanted = _hash(f"{_hash(who)}:{nonce}:{count}:{once}:auth:{_hash(what)}")
        if not hmac.compare_digest(wanted.encode(), _bytes(response.lower())):
            return "no"
        made = nonce.partition(":")[0]
        try:
            age = time.time() - float(made)
        except ValueError:
            return "stale"
        fresh = age < NONCE_SECONDS and hmac.compare_digest(_bytes(self._signed(made)), _bytes(nonce))
        return "yes" if fresh else "stale"

    def _nonce(self, now: float) -> str:
        return self._signed(f"{now:.3f}")

    def _signed(self, made: str) -> str:
        return f"{made}:{hmac.new(self._secret, _bytes(made), 'sha256').hexdigest()[:32]}"


class Basic:
    """Users who may come in, as Robot Web Services 2.0 asks for them (RFC 7617): over TLS, with name and password."""

    def __init__(self, users: dict[str, str]) -> None:
        """Let these users in."""
        self._users = {f"{name}:{password}".encode() for name, password in users.items()}

    def challenge(self, stale: bool = False) -> str:
        """Return the header `WWW-Authenticate`; nothing gets too old."""
        return f'Basic realm="{REALM}"'

    def accepts(self, header: str, method: str, target: str) -> str:
        """Return "yes" or "no" for a header `Authorization`, whatever is asked for."""
        kind, _, rest = header.partition(" ")
        try:
            given = base64.b64decode(rest.strip(), validate=True) if kind.lower() == "basic" else b""
        except ValueError:
            return "no"
        return "yes" if any([hmac.compare_digest(given, one) for one in self._users]) else "no"


def _hash(text: str) -> str:
    return hashlib.md5(_bytes(text), usedforsecurity=False).hexdigest()


def _bytes(text: str) -> bytes:
    """Return what a header's text was: bytes that are no UTF-8 stand in it as surrogates."""
    return text.encode(errors="surrogateescape")
