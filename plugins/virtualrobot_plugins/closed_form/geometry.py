"""The axes of an arm of turning joints, as the library EAIK takes them and as the compiled checks take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import REVOLUTE, Floats, SerialChain

MOST_JOINTS = 6
ANGLE = 1e-4
"""Axes that are parallel or at a right angle up to this (rad) are meant to be: model files round pi / 2 to 1.5708."""
LENGTH = 2e-5
"""Offsets below this (m) are meant to be none; they come from the same rounding."""


class Axes(NamedTuple):
    """The axes of n joints at position 0, in the base frame."""

    direction: Floats
    """(n, 3) unit vectors."""
    point: Floats
    """(n, 3) a point on each axis (m)."""
    base_t_tip: Floats
    """(4, 4) the tip with all joints at 0."""


def check_joints(chain: SerialChain) -> None:
    """Raise ArgumentError unless the chain has one to six turning joints, each with a coordinate of its own."""
    check_own_joints(chain)
    n = len(chain.joint_names)
    if n > MOST_JOINTS:
        raise ArgumentError(
            f"the arm has {n} joints ({', '.join(chain.joint_names)}), so that a pose has endlessly many postures; the "
            f"closed form is for at most {MOST_JOINTS}",
            joints=n,
        )


def check_own_joints(chain: SerialChain) -> None:
    """Raise ArgumentError unless the chain has joints, all of them turn, and each has a coordinate of its own."""
    n = len(chain.pre)
    names = chain.joint_names
    for i in range(n):
        name = names[chain.q_index[i]]
        if chain.joint_type[i] != REVOLUTE:
            raise ArgumentError(f"joint {name!r} slides; the closed form is for joints that turn", joint=name)
    if not np.array_equal(chain.q_index, np.arange(n)) or len(names) != n:
        raise ArgumentError("several joints follow one coordinate; the closed form is for joints that move freely")
    if n == 0 or (chain.multiplier != 1.0).any() or (chain.offset != 0.0).any():
        raise ArgumentError("the closed form is for joints whose positions are the coordinates themselves")


def axes_of(chain: SerialChain) -> Axes:
    """Return the axes of a chain of turning joints at position 0."""
    pose = np.eye(4)
    direction, point = [], []
    for pre, axis in zip(chain.pre, chain.axis, strict=True):
        pose = pose @ pre
        direction.append(pose[:3, :3] @ axis)
        point.append(pose[:3, 3])
    return Axes(np.array(direction), np.array(point), pose @ chain.post)


def idealised(axes: Axes) -> tuple[Axes, bool]:
    """Return the arm that was meant, and whether it differs from the given one by more than rounding of doubles.

    Almost parallel axes are made parallel, almost right angles right, tiny offsets none. What the difference does to
    a solution is polished away afterwards.
    """
    directions: list[Floats] = []
    for given in axes.direction:
        direction = given.copy()
        twin = next((other for other in directions if np.linalg.norm(np.cross(other, direction)) < ANGLE), None)
        if twin is not None:
            direction = twin * np.sign(twin @ direction)
        else:
            for other in directions:
                if abs(other @ direction) < ANGLE:
                    direction = direction - (other @ direction) * other
            direction = direction / np.linalg.norm(direction)
        directions.append(direction)
    ideal = np.array(directions)
    frame = _frame(ideal)
    points = np.vstack([axes.point, axes.base_t_tip[:3, 3]])
    steps = np.diff(points, axis=0, prepend=points[:1]) @ frame
    steps[np.abs(steps) < LENGTH] = 0.0
    points = points[0] + np.cumsum(steps @ frame.T, axis=0)
    base_t_tip = axes.base_t_tip.copy()
    base_t_tip[:3, 3] = points[-1]
    meant = Axes(ideal, points[:-1], base_t_tip)
    off = max(float(np.abs(a - b).max()) for a, b in zip(meant, axes, strict=True))
    return meant, off > 1e-14


def upright_frames(chain: SerialChain) -> Floats:
    """Return (n + 1, 4, 4): `pre` of each joint with frames turned so that every axis is z, and `post` after them."""
    turned = np.eye(4)
    frames = np.empty((len(chain.pre) + 1, 4, 4))
    for i, (pre, axis) in enumerate(zip(chain.pre, chain.axis, strict=True)):
        before, turned = turned, np.eye(4)
        turned[:3, :3] = _frame(axis[None])[:, [1, 2, 0]]
        frames[i] = before.T @ pre @ turned
    frames[-1] = turned.T @ chain.post
    return frames


def _frame(directions: Floats) -> Floats:
    """Return a right-handed orthonormal frame (3, 3) in columns: the first direction, and what the next one adds."""
    first = directions[0]
    for other in [*directions[1:], *np.eye(3)[[2, 0, 1]]]:
        second = other - (first @ other) * first
        if np.linalg.norm(second) > 0.1:
            second = second / np.linalg.norm(second)
            return np.stack([first, second, np.cross(first, second)], axis=1)
    raise AssertionError("three base vectors cannot all be parallel to one direction")
