"""Burden of a vehicle: all bodies with a mass that it carries beside its own hull, such as an arm and what that holds.

The vehicle's component knows its own mass. The vehicle is its base link, and what is fixed to that link or moved by a
drive; all else below is carried. Whatever has a floating or planar joint of its own is not.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse, skew
from virtualrobot_sdk.vehicles import Carried

from virtualrobot_kernel.planning.bodies import inertia_tensor, inertial_of
from virtualrobot_kernel.world.index import SINGLE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import JointType, LinkData, Structure

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Burden:
    """Burden of b bodies that k joints move; make it by `burden`."""

    base: int
    """Row of the vehicle's base link among all poses."""
    base_t_center: Floats
    rows: Integers
    """(b,) rows of the bodies."""
    mass: Floats
    """(b,) in kg."""
    centre: Floats
    """(b, 3) centres of mass in the bodies' frames (m)."""
    inertia: Floats
    """(b, 3, 3) about the centres of mass, along the bodies' axes (kg m^2)."""
    joints: Integers
    """(k,) rows of the links that joints move."""
    axis: Floats
    """(k, 3) in the frames of these links."""
    turns: Floats
    """(k, 1) 1 where the joint turns, 0 where it slides."""
    ratio: Floats
    """(k,) factor of each joint's velocity."""
    q: Integers
    """(k,) places of the joints in q."""
    v: Integers
    """(k,) places of the joints in v."""
    moves: Floats
    """(b, k) 1 where the joint moves the body, else 0."""

    def key(self, now: Snapshot, later: Snapshot) -> bytes:
        """Return what the result of `carried` depends on, as bytes."""
        states = now.state, later.state
        return b"".join(part.tobytes() for one in states for part in (one.q[self.q], one.v[self.v]))

    def carried(self, now: Snapshot, later: Snapshot) -> Carried:
        """Return the bodies at the start and at the end of a tick."""
        first = self._at(now)
        same = (now.state.q[self.q] == later.state.q[self.q]).all() and not later.state.v[self.v].any()
        last = (first[0], np.zeros(6)) if same else self._at(later)
        return Carried(np.array([first[0], last[0]]), np.array([first[1], last[1]]))

    def _at(self, snapshot: Snapshot) -> tuple[Floats, Floats]:
        """Return mass matrix (6, 6) and momentum by own movement (6,), about the component's base."""
        poses = snapshot.world_t_node
        center_t_world = inverse(poses[self.base] @ self.base_t_center)
        bodies = center_t_world @ poses[self.rows]
        turn = bodies[:, :3, :3]
        centre = np.einsum("bij,bj->bi", turn, self.centre) + bodies[:, :3, 3]
        inertia = turn @ self.inertia @ turn.transpose(0, 2, 1)
        moment = self.mass @ centre
        square = np.einsum("b,bi,bj->ij", self.mass, centre, centre)
        whole = np.zeros((6, 6))
        whole[:3, :3] = self.mass.sum() * np.eye(3)
        whole[3:, :3] = skew(moment)
        whole[:3, 3:] = -whole[3:, :3]
        whole[3:, 3:] = inertia.sum(axis=0) + np.trace(square) * np.eye(3) - square
        rates = snapshot.state.v[self.v] * self.ratio
        if not rates.any():
            return whole, np.zeros(6)
        joints = center_t_world @ poses[self.joints]
        axis = np.einsum("kij,kj->ki", joints[:, :3, :3], self.axis) * rates[:, None]
        # Velocities of what moves with each body at the base's origin.
        linear = self.moves @ (self.turns * _cross(joints[:, :3, 3], axis) + (1.0 - self.turns) * axis)
        angular = self.moves @ (self.turns * axis)
        push = self.mass[:, None] * (linear + _cross(angular, centre))
        spin = np.einsum("bij,bj->bi", inertia, angular) + _cross(centre, push)
        return whole, np.concatenate([push.sum(axis=0), spin.sum(axis=0)])


def burden(
    structure: Structure, robot: int, base: int, drives: Collection[int], base_t_center: Floats
) -> Burden | None:
    """Return what a vehicle carries, None for nothing that has a mass.

    Args:
        structure: that of the world.
        robot: the vehicle (uid).
        base: the link that its base joint moves (uid).
        drives: places of its drives in q.
        base_t_center: where the component has its base in that link's frame.
    """
    forest, own = structure.forest, frozenset(structure.robots[robot].links)
    velocity_of = {
        one.q: one.v for index in structure.robots.values() for one in index.coordinates.values() if one.v >= 0
    }
    # Of each node below: whether it is the vehicle itself, and the joints (rows) between it and the base.
    is_hull: dict[int, bool] = {base: True}
    moved: dict[int, tuple[int, ...]] = {base: ()}
    bodies: list[tuple[int, float, Floats, Floats]] = []
    for node in structure.below(base):
        if node.uid == base or node.parent not in moved:
            continue
        row = structure.rows[node.uid]
        kind = node.data.joint.type if isinstance(node.data, LinkData) else JointType.FIXED
        if kind is not JointType.FIXED and kind not in SINGLE:
            continue
        is_still = kind is JointType.FIXED or int(forest.q_index[row]) in drives
        is_hull[node.uid] = is_hull[node.parent] and is_still and node.uid in own
        moved[node.uid] = moved[node.parent] + (() if kind is JointType.FIXED else (row,))
        inertial = inertial_of(node)
        if inertial is None or not inertial.mass or is_hull[node.uid]:
            continue
        turn = inertial.link_t_inertial[:3, :3]
        spread = turn @ inertia_tensor(inertial) @ turn.T
        bodies.append((node.uid, inertial.mass, inertial.link_t_inertial[:3, 3], spread))
    if not bodies:
        return None
    joints = sorted({row for uid, *_ in bodies for row in moved[uid]})
    q = forest.q_index[joints]
    turning = (JointType.REVOLUTE.code, JointType.CONTINUOUS.code)
    return Burden(
        base=structure.rows[base],
        base_t_center=base_t_center,
        rows=np.array([structure.rows[uid] for uid, *_ in bodies], np.int32),
        mass=np.array([mass for _, mass, _, _ in bodies]),
        centre=np.array([centre for _, _, centre, _ in bodies]),
        inertia=np.array([spread for *_, spread in bodies]),
        joints=np.array(joints, np.int32),
        axis=forest.axis[joints].reshape(-1, 3),
        turns=np.array([[float(forest.joint_type[row] in turning)] for row in joints]).reshape(-1, 1),
        ratio=forest.multiplier[joints],
        q=np.array(q, np.int32),
        v=np.array([velocity_of[int(place)] for place in q], np.int32),
        moves=np.array([[float(row in moved[uid]) for row in joints] for uid, *_ in bodies]).reshape(len(bodies), -1),
    )


def _cross(a: Floats, b: Floats) -> Floats:
    """Return the cross products of rows (n, 3), which `np.cross` takes several times as long for."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
