"""Going along with a conveyor, over TCP, tick by tick: where the tool and a picked part are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import geometry_pb2, motion_pb2, nodes_pb2, scene_pb2, signal_pb2

from tests.api.asking import IIWA, apply, box, create, joints, load, refusal, set_signals, start
from tests.api.moving import ABORTED, CANCELLED, RUNNING, SUCCEEDED, TICK, finished, linear, motion
from tests.api.reading import matrix, pose, scene, state, step, unchanged
from tests.api.test_robot import put
from tests.api.test_scene import attach, update
from tests.api.test_tool import pick, tool
from tests.kernels import Stubs

DOWN = [-0.6, 0.6, 0.0, -1.4, 0.0, np.pi - 2.0, 0.0]
"""The tool looks down."""
SURFACE = 0.8


@pytest.fixture
def cell(stepped: Stubs) -> Stubs:
    """An iiwa with a cup, whose tool looks down on a conveyor that passes in front of it, to the left."""
    load(stepped, IIWA, "arm", parent_t_node=pose(at(z=0.65)))
    put(stepped, "arm", {f"lbr_iiwa_joint_{i + 1}": value for i, value in enumerate(DOWN)})
    apply(stepped, create(tool("cup", "arm.lbr_iiwa_link_7", tip=at(z=0.1))))
    load(stepped, "model://conveyor", parent_t_node=pose(across(stepped)))
    return stepped


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def across(stubs: Stubs) -> np.ndarray:
    """Return where the conveyor stands: under the tool, along y, from 70 cm before it."""
    tool = state(stubs, "arm").world_t_tcp.position
    result = at(tool.x, tool.y - 0.7)
    result[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    return result


def tracking(window: float = 0.5, fastest: float = 0.2, node: str = "conveyor.belt") -> motion_pb2.Tracking:
    return motion_pb2.Tracking(node=node, window=window, max_velocity=fastest)


def go(stubs: Stubs, request: motion_pb2.StartMotionRequest) -> motion_pb2.Motion:
    request.on_disconnect = motion_pb2.DISCONNECT_POLICY_CONTINUE
    return stubs.motion.StartMotion(request).motion


def to(stubs: Stubs, goal: np.ndarray, **fields: float) -> motion_pb2.Move:
    """Return a line to a pose in the belt's frame."""
    move = linear("arm", goal, **fields)
    move.linear.goal.reference = "conveyor.belt"
    return move


def seen(stubs: Stubs, frame: str = "conveyor.belt") -> np.ndarray:
    """Return where the tool centre point is, seen from the belt."""
    return np.linalg.inv(scene(stubs, frame)[frame]) @ matrix(state(stubs, "arm").world_t_tcp)


def run_belt(stubs: Stubs, distance: float = 10.0, share: float = 0.4) -> motion_pb2.Motion:
    return start(stubs, joints("conveyor", share, belt=distance))


@pytest.mark.long
def test_a_part_is_picked_from_the_running_belt(cell: Stubs) -> None:
    apply(cell, create(box("part", x=0.4, z=0.05, parent="conveyor.belt")))
    run_belt(cell)  # 0.2 m/s
    step(cell, 250)
    grip = seen(cell)
    grip[:3, 3] = 0.4, 0.0, 0.1
    above = grip @ at(z=-0.1)
    held = {"signal": "held", "value": {"boolean": True}}
    steps = [
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[to(cell, above)])),
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[to(cell, grip)])),
        motion_pb2.ProgramStep(wait_signal=motion_pb2.WaitSignalStep(condition=held)),
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[to(cell, above)])),
    ]
    apply(cell, scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal_pb2.Signal(name="held"))))
    request = motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps, tracking=tracking(0.9)))
    id = go(cell, request).id
    places: list[np.ndarray] = []
    lift: list[float] = []
    while motion(cell, id).phase not in (SUCCEEDED, CANCELLED, ABORTED):
        step(cell)
        places.append(scene(cell, "part")["part"][:3, 3])
        told = motion(cell, id)
        if told.phase == motion_pb2.MOTION_PHASE_WAITING:
            if not lift:
                assert np.abs(seen(cell) - grip).max() < 1e-5
                apply(cell, pick("arm", "part"))
                set_signals(cell, {"held": True})
            lift.append(len(places))
    told = motion(cell, id)
    assert told.phase == SUCCEEDED, told.end_reason
    path = np.array(places)
    # From the belt to the tool without a jerk: 0.2 m/s along the belt all the time, also in the tick of picking.
    at_pick = lift[0]
    speeds = np.diff(path, axis=0)[at_pick - 5 : at_pick + 5] / TICK
    np.testing.assert_allclose(speeds[:, :2], np.tile([0.0, 0.2], (len(speeds), 1)), atol=1e-5)
    assert speeds[:, 2].max() < 0.005, "it is lifted slowly at first"
    assert np.abs(np.diff(path, 2, axis=0)).max() / TICK**2 < 3.0, "m/s^2"
    assert path[-1, 2] == pytest.approx(SURFACE + 0.05 + 0.1, abs=1e-5)


