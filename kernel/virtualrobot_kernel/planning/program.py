"""Specifications of motions: moves that go together, or the steps of a program, as data before they are planned."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from virtualrobot_kernel.motion.signals import Condition, SignalValue
from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.world.awaited_part import AwaitedPart
from virtualrobot_kernel.world.commands import AttachNode, PickPart, PlacePart, SelectTool, SetAllowedPairs

GivenUp = Callable[[], bool]
"""True once nobody waits for a plan any more; asked before each step is planned."""

MAX_STEPS = 10_000
"""Greatest number of steps of a program."""


@dataclass(frozen=True, slots=True)
class Zone:
    """Zone in which a corner may be rounded off: one of meters and percent is above 0.

    meters: the radius about the corner on the way of the tool centre point. percent: the last part of these moves and
    the first of the next ones, each of its own length, up to 50. parabola: whether the way through it is that of a
    controller's radius, however soon that is; `extended` is the radius (m) for orientations and other joints then.
    """

    meters: float = 0.0
    percent: float = 0.0
    parabola: bool = False
    extended: float = 0.0


@dataclass(frozen=True, slots=True)
class TextStep:
    """Step of a program's text: what it is called there, where it is within other steps or after such.

    pauses: whether the program stands paused before it.
    """

    path: str = field(default="", kw_only=True)
    pauses: bool = field(default=False, kw_only=True)


@dataclass(frozen=True, slots=True, eq=False)
class MoveStep(TextStep):
    """Moves that start and end together, in `min_duration` s at least; with a zone they join those of the next step."""

    moves: tuple[Move, ...]
    zone: Zone | None = None
    min_duration: float = 0.0

    @property
    def searches(self) -> bool:
        """True if one of its moves is a search."""
        return any(move.search for move in self.moves)


@dataclass(frozen=True, slots=True)
class SetSignalStep(TextStep):
    """Step that sets a signal, `lead` s before it is reached."""

    signal: str
    value: SignalValue
    lead: float = 0.0


@dataclass(frozen=True, slots=True)
class WaitSignalStep(TextStep):
    """Step that waits until a signal meets the condition; after `timeout` s (0: never) the program is cancelled."""

    condition: Condition
    timeout: float = 0.0


@dataclass(frozen=True, slots=True)
class DwellStep(TextStep):
    """Step that stands still for some seconds."""

    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class OrderStep(TextStep):
    """Step that changes the world by a command, while the robots stand."""

    order: PickPart | PlacePart | AttachNode | SelectTool | SetAllowedPairs


@dataclass(frozen=True, slots=True)
class SpeedStep(TextStep):
    """Step that slows the moves of a robot (empty: all) that come after it."""

    robot: str
    factor: float


@dataclass(frozen=True, slots=True)
class WaitPartStep(TextStep):
    """Step that waits until a part is at a place; after `timeout` s (0: never) the program is aborted."""

    awaited: AwaitedPart
    timeout: float = 0.0


@dataclass(frozen=True, slots=True)
class DecisionStep(TextStep):
    """Step at which a condition decides what comes next; it does nothing itself."""

    condition: Condition


Step = MoveStep | SetSignalStep | WaitSignalStep | DwellStep | OrderStep | SpeedStep | WaitPartStep | DecisionStep
"""Step of a program."""

PASSED = (SetSignalStep, SpeedStep)
"""Steps that may stand between moves with a zone."""


Speeds = tuple[tuple[str, float], ...]
"""Factors by which the moves of robots are slowed; the one of no robot counts for all that are not named."""


def slowed(steps: Sequence[Step], speeds: Speeds = ()) -> tuple[tuple[Step, ...], Speeds]:
    """Return steps whose moves have the factors that steps before them set, and the factors after the last one.

    speeds: the factors before the first one. A trajectory has times of its own and keeps them.
    """
    factors, found = dict(speeds), list[Step]()
    for step in steps:
        if isinstance(step, SpeedStep):
            factors = {**factors, step.robot: step.factor} if step.robot else {"": step.factor}
        elif factors and isinstance(step, MoveStep):
            step = replace(step, moves=tuple(_slower(move, factors) for move in step.moves))
        found.append(step)
    return tuple(found), tuple(factors.items())


def _slower(move: Move, factors: Mapping[str, float]) -> Move:
    factor = factors.get(move.robot, factors.get("", 1.0))
    given = getattr(move, "speed_factor", None)
    return move if given is None else replace(move, **{"speed_factor": given * factor})


def step_name(step: Step, number: int) -> str:
    """Return what a step is called in words for people."""
    return step.path or str(number)


@dataclass(frozen=True, slots=True)
class TrackingSpec:
    """Node to track, the window in which its joint may move, and its greatest speed (0: the joint's limit)."""

    node: str
    window: float
    max_velocity: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MotionSpec:
    """Motion that is asked for: moves that go together, or the steps of a program; and the frame it goes along with.

    outer_count: the number of steps that its text has outside of others; 0: as many as steps. deferred: the steps of
    a text of which it is known only when they are reached whether they are done; none where all are.
    """

    moves: tuple[Move, ...] = ()
    steps: tuple[Step, ...] = ()
    tracking: TrackingSpec | None = None
    outer_count: int = 0
    deferred: tuple[Step, ...] = ()

    @property
    def every_move(self) -> tuple[Move, ...]:
        """All moves, whenever they are made."""
        return self.moves + tuple(move for step in self.steps if isinstance(step, MoveStep) for move in step.moves)
