"""Jogs: from a joint or a direction, as somebody at a pendant chooses it, to a planned move and what ends it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from math import inf, tau

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.jog import SMALLEST_JOG, JogEnd, plan_cartesian_jog, plan_joint_jog
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.planning.actuators import first_beyond
from virtualrobot_kernel.planning.free_joints import led_tcp
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.planned_move import (
    JERK_RATIO,
    LINE_ACCELERATION,
    PlannedMove,
    joint_limits,
    led_move,
)
from virtualrobot_kernel.planning.redundancy import FREE, Redundancy
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_on_path, tcp_frame
from virtualrobot_kernel.world.actuators import actuators_of
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, Kind, Node

VELOCITY, ROTATION_VELOCITY = 0.1, 0.25
"""How fast a tool centre point is jogged where nothing is said, in m/s and rad/s."""

FARTHEST, FARTHEST_TURN = 2.0, tau
"""How far a tool centre point is jogged at most where nothing is said, in m and rad."""


@dataclass(frozen=True, slots=True)
class JointJog:
    """One joint, at a velocity (rad/s or m/s) that says the way too; distance None: until its limit or a whole turn."""

    robot: str
    joint: str
    velocity: float
    distance: float | None = None
    speed_factor: float = 1.0
    group: Group = WHOLE


class JogFrame(Enum):
    """In whose axes a direction is given."""

    BASE = "BASE"
    TOOL = "TOOL"
    NODE = "NODE"


@dataclass(frozen=True, slots=True)
class CartesianJog:
    """The tool centre point in one direction, along it or, where `turns`, about it.

    direction: of any length above 0. velocity: m/s or rad/s, 0 for the default. distance: m or rad; None: as far as the
    arm can go, at most 2 m or a whole turn.
    """

    robot: str
    direction: tuple[float, float, float]
    turns: bool = False
    frame: JogFrame = JogFrame.BASE
    node: str = ""
    velocity: float = 0.0
    distance: float | None = None
    speed_factor: float = 1.0
    redundancy: Redundancy = FREE
    group: Group = WHOLE


def joint_jog(snapshot: Snapshot, move: JointJog, solver_of: SolverOf) -> PlannedMove:
    """Return the planned move of one joint."""
    del solver_of
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    limits, start = joint_limits(snapshot, node, (move.joint,))
    limits = _within_actuators(snapshot, node, limits)
    distance = inf if move.distance is None else move.distance
    endless = np.isinf(limits.upper if move.velocity > 0.0 else limits.lower)[0]
    if move.distance is None and endless:
        joint = single_joint(snapshot.structure, node, move.joint)[0]
        distance = inf if joint.type is JointType.PRISMATIC else tau
    speed_factor = move.speed_factor or 1.0
    plan, end = plan_joint_jog(float(start[0]), move.velocity, distance, limits, speed_factor)
    share = speed_factor * abs(move.velocity) / float(limits.velocity[0])
    return PlannedMove(node, (move.joint,), plan, speed_factor=share, notes=_notes(node, end))


def cartesian_jog(snapshot: Snapshot, move: CartesianJog, solver_of: SolverOf) -> PlannedMove:
    """Return the planned move of a tool centre point."""
    node = snapshot.structure.node(move.robot, Kind.ROBOT)
    arm = arm_on_path(snapshot, node, move.redundancy, move.group)
    limits, start = joint_limits(snapshot, node, arm.joint_names)
    direction = _base_direction(snapshot, arm, move)
    tcp = led_tcp(snapshot, arm, solver_of, move.redundancy)
    cartesian = CartesianLimits(acceleration=LINE_ACCELERATION, jerk=JERK_RATIO * LINE_ACCELERATION)
    if move.turns:
        cartesian = replace(cartesian, rotation_velocity=move.velocity or ROTATION_VELOCITY)
        wanted = move.distance or FARTHEST_TURN
    else:
        cartesian = replace(cartesian, velocity=move.velocity or VELOCITY)
        wanted = move.distance or FARTHEST
    speed_factor = move.speed_factor or 1.0

    def planned(distance: float) -> tuple[Plan, JogEnd | None]:
        way, still = distance * direction, np.zeros(3)
        ways = (still, way) if move.turns else (way, still)
        return plan_cartesian_jog(
            tcp.kinematics, start, *ways, limits, cartesian, speed_factor, tcp.tip_t_tcp, tcp.wish
        )

    plan, end = planned(wanted)
    if beyond := first_beyond(snapshot, node, arm.joint_names, plan.tracks[0].path):
        share, error = beyond
        kept = share * (end.kept if end else wanted) - SMALLEST_JOG
        if kept < SMALLEST_JOG:
            raise LimitError(f"the jog cannot move: {error}", reason=error.reason, **error.metadata) from error
        plan, end = planned(kept)[0], JogEnd(wanted, kept, str(error))
    return replace(led_move(node, arm, plan, tcp, cartesian, speed_factor), notes=_notes(node, end))


def _base_direction(snapshot: Snapshot, arm: Arm, move: CartesianJog) -> NDArray[np.float64]:
    """Return the direction of a jog as a unit vector (3,) in the axes of the arm's base."""
    if move.frame is JogFrame.BASE:
        world_t_frame = snapshot.world_t(arm.base)
    elif move.frame is JogFrame.TOOL:
        world_t_frame = tcp_frame(snapshot, arm.robot, arm)
    else:
        world_t_frame = snapshot.world_t(snapshot.structure.node(move.node).uid)
    given = np.array(move.direction)
    length = float(np.linalg.norm(given))
    if not 0.0 < length < inf:
        raise KernelError(f"the direction of a jog has a finite length above 0, not {list(move.direction)}")
    return inverse(snapshot.world_t(arm.base))[:3, :3] @ world_t_frame[:3, :3] @ (given / length)


def _within_actuators(snapshot: Snapshot, node: Node, limits: JointLimits) -> JointLimits:
    """Return the limits of one joint, narrowed to where the other joints of its actuators let it go."""
    (name,) = limits.names
    lower, upper = float(limits.lower[0]), float(limits.upper[0])
    for actuator in actuators_of(node):
        ratio, rest = 0.0, actuator.offset
        for joint, factor in actuator.terms:
            if joint == name:
                ratio += factor
            else:
                rest += factor * float(snapshot.state.q[single_joint(snapshot.structure, node, joint)[1]])
        if ratio:
            ends = sorted(((actuator.lower - rest) / ratio, (actuator.upper - rest) / ratio))
            lower, upper = max(lower, ends[0]), min(upper, ends[1])
    return replace(limits, lower=np.array([min(lower, upper)]), upper=np.array([upper]))


def _notes(node: Node, end: JogEnd | None) -> tuple[Note, ...]:
    if end is None:
        return ()
    return (Note(NoteKind.JOG_ENDS, 0, node.name, end.wanted, end.kept, f"the jog ends early: {end.reason}"),)
