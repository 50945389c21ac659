"""State of the world at a tick: joints, poses, motions, tool states, signals, the clock; and the snapshot of it all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import Enum
from operator import attrgetter
from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.quick import changer, maker
from virtualrobot_kernel.motion.running_motion import Phase, RunningMotion
from virtualrobot_kernel.motion.signals import SignalValue
from virtualrobot_kernel.world.collisions import NOTHING_SET, Allowance, CollisionSettings
from virtualrobot_kernel.world.structure import Structure


class SignalDirection(Enum):
    """Direction of a signal seen from its owner; the names equal those of `SignalDirection` in the contract."""

    INPUT = "input"
    OUTPUT = "output"
    INTERNAL = "internal"


@dataclass(frozen=True, slots=True)
class Signal:
    """Signal; its type is that of its value and never changes. `owner` is a node (a uid; 0: nobody)."""

    name: str
    value: SignalValue
    description: str = ""
    unit: str = ""
    direction: SignalDirection = SignalDirection.INTERNAL
    owner: int = 0


@dataclass(frozen=True, slots=True)
class Selection:
    """Tool (a uid; 0: none) and tool centre point that a robot works with."""

    tool: int = 0
    tool_center_point: str = ""


class EndCause(Enum):
    """Causes of a motion's end before its goal; the names equal those of `EndCause` in the contract."""

    CALL = "call"
    STOP = "stop"
    PREEMPTED = "preempted"
    UNWATCHED = "unwatched"
    WORLD_CLEARED = "world cleared"
    LEASE_EXPIRED = "lease expired"
    LEASE_TAKEN = "lease taken"
    SIGNAL_TIMEOUT = "signal timeout"
    SETPOINT_TIMEOUT = "setpoint timeout"
    SETPOINT_REFUSED = "setpoint refused"
    WINDOW_LEFT = "window left"
    TRACKING_LOST = "tracking lost"
    FAILED = "failed"
    COLLISION = "collision"
    STEP_REFUSED = "step refused"
    PART_TIMEOUT = "part timeout"
    WORLD_RESTORED = "world restored"
    KERNEL_RESTARTED = "kernel restarted"
    DRIVER = "driver"
    CELL_STOPPED = "cell stopped"
    PATH_TOLERANCE = "path tolerance"
    GOAL_TOLERANCE = "goal tolerance"

    @property
    def aborts(self) -> bool:
        """True for causes by which the kernel had to end the motion, False for those that somebody wanted."""
        return self not in WANTED_ENDS


WANTED_ENDS = (
    *(EndCause.CALL, EndCause.STOP, EndCause.PREEMPTED, EndCause.WORLD_CLEARED, EndCause.LEASE_TAKEN),
    *(EndCause.WORLD_RESTORED, EndCause.CELL_STOPPED),
)
"""Causes that somebody wanted: motions that end by them are CANCELLED, others ABORTED."""


@dataclass(frozen=True, slots=True)
class Cancellation:
    """Reason of a motion's end before its goal: for programs, and in words."""

    cause: EndCause
    reason: str


class DeviationKind(Enum):
    """Values of a joint that may be off; the names equal those of `DeviationKind` in the contract."""

    POSITION = "position"
    VELOCITY = "velocity"


