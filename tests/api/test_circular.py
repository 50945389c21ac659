"""Arcs of the tool centre point, looked at in each tick and under random steering; refusals of what is no arc."""

from __future__ import annotations

from math import pi, tau

import grpc
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, PANDA, apply, create, joints, load, refusal, start
from tests.api.moving import READY, RUNNING, SUCCEEDED, TICK, about, circular, finished, motion
from tests.api.reading import matrix, pose, state, step, unchanged
from tests.api.test_motion_laws import Steering, assert_limits_are_kept
from tests.api.test_robot import drawn, forward, put, robot
from tests.kernels import Stubs

Circle = tuple[np.ndarray, float, np.ndarray]


def circle_through(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> Circle:
    """Return centre, radius and unit normal: the point of the plane that is equally far from three points (3,)."""
    normal = np.cross(b - a, c - a)
    right = np.array([b @ b - a @ a, c @ c - a @ a, 2.0 * normal @ a]) / 2.0
    center = np.linalg.solve(np.array([b - a, c - a, normal]), right)
    return center, float(np.linalg.norm(a - center)), normal / np.linalg.norm(normal)


def distance(point: np.ndarray, circle: Circle) -> float:
    center, radius, normal = circle
    height = (point - center) @ normal
    return float(np.hypot(np.linalg.norm(point - center - height * normal) - radius, height))


def turned(point: np.ndarray, first: np.ndarray, circle: Circle) -> float:
    """Return the angle in [0, 2 pi) by which a point is turned from the first one, by the right hand."""
    center, _, normal = circle
    one, other = first - center, point - center
    return float(np.arctan2(np.cross(one, other) @ normal, one @ other)) % tau


def arcs(
    stubs: Stubs, rng: np.random.Generator, arm: str
) -> tuple[motion_pb2.Motion, np.ndarray, np.ndarray, np.ndarray]:
    """Start a random arc that the arm can go; return it with its first and last pose and the via point."""
    for _ in range(100):
        here = drawn(stubs, arm, rng)
        put(stubs, arm, here)
        first = matrix(state(stubs, arm).world_t_tcp)
        goal = first.copy()
        goal[:3, 3] += rng.uniform(-0.15, 0.15, 3)
        goal[:3, :3] = Rotation.from_rotvec(rng.normal(size=3) * 0.3).as_matrix() @ goal[:3, :3]
        via = first[:3, 3] + rng.uniform(-0.15, 0.15, 3)
        try:
            return start(stubs, circular(arm, goal, via, max_velocity_meters_per_second=0.5)), first, goal, via
        except grpc.RpcError:
            continue
    raise AssertionError("no arc in 100 could be gone")


@pytest.mark.parametrize("uri", [IIWA, PANDA])
def test_an_arc_is_round_and_turns_evenly_at_each_tick(stepped: Stubs, rng: np.random.Generator, uri: str) -> None:
    """The circle by a linear system, slerp is scipy's. 0.01 mm and 0.001 rad is what the kernel promises."""
    load(stepped, uri, "arm")
    ask, first, goal, via = arcs(stepped, rng, "arm")
    circle = circle_through(first[:3, 3], via, goal[:3, 3])
    whole = turned(goal[:3, 3], first[:3, 3], circle)
    turn = Rotation.from_matrix(goal[:3, :3] @ first[:3, :3].T).as_rotvec()
    shares, nearest, steps, before = [0.0], np.inf, 0.0, first
    while motion(stepped, ask.id).phase == RUNNING:
        now = matrix(step(stepped).robots[0].world_t_tcp)
        assert distance(now[:3, 3], circle) < 1e-5
        # A share of a little below 0 is one of a whole turn; nothing else of an arc is near that.
        share = turned(now[:3, 3], first[:3, 3], circle) / whole
        share = 0.0 if share > 1.0 + 1e-3 else share
        even = Rotation.from_rotvec(share * turn).as_matrix() @ first[:3, :3]
        assert Rotation.from_matrix(even.T @ now[:3, :3]).magnitude() < 1e-3
        nearest = min(nearest, float(np.linalg.norm(now[:3, 3] - via)))
        steps = max(steps, float(np.linalg.norm(now[:3, 3] - before[:3, 3])))
        shares.append(share)
        before = now
    assert np.all(np.diff(shares) > -1e-6)
    assert shares[-1] == pytest.approx(1.0, abs=1e-6)
    assert nearest <= 0.5 * steps + 1e-5, "the via point is passed between two ticks"
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), goal, atol=1e-8)