@pytest.mark.long
def test_a_program_that_goes_along_picks_by_itself(cell: Stubs) -> None:
    apply(cell, create(box("part", x=0.4, z=0.05, parent="conveyor.belt")))
    run_belt(cell)  # 0.2 m/s
    step(cell, 250)
    grip = seen(cell)
    grip[:3, 3] = 0.4, 0.0, 0.1
    above = grip @ at(z=-0.1)
    steps = [
        *(motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[to(cell, pose)])) for pose in (above, grip)),
        motion_pb2.ProgramStep(pick=scene_pb2.PickPart(robot="arm", part="part")),
        motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[to(cell, above)])),
    ]
    id = go(cell, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(steps=steps, tracking=tracking(0.9)))).id
    places: list[np.ndarray] = []
    picked = 0
    while motion(cell, id).phase not in (SUCCEEDED, CANCELLED, ABORTED):
        step(cell)
        places.append(scene(cell, "part")["part"][:3, 3])
        picked = picked or (len(places) if motion(cell, id).step == 3 else 0)
    told = motion(cell, id)
    assert told.phase == SUCCEEDED, told.end_reason
    path = np.array(places)
    speeds = np.diff(path, axis=0)[picked - 5 : picked + 5] / TICK
    np.testing.assert_allclose(speeds[:, :2], np.tile([0.0, 0.2], (len(speeds), 1)), atol=1e-5)
    assert path[-1, 2] == pytest.approx(SURFACE + 0.05 + 0.1, abs=1e-5)
    assert not np.any(state(cell, "arm").velocities)


def test_the_window_ends(cell: Stubs) -> None:
    run_belt(cell)
    step(cell, 100)
    ask = go(
        cell,
        motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(
                moves=[to(cell, seen(cell) @ at(z=0.05), max_velocity_meters_per_second=0.01)], tracking=tracking(0.3)
            )
        ),
    )
    before = state(cell, "arm").world_t_tcp.position.y
    told = finished(cell, ask.id)
    assert (told.phase, told.end_cause) == (ABORTED, motion_pb2.END_CAUSE_WINDOW_LEFT)
    assert "its window is 0 to 0.3" in told.end_reason
    assert 0.28 < state(cell, "arm").world_t_tcp.position.y - before <= 0.3 + 1e-9


def test_a_belt_that_is_faster_than_said(cell: Stubs) -> None:
    run_belt(cell)
    step(cell, 200)
    slow = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[to(cell, seen(cell) @ at(z=0.05))], tracking=tracking(fastest=0.1))
    )
    told = finished(cell, go(cell, slow).id)
    assert (told.phase, told.end_cause) == (ABORTED, motion_pb2.END_CAUSE_TRACKING_LOST)
    assert "0.2 per second; 0.1 was the most" in told.end_reason
    assert not np.any(state(cell, "arm").velocities)


def test_the_arm_is_busy_as_a_whole_while_it_goes_along(cell: Stubs) -> None:
    moves = [joints("arm", lbr_iiwa_joint_7=0.3)]
    ask = go(cell, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=moves, tracking=tracking())))
    assert refusal(lambda: start(cell, joints("arm", lbr_iiwa_joint_1=0.3))).reason == "ROBOT_BUSY"
    assert finished(cell, ask.id).phase == SUCCEEDED
    assert state(cell, "arm").positions[6] == pytest.approx(0.3)


