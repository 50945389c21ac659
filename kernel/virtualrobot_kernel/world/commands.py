"""Commands: all changes of the world, as data; `apply` gives them their meaning.

Names are those of nodes, signals and motions; lengths in meters, angles in radians, poses 4x4 `parent_t_child`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.conveyor_tracking import ConveyorTracking
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.motion.segments import TrajectoryPoints
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.motion.signals import SignalValue
from virtualrobot_kernel.motion.tool_lead import ToolLead
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.craft_data import Craft
from virtualrobot_kernel.world.figures import Figure, Pose
from virtualrobot_kernel.world.history_commands import PlayedTicks, RestartWorld, RestoreRecords, RestoreWorld
from virtualrobot_kernel.world.physics_commands import SetContacts, SetDynamics, SetJointEfforts, SetParts, SetPhysics
from virtualrobot_kernel.world.preconditions import Preconditions
from virtualrobot_kernel.world.state import Cancellation, CellStop, EndCause, Signal
from virtualrobot_kernel.world.structure import JointGroup, NodeData, NodeSpec


@dataclass(frozen=True, slots=True, eq=False)
class CreateNodes:
    """Command to add nodes, parents before children."""

    specs: tuple[NodeSpec, ...]


@dataclass(frozen=True, slots=True, eq=False)
class UpdateNode:
    """Command to change the fields of a node that are not None; `running` is for sensors."""

    name: str
    new_name: str | None = None
    parent_t_node: Pose | None = None
    hidden: bool | None = None
    figures: tuple[Figure, ...] | None = None
    data: NodeData = None
    running: bool | None = None
    description: str | None = None
    tags: tuple[str, ...] | None = None
    icon: str | None = None
    locked: bool | None = None


@dataclass(frozen=True, slots=True)
class RemoveNode:
    """Command to take a node and all below it out of the world."""

    name: str


@dataclass(frozen=True, slots=True)
class ClearWorld:
    """Command to take everything out of the world but its root; motions end where they are."""


@dataclass(frozen=True, slots=True, eq=False)
class AttachNode:
    """Command to give a node another parent; without a pose it stays where it is in the world."""

    name: str
    parent: str
    parent_t_node: Pose | None = None


@dataclass(frozen=True, slots=True)
class PickPart:
    """Command to fix a part (empty: the nearest) to the robot's chosen tool; a distance of 0 means the default."""

    robot: str
    part: str = ""
    max_distance: float = 0.0


@dataclass(frozen=True, slots=True)
class PlacePart:
    """Command to release a part (empty: all) from the robot's chosen tool, to a new parent."""

    robot: str
    part: str = ""
    parent: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class SetJointPositions:
    """Command to set joint positions at once: by name, or all coordinates of the robot in their order."""

    robot: str
    joint_positions: Mapping[str, float] = field(default_factory=dict)
    coordinates: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True)
class SetKinematics:
    """Command to choose the kinematics component of a robot, or of its group of this name; motions go on as planned."""

    robot: str
    kinematics: str
    settings: Mapping[str, Any]
    group: str = ""


@dataclass(frozen=True, slots=True)
class SetCraft:
    """Command to make a robot a craft, another one, or (None) no craft any more."""

    robot: str
    craft: Craft | None


@dataclass(frozen=True, slots=True)
class RunSensors:
    """Command to start or stop sensors (empty: all); one that runs goes on, and one with a fault is started anew."""

    sensors: tuple[str, ...]
    running: bool


@dataclass(frozen=True, slots=True)
class SetRangeComponents:
    """Command to choose a range sensor's ray caster and sensor model (name, settings); None keeps the present one."""

    sensor: str
    ray_caster: tuple[str, Mapping[str, Any]] | None = None
    sensor_model: tuple[str, Mapping[str, Any]] | None = None


