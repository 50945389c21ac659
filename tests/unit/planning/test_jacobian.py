"""Jacobians of points on robots: against differences of the forward pass, and against the arm's component."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.planning.jacobian import Point, solve_jacobian
from virtualrobot_kernel.planning.robots import standing_at
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_sdk.poses import rotation_vector

from tests.unit.planning.robots import standing

STEP = 1e-6


def random_positions(snapshot: Snapshot, robot: Node, rng: np.random.Generator) -> dict[str, float]:
    joints = snapshot.structure.robots[robot.uid].joints
    return {one.name: rng.uniform(max(one.limits.lower, -3.0), min(one.limits.upper, 3.0)) for one in joints}


@pytest.mark.parametrize("model", ["panda", "iiwa", "xarm6_gripper"])
def test_points_move_as_the_forward_pass_moves_them(model: str, rng: np.random.Generator) -> None:
    """Central differences; fingers of the Panda slide, those of the xArm mimic a joint."""
    snapshot, robot = standing(model)
    structure, world = snapshot.structure, snapshot.structure.node("").uid
    index = structure.robots[robot.uid]
    positions = random_positions(snapshot, robot, rng)
    q_index, q = np.array(index.q_start, np.int32), np.array([positions[one.name] for one in index.joints])
    nodes, local = list(index.links[1:]), rng.normal(size=3)
    there = standing_at(snapshot, q_index, q)
    in_world = [Point(uid, world, (there.world_t(uid) @ [*local, 1.0])[:3]) for uid in nodes]
    found = solve_jacobian(snapshot, robot, positions, in_world)
    assert found.joint_names == tuple(one.name for one in index.joints)
    for column, shift in enumerate(STEP * np.eye(len(q))):
        before, after = (standing_at(snapshot, q_index, q + sign * shift) for sign in (-1.0, 1.0))
        for row, uid in enumerate(nodes):
            linear = (after.world_t(uid) - before.world_t(uid)) @ [*local, 1.0] / (2.0 * STEP)
            np.testing.assert_allclose(found.points[row, :3, column], linear[:3], atol=1e-8)
            turn = after.world_t(uid)[:3, :3] @ before.world_t(uid)[:3, :3].T
            np.testing.assert_allclose(found.points[row, 3:, column], rotation_vector(turn) / (2.0 * STEP), atol=1e-8)
    own = solve_jacobian(snapshot, robot, positions, [Point(uid, uid, local) for uid in nodes])
    np.testing.assert_allclose(own.points, found.points, atol=1e-12)


def test_the_tool_centre_point_without_a_tool_is_the_flange() -> None:
    snapshot, robot = standing("iiwa")
    flange = snapshot.structure.robots[robot.uid].flange
    found = solve_jacobian(snapshot, robot, {}, [Point(flange, flange, np.zeros(3))])
    np.testing.assert_array_equal(found.tcp, found.points[0])
    np.testing.assert_array_equal(found.world_t_tcp, snapshot.world_t(flange))


def test_what_cannot_be_is_refused() -> None:
    snapshot, robot = standing("iiwa")
    index, world = snapshot.structure.robots[robot.uid], snapshot.structure.node("").uid
    with pytest.raises(UnknownNameError):
        solve_jacobian(snapshot, robot, {"elbow": 0.0})
    with pytest.raises(LimitError):
        solve_jacobian(snapshot, robot, {index.joints[0].name: 4.0})
    with pytest.raises(KernelError, match="does not carry 'world'"):
        solve_jacobian(snapshot, robot, {}, [Point(world, world, np.zeros(3))])
    with pytest.raises(KernelError, match="does not carry"):
        solve_jacobian(snapshot, robot, {}, [Point(robot.uid, world, np.zeros(3))])
