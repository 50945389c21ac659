"""Motions through the client: waiting, watching, cancelling, and what happens when a client vanishes."""

from __future__ import annotations

import _thread
import inspect
import sys
import threading
import time
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest
import virtualrobot
import virtualrobot.motions.motion
import virtualrobot.motions.moves
from virtualrobot import Client, Phase, Robot, pose

from tests.api.client.conftest import IIWA

BENT = np.array([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])


def slow(robot: Robot, seconds: float = 60.0) -> virtualrobot.Motion:
    """Start a motion of the first joint that takes so long."""
    goal = robot.positions
    return robot.move_trajectory([0.0, seconds], [goal, goal + np.eye(7)[0]], wait=False)


def begun(motion: virtualrobot.Motion) -> virtualrobot.Motion:
    """Watch a motion until it moves."""
    for message in motion.watch(max_rate=100):
        if message.progress > 0:
            break
    return motion


def test_all_ways_to_move(iiwa: Robot) -> None:
    motion = iiwa.move_joints(BENT)
    assert (motion.phase, motion.progress, motion.robots) == (Phase.SUCCEEDED, 1.0, ("iiwa",))
    np.testing.assert_allclose(iiwa.positions, BENT, atol=1e-9)
    start = iiwa.tcp
    iiwa.move_linear(start @ pose(z=0.05), velocity=0.5)
    np.testing.assert_allclose(iiwa.tcp[:3, 3], (start @ pose(z=0.05))[:3, 3], atol=1e-3)
    iiwa.move_linear(pose(z=-0.05), reference=iiwa.flange, velocity=0.5)  # 5 cm back along the tool
    np.testing.assert_allclose(iiwa.tcp[:3, 3], start[:3, 3], atol=2e-3)
    iiwa.move_pose(start @ pose(x=0.05))
    np.testing.assert_allclose(iiwa.tcp[:3, 3], (start @ pose(x=0.05))[:3, 3], atol=1e-3)
    here = iiwa.tcp
    side = pose(y=0.1) @ here
    iiwa.move_circular(here[:3, 3] + (0.05, 0.05, 0.0), side, velocity=0.5)
    np.testing.assert_allclose(iiwa.tcp, side, atol=1e-8)
    iiwa.move_circular(center=here[:3, 3] + (0.0, 0.05, 0.0), axis=[0, 0, 1], angle=np.pi, velocity=0.5)
    np.testing.assert_allclose(iiwa.tcp, here, atol=1e-8)
    iiwa.move_circular(center=[0, 0.05, 0], axis=[1, 0, 0], angle=0.5, turn_with_arc=True, reference=iiwa.flange)
    turned = here @ pose(y=0.05) @ pose(roll=0.5) @ pose(y=-0.05)
    np.testing.assert_allclose(iiwa.tcp, turned, atol=1e-8)
    now = iiwa.positions
    iiwa.move_trajectory([0, 0.2, 0.5], [now, now + 0.02, now + 0.05])
    np.testing.assert_allclose(iiwa.positions, now + 0.05, atol=1e-9)
    with pytest.raises(virtualrobot.UnknownNameError):
        iiwa.move_to("home")


def test_an_arc_and_a_joint_move_go_together(client: Client, iiwa: Robot) -> None:
    other = client.load_robot(IIWA, name="other", pose=pose(x=2))
    iiwa.move_joints(BENT)
    here = iiwa.tcp
    round_trip = iiwa.circular(center=here[:3, 3] + (0.0, 0.04, 0.0), axis=[0, 0, 1], angle=-2 * np.pi, velocity=0.5)
    client.move_together([round_trip, other.ptp({"lbr_iiwa_joint_1": 0.1})], wait=True)
    np.testing.assert_allclose(iiwa.tcp, here, atol=1e-8)
    np.testing.assert_allclose(other.positions[0], 0.1, atol=1e-9)


def test_arcs_that_say_too_little_or_too_much_are_refused_before_they_are_sent(iiwa: Robot) -> None:
    side = iiwa.tcp @ pose(x=0.1)
    bad: list[dict[str, Any]] = [
        {"goal": side},
        {"via": [0, 0, 1], "center": [0, 0, 1], "goal": side},
        {"via": [0, 0, 1], "goal": side, "angle": 1.0},
        {"via": [0, 0], "goal": side},
        {"center": [0, 0, float("nan")], "goal": side},
    ]
    for arguments in bad:
        with pytest.raises(virtualrobot.InvalidArgumentError):
            iiwa.circular(**arguments)
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"goal\.reference_t_tcp is missing"):
        iiwa.move_circular(via=[0, 0, 1])


