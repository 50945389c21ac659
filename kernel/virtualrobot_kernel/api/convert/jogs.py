"""Jogs of the contract: to values of `planning`."""

from __future__ import annotations

from math import hypot, tau

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.values import finite, not_negative, vector
from virtualrobot_kernel.planning.moves import CartesianJog, JogFrame, JointJog

SMALLEST_DIRECTION = 1e-9
"""Smallest length of a direction."""

GREATEST_WAY, GREATEST_TURN = 100.0, 10.0 * tau
"""Greatest distance and angle of one jog of a tool centre point, in m and rad."""

FRAMES = EnumTable(JogFrame, motion_pb2.JogFrame, JogFrame.BASE)


def joint_jog(robot: str, jog: motion_pb2.JointJog, factor: float, what: str) -> JointJog:
    """Return the wish to jog a joint; raise KernelError that names the field that is wrong."""
    if not jog.joint:
        raise KernelError(f"{what}.joint is missing: which joint shall move?", field=f"{what}.joint")
    if not finite(jog.velocity, f"{what}.velocity"):
        raise KernelError(f"{what}.velocity must be other than 0; its sign says which way", field=f"{what}.velocity")
    return JointJog(robot, jog.joint, jog.velocity, _distance(jog, what), factor)


def cartesian_jog(robot: str, jog: motion_pb2.CartesianJog, factor: float, what: str) -> CartesianJog:
    """Return the wish to jog a tool centre point; raise KernelError that names the field that is wrong."""
    frame, kind = FRAMES.read(jog.frame, f"{what}.frame"), jog.WhichOneof("direction")
    if kind is None:
        raise KernelError(f"{what} does not say which way; give translation or rotation", field=what)
    turns = kind == "rotation"
    direction = vector(jog.rotation if turns else jog.translation, f"{what}.{kind}")
    if hypot(*direction) < SMALLEST_DIRECTION:
        raise KernelError(
            f"{what}.{kind} must have a length of at least {SMALLEST_DIRECTION:g}, not {list(direction)}",
            field=f"{what}.{kind}",
        )
    if jog.node and frame is not JogFrame.NODE:
        raise KernelError(
            f"{what}.node is {jog.node!r}, but the direction is in the axes of {frame.value}; give JOG_FRAME_NODE, or "
            "no node",
            field=f"{what}.node",
        )
    velocity = not_negative(jog.velocity, f"{what}.velocity")
    distance, greatest = _distance(jog, what), GREATEST_TURN if turns else GREATEST_WAY
    if distance is not None and distance > greatest:
        raise KernelError(
            f"{what}.distance must be at most {greatest:.6g}, not {distance:g}",
            field=f"{what}.distance",
            value=distance,
        )
    return CartesianJog(robot, direction, turns, frame, jog.node, velocity, distance, factor)


def _distance(jog: motion_pb2.JointJog | motion_pb2.CartesianJog, what: str) -> float | None:
    """Return the distance of a jog, None for as far as it goes."""
    if not jog.HasField("distance"):
        return None
    distance = finite(jog.distance, f"{what}.distance")
    if distance <= 0.0:
        sense = "the sign of the velocity" if isinstance(jog, motion_pb2.JointJog) else "the direction"
        raise KernelError(
            f"{what}.distance must be above 0, not {distance:g}; {sense} says which way",
            field=f"{what}.distance",
            value=distance,
        )
    return distance
