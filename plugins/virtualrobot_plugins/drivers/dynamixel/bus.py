"""A bus of Dynamixel servos by protocol 2.0: reads and writes of all servos at once, whose faults are told in words."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from dynamixel_sdk import COMM_RX_CORRUPT, COMM_SUCCESS, PortHandler, Protocol2PacketHandler
from virtualrobot_sdk.drivers import DriverFault

from virtualrobot_plugins.drivers.serial_port import ports

ALERT = 0x80
"""Bit of a status packet's error: the servo has a hardware error."""
TRIES = 3
"""Number of times that an answer may come damaged."""
POLL_SECONDS = 0.002
"""Longest time (s) for which the port waits for bytes before the library looks at the clock."""


class _Port(PortHandler):
    """The library's port, but waiting for bytes, where that asks without end, and by a clock that nobody sets."""

    ser: Any

    def __init__(self, path: str, baud: int, silence_seconds: float) -> None:
        super().__init__(path)
        self.silence_ms = 1e3 * silence_seconds
        if not self.setBaudRate(baud):
            raise DriverFault(f"the library of the servos has no {baud} baud; 57600, 115200, 1000000 are usual")
        self.ser.timeout = POLL_SECONDS
        self.ser.write_timeout = silence_seconds

    def clearPort(self) -> None:
        # `reset_input_buffer` of a port that is gone raises what is no OSError.
        self.ser.read(self.ser.in_waiting)

    def setPacketTimeout(self, packet_length: int) -> None:
        self.setPacketTimeoutMillis(self.tx_time_per_byte * packet_length + self.silence_ms)

    def getCurrentTime(self) -> float:
        return 1e3 * time.monotonic()


class Bus:
    """Servos on one port; each of its faults is a DriverFault that names port and servo."""

    def __init__(self, path: str, baud: int, ids: Sequence[int], silence_seconds: float) -> None:
        """Open the port. Raises DriverFault, with the ports that there are."""
        self.path, self.baud, self.ids = path, baud, tuple(ids)
        self._packets = Protocol2PacketHandler()
        self.alerts: tuple[int, ...] = ()
        """The servos that told of a hardware error in the last `read`."""
        try:
            self._port = _Port(path, baud, silence_seconds)
        except (OSError, ValueError) as error:
            there = ", ".join(ports()) or "no serial port"
            raise DriverFault(f"{path} can't be opened: {error}; this machine has {there}") from error

    def ping(self, servo: int) -> int | None:
        """Return the model number of a servo; None when it doesn't answer."""
        number, result, _ = self._told(lambda: self._packets.ping(self._port, servo))
        return number if result == COMM_SUCCESS else None

    def read(self, address: int, length: int) -> list[bytes]:
        """Return `length` bytes from `address` on of each servo. Raises DriverFault where one is silent."""
        for _ in range(TRIES):
            data, result, servo = self._told(lambda: self._read(address, length))
            if result != COMM_RX_CORRUPT:
                break
        if result != COMM_SUCCESS:
            why = self._packets.getTxRxResult(result).partition("] ")[2].rstrip("!")
            raise DriverFault(f"servo {servo} on {self.path} doesn't answer: {why}", f"{result}")
        return data

    def write(self, address: int, length: int, values: Sequence[int]) -> None:
        """Write a number of `length` bytes to `address` of each servo; they don't answer."""
        data = bytearray()
        for servo, value in zip(self.ids, values, strict=True):
            data += bytes((servo,)) + value.to_bytes(length, "little", signed=value < 0)
        self._told(lambda: self._packets.syncWriteTxOnly(self._port, address, length, list(data), len(data)))

    def reboot(self, servo: int) -> None:
        """Begin a servo anew, which clears its error and leaves it without torque."""
        self._told(lambda: self._packets.reboot(self._port, servo))

    def close(self) -> None:
        """Give the port back; harmless more than once."""
        self._port.closePort()

    def _read(self, address: int, length: int) -> tuple[list[bytes], int, int]:
        result = self._packets.syncReadTx(self._port, address, length, list(self.ids), len(self.ids), False)
        found, alerts = [], []
        for servo in self.ids:
            if result == COMM_SUCCESS:
                data, result, error = self._packets.readRx(self._port, servo, length)
                found.append(bytes(data))
                alerts += [servo] if error & ALERT else []
            if result != COMM_SUCCESS:
                return [], result, servo
        self.alerts = tuple(alerts)
        return found, result, 0

    def _told(self, call: Callable[[], Any]) -> Any:  # noqa: ANN401
        try:
            return call()
        except (OSError, ValueError, TypeError, AttributeError) as error:
            # A closed port raises anything in pyserial.
            raise DriverFault(f"{self.path} is gone: {error}") from error
        finally:
            self._port.is_using = False
