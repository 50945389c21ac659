"""Datagrams (UDP) of one controller: bound to one address, taken from one peer, with a time after which it is silent.

Controllers with Externally Guided Motion (ABB) or the Robot Sensor Interface (KUKA) begin to speak by themselves and
send at their own rate. What others send to the same port is counted and thrown away.
"""

from __future__ import annotations

import select
import socket
import time

from virtualrobot_sdk.drivers import DriverFault

GREATEST = 65535
"""Longest datagram (bytes) that there is."""
MOST_AT_ONCE = 256
"""Datagrams that are looked at before whoever sends them is said to flood."""


class Datagrams:
    """A bound socket. It takes what comes from one host, and from the first port there that `lock` was called for."""

    def __init__(self, address: str, port: int, controller: str) -> None:
        """Bind to `address` and `port` for datagrams of the host `controller`.

        Raises DriverFault where that host has no address, or the address and port can't be had.
        """
        try:
            self._host = socket.gethostbyname(controller)
        except OSError as error:
            raise DriverFault(f"the controller {controller!r} has no address: {error}") from error
        self._peer: tuple[str, int] | None = None
        self._from: tuple[str, int] | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.here, self.strangers = f"{address}:{port}", 0
        try:
            self._socket.bind((address, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise DriverFault(f"{self.here} cannot be listened at: {error}", clears=True) from error
        self._socket.setblocking(False)

    @property
    def port(self) -> int:
        """The port that it is bound to."""
        return self._socket.getsockname()[1]

    def lock(self) -> None:
        """Take datagrams of the sender of the newest one alone, from now on."""
        self._peer = self._from

    def receive(self, seconds: float) -> list[bytes]:
        """Return what has come, the oldest first, and wait at most `seconds` for the first of it.

        Nothing is returned once `seconds` are negative. Raises DriverFault where there is no end to what comes.
        """
        if seconds < 0.0:
            return []
        deadline, got = time.monotonic() + seconds, []
        for _ in range(MOST_AT_ONCE):
            wait = 0.0 if got else max(0.0, deadline - time.monotonic())
            if not select.select([self._socket], [], [], wait)[0]:
                return got
            try:
                data, sender = self._socket.recvfrom(GREATEST)
            except ConnectionError:
                continue  # what was sent last found nobody, which some systems tell here
            if sender[0] != self._host or (self._peer is not None and sender != self._peer):
                self.strangers += 1
                continue
            self._from = sender
            got.append(data)
        raise DriverFault(f"more than {MOST_AT_ONCE} packets wait at {self.here}{self._others()}", clears=True)

    def silence(self, seconds: float, last_words: str = "") -> DriverFault:
        """Return the fault that nothing good has come for `seconds`; `last_words`: what was wrong with what came."""
        wrong = f"; the last packet was refused: {last_words}" if last_words else ""
        return DriverFault(
            f"nothing came from the controller {self._host} at {self.here} for {seconds:g} s{self._others()}{wrong}",
            clears=True,
        )

    def _others(self) -> str:
        return f"; {self.strangers} packets came from others" if self.strangers else ""

    def send(self, data: bytes) -> None:
        """Send a datagram to where the newest one came from; one that the network doesn't take is lost."""
        if self._from is None:
            return
        try:
            self._socket.sendto(data, self._from)
        except (BlockingIOError, ConnectionError):
            return
        except OSError as error:
            raise DriverFault(f"{self._from[0]}:{self._from[1]} cannot be sent to: {error}", clears=True) from error

    def close(self) -> None:
        """Give the port back; harmless more than once."""
        self._socket.close()
