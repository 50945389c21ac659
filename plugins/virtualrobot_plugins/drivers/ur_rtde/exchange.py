"""Real-Time Data Exchange (RTDE), protocol 2: the client's side, of which this driver needs little.

A packet is its length (two bytes, with the three of its head), its kind, and a body; numbers are in the network's byte
order (Universal Robots, "Real-Time Data Exchange (RTDE) Guide").
"""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Sequence

from virtualrobot_sdk.drivers import DriverFault

PORT = 30004
_HEAD = struct.Struct(">HB")
_VERSION, _CONTROLLER, _TEXT, _DATA, _OUTPUTS, _INPUTS, _START = (ord(one) for one in "VvMUOIS")
_LETTERS = {
    "VECTOR6D": "6d",
    "DOUBLE": "d",
    "INT32": "i",
    "UINT32": "I",
    "UINT64": "Q",
    "UINT8": "B",
}
_BACKLOG = 1 << 20
"""Bytes that may have come since they were last looked at."""


class Exchange:
    """A connection to a controller's port 30004: it tells the variables of one recipe, and takes those of another."""

    def __init__(self, host: str, seconds: float) -> None:
        """Connect; raises DriverFault where nobody answers within `seconds`."""
        self.here = f"{host}:{PORT}"
        try:
            self._socket = socket.create_connection((host, PORT), seconds)
        except OSError as error:
            raise DriverFault(
                f"no controller of Universal Robots answers at {self.here}: {error}", clears=True
            ) from error
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setblocking(False)
        self._got = bytearray()
        self._told = self._taken = struct.Struct("")
        self._recipes = (0, 0)
        self._deadline = time.monotonic() + seconds
        self._newest = b""
        self.arrived = 0.0
        """Time of the newest values, by `time.monotonic`."""
        self.text = ""
        """The newest words of the controller about this connection."""

    def agree(self, rate: float, told: dict[str, str], taken: dict[str, str]) -> tuple[int, int, int, int]:
        """Agree on protocol 2 and the variables, which are told `rate` times a second; return the controller's version.

        `told` and `taken` have the type of each variable by its name. Raises DriverFault with what is wrong.
        """
        if self._ask(_VERSION, b"\0\2") != b"\1":
            raise DriverFault(f"{self.here} doesn't speak version 2 of RTDE; controllers since 3.5 and 5.0 do")
        answer = self._ask(_CONTROLLER)
        if len(answer) != 16:
            raise DriverFault(f"{self.here} tells its version in {len(answer)} bytes; it must be 16")
        out = self._recipe(_OUTPUTS, told, struct.pack(">d", rate))
        into = self._recipe(_INPUTS, taken)
        self._recipes = (out, into)
        self._told, self._taken = (
            struct.Struct(">B" + "".join(_LETTERS[kind] for kind in kinds.values())) for kinds in (told, taken)
        )
        return struct.unpack(">4I", answer)

    def start(self) -> None:
        """Have the controller tell its variables from now on."""
        if self._ask(_START) != b"\1":
            raise DriverFault(f"{self.here} doesn't start to tell its variables")
        self.arrived = time.monotonic()

    def _recipe(self, kind: int, variables: dict[str, str], head: bytes = b"") -> int:
        answer = self._ask(kind, head + ",".join(variables).encode())
        kinds = answer[1:].decode(errors="replace").split(",")
        for name, found, wanted in zip(variables, kinds, variables.values(), strict=False):
            if found == "IN_USE":
                raise DriverFault(
                    f"another program sets {name} of the controller at {self.here}: end it, or its fieldbus",
                    clears=True,
                )
            if found != wanted:
                raise DriverFault(f"the controller at {self.here} has {name} as {found}; it must be {wanted}")
        if len(kinds) != len(variables) or not answer[0]:
            raise DriverFault(f"the controller at {self.here} refuses {', '.join(variables)}: {kinds}")
        return answer[0]

    def _ask(self, kind: int, body: bytes = b"") -> bytes:
        """Send a request, and return the body of its answer."""
        self._send(_HEAD.pack(_HEAD.size + len(body), kind) + body)
        while True:
            for found, said in self._packets():
                if found == kind:
                    return said
            left = self._deadline - time.monotonic()
            if left <= 0.0:
                raise DriverFault(
                    f"the controller at {self.here} has accepted the connection and is silent", clears=True
                )
            select.select([self._socket], [], [], left)
            self._receive()

    def poll(self, seconds: float = 0.0) -> tuple | None:
        """Return the newest values of all variables in their order, or None where none have come.

        It waits for at most `seconds` where none has come yet. Raises DriverFault where the connection is lost.
        """
        if seconds > 0.0:
            select.select([self._socket], [], [], seconds)
        self._receive()
        newest = None
        for kind, body in self._packets():
            if kind == _DATA:
                newest = body
        if newest is None:
            return None
        if len(newest) != self._told.size or newest[0] != self._recipes[0]:
            raise DriverFault(
                f"the controller at {self.here} tells {len(newest)} bytes; the variables that were agreed on have "
                f"{self._told.size}"
            )
        self.arrived = time.monotonic()
        return self._told.unpack(newest)[1:]

    def send(self, numbers: Sequence[float]) -> None:
        """Set all variables, in their order."""
        body = self._taken.pack(self._recipes[1], *numbers)
        self._send(_HEAD.pack(_HEAD.size + len(body), _DATA) + body)

    def _send(self, data: bytes) -> None:
        """Send it whole or not at all: half a packet would make all that follow unreadable."""
        try:
            sent = self._socket.send(data)
        except BlockingIOError:
            sent = 0
        except OSError as error:
            raise DriverFault(
                f"the connection to the controller at {self.here} is lost: {error}", clears=True
            ) from error
        if sent != len(data):
            raise DriverFault(f"the controller at {self.here} takes nothing more: its connection is full", clears=True)

    def _receive(self) -> None:
        try:
            while len(self._got) < _BACKLOG:
                data = self._socket.recv(65536)
                if not data:
                    raise DriverFault(f"the controller at {self.here} has closed the connection", clears=True)
                self._got += data
        except BlockingIOError:
            pass
        except OSError as error:
            raise DriverFault(
                f"the connection to the controller at {self.here} is lost: {error}", clears=True
            ) from error

    def _lost(self, error: OSError) -> DriverFault:
        return DriverFault(f"the connection to the controller at {self.here} is lost: {error}", clears=True)

    def _packets(self) -> list[tuple[int, bytes]]:
        """Take what has come whole; its words are kept."""
        found = []
        while len(self._got) >= _HEAD.size:
            size, kind = _HEAD.unpack_from(self._got)
            if size < _HEAD.size:
                raise DriverFault(f"{self.here} sends packets of {size} bytes; this is not RTDE")
            if len(self._got) < size:
                break
            body = bytes(self._got[_HEAD.size : size])
            del self._got[:size]
            if kind == _TEXT and body:
                self.text = body[1 : 1 + body[0]].decode(errors="replace")
            else:
                found.append((kind, body))
        return found

    def close(self) -> None:
        """Give the connection back."""
        self._socket.close()
