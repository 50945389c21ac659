"""Check of plans against the limits of a robot's actuators, where those are not the joints'."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.planning.planned_move import PlannedMove
from virtualrobot_kernel.world.actuators import LIMIT_TOLERANCE, actuators_of, beyond
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Actuator, Node


@dataclass(frozen=True, eq=False)
class ActuatorLimit:
    """Limits of a robot's actuator for k of its joints: its position is ratios (k,) times theirs, plus the rest.

    rest: its offset, and what the robot's other joints add where they stand.
    """

    robot: Node
    actuator: Actuator
    ratios: NDArray[np.float64]
    rest: float


def actuator_limits(snapshot: Snapshot, robot: Node, joint_names: Sequence[str]) -> list[ActuatorLimit]:
    """Return the actuators that move one of these joints of a robot."""
    return [
        ActuatorLimit(
            robot,
            actuator,
            np.array([dict(actuator.terms).get(joint, 0.0) for joint in joint_names]),
            actuator.offset + _standing(snapshot, robot, actuator, joint_names),
        )
        for actuator in actuators_of(robot)
        if any(joint in joint_names for joint, _ in actuator.terms)
    ]


def check_plans(snapshot: Snapshot, planned: Sequence[PlannedMove]) -> None:
    """Raise LimitError when moves that go together lead an actuator beyond its limits.

    Where joints of several moves are in an actuator, each may be anywhere on its way while the others are on theirs.
    """
    for robot in dict.fromkeys(one.robot.uid for one in planned):
        moves = [one for one in planned if one.robot.uid == robot]
        for actuator in actuators_of(moves[0].robot):
            joints = {joint for joint, _ in actuator.terms}
            moving = [one for one in moves if not joints.isdisjoint(one.joint_names)]
            if len(moving) > 1:
                _check_together(snapshot, actuator, moving)
            elif moving:
                one = moving[0]
                found = first_beyond(snapshot, one.robot, one.joint_names, one.plan.tracks[0].path, (actuator,))
                if found is not None:
                    raise found[1]


def first_beyond(
    snapshot: Snapshot,
    robot: Node,
    joint_names: Sequence[str],
    path: PiecewisePolynomial,
    actuators: Sequence[Actuator] | None = None,
) -> tuple[float, LimitError] | None:
    """Return the place where a path of joints of one robot first leads an actuator (None: any) beyond its ends.

    That is a share of the path, and the refusal. Exact also between samples: an actuator's position is a linear
    combination of the joints' paths, so it is a piecewise polynomial as they are. Joints that the plan does not move
    stay where the snapshot has them.
    """
    found = []
    for one in actuator_limits(snapshot, robot, joint_names):
        actuator = one.actuator
        if actuators is not None and actuator not in actuators:
            continue
        coefficients = path.coefficients @ one.ratios[:, None]
        coefficients[:, 0, 0] += one.rest
        lower, upper = np.array([actuator.lower]), np.array([actuator.upper])
        excursion = PiecewisePolynomial(path.breaks, coefficients).first_excursion(lower, upper, LIMIT_TOLERANCE)
        if excursion is not None:
            share = (excursion.entered - path.start) / (path.end - path.start)
            error = beyond(robot, actuator, excursion.value, f" after {100.0 * share:.3g}% of the way")
            found.append((share, error))
    return min(found, key=lambda one: one[0], default=None)


def _check_together(snapshot: Snapshot, actuator: Actuator, moves: Sequence[PlannedMove]) -> None:
    robot, ratios = moves[0].robot, dict(actuator.terms)
    moved = [joint for one in moves for joint in one.joint_names]
    lowest = highest = actuator.offset + _standing(snapshot, robot, actuator, moved)
    for one in moves:
        path = one.plan.tracks[0].path
        turns = path.coefficients @ np.array([ratios.get(joint, 0.0) for joint in one.joint_names])[:, None]
        ends = PiecewisePolynomial(path.breaks, turns).hull()
        lowest, highest = lowest + float(ends[0][0]), highest + float(ends[1][0])
    for value in (lowest, highest):
        if not actuator.lower - LIMIT_TOLERANCE <= value <= actuator.upper + LIMIT_TOLERANCE:
            raise beyond(robot, actuator, value, " somewhere on the ways of its joints, which are in several moves")


def _standing(snapshot: Snapshot, robot: Node, actuator: Actuator, moved: Sequence[str]) -> float:
    """Return the part of an actuator's position that comes from joints which are not among the `moved` ones."""
    return sum(
        ratio * float(snapshot.state.q[single_joint(snapshot.structure, robot, joint)[1]])
        for joint, ratio in actuator.terms
        if joint not in moved
    )
