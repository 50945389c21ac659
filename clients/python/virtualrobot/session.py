"""Meeting point of a kernel and its clients: the usual address, the file with the token, the test for this machine.

The kernel writes the token, clients of the same user read it; both take the rule from here.
"""

from __future__ import annotations

import ipaddress
import os
from pathlib import Path

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 50500
ADDRESS_VARIABLE = "VIRTUALROBOT_ADDRESS"
TOKEN_VARIABLE = "VIRTUALROBOT_TOKEN"


def token_path(port: int) -> Path:
    """Return the file that holds the token of the kernel listening on `port`; only its user may read it."""
    # Imported here so that importing the package stays quick.
    import platformdirs

    return Path(platformdirs.user_state_path("virtualrobot", appauthor=False)) / f"token-{port}"


def default_address() -> str:
    """Return `host:port` from the environment variable VIRTUALROBOT_ADDRESS, or 127.0.0.1:50500."""
    return os.environ.get(ADDRESS_VARIABLE) or f"{DEFAULT_HOST}:{DEFAULT_PORT}"


def is_loopback(host: str) -> bool:
    """Return whether `host` is this machine by its loopback interface: beyond it both ends want TLS."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def split_address(address: str) -> tuple[str, int]:
    """Return host and port of `host:port`, `host` (the usual port), `:port` (this machine) or `[::1]:port`.

    Raises:
        ValueError: when the port is not a number from 1 to 65535.
    """
    host, separator, port = address.rpartition(":")
    if not separator or (":" in host and not host.startswith("[")) or address.endswith("]"):
        host, port = address, ""  # no port at all, or a bare IPv6 address
    if not port:
        return host.strip("[]") or DEFAULT_HOST, DEFAULT_PORT
    if not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise ValueError(f"{address!r} is no address: {port!r} is no port; give host:port with a port from 1 to 65535")
    return host.strip("[]") or DEFAULT_HOST, int(port)


def find_token(port: int) -> str | None:
    """Return the token from the environment variable VIRTUALROBOT_TOKEN or this user's file for `port`, else None."""
    if token := os.environ.get(TOKEN_VARIABLE):
        return token
    try:
        return token_path(port).read_text(encoding="utf-8").strip() or None
    except OSError:
        return None  # a kernel without token, or one of another user: the kernel says so when it is called
