"""The paths of motions, looked at in each tick; refusals of paths that cannot be gone."""

from __future__ import annotations

import grpc
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, PANDA, apply, create, load, refusal, start
from tests.api.moving import READY, RUNNING, SUCCEEDED, TICK, finished, linear, motion, to_pose, trajectory
from tests.api.reading import matrix, pose, state, step, unchanged
from tests.api.test_robot import drawn, forward, put, robot
from tests.api.test_scene import update
from tests.kernels import Stubs


def test_goals_by_pose_reference_and_posture(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    home = nodes_pb2.NamedPosture(name="home", joint_positions=READY)
    table = np.eye(4)
    table[:3, 3] = rng.uniform(-1, 1, 3)
    apply(
        stepped,
        update("arm", "robot", robot=nodes_pb2.Robot(postures=[home])),
        create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=pose(table))),
    )
    posture = motion_pb2.PointToPoint(posture="home")
    finished(stepped, start(stepped, motion_pb2.Move(robot="arm", point_to_point=posture)).id)
    assert np.allclose(state(stepped, "arm").positions, list(READY.values()), atol=1e-12)
    goal = matrix(forward(stepped, "arm", drawn(stepped, "arm", rng)).world_t_tcp)
    finished(stepped, start(stepped, to_pose("arm", np.linalg.inv(table) @ goal, "table")).id)
    off = np.linalg.inv(goal) @ matrix(state(stepped, "arm").world_t_tcp)
    assert np.abs(off - np.eye(4)).max() < 1e-3


def lines(stubs: Stubs, rng: np.random.Generator, arm: str) -> tuple[motion_pb2.Motion, np.ndarray, np.ndarray]:
    """Start a random line that the arm can go; return it with its first and last pose."""
    for _ in range(60):
        here = drawn(stubs, arm, rng)
        put(stubs, arm, here)
        limits = {joint.name: joint.limits for joint in robot(stubs, arm).joints}
        near = {
            n: float(np.clip(v + rng.uniform(-0.4, 0.4), limits[n].lower, limits[n].upper)) for n, v in here.items()
        }
        first = matrix(state(stubs, arm).world_t_tcp)
        goal = matrix(forward(stubs, arm, near).world_t_tcp)
        try:
            return start(stubs, linear(arm, goal)), first, goal
        except grpc.RpcError:
            continue
    raise AssertionError("no line in 60 could be gone")


@pytest.mark.long
@pytest.mark.parametrize("uri", [IIWA, PANDA])
def test_a_line_is_straight_and_turns_evenly_at_each_tick(stepped: Stubs, rng: np.random.Generator, uri: str) -> None:
    """Slerp is scipy's."""
    load(stepped, uri, "arm")
    for _ in range(2):
        ask, first, goal = lines(stepped, rng, "arm")
        way = goal[:3, 3] - first[:3, 3]
        turn = Rotation.from_matrix(first[:3, :3].T @ goal[:3, :3]).as_rotvec()
        shares = [0.0]
        while motion(stepped, ask.id).phase == RUNNING:
            now = matrix(step(stepped).robots[0].world_t_tcp)
            share = (now[:3, 3] - first[:3, 3]) @ way / (way @ way)
            assert np.linalg.norm(first[:3, 3] + share * way - now[:3, 3]) < 1e-5
            even = first[:3, :3] @ Rotation.from_rotvec(share * turn).as_matrix()
            assert Rotation.from_matrix(even.T @ now[:3, :3]).magnitude() < 1e-3
            shares.append(float(share))
        assert np.all(np.diff(shares) > -1e-9)
        assert shares[-1] == pytest.approx(1.0, abs=1e-6)


def test_lines_that_cannot_be_gone_are_refused_with_the_place(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    stretched = matrix(state(stepped, "arm").world_t_tcp)
    stretched[2, 3] -= 0.1  # the wrist can come down, but not straight down at once
    with unchanged(stepped):
        singular = refusal(lambda: start(stepped, linear("arm", stretched)))
        assert (singular.code, singular.reason) == (grpc.StatusCode.OUT_OF_RANGE, "SINGULARITY")
    put(stepped, "arm", {**READY, "lbr_iiwa_joint_7": 3.0})
    here = matrix(state(stepped, "arm").world_t_tcp)
    far, turned = here.copy(), here.copy()
    far[0, 3] += 1.0
    turned[:3, :3] = here[:3, :3] @ Rotation.from_rotvec([0, 0, 0.8]).as_matrix()
    with unchanged(stepped):
        unreachable = refusal(lambda: start(stepped, linear("arm", far)))
        assert (unreachable.code, unreachable.reason) == (grpc.StatusCode.OUT_OF_RANGE, "UNREACHABLE")
        limit = refusal(lambda: start(stepped, linear("arm", turned)))
        assert (limit.code, limit.reason) == (grpc.StatusCode.OUT_OF_RANGE, "LIMIT_EXCEEDED")
    assert limit.metadata["joint"] == "lbr_iiwa_joint_7"
    for refused in (singular, unreachable, limit):
        assert 0.0 <= float(refused.metadata["fraction"]) <= 1.0, refused
    assert refusal(lambda: start(stepped, to_pose("arm", far))).reason == "UNREACHABLE"


def test_a_trajectory_passes_its_samples_on_time(stepped: Stubs, rng: np.random.Generator) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    names = ["lbr_iiwa_joint_4", "lbr_iiwa_joint_2"]
    ticks = np.cumsum([0, *rng.integers(60, 120, 5)])
    positions = np.array([READY[name] for name in names]) + np.cumsum(rng.uniform(-0.08, 0.08, (6, 2)), axis=0)
    positions[0] = [READY[name] for name in names]
    ask = start(stepped, trajectory("arm", names, ticks * TICK, positions))
    assert ask.planned_duration_seconds == pytest.approx(ticks[-1] * TICK)
    order = [joint.name for joint in robot(stepped, "arm").joints]
    for length, row in zip(np.diff(ticks).tolist(), positions[1:], strict=True):
        now = step(stepped, length).robots[0]
        assert np.abs([now.positions[order.index(name)] for name in names] - row).max() < 1e-9
    assert motion(stepped, ask.id).phase == SUCCEEDED
