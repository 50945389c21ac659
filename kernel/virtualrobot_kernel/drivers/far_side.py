"""Far side of a link: what it needs of a driver's process, of a robot's ring and of the cell's block.

`virtualrobot_sdk.drivers` has all three; with others a link is tried without any process.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Safety

from virtualrobot_kernel.drivers.twin import Asked, Twin

Floats = NDArray[np.float64]


class Report(Protocol):
    """Newest report of a driver's host; k joints in the controller's order and the kernel's units.

    Attributes:
        active: whether the robot is played.
        braking: whether it goes, or has gone, the brake of the newest tick that it held.
        tick: the tick that is played.
        rate: that of the play clock.
        positions, velocities: (k,), as measured.
        mode, safety: as the controller says.
        speed_scaling: share of the speed that it was told at which the controller goes.
        inputs: digital inputs, the first in the lowest bit.
        cycles, skipped: how many there were, and were left out.
        lateness: of the latest one, s.
        faulty: whether the host has met a fault, whose words come by the process.
    """

    active: bool
    braking: bool
    tick: int
    rate: float
    positions: Floats
    velocities: Floats
    mode: Mode
    safety: Safety
    speed_scaling: float
    inputs: int
    cycles: int
    skipped: int
    lateness: float
    faulty: bool


class Process(Protocol):
    """Driver in a process of its own. Each call ends by its deadline, and raises DriverFault with the words."""

    @property
    def pid(self) -> int:
        """Number of the process; 0 once it has ended."""
        ...

    @property
    def fault(self) -> DriverFault | None:
        """Fault that the host, or the process itself, met last."""
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

    def close(self) -> None:
        """End the process."""
        ...


class Ring(Protocol):
    """Ring of a robot's ticks, and what comes back of them."""

    def put(self, tick: int, play_ns: int, q: Floats, v: Floats, outputs: int, brake: Floats | None) -> None:
        """Keep a tick, and its brake from there where it is known."""
        ...

    def reported(self) -> Report | None:
        """Return the newest report; None before the first."""
        ...

    def close(self) -> None:
        """Give the memory back."""
        ...


class Cell(Protocol):
    """Block of memory that all hosts of a kernel look at."""

    @property
    def stopped(self) -> bool:
        """Whether anybody has stopped the cell."""
        ...

    ramp_ns: int

    def beat(self, ns: int) -> None:
        """Say that the kernel lives."""
        ...

    def complete(self, tick: int, braked: bool) -> None:
        """Say that all rings hold a tick, and whether with its brakes."""
        ...

    def stop(self) -> None:
        """Stop all robots from now on."""
        ...

    def release(self) -> None:
        """End the stop."""
        ...

    def close(self) -> None:
        """Give the memory back."""
        ...


class Site(Protocol):
    """Maker of the far side, and its folder in shared memory."""

    stopper_address: str
    stopper_key: str

    def cell(self) -> Cell:
        """Return the one block of this kernel, made when it is asked for first."""
        ...

    def connection(self, twin: Twin, asked: Asked, tick_ns: int, words: Callable[[str], None]) -> tuple[Process, Ring]:
        """Start the process of a driver, which connects to nothing yet, with a new ring; `words` are its messages.

        Raises KernelError for a component that there is not, and for settings that it has not.
        """
        ...

    def close(self) -> None:
        """End all and take the files away."""
        ...
