"""Connections of a script, by name: what has come over them is looked at once a cycle, and nothing waits here."""

from __future__ import annotations

import errno
import select
import socket

MOST = 1 << 20
"""Bytes that may wait on a connection, each way; more end it."""


class Connection:
    """A connection that is being opened, or is open."""

    def __init__(self, address: str, port: int) -> None:
        """Begin to connect; raises OSError where there is no such address."""
        family, kind, protocol, _, place = socket.getaddrinfo(address, port, type=socket.SOCK_STREAM)[0]
        self._socket = socket.socket(family, kind, protocol)
        self._socket.setblocking(False)
        self.got, self._waiting = bytearray(), bytearray()
        self.open = self.ended = False
        self.ended = self._socket.connect_ex(place) not in (0, errno.EINPROGRESS, errno.EWOULDBLOCK)

    def look(self) -> None:
        """Take what has come and send what waits."""
        if self.ended:
            return
        readable, writable, failed = select.select([self._socket], [self._socket], [self._socket], 0.0)
        try:
            if not self.open and (writable or failed):
                self.ended = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) != 0
                self.open = not self.ended
                if self.open:
                    self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self.open and readable:
                data = self._socket.recv(65536)
                self.got += data
                self.ended = not data
            if self.open and self._waiting:
                del self._waiting[: self._socket.send(self._waiting)]
        except BlockingIOError:
            pass
        except OSError:
            self.ended = True
        self.ended |= max(len(self.got), len(self._waiting)) > MOST

    def send(self, data: bytes) -> bool:
        """Send, or keep what the other side doesn't take yet; return whether the connection is there."""
        if not self.open or self.ended:
            return False
        self._waiting += data
        self.look()
        return not self.ended

    def close(self) -> None:
        """Close it."""
        self._socket.close()


class Connections:
    """Connections of one script, by name."""

    def __init__(self) -> None:
        """Begin without any."""
        self._open: dict[str, Connection] = {}

    def connect(self, name: str, address: str, port: int) -> Connection | None:
        """Begin to connect, in place of what had this name; None where there is no such address."""
        self.drop(name)
        try:
            made = Connection(address, port)
        except OSError:
            return None
        self._open[name] = made
        return made

    def get(self, name: str) -> Connection | None:
        """Return the connection of a name."""
        return self._open.get(name)

    def drop(self, name: str) -> None:
        """Close the connection of a name, where there is one."""
        if (connection := self._open.pop(name, None)) is not None:
            connection.close()

    def close(self) -> None:
        """Close all."""
        for name in list(self._open):
            self.drop(name)
