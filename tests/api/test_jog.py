"""Jogs: as far as they go, in whose axes they are given, released keys, and refusals; time goes on by steps."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import motion_pb2, nodes_pb2

from tests.api.asking import IIWA, apply, create, load, refusal, start
from tests.api.moving import CANCELLED, READY, RUNNING, SUCCEEDED, finished, jog, joint_jog, motion
from tests.api.reading import matrix, pose, random_matrix, state, step, unchanged, values
from tests.api.test_robot import put, robot
from tests.kernels import Stubs

BASE, TOOL, NODE = motion_pb2.JOG_FRAME_BASE, motion_pb2.JOG_FRAME_TOOL, motion_pb2.JOG_FRAME_NODE
FIRST = "lbr_iiwa_joint_1"
#: Of the iiwa's first joint, as its URDF has it.
LIMIT = 2.96705972839


def started(stubs: Stubs, move: motion_pb2.Move) -> motion_pb2.StartMotionResponse:
    """Start a motion that goes on without a watch; return all that is answered."""
    leave = motion_pb2.DISCONNECT_POLICY_CONTINUE
    return stubs.motion.StartMotion(
        motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[move]), on_disconnect=leave)
    )


@pytest.fixture
def ready(stepped: Stubs) -> Stubs:
    """Return stubs to a kernel whose only robot, turned and shifted, stands away from limits and singularities."""
    load(stepped, IIWA, "arm")
    apply(stepped, create(nodes_pb2.Node(name="nothing", object=nodes_pb2.SceneObject())))
    put(stepped, "arm", READY)
    return stepped


def test_a_joint_goes_to_its_limit_and_is_refused_there(ready: Stubs) -> None:
    others = list(state(ready, "arm").positions)[1:]
    motion_id = start(ready, joint_jog("arm", FIRST, -0.9)).id
    fastest = 0.0
    while motion(ready, motion_id).phase == RUNNING:
        fastest = max(fastest, -step(ready).robots[0].velocities[0])
    assert fastest == pytest.approx(0.9, rel=1e-6)
    assert list(state(ready, "arm").positions) == [pytest.approx(-LIMIT, abs=1e-9), *others]
    with unchanged(ready):
        refused = refusal(lambda: start(ready, joint_jog("arm", FIRST, -0.1)))
    assert refused.reason == "LIMIT_EXCEEDED"
    assert "the jog cannot move, it is at its end" in refused.message
    answer = started(ready, joint_jog("arm", FIRST, 0.5, 0.25))
    assert not answer.notes
    assert finished(ready, answer.motion.id).phase == SUCCEEDED
    assert state(ready, "arm").positions[0] == pytest.approx(-LIMIT + 0.25, abs=1e-9)
    far = started(ready, joint_jog("arm", FIRST, 0.9, 20.0))
    (note,) = far.notes
    assert (note.kind, note.robot, note.wanted) == (motion_pb2.PLAN_NOTE_KIND_JOG_ENDS, "arm", 20.0)
    assert note.kept == pytest.approx(2.0 * LIMIT - 0.25)
    assert f"'{FIRST}' reaches its upper limit" in note.message


def test_a_key_that_is_released_stops_the_joint_soon(ready: Stubs) -> None:
    """From 0.5 rad/s a smooth stop takes less than half a second; the limit would be seconds away."""
    ask = start(ready, joint_jog("arm", FIRST, 0.5))
    step(ready, 300)
    before = state(ready, "arm").positions[0]
    ready.motion.CancelMotion(motion_pb2.CancelMotionRequest(id=ask.id, reason="released"))
    assert finished(ready, ask.id).phase == CANCELLED
    gone = state(ready, "arm").positions[0] - before
    assert 0.0 < gone < 0.5 * 0.5


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("frame", [BASE, TOOL, NODE])
def test_a_direction_is_in_the_axes_that_are_named(
    ready: Stubs, frame: motion_pb2.JogFrame, turns: bool, rng: np.random.Generator
) -> None:
    """The TCP by forward kinematics before and after; the axes from the scene's own poses."""
    place = random_matrix(rng)
    apply(ready, create(nodes_pb2.Node(name="table", object=nodes_pb2.SceneObject(), parent_t_node=pose(place))))
    first = matrix(state(ready, "arm").world_t_tcp)
    axes = {BASE: np.eye(3), TOOL: first[:3, :3], NODE: place[:3, :3]}[frame]
    direction = rng.normal(size=3)
    unit = axes @ direction / np.linalg.norm(direction)
    node = "table" if frame == NODE else ""
    ways: dict[str, object] = {"rotation" if turns else "translation": direction}
    ask = start(ready, jog("arm", **ways, frame=frame, node=node, distance=0.03))
    assert finished(ready, ask.id).phase == SUCCEEDED
    after = matrix(state(ready, "arm").world_t_tcp)
    turn = Rotation.from_matrix(after[:3, :3] @ first[:3, :3].T).as_rotvec()
    np.testing.assert_allclose(after[:3, 3] - first[:3, 3], 0.03 * unit * (not turns), atol=1e-8)
    np.testing.assert_allclose(turn, 0.03 * unit * turns, atol=1e-8)


