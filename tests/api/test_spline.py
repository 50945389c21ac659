"""Splines of the tool centre point, looked at in each tick and under random steering; refusals of what is none."""

from __future__ import annotations

from itertools import pairwise

import grpc
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, PANDA, apply, create, joints, load, refusal, start
from tests.api.moving import READY, RUNNING, SUCCEEDED, TICK, finished, motion, spline
from tests.api.reading import matrix, pose, state, step, unchanged
from tests.api.test_motion_laws import Steering, assert_limits_are_kept
from tests.api.test_robot import drawn, forward, put, robot
from tests.kernels import Stubs


def away(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Return distance and angle between two poses."""
    turn = Rotation.from_matrix(one[:3, :3].T @ other[:3, :3]).magnitude()
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3])), float(turn)


def beside(here: np.ndarray, rng: np.random.Generator, size: float = 0.12) -> np.ndarray:
    goal = here.copy()
    goal[:3, 3] += rng.uniform(-size, size, 3)
    goal[:3, :3] = Rotation.from_rotvec(rng.normal(size=3) * 0.2).as_matrix() @ goal[:3, :3]
    return goal


def curve(stubs: Stubs, rng: np.random.Generator, arm: str) -> tuple[motion_pb2.Motion, list[np.ndarray]]:
    """Start a random spline that the arm can go; return it with the poses that it shall pass."""
    for _ in range(100):
        put(stubs, arm, drawn(stubs, arm, rng))
        first = matrix(state(stubs, arm).world_t_tcp)
        goals = [beside(first, rng) for _ in range(4)]
        try:
            return start(stubs, spline(arm, *goals, max_velocity_meters_per_second=0.2)), goals
        except grpc.RpcError:
            continue
    raise AssertionError("no spline in 100 could be gone")


@pytest.mark.parametrize("uri", [IIWA, PANDA])
def test_a_spline_passes_its_poses_in_order_and_keeps_its_speed(
    stepped: Stubs, rng: np.random.Generator, uri: str
) -> None:
    """Between two ticks it goes 0.8 mm at most, so that one of them is within half of that of each pose."""
    load(stepped, uri, "arm")
    ask, goals = curve(stepped, rng, "arm")
    seen = [matrix(state(stepped, "arm").world_t_tcp)]
    while motion(stepped, ask.id).phase == RUNNING:
        seen.append(matrix(step(stepped).robots[0].world_t_tcp))
    steps = [away(one, other) for one, other in pairwise(seen)]
    assert max(way for way, _ in steps) <= 0.2 * TICK * (1.0 + 1e-6)
    velocity = np.diff([one[:3, 3] for one in seen], axis=0) / TICK
    assert np.linalg.norm(np.diff(velocity, axis=0), axis=1).max() / TICK <= 1.0 * 1.01
    turn = max(angle for _, angle in steps)
    passed = []
    for goal in goals:
        distances = [away(one, goal) for one in seen]
        nearest = int(np.argmin([way + angle for way, angle in distances]))
        assert distances[nearest][0] <= 0.1 * TICK + 1e-6
        assert distances[nearest][1] <= 0.5 * turn + 1e-6
        passed.append(nearest)
    assert passed == sorted(passed)
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), goals[-1], atol=1e-8)


def test_a_steered_spline_keeps_the_limits_and_comes_no_other_way(stepped: Stubs, rng: np.random.Generator) -> None:
    """What is steered goes where what was not went: each place is near one of those."""
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    first = matrix(state(stepped, "arm").world_t_tcp)
    goals = [beside(first, rng, 0.06) for _ in range(4)]
    ask = start(stepped, spline("arm", *goals))
    way = []
    while motion(stepped, ask.id).phase == RUNNING:
        way.append(matrix(step(stepped).robots[0].world_t_tcp)[:3, 3])
    put(stepped, "arm", READY)
    now = np.array(state(stepped, "arm").positions)
    ask = start(stepped, spline("arm", *goals))
    positions, velocities = Steering(stepped, rng, ask.id).rows()
    assert_limits_are_kept(stepped, now, positions, velocities)
    names = [joint.name for joint in robot(stepped, "arm").joints]
    for row in positions[::25]:
        place = matrix(forward(stepped, "arm", dict(zip(names, row.tolist(), strict=True))).world_t_tcp)[:3, 3]
        # Half of 0.25 m/s in a tick, and what a curve is off its chord there: less than v² / a / 8.
        assert np.linalg.norm(way - place, axis=1).min() <= 0.5 * 0.25 * TICK + 1e-4


def test_each_pose_may_be_in_the_frame_of_another_node(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    load(stepped, PANDA, "other")
    put(stepped, "arm", READY)
    table = np.eye(4)
    table[:3, 3], table[:3, :3] = rng.uniform(-1, 1, 3), Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    apply(stepped, create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=pose(table))))
    first = matrix(state(stepped, "arm").world_t_tcp)
    there, here = beside(first, rng, 0.05), beside(first, rng, 0.05)
    seen = np.linalg.inv(table) @ there
    together = start(stepped, spline("arm", here, seen, reference=("", "table")), joints("other", panda_joint1=0.1))
    assert finished(stepped, together.id).phase == SUCCEEDED
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), there, atol=1e-8)
    assert state(stepped, "other").positions[0] == pytest.approx(0.1)


def test_splines_that_are_none_are_refused_by_the_goal(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    here = matrix(state(stepped, "arm").world_t_tcp)
    poses = [here.copy() for _ in range(3)]
    for number, one in enumerate(poses):
        one[1, 3] += 0.05 * (number + 1)
    far = here.copy()
    far[0, 3] += 3.0
    named = spline("arm", *poses)
    named.spline.goals[1].configuration = "right up noflip"
    nowhere = spline("arm", *poses)
    nowhere.spline.goals[2].ClearField("reference_t_tcp")
    nan = spline("arm", *poses)
    nan.spline.goals[0].reference_t_tcp.position.x = float("nan")
    many = motion_pb2.Move(robot="arm", spline=motion_pb2.Spline(goals=list(named.spline.goals[:1]) * 1001))
    cases = [
        (motion_pb2.Move(robot="arm", spline=motion_pb2.Spline()), "INVALID_ARGUMENT", "1 to 1000 poses, not 0"),
        (many, "INVALID_ARGUMENT", "1 to 1000 poses, not 1001"),
        (spline("arm", poses[0], poses[0]), "INVALID_ARGUMENT", "goals[1] of a spline is the same pose as goals[0]"),
        (spline("arm", here, poses[0]), "INVALID_ARGUMENT", "goals[0] of a spline is the same pose as the start"),
        (named, "INVALID_ARGUMENT", "goals[1].configuration"),
        (nowhere, "INVALID_ARGUMENT", "goals[2].reference_t_tcp is missing"),
        (nan, "INVALID_ARGUMENT", "goals[0].reference_t_tcp.position"),
        (spline("arm", *poses, reference=("", "tabel", "")), "UNKNOWN_NAME", "tabel"),
        (spline("arm", *poses, max_velocity_meters_per_second=-1.0), "INVALID_ARGUMENT", "max_velocity"),
        (spline("arm", *poses, far), "UNREACHABLE", "nearest to goals"),
    ]
    with unchanged(stepped):
        for move, reason, words in cases:
            refused = refusal(lambda move=move: start(stepped, move))
            assert refused.reason == reason, (move, refused)
            assert words in refused.message, refused.message
        assert refused.metadata["goal"] in ("2", "3")
