"""Teleoperation on a real kernel: what moves while a key or a button is held, and whatever ends that stops it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from prompt_toolkit.input import PipeInput, create_pipe_input
from prompt_toolkit.output import DummyOutput
from virtualrobot import Client, Robot
from virtualrobot.cli.gamepad import Gamepad
from virtualrobot.cli.gamepad_mapping import SPACE_MOUSE, USUAL, USUAL_SPACE_MOUSE, read_mapping
from virtualrobot.cli.space_mouse import SpaceMouse
from virtualrobot.cli.teleop import drive_by_keys, drive_by_pad
from virtualrobot.cli.teleoperation import REST, Teleoperation
from virtualrobot.errors import UnknownNameError, WrongStateError

from tests.api.client.conftest import Run
from tests.gamepads import VirtualPad, virtual_pad
from tests.space_mice import FakeHid, pressed, translation
from tests.waiting import repeated, until

COMMAND = [sys.executable, "-m", "virtualrobot", "teleop", "ugv"]
SPEED, TURN = 0.2, 0.5
KEY_SECONDS = 0.03
"""Time (s) after which a terminal repeats a key that is held."""


@pytest.fixture
def ugv(client: Client) -> Robot:
    """Return a UGV in real time."""
    return client.load_robot("model://ugv", base="planar")


def rests(robot: Robot) -> bool:
    return not robot.state.velocities.any() and not robot.state.motion_ids


def x_of(robot: Robot) -> float:
    return robot.way([]).begin[0]


def heading_of(robot: Robot) -> float:
    return robot.way([]).begin[2]


@contextmanager
def hands(keys: PipeInput, act: Callable[[], None]) -> Iterator[None]:
    """Let hands act in a thread for the length of a block, and press q in the end; their failure is the test's."""
    failed: list[BaseException] = []

    def run() -> None:
        try:
            act()
        except BaseException as error:
            failed.append(error)
        finally:
            keys.send_text("q")

    holder = threading.Thread(target=run)
    holder.start()
    try:
        yield
    finally:
        holder.join()
    assert not failed, failed


