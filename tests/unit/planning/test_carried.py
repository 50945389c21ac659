"""Arms that other moves carry: a line on a turning table, an arm on a rail, an arm on an arm, on real robots.

What is true of them is asked of the world itself: the forward pass at each tick, and at ten points between.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.circle import Center
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.moves import Circular, JointTrajectory, Linear, Move, PointToPoint, Spline
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.relative_frame import relative_frame
from virtualrobot_kernel.planning.robots import tcp_frame, world_poses
from virtualrobot_kernel.planning.steps import arrived
from virtualrobot_kernel.world.change import Change, joint_places, single_joint
from virtualrobot_kernel.world.commands import AttachNode, CreateNodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from tests.unit.planning.cell import JOINTS, TICK, cell, chain, pictured
from tests.unit.planning.crafts import FLOATING, PLANAR, at, craft
from tests.unit.planning.runs import plan_run
from tests.unit.world.builders import Z, after, link, shifted

FAST = JointLimits(-10.0, 10.0, 1.0, 4.0, 40.0)


@pytest.fixture
def world(rng: np.random.Generator) -> Change:
    """The arm of the cell on a rail, and in front of it a table that tilts (about y) and turns."""
    axis = (0.0, 1.0, 0.0)
    made = CreateNodes(
        (
            NodeSpec("rail", Kind.ROBOT, "stand", shifted(y=-0.3), data=RobotData()),
            link("rail.carriage", "rail", Joint("slide", JointType.PRISMATIC, (0.0, 1.0, 0.0), FAST), shifted(z=0.05)),
            NodeSpec("table", Kind.ROBOT, "world", shifted(x=0.7, y=0.2, z=0.35), data=RobotData()),
            link("table.yoke", "table", Joint("tilt", JointType.REVOLUTE, axis, FAST)),
            link(
                "table.plate",
                "table.yoke",
                Joint("turn", JointType.CONTINUOUS, Z, replace(FAST, lower=-np.inf, upper=np.inf)),
                shifted(z=0.1),
            ),
        )
    )
    turned = np.eye(4)
    turned[:3, :3] = rotation_matrix(rng.uniform(-0.15, 0.15, 3))
    turned[1, 3] = 0.5
    return after(cell(), made, AttachNode("arm", "rail.carriage", turned))


def run(snapshot: Snapshot, *moves: Move) -> PlannedRun:
    ((planned,), notes) = plan_run(snapshot, [MoveStep(moves)], chain)
    assert not notes
    return planned


def fine(planned: PlannedRun) -> np.ndarray:
    """Return nominal times: all ticks, and ten points between each two."""
    return np.arange(0.0, planned.plan.duration, TICK / 11.0)


def along(snapshot: Snapshot, planned: PlannedRun, taus: np.ndarray, reference: str) -> np.ndarray:
    """Return reference_t_tcp (m, 4, 4) at nominal times, by the world's own forward pass."""
    structure, result = snapshot.structure, []
    arm, uid = structure.node("arm"), structure.node(reference).uid
    joints = tuple((structure.node(robot).uid, name) for robot, name in planned.joints)
    places, everything = joint_places(structure, joints)[0], snapshot.state.q.copy()
    for q in planned.plan.derivatives(taus)[0]:
        everything[places] = q
        state = replace(snapshot.state, q=everything)
        there = replace(snapshot, state=state, world_t_node=world_poses(structure, state))
        result.append(np.linalg.inv(there.world_t(uid)) @ tcp_frame(there, arm))
    return np.array(result)


def check_line(poses: np.ndarray, start: np.ndarray, goal: np.ndarray, limits: CartesianLimits) -> None:
    """The poses are on the line to 0.01 mm, evenly turned, at most as fast as allowed, and at the goal in the end."""
    way, turn = goal[:3, 3] - start[:3, 3], rotation_vector(goal[:3, :3] @ start[:3, :3].T)
    share = (poses[:, :3, 3] - start[:3, 3]) @ way / (way @ way)
    np.testing.assert_allclose(poses[:, :3, 3], start[:3, 3] + share[:, None] * way, atol=1e-5)
    assert np.all(np.diff(share) > -1e-9)
    for pose, u in zip(poses[::37], share[::37], strict=True):
        expected = rotation_matrix(u * turn) @ start[:3, :3]
        assert np.linalg.norm(rotation_vector(pose[:3, :3] @ expected.T)) < 2e-5 + 1e-5 * np.linalg.norm(
            turn
        ) / np.linalg.norm(way)
    speed = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / (TICK / 11.0)
    assert speed.max() <= limits.velocity * (1.0 + 1e-6)
    acceleration = np.linalg.norm(np.diff(poses[:, :3, 3], n=2, axis=0), axis=1) / (TICK / 11.0) ** 2
    assert acceleration.max() <= limits.acceleration * 1.005 + 1e-3


