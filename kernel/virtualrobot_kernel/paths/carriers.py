"""External axes of a tool path: joints of other robots that carry the arm, as rails do, or the path's frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE
from virtualrobot_sdk.poses import inverse
from virtualrobot_sdk.reference import joint_motion

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.paths.closed_forms import Carriers
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]

MOST = 3
"""Greatest number of external axes: combinations of their values are searched."""
ELSEWHERE, MOVES = 0.1, 1e-9
"""Displacement of a joint (rad or m) that shows whether it carries something, and how far that then is elsewhere."""

_TRIED = np.array([[0.3, -0.5, 0.7], [-0.9, 0.2, 0.4]])
"""Displacements of joints (rad or m) at which a quick product of their motions is held against the world's own."""


@dataclass(frozen=True, slots=True, eq=False)
class External:
    """External axes of one robot.

    Attributes:
        robot: its name.
        joint_names: the joints (m,) that carry something.
        q_index: (m,) where they are in q.
        limits: theirs, with names such as `rail.slide`.
    """

    robot: str
    joint_names: tuple[str, ...]
    q_index: NDArray[np.int32]
    limits: JointLimits


def externals_of(snapshot: Snapshot, arm: str, base: int, reference: int, names: Sequence[str]) -> tuple[External, ...]:
    """Return the external axes of robots by name, for an arm whose base is one node (uid), and a path's frame another.

    Raises UnknownNameError for a robot that there is not, and KernelError with the field for one that carries neither,
    that is named twice or leads the tool itself, for a joint that slides without limits, and for too many of them.
    """
    found = tuple(_external(snapshot, arm, base, reference, name) for name in names)
    for place, name in enumerate(names):
        if name in names[:place]:
            raise _wrong(f"{name!r} stands among the external robots twice")
    if sum(len(one.joint_names) for one in found) > MOST:
        joints = ", ".join(name for one in found for name in one.limits.names)
        raise _wrong(f"a tool path has at most {MOST} external axes, and these are more: {joints}")
    return found


def _external(snapshot: Snapshot, arm: str, base: int, reference: int, name: str) -> External:
    robot = snapshot.structure.node(name, Kind.ROBOT)
    if name == arm:
        raise _wrong(f"{name!r} leads the tool itself; its own joints move without being named")
    index, there = snapshot.structure.robots[robot.uid], _base_t_reference(snapshot, base, reference)
    names, places = list[str](), list[int]()
    for joint, place in zip(index.joints, index.q_start, strict=True):
        if joint.type.coordinate_count != 1:
            continue
        moved = standing_at(snapshot, np.array([place], np.int32), snapshot.state.q[[place]] + ELSEWHERE)
        if np.abs(_base_t_reference(moved, base, reference) - there).max() > MOVES:
            names.append(joint.name)
            places.append(place)
    if not names:
        raise _wrong(
            f"{name!r} carries neither {arm!r} nor the path's frame: none of its joints moves one of them against the "
            "other; leave it out, or give the path in the frame of a node that it carries"
        )
    limits = joint_limits(snapshot, robot, names)[0]
    for joint, lower, upper in zip(names, limits.lower.tolist(), limits.upper.tolist(), strict=True):
        if joint in limits.sliding and not np.isfinite(upper - lower):
            raise _wrong(f"{name}.{joint} slides without limits, so its places can't be searched; give it limits")
    told = tuple(f"{name}.{joint}" for joint in names)
    sliding = frozenset(f"{name}.{joint}" for joint in limits.sliding)
    arrays = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
    return External(name, tuple(names), np.array(places, np.int32), JointLimits(told, *arrays, sliding=sliding))


