"""What a program is wished to do: its steps as data, before they are planned."""

from __future__ import annotations

from dataclasses import dataclass

from virtualrobot_kernel.motion.signals import Condition, SignalValue
from virtualrobot_kernel.planning.wishes import Linear, Move

MAX_STEPS = 10_000
"""The most steps of a program."""


@dataclass(frozen=True, slots=True)
class Zone:
    """From where on a path may be rounded off: one of both is above 0.

    meters: the radius about the corner on the way of the tool centre point. percent: the last part of these moves and
    the first of the next ones, each of its own length, up to 50.
    """

    meters: float = 0.0
    percent: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MoveStepWish:
    """Moves that start and end together; with a zone they go over into the moves of the next step."""

    moves: tuple[Move, ...]
    zone: Zone | None = None

    @property
    def searches(self) -> bool:
        """Whether one of its moves is a search."""
        return any(isinstance(move, Linear) and move.until is not None for move in self.moves)


@dataclass(frozen=True, slots=True)
class SetSignalWish:
    """Sets a signal."""

    signal: str
    value: SignalValue


@dataclass(frozen=True, slots=True)
class WaitSignalWish:
    """Stands still until a signal meets the condition; after `timeout` seconds (0: never) the program is cancelled."""

    condition: Condition
    timeout: float = 0.0


@dataclass(frozen=True, slots=True)
class DwellWish:
    """Stands still for some seconds."""

    seconds: float


StepWish = MoveStepWish | SetSignalWish | WaitSignalWish | DwellWish


@dataclass(frozen=True, slots=True)
class TrackingWish:
    """A node to go along with, how far its joint may move meanwhile, and its greatest speed (0: the joint's limit)."""

    node: str
    window: float
    max_velocity: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MotionWish:
    """What a motion shall do: either moves that go together, or the steps of a program; and what it goes along with."""

    moves: tuple[Move, ...] = ()
    steps: tuple[StepWish, ...] = ()
    tracking: TrackingWish | None = None

    @property
    def every_move(self) -> tuple[Move, ...]:
        """All moves, whenever they are made."""
        return self.moves + tuple(move for step in self.steps if isinstance(step, MoveStepWish) for move in step.moves)
