"""Specifications of motions: moves that go together, or the steps of a program, as data before they are planned."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.motion.signals import Condition, SignalValue
from virtualrobot_kernel.planning.moves import Move

MAX_STEPS = 10_000
"""Greatest number of steps of a program."""


@dataclass(frozen=True, slots=True)
class Zone:
    """Zone in which a corner may be rounded off: one of both is above 0.

    meters: the radius about the corner on the way of the tool centre point. percent: the last part of these moves and
    the first of the next ones, each of its own length, up to 50.
    """

    meters: float = 0.0
    percent: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MoveStep:
    """Moves that start and end together; with a zone they go over into the moves of the next step."""

    moves: tuple[Move, ...]
    zone: Zone | None = None

    @property
    def searches(self) -> bool:
        """True if one of its moves is a search."""
        return any(move.search for move in self.moves)


@dataclass(frozen=True, slots=True)
class SetSignalStep:
    """Step that sets a signal."""

    signal: str
    value: SignalValue


@dataclass(frozen=True, slots=True)
class WaitSignalStep:
    """Step that waits until a signal meets the condition; after `timeout` s (0: never) the program is cancelled."""

    condition: Condition
    timeout: float = 0.0


@dataclass(frozen=True, slots=True)
class DwellStep:
    """Step that stands still for some seconds."""

    seconds: float


Step = MoveStep | SetSignalStep | WaitSignalStep | DwellStep


@dataclass(frozen=True, slots=True)
class TrackingSpec:
    """Node to track, the window in which its joint may move, and its greatest speed (0: the joint's limit)."""

    node: str
    window: float
    max_velocity: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MotionSpec:
    """Motion that is asked for: moves that go together, or the steps of a program; and the frame it goes along with."""

    moves: tuple[Move, ...] = ()
    steps: tuple[Step, ...] = ()
    tracking: TrackingSpec | None = None

    @property
    def every_move(self) -> tuple[Move, ...]:
        """All moves, whenever they are made."""
        return self.moves + tuple(move for step in self.steps if isinstance(step, MoveStep) for move in step.moves)