@dataclass(frozen=True, slots=True)
class SetAllowedPairs:
    """Command to forbid pairs of nodes (name, name) to touch, and then to allow others (name, name, reason).

    `built` are those that an import has found.
    """

    allow: tuple[tuple[str, str, str], ...] = ()
    forbid: tuple[tuple[str, str], ...] = ()
    built: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class SetCollisionSettings:
    """Command to change the settings of collision handling; None leaves what there is.

    modes: of robots (robot, mode), None takes a robot's own mode away. paddings: of nodes (node, meters), 0 for none.
    """

    mode: CollisionMode | None = None
    modes: tuple[tuple[str, CollisionMode | None], ...] = ()
    look_ahead_seconds: float | None = None
    paddings: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class SetGroups:
    """Command to replace a robot's groups of joints; motions go on as they were planned."""

    robot: str
    groups: tuple[JointGroup, ...]


@dataclass(frozen=True, slots=True)
class SetPostures:
    """Command to take postures of a robot away by name, and then to add others or put them in their places."""

    robot: str
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    removed: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SelectTool:
    """Command to choose a robot's tool (empty: none) and tool centre point (empty: the tool's first)."""

    robot: str
    tool: str = ""
    tool_center_point: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class MountTool:
    """Command to mount a tool, or what brings one, on a robot (parent empty: its flange) and to work with it.

    Without a pose both frames coincide; no tool centre point means the tool's first.
    """

    robot: str
    node: str
    parent: str = ""
    parent_t_node: Pose | None = None
    tool_center_point: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class UnmountTool:
    """Command to take a tool (empty: the chosen one, or its gripper) off a robot; without a pose it stays in place."""

    robot: str
    node: str = ""
    parent: str = ""
    parent_t_node: Pose | None = None


@dataclass(frozen=True, slots=True)
class SetToolState:
    """Command to put a tool into a state at once."""

    tool: str
    state: str


@dataclass(frozen=True, slots=True)
class CreateSignal:
    """Command to add a signal; `owner` is the node that it belongs to (empty: nobody), whatever `signal.owner` says."""

    signal: Signal
    owner: str = ""


@dataclass(frozen=True, slots=True)
class RemoveSignal:
    """Command to take a signal out of the world."""

    name: str


@dataclass(frozen=True, slots=True)
class SetSignal:
    """Command to set a signal to a value of its type."""

    name: str
    value: SignalValue


@dataclass(frozen=True, slots=True)
class SetSpeedFactor:
    """Command to set the speed factor of the motions of one robot, or of all (empty)."""

    robot: str
    factor: float


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """Joint of a robot that a motion goes along with, and the law by which arms do."""

    robot: str
    joint: str
    law: ConveyorTracking


@dataclass(frozen=True, slots=True)
class SetTcpSpeedLimit:
    """Command to limit the speed of a robot's tool centre point (m/s); 0 lifts the limit. Refused while it moves."""

    robot: str
    limit: float


@dataclass(frozen=True, slots=True, eq=False)
class FromHere:
    """Points of a trajectory that begins wherever its joints are as it starts, and as fast as they are.

    begin: when the trajectory begins, in ticks since the world began, perhaps between two; None: when it starts.
    tick_seconds: the length of a tick (s). replaces: whether motions in the way end there.
    """

    points: TrajectoryPoints
    limits: JointLimits
    begin: float | None
    tick_seconds: float
    replaces: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class StartMotion:
    """Command to start a planned motion; refused when the joints are not at its start, or what it assumes has changed.

    `joints` names the program's columns as (robot, joint); `tool_states` (step, tool, state) become true when their
    step is done; `searcher` is the robot that searches in the last step, if one does; `tracking` is what it goes along
    with, if anything; `nodes` and `signals` are named by steps that are planned when they are reached. `from_here` has
    the plan of its one move made anew as it starts; `path_tolerances` are the motion's.
    """

    joints: tuple[tuple[str, str], ...]
    program: Program
    tool_states: tuple[tuple[int, str, str], ...] = ()
    searcher: str = ""
    preconditions: Preconditions = ()
    tracking: Tracking | None = None
    nodes: tuple[str, ...] = ()
    signals: frozenset[str] = frozenset()
    from_here: FromHere | None = None
    path_tolerances: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class AppendMotion:
    """Command to append planned stages to an open program; refused when it is not what they were planned for.

    step_count: the number of steps that it has before. more: the stages, for its joints and perhaps others after them.
    cut: the first of these takes the place of its last stage, and is the same up to this nominal time (s); None: all of
    them come after.
    """

    id: str
    step_count: int
    more: StartMotion
    cut: float | None = None


