"""Arcs in frames of nodes and beside other moves; refusals of what is no arc."""

from __future__ import annotations

from math import pi, tau

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, PANDA, apply, create, joints, load, refusal, start
from tests.api.moving import READY, SUCCEEDED, about, circular, finished
from tests.api.reading import matrix, pose, state, unchanged
from tests.api.test_robot import put
from tests.kernels import Stubs


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
