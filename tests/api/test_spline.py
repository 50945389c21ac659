"""Splines of the tool centre point in frames of several nodes; refusals of what is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, PANDA, apply, create, joints, load, refusal, start
from tests.api.moving import READY, SUCCEEDED, finished, spline
from tests.api.reading import matrix, pose, state, unchanged
from tests.api.test_robot import put
from tests.kernels import Stubs


def beside(here: np.ndarray, rng: np.random.Generator, size: float = 0.12) -> np.ndarray:
    goal = here.copy()
    goal[:3, 3] += rng.uniform(-size, size, 3)
    goal[:3, :3] = Rotation.from_rotvec(rng.normal(size=3) * 0.2).as_matrix() @ goal[:3, :3]
    return goal


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
