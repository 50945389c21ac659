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
        ValueError: when the port is not a number from 1 to 65535, or the address is a URL.
    """
    if "://" in address:
        scheme, _, rest = address.partition("://")
        raise ValueError(f"{address!r} is no address: leave {scheme}:// away, as in {rest.rstrip('/')!r}")
    host, separator, port = address.rpartition(":")
    if not separator or (":" in host and not host.startswith("[")) or address.endswith("]"):
        host, port = address, ""  # no port at all, or a bare IPv6 address
    if not port:
        return host.strip("[]") or DEFAULT_HOST, DEFAULT_PORT
    if not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise ValueError(f"{address!r} is no address: {port!r} is no port; give host:port with a port from 1 to 65535")
    return host.strip("[]") or DEFAULT_HOST, int(port)


def given_token(file: Path | None) -> tuple[str, str]:
    """Return the token in `file`, or else the one that VIRTUALROBOT_TOKEN is, and where it is from; "" for none.

    The rule of both ends: a kernel that is given a token so wants it, a client sends it.

    Raises:
        ValueError: when the file cannot be read or is empty, or what is given is no token.
    """
    if file is None:
        return checked_token(os.environ.get(TOKEN_VARIABLE, "").strip(), TOKEN_VARIABLE), TOKEN_VARIABLE
    try:
        token = file.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        said = error.strerror if isinstance(error, OSError) else "it is no text"
        # What is no path may be the token itself, which belongs in no log; the error below it would tell it too.
        name = repr(str(file)) if _is_path(str(file)) else f"of the name that was given, in {os.getcwd()!r}"
        raise ValueError(
            f"no token can be read from the file {name}: {said}; a token itself goes into {TOKEN_VARIABLE}"
        ) from None
    if not token:
        raise ValueError(f"the token file {file} is empty")
    return checked_token(token, f"the file {file}"), f"the file {file}"


def checked_token(token: str, origin: str) -> str:
    """Return `token`, which is from `origin`.

    Raises:
        ValueError: when it is a path (`_is_path`), or no single word of printable ASCII; the message is without it.
    """
    if _is_path(token):
        raise ValueError(
            f"{origin} is the token itself, and what it holds is the path of a file; --token-file and token_file take "
            "files"
        )
    if not token.isascii() or any(not letter.isprintable() or letter.isspace() for letter in token):
        raise ValueError(f"{origin} holds no token: a token is one word of printable ASCII characters")
    return token


def _is_path(text: str) -> bool:
    """Return whether a text is the path of a file, or begins as one: with `~`, `./`, `../` or a folder that is here.

    A token may have slashes, as base64 has, and a file need not be there to be meant.
    """
    if os.path.isfile(os.path.expanduser(text)) or text.startswith(("~", "./", "../", ".\\", "..\\")):
        return True
    parts = Path(text).parts
    first = 2 if Path(text).anchor else 1
    return len(parts) > first and os.path.isdir(Path(*parts[:first]))


def find_token(port: int, file: Path | None = None) -> tuple[str, str]:
    """Return the token that is given (`given_token`), or else the one in this user's file for `port`, and its origin.

    "" means that there is none: it is a kernel without token, or one of another user, which says so when it is called.
    """
    token, origin = given_token(file)
    path = token_path(port)
    if not token and path.is_file():
        token, origin = given_token(path)
    return token, origin
