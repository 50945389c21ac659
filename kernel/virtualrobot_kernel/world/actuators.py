"""Actuators: motors and cylinders that move joints through gears and rods, as linear combinations of joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.world.structure import Actuator, Node, RobotData, Structure

LIMIT_TOLERANCE = 1e-6
"""Greatest excess of an actuator over its limits by rounding, in its own unit."""


def actuators_of(robot: Node) -> tuple[Actuator, ...]:
    """Return the actuators of a robot; none where each joint is its own."""
    return robot.data.actuators if isinstance(robot.data, RobotData) else ()


def actuator_positions(structure: Structure, robot: Node, q: NDArray[np.float64]) -> list[float]:
    """Return the positions of a robot's actuators, in its order and their units, for all coordinates q of the world."""
    places = _places(structure, robot)
    return [_position(one, {joint: float(q[places[joint]]) for joint, _ in one.terms}) for one in actuators_of(robot)]


def coupled_joints(structure: Structure, joints: Iterable[tuple[int, str]]) -> set[tuple[int, str]]:
    """Return joints, given as (robot uid, joint name), and those that an actuator with limits moves with one of them.

    What moves some of them has to know where the others stand; robots that are gone have no such others.
    """
    result = set(joints)
    for uid in {uid for uid, _ in result} & structure.nodes.keys():
        names = {name for owner, name in result if owner == uid}
        for actuator in actuators_of(structure.nodes[uid]):
            terms = [name for name, _ in actuator.terms]
            if not names.isdisjoint(terms) and np.isfinite([actuator.lower, actuator.upper]).any():
                result |= {(uid, name) for name in terms}
    return result


def check_actuators(structure: Structure, robot: Node, q: NDArray[np.float64]) -> None:
    """Raise LimitError for the first actuator of a robot that coordinates q of the world put outside its limits."""
    for actuator, position in zip(actuators_of(robot), actuator_positions(structure, robot, q), strict=True):
        if not actuator.lower - LIMIT_TOLERANCE <= position <= actuator.upper + LIMIT_TOLERANCE:
            raise beyond(robot, actuator, position)


def beyond(robot: Node, actuator: Actuator, position: float, where: str = "") -> LimitError:
    """Return the error that an actuator would be outside its limits; `where` says when."""
    joints = " and ".join(repr(joint) for joint, _ in actuator.terms)
    return LimitError(
        f"the actuator {actuator.name!r} of {robot.name!r}, which moves {joints}, would be at {position:.6g}{where}; "
        f"its limits are {actuator.lower:.6g} to {actuator.upper:.6g}",
        robot=robot.name,
        actuator=actuator.name,
        value=position,
        lower=actuator.lower,
        upper=actuator.upper,
    )


def joint_positions(robot: Node, positions: Mapping[str, float]) -> dict[str, float]:
    """Return the positions of the joints of actuators' terms, rad or m by name, from actuator positions by name.

    Raises:
        UnknownNameError: for an actuator that the robot lacks.
        KernelError: when these actuators leave a joint free, or contradict each other.
    """
    known = {one.name: one for one in actuators_of(robot)}
    for name in positions:
        if name not in known:
            raise UnknownNameError(f"actuator of {robot.name!r}", name, known)
    chosen = [known[name] for name in positions]
    joints = list(dict.fromkeys(joint for one in chosen for joint, _ in one.terms))
    matrix = np.array([[dict(one.terms).get(joint, 0.0) for joint in joints] for one in chosen])
    wanted = np.array([positions[one.name] - one.offset for one in chosen])
    if not chosen:
        raise KernelError(f"the move of {robot.name!r} names no actuator", robot=robot.name)
    if np.linalg.matrix_rank(matrix) < len(joints):
        sharing = [one.name for one in known.values() if not set(joints).isdisjoint(joint for joint, _ in one.terms)]
        raise KernelError(
            f"the actuators {', '.join(positions)} of {robot.name!r} do not say where all of {', '.join(joints)} are; "
            f"give {', '.join(sharing)}",
            robot=robot.name,
        )
    found = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    error = np.abs(matrix @ found - wanted)
    if np.any(error > LIMIT_TOLERANCE * np.maximum(1.0, np.abs(wanted))):
        worst = chosen[int(error.argmax())].name
        raise KernelError(
            f"no joints put the actuators {', '.join(positions)} of {robot.name!r} there together: {worst!r} is off by "
            f"{error.max():.3g}",
            robot=robot.name,
            actuator=worst,
        )
    return dict(zip(joints, found.tolist(), strict=True))


def _position(actuator: Actuator, joints: Mapping[str, float]) -> float:
    return actuator.offset + sum(ratio * joints[joint] for joint, ratio in actuator.terms)


def _places(structure: Structure, robot: Node) -> dict[str, int]:
    index = structure.robots[robot.uid]
    return {name: one.q for name, one in index.coordinates.items()}
