"""The cell: all robots together, stopped until somebody releases them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from virtualrobot._wire.arguments import Text, checked
from virtualrobot._wire.messages import value_or_default
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown, told
from virtualrobot.v1 import driver_pb2


@shown
@dataclass(frozen=True, slots=True)
class CellStop:
    """Stop of the cell, which stays until it is released.

    Attributes:
        by: who stopped it.
        reason: why, in words.
        time: when, by the kernel's clock.
    """

    by: str
    reason: str
    time: datetime

    @staticmethod
    def of(message: driver_pb2.CellStatus) -> CellStop | None:
        """Return what a message tells; None where the cell is not stopped."""
        if not message.stopped:
            return None
        return CellStop(message.stopped_by, message.reason, message.stop_time.ToDatetime(UTC))


@checked
class Cell:
    """The cell of one kernel: all its robots, simulated and real ones.

    Example:
        >>> client.cell.stop("a hand in the cell")
        >>> client.cell.stopped.reason
        'a hand in the cell'
        >>> client.cell.release()
    """

    def __init__(self, services: Services) -> None:
        """Handle the cell of one kernel."""
        self._services = services

    def stop(self, reason: Text = "") -> None:
        """Bring all robots to rest on their paths, and refuse all motions until the cell is released.

        It needs no lease; of several stops the first one is kept. It is no emergency stop. `client.stop` ends the
        motions that there are, and no more.
        """
        self._services.driver.StopCell(driver_pb2.StopCellRequest(reason=reason))

    @property
    def stopped(self) -> CellStop | None:
        """The stop of the cell; None while nobody has stopped it."""
        return CellStop.of(self._services.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell)

    def watch(self) -> Iterator[CellStop | None]:
        """Yield the stop of the cell, None while there is none: at once, and then whenever that changes."""
        request = driver_pb2.WatchDriversRequest(max_rate_hertz=value_or_default(None, "max_rate"))
        last: list[CellStop | None] = []
        with self._services.driver.WatchDrivers(request) as stream:
            for response in stream:
                if last != [stop := CellStop.of(response.cell)]:
                    last = [stop]
                    yield stop

    def release(self) -> None:
        """End a stop; nothing moves by that, and each real robot is set to `execute` again by its own call.

        Raises:
            WrongStateError: when a robot is not at rest yet.
        """
        self._services.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())

    def __repr__(self) -> str:
        """Return a line for people."""
        return told("Cell", lambda: f"stopped by {stop.by}: {stop.reason}" if (stop := self.stopped) else "not stopped")