def check_joints(snapshot: Snapshot, planned: PlannedRun) -> None:
    """Velocity, acceleration and jerk of each joint stay within its limits."""
    _, v, a, j = planned.plan.derivatives(fine(planned))
    for column, (robot, name) in enumerate(planned.joints):
        limit = snapshot.structure.robot(robot)[1].coordinates[name].joint.limits
        assert np.abs(v[:, column]).max() <= limit.velocity * (1.0 + 1e-6)
        assert np.abs(a[:, column]).max() <= limit.acceleration * 1.005
        assert np.abs(j[:, column]).max() <= limit.jerk * 1.005


def shifted_goal(rng: np.random.Generator, pose: np.ndarray, way: float = 0.15) -> np.ndarray:
    goal = pose.copy()
    goal[:3, 3] += rng.uniform(-way, way, 3)
    goal[:3, :3] = rotation_matrix(rng.uniform(-0.15, 0.15, 3)) @ goal[:3, :3]
    return goal


def test_a_line_on_a_table_that_tilts_and_turns(world: Change, rng: np.random.Generator) -> None:
    snapshot = pictured(world)
    plate = snapshot.world_t(snapshot.structure.node("table.plate").uid)
    start = np.linalg.inv(plate) @ tcp_frame(snapshot, snapshot.structure.node("arm"))
    for _ in range(3):
        goal = shifted_goal(rng, start, 0.03)
        table = PointToPoint("table", {"tilt": float(rng.uniform(-0.1, 0.1)), "turn": float(rng.uniform(-0.2, 0.2))})
        line = Linear("arm", PoseGoal(goal, "table.plate", moving=True), max_velocity=0.2)
        planned = run(snapshot, line, table)
        assert {robot for robot, _ in planned.joints} == {"arm", "table"}
        poses = along(snapshot, planned, fine(planned), "table.plate")
        check_line(poses, start, goal, CartesianLimits(0.2, 1.0, 10.0))
        check_joints(snapshot, planned)
        end = arrived(snapshot, planned.joints, planned.plan.goal)
        there = np.linalg.inv(end.world_t(end.structure.node("table.plate").uid)) @ tcp_frame(
            end, end.structure.node("arm")
        )
        np.testing.assert_allclose(there, goal, atol=1e-7)


def test_an_arm_on_a_rail_goes_straight_while_the_rail_moves(world: Change, rng: np.random.Generator) -> None:
    snapshot = pictured(world)
    start = tcp_frame(snapshot, snapshot.structure.node("arm"))
    goal = shifted_goal(rng, start, 0.05)
    goal[1, 3] += 1.4
    rail = PointToPoint("rail", {"slide": 1.4})
    planned = run(snapshot, rail, Linear("arm", PoseGoal(goal), max_velocity=1.0, max_acceleration=2.0))
    check_line(along(snapshot, planned, fine(planned), "world"), start, goal, CartesianLimits(1.0, 2.0, 20.0))
    check_joints(snapshot, planned)
    # Without the rail the goal is out of reach.
    with pytest.raises(KernelError):
        run(snapshot, Linear("arm", PoseGoal(goal)))


def test_a_tool_that_stands_still_in_the_world_while_its_arm_is_carried(world: Change) -> None:
    snapshot = pictured(world)
    start = tcp_frame(snapshot, snapshot.structure.node("arm"))
    planned = run(snapshot, Linear("arm", PoseGoal(start)), PointToPoint("rail", {"slide": 0.2}))
    poses = along(snapshot, planned, fine(planned)[::5], "world")
    np.testing.assert_allclose(poses, np.broadcast_to(start, poses.shape), atol=2e-6)


def test_an_arc_on_the_turning_table(world: Change) -> None:
    snapshot = pictured(world)
    plate = snapshot.world_t(snapshot.structure.node("table.plate").uid)
    start = np.linalg.inv(plate) @ tcp_frame(snapshot, snapshot.structure.node("arm"))
    center = start[:3, 3] + [0.05, 0.0, 0.0]
    shape = Center(center, np.array([0.0, 0.0, 1.0]), 1.5)
    arc = Circular("arm", shape, reference="table.plate", moving=True)
    planned = run(snapshot, arc, PointToPoint("table", {"turn": -0.4}))
    poses = along(snapshot, planned, fine(planned), "table.plate")
    np.testing.assert_allclose(np.linalg.norm(poses[:, :2, 3] - center[:2], axis=1), 0.05, atol=1e-5)
    np.testing.assert_allclose(poses[:, 2, 3], center[2], atol=1e-5)
    check_joints(snapshot, planned)