def test_a_steered_arc_stays_on_its_circle(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", {name: value + float(rng.uniform(-0.1, 0.1)) for name, value in READY.items()})
    first = matrix(state(stepped, "arm").world_t_tcp)
    center, axis = first[:3, 3] + rng.uniform(-0.03, 0.03, 3), rng.normal(size=3)
    center -= (center - first[:3, 3]) @ axis / (axis @ axis) * axis
    ask = start(stepped, circular("arm", center=about(center, axis, 1.5 * tau)))
    now = np.array(state(stepped, "arm").positions)
    positions, velocities = Steering(stepped, rng, ask.id).rows()
    assert_limits_are_kept(stepped, now, positions, velocities)
    names = [joint.name for joint in robot(stepped, "arm").joints]
    circle = (center, float(np.linalg.norm(first[:3, 3] - center)), axis / np.linalg.norm(axis))
    for row in positions[::7]:
        tcp = matrix(forward(stepped, "arm", dict(zip(names, row.tolist(), strict=True))).world_t_tcp)
        assert distance(tcp[:3, 3], circle) < 1e-5
        assert Rotation.from_matrix(first[:3, :3].T @ tcp[:3, :3]).magnitude() < 1e-3, "it keeps its orientation"


def test_an_arc_in_the_frame_of_a_table_whose_tool_turns_with_it(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    table = np.eye(4)
    table[:3, 3], table[:3, :3] = rng.uniform(-1, 1, 3), Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    apply(stepped, create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=pose(table))))
    first = matrix(state(stepped, "arm").world_t_tcp)
    table_t_world = np.linalg.inv(table)
    center, axis = first[:3, 3] + (0.0, 0.1, 0.0), np.array([0.0, 0.0, -1.0])
    seen_center = (table_t_world @ [*center, 1.0])[:3]
    seen = about(seen_center, table_t_world[:3, :3] @ axis, 0.7)
    with_arc = motion_pb2.ARC_ORIENTATION_WITH_ARC
    ask = start(stepped, circular("arm", center=seen, reference="table", orientation=with_arc))
    assert finished(stepped, ask.id).phase == SUCCEEDED
    disc = np.eye(4)
    disc[:3, :3] = Rotation.from_rotvec(0.7 * axis).as_matrix()
    disc[:3, 3] = center - disc[:3, :3] @ center
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), disc @ first, atol=1e-8)
    back = start(stepped, circular("arm", table_t_world @ first, center=about(seen_center), reference="table"))
    assert finished(stepped, back.id).phase == SUCCEEDED
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), first, atol=1e-8)


def test_an_arc_keeps_its_speed_and_its_acceleration_in_space(stepped: Stubs) -> None:
    """0.2 m/s on 0.1 m is 0.4 m/s² to the centre, of 0.5 m/s² in all."""
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    first = matrix(state(stepped, "arm").world_t_tcp)
    center = first[:3, 3] - (0.1, 0.0, 0.0)
    whole = circular("arm", center=about(center, [0, 0, 1], tau))
    whole.circular.max_velocity_meters_per_second = 0.2
    whole.circular.max_acceleration_meters_per_second_squared = 0.5
    ask = start(stepped, whole)
    places = [first[:3, 3]]
    while motion(stepped, ask.id).phase == RUNNING:
        places.append(matrix(step(stepped).robots[0].world_t_tcp)[:3, 3])
    velocity = np.diff(places, axis=0) / TICK
    assert np.linalg.norm(velocity, axis=1).max() == pytest.approx(0.2, rel=1e-3), "reached, and never exceeded"
    assert np.linalg.norm(np.diff(velocity, axis=0), axis=1).max() / TICK <= 0.5 * 1.01


