"""EGM of programs in RAPID on a robot of a real kernel, guided by programs with ABBRobotEGM as they are."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from ABBRobotEGM import EGM
from virtualrobot_apps.emulators.abb.controller import Controller
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded
from tests.apps.languages.test_rapid_motion import DATA, numbers
from tests.kernels import KernelProcess
from tests.waiting import PATIENCE_SECONDS, until

pytestmark = pytest.mark.long

READY = np.array([0.0, 0.0, 0.0, 0.0, 30.0, 0.0])
GOAL = READY + np.array([8.0, -5.0, 4.0, 10.0, -6.0, 12.0])
MORE = r"""
VAR egmident id;
VAR egm_minmax near := [-0.05, 0.05];
VAR intnum pressed;
VAR robtarget there;
CONST pose none := [[0, 0, 0], [1, 0, 0, 0]];
PROC connect_joints()
  EGMReset id;
  EGMGetId id;
  EGMSetupUC ROB_1, id, "default", "UCdevice:" \Joint \CommTimeout:=30;
  EGMActJoint id \J1:=near \J2:=near \J3:=near \J4:=near \J5:=near \J6:=near \MaxSpeedDeviation:=60;
ENDPROC
"""
HOME = "MoveAbsJ ready, v1000, fine, tool0;"
TOLD = r"TPWrite ValToStr(CJointT());"
AXES = r"\J1 \J2 \J3 \J4 \J5 \J6"


class Computer:
    """A program that answers each packet with what it asks for, in a thread.

    Attributes:
        asked: where the joints go (degrees), or a position and an orientation; None: it doesn't answer.
        state: the state that was told last; None: none yet.
    """

    def __init__(self) -> None:
        """Listen at a port that is free."""
        self.asked: Callable[[Any], dict[str, Any]] | None = None
        self.state: Any = None
        self._egm, self._over = EGM(port=0), False
        assert self._egm.socket is not None
        self.port = self._egm.socket.getsockname()[1]
        self._thread = threading.Thread(target=self._answer)
        self._thread.start()

    def _answer(self) -> None:
        while not self._over:
            there, state = self._egm.receive_from_robot(0.05)
            if there and state is not None:
                self.state = state
                if self.asked is not None:
                    self._egm.send_to_robot(**self.asked(state))

    @property
    def device(self) -> dict[str, tuple[str, int]]:
        """The UDP device that it is."""
        return {"UCdevice": ("127.0.0.1", self.port)}

    def close(self) -> None:
        """End it."""
        self._over = True
        self._thread.join()
        self._egm.close()


@pytest.fixture
def computer() -> Iterator[Computer]:
    made = Computer()
    yield made
    made.close()


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an IRB 120 that stands somewhere."""
    return client.load_robot("model://irb120", name="arm", pose=virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4))


def text(statements: str) -> str:
    """Return a module whose main has these statements."""
    return f"MODULE Tried\n{DATA.strip()}{MORE}\nPROC main()\n{statements}\nENDPROC\nENDMODULE\n"


def run(client: virtualrobot.Client, statements: str, computer: Computer) -> list[str]:
    """Return what a program prints that the computer guides."""
    lines: list[str] = []
    program = loaded(text(statements), client.signals)
    RapidTask(program, World(client, "arm"), lines.append, egm=computer.device).run()
    return lines


def joints_told(line: str) -> np.ndarray:
    """Return the joints of a jointtarget that was printed."""
    return np.array(numbers(line)[:6])


