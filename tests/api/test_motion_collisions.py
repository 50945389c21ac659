"""CheckMotion tells collisions over TCP: what the world then does tick by tick, what is left out, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, motion_pb2, nodes_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, start
from tests.api.moving import TICK
from tests.api.reading import matrix, state, step
from tests.kernels import Stubs

LEAN = {"lbr_iiwa_joint_2": 1.2}
COLLISION = motion_pb2.VIOLATION_KIND_COLLISION


def checked(stubs: Stubs, *moves: motion_pb2.Move, **options: object) -> motion_pb2.CheckMotionResponse:
    spec = motion_pb2.MotionSpec(moves=moves)
    return stubs.motion.CheckMotion(motion_pb2.CheckMotionRequest(spec=spec, **options))  # pyright: ignore[reportArgumentType]


def touching(stubs: Stubs) -> set[tuple[str, str]]:
    pairs = stubs.collision.CheckCollision(collision_pb2.CheckCollisionRequest()).pairs
    return {(pair.first, pair.second) for pair in pairs}


def test_the_world_touches_when_and_where_it_was_told(stepped: Stubs) -> None:
    """The motion is run: free in the tick before the time, touching in the tick after it, the same pair."""
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("box", x=0.6, z=0.9)))
    move = joints("arm", **LEAN)
    found = checked(stepped, move)
    told = found.first_violation
    assert (told.kind, told.robot, told.second) == (COLLISION, "arm", "box")
    assert told.first.startswith("arm.lbr_iiwa_link_") and found.duration_seconds > told.time_seconds > 0.0
    assert 0.0 <= told.value < told.limit == 0.0001
    points = (told.first_point, told.second_point)
    one, other = (np.array([point.x, point.y, point.z]) for point in points)
    assert np.linalg.norm(one - other) == pytest.approx(told.value, abs=1e-9)
    assert np.abs(other - [0.6, 0.0, 0.9]).max() == pytest.approx(0.05, abs=1e-6), "on the box"
    start(stepped, move)
    before = int(told.time_seconds / TICK)
    step(stepped, before)
    assert not touching(stepped)
    there = [matrix(state(stepped, "arm").world_t_tcp)]
    step(stepped)
    there.append(matrix(state(stepped, "arm").world_t_tcp))
    share = told.time_seconds / TICK - before
    np.testing.assert_allclose(matrix(told.world_t_tcp), there[0] + share * (there[1] - there[0]), atol=1e-4)
    step(stepped)
    assert (told.first, told.second) in touching(stepped)


def test_collisions_can_be_left_out_or_allowed(stubs: Stubs) -> None:
    load(stubs, IIWA, "arm")
    apply(stubs, create(box("box", x=0.6, z=0.9)))
    move = joints("arm", **LEAN)
    assert not checked(stubs, move, ignore_collisions=True).HasField("first_violation")
    while checked(stubs, move).HasField("first_violation"):
        told = checked(stubs, move).first_violation
        assert told.second == "box"
        pair = nodes_pb2.NodePair(first=told.first, second="box")
        apply(stubs, scene_pb2.Command(set_allowed_pairs=collision_pb2.SetAllowedPairs(allow=[pair])))


@pytest.mark.parametrize("resolution", [-1.0, 1e-7, 0.2, np.inf, np.nan])
def test_resolutions_without_sense_are_refused(stubs: Stubs, resolution: float) -> None:
    load(stubs, IIWA, "arm")
    refused = refusal(lambda: checked(stubs, joints("arm", **LEAN), resolution_meters=resolution))
    assert refused.reason == "INVALID_ARGUMENT" and "resolution_meters" in refused.message