def test_a_craft_drives_while_a_key_is_held(ugv: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    with create_pipe_input() as keys:

        def hold() -> None:
            with repeated(lambda: keys.send_text("w"), KEY_SECONDS):
                until(lambda: x_of(ugv) > 0.05)
            until(lambda: rests(ugv))  # though the command goes on: others may move it now
            with repeated(lambda: keys.send_text("\x1b[D"), KEY_SECONDS):  # the arrow to the left
                until(lambda: heading_of(ugv) > 0.1)

        with hands(keys, hold):
            drive_by_keys(ugv, SPEED, TURN, source=keys, output=DummyOutput())
    assert rests(ugv)
    x, y, heading = ugv.way([]).begin
    assert x > 0.05 and y < 0.1 and heading > 0.1
    assert capsys.readouterr().out == f"ugv rests at {x:.3f}, {y:.3f} m, heading {heading:.3f} rad\n"


def test_what_is_refused_is_told_and_driven_only_after_the_key_was_let_go(client: Client, ugv: Robot) -> None:
    wanted = [(99.0, 0.0, 0.0)]
    with Teleoperation(ugv, lambda: wanted[0]) as driving:
        until(lambda: driving.error)
        assert "'left_wheel'" in driving.error and "limit is" in driving.error
        wanted[0] = (SPEED, 0.0, 0.0)  # it is held on
        until(lambda: driving.twist == wanted[0])
        assert rests(ugv) and driving.error
        wanted[0] = REST
        until(lambda: not driving._refused)
        wanted[0] = (SPEED, 0.0, 0.0)
        until(lambda: x_of(ugv) > 0.02)
        assert not driving.error
        ugv.stop()  # by somebody else
        until(lambda: driving.error)
        until(lambda: rests(ugv))
    assert rests(ugv)


def test_another_motion_is_preempted_only_when_asked_for(ugv: Robot) -> None:
    with ugv.stream_twist(timeout=600.0) as other:
        other.send([0.05, 0.0, 0.0], wait=True)
        with Teleoperation(ugv, lambda: (0.0, 0.0, TURN)) as driving:
            until(lambda: "ugv" in driving.error)
            assert not other.motion.phase.ended
        with Teleoperation(ugv, lambda: (0.0, 0.0, TURN), preempt=True):
            until(lambda: other.motion.phase.ended)
            until(lambda: heading_of(ugv) > 0.02)
        other.cancel()
    assert rests(ugv)


def driven_by_pad(robot: Robot, act: Callable[[VirtualPad], None]) -> None:
    """Drive a robot by SDL's virtual gamepad, which `act` moves meanwhile; ends with q, or raises what it raises."""
    with virtual_pad() as virtual, Gamepad() as pad, create_pipe_input() as keys, hands(keys, lambda: act(virtual)):
        drive_by_pad(robot, pad, read_mapping(), SPEED, TURN, source=keys, output=DummyOutput())


def test_a_gamepad_drives_while_its_dead_mans_button_is_held(ugv: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    def hands(virtual: VirtualPad) -> None:
        virtual.press("right_shoulder")
        virtual.move(left_y=-1.0)
        until(lambda: x_of(ugv) > 0.05)
        virtual.press("right_shoulder", down=False)  # the stick is held on
        until(lambda: rests(ugv))
        virtual.move(left_y=0.0, right_x=-1.0)
        virtual.press("right_shoulder")
        until(lambda: heading_of(ugv) > 0.1)

    driven_by_pad(ugv, hands)
    assert rests(ugv)
    assert capsys.readouterr().out == "ugv rests\n"


def test_a_gamepad_that_is_unplugged_stops_what_it_drives(ugv: Robot) -> None:
    def hands(virtual: VirtualPad) -> None:
        virtual.press("right_shoulder")
        virtual.move(left_y=-1.0)
        until(lambda: x_of(ugv) > 0.02)
        virtual.unplug()
        until(lambda: rests(ugv))

    with pytest.raises(WrongStateError, match="has gone"):
        driven_by_pad(ugv, hands)
    assert rests(ugv)


def test_a_gamepad_moves_the_joints_of_an_arm(client: Client) -> None:
    """A joint goes no faster than its limit of speed and the one that is asked for."""
    arm = client.load_robot("model://ar_manipulator", name="arm")
    start = arm.positions
    fastest: list[float] = []

    def hands(virtual: VirtualPad) -> None:
        virtual.press("right_shoulder")
        virtual.move(left_x=-1.0)

        def moved() -> bool:
            fastest.append(float(arm.state.velocities[0]))
            return arm.positions[0] - start[0] > 0.2

        until(moved)

    driven_by_pad(arm, hands)
    assert rests(arm)
    assert TURN * 0.9 < max(fastest) <= TURN + 1e-9
    assert arm.positions[1:].tolist() == start[1:].tolist()


def test_a_mapping_that_moves_nothing_of_a_robot_is_refused(
    run: Run, client: Client, ugv: Robot, tmp_path: Path
) -> None:
    file = tmp_path / "pad.yaml"
    with virtual_pad(), Gamepad() as pad:
        file.write_text("{schema_version: 1, hold: a}")
        with pytest.raises(WrongStateError, match="'ugv' is a craft, and the mapping has no 'drive'"):
            drive_by_pad(ugv, pad, read_mapping(file), SPEED, TURN)
        arm = client.load_robot("model://ar_manipulator", name="arm")
        with pytest.raises(WrongStateError, match="'arm' is no craft, and the mapping names no joint of it"):
            drive_by_pad(arm, pad, read_mapping(file), SPEED, TURN)
        file.write_text("{schema_version: 1, hold: a, jog: {elbow: left_x}}")
        with pytest.raises(UnknownNameError, match="'arm' has no joint 'elbow'; its joints are joint_1, joint_2"):
            drive_by_pad(arm, pad, read_mapping(file), SPEED, TURN)
    assert "say --gamepad, too" in run("teleop", "ugv", "--mapping", str(USUAL), code=2)


def test_a_space_mouse_moves_a_tool_and_drives_a_craft(client: Client, ugv: Robot) -> None:
    arm = client.load_robot("model://ar_manipulator", name="arm")
    arm.set_positions([0.0, 0.3, -0.6, 0.2, 0.8, 0.0])
    begin = arm.state.world_t_tcp
    hid, meant = FakeHid(), read_mapping(USUAL_SPACE_MOUSE, SPACE_MOUSE)

    def height() -> float:
        return float(arm.state.world_t_tcp[2, 3])

    with SpaceMouse(hid) as mouse, create_pipe_input() as keys:

        def lift() -> None:
            hid.send(translation(0, 0, -350))
            repeated_rest(arm)  # the dead man's button is not held
            hid.send(pressed(1))
            until(lambda: height() > begin[2, 3] + 0.03)
            hid.send(translation())  # the cap springs back
            until(lambda: rests(arm))

        with hands(keys, lift):
            drive_by_pad(arm, mouse, meant, 0.1, TURN, source=keys, output=DummyOutput())
    assert rests(arm)
    way = arm.state.world_t_tcp @ np.linalg.inv(begin)
    assert abs(arm.state.world_t_tcp[:2, 3] - begin[:2, 3]).max() < 1e-6 and np.allclose(
        way[:3, :3], np.eye(3), atol=1e-6
    )
    hid = FakeHid()
    with SpaceMouse(hid) as mouse, create_pipe_input() as keys:

        def drive() -> None:
            hid.send(translation(0, -350, 0), pressed(1))
            until(lambda: x_of(ugv) > 0.05)
            hid.is_there = False
            until(lambda: rests(ugv))

        with hands(keys, drive), pytest.raises(WrongStateError, match="SpaceMouse Compact has gone"):
            drive_by_pad(ugv, mouse, meant, SPEED, TURN, source=keys, output=DummyOutput())
    assert rests(ugv)


def test_a_gamepad_lets_a_hand_feel_what_weighs_on_the_tool(client: Client, tmp_path: Path) -> None:
    arm = client.load_robot("model://ar_manipulator", name="arm")
    arm.set_positions([0.0, 0.3, -0.6, 0.2, 0.8, 0.0])
    client.scene.add_motion_sensor("wrist", virtualrobot.force_torque_sensor(), parent=arm.flange)
    file = tmp_path / "mapping.yaml"
    file.write_text("{schema_version: 1, hold: a, tool: {vz: -left_y}, force: {sensor: wrist, full: 39.24}}")
    with virtual_pad() as hand, Gamepad() as pad, create_pipe_input() as keys:

        def weigh() -> None:
            hand.press("a")
            hand.move(left_y=-1.0)
            begin = float(arm.state.world_t_tcp[2, 3])
            until(lambda: arm.state.world_t_tcp[2, 3] > begin + 0.01)
            hand.move(left_y=0.0)
            until(lambda: rests(arm))
            client.scene.add_part("load", virtualrobot.box(0.1, 0.1, 0.1), parent=arm.flange, mass=1.0)
            # A kilogram weighs 9.81 N: a quarter of what is felt with full strength, 65535.
            until(lambda: hand.felt[-1:] == [(16384, 16384)])
            hand.press("a", down=False)
            until(lambda: hand.felt[-1:] == [(0, 0)])

        with hands(keys, weigh):
            drive_by_pad(arm, pad, read_mapping(file), SPEED, TURN, source=keys, output=DummyOutput())
        with SpaceMouse(FakeHid()) as mouse, pytest.raises(WrongStateError, match="lets nobody feel a force"):
            file.write_text("{schema_version: 1, hold: left, tool: {vz: -z}, force: {sensor: wrist, full: 10}}")
            drive_by_pad(arm, mouse, read_mapping(file, SPACE_MOUSE), SPEED, TURN, source=keys, output=DummyOutput())
        with pytest.raises(UnknownNameError, match="'writs'"):
            file.write_text("{schema_version: 1, hold: a, tool: {vz: -left_y}, force: {sensor: writs, full: 10}}")
            drive_by_pad(arm, pad, read_mapping(file), SPEED, TURN, source=keys, output=DummyOutput())


def repeated_rest(robot: Robot) -> None:
    """Look at a robot for some ticks of its clock, in which it does not move."""
    begin = robot.state
    until(lambda: robot.state.stamp.tick > begin.stamp.tick + 50)
    assert np.array_equal(robot.positions, begin.positions)


def test_teleoperation_wants_a_craft_a_terminal_and_time(run: Run, client: Client, ugv: Robot) -> None:
    fixed = client.load_robot("model://ugv", name="fixed")
    with pytest.raises(WrongStateError, match="fixed"):
        Teleoperation(fixed, lambda: REST)
    assert "keys need a terminal" in run("teleop", "ugv", code=2)
    run("teleop", "ugv", "--speed", "-1", code=2)


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals that Python can open")
@pytest.mark.parametrize("end", ["q", "ctrl-c", "killed"])
def test_the_command_drives_in_a_terminal(client: Client, environment: None, ugv: Robot, end: str) -> None:
    """A real terminal, which turns Ctrl-C into its key; of a program that is killed the kernel stops the craft."""
    import pty

    ours, theirs = pty.openpty()
    command = [*COMMAND, "--speed", str(SPEED)]
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True) as process:
        os.close(theirs)
        shown = bytearray()

        def show() -> None:
            try:
                while part := os.read(ours, 65536):
                    shown.extend(part)
            except OSError:  # the terminal of a process that has ended
                pass

        reader = threading.Thread(target=show, daemon=True)
        reader.start()
        try:
            until(lambda: b"ugv at" in shown)
            with repeated(lambda: os.write(ours, b"w"), KEY_SECONDS):
                until(lambda: x_of(ugv) > 0.05)
                if end == "killed":
                    process.kill()
                    process.wait(60.0)
                    until(lambda: rests(ugv))
            if end != "killed":
                os.write(ours, b"q" if end == "q" else b"\x03")
                assert process.wait(60.0) == 0
                assert rests(ugv)
        finally:
            process.kill()
            reader.join(60.0)
            os.close(ours)
    assert (b"ugv rests at" in shown) == (end != "killed")