def test_joints_are_guided_until_they_have_been_there_for_a_time(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer
) -> None:
    computer.asked = lambda state: {"joint_angles": GOAL}
    lines = run(
        client,
        rf"""
        {HOME}
        connect_joints;
        TPWrite "" \Num:=EGMGetState(id);
        EGMRunJoint id, EGM_STOP_HOLD {AXES} \CondTime:=0.2 \RampInTime:=0.2;
        TPWrite "" \Num:=EGMGetState(id);
        {TOLD}
        MoveAbsJ ready, v1000, fine, tool0;
        EGMRunJoint id, EGM_STOP_RAMP_DOWN \J1 \J6 \CondTime:=0.1 \RampInTime:=0 \RampOutTime:=0.2;
        {TOLD}
        """,
        computer,
    )
    assert lines[:2] == ["1", "1"]
    np.testing.assert_allclose(joints_told(lines[2]), GOAL, atol=0.06)  # within its range, and a little on its way
    np.testing.assert_allclose(joints_told(lines[3]), READY, atol=0.02)  # it has gone back
    assert computer.state.rapid_running and computer.state.motors_on


def test_a_silent_computer_is_an_error_of_the_program(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer
) -> None:
    lines = run(
        client,
        rf"""
        {HOME}
        EGMGetId id;
        EGMSetupUC ROB_1, id, "default", "ucdevice" \Joint \CommTimeout:=0.2;
        EGMActJoint id;
        EGMRunJoint id, EGM_STOP_HOLD {AXES};
        {TOLD}
        ERROR
          TPWrite "" \Bool:=ERRNO = ERR_UDPUC_COMM;
          TPWrite "" \Num:=EGMGetState(id);
          TRYNEXT;
        """,
        computer,
    )
    assert lines[:2] == ["TRUE", "1"]
    np.testing.assert_allclose(joints_told(lines[2]), READY, atol=1e-4)
    assert computer.state is not None


def test_a_trap_stops_it_and_it_goes_back(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer
) -> None:
    client.signals.create("halt")
    computer.asked = lambda state: {"joint_angles": GOAL}
    statements = rf"""
        {HOME}
        connect_joints;
        CONNECT pressed WITH stops;
        ISignalDI halt, 1, pressed;
        EGMRunJoint id, EGM_STOP_HOLD {AXES} \CondTime:=1000 \RampInTime:=0;
        {TOLD}
        EGMStop id, EGM_STOP_HOLD;
        ENDPROC
        TRAP stops
          TPWrite "" \Num:=EGMGetState(id);
          EGMStop id, EGM_STOP_RAMP_DOWN \RampOutTime:=0.3;
        ENDTRAP
        PROC other()
        """

    def press() -> None:
        until(lambda: computer.state is not None and computer.state.mci_convergence_met)
        client.signals["halt"] = True

    thread = threading.Thread(target=press)
    thread.start()
    try:
        running, told = run(client, statements, computer)
    finally:
        thread.join()
    assert running == "2"
    np.testing.assert_allclose(joints_told(told), READY, atol=0.02)


def test_a_pose_is_guided_in_the_frame_of_a_work_object(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer
) -> None:
    """The tool goes 20 mm along x and y of the table, where it is asked to go 20 mm up as well."""
    first: list[np.ndarray] = []

    def asked(state: Any) -> dict[str, Any]:  # noqa: ANN401
        place = state.cartesian
        first.append(np.array(place.pos))
        turned = np.array([place.orient.u0, place.orient.u1, place.orient.u2, place.orient.u3])
        return {"cartesian": (first[0] + 20.0, turned)}

    computer.asked = asked
    lines = run(
        client,
        r"""
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        EGMGetId id;
        EGMSetupUC ROB_1, id, "default", "UCdevice" \Pose \CommTimeout:=30;
        EGMActPose id \Tool:=tool0 \WObj:=table, none, EGM_FRAME_WOBJ, none, EGM_FRAME_WOBJ
          \X:=near \Y:=near \Z:=near \MaxSpeedDeviation:=60;
        EGMRunPose id, EGM_STOP_HOLD \X \Y \CondTime:=0.1 \RampInTime:=0.5;
        there := CRobT(\Tool:=tool0 \WObj:=table);
        TPWrite ValToStr(there.trans);
        TPWrite ValToStr(there.rot);
        """,
        computer,
    )
    np.testing.assert_allclose(first[0], [0.0, 0.0, 150.0], atol=0.01)
    np.testing.assert_allclose(numbers(lines[0]), [20.0, 20.0, 150.0], atol=0.1)
    assert abs(numbers(lines[1])[2]) == pytest.approx(1.0, abs=1e-6)  # a quaternion and its negative are one turn


