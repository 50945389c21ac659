"""Query for a tool path: frames in the arm's base frame, how far the tool may be off them, and its speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.free_path import AXES, frame_path
from virtualrobot_kernel.motion.pose_check import check_poses
from virtualrobot_kernel.motion.spline import MOST_GOALS, SAME, spline
from virtualrobot_kernel.paths.carriers import ELSEWHERE, MOVES, External, externals_of
from virtualrobot_kernel.paths.closed_forms import led_arm
from virtualrobot_kernel.planning.actuators import ActuatorLimit, actuator_limits
from virtualrobot_kernel.planning.planned_move import cartesian_limits
from virtualrobot_kernel.planning.robots import arm_of, standing_at, tip_t_tcp
from virtualrobot_kernel.units import millimetres_question
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]

FARTHEST = (0.1, np.pi)
"""Greatest distance (m) and angle (rad) from a frame, either way, that a tolerance with ends allows."""


MOST_PARTNERS = 3
"""Greatest number of arms that go along with one."""

TOGETHER = 0.02
"""Greatest part by which a partner's speed may be off the one by which both end together."""


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
        slope: greatest angle (rad) between the frame's z and straight down; 0: any.
        partners: arms that go along, by the same external axes; their velocity is what their paths' lengths make it.
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
    slope: float = 0.0
    partners: tuple[ToolPathQuery, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ToolPathAsked:
    """Tool path as it is asked for: frames (n, 4, 4) in the frame of a node, for a robot or a group of it.

    velocity: in m/s, acceleration: in m/s², 0 for the default, time_limit: in s. externals: robots that move along.
    slope: as in the query. partners: arms that go along, by name, each with its path; velocity 0: whichever the lengths
    of both make it.
    """

    group: Group
    frames: Floats
    reference: str
    tolerances: Tolerances
    velocity: float
    acceleration: float
    time_limit: float
    externals: tuple[str, ...] = ()
    slope: float = 0.0
    partners: tuple[tuple[str, ToolPathAsked], ...] = ()


def tool_path_query(snapshot: Snapshot, robot_name: str, asked: ToolPathAsked) -> ToolPathQuery:
    """Return the query for a path of a robot in this world.

    Raises UnknownNameError for a robot or node that there is not, and KernelError with the field for frames,
    tolerances and speeds that make no sense, and for an arm whose postures no closed form tells.
    """
    query = _query(snapshot, robot_name, asked, None)
    return replace(query, partners=_partners(snapshot, query, asked)) if asked.partners else query


def _query(
    snapshot: Snapshot, robot_name: str, asked: ToolPathAsked, externals: tuple[External, ...] | None
) -> ToolPathQuery:
    """Return the query for one arm; of a partner, the external axes are the leader's."""
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
    if asked.slope > np.pi:
        raise KernelError(
            f"the greatest slope is {asked.slope:g} rad; it is at most half a turn, and 0 for any", field="path"
        )
    cartesian = cartesian_limits(asked.velocity, asked.acceleration)
    reference = snapshot.structure.node(asked.reference).uid
    if externals is None:
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
        asked.slope,
    )


def _partners(snapshot: Snapshot, leader: ToolPathQuery, asked: ToolPathAsked) -> tuple[ToolPathQuery, ...]:
    """Return the queries of the arms that go along; raises KernelError for what can't go together."""
    if len(asked.partners) > MOST_PARTNERS:
        raise _wrong(f"a tool path has at most {MOST_PARTNERS} partners, not {len(asked.partners)}")
    names, found = [leader.robot], list[ToolPathQuery]()
    length = _length(leader.frames)
    for name, path in asked.partners:
        if name in names:
            raise _wrong(f"{name!r} is to lead two tools at once; each arm leads one")
        if name in asked.externals:
            raise _wrong(
                f"{name!r} is to lead a tool and to carry: leave it out of the external robots or the partners"
            )
        names.append(name)
        _check_frames(path.frames)
        own = _length(path.frames)
        velocity = leader.velocity * own / length
        if path.velocity and abs(path.velocity / velocity - 1.0) > TOGETHER:
            raise _wrong(
                f"{name!r} would end {100.0 * abs(velocity / path.velocity - 1.0):.3g}% apart from {leader.robot!r}: "
                f"its path has {1e3 * own:.4g} mm at {path.velocity:.4g} m/s, the other one {1e3 * length:.4g} mm at "
                f"{leader.velocity:.4g} m/s; to end together it has to go by {velocity:.4g} m/s"
            )
        found.append(_query(snapshot, name, replace(path, velocity=velocity), leader.externals))
    _check_apart(snapshot, [leader, *found])
    return tuple(found)


def _length(frames: Floats) -> float:
    """Return the length (m) of the path through frames."""
    return frame_path(spline(frames[0], list(frames[1:]))).length


def _check_apart(snapshot: Snapshot, arms: Sequence[ToolPathQuery]) -> None:
    """Raise KernelError where an arm carries another one, or the frame of another one's path."""
    for one in arms:
        index = one.q_index[: len(one.joint_names)]
        moved = standing_at(snapshot, index, snapshot.state.q[index] + ELSEWHERE)
        for other in arms:
            for node in (other.base, other.reference):
                if np.abs(moved.world_t(node) - snapshot.world_t(node)).max() > MOVES:
                    raise _wrong(
                        f"{one.robot!r} carries {snapshot.structure.nodes[node].name!r}, which the path of "
                        f"{other.robot!r} begins at; an arm that leads a tool along a path can't carry another path"
                    )


def _wrong(words: str) -> KernelError:
    return KernelError(words, field="partners")


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
