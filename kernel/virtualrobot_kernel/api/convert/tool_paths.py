"""Tool paths: messages to values and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, motion_pb2, path_pb2
from virtualrobot_sdk.poses import from_quaternion

from virtualrobot_kernel.api.convert.paths import time_limit
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.robots import group_selection, selection_message
from virtualrobot_kernel.messages.values import array, array_message, finite, not_negative, positive, snapped
from virtualrobot_kernel.motion.free_path import AXES
from virtualrobot_kernel.paths.tool_query import Tolerances, ToolPathAsked, ToolPathQuery
from virtualrobot_kernel.world.groups import WHOLE

SECONDS = 30.0
"""Default time of a search for a way along a tool path, in s."""


def tool_path_asked(request: path_pb2.FindToolPathRequest) -> ToolPathAsked:
    """Return what a request asks for; raise KernelError that names the field that is wrong."""
    path = request.path
    return ToolPathAsked(
        group_selection(request.group, "group"),
        _frames(path.frames),
        path.reference,
        _tolerances(path),
        positive(path.velocity_meters_per_second, "path.velocity_meters_per_second"),
        not_negative(path.acceleration_meters_per_second_squared, "path.acceleration_meters_per_second_squared"),
        time_limit(request.time_limit_seconds, SECONDS),
    )


def _frames(message: geometry_pb2.NumericArray) -> NDArray[np.float64]:
    rows = array(message, (None, 7), "path.frames")
    frames = np.tile(np.eye(4), (len(rows), 1, 1))
    for number, row in enumerate(rows):
        if not np.linalg.norm(row[3:]) > 0.1:
            raise KernelError(
                f"frames[{number}] of the tool path has the quaternion {row[3:].tolist()}; its length must be 1",
                field="path.frames",
                frame=number,
            )
        frames[number, :3, :3] = from_quaternion(snapped(row[3:], f"path.frames[{number}]"))
        frames[number, :3, 3] = row[:3]
    return frames


def _tolerances(path: path_pb2.ToolPath) -> Tolerances:
    bounds, endless = np.zeros((2, len(AXES))), np.zeros(len(AXES), np.bool_)
    for place, axis in enumerate(AXES):
        if path.HasField(axis):  # pyright: ignore[reportArgumentType] the axes are fields
            message: path_pb2.AxisTolerance = getattr(path, axis)
            bounds[:, place] = [finite(getattr(message, end), f"path.{axis}.{end}") for end in ("lower", "upper")]
            endless[place] = message.free
    return Tolerances(bounds, endless)


def found_tool_path(query: ToolPathQuery, found: Mapping[str, Any]) -> path_pb2.FoundToolPath:
    """Return the result of `find_tool_path` as a message."""
    times, positions, velocities = map(array_message, found["trajectory"])
    trajectory = motion_pb2.JointTrajectory(
        joint_names=query.joint_names, times=times, positions=positions, velocities=velocities
    )
    group = selection_message(query.group) if query.group != WHOLE else None
    move = motion_pb2.Move(robot=query.robot, group=group, joint_trajectory=trajectory)
    return path_pb2.FoundToolPath(
        joint_names=query.joint_names,
        times=array_message(found["times"]),
        positions=array_message(found["positions"]),
        freedoms=array_message(found["freedoms"]),
        length_meters=found["length"],
        held_from_seconds=found["held"][0],
        held_until_seconds=found["held"][1],
        duration_seconds=found["duration"],
        spec=motion_pb2.MotionSpec(steps=[motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[move]))]),
        planning_seconds=found["seconds"],
    )
