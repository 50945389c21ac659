"""Values of RAPID that are things of their own, and values as text."""

from __future__ import annotations

import re
import socket
from collections.abc import Callable
from typing import Any, BinaryIO


class Clock:
    """A stop watch."""

    def __init__(self, now: Callable[[], float]) -> None:
        """Stand at 0; `now` tells the time (s)."""
        self._now, self._passed = now, 0.0
        self._since: float | None = None

    def start(self) -> None:
        """Run on."""
        if self._since is None:
            self._since = self._now()

    def stop(self) -> None:
        """Stand still."""
        self._passed, self._since = self.read(), None

    def reset(self) -> None:
        """Begin again at 0, running or not as before."""
        self._passed = 0.0
        self._since = None if self._since is None else self._now()

    def read(self) -> float:
        """Return the time (s) that it has run."""
        return self._passed if self._since is None else self._passed + self._now() - self._since


class SocketDevice:
    """A socket of the program, and its state, one of `SOCKET_STATES`."""

    def __init__(self) -> None:
        """Be closed."""
        self.socket: socket.socket | None = None
        self.state = "SOCKET_CLOSED"

    def close(self) -> None:
        """Close it, if it is open."""
        if self.socket is not None:
            self.socket.close()
        self.socket, self.state = None, "SOCKET_CLOSED"


class FileDevice:
    """A file of the program; None while it is closed. A text file is read and written in ISO 8859-1, as bytes."""

    def __init__(self) -> None:
        """Be closed."""
        self.file: BinaryIO | None = None
        self.binary = False

    def close(self) -> None:
        """Close it, if it is open."""
        if self.file is not None:
            self.file.close()
        self.file = None


class FolderDevice:
    """A folder of the program, with the names in it that were not read yet; None while it is closed."""

    def __init__(self) -> None:
        """Be closed."""
        self.names: list[str] | None = None


def number_text(number: float) -> str:
    """Return a number as the pendant shows it, rounded to six digits."""
    text = f"{number:.6g}"
    mantissa, sign, exponent = text.partition("e")
    return f"{mantissa}E{exponent[0]}{exponent[1:].lstrip('0').rjust(2, '0')}" if sign else text


def value_text(value: Any) -> str:  # noqa: ANN401 any value of RAPID
    """Return a value as a program would write it; a string within others has quotes."""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, str):
        return '"{}"'.format(value.replace('"', '""'))
    if isinstance(value, list):
        return f"[{','.join(map(value_text, value))}]"
    return number_text(value) if isinstance(value, int | float) else "?"


_PIECE = re.compile(r'\s*(?:(?P<sign>[\[\],])|"(?P<text>(?:[^"]|"")*)"|(?P<word>[^\[\],"\s]+))')


def read_value(text: str, like: Any) -> Any:  # noqa: ANN401 any value of RAPID
    """Return the value that a text says, of the type of another one; raises ValueError where it says none."""
    if isinstance(like, str):
        return text[1:-1].replace('""', '"') if len(text) > 1 and text[0] == text[-1] == '"' else text
    pieces = [match for match in _PIECE.finditer(text.strip())]
    if "".join(match.group() for match in pieces) != text.strip():
        raise ValueError(text)
    value, rest = _read(pieces, like)
    if rest:
        raise ValueError(text)
    return value


def _read(pieces: list[re.Match[str]], like: Any) -> tuple[Any, list[re.Match[str]]]:  # noqa: ANN401
    if not pieces:
        raise ValueError("nothing")
    first, rest = pieces[0], pieces[1:]
    if isinstance(like, list):
        if first["sign"] != "[":
            raise ValueError(first.group())
        values = []
        for number, inner in enumerate(like):
            value, rest = _read(rest, inner)
            values.append(value)
            wanted = "," if number + 1 < len(like) else "]"
            if not rest or rest[0]["sign"] != wanted:
                raise ValueError(wanted)
            rest = rest[1:]
        return values, rest
    if isinstance(like, str):
        if first["text"] is None:
            raise ValueError(first.group())
        return first["text"].replace('""', '"'), rest
    word = first["word"]
    if word is None:
        raise ValueError(first.group())
    if isinstance(like, bool):
        return {"TRUE": True, "FALSE": False}.get(word.upper()) if word.upper() in ("TRUE", "FALSE") else _no(
            word
        ), rest
    if not re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", word):
        raise ValueError(word)
    return float(word), rest


def _no(word: str) -> bool:
    raise ValueError(word)
