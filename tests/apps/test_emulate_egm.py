"""The emulated ABB controller: a program that uses ABBRobotEGM against a real one runs against it, unchanged."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import virtualrobot
from ABBRobotEGM import EGM
from click.testing import CliRunner
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.command import emulate
from virtualrobot_apps.emulators.egm.controller import EgmController

from tests.kernels import KernelProcess, Stubs

MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 1, 2, 3
HOME = np.radians([0.0, -30.0, 30.0, 0.0, 45.0, 10.0])
MINUTE = 60.0


def port_of(program: EGM) -> int:
    assert program.socket is not None
    return program.socket.getsockname()[1]


class Setup:
    """A program's side of EGM and a controller with a simulated arm, in lockstep."""

    def __init__(self, arm: SimulatedArm) -> None:
        """Let the controller speak to the program."""
        self.told: list[str] = []
        self.arm = arm
        self.program = EGM(port=0)  # any that is free
        to = ("127.0.0.1", port_of(self.program))
        self.controller = EgmController(arm, to, tell=self.told.append)

    def cycle(self, *asked: Any, **more: Any) -> Any:  # noqa: ANN401 as the package has them
        """Return the state of another cycle, after the answer where there is one."""
        self.controller.cycle()
        there, state = self.program.receive_from_robot(MINUTE)
        assert there and state is not None
        if asked or more:
            assert self.program.send_to_robot(*asked, **more)
        return state

    def close(self) -> None:
        self.program.close()
        self.controller.close()


@pytest.fixture
def setup() -> Iterator[Setup]:
    made = Setup(SimulatedArm(HOME))
    yield made
    made.close()


def test_it_tells_what_a_controller_tells(setup: Setup) -> None:
    for cycle in range(3):
        state = setup.cycle()
        np.testing.assert_allclose(state.joint_angles, np.degrees(HOME))
        np.testing.assert_allclose(state.joint_angles_planned, np.degrees(HOME))
        assert (state.header.seqno, state.header.tm, state.header.mtype) == (cycle, 4 * (cycle + 1), 2)
        assert tuple(state.clock) == (0, 4000 * (cycle + 1))
        assert (state.motors_on, state.rapid_running, state.mci_state) == (True, True, MCI_RUNNING)
        assert state.cartesian is None and len(state.external_axes) == 0
    setup.controller.motors_on = False
    state = setup.cycle()
    assert (state.motors_on, state.rapid_running, state.mci_state) == (False, True, MCI_STOPPED)


def test_the_arm_goes_where_the_program_sends_it(setup: Setup) -> None:
    start, way = np.degrees(HOME), np.array([3.0, -2.0, 1.0, 5.0, -4.0, 2.0])
    for cycle in range(250):
        setup.cycle(start + way * min(1.0, cycle / 200), rapid_to_robot=[1.5, cycle], digital_signal_to_robot=True)
    state = setup.cycle()
    np.testing.assert_allclose(state.joint_angles, start + way, atol=0.01)
    assert state.mci_convergence_met and list(state.rapid_from_robot) == [1.5, 249]
    assert state.robot_message.RAPIDfromRobot.digVal is True
    assert setup.told == ["the computer answers"]


def test_external_axes_are_apart_and_sliding_ones_in_millimeters() -> None:
    setup = Setup(SimulatedArm([0.1] * 6 + [0.25, math.pi], sliding=(False,) * 6 + (True, False)))
    state = setup.cycle(np.degrees([0.1] * 6), external_joints=np.array([260.0, 175.0]))
    np.testing.assert_allclose(state.external_axes, [250.0, 180.0])
    for _ in range(250):
        state = setup.cycle(np.degrees([0.1] * 6), external_joints=np.array([260.0, 175.0]))
    np.testing.assert_allclose(state.external_axes, [260.0, 175.0], atol=0.01)
    setup.close()


def test_what_cannot_be_followed_is_an_error_until_the_time_out(setup: Setup) -> None:
    start = np.degrees(HOME)
    for asked, why in (
        ((start[:5],), "it is asked for 5 joints and 0 external axes, and has 6 and 0"),
        ((np.where(start == 10.0, np.nan, start),), "nan], which are no numbers"),
        ((None, ([500, 0, 500], [1, 0, 0, 0])), "an arm without a kernel has joints alone, and knows no poses"),
        ((start + 1000.0,), "joint joint_1 would be at 17.4533, its range is -6.28319 to 6.28319"),
    ):
        setup.told.clear()
        setup.cycle(*asked)
        state = setup.cycle()
        assert state.mci_state == MCI_ERROR and why in setup.told[-1]
        for _ in range(260):
            state = setup.cycle()
        assert state.mci_state == MCI_RUNNING and state.header.seqno < 260  # it began anew
        assert setup.told[-1] == "nothing has come for 1 s: the robot stops, and EGM begins anew"
        np.testing.assert_allclose(state.joint_angles, start)


def test_it_stops_where_the_program_falls_silent_and_where_motors_go_off(setup: Setup) -> None:
    goal = np.degrees(HOME) + 90.0
    for _ in range(50):
        setup.cycle(goal)
    for _ in range(50):
        going = setup.cycle()
    before = going.joint_angles
    for _ in range(400):
        state = setup.cycle()
    assert np.all(state.joint_angles > before) and np.all(state.joint_angles < goal + 0.01)
    for _ in range(20):
        setup.cycle(np.degrees(HOME))
    setup.controller.motors_on = False
    setup.cycle(np.degrees(HOME))
    for _ in range(100):
        stood = setup.cycle()
    setup.controller.motors_on = True
    for _ in range(10):
        state = setup.cycle()
    np.testing.assert_array_equal(state.joint_angles, stood.joint_angles)  # what was asked before is over
    assert state.header.seqno == 9


