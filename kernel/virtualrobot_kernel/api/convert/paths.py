"""Paths: messages to values and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from virtualrobot.v1 import motion_pb2, path_pb2

from virtualrobot_kernel.api.convert.moves import speed_factor
from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.robots import selection_message
from virtualrobot_kernel.messages.values import check_enum, finite
from virtualrobot_kernel.paths.query import PathOptions, PathQuery
from virtualrobot_kernel.world.collisions import MOST_PADDING_METERS
from virtualrobot_kernel.world.groups import WHOLE

SECONDS, MOST_SECONDS = 10.0, 600.0
"""Default and greatest time of a path search, in s."""

PLANNERS = {
    path_pb2.PATH_PLANNER_UNSPECIFIED: "RRTConnect",
    path_pb2.PATH_PLANNER_RRT_CONNECT: "RRTConnect",
    path_pb2.PATH_PLANNER_RRT: "RRT",
    path_pb2.PATH_PLANNER_KPIECE1: "KPIECE1",
    path_pb2.PATH_PLANNER_BKPIECE1: "BKPIECE1",
    path_pb2.PATH_PLANNER_LBKPIECE1: "LBKPIECE1",
    path_pb2.PATH_PLANNER_RRT_STAR: "RRTstar",
    path_pb2.PATH_PLANNER_INFORMED_RRT_STAR: "InformedRRTstar",
}
"""Planners by their numbers in the contract, as OMPL names them."""
PLANNER_NUMBERS = {name: number for number, name in PLANNERS.items()}

PERCENT = 50.0
"""Greatest zone in percent, and the default one."""


def time_limit(value: float, default: float) -> float:
    """Return the time of a search in s; raise KernelError for one that makes no sense."""
    seconds = finite(value, "time_limit_seconds") or default
    if not 0.0 < seconds <= MOST_SECONDS:
        raise LimitError(
            f"time_limit_seconds must be above 0 and at most {MOST_SECONDS:g}, not {seconds:g}",
            field="time_limit_seconds",
            value=seconds,
            upper=MOST_SECONDS,
        )
    return seconds


def path_options(request: path_pb2.FindPathRequest) -> PathOptions:
    """Return the options of a path search; raise KernelError that names the field that is wrong."""
    seconds = time_limit(request.time_limit_seconds, SECONDS)
    factor = speed_factor(request.speed_factor, "speed_factor")
    percent = finite(request.blend_percent, "blend_percent") if request.HasField("blend_percent") else PERCENT
    if not 0.0 <= percent <= PERCENT:
        raise KernelError(f"blend_percent must be from 0 to {PERCENT:g}, not {percent:g}", field="blend_percent")
    clearance = finite(request.clearance_meters, "clearance_meters")
    if not 0.0 <= clearance <= MOST_PADDING_METERS:
        raise LimitError(
            f"clearance_meters must be from 0 to {MOST_PADDING_METERS:g}, not {clearance:g}",
            field="clearance_meters",
            value=clearance,
            upper=MOST_PADDING_METERS,
        )
    check_enum(request, "planner")
    return PathOptions(PLANNERS[request.planner], request.seed, seconds, factor, percent, clearance)


def found_message(query: PathQuery, found: Mapping[str, Any]) -> path_pb2.FoundPath:
    """Return the result of `find_path` as a message."""
    waypoints = found["waypoints"]
    return path_pb2.FoundPath(
        joint_names=query.joint_names,
        waypoints=[path_pb2.Waypoint(positions=row) for row in waypoints],
        straight=found["straight"],
        length=found["length"],
        straight_length=found["straight_length"],
        spec=motion_pb2.MotionSpec(
            steps=[
                motion_pb2.ProgramStep(move=_step(query, goal.tolist(), zone))
                for goal, zone in zip(waypoints[1:], found["zones"], strict=True)
            ]
        ),
        duration_seconds=found["duration"],
        planner=PLANNER_NUMBERS[found["planner"]],
        planning_seconds=found["seconds"],
    )


def _step(query: PathQuery, goal: list[float], zone: float) -> motion_pb2.MoveStep:
    joints = motion_pb2.JointGoal(joint_positions=dict(zip(query.joint_names, goal, strict=True)))
    move = motion_pb2.Move(
        robot=query.robot,
        group=selection_message(query.group) if query.group != WHOLE else None,
        speed_factor=query.speed_factor,
        point_to_point=motion_pb2.PointToPoint(joints=joints),
    )
    return motion_pb2.MoveStep(moves=[move], blend_percent=zone or None)
