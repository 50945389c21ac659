"""Planned and checked motions: samples and violations to messages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from virtualrobot.v1 import geometry_pb2, motion_pb2

from virtualrobot_kernel.api.convert.program import NOTE
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.robots import selection_message
from virtualrobot_kernel.messages.values import array_message, pose_message, poses_array, vector_message
from virtualrobot_kernel.planning.check import Checked
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.sampling import RobotSamples, Samples
from virtualrobot_kernel.planning.violations import Violation, ViolationKind

VIOLATIONS = EnumTable(ViolationKind, motion_pb2.ViolationKind)


def plan_message(samples: Samples, notes: Sequence[Note]) -> motion_pb2.PlanMotionResponse:
    """Return a motion in samples, without its stamp."""
    return motion_pb2.PlanMotionResponse(
        duration_seconds=float(samples.times[-1]),
        times=array_message(samples.times),
        steps=array_message(samples.steps, geometry_pb2.NUMERIC_TYPE_INT32),
        robots=[_robot_message(robot) for robot in samples.robots],
        notes=map(NOTE.write, notes),
    )


def _robot_message(robot: RobotSamples) -> motion_pb2.RobotTrajectory:
    whole, *groups = robot.tools
    names, base = robot.joint_names, robot.base
    positions, velocities, accelerations, efforts = (
        robot.positions,
        robot.velocities,
        robot.accelerations,
        robot.efforts,
    )
    if base is not None:
        names = (*names, *base.names)
        positions = np.hstack([positions, base.positions])
        velocities = np.hstack([velocities, base.velocities])
        accelerations = np.hstack([accelerations, base.accelerations])
        efforts = np.hstack([efforts, np.zeros_like(base.positions)])
    return motion_pb2.RobotTrajectory(
        robot=robot.robot.name,
        joint_names=names,
        positions=array_message(positions),
        velocities=array_message(velocities),
        accelerations=array_message(accelerations),
        efforts=array_message(efforts),
        world_t_tcp=poses_array(whole.world_t_tcp),
        tcp_speeds=array_message(whole.tcp_speeds),
        groups=[
            motion_pb2.GroupTrajectory(
                group=selection_message(tool.group),
                world_t_tcp=poses_array(tool.world_t_tcp),
                tcp_speeds=array_message(tool.tcp_speeds),
            )
            for tool in groups
        ],
    )


def check_message(checked: Checked) -> motion_pb2.CheckMotionResponse:
    """Return the result of a check as a message, without its stamp."""
    first = checked.first_violation
    return motion_pb2.CheckMotionResponse(
        first_violation=None if first is None else violation_message(first),
        duration_seconds=checked.duration,
        min_singular_value=checked.min_singular_value,
        notes=map(NOTE.write, checked.notes),
    )


def violation_message(violation: Violation) -> motion_pb2.Violation:
    """Return a limit that a motion violates, or a collision on its way."""
    (first, first_point), (second, second_point) = violation.contact or (("", None), ("", None))
    return motion_pb2.Violation(
        kind=VIOLATIONS.write(violation.kind),
        step=violation.step,
        robot=violation.robot,
        joint=violation.joint,
        time_seconds=violation.time,
        path_fraction=violation.path_fraction,
        world_t_tcp=None if violation.world_t_tcp is None else pose_message(np.asarray(violation.world_t_tcp)),
        value=violation.value,
        limit=violation.limit,
        message=violation.message,
        first=first,
        second=second,
        first_point=None if first_point is None else vector_message(first_point),
        step_path=violation.step_path,
        second_point=None if second_point is None else vector_message(second_point),
    )