def test_what_cannot_be_followed_ends_the_program(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer
) -> None:
    statements = rf"{HOME} connect_joints; EGMRunJoint id, EGM_STOP_HOLD {AXES} \RampInTime:=0;"
    for asked, words in (
        ({"joint_angles": READY + 1000.0}, "EGM stops: a setpoint is refused: joint"),
        ({"joint_angles": READY[:5]}, "EGM stops: it is asked for 5 joints"),
        (
            {"cartesian": (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))},
            "it is asked for a pose, and is guided by joints",
        ),
    ):
        computer.asked = lambda state, asked=asked: asked
        with pytest.raises(RapidStopped, match=words):
            run(client, statements, computer)
        assert np.abs(arm.state.velocities).max() == 0.0
    with pytest.raises(RapidStopped, match="EGM needs the computer that guides"):
        recorded(client, "arm", loaded(text(statements)))


def test_a_controller_that_is_stopped_stands_and_goes_on(
    client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer, tmp_path: Path
) -> None:
    computer.asked = lambda state: {"joint_angles": GOAL}
    controller = Controller(client, ["arm"], tmp_path, create_signals=True, egm=computer.device)
    try:
        statements = rf"{HOME} connect_joints; EGMRunJoint id, EGM_STOP_HOLD {AXES} \CondTime:=1000;"
        controller.load_module("T_ROB1", Source(text(statements), "tried.mod"))
        controller.reset_pointer()
        controller.start("once")
        until(lambda: computer.state is not None and computer.state.mci_convergence_met)
        controller.stop()
        until(lambda: not controller.running)
        assert np.abs(arm.state.velocities).max() < 1e-9
        count = computer.state.header.seqno
        computer.asked = lambda state: {"joint_angles": READY}
        controller.start()
        until(lambda: computer.state.header.seqno > count + 100 and computer.state.mci_convergence_met)
        # It may have passed the goal for a moment: setpoints that come late on a busy machine are carried on from.
        until(lambda: np.abs(np.degrees(arm.positions) - READY).max() < 0.1)
    finally:
        controller.close()


@contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Give a command of ours, as a process."""
    command = [sys.executable, "-m", "virtualrobot", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def test_the_command_names_the_device(
    kernel: KernelProcess, client: virtualrobot.Client, arm: virtualrobot.Robot, computer: Computer, tmp_path: Path
) -> None:
    computer.asked = lambda state: {"joint_angles": GOAL}
    file = tmp_path / "guided.mod"
    file.write_text(text(rf"connect_joints; EGMRunJoint id, EGM_STOP_HOLD {AXES} \CondTime:=0.1; {TOLD}"))
    run = ("rapid", "run", str(file), "--robot", "arm", "--address", kernel.address)
    with started(*run, "--egm", f"UCdevice=127.0.0.1:{computer.port}") as process:
        said = process.communicate(timeout=PATIENCE_SECONDS)[0]
    assert process.returncode == 0, said
    np.testing.assert_allclose(joints_told(said), GOAL, atol=0.06)
    with started(*run, "--egm", "pc=127.0.0.1:1") as process:
        said = process.communicate(timeout=PATIENCE_SECONDS)[0]
    assert "there is no UDP device 'UCdevice:': name it by --egm UCdevice=HOST:PORT; there are: pc" in said
    with started(*run, "--egm", "UCdevice") as process:
        said = process.communicate(timeout=PATIENCE_SECONDS)[0]
    assert "'UCdevice' is not NAME=HOST:PORT, such as UCdevice=127.0.0.1:6510" in said
    with started("rapid", "check", str(file), "--run", "--robot", "arm", "--address", kernel.address) as process:
        said = process.communicate(timeout=PATIENCE_SECONDS)[0]
    assert (
        "EGM needs the computer that guides, which is not there where a program is only tried" in said
        and process.returncode == 1
    )
