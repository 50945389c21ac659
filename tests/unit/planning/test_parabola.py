"""Zones by a controller's radius: the way through the corner against the parabola's formula, for all that moves.

The parabola is the quadratic Bézier curve of where the zone begins, the corner, and where it ends, so that it passes
the corner of two lines that meet at 90 degrees at a distance of radius √2 / 4.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.circle import Via
from virtualrobot_kernel.motion.superposed import fade_within
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.extend_run import Extension, extended
from virtualrobot_kernel.planning.moves import Circular, Linear, Move, PointToPoint
from virtualrobot_kernel.planning.notes import NoteKind
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.robots import tcp_frame
from virtualrobot_kernel.planning.steps import arrived, plan_steps
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from tests.tiers import Draws
from tests.unit.planning.runs import KINDS, cell_of, plan_run, random_steps, solver, with_joints
from tests.unit.planning.test_blending import alone, check_law

POSTURE = np.array([0.2, 0.8, -3.0, 0.3, 0.9, 0.1])
"""Posture of a Puma 560 with room around it."""


def cell(rng: np.random.Generator, *files: str) -> tuple[Snapshot, np.ndarray]:
    """Return a world whose first arm has room around it, and where its tool centre point is (4, 4)."""
    snapshot = with_joints(cell_of(rng, *(files or ("puma560",))), "arm0", POSTURE)
    return snapshot, tcp_frame(snapshot, snapshot.structure.node("arm0", Kind.ROBOT)).copy()


def moved(pose: np.ndarray, way: np.ndarray | list[float], turn: np.ndarray | None = None) -> np.ndarray:
    """Return a pose moved by a way (m), and turned by a rotation vector."""
    pose = pose.copy()
    pose[:3, 3] += way
    if turn is not None:
        pose[:3, :3] = rotation_matrix(turn) @ pose[:3, :3]
    return pose


def line(pose: np.ndarray, speed: float = 0.2) -> Linear:
    """Return the line to a pose in the world."""
    return Linear("arm0", PoseGoal(pose), max_velocity=speed, max_acceleration=2.0)


def program(*moves: Move | tuple[Move, ...], zone: Zone) -> list[MoveStep]:
    """Return steps with a zone after each but the last."""
    each = [move if isinstance(move, tuple) else (move,) for move in moves]
    return [MoveStep(one, zone if place < len(each) - 1 else None) for place, one in enumerate(each)]


def run_of(snapshot: Snapshot, steps: list[MoveStep]) -> PlannedRun:
    """Return the only run that steps become, whose law keeps the limits of the joints."""
    (run,), _ = plan_run(snapshot, steps, solver)
    limits = {}
    for robot in {name for name, _ in run.joints}:
        limits |= {(robot, joint.name): joint.limits for joint in snapshot.structure.robot(robot)[1].joints}
    check_law(
        run.plan,
        *(np.array([getattr(limits[one], f) for one in run.joints]) for f in ("velocity", "acceleration", "jerk")),
    )
    return run


def poses(snapshot: Snapshot, run: PlannedRun, count: int = 1500) -> np.ndarray:
    """Return the poses (n, 4, 4) of the first arm's tool centre point along a run."""
    node = snapshot.structure.node("arm0", Kind.ROBOT)
    path = run.plan.tracks[0].path
    return np.array(
        [
            tcp_frame(arrived(snapshot, run.joints, q), node).copy()
            for q in path.evaluate(np.linspace(path.start, path.end, count))
        ]
    )