def test_answers_that_come_late_or_from_others_are_dropped(setup: Setup) -> None:
    start = np.degrees(HOME)
    for _ in range(3):
        setup.cycle(start)
    setup.program.send_sequence_number = 1
    setup.cycle(start + 5.0)
    stranger = EGM(port=0)
    stranger.send_sequence_number, stranger.egm_addr = 100, setup.program.egm_addr
    stranger.send_to_robot(start + 5.0)
    for _ in range(20):
        state = setup.cycle()
    np.testing.assert_allclose(state.joint_angles, start)
    stranger.close()


@pytest.mark.long
def test_a_program_moves_the_twin_in_a_kernel(kernel: KernelProcess, stubs: Stubs) -> None:
    program, base = EGM(port=0), virtualrobot.pose(0.5, 1.0, 0.2, yaw=1.0)
    base_t_world = np.linalg.inv(base)
    with virtualrobot.connect(kernel.address) as client:
        arm = client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm", pose=base)
        start = np.array([10.0, 30.0, 5.0, -90.0, 3.0, 60.0, 4.0])
        arm.set_positions(np.radians(start))
        to = f"127.0.0.1:{port_of(program)}"
        command = [sys.executable, "-m", "virtualrobot", "emulate", "egm", "arm", "--to", to, "--timeout", "60"]
        process = subprocess.Popen(
            [*command, "--address", kernel.address], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        with process:
            try:
                # In small steps: what a busy kernel takes together must not be too far for one tick.
                goal = start + np.array([2.0, -2.0, 1.0, 2.0, -1.0, 1.0, -2.0])
                share, state, rests = 0.0, None, 0
                while state is None or rests < 100:  # a goal that stops all at once is overshot
                    there, state = program.receive_from_robot(MINUTE)
                    assert there and state is not None and state.mci_state == MCI_RUNNING
                    share = min(1.0, share + 0.004)
                    off = np.abs([*state.joint_angles, *state.external_axes] - goal).max()
                    rests = rests + 1 if off < 0.01 else 0
                    asked = start + share * (goal - start)
                    assert program.send_to_robot(asked[:6], external_joints=asked[6:])
                np.testing.assert_allclose(np.degrees(arm.positions), goal, atol=0.02)
                position = 1e3 * (base_t_world @ arm.tcp)[:3, 3]
                assert state.cartesian is not None
                told = state.cartesian.pos
                np.testing.assert_allclose([told.x, told.y, told.z], position, atol=1.0)
                # Then down by 20 mm, as with EGMRunPose.
                orient, asked, rests = state.cartesian.orient, position.copy(), 0
                turned = np.array([orient.u0, orient.u1, orient.u2, orient.u3])
                below = position - np.array([0.0, 0.0, 20.0])
                while rests < 100:
                    asked[2] = max(asked[2] - 0.1, below[2])
                    assert program.send_to_robot(cartesian=(asked, turned))
                    there, state = program.receive_from_robot(MINUTE)
                    assert there and state is not None and state.mci_state == MCI_RUNNING and state.cartesian
                    told = state.cartesian.pos
                    off = np.abs([told.x, told.y, told.z] - below).max()
                    rests = rests + 1 if off < 0.1 else 0
                np.testing.assert_allclose(1e3 * (base_t_world @ arm.tcp)[:3, 3], below, atol=0.2)
                while state.mci_state == MCI_RUNNING:
                    program.send_to_robot([10.0, 170.0, 5.0, -90.0, 3.0, 60.0], external_joints=[4.0])
                    there, state = program.receive_from_robot(MINUTE)
                    assert there and state is not None
                assert state.mci_state == MCI_ERROR
            finally:
                process.send_signal(signal.SIGINT)
            lines = process.communicate(timeout=MINUTE)[0].splitlines()
    program.close()
    assert process.returncode == 0, lines
    assert lines[:2] == [f"EGM speaks to {to}, 250 times a second; Ctrl-C ends it", "the computer answers"]
    assert lines[2].startswith("EGM stops: a setpoint is refused: joint 'lbr_iiwa_joint_2' would be at 2.96706 rad")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", "nowhere"], "'nowhere' is not HOST:PORT, such as 127.0.0.1:6510"),
        (["--to", "127.0.0.1:0"], "is not HOST:PORT"),
        (["arm", "--at", "0,1"], "--at goes with an arm of its own, without ROBOT"),
        (["--at", "0,nan"], "has a number that is not finite"),
        (["--to", "no.such.host.invalid:6510"], "no.such.host.invalid:6510 cannot be spoken to"),
    ],
)
def test_wrong_options_are_told(arguments: list[str], words: str) -> None:
    done = CliRunner().invoke(emulate, ["egm", *arguments])
    assert done.exit_code != 0 and words in done.output


def test_an_arm_of_its_own_needs_no_kernel() -> None:
    program = EGM(port=0)
    options = ["--at", "0,-30,30,0,45,10", "--degrees", "--to", f"127.0.0.1:{port_of(program)}"]
    command = [sys.executable, "-m", "virtualrobot", "emulate", "egm", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            there, state = program.receive_from_robot(MINUTE)
            assert there and state is not None
            np.testing.assert_allclose(state.joint_angles, np.degrees(HOME), atol=1e-9)
        finally:
            process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=MINUTE)[0]
    program.close()
    assert process.returncode == 0, said