@pytest.mark.long
def test_a_spline_on_the_turning_table_and_one_in_the_world_from_a_rail(
    world: Change, rng: np.random.Generator
) -> None:
    snapshot = pictured(world)
    plate = snapshot.world_t(snapshot.structure.node("table.plate").uid)
    first = tcp_frame(snapshot, snapshot.structure.node("arm"))
    for reference, start, carrier in (
        ("table.plate", np.linalg.inv(plate) @ first, PointToPoint("table", {"turn": -0.3})),
        ("world", first, PointToPoint("rail", {"slide": 0.3})),
    ):
        goals = [shifted_goal(rng, start, 0.04) for _ in range(3)]
        own = reference != "world"
        wishes = tuple(PoseGoal(goal, reference, moving=own) for goal in goals)
        planned = run(snapshot, Spline("arm", wishes, max_velocity=0.2), carrier)
        poses = along(snapshot, planned, fine(planned), reference)
        speed = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / (TICK / 11.0)
        assert speed.max() <= 0.2 * (1.0 + 1e-6)
        tcp_path = spline(start, goals)
        # Where it is nearest to each goal in the end: half a step away at most.
        for goal in goals:
            assert np.linalg.norm(poses[:, :3, 3] - goal[:3, 3], axis=1).min() < 0.2 * TICK / 11.0
        for pose in poses[:: len(poses) // 20]:
            nearest = min(np.linalg.norm(tcp_path.pose(u)[:3, 3] - pose[:3, 3]) for u in np.linspace(0.0, 1.0, 2001))
            assert nearest < 1e-3
        check_joints(snapshot, planned)


def test_goals_of_a_spline_move_along_all_or_none(world: Change) -> None:
    snapshot = pictured(world)
    goals = (PoseGoal(np.eye(4), "table.plate", moving=True), PoseGoal(np.eye(4), "world"))
    for wrong in (goals, (goals[0], PoseGoal(np.eye(4), "table.yoke", moving=True))):
        with pytest.raises(KernelError, match="all of them must move along, with one node, or none"):
            run(snapshot, Spline("arm", wrong), PointToPoint("table", {"turn": -0.3}))


def test_a_pose_is_reached_where_base_and_reference_are_in_the_end(world: Change, rng: np.random.Generator) -> None:
    snapshot = pictured(world)
    plate = snapshot.structure.node("table.plate").uid
    start = np.linalg.inv(snapshot.world_t(plate)) @ tcp_frame(snapshot, snapshot.structure.node("arm"))
    goal = shifted_goal(rng, start, 0.03)
    others = [PointToPoint("table", {"turn": 0.2}), PointToPoint("rail", {"slide": 0.1})]
    for moving in (True, False):
        planned = run(snapshot, PointToPoint("arm", PoseGoal(goal, "table.plate", moving=moving)), *others)
        end = arrived(snapshot, planned.joints, planned.plan.goal)
        reference = (end if moving else snapshot).world_t(plate)
        found = np.linalg.inv(reference) @ tcp_frame(end, end.structure.node("arm"))
        np.testing.assert_allclose(found, goal, atol=1e-8)


def test_goals_that_do_not_move_along_count_at_the_start(world: Change) -> None:
    snapshot = pictured(world)
    plate = snapshot.world_t(snapshot.structure.node("table.plate").uid)
    start = tcp_frame(snapshot, snapshot.structure.node("arm"))
    goal = np.linalg.inv(plate) @ start @ shifted(x=0.05)
    planned = run(snapshot, Linear("arm", PoseGoal(goal, "table.plate")), PointToPoint("table", {"turn": 0.5}))
    end = arrived(snapshot, planned.joints, planned.plan.goal)
    np.testing.assert_allclose(tcp_frame(end, end.structure.node("arm")), start @ shifted(x=0.05), atol=1e-7)


def test_moves_that_carry_each_other_and_moves_that_cannot_be_carried(world: Change) -> None:
    on_hand = after(world, AttachNode("table", "hand"))
    snapshot = pictured(on_hand)
    turn = PointToPoint("table", {"turn": 0.3})
    line = Linear("arm", PoseGoal(np.eye(4), "table.plate", moving=True))
    with pytest.raises(KernelError, match="the moves of 'arm' go along with each other in a circle"):
        run(snapshot, line)  # its own reference
    snapshot = pictured(world)
    with pytest.raises(KernelError, match="needs at least one move"):
        run(snapshot)
    planned, notes = plan_run(
        snapshot,
        [
            MoveStep(
                (
                    Linear("arm", PoseGoal(tcp_frame(snapshot, snapshot.structure.node("arm")))),
                    PointToPoint("rail", {"slide": 0.05}),
                ),
                Zone(0.05),
            ),
            MoveStep((turn,)),
        ],
        chain,
    )
    assert len(planned) == 2 and "one robot goes along with another" in notes[0].message


@pytest.mark.parametrize("axis", [Z, (0.28, 0.0, 0.96), (0.0, 0.0, -1.0)])
def test_a_line_is_straight_in_the_world_while_a_planar_base_drives_and_turns(axis: tuple[float, float, float]) -> None:
    world = after(cell(), craft(PLANAR, axis), AttachNode("arm", "craft.body", shifted(z=0.2)))
    snapshot = pictured(world)
    start = tcp_frame(snapshot, snapshot.structure.node("arm"))
    goal = start @ shifted(x=0.05, y=-0.1)
    drive = PointToPoint("craft", {"base/x": -0.2, "base/y": 0.1, "base/theta": 0.4})
    planned = run(snapshot, drive, Linear("arm", PoseGoal(goal)))
    check_line(along(snapshot, planned, fine(planned), "world"), start, goal, CartesianLimits(0.25, 1.0, 10.0))
    check_joints(snapshot, planned)


def test_a_floating_base_that_turns_carries_nothing() -> None:
    world = after(cell(), craft(FLOATING), AttachNode("arm", "craft.body", shifted(z=0.2)))
    snapshot = pictured(world)
    line = Linear("arm", PoseGoal(tcp_frame(snapshot, snapshot.structure.node("arm"))))
    turn = at(FLOATING, np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.6, 0.8]))
    with pytest.raises(KernelError, match="the move of 'craft' turns a floating joint, and moves"):
        run(snapshot, PointToPoint("craft", turn), line)
    run(snapshot, PointToPoint("craft", {"base/z": 0.05}), line)


