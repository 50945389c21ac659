"""Streams of setpoints: messages to commands and values."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.jogs import FRAMES
from virtualrobot_kernel.api.convert.states import motion_message
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.values import check_enum, not_negative, stamp
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.motion.tool_setpoints import NAMES, ToolSetpointMotion
from virtualrobot_kernel.planning.moves import JogFrame
from virtualrobot_kernel.planning.tool_setpoints import ToolFrame, tool_start
from virtualrobot_kernel.world.commands import StartSetpointMotion
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.state import Motion, Snapshot

TIMEOUT_SECONDS = 0.2
"""Default time without a setpoint after which a motion stops."""

TWIST = ("vx", "vy", "omega")
"""Names of the values of a craft's twist."""

TOOL_FIELDS = (
    *("frame", "node", "group"),
    *("max_velocity_meters_per_second", "max_rotation_velocity_radians_per_second"),
)
"""Fields of a target that are about a tool."""

MODES = EnumTable(SetpointMode, motion_pb2.SetpointMode, SetpointMode.POSITION)


class Followed(NamedTuple):
    """Start of a motion that follows setpoints, the names of their values, and their frame where they are a tool's."""

    start: StartSetpointMotion
    names: tuple[str, ...]
    frame: ToolFrame | None = None

    def values(self, snapshot: Snapshot, given: tuple[float, ...]) -> tuple[float, ...]:
        """Return a setpoint as the motion takes it."""
        return given if self.frame is None else self.frame.in_lead(snapshot, self.start.mode, given)


def followed(snapshot: Snapshot, target: motion_pb2.SetpointTarget, craft: CraftAtWork | None = None) -> Followed:
    """Return what starts a motion which follows setpoints; they may be twists of a craft, or of a tool.

    Raises KernelError that names the bad field.
    """
    check_enum(target, "busy_policy")
    timeout = not_negative(target.timeout_seconds, "target.timeout_seconds") or TIMEOUT_SECONDS
    mode = SetpointMode.VELOCITY if craft is not None else MODES.read(target.mode, "target.mode")
    if mode in NAMES:
        return _of_tool(snapshot, target, mode, timeout)
    for field, _ in target.ListFields():
        if field.name in TOOL_FIELDS:
            raise KernelError(
                f"target.{field.name} is for setpoints of a tool; leave it out", field=f"target.{field.name}"
            )
    if craft is not None:
        return Followed(StartSetpointMotion(target.robot, craft.drives.joints, mode, timeout), TWIST)
    names = tuple(target.joint_names)
    if not names:
        names = tuple(snapshot.structure.robot(target.robot)[1].coordinates)
    return Followed(StartSetpointMotion(target.robot, names, mode, timeout), names)


def _of_tool(snapshot: Snapshot, target: motion_pb2.SetpointTarget, mode: SetpointMode, timeout: float) -> Followed:
    if target.joint_names:
        raise KernelError("a tool is led by all joints of its arm; leave joint_names out", field="target.joint_names")
    frame = FRAMES.read(target.frame, "target.frame")
    if target.node and frame is not JogFrame.NODE:
        raise KernelError(
            f"target.node is {target.node!r}, but setpoints are in the frame {frame.value}; give JOG_FRAME_NODE, or no "
            "node",
            field="target.node",
        )
    group = group_selection(target.group, "target.group") if target.HasField("group") else WHOLE
    speeds = (not_negative(getattr(target, name), f"target.{name}") for name in TOOL_FIELDS[-2:])
    start, tool_frame = tool_start(snapshot, target.robot, mode, timeout, frame, target.node, group, *speeds)
    return Followed(start, NAMES[mode], tool_frame)


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
    snapshot: Snapshot, motion: Motion, given: int, craft: CraftAtWork | None = None, frame: ToolFrame | None = None
) -> motion_pb2.StreamSetpointsResponse:
    """Return the progress of a motion on its setpoints, of which it has been given so many; craft, frame: whose."""
    # Of the motion itself: once it has ended, its robot may be gone or elsewhere in the world's arrays.
    positions, velocities, _ = motion.running.sample()
    if craft is not None:
        q, v = snapshot.state.q, snapshot.state.v
        positions, velocities = craft.place(q), craft.twist(craft.states(q), v[craft.drives.v] / craft.drives.ratio)
    held_by = ""
    if frame is not None and isinstance(motion.running, ToolSetpointMotion):
        (positions, velocities), held_by = frame.seen(snapshot, motion.running), motion.running.held_by
    return motion_pb2.StreamSetpointsResponse(
        stamp=stamp(snapshot),
        motion=motion_message(snapshot, motion),
        positions=positions.tolist(),
        velocities=velocities.tolist(),
        setpoint_count=given,
        held_by=held_by,
    )