def off_from(points: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Return how far points (n, 3) are from a curve of many points (m, 3)."""
    first, ways = curve[:-1], np.diff(curve, axis=0)
    share = ((points[:, None] - first) * ways).sum(axis=2) / (ways**2).sum(axis=1)
    near = first + np.clip(share, 0.0, 1.0)[:, :, None] * ways
    return np.linalg.norm(points[:, None] - near, axis=2).min(axis=1)


def nearest(points: np.ndarray, corner: np.ndarray) -> float:
    """Return how near a curve of many points passes a corner."""
    return float(off_from(corner[None], points)[0])


def bezier(start: np.ndarray, corner: np.ndarray, end: np.ndarray, count: int = 401) -> np.ndarray:
    """Return points of a quadratic Bézier curve."""
    t = np.linspace(0.0, 1.0, count)[:, None]
    return (1.0 - t) ** 2 * start + 2.0 * t * (1.0 - t) * corner + t**2 * end


@pytest.mark.parametrize("degrees", [20.0, 60.0, 90.0, 135.0])
@pytest.mark.parametrize("radius", [0.005, 0.03])
def test_two_lines_are_joined_by_the_parabola_of_the_radius(
    rng: np.random.Generator, degrees: float, radius: float
) -> None:
    snapshot, at = cell(rng)
    one = np.array([0.0, 0.1, 0.0])
    other = 0.1 * np.array([0.0, np.cos(np.radians(degrees)), -np.sin(np.radians(degrees))])
    corner = moved(at, one)
    steps = program(line(corner), line(moved(corner, other)), zone=Zone(meters=radius, parabola=True))
    points = poses(snapshot, run_of(snapshot, steps))[:, :3, 3]
    begin, middle = at[:3, 3], corner[:3, 3]
    wanted = bezier(middle - radius * 10.0 * one, middle, middle + radius * 10.0 * other)
    wanted = np.concatenate([[begin], wanted, [middle + other]])
    depth = nearest(wanted, middle)
    assert depth == pytest.approx(0.5 * radius * np.sin(np.radians(degrees / 2.0)), rel=1e-4)
    assert off_from(points, wanted).max() < 0.01 * depth
    assert nearest(points, middle) == pytest.approx(depth, rel=0.01)


def test_a_line_and_an_arc_are_joined_by_the_sum_of_both(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    radius, corner = 0.02, moved(at, [0.0, 0.1, 0.0])
    bend, x, z = 0.08, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])

    def on_arc(length: np.ndarray | float) -> np.ndarray:
        angle = np.asarray(length)[..., None] / bend
        return corner[:3, 3] + bend * (np.sin(angle) * x - (1.0 - np.cos(angle)) * z)

    quarter = bend * np.pi / 2.0
    via = Circular("arm0", Via(on_arc(quarter / 2.0)), moved(at, on_arc(quarter) - at[:3, 3]), max_velocity=0.2)
    steps = program(line(corner), via, zone=Zone(meters=radius, parabola=True))
    points = poses(snapshot, run_of(snapshot, steps))[:, :3, 3]
    s = np.linspace(-radius, radius, 401)
    before, after = -((radius - s) ** 2) / (4.0 * radius), (radius + s) ** 2 / (4.0 * radius)
    sums = corner[:3, 3] + before[:, None] * np.array([0.0, 1.0, 0.0]) + on_arc(after) - corner[:3, 3]
    wanted = np.concatenate([[at[:3, 3]], sums, on_arc(np.linspace(radius, quarter, 400))])
    depth = nearest(wanted, corner[:3, 3])
    assert off_from(points, wanted).max() < 0.012 * depth  # the zone begins on a chord of the arc
    assert nearest(points, corner[:3, 3]) == pytest.approx(depth, rel=0.01)


def test_two_arcs_are_joined_by_the_sum_of_both(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    radius, bends = 0.02, (0.08, 0.06)
    x, y, z = np.eye(3)
    corner = moved(at, bends[0] * (y - z))
    middle = corner[:3, 3]

    def on_arc(number: int, along: np.ndarray, length: np.ndarray | float) -> np.ndarray:
        """Return points on an arc that passes the corner in a direction and bends downwards, by lengths from there."""
        angle = np.asarray(length)[..., None] / bends[number]
        return middle + bends[number] * (np.sin(angle) * along + (-1.0) ** number * (1.0 - np.cos(angle)) * z)

    quarters = [bend * np.pi / 2.0 for bend in bends]
    first = Circular("arm0", Via(on_arc(0, y, -quarters[0] / 2.0)), corner, max_velocity=0.2)
    goal = moved(at, on_arc(1, x, quarters[1]) - at[:3, 3])
    second = Circular("arm0", Via(on_arc(1, x, quarters[1] / 2.0)), goal, max_velocity=0.2)
    points = poses(snapshot, run_of(snapshot, program(first, second, zone=Zone(meters=radius, parabola=True))))
    points = points[:, :3, 3]
    s = np.linspace(-radius, radius, 401)
    before, after = -((radius - s) ** 2) / (4.0 * radius), (radius + s) ** 2 / (4.0 * radius)
    sums = on_arc(0, y, before) + on_arc(1, x, after) - middle
    wanted = np.concatenate(
        [
            on_arc(0, y, np.linspace(-quarters[0], -radius, 400)[:-1]),
            sums,
            on_arc(1, x, np.linspace(radius, quarters[1], 400)[1:]),
        ]
    )
    depth = nearest(wanted, middle)
    assert off_from(points, wanted).max() < 0.02 * depth  # the zone begins on chords of both arcs
    assert nearest(points, middle) == pytest.approx(depth, rel=0.01)


def test_zones_that_meet_are_as_large_as_half_of_the_move(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    ways = [[0.0, 0.1, 0.0], [0.0, 0.0, -0.06], [0.0, -0.1, 0.0]]
    goals = [at]
    for way in ways:
        goals.append(moved(goals[-1], way))
    steps = program(*(line(goal) for goal in goals[1:]), zone=Zone(meters=0.05, parabola=True))
    run = run_of(snapshot, steps)
    _, notes = plan_run(snapshot, steps, solver)
    assert [note.kind for note in notes] == [NoteKind.ZONE_SHRUNK] * 2
    assert [note.kept for note in notes] == [pytest.approx(0.03, rel=0.01)] * 2
    points = poses(snapshot, run)[:, :3, 3]
    for corner in goals[1:3]:
        assert nearest(points, corner[:3, 3]) == pytest.approx(0.03 * np.sqrt(2.0) / 4.0, rel=0.01)


def test_orientation_goes_over_in_the_extended_radius(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    radius, wide = 0.01, 0.03
    turn = np.array([0.0, 0.0, 0.3])
    corner = moved(at, [0.0, 0.1, 0.0], turn)
    goal = moved(corner, [0.0, 0.0, -0.1])
    steps = program(line(corner), line(goal), zone=Zone(meters=radius, parabola=True, extended=wide))
    found = poses(snapshot, run_of(snapshot, steps), 4000)
    angles = np.array([rotation_vector(pose[:3, :3] @ at[:3, :3].T)[2] for pose in found])
    y, z = (found[:, :3, 3] - at[:3, 3])[:, 1:].T
    # Outside of the inner radius the tool is on the lines; the way s to the corner tells how much of the turn is left.
    for s, angle in [*zip(y - 0.1, angles, strict=True)][:: len(found) // 400]:
        if s < -1.25 * radius:
            left = 0.0 if s < -wide else (s + wide) ** 2 / (4.0 * wide)
            assert angle == pytest.approx(0.3 * (1.0 + (s - left) / 0.1), abs=0.01 * 0.3 * wide / 4.0 / 0.1)
    for s, angle in [*zip(-z, angles, strict=True)][:: len(found) // 400]:
        if s > 1.25 * radius:
            left = 0.0 if s > wide else -((wide - s) ** 2) / (4.0 * wide)
            assert angle == pytest.approx(0.3 * (1.0 + left / 0.1), abs=0.01 * 0.3 * wide / 4.0 / 0.1)
    assert nearest(found[:, :3, 3], corner[:3, 3]) == pytest.approx(radius * np.sqrt(2.0) / 4.0, rel=0.01)


def test_joints_of_another_robot_go_over_in_the_extended_radius(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng, "puma560", "xarm6")
    joint = snapshot.structure.robot("arm1")[1].joints[5].name
    start = float(arrived(snapshot, [], np.zeros(0)).state.q[-1])
    radius, wide, corner = 0.01, 0.03, moved(at, [0.0, 0.1, 0.0])
    goal = moved(corner, [0.0, 0.0, -0.1])
    steps = program(
        (line(corner, 0.05), PointToPoint("arm1", {joint: start + 0.2})),
        (line(goal, 0.05), PointToPoint("arm1", {joint: start + 0.1})),
        zone=Zone(meters=radius, parabola=True, extended=wide),
    )
    run = run_of(snapshot, steps)
    path = run.plan.tracks[0].path
    column = run.joints.index(("arm1", joint))
    values = path.evaluate(np.linspace(path.start, path.end, 3000))[:, column] - start
    # It goes to 0.2 rad at 2 rad/m and back at 1 rad/m; the sum of both is greatest where their rates are the same.
    s = np.linspace(-wide, wide, 2001)
    both = 0.2 - 2.0 * (wide - s) ** 2 / (4.0 * wide) - (wide + s) ** 2 / (4.0 * wide)
    assert values.max() == pytest.approx(both.max(), abs=0.01 * (0.2 - both.max()))
    points = poses(snapshot, run)[:, :3, 3]
    assert nearest(points, corner[:3, 3]) == pytest.approx(radius * np.sqrt(2.0) / 4.0, rel=0.01)


def test_next_to_a_joint_move_the_radius_is_the_distance_of_a_zone(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    names = [joint.name for joint in snapshot.structure.robot("arm0")[1].joints]
    goal = dict(zip(names, POSTURE + np.array([0.5, 0.4, 0.0, 0.0, 0.0, 0.0]), strict=True))
    moves = (line(moved(at, [0.0, 0.1, 0.0])), PointToPoint("arm0", goal))
    runs = [run_of(snapshot, program(*moves, zone=zone)) for zone in (Zone(0.05, parabola=True), Zone(0.05))]
    assert runs[0].plan.duration == runs[1].plan.duration


def test_a_step_that_comes_while_the_robot_moves_is_joined_by_the_same_parabola(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    corner = moved(at, [0.0, 0.1, 0.0])
    steps = program(line(corner), line(moved(corner, [0.0, 0.0, -0.1])), zone=Zone(meters=0.02, parabola=True))
    first, second = plan_steps(snapshot, steps, solver)
    (alone,), _ = plan_run(snapshot, [MoveStep(steps[0].moves)], solver)
    assert alone.tail is not None
    run = replace(alone, tail=replace(alone.tail, steps=(first,)))
    found = extended(run, second, 0.1, 0.1)
    assert isinstance(found, Extension) and not found.notes
    points = poses(snapshot, found.run)[:, :3, 3]
    assert nearest(points, corner[:3, 3]) == pytest.approx(0.02 * np.sqrt(2.0) / 4.0, rel=0.01)
    late = extended(run, second, alone.plan.duration - 0.05, alone.plan.duration - 0.05)
    assert isinstance(late, str) and "too near" in late


@pytest.mark.long
@pytest.mark.parametrize("name", ["puma560", "iiwa", "panda", "xarm6"])
def test_programs_of_any_moves_keep_the_limits(rng: np.random.Generator, draws: Draws, name: str) -> None:
    """Corners that no parabola fits are stops, and none takes more than twice as long as with stops."""
    for _ in range(draws(15)):
        radius = float(rng.uniform(0.003, 0.08))
        zone = Zone(radius, parabola=True, extended=radius * float(rng.uniform(0.0, 3.0)))
        snapshot, steps = random_steps(rng, name, list(rng.choice(KINDS, 3)), zone)
        runs, notes = plan_run(snapshot, steps, solver)
        assert len(runs) == 1 + sum(note.kind is NoteKind.ZONE_DROPPED for note in notes)
        assert sum(run.plan.duration for run in runs) <= 2.0 * sum(run.plan.duration for run in alone(snapshot, steps))
        joints = {joint.name: joint.limits for joint in snapshot.structure.robot("arm0")[1].joints}
        for run in runs:
            limits = [joints[joint] for _, joint in run.joints]
            check_law(
                run.plan, *(np.array([getattr(x, f) for x in limits]) for f in ("velocity", "acceleration", "jerk"))
            )


def test_a_fade_is_the_sum_of_both_and_smooth() -> None:
    for radius, room in ((0.02, 1.0), (0.02, 0.021), (0.02, 0.02), (0.02, 0.01)):
        fade = fade_within(radius, room)
        kept = min(radius, room)
        assert fade.reach <= room * (1.0 + 1e-12)
        assert fade.at(0.0)[1] == pytest.approx(kept / 4.0, rel=0.01)
        for s in np.linspace(-1.1 * fade.reach, 1.1 * fade.reach, 50).tolist():
            before, after, share = fade.at(s)
            assert before + after == pytest.approx(s) and before <= 1e-15 and after >= -1e-15
            ends = [fade.at(one) for one in (s - 1e-7, s + 1e-7)]
            assert (ends[1][1] - ends[0][1]) / 2e-7 == pytest.approx(share, abs=1e-5)
    assert [round(b - a, 9) for a, b in pairwise(fade_within(0.02, 1.0).knots)][::2] == [0.008] * 2


def test_a_corner_that_no_joints_can_make_is_a_stop(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    with pytest.raises(KernelError):
        plan_run(snapshot, [MoveStep((line(moved(at, [3.0, 0.0, 0.0])),))], solver)
    corner = moved(at, [0.0, 0.1, 0.0])
    still = MoveStep((line(corner),))
    steps = [MoveStep((line(corner),), Zone(meters=0.02, parabola=True)), still]
    _, notes = plan_run(snapshot, steps, solver)
    assert [note.kind for note in notes] == [NoteKind.ZONE_DROPPED]