@dataclass(frozen=True, slots=True)
class StepMotion:
    """Command to let a motion go on to the end of its present step, and pause there."""

    id: str


@dataclass(frozen=True, slots=True)
class GoOn:
    """Command to let a motion go on whose orders were done: the last one of their batch."""

    id: str


@dataclass(frozen=True, slots=True)
class StartSetpointMotion:
    """Command to start a motion of some joints of a robot that follows setpoints, from its present positions.

    timeout: after how long without a setpoint it stops, in seconds of simulation time. lead: what the joints lead, of
    setpoints of a tool centre point; preconditions: what of the world that assumes.
    """

    robot: str
    joint_names: tuple[str, ...]
    mode: SetpointMode
    timeout: float
    lead: ToolLead | None = None
    preconditions: Preconditions = ()


@dataclass(frozen=True, slots=True)
class SetSetpoint:
    """Command to give a motion its newest setpoint: a value for each joint, rad or m, or per second; or of its tool.

    That is a twist (6,) in the axes of its lead, or a pose (7,) in the frame of the chain's base.
    """

    id: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class EndSetpoints:
    """Command to close a motion's stream of setpoints: it ends at the newest one, or at standstill."""

    id: str


@dataclass(frozen=True, slots=True, eq=False)
class SetMeasuredJoints:
    """Command to set the measured joints of a robot, given by uid, by the end of this tick; motions command them on.

    positions (nq,), velocities (nv,): all of the robot's coordinates and velocities, as in the state. None ends that:
    the robot stays where it was measured, and its commanded joints are there, too.
    """

    robot: int
    positions: NDArray[np.float64] | None
    velocities: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True)
class PauseMotion:
    """Command to slow a motion to standstill on its path."""

    id: str


@dataclass(frozen=True, slots=True)
class ResumeMotion:
    """Command to resume a paused motion."""

    id: str


CALLED = Cancellation(EndCause.CALL, "cancelled")


@dataclass(frozen=True, slots=True)
class CancelMotion:
    """Command to slow a motion to standstill on its path and to end it."""

    id: str
    cancellation: Cancellation = CALLED


@dataclass(frozen=True, slots=True)
class StopMotions:
    """Command to cancel all motions of these robots (empty: of all)."""

    robots: tuple[str, ...] = ()
    reason: str = "stopped"


@dataclass(frozen=True, slots=True)
class StopRobots:
    """Command to cancel or abort, by its cause, all motions of robots given by uid. Robots that are gone are left out.

    The kernel's own way to stop: guard, monitor and leases use it.
    """

    robots: tuple[int, ...]
    cancellation: Cancellation


@dataclass(frozen=True, slots=True)
class StopCell:
    """Command to cancel all motions, and to refuse new ones until the cell is released; an earlier stop stays."""

    stop: CellStop


@dataclass(frozen=True, slots=True)
class ReleaseCell:
    """Command to end a stop of the cell; nothing moves by that. Refused while a motion has not come to rest."""


Command = (
    CreateNodes
    | UpdateNode
    | RemoveNode
    | ClearWorld
    | AttachNode
    | PickPart
    | PlacePart
    | SetJointPositions
    | SetKinematics
    | SetCraft
    | RunSensors
    | SetRangeComponents
    | SetAllowedPairs
    | SetCollisionSettings
    | SetGroups
    | SetPostures
    | SelectTool
    | MountTool
    | UnmountTool
    | SetToolState
    | CreateSignal
    | RemoveSignal
    | SetSignal
    | SetSpeedFactor
    | SetTcpSpeedLimit
    | StartMotion
    | AppendMotion
    | GoOn
    | StepMotion
    | StartSetpointMotion
    | SetSetpoint
    | EndSetpoints
    | SetMeasuredJoints
    | SetDynamics
    | SetJointEfforts
    | SetParts
    | SetContacts
    | SetPhysics
    | PauseMotion
    | ResumeMotion
    | CancelMotion
    | StopMotions
    | StopRobots
    | StopCell
    | ReleaseCell
    | PlayedTicks
    | RestartWorld
    | RestoreRecords
    | RestoreWorld
)
