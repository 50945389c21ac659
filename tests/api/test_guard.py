"""Guarded robots over the wire: a motion that ends before a wall, refusals, what it costs."""

from __future__ import annotations

import numpy as np
from virtualrobot.v1 import collision_pb2, geometry_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal, start
from tests.api.moving import ABORTED, READY, finished, linear
from tests.api.reading import matrix, state, step
from tests.api.test_robot import put
from tests.kernels import Stubs

GUARD = collision_pb2.COLLISION_MODE_GUARD


def wall(x: float) -> nodes_pb2.Node:
    """Return a wall of 1 mm."""
    node = box("wall", x=x, z=0.5)
    node.figures[0].box.size.CopyFrom(geometry_pb2.Vector3(x=0.001, y=2.0, z=2.0))
    return node


def collisions(stubs: Stubs) -> list[collision_pb2.CollisionPair]:
    request = collision_pb2.CheckCollisionRequest(robots=["arm"])
    return list(stubs.collision.CheckCollision(request).pairs)


def test_a_guarded_arm_ends_its_line_before_a_wall(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    here = matrix(state(stepped, "arm").world_t_tcp)
    apply(stepped, create(wall(here[0, 3] + 0.12)))
    apply(stepped, scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=GUARD)))
    assert not collisions(stepped)
    goal = here.copy()
    goal[0, 3] += 0.18
    id = start(stepped, linear("arm", goal)).id
    for _ in range(20):
        step(stepped, 20)
        assert not collisions(stepped)
    ended = finished(stepped, id)
    assert (ended.phase, ended.end_cause) == (ABORTED, motion_pb2.END_CAUSE_COLLISION)
    assert "would touch 'wall' in 0." in ended.end_reason
    request = collision_pb2.MeasureDistancesRequest(first=["arm"], second=["wall"])
    (nearest,) = stepped.collision.MeasureDistances(request).pairs
    assert 0.0 < nearest.distance_meters < 0.003
    moved = matrix(state(stepped, "arm").world_t_tcp)[:3, 3] - here[:3, 3]
    np.testing.assert_allclose(moved[1:], 0.0, atol=1e-6, err_msg="it brakes on its line")
    cost = stepped.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).guard_cost
    assert cost.ticks > 10
    assert 0.0 < cost.mean_seconds <= cost.worst_seconds


def test_what_would_touch_a_guarded_robot_is_refused(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    put(stepped, "arm", READY)
    apply(stepped, scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=GUARD)))
    here = matrix(state(stepped, "arm").world_t_tcp)
    x, y, z = here[:3, 3].tolist()
    refused = refusal(lambda: apply(stepped, create(box("box", x=x, y=y, z=z))))
    assert (refused.reason, refused.metadata["second"]) == ("COLLISION", "box")
    assert refused.metadata["first"].startswith("arm.lbr_iiwa_link_")
    apply(stepped, create(box("box", x=x + 2.0, y=y, z=z)))
    names = [node.name for node in stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes]
    assert names.count("box") == 1