def test_arcs_move_together_with_other_moves_and_are_slowed_by_their_factor(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    load(stepped, PANDA, "other")
    put(stepped, "arm", READY)
    first = matrix(state(stepped, "arm").world_t_tcp)
    whole = circular("arm", center=about(first[:3, 3] - (0.05, 0.0, 0.0), [0, 0, 1], tau))
    together = start(stepped, whole, joints("other", panda_joint1=0.1))
    assert finished(stepped, together.id).phase == SUCCEEDED
    np.testing.assert_allclose(matrix(state(stepped, "arm").world_t_tcp), first, atol=1e-8)
    assert state(stepped, "other").positions[0] == pytest.approx(0.1)
    whole.speed_factor = 0.25
    slow = start(stepped, whole)
    assert slow.planned_duration_seconds > 2.5 * together.planned_duration_seconds


def test_arcs_that_cannot_be_gone_are_refused_with_place_or_amount(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", {**READY, "lbr_iiwa_joint_7": 2.8})
    here = matrix(state(stepped, "arm").world_t_tcp)
    start_point, side = here[:3, 3], here.copy()
    side[1, 3] += 0.2
    middle = 0.5 * (start_point + side[:3, 3])
    x, y, z = np.eye(3)
    with_arc = motion_pb2.ARC_ORIENTATION_WITH_ARC
    cases = {
        "UNREACHABLE": [circular("arm", side, middle + 1.5 * x)],
        "LIMIT_EXCEEDED": [circular("arm", center=about(middle, z, -pi), orientation=with_arc)],
        "INVALID_ARGUMENT": [
            circular("arm", side, middle),
            circular("arm", side, middle + 4e-6 * z),
            circular("arm", side, start_point),
            circular("arm", side, side[:3, 3]),
            circular("arm", here, middle + 0.1 * z),
            circular("arm", here, center=about(middle, z)),
            circular("arm", side, center=about(middle)),
            circular("arm", side, center=about(start_point + 0.05 * y, z)),
            circular("arm", center=about(middle, z, 0.0)),
            circular("arm", center=about(middle, z, 1000.0)),
            circular("arm", center=about(middle, 0.0 * z, 1.0)),
            circular("arm", center=about(middle, z + y, 1.0)),
            circular("arm", center=about(start_point, z, 1.0)),
        ],
    }
    with unchanged(stepped):
        for reason, moves in cases.items():
            for move in moves:
                refused = refusal(lambda move=move: start(stepped, move))
                assert refused.reason == reason, (move, refused)
                if reason == "INVALID_ARGUMENT":
                    assert any(unit in refused.message for unit in (" mm", " rad", "length above 0")), refused.message
                else:
                    assert 0.0 <= float(refused.metadata["fraction"]) <= 1.0, refused
                    assert "of the arc" in refused.message
        twice = refusal(lambda: start(stepped, circular("arm", side, center=about(start_point + 0.05 * y, z))))
        assert float(twice.metadata["start_distance_meters"]) == pytest.approx(0.05)
        assert float(twice.metadata["goal_distance_meters"]) == pytest.approx(0.15)


def test_an_arc_that_starts_in_a_singularity_is_refused(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    stretched = matrix(state(stepped, "arm").world_t_tcp)
    with unchanged(stepped):
        center = about(stretched[:3, 3] - (0.0, 0.0, 0.1), [1, 0, 0], 0.5)
        singular = refusal(lambda: start(stepped, circular("arm", center=center)))
    assert (singular.code, singular.reason) == (grpc.StatusCode.OUT_OF_RANGE, "SINGULARITY")
    assert singular.metadata["fraction"] == "0.000000"
