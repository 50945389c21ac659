"""Far side of a link: what it needs of a driver's process, and of who makes it; tests try links with others."""

from __future__ import annotations

from typing import Protocol

from virtualrobot_sdk.drivers import About, DriverFault, Words
from virtualrobot_sdk.drivers.shared import CellBlock, TickRing

from virtualrobot_kernel.drivers.twin import Asked, Twin


class Process(Protocol):
    """Driver in a process of its own. Each call ends by its deadline, and raises DriverFault with the words."""

    @property
    def pid(self) -> int:
        """Number of the process; 0 once it has ended."""
        ...

    @property
    def fault(self) -> DriverFault | None:
        """Fault that ended the process; None while it lives."""
        ...

    def connect(self) -> About:
        """Connect to the controller; readings come from then on."""
        ...

    def begin(self) -> None:
        """Play from now on what the ring says."""
        ...

    def end(self) -> None:
        """Play no more; the robot is at rest."""
        ...

    def reset(self) -> None:
        """Clear a fault at the controller."""
        ...

    def words(self) -> Words:
        """Return the newest words of the controller, or about it."""
        ...

    def where(self) -> Words:
        """Return where the driver is just now, of one that is silent; without text it is nowhere."""
        ...

    def close(self) -> None:
        """Have the driver let go, and end the process."""
        ...

    def kill(self) -> None:
        """End the process at once, whatever it does; any thread may, also while another one asks it."""
        ...


class Site(Protocol):
    """Maker of the far side, and its folder in shared memory."""

    @property
    def stopper(self) -> tuple[str, str]:
        """Address and key of the process that stops the cell for whoever has the key; empty where there is none."""
        ...

    def cell(self) -> CellBlock:
        """Return the one block of this kernel, made when it is asked for first."""
        ...

    def connection(self, twin: Twin, asked: Asked, tick_ns: int) -> tuple[Process, TickRing]:
        """Start the process of a driver, which connects to nothing yet, with a new ring.

        Raises KernelError for a component that there is not, and for settings that it has not.
        """
        ...

    def close(self) -> None:
        """End all and take the files away."""
        ...
