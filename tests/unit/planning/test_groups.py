"""Groups of a branched robot, two Pandas on a torso that lifts them: against pinocchio and the world itself."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.free_joints import solve_inverse
from virtualrobot_kernel.planning.jacobian import solve_jacobian
from virtualrobot_kernel.planning.moves import Linear, PointToPoint
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep
from virtualrobot_kernel.planning.robots import arm_of, standing_at, tcp_frame
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_kernel.planning.steps import arrived
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.groups import Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node

from tests.unit.formats.models import ROBOTS, read_text
from tests.unit.planning.cell import pictured
from tests.unit.planning.runs import plan_run
from tests.unit.world.builders import after, empty, shifted

LEFT, RIGHT = (Group(base="torso", tip=f"{side}_panda_link8") for side in ("left", "right"))
FROM_FLOOR = Group(base="floor", tip="left_panda_link8")


@cache
def twin() -> str:
    """Return the URDF: two arms without shapes, their names with `left_` and `right_` before them."""
    arm = ROBOTS["panda"].read_text()
    inside = re.search(r"(?s)<robot[^>]*>(.*)</robot>", arm)
    assert inside
    arm = re.sub(r"(?s)<(visual|collision)>.*?</\1>", "", inside[1])
    sides = [re.sub(r'(name|link|joint)="(panda_\w+)"', rf'\1="{side}_\2"', arm) for side in ("left", "right")]
    mounts = "".join(
        f'<joint name="{side}_mount" type="fixed"><origin xyz="0.1 {y} 0.3" rpy="{y} 0.2 0"/><parent link="torso"/>'
        f'<child link="{side}_panda_link0"/></joint>'
        for side, y in (("left", 0.3), ("right", -0.3))
    )
    lift = (
        '<joint name="lift" type="prismatic"><axis xyz="0 0 1"/><parent link="floor"/><child link="torso"/>'
        '<limit lower="0" upper="0.5" velocity="0.3" effort="900"/></joint>'
    )
    return f'<robot name="twin"><link name="floor"/><link name="torso"/>{lift}{mounts}{"".join(sides)}</robot>'


@pytest.fixture
def world(rng: np.random.Generator) -> tuple[Snapshot, Node]:
    """The robot, all its joints somewhere well within their limits."""
    change = after(empty(), CreateNodes(read_text(twin()).nodes))
    node = next(node for node in change.structure.nodes.values() if node.kind is Kind.ROBOT)
    index = change.structure.robots[node.uid]
    ends = np.array([(joint.limits.lower, joint.limits.upper) for joint in index.joints])
    q = ends[:, 0] + rng.uniform(0.4, 0.6, len(ends)) * (ends[:, 1] - ends[:, 0])
    return standing_at(pictured(change), np.array(index.q_start, np.int32), q), node


@pytest.fixture
def solvers() -> Iterator[Solvers]:
    solvers = Solvers(Catalog())
    yield solvers
    solvers.close()


@pytest.mark.parametrize("group", [LEFT, RIGHT, FROM_FLOOR], ids=str)
def test_ends_and_jacobians_are_pinocchio_s(
    world: tuple[Snapshot, Node], group: Group, rng: np.random.Generator
) -> None:
    snapshot, node = world
    model = pinocchio.buildModelFromXML(twin())
    data, index = model.createData(), snapshot.structure.robots[node.uid]
    arm = arm_of(snapshot, node, group)
    chain = arm.serial()
    for _ in range(30):
        there = standing_at(snapshot, arm.q_index, rng.uniform(chain.lower, chain.upper))
        q = pinocchio.neutral(model)
        for joint, place in zip(index.joints, index.q_start, strict=True):
            q[model.joints[model.getJointId(joint.name)].idx_q] = there.state.q[place]
        frame = model.getFrameId(group.tip)
        found = solve_jacobian(there, node, {}, (), group)
        jacobian = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)
        pinocchio.updateFramePlacements(model, data)
        np.testing.assert_allclose(found.world_t_tcp, data.oMf[frame].homogeneous, atol=1e-12)
        columns = [model.joints[model.getJointId(name)].idx_v for name in found.joint_names]
        np.testing.assert_allclose(found.tcp, jacobian[:, columns], atol=1e-12)
        others = np.delete(jacobian, columns, axis=1)
        assert (group is FROM_FLOOR) == (not others.any())


@pytest.mark.parametrize("group", [LEFT, RIGHT, FROM_FLOOR], ids=str)
def test_every_reachable_pose_is_solved(
    world: tuple[Snapshot, Node], group: Group, solvers: Solvers, rng: np.random.Generator
) -> None:
    """Poses of random joints, solved from elsewhere and put back into the world's forward pass."""
    snapshot, node = world
    arm = arm_of(snapshot, node, group)
    chain = arm.serial()
    for _ in range(40):
        goal = standing_at(snapshot, arm.q_index, rng.uniform(chain.lower, chain.upper)).world_t(arm.tip)
        found, result = solve_inverse(snapshot, node, goal, {}, solvers.of, group=group)
        assert found.joint_names == chain.joint_names
        again = standing_at(snapshot, arm.q_index, result.solutions[0])
        np.testing.assert_allclose(again.world_t(arm.tip), goal, atol=2e-3)
        still = np.setdiff1d(np.arange(len(snapshot.state.q)), arm.q_index)
        np.testing.assert_array_equal(again.state.q[still], snapshot.state.q[still])


