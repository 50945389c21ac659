"""Tool paths: messages to values and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, motion_pb2, nodes_pb2, path_pb2
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
    partners = ((one.robot, _asked(one, not_negative, f"partners[{row}].")) for row, one in enumerate(request.partners))
    return replace(
        _asked(request, positive),
        time_limit=time_limit(request.time_limit_seconds, SECONDS),
        externals=tuple(request.external_robots),
        partners=tuple(partners),
    )


def _asked(
    message: path_pb2.FindToolPathRequest | path_pb2.ToolPathPartner,
    speed: Callable[[float, str], float],
    before: str = "",
) -> ToolPathAsked:
    """Return what is asked of one arm, whose speed is checked so; `before` is where the message is in a request."""
    path, field = message.path, f"{before}path"
    return ToolPathAsked(
        group_selection(message.group, f"{before}group"),
        _frames(path.frames, f"{field}.frames"),
        path.reference,
        _tolerances(path, field),
        speed(path.velocity_meters_per_second, f"{field}.velocity_meters_per_second"),
        not_negative(path.acceleration_meters_per_second_squared, f"{field}.acceleration_meters_per_second_squared"),
        0.0,
        slope=not_negative(path.max_slope_radians, f"{field}.max_slope_radians"),
    )


def _frames(message: geometry_pb2.NumericArray, field: str) -> NDArray[np.float64]:
    rows = array(message, (None, 7), field)
    frames = np.tile(np.eye(4), (len(rows), 1, 1))
    for number, row in enumerate(rows):
        if not np.linalg.norm(row[3:]) > 0.1:
            raise KernelError(
                f"frames[{number}] of the tool path has the quaternion {row[3:].tolist()}; its length must be 1",
                field=field,
                frame=number,
            )
        frames[number, :3, :3] = from_quaternion(snapped(row[3:], f"{field}[{number}]"))
        frames[number, :3, 3] = row[:3]
    return frames


def _tolerances(path: path_pb2.ToolPath, field: str) -> Tolerances:
    bounds, endless = np.zeros((2, len(AXES))), np.zeros(len(AXES), np.bool_)
    for place, axis in enumerate(AXES):
        if path.HasField(axis):  # pyright: ignore[reportArgumentType] the axes are fields
            message: path_pb2.AxisTolerance = getattr(path, axis)
            bounds[:, place] = [finite(getattr(message, end), f"{field}.{axis}.{end}") for end in ("lower", "upper")]
            endless[place] = message.free
    return Tolerances(bounds, endless)


def found_tool_path(query: ToolPathQuery, found: Mapping[str, Any]) -> path_pb2.FoundToolPath:
    """Return the result of `find_tool_path` as a message."""
    times, positions, velocities = found["trajectory"]
    own = (query.robot, _selection(query), query.joint_names)
    moves, external, first = list[motion_pb2.Move](), list[path_pb2.ExternalMotion](), 0
    partners = list[path_pb2.PartnerMotion]()
    others = [(one.robot, None, one.joint_names) for one in query.externals]
    others += [(one.robot, _selection(one), one.joint_names) for one in query.partners]
    for robot, of, names in (own, *others):
        columns = slice(first, first + len(names))
        first = columns.stop
        trajectory = motion_pb2.JointTrajectory(
            joint_names=names,
            times=array_message(times),
            positions=array_message(positions[:, columns]),
            velocities=array_message(velocities[:, columns]),
        )
        moves.append(motion_pb2.Move(robot=robot, group=of, joint_trajectory=trajectory))
        place = len(moves) - 2 - len(query.externals)
        if place >= 0:
            partners.append(_partner_motion(robot, names, columns, found["partners"][place]))
        elif len(moves) > 1:
            there = array_message(found["positions"][:, columns])
            external.append(path_pb2.ExternalMotion(robot=robot, joint_names=names, positions=there))
    return path_pb2.FoundToolPath(
        joint_names=query.joint_names,
        times=array_message(found["times"]),
        positions=array_message(found["positions"][:, : len(query.joint_names)]),
        freedoms=array_message(found["freedoms"]),
        length_meters=found["length"],
        held_from_seconds=found["held"][0],
        held_until_seconds=found["held"][1],
        duration_seconds=found["duration"],
        spec=motion_pb2.MotionSpec(steps=[motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=moves))]),
        planning_seconds=found["seconds"],
        external=external,
        partners=partners,
    )


def _selection(query: ToolPathQuery) -> nodes_pb2.GroupSelection | None:
    return selection_message(query.group) if query.group != WHOLE else None


def _partner_motion(
    robot: str, names: Sequence[str], columns: slice, found: Mapping[str, Any]
) -> path_pb2.PartnerMotion:
    return path_pb2.PartnerMotion(
        robot=robot,
        joint_names=names,
        times=array_message(found["times"]),
        positions=array_message(found["positions"][:, columns]),
        freedoms=array_message(found["freedoms"]),
        length_meters=found["length"],
        velocity_meters_per_second=found["velocity"],
    )
