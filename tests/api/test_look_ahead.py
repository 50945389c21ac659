"""Looking ahead over TCP: what is put in the way of a motion stops it before contact, whatever the clock."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.v1 import collision_pb2, motion_pb2, scene_pb2

from tests.api.asking import IIWA, apply, box, create, ended, joints, load, start
from tests.api.moving import ABORTED, CANCELLED, RUNNING, SUCCEEDED, motion
from tests.api.reading import step
from tests.api.test_append import append, opened
from tests.api.test_program import move
from tests.kernels import Stubs

STOP, GUARD = collision_pb2.COLLISION_MODE_STOP, collision_pb2.COLLISION_MODE_GUARD


def looking(stubs: Stubs, seconds: float | None, mode: collision_pb2.CollisionMode = STOP) -> None:
    """Load an arm that is to be stopped, so many seconds ahead; None leaves it to the kernel."""
    load(stubs, IIWA, "arm")
    command = collision_pb2.SetCollisionSettings(mode=mode, look_ahead_seconds=seconds)
    apply(stubs, scene_pb2.Command(set_collision_settings=command))


def touching(stubs: Stubs) -> bool:
    return bool(stubs.collision.CheckCollision(collision_pb2.CheckCollisionRequest()).pairs)


def lean(stubs: Stubs, speed_factor: float) -> str:
    return start(stubs, joints("arm", speed_factor=speed_factor, lbr_iiwa_joint_2=1.9)).id


@pytest.mark.parametrize("mode", [STOP, GUARD])
def test_a_box_in_the_way_stops_the_motion_and_each_tick_is_free(
    stepped: Stubs, mode: collision_pb2.CollisionMode, rng: np.random.Generator
) -> None:
    """A guarded robot is stopped long before its guard would have to."""
    looking(stepped, 1.0, mode)
    id = lean(stepped, 0.1)
    step(stepped, int(rng.integers(1, 100)))
    assert motion(stepped, id).phase == RUNNING
    apply(stepped, create(box("box", x=0.5, z=0.9)))
    while motion(stepped, id).phase not in (SUCCEEDED, CANCELLED, ABORTED):
        step(stepped)
        assert not touching(stepped)
    told = motion(stepped, id)
    assert (told.phase, told.end_cause) == (ABORTED, motion_pb2.END_CAUSE_COLLISION)
    assert "'arm.lbr_iiwa_link_" in told.end_reason and "would touch 'box' in " in told.end_reason


def settings(stubs: Stubs) -> collision_pb2.CollisionSettings:
    return stubs.collision.GetCollisionSettings(collision_pb2.GetCollisionSettingsRequest()).settings


def test_who_is_to_be_stopped_stops_before_a_touch_if_nothing_else_is_said(stepped: Stubs) -> None:
    """At full speed into a box; the same again stops at once, and says so again."""
    looking(stepped, None)
    assert settings(stepped).look_ahead_seconds == 1.0
    apply(stepped, create(box("box", x=0.5, z=0.9)))
    for _ in range(2):
        id = lean(stepped, 1.0)
        while motion(stepped, id).phase not in (SUCCEEDED, CANCELLED, ABORTED):
            step(stepped, 5)
            assert not touching(stepped)
        told = motion(stepped, id)
        assert (told.phase, told.end_cause) == (ABORTED, motion_pb2.END_CAUSE_COLLISION)
        assert "would touch 'box' in " in told.end_reason


def test_a_start_tells_of_what_touches_already_since_nothing_stops_for_that(stepped: Stubs) -> None:
    looking(stepped, 0.0)
    apply(stepped, create(box("box", x=0.5, z=0.9)))
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[joints("arm", lbr_iiwa_joint_2=0.75)]),
        on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE,
    )
    first = stepped.motion.StartMotion(request)
    assert not first.notes
    step(stepped, 500)
    assert motion(stepped, first.motion.id).end_cause == motion_pb2.END_CAUSE_COLLISION and touching(stepped)
    (note, *_) = stepped.motion.StartMotion(request).notes
    assert (note.kind, note.robot) == (motion_pb2.PLAN_NOTE_KIND_TOUCHING, "arm")
    assert note.message.startswith("'arm.lbr_iiwa_link_") and "and 'box' touch already" in note.message


def test_a_box_in_the_way_stops_the_motion_while_the_clock_runs(stubs: Stubs) -> None:
    looking(stubs, 3.0)
    id = lean(stubs, 0.05)
    apply(stubs, create(box("box", x=0.5, z=0.9)))
    told = ended(stubs, id)
    assert (told.phase, told.end_cause) == (ABORTED, motion_pb2.END_CAUSE_COLLISION)
    assert "would touch 'box' in " in told.end_reason
    assert not touching(stubs)


def test_what_is_appended_is_looked_at_at_once(stepped: Stubs) -> None:
    looking(stepped, 3.0)
    apply(stepped, create(box("box", x=0.5, z=0.9)))
    to = [move(joints("arm", 0.3, lbr_iiwa_joint_2=goal), blend_percent=20.0) for goal in (0.3, 1.9)]
    id = opened(stepped, to[0])
    step(stepped, 20)
    append(stepped, id, to[1])
    step(stepped, 2)
    assert motion(stepped, id).end_cause == motion_pb2.END_CAUSE_COLLISION
