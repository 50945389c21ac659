"""Datagrams (UDP) of one controller: bound to one address, taken from one peer, with a time after which it is silent.

Controllers with Externally Guided Motion (ABB) or the Robot Sensor Interface (KUKA) begin to speak by themselves and
send at their own rate. What others send to the same port is counted and thrown away.
"""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable

from virtualrobot_sdk.drivers import Driver, DriverFault

GREATEST = 65535
"""Longest datagram (bytes) that there is."""
MOST_AT_ONCE = 1024
"""Number of datagrams that are looked at before they are called a flood: more than a system keeps waiting."""


class Datagrams:
    """A bound socket. It takes what comes from one host, and from one port there once `lock` was called.

    Attributes:
        here: address and port that it listens at, for people.
        strangers: packets of others, which were thrown away.
        dropped: packets of the controller that were refused: broken, doubled, late.
    """

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
        self.here = f"{address}:{port}"
        self.strangers = self.dropped = 0
        try:
            self._socket.bind((address, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise DriverFault(f"{self.here} cannot be listened at: {error}") from error
        self._socket.setblocking(False)

    def lock(self) -> None:
        """Take datagrams of the sender of the newest one alone, from now on."""
        self._peer = self._from

    def newest(self, seconds: float, take: Callable[[bytes], str]) -> None:
        """Hand all that has come to `take`, the oldest first; wait until something new has.

        `take` returns why it refuses a packet; one that is new it takes, and returns nothing. Raises DriverFault where
        none is taken within `seconds`, with the last refusal, and where there is no end to what comes.
        """
        deadline, taken, refusal = time.monotonic() + seconds, False, ""
        while not taken:
            waiting = self._receive(deadline - time.monotonic())
            if not waiting:
                told = f"; the last packet was refused: {refusal}" if refusal else ""
                raise DriverFault(
                    f"nothing came from the controller {self._host} at {self.here} for {seconds:g} s"
                    f"{self._others()}{told}"
                )
            for data in waiting:
                said = take(data)
                refusal, taken = said or refusal, taken or not said
                self.dropped += bool(said)

    def _receive(self, seconds: float) -> list[bytes]:
        """Return what has come, and wait at most `seconds` for the first of it; nothing once they are negative."""
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
        raise DriverFault(f"more than {MOST_AT_ONCE} packets wait at {self.here}{self._others()}")

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
            raise DriverFault(f"{self._from[0]}:{self._from[1]} cannot be sent to: {error}") from error

    def close(self) -> None:
        """Give the port back; harmless more than once."""
        self._socket.close()


class DatagramDriver(Driver):
    """Driver of a controller that speaks first: it listens from `connect` on, and answers from `begin` on."""

    def __init__(self) -> None:
        """Listen to nobody yet."""
        self._socket: Datagrams | None = None
        self._begun = False

    @property
    def dropped(self) -> int:
        """Packets that came twice, too late or broken since `connect`."""
        return self._socket.dropped if self._socket is not None else 0

    def stop(self) -> None:
        """Hold the last position that was sent: the controller has no stop for those who speak to it."""
        self._begun = False

    def end(self) -> None:
        """Hold the robot where it stands, as before `begin`."""
        self._begun = False

    def close(self) -> None:
        """Give the port back; a robot that follows is stopped by its controller, which gets no answers."""
        self._begun = False
        if self._socket is not None:
            self._socket.close()
            self._socket = None