def test_an_arm_goes_straight_in_the_world_while_its_torso_lifts(
    world: tuple[Snapshot, Node], solvers: Solvers
) -> None:
    """Both are moves of one robot in one step; at ten places of the way the end is on its line, the other arm still."""
    snapshot, node = world
    arm = arm_of(snapshot, node, LEFT)
    start = tcp_frame(snapshot, node, arm)
    goal = shifted(x=0.04, y=-0.05, z=0.03) @ start
    lift = float(snapshot.state.q[snapshot.structure.robots[node.uid].q_start[0]]) + 0.05
    moves = Linear(node.name, PoseGoal(goal), group=LEFT), PointToPoint(node.name, {"lift": lift})
    ((run,), notes) = plan_run(snapshot, [MoveStep(moves)], solvers.of)
    assert not notes
    way = goal[:3, 3] - start[:3, 3]
    for time in np.linspace(0.0, run.plan.duration, 10):
        there = arrived(snapshot, run.joints, run.plan.derivatives(np.array([time]))[0][0])
        along = tcp_frame(there, node, arm)[:3, 3] - start[:3, 3]
        share = along @ way / (way @ way)
        np.testing.assert_allclose(along, share * way, atol=1e-4)
    np.testing.assert_allclose(tcp_frame(there, node, arm), goal, atol=1e-6)
    other = arm_of(snapshot, node, RIGHT)
    np.testing.assert_array_equal(there.state.q[other.q_index], snapshot.state.q[other.q_index])


def test_groups_that_share_joints_do_not_move_together(world: tuple[Snapshot, Node], solvers: Solvers) -> None:
    snapshot, node = world
    goals = (tcp_frame(snapshot, node, arm_of(snapshot, node, group)) for group in (LEFT, FROM_FLOOR))
    moves = tuple(
        PointToPoint(node.name, PoseGoal(goal), group=group)
        for goal, group in zip(goals, (LEFT, FROM_FLOOR), strict=True)
    )
    with pytest.raises(KernelError, match="two moves of one motion move the joint 'left_panda_joint1'"):
        plan_run(snapshot, [MoveStep(moves)], solvers.of)


def test_a_chain_without_joints_is_not_solved(world: tuple[Snapshot, Node], solvers: Solvers) -> None:
    snapshot, node = world
    fixed = Group(base="left_panda_link7", tip="left_panda_link8")
    with pytest.raises(KernelError, match="no joint moves the end of 'twin', chain from 'left_panda_link7'") as refused:
        solve_inverse(snapshot, node, np.eye(4), {}, solvers.of, group=fixed)
    assert refused.value.reason is Reason.WRONG_STATE
