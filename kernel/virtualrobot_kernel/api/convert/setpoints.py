"""Streams of setpoints: messages to commands and values."""

from __future__ import annotations

import math
from collections.abc import Iterable

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.states import motion_message
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.values import check_enum, not_negative, stamp
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.world.commands import StartSetpointMotion
from virtualrobot_kernel.world.state import Motion, Snapshot

TIMEOUT_SECONDS = 0.2
"""Default time without a setpoint after which a motion stops."""

MODES = EnumTable(SetpointMode, motion_pb2.SetpointMode, SetpointMode.POSITION)


def followed(
    snapshot: Snapshot, target: motion_pb2.SetpointTarget, craft: CraftAtWork | None = None
) -> StartSetpointMotion:
    """Return the command that starts a motion which follows setpoints, which may be twists of a craft.

    Raises KernelError that names the bad field.
    """
    check_enum(target, "busy_policy")
    timeout = not_negative(target.timeout_seconds, "target.timeout_seconds") or TIMEOUT_SECONDS
    if craft is not None:
        return StartSetpointMotion(target.robot, craft.drives.joints, SetpointMode.VELOCITY, timeout)
    names = tuple(target.joint_names)
    if not names:
        names = tuple(snapshot.structure.robot(target.robot)[1].coordinates)
    return StartSetpointMotion(target.robot, names, MODES.read(target.mode, "target.mode"), timeout)


def follows_twists(target: motion_pb2.SetpointTarget) -> bool:
    """Return whether setpoints are twists of a craft; raise KernelError where joints are named, too."""
    if target.mode != motion_pb2.SETPOINT_MODE_TWIST:
        return False
    if target.joint_names:
        raise KernelError("a twist is of a craft as a whole; leave joint_names out", field="target.joint_names")
    return True


def setpoint(message: motion_pb2.StreamSetpointsRequest, joint_names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the values of a message, one for each joint; raise KernelError naming the joint whose value is none."""
    return numbers(message.values, joint_names, "values")


def numbers(given: Iterable[float], joint_names: tuple[str, ...], field: str) -> tuple[float, ...]:
    """Return values, one for each joint; raise KernelError naming the joint whose value is none."""
    values = tuple(given)
    if len(values) != len(joint_names):
        raise KernelError(
            f"{field} must have one value for each of {', '.join(joint_names)}, not {len(values)}",
            field=field,
            joints=", ".join(joint_names),
        )
    for name, value in zip(joint_names, values, strict=True):
        if not math.isfinite(value):
            raise KernelError(
                f"the value of joint {name!r} must be a finite number, not {value}",
                field=field,
                joint=name,
                value=value,
            )
    return values


def progress(
    snapshot: Snapshot, motion: Motion, given: int, craft: CraftAtWork | None = None
) -> motion_pb2.StreamSetpointsResponse:
    """Return the progress of a motion on its setpoints, of which it has been given so many; they may be a craft's."""
    # Of the motion itself: once it has ended, its robot may be gone or elsewhere in the world's arrays.
    positions, velocities, _ = motion.running.sample()
    if craft is not None:
        q, v = snapshot.state.q, snapshot.state.v
        positions, velocities = craft.place(q), craft.twist(craft.states(q), v[craft.drives.v] / craft.drives.ratio)
    return motion_pb2.StreamSetpointsResponse(
        stamp=stamp(snapshot),
        motion=motion_message(snapshot, motion),
        positions=positions.tolist(),
        velocities=velocities.tolist(),
        setpoint_count=given,
    )