REFUSED = {
    "unknown node": (tracking(node="conveyor.bolt"), "UNKNOWN_NAME", "did you mean 'conveyor.belt'"),
    "empty node": (tracking(node=""), "INVALID_ARGUMENT", "tracking.node is empty"),
    "a node that nothing moves": (tracking(node="conveyor.frame"), "INVALID_ARGUMENT", "no joint moves it"),
    "the arm's own link": (
        tracking(node="arm.lbr_iiwa_link_7"),
        "INVALID_ARGUMENT",
        "it is moved by 'lbr_iiwa_joint_7' of 'arm', 'lbr_iiwa_joint_6'",
    ),
    "the arm's first link": (
        tracking(node="arm.lbr_iiwa_link_1"),
        "INVALID_ARGUMENT",
        "it is moved by 'lbr_iiwa_joint_1' of 'arm', which the motion moves itself; name a node that exactly",
    ),
    "no window": (tracking(0.0), "INVALID_ARGUMENT", "tracking.window must say how far"),
    "a window that is no number": (tracking(float("nan")), "INVALID_ARGUMENT", "tracking.window"),
    "an endless window": (tracking(1e9), "INVALID_ARGUMENT", "tracking.window is at most 100 m"),
    "a speed that is no number": (tracking(fastest=float("inf")), "INVALID_ARGUMENT", "tracking.max_velocity"),
    "a negative speed": (tracking(fastest=-0.1), "INVALID_ARGUMENT", "tracking.max_velocity must be 0"),
    "a window out of reach": (tracking(3.0), "UNREACHABLE", "the arm cannot go along at"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_followed_is_refused(cell: Stubs, what: str) -> None:
    wish, reason, words = REFUSED[what]
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[to(cell, seen(cell) @ at(z=0.05))], tracking=wish)
    )
    with unchanged(cell):
        told = refusal(lambda: go(cell, request))
    assert told.reason == reason, told
    assert words in told.message


def test_a_place_that_cannot_be_followed_is_named(cell: Stubs) -> None:
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[to(cell, seen(cell) @ at(z=0.05))], tracking=tracking(3.0))
    )
    told = refusal(lambda: go(cell, request))
    beyond = float(told.metadata["displacement"])
    assert 0.1 < beyond < 3.0
    assert float(told.metadata["tracked_position"]) == pytest.approx(beyond)
    assert 0.0 <= float(told.metadata["fraction"]) <= 1.0
    # Nearly so far it can.
    request.spec.tracking.window = beyond - 0.05
    go(cell, request)


def test_the_motion_may_not_move_the_belt_itself(cell: Stubs) -> None:
    moves = [to(cell, seen(cell) @ at(z=0.05)), joints("conveyor", belt=1.0)]
    told = refusal(
        lambda: go(cell, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=moves, tracking=tracking())))
    )
    assert "it is moved by 'belt' of 'conveyor', which the motion moves itself" in told.message
    told = refusal(
        lambda: go(
            cell, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=moves[1:], tracking=tracking()))
        )
    )
    assert told.reason == "INVALID_ARGUMENT"


def test_a_belt_that_is_too_fast_is_refused_with_the_speed_that_would_do(cell: Stubs) -> None:
    put(cell, "arm", {"lbr_iiwa_joint_1": -0.6, "lbr_iiwa_joint_6": 1.0})
    belt = nodes_pb2.Link(joint=nodes_pb2.Joint(name="belt", type=nodes_pb2.JOINT_TYPE_PRISMATIC))
    belt.joint.axis.x = 1.0
    belt.joint.limits.CopyFrom(nodes_pb2.JointLimits(velocity=20.0, acceleration=20.0, jerk=200.0))
    apply(cell, update("conveyor.belt", "link", link=belt))
    move = to(cell, seen(cell) @ at(z=0.05))
    told = refusal(
        lambda: go(
            cell,
            motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[move], tracking=tracking(fastest=0.0))),
        )
    )
    assert told.reason == "LIMIT_EXCEEDED"
    assert "cannot keep up with the joint 'belt' at 20 m/s where this is at " in told.message
    assert "; give a max_velocity of at most" in told.message and "window" not in told.metadata
    assert 0.5 < float(told.metadata["limit"]) < 20.0
    fitting = tracking(fastest=0.999 * float(told.metadata["limit"]))
    assert (
        finished(
            cell, go(cell, motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[move], tracking=fitting))).id
        ).phase
        == SUCCEEDED
    )


