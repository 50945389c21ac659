"""Motions to start, and how they are doing."""

from __future__ import annotations

import numpy as np
from virtualrobot.v1 import geometry_pb2, motion_pb2

from tests.api.reading import array, pose, step
from tests.kernels import Stubs

RUNNING, PAUSED = motion_pb2.MOTION_PHASE_RUNNING, motion_pb2.MOTION_PHASE_PAUSED
SUCCEEDED, CANCELLED = motion_pb2.MOTION_PHASE_SUCCEEDED, motion_pb2.MOTION_PHASE_CANCELLED
ABORTED = motion_pb2.MOTION_PHASE_ABORTED
TICK = 0.004
READY = dict(zip([f"lbr_iiwa_joint_{i}" for i in range(1, 8)], [0.3, 0.6, -0.2, -1.4, 0.1, 0.9, 0.2], strict=True))


def motion(stubs: Stubs, id: str) -> motion_pb2.Motion:
    return stubs.motion.GetMotion(motion_pb2.GetMotionRequest(id=id)).motion


def finished(stubs: Stubs, id: str) -> motion_pb2.Motion:
    """Let time go on until a motion has ended."""
    for _ in range(100):
        step(stubs, 200)
        if motion(stubs, id).phase in (SUCCEEDED, CANCELLED, ABORTED):
            break
    return motion(stubs, id)


def linear(robot: str, goal: np.ndarray, **fields: float) -> motion_pb2.Move:
    line = motion_pb2.Linear(goal=motion_pb2.PoseGoal(reference_t_tcp=pose(goal)), **fields)  # pyright: ignore[reportArgumentType]
    return motion_pb2.Move(robot=robot, linear=line)


def circular(
    robot: str,
    goal: np.ndarray | None = None,
    via: np.ndarray | None = None,
    center: motion_pb2.ArcCenter | None = None,
    reference: str = "",
    **fields: object,
) -> motion_pb2.Move:
    there = motion_pb2.PoseGoal(reference=reference, reference_t_tcp=None if goal is None else pose(goal))
    point = None if via is None else vector(via)
    arc = motion_pb2.Circular(goal=there, via=point, center=center, **fields)  # pyright: ignore[reportArgumentType]
    return motion_pb2.Move(robot=robot, circular=arc)


def about(position: object, axis: object = None, angle: float | None = None) -> motion_pb2.ArcCenter:
    turn = None if axis is None else vector(axis)
    return motion_pb2.ArcCenter(position=vector(position), axis=turn, angle_radians=angle)


def vector(values: object) -> geometry_pb2.Vector3:
    x, y, z = np.asarray(values, float).tolist()
    return geometry_pb2.Vector3(x=x, y=y, z=z)


def to_pose(robot: str, goal: np.ndarray, reference: str = "") -> motion_pb2.Move:
    wanted = motion_pb2.PoseGoal(reference_t_tcp=pose(goal), reference=reference)
    return motion_pb2.Move(robot=robot, point_to_point=motion_pb2.PointToPoint(pose=wanted))


def trajectory(robot: str, names: list[str], times: object, positions: object, **more: object) -> motion_pb2.Move:
    arrays = {name: array(numbers) for name, numbers in more.items()}
    asked = motion_pb2.JointTrajectory(joint_names=names, times=array(times), positions=array(positions), **arrays)  # pyright: ignore[reportArgumentType]
    return motion_pb2.Move(robot=robot, joint_trajectory=asked)


def spline(robot: str, *goals: np.ndarray, reference: tuple[str, ...] = (), **fields: float) -> motion_pb2.Move:
    """Return a move through poses, each in the frame of its own reference where these are given."""
    names = reference or ("",) * len(goals)
    curve = motion_pb2.Spline(**fields)  # pyright: ignore[reportArgumentType]
    for goal, name in zip(goals, names, strict=True):
        curve.goals.add(reference_t_tcp=pose(goal), reference=name)
    return motion_pb2.Move(robot=robot, spline=curve)


def joint_jog(robot: str, joint: str, velocity: float, distance: float | None = None) -> motion_pb2.Move:
    jog = motion_pb2.JointJog(joint=joint, velocity=velocity, distance=distance)
    return motion_pb2.Move(robot=robot, joint_jog=jog)


def jog(robot: str, translation: object = None, rotation: object = None, **fields: object) -> motion_pb2.Move:
    """Return a jog of the tool centre point."""
    way = motion_pb2.CartesianJog(**fields)  # pyright: ignore[reportArgumentType]
    if translation is not None:
        way.translation.CopyFrom(vector(translation))
    if rotation is not None:
        way.rotation.CopyFrom(vector(rotation))
    return motion_pb2.Move(robot=robot, cartesian_jog=way)
