"""A serial port whose faults are told in words: the part that drivers of serial robots share. It needs pyserial."""

from __future__ import annotations

import time
from importlib.util import find_spec

from virtualrobot_sdk.drivers import DriverFault

POLL_SECONDS = 0.02
"""Longest time (s) for which a read waits before it looks at its deadline again."""
WRITE_SECONDS = 0.5
"""Time (s) after which a port that takes no more bytes is a fault."""
LONGEST = 4096
"""Bytes without a mark after which nothing that can be understood will come."""


def ports() -> list[str]:
    """Return the names of this machine's serial ports, such as `/dev/ttyUSB0` or `COM3`, in order.

    Raises DriverFault without pyserial.
    """
    _need_pyserial()
    from serial.tools.list_ports import comports

    return sorted(port.device for port in comports())


class SerialPort:
    """An open serial port, 8 bits without parity; each of its faults is a DriverFault that names it."""

    def __init__(self, path: str, baud: int) -> None:
        """Open a port, or `socket://HOST:PORT` of a serial device server, at `baud` bits a second, for nobody else.

        Raises DriverFault, with the ports that there are.
        """
        _need_pyserial()
        from serial import serial_for_url

        self.path, self.baud = path, baud
        self._held = b""
        try:
            self._port = serial_for_url(path, baud, timeout=POLL_SECONDS, write_timeout=WRITE_SECONDS, exclusive=True)
        except (OSError, ValueError) as error:
            there = ", ".join(ports()) or "no serial port"
            raise DriverFault(f"{path} can't be opened: {_cause(error, path)}; this machine has {there}") from error

    def write(self, data: bytes) -> None:
        """Send `data`. Raises DriverFault when the port is gone, or nobody takes it."""
        try:
            self._port.write(data)
        except (OSError, ValueError) as error:
            raise DriverFault(f"{self.path} is gone, or takes nothing: {error}") from error

    def until(self, mark: bytes, seconds: float) -> bytes | None:
        """Return the bytes that came up to `mark`, without it; None when it doesn't come within `seconds`.

        Bytes without a mark are kept for the next call. Raises DriverFault when the port is gone, and for a flood
        without any mark.
        """
        deadline = time.monotonic() + seconds
        while mark not in self._held:
            try:
                waiting = self._port.in_waiting
                if not waiting and time.monotonic() >= deadline:
                    return None
                self._held += self._port.read(max(1, waiting))
            except (OSError, ValueError) as error:
                raise DriverFault(f"{self.path} is gone: {error}") from error
            if len(self._held) > LONGEST and mark not in self._held:
                raise DriverFault(
                    f"{self.path} sends {len(self._held)} bytes without {mark!r}: is {self.baud} its baud rate?"
                )
        found, _, self._held = self._held.partition(mark)
        return found

    def whole(self, mark: bytes) -> list[bytes]:
        """Return the parts that have come up to their marks, without these, and wait for none."""
        try:
            # A socket says of one byte at a time that it waits.
            while (waiting := self._port.in_waiting) and len(self._held) <= LONGEST:
                self._held += self._port.read(waiting)
        except (OSError, ValueError) as error:
            raise DriverFault(f"{self.path} is gone: {error}") from error
        *parts, self._held = self._held.split(mark)
        return parts

    def close(self) -> None:
        """Give the port back; harmless more than once."""
        # pyserial 3.5 leaves a socket open whose other end has gone first.
        near = getattr(self._port, "_socket", None)
        self._port.close()
        if near is not None:
            near.close()


def _need_pyserial() -> None:
    if find_spec("serial") is None:
        raise DriverFault("serial ports need pyserial: pip install 'virtualrobot[serial]'")


def _cause(error: Exception, path: str) -> str:
    """Return why a port can't be opened: pyserial names the port twice, and the number of the error twice."""
    said = str(error)
    if "exclusively lock" in said:
        return "another program has it"
    return said.rpartition("[Errno ")[2].partition("] ")[2].removesuffix(f": {path!r}") or said