def test_a_trajectory_keeps_its_times_so_it_carries_nothing(world: Change) -> None:
    """All moves of a step with a carried line have one law, so the times of a trajectory would count for nothing."""
    snapshot = pictured(world)
    times, places = np.array([0.0, 1.0, 2.0]), np.array([[0.0], [0.1], [0.2]])
    places += snapshot.state.q[single_joint(snapshot.structure, snapshot.structure.node("rail"), "slide")[1]]
    slide = JointTrajectory("rail", ("slide",), times, places)
    line = Linear("arm", PoseGoal(tcp_frame(snapshot, snapshot.structure.node("arm"))))
    with pytest.raises(KernelError, match="the joint trajectory of 'rail' has times of its own"):
        run(snapshot, line, slide)
    bend = PointToPoint("arm", {"lbr_iiwa_joint_1": 0.1})
    assert run(snapshot, bend, slide).plan.duration == pytest.approx(2.0)


def test_the_jacobian_between_frames_is_that_of_finite_differences(world: Change, rng: np.random.Generator) -> None:
    """Against central differences of the pose, for joints above the point, above the reference, and above both."""
    snapshot = pictured(world)
    structure = snapshot.structure
    joints = [("arm", name) for name in JOINTS] + [("rail", "slide"), ("table", "tilt"), ("table", "turn")]
    places = np.array(
        [
            structure.robot(robot)[1].q_start[structure.robot(robot)[1].joint_names.index(name)]
            for robot, name in joints
        ],
        np.int32,
    )
    hand = structure.node("hand").uid
    for reference in ("table.plate", "world", "arm.lbr_iiwa_link_3"):
        seen = relative_frame(snapshot, structure.node(reference).uid, hand, shifted(x=0.1, z=0.2), places)
        q = rng.uniform(-1.0, 1.0, len(joints))
        found, h = seen.jacobian(q), 1e-6
        for column in range(len(joints)):
            step = np.zeros(len(joints))
            step[column] = h
            after_, before = seen.pose(q + step), seen.pose(q - step)
            linear = (after_[:3, 3] - before[:3, 3]) / (2 * h)
            angular = rotation_vector(after_[:3, :3] @ before[:3, :3].T) / (2 * h)
            np.testing.assert_allclose(found[:, column], np.concatenate([linear, angular]), atol=1e-8)
