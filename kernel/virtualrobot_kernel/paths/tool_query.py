"""Query for a tool path: frames in the arm's base frame, how far the tool may be off them, and its speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.free_path import AXES
from virtualrobot_kernel.motion.pose_check import check_poses
from virtualrobot_kernel.motion.spline import MOST_GOALS, SAME
from virtualrobot_kernel.paths.carriers import External, externals_of
from virtualrobot_kernel.paths.closed_forms import led_arm
from virtualrobot_kernel.planning.actuators import ActuatorLimit, actuator_limits
from virtualrobot_kernel.planning.planned_move import cartesian_limits
from virtualrobot_kernel.planning.robots import arm_of, tip_t_tcp
from virtualrobot_kernel.units import millimetres_question
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]

FARTHEST = (0.1, np.pi)
"""Greatest distance (m) and angle (rad) from a frame, either way, that a tolerance with ends allows."""


@dataclass(frozen=True, slots=True, eq=False)
class Tolerances:
    """Bounds (2, 6) of a tool in its frame, in m along x, y, z, in rad about them; endless (6,): any turn will do."""

    bounds: Floats
    endless: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class ToolPathQuery:
    """Query for a way along a tool path.

    Attributes:
        robot: its name, and `group`, whose joints move.
        joint_names: the arm's joints (k,).
        q_index: (k + m,) where they, and external axes, are among all coordinates.
        lower: (k + m,) from where to where they may go, and `upper`.
        ratios: (a, k + m) of actuators with limits of their own, `least` and `most` (a,): ratios @ q is between them.
        base: the node (uid) that the arm begins at, and `reference`, in whose frame the path is.
        externals: external axes (m in all), whose coordinates come after the arm's own.
        frames: (n, 4, 4) in the frame of the arm's base; with external axes in that of the reference.
        tip_t_tcp: (4, 4).
        tolerances: how far the tool may be from them.
        velocity: of the frame in m/s, and `acceleration` in m/s².
        time_limit: in s.
    """

    robot: str
    group: Group
    joint_names: tuple[str, ...]
    q_index: NDArray[np.int32]
    lower: Floats
    upper: Floats
    ratios: Floats
    least: Floats
    most: Floats
    base: int
    reference: int
    externals: tuple[External, ...]
    frames: Floats
    tip_t_tcp: Floats
    tolerances: Tolerances
    velocity: float
    acceleration: float
    time_limit: float


@dataclass(frozen=True, slots=True, eq=False)
class ToolPathAsked:
    """Tool path as it is asked for: frames (n, 4, 4) in the frame of a node, for a robot or a group of it.

    velocity: in m/s, acceleration: in m/s², 0 for the default, time_limit: in s. externals: robots that move along.
    """

    group: Group
    frames: Floats
    reference: str
    tolerances: Tolerances
    velocity: float
    acceleration: float
    time_limit: float
    externals: tuple[str, ...] = ()


def tool_path_query(snapshot: Snapshot, robot_name: str, asked: ToolPathAsked) -> ToolPathQuery:
    """Return the query for a path of a robot in this world.

    Raises UnknownNameError for a robot or node that there is not, and KernelError with the field for frames,
    tolerances and speeds that make no sense, and for an arm whose postures no closed form tells.
    """
    robot = snapshot.structure.node(robot_name, Kind.ROBOT)
    group, frames = asked.group, asked.frames
    arm = arm_of(snapshot, robot, group)
    chain = arm.serial()
    try:
        led_arm(chain)
    except ArgumentError as error:
        raise KernelError(
            f"{robot_name!r}{group} can't be led along a tool path with freedom: {error}; lines, arcs and splines lead "
            "every arm",
            robot=robot_name,
            field="robot",
        ) from error
    _check_frames(frames)
    _check_tolerances(asked.tolerances)
    cartesian = cartesian_limits(asked.velocity, asked.acceleration)
    reference = snapshot.structure.node(asked.reference).uid
    externals = externals_of(snapshot, robot_name, arm.base, reference, asked.externals)
    base_t_reference = inverse(snapshot.world_t(arm.base)) @ snapshot.world_t(reference)
    limits = list[tuple[ActuatorLimit, int]]()
    count = 0
    every = [(robot, chain.joint_names)]
    every += [(snapshot.structure.node(one.robot), one.joint_names) for one in externals]
    for moved, names in every:
        limits += [(one, count) for one in actuator_limits(snapshot, moved, names)]
        count += len(names)
    ratios = np.zeros((len(limits), count))
    for row, (one, first) in zip(ratios, limits, strict=True):
        row[first : first + len(one.ratios)] = one.ratios
    rest = np.array([one.rest for one, _ in limits])
    return ToolPathQuery(
        robot.name,
        group,
        chain.joint_names,
        np.concatenate([arm.q_index, *(one.q_index for one in externals)]),
        np.concatenate([chain.lower, *(one.limits.lower for one in externals)]),
        np.concatenate([chain.upper, *(one.limits.upper for one in externals)]),
        ratios,
        np.array([one.actuator.lower for one, _ in limits]) - rest,
        np.array([one.actuator.upper for one, _ in limits]) - rest,
        arm.base,
        reference,
        externals,
        frames if externals else base_t_reference @ frames,
        tip_t_tcp(snapshot, arm),
        asked.tolerances,
        cartesian.velocity,
        cartesian.acceleration,
        asked.time_limit,
    )


def _check_frames(frames: Floats) -> None:
    most = MOST_GOALS + 1
    if not 2 <= len(frames) <= most:
        raise KernelError(f"a tool path has 2 to {most:,} frames, not {len(frames)}", field="path.frames")
    check_poses(frames, "frames[{}]")
    steps = np.linalg.norm(np.diff(frames[:, :3, 3], axis=0), axis=1)
    for number in np.flatnonzero(steps < SAME).tolist():
        raise KernelError(
            f"frames[{number + 1}] of the tool path is where frames[{number}] is: {1e3 * steps[number]:.3g} mm away; a "
            f"tool can't keep its speed there, so leave it out (frames are {1e3 * SAME:g} mm apart or more)",
            field="path.frames",
            frame=number + 1,
        )


def _check_tolerances(tolerances: Tolerances) -> None:
    for axis, (lower, upper), endless in zip(AXES, tolerances.bounds.T.tolist(), tolerances.endless, strict=True):
        turns = axis.startswith("rotation")
        most, unit = (FARTHEST[1], "rad") if turns else (FARTHEST[0], "m")
        if endless and (not turns or lower or upper):
            raise KernelError(
                f"the tolerance {axis} is free, so it has no ends"
                if turns
                else f"the tolerance {axis} of a distance can't be free; give it ends in m",
                field=f"path.{axis}",
            )
        if lower > upper:
            raise KernelError(
                f"the tolerance {axis} is from {lower:g} to {upper:g} {unit}: its lower end must not be above its "
                "upper one; swap them",
                field=f"path.{axis}",
            )
        if max(-lower, upper) > most:
            question = "" if turns else millimetres_question(max(-lower, upper))
            raise KernelError(
                f"the tolerance {axis} is from {lower:g} to {upper:g} {unit}; a tool may be {most:.4g} {unit} off at "
                f"the most{question}" + ("; where any turn will do let it be free" if turns else ""),
                field=f"path.{axis}",
            )
