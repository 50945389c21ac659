"""Speed of the tool centre point on joint moves, and the least duration of a step, against samples of the plan."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.moves import JointTrajectory, Linear, PointToPoint
from virtualrobot_kernel.planning.notes import NoteKind
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MoveStep, Zone
from virtualrobot_kernel.planning.robots import tcp_frame
from virtualrobot_kernel.planning.steps import arrived, plan_steps
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_sdk.poses import rotation_vector

from tests.unit.planning.runs import plan_run, solver
from tests.unit.planning.test_parabola import POSTURE, cell, moved

WAY = np.array([1.2, -0.5, 0.6, 0.4, -0.8, 0.5])


def to(snapshot: Snapshot, way: np.ndarray, **options: float) -> PointToPoint:
    """Return the joint move by a way from the posture."""
    names = [joint.name for joint in snapshot.structure.robot("arm0")[1].joints]
    return PointToPoint("arm0", dict(zip(names, (POSTURE + way).tolist(), strict=True)), **options)  # pyright: ignore[reportArgumentType]


def rates(snapshot: Snapshot, move: PointToPoint) -> tuple[float, float, float]:
    """Return the greatest speed and angular velocity of the tool on a move, and its duration."""
    (run,), _ = plan_run(snapshot, [MoveStep((move,))], solver)
    times = np.linspace(0.0, run.plan.duration, 4001)
    found = []
    node = snapshot.structure.node("arm0", Kind.ROBOT)
    for q in run.plan.at(times)[0]:
        found.append(tcp_frame(arrived(snapshot, run.joints, q), node).copy())
    places = np.array(found)
    step = times[1]
    turns = [np.linalg.norm(rotation_vector(b[:3, :3] @ a[:3, :3].T)) for a, b in pairwise(places)]
    speed = np.linalg.norm(np.diff(places[:, :3, 3], axis=0), axis=1).max() / step
    return float(speed), max(turns) / step, run.plan.duration


def test_a_joint_move_keeps_the_speed_of_the_tool_and_reaches_it(rng: np.random.Generator) -> None:
    snapshot, _ = cell(rng)
    free = rates(snapshot, to(snapshot, WAY))
    speed, turning, duration = rates(snapshot, to(snapshot, WAY, max_velocity=0.2))
    assert free[0] > 0.3 and duration > free[2]
    assert speed == pytest.approx(0.2, rel=2e-3) and speed < 0.2 * (1.0 + 1e-3)
    _, turning, _ = rates(snapshot, to(snapshot, WAY, max_angular_velocity=0.3))
    assert turning == pytest.approx(0.3, rel=2e-3)
    slow, _, _ = rates(snapshot, to(snapshot, WAY, max_velocity=0.2, speed_factor=0.5))
    assert slow == pytest.approx(0.1, rel=2e-3)
    assert rates(snapshot, to(snapshot, WAY, max_velocity=40.0, max_angular_velocity=100.0)) == free
    (still,), _ = plan_run(snapshot, [MoveStep((to(snapshot, 0.0 * WAY, max_velocity=0.2),))], solver)
    assert still.plan.duration == 0.0


@pytest.mark.parametrize("seconds", [0.01, 3.0, 17.5])
def test_a_step_takes_its_least_duration_exactly_where_limits_let_it_be_faster(
    rng: np.random.Generator, seconds: float
) -> None:
    snapshot, at = cell(rng)
    for move in (to(snapshot, WAY), Linear("arm0", PoseGoal(moved(at, [0.0, 0.1, 0.0])), max_velocity=5.0)):
        free, timed = (plan_steps(snapshot, [MoveStep((move,), min_duration=one)], solver)[0] for one in (0.0, seconds))
        assert timed.plan.duration == max(seconds, free.plan.duration)
        share = timed.plan.duration / free.plan.duration
        times = np.linspace(0.0, free.plan.duration, 50)
        np.testing.assert_allclose(timed.plan.at(share * times)[0], free.plan.at(times)[0], atol=1e-9)


def test_a_step_with_a_least_duration_is_joined_to_no_other_which_a_note_tells(rng: np.random.Generator) -> None:
    snapshot, at = cell(rng)
    corner = moved(at, [0.0, 0.1, 0.0])
    first, second = (Linear("arm0", PoseGoal(pose)) for pose in (corner, moved(corner, [0.0, 0.0, -0.1])))
    for durations in ((2.0, 0.0), (0.0, 2.0)):
        steps = [MoveStep((first,), Zone(meters=0.02), durations[0]), MoveStep((second,), None, durations[1])]
        runs, (note,) = plan_run(snapshot, steps, solver)
        assert len(runs) == 2 and note.kind is NoteKind.ZONE_DROPPED and "has a duration of its own" in note.message
        assert 2.0 in [run.plan.duration for run in runs]


def test_a_trajectory_has_its_own_times(rng: np.random.Generator) -> None:
    snapshot, _ = cell(rng)
    names = tuple(joint.name for joint in snapshot.structure.robot("arm0")[1].joints)
    rows = np.array([POSTURE, POSTURE + 0.01])
    trajectory = JointTrajectory("arm0", names, np.array([0.0, 1.0]), rows)
    with pytest.raises(KernelError, match="step 0: a joint trajectory has a time of its own"):
        plan_steps(snapshot, [MoveStep((trajectory,), min_duration=9.0)], solver)