def test_a_motion_is_paused_resumed_and_cancelled(client: Client, iiwa: Robot) -> None:
    motion = begun(slow(iiwa))
    assert [running.id for running in client.motions()] == [motion.id]
    motion.pause()
    for message in motion.watch():
        if message.phase is Phase.PAUSED:
            break
    standing, done = iiwa.positions, motion.progress
    np.testing.assert_array_equal(iiwa.state.velocities, np.zeros(7))
    motion.resume()
    for message in motion.watch():
        if message.phase is Phase.RUNNING and message.progress > done:
            break
    motion.cancel("enough")
    with pytest.raises(virtualrobot.MotionCancelledError, match="enough") as cancelled:
        motion.wait()
    assert cancelled.value.metadata == {"motion": motion.id, "end_cause": "call", "end_reason": "enough"}
    assert motion.phase is Phase.CANCELLED
    assert iiwa.positions[0] >= standing[0]
    assert client.motions() == []
    assert motion.id in {ended.id for ended in client.motions(running_only=False)}
    assert "cancelled" in repr(motion)


def test_a_busy_robot_is_refused_or_taken_over(iiwa: Robot) -> None:
    first = begun(slow(iiwa))
    with pytest.raises(virtualrobot.RobotBusyError, match=first.id):
        iiwa.move_joints(BENT)
    iiwa.move_joints(BENT, preempt=True)
    assert first.phase is Phase.CANCELLED
    np.testing.assert_allclose(iiwa.positions, BENT, atol=1e-9)


def test_stop_cancels_what_moves(client: Client, iiwa: Robot) -> None:
    motion = begun(slow(iiwa))
    assert [stopped.id for stopped in iiwa.stop()] == [motion.id]
    with pytest.raises(virtualrobot.MotionCancelledError):
        motion.wait()
    assert client.stop() == []


def test_waiting_has_a_limit(iiwa: Robot) -> None:
    motion = slow(iiwa)
    with pytest.raises(virtualrobot.CallTimeoutError, match="it goes on"):
        motion.wait(timeout=0.05)
    assert not motion.phase.ended
    motion.cancel()


def main_thread_is_in(function: FunctionType) -> bool:
    frame = sys._current_frames().get(threading.main_thread().ident or 0)
    while frame is not None and frame.f_code is not inspect.unwrap(function).__code__:
        frame = frame.f_back
    return frame is not None


def test_ctrl_c_cancels_what_is_waited_for(iiwa: Robot) -> None:
    motion = slow(iiwa)

    def interrupt() -> None:
        begun(motion)
        while not main_thread_is_in(virtualrobot.Motion.wait):  # else Ctrl-C would come before the wait
            time.sleep(0.001)
        _thread.interrupt_main()

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        motion.wait()
    thread.join()
    with pytest.raises(virtualrobot.MotionCancelledError, match="keyboard"):
        motion.wait()


def test_a_block_waits_and_cancels_when_it_fails(iiwa: Robot) -> None:
    with iiwa.move_joints(BENT, wait=False) as motion:
        pass
    assert motion.phase is Phase.SUCCEEDED
    with pytest.raises(RuntimeError, match="the program's own"), slow(iiwa) as motion:
        raise RuntimeError("the program's own")
    with pytest.raises(virtualrobot.MotionCancelledError):
        motion.wait()


def test_a_motion_nobody_waits_for_goes_on_while_its_client_lives(iiwa: Robot) -> None:
    """The kernel cancels what nobody watches for a second; the library watches in the background."""
    motion = slow(iiwa)
    threading.Event().wait(2.0)  # longer than the second of grace, while this program does nothing
    assert motion.phase is Phase.RUNNING
    motion.cancel()


def test_the_state_is_watched(iiwa: Robot) -> None:
    watch = iiwa.watch(max_rate=50)
    first = next(watch)
    np.testing.assert_array_equal(first.positions, np.zeros(7))
    motion = iiwa.move_joints(BENT, speed_factor=0.1, wait=False)
    moving = next(state for state in watch if np.abs(state.velocities).max() > 0)
    assert moving.motion_ids == (motion.id,)
    assert moving.stamp.tick > first.stamp.tick
    still = next(state for state in watch if not state.motion_ids)
    np.testing.assert_allclose(still.positions, BENT, atol=1e-9)


def test_unknown_policies_are_refused(iiwa: Robot) -> None:
    with pytest.raises(ValueError, match="'stop' or 'continue', not 'halt'"):
        iiwa.move_joints(BENT, on_disconnect="halt")


