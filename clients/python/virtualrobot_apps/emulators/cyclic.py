"""The clock of an emulated controller, and the datagrams that it exchanges with one computer."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable

GREATEST = 65535
"""Longest datagram (bytes) that there is."""
MOST_AT_ONCE = 256
"""Number of datagrams that are read in one cycle; more stay for the next."""


def run(cycle: Callable[[], None], seconds: float, over: threading.Event) -> None:
    """Call `cycle` each `seconds` of the wall clock until `over` is set; cycles that are late are left out."""
    due = time.monotonic()
    while not over.wait(max(0.0, due - time.monotonic())):
        cycle()
        due = max(due + seconds, time.monotonic() - seconds)


class Datagrams:
    """Datagrams to one computer, and what comes back from where they go to."""

    def __init__(self, to: tuple[str, int], address: str = "", port: int = 0) -> None:
        """Speak to `to` from `address` and `port`; empty and 0: the system chooses, one for each connection."""
        self._to = (socket.gethostbyname(to[0]), to[1])
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((address or ("127.0.0.1" if self._to[0].startswith("127.") else ""), port))
        except OSError:
            self._socket.close()
            raise

    def send(self, data: bytes) -> None:
        """Send a datagram; where nobody listens, or the network is gone, it is lost."""
        try:
            self._socket.sendto(data, self._to)
        except OSError:
            return

    def received(self) -> list[bytes]:
        """Return what has come from there, the oldest first; what others have sent is thrown away."""
        got = []
        for _ in range(MOST_AT_ONCE):
            try:
                data, sender = self._socket.recvfrom(GREATEST)
            except BlockingIOError:
                break
            except OSError:
                continue  # nobody was there for what was sent last
            if sender == self._to:
                got.append(data)
        return got

    def close(self) -> None:
        """Give the socket back; harmless more than once."""
        self._socket.close()
