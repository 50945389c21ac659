"""The controller's side of drivers that answer datagrams, in lockstep: a packet goes out when the test says so."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from itertools import count

from virtualrobot_sdk.drivers import About, Driver

from tests.waiting import repeated

ADDRESS = f"127.{64 + (os.getpid() >> 16 & 63)}.{os.getpid() >> 8 & 255}.{os.getpid() & 255}"
"""Address of this process alone, all of which are this computer's: tests side by side don't share ports."""
_ports = count(20001)


def free_port() -> int:
    """Return a port of `ADDRESS` that nothing else in this process has been given."""
    return next(_ports)


class Peer:
    """Socket of a controller."""

    def __init__(self, port: int, host: str = ADDRESS) -> None:
        """Speak to `port` of `ADDRESS` from `host`."""
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((host, 0))
        self._to = (ADDRESS, port)

    def send(self, data: bytes) -> None:
        """Send a datagram; the driver may not be there yet."""
        self.socket.sendto(data, self._to)

    def answers(self) -> list[bytes]:
        """Return what has been answered and was not looked at yet, the oldest first."""
        self.socket.setblocking(False)
        got = []
        while True:
            try:
                got.append(self.socket.recv(65535))
            except BlockingIOError:
                return got

    def close(self) -> None:
        """Give the socket back."""
        self.socket.close()


def connected(driver: Driver, speak: Callable[[], object]) -> About:
    """Connect a driver whose controller speaks by `speak` meanwhile."""
    with repeated(speak):
        return driver.connect()