@dataclass(frozen=True, slots=True)
class Deviation:
    """Joint (robot uid, name) that is off by a value beyond its tolerance: rad or m, or per second."""

    joint: tuple[int, str]
    kind: DeviationKind
    value: float
    tolerance: float


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Result of a search: the tick at which it was over, and where the robot was then.

    joint_positions: by name, rad or m; world_t_tcp (4, 4): the chosen tool centre point.
    """

    found: bool
    tick: int
    joint_positions: Mapping[str, float]
    world_t_tcp: NDArray[np.float64]


Rated = EllipsisType | NDArray[np.intp]
"""Columns of a motion that have a velocity of their own: all, or all but the w of quaternions."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Motion that runs or has ended: its joints, and its state on its path.

    `q_index` says where each column of the path goes in q, and `v_index` where those that are `rated` go in v;
    `joints` names the columns as (robot uid, coordinate); `tool_states` (step, tool uid, state) become true when their
    step is done; `step_count` is 0 for moves that are no program; `signals` are all that it names, and `nodes`
    (uids) those that steps name which are planned when they are reached; `searcher` is the robot that searches (a
    uid; 0: none) and `search` what it came to; `tracked_joint` is the joint (robot uid, name) that the motion goes
    along with, and `tracked_at` where that is in q and v, None when it is gone; `end_tick` is 0 until it has ended.
    `path_tolerances` (k, 2) say how far positions and velocities of its joints may be from what it commands (0: any),
    and `deviations` which were farther when that, or its goal, ended it.
    """

    id: str
    robots: tuple[int, ...]
    joints: tuple[tuple[int, str], ...]
    q_index: NDArray[np.int32]
    v_index: NDArray[np.int32]
    running: RunningMotion
    start_tick: int
    tool_states: tuple[tuple[int, int, str], ...] = ()
    step_count: int = 0
    signals: frozenset[str] = frozenset()
    nodes: frozenset[int] = frozenset()
    searcher: int = 0
    search: Search | None = None
    tracked_joint: tuple[int, str] | None = None
    tracked_at: tuple[int, int] | None = None
    rated: Rated = ...
    cancellation: Cancellation | None = None
    end_tick: int = 0
    path_tolerances: NDArray[np.float64] | None = None
    deviations: tuple[Deviation, ...] = ()

    def going(self, running: RunningMotion) -> Motion:
        """Return the motion with another state on its path, as `replace` does in twenty times the time."""
        return _going(self, running)

    @property
    def step_path(self) -> str:
        """Step of the program that it is at, as its text calls it."""
        if not self.step_count:
            return ""
        return self.running.step_path or str(min(self.running.steps_done, max(0, self.step_count - 1)))

    @property
    def phase(self) -> Phase:
        """Phase of the motion; ABORTED where the kernel had to end it, RUNNING until the tick that ends it is made."""
        phase = self.running.phase
        if phase is Phase.SUCCEEDED and not self.end_tick:
            return Phase.RUNNING  # one without length: what it does, such as a tool's state, comes with its one tick
        if phase is Phase.CANCELLED and self.cancellation and self.cancellation.cause.aborts:
            return Phase.ABORTED
        return phase


_going = changer(Motion, "running")


@dataclass(frozen=True, slots=True, eq=False)
class JointValues:
    """All coordinates q (nq,) and velocities v (nv,) of one robot: radians, meters, per second."""

    q: NDArray[np.float64]
    v: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Dynamics:
    """Values that become true with the next tick: q (k,) at the places q_index among all coordinates, v (m,) likewise.

    Radians, meters, per second.
    """

    q_index: NDArray[np.int32]
    q: NDArray[np.float64]
    v_index: NDArray[np.int32]
    v: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MovedParts:
    """Parts (k,) (uids) that are elsewhere with the next tick: parent_t_part (k, 4, 4), and their twists (k, 6)."""

    parts: NDArray[np.int64]
    parent_t_part: NDArray[np.float64]
    twists: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class BodyContacts:
    """The c points at which nodes touch under physics as a tick ends.

    nodes (c, 2): their uids. positions (c, 3): in the world (m). normals (c, 3): in the world, from the first to the
    second. forces (c, 3): on the second, in the world (N).
    """

    nodes: NDArray[np.int64]
    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    forces: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PhysicsSettings:
    """Settings of what moves by forces.

    Attributes:
        engine: the component that computes it; empty: nothing moves by forces.
        engine_settings: plain values; the component says what they may be.
        gravity: in the world (m/s^2).
        substeps: number of the engine's steps in a tick.
    """

    engine: str = ""
    engine_settings: Mapping[str, Any] = field(default_factory=dict)
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    substeps: int = 4


NO_PHYSICS = PhysicsSettings()
"""Settings of a new world: nothing moves by forces."""


@dataclass(frozen=True, slots=True)
class SensorStart:
    """Start of a sensor: its number among all starts, and the tick from which its readings and its noise are counted.

    One that is started while it runs has a number anew, and the tick of before.
    """

    number: int
    tick: int


@dataclass(frozen=True, slots=True)
class CellStop:
    """Stop of the cell, which stays until it is released: nothing begins to move meanwhile.

    by: who stopped it, for people. reason: why, in words, never empty. wall_time: when, in seconds since 1970.
    """

    by: str
    reason: str
    wall_time: float


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """World at one tick. Arrays are never written to after they are published.

    q (nq,) coordinates and v (nv,) velocities of all joints as they are: radians, meters, per second.
    commanded: what motions command, of the robots (uids) whose joints are measured; those of all others are q and v.
    readings: what was measured since the tick before, by robot (uid): it becomes q and v with the next tick.
    parent_t_node (N, 4, 4): where each node is in its parent's frame, a row for each node.
    allowed_pairs: nodes (uids, the smaller first) that clients or imports let touch each other, and why.
    collisions: what is done about collisions.
    running_sensors: the start of each sensor (a uid) that runs; `sensor_starts` counts all starts.
    epoch: counts how often the world was replaced as a whole.
    tcp_speed_limits: greatest speed (m/s) of the tool centre point of each robot (a uid) that has one, as for teaching.
    dynamics: what crafts and physics have computed since the tick before: it becomes q and v with the next tick.
    physics: how forces move parts that are dynamic, None where nobody has said (see `physics_settings`).
    moved_parts: parts that forces have moved since the tick before: they are there with the next tick.
    twists: velocity (6,) of each part (a uid) that forces move and that is not at rest: of its origin in the axes of
        the world (m/s), and about its own axes (rad/s).
    motored: what motions command of the robots (uids) whose joints are moved by motors under physics; where they are
        say q and v.
    efforts: what clients have motors exert, by robot (a uid) and joint: N m or N.
    contacts: where what sensors feel touches under physics, and by which force; None: nowhere.
    told_contacts: contacts that the engine has told since the tick before: they become `contacts` with the next tick.
    stop: the stop of the cell, None while nobody has stopped it.
    """

    tick: int
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    parent_t_node: NDArray[np.float64]
    signals: Mapping[str, Signal] = field(default_factory=dict)
    commanded: Mapping[int, JointValues] = field(default_factory=dict)
    readings: Mapping[int, JointValues] = field(default_factory=dict)
    motions: tuple[Motion, ...] = ()
    ended: tuple[Motion, ...] = ()
    motion_count: int = 0
    tool_states: Mapping[int, str] = field(default_factory=dict)
    selections: Mapping[int, Selection] = field(default_factory=dict)
    speed_factors: Mapping[int, float] = field(default_factory=dict)
    speed_factor: float = 1.0
    allowed_pairs: Mapping[tuple[int, int], Allowance] = field(default_factory=dict)
    collisions: CollisionSettings = NOTHING_SET
    running_sensors: Mapping[int, SensorStart] = field(default_factory=dict)
    sensor_starts: int = 0
    epoch: int = 0
    tcp_speed_limits: Mapping[int, float] = field(default_factory=dict)
    dynamics: Dynamics | None = None
    physics: PhysicsSettings | None = None
    moved_parts: MovedParts | None = None
    twists: Mapping[int, NDArray[np.float64]] = field(default_factory=dict)
    motored: Mapping[int, JointValues] = field(default_factory=dict)
    efforts: Mapping[int, Mapping[str, float]] = field(default_factory=dict)
    contacts: BodyContacts | None = None
    told_contacts: BodyContacts | None = None
    stop: CellStop | None = None

    @property
    def physics_settings(self) -> PhysicsSettings:
        """Return how forces move parts that are dynamic."""
        return self.physics or NO_PHYSICS

    def but(self, **changes: Any) -> State:  # noqa: ANN401 fields of a state
        """Return this state with other values of some fields, as `dataclasses.replace` does in five times the time.

        A tick makes several states, one of another.
        """
        values = list(_VALUES(self))
        for name, value in changes.items():
            values[_PLACES[name]] = value
        return _state(*values)


_VALUES = attrgetter(*(one.name for one in fields(State)))
_PLACES = {one.name: place for place, one in enumerate(fields(State))}
_state = maker(State)


def empty_state() -> State:
    """Return the state of a world with nothing but its root, at tick 0."""
    return State(0, np.zeros(0), np.zeros(0), np.eye(4)[None])


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """Immutable picture of the world; replacing a reference to it publishes it.

    world_t_node (N, 4, 4): where each node is in the world's frame, a row for each node (`structure.rows`).
    `wall_time` is in seconds since 1970.
    """

    structure: Structure
    state: State
    world_t_node: NDArray[np.float64]
    revision: int
    wall_time: float
    tick_seconds: float

    @property
    def simulation_time(self) -> float:
        """Return the simulation time in seconds."""
        return self.state.tick * self.tick_seconds

    def world_t(self, uid: int) -> NDArray[np.float64]:
        """Return the pose world_t_node (4, 4) of a node in the world's frame."""
        return self.world_t_node[self.structure.rows[uid]]


def unchanged(before: Sequence[object], now: Sequence[object]) -> bool:
    """Return whether parts of two snapshots are the same objects: what nothing has changed is handed on, not copied."""
    return len(before) == len(now) and all(one is other for one, other in zip(before, now, strict=True))