def test_none_is_the_default_of_every_option(client: Client, iiwa: Robot) -> None:
    options: Any = dict.fromkeys(virtualrobot.motions.motion.StartOptions.__optional_keys__)
    moves: Any = dict.fromkeys(virtualrobot.motions.moves.PointToPointOptions.__optional_keys__)
    motion = iiwa.move_pose(iiwa.tcp, **moves, **options)
    assert motion.phase is Phase.SUCCEEDED  # it was waited for
    assert iiwa.jog_joint("lbr_iiwa_joint_1", 0.1, 0.001, wait=None).wait().phase is Phase.SUCCEEDED
    assert iiwa.check(iiwa.ptp(BENT), min_singular_value=None, collisions=None, resolution=None).ok
    assert iiwa.plan(iiwa.ptp(BENT), sample_time=None).duration > 0
    with client.scene.batch() as batch:
        batch.create_signal("s", description=None, unit=None, direction=None, owner=None)
    client.load_robot(IIWA, name="other", pose=pose(x=2), parent=None, base=None, strict=None)


def test_a_cancel_and_an_abort_are_told_apart(client: Client, iiwa: Robot) -> None:
    motion = begun(slow(iiwa))
    motion.cancel()
    with pytest.raises(virtualrobot.MotionEndedError) as ended:
        motion.wait()
    assert type(ended.value) is virtualrobot.MotionCancelledError
    assert ended.value.metadata["end_cause"] == "call"
    client.signals.create("part")
    with pytest.raises(virtualrobot.MotionEndedError, match=r"^motion motion-\d+ was aborted at") as ended:
        client.program().wait("part", timeout=0.01).start()
    assert type(ended.value) is virtualrobot.MotionAbortedError
    assert ended.value.metadata["end_cause"] == "signal_timeout"
    assert not issubclass(virtualrobot.MotionAbortedError, virtualrobot.MotionCancelledError)


def test_what_does_nothing_says_what_would(client: Client, iiwa: Robot) -> None:
    for use in (
        client.program().start,
        lambda: client.program().start(open=True),
        client.program().plan,
        client.program().check,
        lambda: client.move_together([]),
    ):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"give a first step or move, as by program\.move"):
            use()


def test_wrong_arguments_never_reach_the_kernel(client: Client, iiwa: Robot) -> None:
    motion: Any = client.program().dwell(0.01).start(open=True)
    robot: Any = iiwa
    for call, words in (
        (lambda: motion.append("move"), "program is 'move'; it must be a Program, or None"),
        (lambda: robot.move_joints(BENT, expected_structure_revision=-1), "expected_structure_revision is -1"),
        (lambda: robot.move_joints({"base": "abc"}), r"goal\['base'\] is 'abc'; it must be a number"),
        (lambda: robot.move_joints(BENT, speed_factor="fast"), "speed_factor is 'fast'; it must be a number"),
        (lambda: robot.move_joints(BENT, tracking="belt"), "tracking is 'belt'; it must be a Tracking"),
        (lambda: setattr(robot, "speed_factor", "fast"), "speed_factor is 'fast'; it must be a number"),
        (lambda: client.robot(""), "name is ''; it must be a text that is not empty"),
        (lambda: client.scene.node(""), "name is ''"),
        (lambda: client.load_robot(IIWA, name=""), "name is ''"),
        (lambda: client.signals.create(""), "name is ''"),
        (lambda: client.sensors[""], "name is ''"),
    ):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=words):
            call()
    motion.append(last=True)
    motion.wait()
    assert not iiwa.positions.any()


def test_moves_of_a_program_file_are_a_step_to_be_appended_to(client: Client, iiwa: Robot, tmp_path: Path) -> None:
    (file := tmp_path / "moves.yaml").write_text(
        "schema_version: 1\nmoves:\n- robot: iiwa\n"
        "  point_to_point: {joints: {joint_positions: {lbr_iiwa_joint_1: 0.1}}}\n"
    )
    program = client.read_program(file)
    assert (len(program), program.start().phase) == (1, Phase.SUCCEEDED)
    assert iiwa.positions[0] == pytest.approx(0.1)
    assert program.move(iiwa.ptp({"lbr_iiwa_joint_1": 0.2})).start().step_count == 2
    assert iiwa.positions[0] == pytest.approx(0.2)
    motion = client.program().dwell(0.01).start(open=True)
    motion.append(client.read_program(file), last=True)
    assert motion.wait().step_count == 2
    assert iiwa.positions[0] == pytest.approx(0.1)
