"""Tools that stand apart from their robot, which carries what is worked on: ways of the tool on the workpiece.

What is true of them is asked of the world itself: where the tool is in the workpiece, by the forward pass.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.apart_path import ApartPath
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.circle import Via
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.moves import Circular, Linear, Move, PointToPoint, Spline
from virtualrobot_kernel.planning.notes import NoteKind
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change, joint_places
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from tests.unit.planning.cell import READY, cell, chain, pictured, tcp
from tests.unit.planning.runs import plan_run
from tests.unit.planning.test_carried import check_line, fine
from tests.unit.world.builders import after, shifted

APART: dict[str, Any] = {"fixed_tool": "spindle"}


@pytest.fixture
def world(rng: np.random.Generator) -> Change:
    """The arm of the cell with a workpiece in its hand, and a spindle some centimetres before that, both askew."""
    change, askew = cell(), np.eye(4)
    askew[:3, :3] = rotation_matrix(rng.uniform(-0.5, 0.5, 3))
    work = shifted(x=0.03, z=0.12) @ askew
    spindle = tcp(change) @ shifted(x=0.05, y=-0.02, z=0.06) @ np.linalg.inv(askew)
    return after(
        change,
        CreateNodes(
            (
                NodeSpec("work", Kind.OBJECT, "hand", work),
                NodeSpec("spindle", Kind.OBJECT, "world", spindle),
            )
        ),
    )


def run(snapshot: Snapshot, *moves: Move, zone: Zone | None = None) -> PlannedRun:
    """Return the only run that moves become, one after the other."""
    steps = [MoveStep((move,), zone if place < len(moves) - 1 else None) for place, move in enumerate(moves)]
    (planned,), notes = plan_run(snapshot, steps, chain)
    assert not notes
    return planned


def on_work(snapshot: Snapshot, planned: PlannedRun) -> tuple[np.ndarray, np.ndarray]:
    """Return `fine` times (m,), and the end, and work_t_spindle (m, 4, 4) then, by the world's own forward pass."""
    structure, found = snapshot.structure, []
    work, spindle = (structure.node(name).uid for name in ("work", "spindle"))
    joints = tuple((structure.node(robot).uid, name) for robot, name in planned.joints)
    places, everything = joint_places(structure, joints)[0], snapshot.state.q.copy()
    times = np.append(fine(planned), planned.plan.duration)
    for q in planned.plan.derivatives(times)[0]:
        everything[places] = q
        state = replace(snapshot.state, q=everything)
        there = replace(snapshot, state=state, world_t_node=world_poses(structure, state))
        found.append(np.linalg.inv(there.world_t(work)) @ there.world_t(spindle))
    return times, np.array(found)


def start_of(snapshot: Snapshot) -> np.ndarray:
    """Return work_t_spindle (4, 4) as it is."""
    work, spindle = (snapshot.world_t(snapshot.structure.node(name).uid) for name in ("work", "spindle"))
    return np.linalg.inv(work) @ spindle


def aside(pose: np.ndarray, way: list[float], turn: list[float] | None = None) -> np.ndarray:
    """Return a pose moved by a way (m) and turned by a rotation vector, in its reference."""
    found = pose.copy()
    found[:3, 3] += way
    found[:3, :3] = rotation_matrix(np.array(turn or [0.0, 0.0, 0.0])) @ found[:3, :3]
    return found


def test_the_twist_of_the_inverse_way_is_its_derivative(rng: np.random.Generator) -> None:
    begin, goal, tool = (
        aside(np.eye(4), rng.uniform(-1, 1, 3).tolist(), rng.uniform(-1, 1, 3).tolist()) for _ in range(3)
    )
    way = ApartPath(np.eye(4), line_between(begin, goal), tool)
    for u in (0.1, 0.5, 0.9):
        before, after_ = way.pose(u - 1e-6), way.pose(u + 1e-6)
        turn = rotation_vector(after_[:3, :3] @ before[:3, :3].T)
        twist = np.concatenate([after_[:3, 3] - before[:3, 3], turn]) / 2e-6
        np.testing.assert_allclose(way.twist(u), twist, atol=1e-7)