def carriers_of(snapshot: Snapshot, base: int, reference: int, externals: Sequence[External]) -> Carriers | None:
    """Return what external axes carry; None without any."""
    if not externals:
        return None
    q_index = np.concatenate([one.q_index for one in externals])
    turns = np.array([name not in one.limits.sliding for one in externals for name in one.limits.names])

    def exactly(values: Floats) -> Floats:
        rows, places = np.unique(values.reshape(-1, len(q_index)), axis=0, return_inverse=True)
        found = np.array([_base_t_reference(standing_at(snapshot, q_index, one), base, reference) for one in rows])
        return found[places.reshape(values.shape[:-1])]

    quickly = _product(snapshot, q_index, turns, base, reference)
    now = snapshot.state.q[q_index]
    same = np.abs(quickly(now + _TRIED[:, : len(now)]) - exactly(now + _TRIED[:, : len(now)])).max() < MOVES
    base_t_reference = quickly if same else exactly
    lower, upper = (np.concatenate([getattr(one.limits, end) for one in externals]) for end in ("lower", "upper"))
    return Carriers(lower, upper, turns, base_t_reference)


def _product(
    snapshot: Snapshot, q_index: NDArray[np.int32], turns: NDArray[np.bool_], base: int, reference: int
) -> Callable[[Floats], Floats]:
    """Return where the path's frame is in the base's, by a product of joint motions about axes as they stand now.

    (R. Brockett, Robotic manipulators and the product of exponentials formula, 1984.) It holds where joints come from
    root to tip, and no other follows one of them.
    """
    now = snapshot.state.q[q_index]
    axes = list[tuple[int, Floats, Floats]]()
    moved = [standing_at(snapshot, q_index[[row]], now[[row]] + ELSEWHERE) for row in range(len(now))]
    for row, turning in enumerate(turns.tolist()):
        for node in (base, reference):
            motion = moved[row].world_t(node) @ inverse(snapshot.world_t(node))
            turn, shift = motion[:3, :3], motion[:3, 3]
            if not turning:
                axes.append((PRISMATIC, shift / ELSEWHERE, np.zeros(3)))
                continue
            sine = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
            axis = sine / (2.0 * np.sin(ELSEWHERE))
            centre: Floats = np.linalg.lstsq(np.eye(3) - turn, shift, rcond=1e-6)[0].astype(np.float64)
            axes.append((REVOLUTE, axis, centre))

    def base_t_reference(values: Floats) -> Floats:
        ends = [np.broadcast_to(np.eye(4), (*values.shape[:-1], 4, 4)) for _ in range(2)]
        for place, (kind, axis, centre) in enumerate(axes):
            row, end = divmod(place, 2)
            motion = joint_motion(kind, axis, values[..., row] - now[row])
            motion[..., :3, 3] += centre - motion[..., :3, :3] @ centre
            ends[end] = ends[end] @ motion
        world_t_base, world_t_reference = (
            motion @ snapshot.world_t(node) for motion, node in zip(ends, (base, reference), strict=True)
        )
        turn = np.swapaxes(world_t_base[..., :3, :3], -1, -2)
        found = world_t_reference.copy()
        found[..., :3, :3] = turn @ world_t_reference[..., :3, :3]
        found[..., :3, 3:] = turn @ (world_t_reference[..., :3, 3:] - world_t_base[..., :3, 3:])
        return found

    return base_t_reference


def limits_with(limits: JointLimits, externals: Sequence[External]) -> JointLimits:
    """Return the limits of an arm's joints and of external axes after them."""
    every = (limits, *(one.limits for one in externals))
    arrays = (
        np.concatenate([getattr(one, field) for one in every])
        for field in ("lower", "upper", "velocity", "acceleration", "jerk")
    )
    names = tuple(name for one in every for name in one.names)
    return JointLimits(names, *arrays, sliding=frozenset().union(*(one.sliding for one in every)))


def _base_t_reference(snapshot: Snapshot, base: int, reference: int) -> Floats:
    return inverse(snapshot.world_t(base)) @ snapshot.world_t(reference)


def _wrong(words: str) -> KernelError:
    return KernelError(words, field="external_robots")