def test_without_a_node_the_axes_are_the_worlds(ready: Stubs, rng: np.random.Generator) -> None:
    place = random_matrix(rng)
    load(ready, IIWA, "turned", parent_t_node=pose(place))
    put(ready, "turned", READY)
    before = matrix(state(ready, "turned").world_t_tcp)
    for frame, axes in ((NODE, np.eye(3)), (BASE, place[:3, :3]), (motion_pb2.JOG_FRAME_UNSPECIFIED, place[:3, :3])):
        ask = start(ready, jog("turned", [0.0, 0.0, 5.0], frame=frame, distance=0.02, velocity=0.2))
        assert finished(ready, ask.id).phase == SUCCEEDED
        after = matrix(state(ready, "turned").world_t_tcp)
        np.testing.assert_allclose(after[:3, 3] - before[:3, 3], 0.02 * axes[:, 2], atol=1e-8)
        before = after


def test_jogs_that_are_none_are_refused(ready: Stubs) -> None:
    down = [0.0, 0.0, -1.0]
    cases = [
        (joint_jog("arm", FIRST, 0.0), "INVALID_ARGUMENT", "velocity must be other than 0"),
        (joint_jog("arm", FIRST, nan), "INVALID_ARGUMENT", "velocity must be a finite number"),
        (joint_jog("arm", FIRST, 99.0), "LIMIT_EXCEEDED", "at most its limit"),
        (joint_jog("arm", FIRST, 0.1, -0.2), "INVALID_ARGUMENT", "distance must be above 0"),
        (joint_jog("arm", FIRST, 0.1, inf), "INVALID_ARGUMENT", "distance must be a finite number"),
        (joint_jog("arm", "", 0.1), "INVALID_ARGUMENT", "joint is missing"),
        (joint_jog("arm", "lbr_iiwa_joint_8", 0.1), "UNKNOWN_NAME", "lbr_iiwa_joint_7"),
        (joint_jog("arn", FIRST, 0.1), "UNKNOWN_NAME", "did you mean 'arm'"),
        (jog("arm"), "INVALID_ARGUMENT", "give translation or rotation"),
        (jog("arm", [0.0, 0.0, 0.0]), "INVALID_ARGUMENT", "translation must have a length"),
        (jog("arm", rotation=[0.0, nan, 0.0]), "INVALID_ARGUMENT", "cartesian_jog.rotation must be finite"),
        (jog("arm", down, velocity=-0.1), "INVALID_ARGUMENT", "velocity must be 0 or above"),
        (jog("arm", down, distance=0.0), "INVALID_ARGUMENT", "distance must be above 0"),
        (jog("arm", down, distance=101.0), "INVALID_ARGUMENT", "distance must be at most 100"),
        (jog("arm", rotation=down, distance=63.0), "INVALID_ARGUMENT", "distance must be at most 62.8"),
        (jog("arm", down, frame=TOOL, node="nothing"), "INVALID_ARGUMENT", "give JOG_FRAME_NODE"),
        (jog("arm", down, frame=NODE, node="nobody"), "UNKNOWN_NAME", "nobody"),
        (jog("arm", down, frame=9), "INVALID_ARGUMENT", "frame is 9"),
    ]
    with unchanged(ready):
        for move, reason, words in cases:
            refused = refusal(lambda move=move: start(ready, move))
            assert refused.reason == reason, (move, refused)
            assert words in refused.message, refused.message
    put(ready, "arm", dict.fromkeys(READY, 0.0))
    with unchanged(ready):
        stretched = refusal(lambda: start(ready, jog("arm", [0.0, 0.0, 1.0])))
    assert stretched.reason == "SINGULARITY"


def test_a_jog_is_planned_and_checked_before_it_moves(ready: Stubs) -> None:
    outward = matrix(state(ready, "arm").world_t_tcp)[:3, 3] * (1.0, 1.0, 0.0)
    spec = motion_pb2.MotionSpec(moves=[jog("arm", outward, velocity=0.5)])
    with unchanged(ready):
        answer = ready.motion.PlanMotion(motion_pb2.PlanMotionRequest(spec=spec, sample_seconds=0.1))
        assert [note.kind for note in answer.notes] == [motion_pb2.PLAN_NOTE_KIND_JOG_ENDS]
        speeds = values(answer.robots[0].tcp_speeds)
        assert 0.0 < speeds.max() <= 0.5 * (1.0 + 1e-6)
        checked = ready.motion.CheckMotion(motion_pb2.CheckMotionRequest(spec=spec))
        assert not checked.HasField("first_violation")
        assert checked.duration_seconds == pytest.approx(answer.duration_seconds)
        for wrong, kind in (
            (joint_jog("arm", FIRST, 99.0), motion_pb2.VIOLATION_KIND_JOINT_VELOCITY),
            (jog("arm", outward, velocity=0.5, distance=1.0), None),
        ):
            spec = motion_pb2.MotionSpec(moves=[wrong])
            checked = ready.motion.CheckMotion(motion_pb2.CheckMotionRequest(spec=spec))
            assert checked.HasField("first_violation") == (kind is not None), checked
            if kind is not None:
                assert checked.first_violation.joint == FIRST
                assert checked.first_violation.limit == robot(ready, "arm").joints[0].limits.velocity