@pytest.mark.parametrize("law", TimeLaw)
def test_a_line_is_one_of_the_tool_on_the_workpiece(world: Change, law: TimeLaw) -> None:
    """Though the workpiece turns about the tool by 34 degrees on its way of 10 cm."""
    snapshot = pictured(world)
    start = start_of(snapshot)
    goal = aside(start, [0.08, 0.05, -0.03], [0.2, -0.3, 0.5])
    limits = CartesianLimits(velocity=0.1, acceleration=0.8, jerk=8.0, rotation_velocity=0.4)
    line = Linear("arm", PoseGoal(goal, "work"), 1.0, 0.1, 0.8, 0.4, time_law=law, **APART)
    planned = run(snapshot, line)
    times, poses = on_work(snapshot, planned)
    check_line(poses[:-1], start, goal, limits)
    speeds = np.linalg.norm(np.diff(poses[:-1, :3, 3], axis=0), axis=1) / times[1]
    turning = np.linalg.norm([0.2, -0.3, 0.5]) / np.linalg.norm([0.08, 0.05, -0.03])
    assert speeds.max() == pytest.approx(min(0.1, 0.4 / turning), rel=1e-3)


def test_an_arc_and_a_spline_are_ways_of_the_tool_on_the_workpiece(world: Change) -> None:
    snapshot = pictured(world)
    start = start_of(snapshot)
    via, goal = aside(start, [0.04, 0.04, 0.0]), aside(start, [0.08, 0.0, 0.0], [0.0, 0.0, 0.4])
    rates = {"max_velocity": 0.1, "max_acceleration": 1.0}
    arc = run(snapshot, Circular("arm", Via(via[:3, 3]), goal, "work", **rates, **APART))
    _, poses = on_work(snapshot, arc)
    center = start[:3, 3] + [0.04, 0.0, 0.0]
    np.testing.assert_allclose(np.linalg.norm(poses[:, :3, 3] - center, axis=1), 0.04, atol=1e-5)
    np.testing.assert_allclose(poses[:, 2, 3], start[2, 3], atol=1e-5)
    np.testing.assert_allclose(poses[-1], goal, atol=1e-6)
    curve = run(snapshot, Spline("arm", (PoseGoal(via, "work"), PoseGoal(goal, "work")), **rates, **APART))
    _, poses = on_work(snapshot, curve)
    assert np.linalg.norm(poses[:, :3, 3] - via[:3, 3], axis=1).min() < 1e-4
    np.testing.assert_allclose(poses[-1], goal, atol=1e-6)


def test_a_joint_move_brings_the_tool_to_a_place_on_the_workpiece_at_its_speed(world: Change) -> None:
    snapshot = pictured(world)
    goal = aside(start_of(snapshot), [0.1, -0.1, 0.05], [0.5, 0.0, 0.3])
    move = PointToPoint("arm", PoseGoal(goal, "work"), max_velocity=0.05, **APART)
    times, poses = on_work(snapshot, run(snapshot, move))
    np.testing.assert_allclose(poses[-1], goal, atol=1e-6)
    speeds = np.linalg.norm(np.diff(poses[:-1, :3, 3], axis=0), axis=1) / times[1]
    assert speeds.max() == pytest.approx(0.05, rel=5e-3)


