"""Running motions, as the tick sees every kind of them. Pure: each method returns the motion as it is afterwards."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple, Protocol, Self

from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.signals import SignalValue


class Phase(Enum):
    """Phases of a motion; the names equal those of `MotionPhase` in the contract."""

    RUNNING = "RUNNING"
    PAUSING = "PAUSING"
    PAUSED = "PAUSED"
    STOPPING = "STOPPING"
    WAITING = "WAITING"
    STARVED = "STARVED"
    SUCCEEDED = "SUCCEEDED"
    CANCELLED = "CANCELLED"
    ABORTED = "ABORTED"


ENDED = (Phase.SUCCEEDED, Phase.CANCELLED, Phase.ABORTED)
"""Final phases. Whether a motion that ends before its goal is CANCELLED or ABORTED is told by its cause."""


class TickContext(NamedTuple):
    """World values that a motion may read in its tick."""

    signals: Mapping[str, SignalValue]
    """Every signal's value before this tick."""
    tracked: tuple[float, float] | None = None
    """Position and velocity by the end of this tick of the joint that the motion goes along with; None where none is.
    """


NOTHING = TickContext({})
"""Context of motions that read nothing of the world."""


class RunningMotion(Protocol):
    """Motion that runs or has ended, of n joints."""

    @property
    def phase(self) -> Phase:
        """Phase of the motion."""
        ...

    @property
    def ended(self) -> bool:
        """True once it has succeeded or been cancelled."""
        ...

    @property
    def progress(self) -> float:
        """Share of it that is done, 0 to 1."""
        ...

    @property
    def duration(self) -> float:
        """Duration at full rate, in s; 0 where it is unknown."""
        ...

    @property
    def signals(self) -> Mapping[str, SignalValue]:
        """Signals that it sets with this tick."""
        ...

    @property
    def fault(self) -> tuple[str, str] | None:
        """Cause of an end by itself: the name of an `EndCause` and a text; None without one."""
        ...

    @property
    def steps_done(self) -> int:
        """Number of steps done, of a program; otherwise 1 once it has succeeded."""
        ...

    @property
    def step_path(self) -> str:
        """Step that it is at as the text of its program calls it; empty where it has no name."""
        ...

    @property
    def found(self) -> bool | None:
        """Result of a search: True if it has met its signal; None before its end, and without a search."""
        ...

    @property
    def orders(self) -> tuple[object, ...]:
        """Orders that the world shall do, or wait for, before the motion goes on (`obeyed`); none where it does."""
        ...

    def sample(self) -> tuple[Array, Array, Array]:
        """Return joint positions, velocities and accelerations (n,): rad or m, per s, per s²."""
        ...

    def advance(self, dt: float, override: float, context: TickContext = NOTHING) -> Self:
        """Return the motion `dt` seconds later, with the speed `override` in (0, 1] that holds from now on."""
        ...

    def pause(self) -> Self:
        """Return the motion slowing to standstill; raise KernelError (WRONG_STATE) when it stops or has ended."""
        ...

    def resume(self) -> Self:
        """Return the motion going on after a pause; raise KernelError (WRONG_STATE) when it stops or has ended."""
        ...

    def step(self) -> Self:
        """Return the motion going on to the end of its step, where it pauses; what has no steps goes on as by `resume`.

        Raises KernelError (WRONG_STATE) when it stops or has ended.
        """
        ...

    def cancel(self) -> Self:
        """Return the motion braking to its end; one that stops or has ended stays as it is."""
        ...

    def obeyed(self) -> Self:
        """Return the motion after its orders were done."""
        ...

    def abort(self) -> Self:
        """Return the motion ended where it is: what it moved is gone."""
        ...