def test_a_node_that_two_joints_move_and_a_rail_that_moves_too(cell: Stubs) -> None:
    load(cell, "model://positioner", "table")
    move = linear("arm", matrix(state(cell, "arm").world_t_tcp) @ at(z=0.05))
    told = refusal(
        lambda: go(
            cell,
            motion_pb2.StartMotionRequest(
                spec=motion_pb2.MotionSpec(moves=[move], tracking=tracking(node="table.plate"))
            ),
        )
    )
    assert "it is moved by 'turn' of 'table', 'tilt' of 'table'; name a node that exactly one" in told.message
    load(cell, "model://rail")
    apply(cell, attach("arm", "rail.carriage"))
    bend = joints("arm", lbr_iiwa_joint_7=0.1)
    told = refusal(
        lambda: go(
            cell,
            motion_pb2.StartMotionRequest(
                spec=motion_pb2.MotionSpec(moves=[bend, joints("rail", slide=0.2)], tracking=tracking())
            ),
        )
    )
    assert "while the same motion moves what carries it, 'slide' of 'rail'" in told.message


def test_an_arm_of_four_axes(stepped: Stubs) -> None:
    """A palletizer, whose flange stays level, goes along with belts, and not with a wheel that would tilt it."""
    load(stepped, "model://palletizer", "arm")
    put(stepped, "arm", {"joint_1": -0.3, "joint_2": 0.2, "joint_3": 0.4})
    tool = matrix(state(stepped, "arm").world_t_tcp)[:3, 3]
    place = at(tool[0], tool[1] - 0.5)
    place[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    load(stepped, "model://conveyor", parent_t_node=pose(place))
    run_belt(stepped)
    step(stepped, 100)
    goal = seen(stepped) @ at(z=0.05)
    ask = go(
        stepped,
        motion_pb2.StartMotionRequest(spec=motion_pb2.MotionSpec(moves=[to(stepped, goal)], tracking=tracking(0.8))),
    )
    while (told := motion(stepped, ask.id)).phase == RUNNING and told.progress < 1.0:
        step(stepped)
    np.testing.assert_allclose(seen(stepped), goal, atol=1e-5)
    assert finished(stepped, ask.id).phase == SUCCEEDED
    climbing = place.copy()
    climbing[:3, :3] = Rotation.from_euler("zy", [90, -10], degrees=True).as_matrix()
    load(stepped, "model://conveyor", "ramp", parent_t_node=pose(climbing))
    bend = joints("arm", joint_4=0.1)
    ask = go(
        stepped,
        motion_pb2.StartMotionRequest(
            spec=motion_pb2.MotionSpec(moves=[bend], tracking=tracking(0.3, 0.1, "ramp.belt"))
        ),
    )
    assert finished(stepped, ask.id).phase == SUCCEEDED
    table = at(tool[0] + 0.3, tool[1], 0.3)
    table[:3, :3] = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    limits = nodes_pb2.JointLimits(lower=-100.0, upper=100.0, velocity=1.0, acceleration=1.0, jerk=10.0)
    turn = nodes_pb2.Joint(
        name="turn", type=nodes_pb2.JOINT_TYPE_CONTINUOUS, axis=geometry_pb2.Vector3(z=1.0), limits=limits
    )
    apply(
        stepped,
        create(nodes_pb2.Node(name="wheel", robot=nodes_pb2.Robot(), parent_t_node=pose(table))),
        create(nodes_pb2.Node(name="wheel.rim", parent="wheel", link=nodes_pb2.Link(joint=turn))),
    )
    told = refusal(
        lambda: go(
            stepped,
            motion_pb2.StartMotionRequest(
                spec=motion_pb2.MotionSpec(moves=[bend], tracking=tracking(0.3, 0.1, "wheel.rim"))
            ),
        )
    )
    assert told.reason == "UNREACHABLE"
