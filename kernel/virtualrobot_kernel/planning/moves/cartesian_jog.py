"""Jogs of a tool centre point in one direction, as somebody at a pendant chooses them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from math import inf, tau

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.jog import SMALLEST_JOG, JogEnd, plan_cartesian_jog
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.planning.actuators import first_beyond
from virtualrobot_kernel.planning.free_joints import cartesian_tcp
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.notes import jog_notes
from virtualrobot_kernel.planning.planned_move import (
    JERK_RATIO,
    LINE_ACCELERATION,
    PlannedMove,
    joint_limits,
    led_move,
)
from virtualrobot_kernel.planning.redundancy import FREE, NearOf, Redundancy
from virtualrobot_kernel.planning.robots import Arm, SolverOf, arm_on_path, tcp_frame
from virtualrobot_kernel.world.state import Snapshot

VELOCITY, ROTATION_VELOCITY = 0.1, 0.25
"""Default speeds of a tool centre point that is jogged, in m/s and rad/s."""

FARTHEST, FARTHEST_TURN = 2.0, tau
"""Default longest distance and angle of a Cartesian jog, in m and rad."""


class JogFrame(Enum):
    """Frame in whose axes a direction is given."""

    BASE = "BASE"
    TOOL = "TOOL"
    NODE = "NODE"


@dataclass(frozen=True, slots=True, eq=False)
class CartesianJog(Move):
    """Jog of a tool centre point in one direction, along it or, where `turns`, about it.

    direction: of any length above 0. velocity: m/s or rad/s, 0 for the default. distance: m or rad; None: as far as the
    arm can go, at most 2 m or a whole turn.
    """

    direction: tuple[float, float, float]
    turns: bool = False
    frame: JogFrame = JogFrame.BASE
    reference: str = ""
    velocity: float = 0.0
    distance: float | None = None
    speed_factor: float = 1.0
    redundancy: Redundancy = FREE

    @property
    def solved(self) -> bool:
        """True: a jog of a tool centre point needs the kinematics component."""
        return True

    @property
    def references(self) -> tuple[str, ...]:
        """Node in whose axes the direction is."""
        return (self.reference,) if self.frame is JogFrame.NODE else ()

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints of the arm that are not locked."""
        return arm_on_path(snapshot, self.node(snapshot), self.redundancy, self.group).joint_names

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan, which ends early where the arm or an actuator can go no further; a note tells that."""
        node = self.node(snapshot)
        arm = arm_on_path(snapshot, node, self.redundancy, self.group)
        limits, start = joint_limits(snapshot, node, arm.joint_names)
        direction = _base_direction(snapshot, arm, self)
        tcp = cartesian_tcp(snapshot, arm, solver_of, self.redundancy, near_of)
        cartesian = CartesianLimits(acceleration=LINE_ACCELERATION, jerk=JERK_RATIO * LINE_ACCELERATION)
        if self.turns:
            cartesian = replace(cartesian, rotation_velocity=self.velocity or ROTATION_VELOCITY)
            wanted = self.distance or FARTHEST_TURN
        else:
            cartesian = replace(cartesian, velocity=self.velocity or VELOCITY)
            wanted = self.distance or FARTHEST
        speed_factor = self.speed_factor or 1.0

        def planned(distance: float) -> tuple[Plan, JogEnd | None]:
            way, still = distance * direction, np.zeros(3)
            ways = (still, way) if self.turns else (way, still)
            return plan_cartesian_jog(
                tcp.kinematics, start, *ways, limits, cartesian, speed_factor, tcp.tip_t_tcp, tcp.objective
            )

        plan, end = planned(wanted)
        if beyond := first_beyond(snapshot, node, arm.joint_names, plan.tracks[0].path):
            share, error = beyond
            kept = share * (end.kept if end else wanted) - SMALLEST_JOG
            if kept < SMALLEST_JOG:
                raise LimitError(f"the jog cannot move: {error}", reason=error.reason, **error.metadata) from error
            plan, end = planned(kept)[0], JogEnd(wanted, kept, str(error))
        return replace(led_move(node, arm, plan, tcp, cartesian, speed_factor), notes=jog_notes(node.name, end))


def _base_direction(snapshot: Snapshot, arm: Arm, move: CartesianJog) -> NDArray[np.float64]:
    """Return the direction of a jog as a unit vector (3,) in the axes of the arm's base."""
    if move.frame is JogFrame.BASE:
        world_t_frame = snapshot.world_t(arm.base)
    elif move.frame is JogFrame.TOOL:
        world_t_frame = tcp_frame(snapshot, arm.robot, arm)
    else:
        world_t_frame = snapshot.world_t(snapshot.structure.node(move.reference).uid)
    given = np.array(move.direction)
    length = float(np.linalg.norm(given))
    if not 0.0 < length < inf:
        raise KernelError(f"the direction of a jog has a finite length above 0, not {list(move.direction)}")
    return inverse(snapshot.world_t(arm.base))[:3, :3] @ world_t_frame[:3, :3] @ (given / length)
