"""Words of the controller: the dashboard's answers, and the messages of the primary interface.

Universal Robots, "Dashboard Server" and "Remote Control via TCP/IP" (client interface: robot messages).
"""

from __future__ import annotations

import re
import socket
import struct

from virtualrobot_sdk.drivers import DriverFault

DASHBOARD, PRIMARY = 29999, 30001
_HEAD = struct.Struct(">iB")
_ROBOT_MESSAGE = 20
_ERROR, _KEY, _EXCEPTION = 6, 7, 10
_LARGEST = 1 << 20


class Dashboard:
    """A connection to port 29999."""

    def __init__(self, host: str, seconds: float) -> None:
        """Connect, and take the banner; raises DriverFault where nobody answers within `seconds`."""
        self._here = f"{host}:{DASHBOARD}"
        try:
            self._socket = socket.create_connection((host, DASHBOARD), seconds)
        except OSError as error:
            raise DriverFault(f"no dashboard answers at {self._here}: {error}", clears=True) from error
        self._socket.settimeout(seconds)
        self._got = b""
        self._line()

    def ask(self, words: str) -> str:
        """Return the answer to a line; raises DriverFault where none comes."""
        try:
            self._socket.sendall(words.encode() + b"\n")
        except OSError as error:
            raise DriverFault(f"the dashboard at {self._here} is lost: {error}", clears=True) from error
        return self._line()

    def _line(self) -> str:
        try:
            while b"\n" not in self._got:
                data = self._socket.recv(4096)
                if not data:
                    raise ConnectionError("it was closed")
                self._got += data
        except OSError as error:
            raise DriverFault(f"the dashboard at {self._here} says nothing: {error}", clears=True) from error
        line, _, self._got = self._got.partition(b"\n")
        return line.decode(errors="replace").strip()

    def close(self) -> None:
        """Give the connection back."""
        self._socket.close()


class Primary:
    """A connection to port 30001: it takes scripts, and tells the controller's messages."""

    def __init__(self, host: str, seconds: float) -> None:
        """Connect; raises DriverFault where nobody answers within `seconds`."""
        here = f"{host}:{PRIMARY}"
        try:
            self._socket = socket.create_connection((host, PRIMARY), seconds)
        except OSError as error:
            raise DriverFault(f"no primary interface answers at {here}: {error}", clears=True) from error
        self._here, self._seconds = here, seconds
        self._got = bytearray()

    def upload(self, script: str) -> None:
        """Give the controller a script, which it runs."""
        self._socket.settimeout(self._seconds)
        try:
            self._socket.sendall(script.encode())
        except OSError as error:
            raise DriverFault(f"the script can't be given to {self._here}: {error}", clears=True) from error

    def messages(self) -> list[tuple[str, str]]:
        """Return the errors that came since it was last called, the oldest first: number and words of each."""
        self._socket.setblocking(False)
        try:
            while data := self._socket.recv(65536):
                self._got += data
        except OSError:
            pass  # RTDE tells of a lost connection
        found = []
        while len(self._got) >= _HEAD.size:
            size, kind = _HEAD.unpack_from(self._got)
            if not _HEAD.size <= size <= _LARGEST:
                self._got.clear()  # this is no message; the next ones may be
                break
            if len(self._got) < size:
                break
            body = bytes(self._got[_HEAD.size : size])
            del self._got[:size]
            if kind == _ROBOT_MESSAGE and (said := message(body)):
                found.append(said)
        return found

    def close(self) -> None:
        """Give the connection back."""
        self._socket.close()


def message(body: bytes) -> tuple[str, str] | None:
    """Return number and words of a robot message that tells an error; None of others."""
    try:
        _, _, kind = struct.unpack_from(">QBB", body)
        if kind == _ERROR:
            code, argument, _, _, data = struct.unpack_from(">iiiII", body, 10)
            return f"C{code}A{argument}" if code else "", _clean(body[30:]) or f"data {data}"
        if kind == _KEY:
            code, argument, size = struct.unpack_from(">iiB", body, 10)
            title = _clean(body[19 : 19 + size])
            return f"C{code}A{argument}", ": ".join(filter(None, (title, _clean(body[19 + size :]))))
        if kind == _EXCEPTION:
            line, column = struct.unpack_from(">ii", body, 10)
            return "", f"line {line}, column {column}: {_clean(body[18:])}"
    except struct.error:
        pass
    return None


def _clean(data: bytes) -> str:
    return re.sub(r"[\x00-\x1f]+", " ", data.decode(errors="replace")).strip()
