"""Joints for points, put back into the forward pass; a leg's closed form and what is out of reach: tests/api."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.planning.points import PointPostures, solve_points
from virtualrobot_kernel.planning.robots import arm_of, standing_at
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_sdk.kinematics import InverseStatus

from tests.tiers import Draws
from tests.unit.planning.robots import standing


def ends(snapshot: Snapshot, robot: Node, found: PointPostures, tip: int) -> np.ndarray:
    """Return where the forward pass has the link `tip` for each posture."""
    index = snapshot.structure.robots[robot.uid]
    places = dict(zip((joint.name for joint in index.joints), index.q_start, strict=True))
    columns = np.array([places[name] for name in found.joint_names])
    return np.array([standing_at(snapshot, columns, q).world_t(tip)[:3, 3] for q in found.positions])


@pytest.mark.parametrize("model", ["panda", "iiwa", "puma560", "nine_axis"])
def test_the_forward_pass_has_the_flange_at_each_point(model: str, rng: np.random.Generator, draws: Draws) -> None:
    """Points that postures within limits have, in any order."""
    snapshot, robot = standing(model)
    index = snapshot.structure.robots[robot.uid]
    arm = arm_of(snapshot, robot)
    limits = list(zip(arm.serial().lower.tolist(), arm.serial().upper.tolist(), strict=True))
    columns = arm.q_index
    postures = [[rng.uniform(*limit) for limit in limits] for _ in range(draws(100))]
    points = np.array([standing_at(snapshot, columns, np.array(q)).world_t(index.flange)[:3, 3] for q in postures])
    found = solve_points(snapshot, robot, points, snapshot.structure.node("").uid, {})
    assert found.status is InverseStatus.SOLVED, found.reason
    np.testing.assert_allclose(ends(snapshot, robot, found, index.flange), points, atol=1e-9)
    for column, (lower, upper) in zip(found.positions.T, limits, strict=True):
        assert lower - 1e-12 <= column.min() and column.max() <= upper + 1e-12


def test_a_leg_of_a_quadruped_is_a_group() -> None:
    snapshot, robot = standing("a1")
    structure = snapshot.structure
    trunk = structure.node("a1.trunk").uid
    foot = structure.node("a1.FL_toe").uid
    below = np.array([[0.18, 0.13, -0.28], [0.2, 0.13, -0.3], [0.15, 0.1, -0.25]])
    found = solve_points(snapshot, robot, below, trunk, {}, Group("", "a1.trunk", "a1.FL_toe"))
    assert found.status is InverseStatus.SOLVED and len(found.joint_names) == 3
    world = below @ snapshot.world_t(trunk)[:3, :3].T + snapshot.world_t(trunk)[:3, 3]
    np.testing.assert_allclose(ends(snapshot, robot, found, foot), world, atol=1e-9)