def test_a_zone_is_as_large_on_the_workpiece_as_it_says(world: Change) -> None:
    """Of two lines at a right angle, whatever way the flange takes; within the zone the tool doesn't stand."""
    snapshot = pictured(world)
    start = start_of(snapshot)
    corner, end = aside(start, [0.08, 0.0, 0.0], [0.0, 0.0, 0.6]), aside(start, [0.08, 0.08, 0.0], [0.0, 0.0, 1.2])
    first, second = (Linear("arm", PoseGoal(goal, "work"), max_velocity=0.1, **APART) for goal in (corner, end))
    planned = run(snapshot, first, second, zone=Zone(meters=0.01))
    times, poses = on_work(snapshot, planned)
    places = poses[:, :3, 3] - corner[:3, 3]
    off = np.minimum(
        np.linalg.norm(places[:, 1:], axis=1) + np.maximum(places[:, 0], 0.0),
        np.linalg.norm(places[:, [0, 2]], axis=1) + np.maximum(-places[:, 1], 0.0),
    )
    far = np.linalg.norm(places, axis=1)
    assert off[far > 0.01].max() < 1e-5 < off.max() < 0.01
    speeds = np.linalg.norm(np.diff(places[:-1], axis=0), axis=1) / times[1]
    assert speeds[(far < 0.01)[:-2]].min() > 0.01
    assert far.min() < 0.01


def test_no_zone_joins_lines_with_different_tools(world: Change) -> None:
    snapshot = pictured(world)
    goal = aside(start_of(snapshot), [0.05, 0.0, 0.0])
    ahead = aside(tcp(world), [0.0, 0.03, 0.0])
    steps = [
        MoveStep((Linear("arm", PoseGoal(goal, "work"), **APART),), Zone(meters=0.01)),
        MoveStep((Linear("arm", PoseGoal(ahead)),)),
    ]
    runs, (note,) = plan_run(snapshot, steps, chain)
    assert len(runs) == 2 and note.kind is NoteKind.ZONE_DROPPED and "have different tools" in note.message


@pytest.mark.parametrize(
    ("reference", "tool", "told"),
    [
        ("bench", "spindle", "'arm' moves 'bench' along the tool 'spindle', and must carry it"),
        ("", "spindle", "'arm' moves 'world' along the tool 'spindle', and must carry it"),
        ("work", "work", "the tool 'work' moves with 'arm'"),
        ("work", "nothing", "there is no node named 'nothing'"),
    ],
)
@pytest.mark.parametrize("kind", [Linear, PointToPoint])
def test_what_the_robot_carries_not_is_told(
    world: Change, kind: type[Linear | PointToPoint], reference: str, tool: str, told: str
) -> None:
    with pytest.raises(KernelError, match=told):
        plan_run(pictured(world), [MoveStep((kind("arm", PoseGoal(np.eye(4), reference), fixed_tool=tool),))], chain)


def test_a_tool_that_moves_meanwhile_is_told(world: Change) -> None:
    change = after(world, CreateNodes((NodeSpec("brush", Kind.OBJECT, "belt.tray", shifted(z=0.2)),)))
    belt = PointToPoint("belt", {"slide": 0.3})
    line = Linear("arm", PoseGoal(np.eye(4), "work"), fixed_tool="brush")
    with pytest.raises(KernelError, match="a tool that stands apart stands still"):
        plan_run(pictured(change), [MoveStep((belt, line))], chain)


def test_appended_lines_begin_where_the_tool_is_on_the_workpiece_then(world: Change) -> None:
    """Whatever the robot did before: each line from where the one before has brought the workpiece."""
    snapshot = pictured(world)
    start = start_of(snapshot)
    goals = [aside(start, way, turn) for way, turn in (([0.05, 0, 0], [0, 0, 0.3]), ([0.05, 0.05, 0.02], [0.2, 0, 0]))]
    back = PointToPoint("arm", READY)
    steps = [MoveStep((Linear("arm", PoseGoal(goal, "work"), **APART),)) for goal in goals]
    runs, _ = plan_run(snapshot, [*steps, MoveStep((back,)), steps[0]], chain)
    assert len(runs) == 4
    _, poses = on_work(snapshot, runs[1])
    check_line(poses[:-1], goals[0], goals[1], CartesianLimits(0.25, 1.0, 10.0))
    np.testing.assert_allclose(on_work(snapshot, runs[3])[1][-1], goals[0], atol=1e-6)
