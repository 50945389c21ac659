"""EGM of programs in RAPID without a kernel: the words, and motions whose peer is ABBRobotEGM, in lockstep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from ABBRobotEGM import EGM
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.guided import GuidedMotion, Terms
from virtualrobot_apps.languages.rapid.task import RapidTask

from tests.apps.languages.rapid import fault_of, loaded

HOME = np.array([0.0, -30.0, 30.0, 0.0, 45.0, 10.0])
FAST = math.radians(100.0)
ALL = [True] * 6
MINUTE = 60.0


class Guided:
    """A motion of an arm that is simulated, and the program that guides it."""

    def __init__(self, terms: Terms, axes: list[bool] = ALL, ramp: float = 0.0) -> None:
        """Let the controller speak to the program."""
        self.program = EGM(port=0)  # any that is free
        assert self.program.socket is not None
        to = ("127.0.0.1", self.program.socket.getsockname()[1])
        self.arm = SimulatedArm(np.radians(HOME))
        self.motion = GuidedMotion(self.arm, to, terms, axes, poses=False, ramp=ramp, speeds=np.full(6, 3.0))

    def cycle(self, *asked: Any, **more: Any) -> Any:  # noqa: ANN401 as the package has them
        """Return the state of another cycle, after the answer where there is one."""
        self.motion.cycle()
        there, state = self.program.receive_from_robot(MINUTE)
        assert there and state is not None
        if asked or more:
            assert self.program.send_to_robot(*asked, **more)
        return state

    def close(self) -> None:
        """End both."""
        self.program.close()
        self.motion.close()


@pytest.fixture
def guided(request: pytest.FixtureRequest) -> Iterator[Guided]:
    made = Guided(*request.param)
    yield made
    made.close()


@pytest.mark.parametrize("guided", [(Terms(fastest=FAST),)], indirect=True)
def test_a_motion_has_converged_when_all_joints_were_within_their_ranges_for_a_time(guided: Guided) -> None:
    """The ranges are those of the manual, half a degree to both sides; by hand, 4 ms a cycle."""
    goal = HOME + np.array([8.0, 0.0, 0.0, 0.0, 0.0, -8.0])
    for _ in range(50):
        state = guided.cycle()
        assert not state.mci_convergence_met and guided.motion.met == 0.0  # nobody has asked for anything
    while not guided.cycle(goal).mci_convergence_met:
        assert guided.motion.met == 0.0
    off = goal - np.degrees(guided.arm.read()[0])
    assert 0.0 < np.abs(off).max() <= 0.5
    for _ in range(100):
        state = guided.cycle(goal)
    assert state.mci_convergence_met and guided.motion.met == pytest.approx(101 * 0.004)
    guided.cycle(HOME)
    assert not guided.cycle(HOME).mci_convergence_met and guided.motion.met == 0.0


@pytest.mark.parametrize("guided", [(Terms(fastest=math.radians(10.0)),)], indirect=True)
def test_joints_go_no_faster_than_was_said(guided: Guided) -> None:
    told = [guided.cycle(HOME + 20.0).joint_angles for _ in range(250)]
    speeds = np.diff(told, axis=0) / 0.004
    assert speeds.max() == pytest.approx(10.0, abs=0.01) and speeds.min() >= 0.0
    assert told[-1] - HOME == pytest.approx(10.0, abs=0.5)  # a second, less the arm's lag


@pytest.mark.parametrize(
    "guided",
    [(Terms(fastest=FAST, farthest=math.radians(5.0)), [True, False, True, False, False, False])],
    indirect=True,
)
def test_joints_that_are_left_out_stay_and_others_go_no_farther_than_was_said(guided: Guided) -> None:
    for _ in range(500):
        state = guided.cycle(HOME + np.array([3.0, 3.0, 30.0, 3.0, 3.0, 3.0]))
    np.testing.assert_allclose(state.joint_angles - HOME, [3.0, 0.0, 5.0, 0.0, 0.0, 0.0], atol=1e-3)
    assert not state.mci_convergence_met  # joint 3 is held back


@pytest.mark.parametrize("guided", [(Terms(fastest=FAST), ALL, 1.0)], indirect=True)
def test_what_is_asked_for_comes_to_count_in_the_ramp(guided: Guided) -> None:
    """A share that grows evenly in 1 s: after half of it the arm is sent half of the way."""
    for _ in range(126):
        state = guided.cycle(HOME + 10.0)
    assert state.joint_angles - HOME == pytest.approx(5.0, abs=0.3)  # less the arm's lag of 20 ms, at 10 degrees/s
    for _ in range(250):
        state = guided.cycle(HOME + 10.0)
    assert state.joint_angles - HOME == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize("guided", [(Terms(fastest=FAST, filter=1.0),)], indirect=True)
def test_a_filter_of_first_order_lags_by_its_time_constant(guided: Guided) -> None:
    """The answer to a step is 1 - exp(-2 pi f t)."""
    step = np.full(6, 1.0)
    for _ in range(41):
        guided.cycle(HOME + step)
    sent = guided.motion.setpoint(np.radians(HOME + step))  # the 41st
    wanted = 1.0 - math.exp(-2.0 * math.pi * 41 * 0.004)
    assert np.degrees(sent) - HOME == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("guided", [(Terms(fastest=FAST),)], indirect=True)
def test_it_goes_back_to_where_it_began_in_its_time(guided: Guided) -> None:
    goal = HOME + np.array([10.0, 0.0, 0.0, -10.0, 0.0, 0.0])
    for _ in range(250):
        guided.cycle(goal)
    assert not guided.motion.back
    guided.motion.go_back(1.0)
    for _ in range(125):
        state = guided.cycle(goal)
    assert state.joint_angles - HOME == pytest.approx([5.0, 0.0, 0.0, -5.0, 0.0, 0.0], abs=0.5)
    for _ in range(175):
        guided.cycle(goal)
    assert guided.motion.back


@pytest.mark.parametrize("guided", [(Terms(),)], indirect=True)
def test_silence_counts_from_the_begin_and_from_each_answer(guided: Guided) -> None:
    for _ in range(100):
        guided.cycle()
    assert guided.motion.silence == pytest.approx(0.4)
    guided.cycle(HOME)
    guided.cycle()
    assert guided.motion.silence == 0.0
    for _ in range(500):  # and nothing begins anew by itself
        state = guided.cycle()
    assert guided.motion.silence == pytest.approx(2.0) and state.header.seqno == 601


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ((HOME[:5],), "it is asked for 5 joints and 0 external axes, and has 6 and 0"),
        ((None, (HOME[:3], [1.0, 0.0, 0.0, 0.0])), "it is asked for a pose, and is guided by joints"),
        ((HOME * math.nan,), "which are no numbers"),
    ],
)
@pytest.mark.parametrize("guided", [(Terms(),)], indirect=True)
def test_what_cannot_be_followed_is_told(guided: Guided, asked: tuple[Any, ...], words: str) -> None:
    guided.cycle(*asked)
    guided.cycle()
    assert words in guided.motion.refused


def test_it_goes_on_from_where_it_was_stopped_with_a_ramp() -> None:
    guided = Guided(Terms(fastest=FAST), ALL, 0.5)
    try:
        for _ in range(100):
            guided.cycle(HOME + 10.0)
        guided.arm.halt()
        for _ in range(20):
            guided.arm.advance(0.004)
        guided.motion.begin_here()
        stood = guided.cycle(HOME + 10.0).joint_angles
        assert guided.cycle(HOME + 10.0).joint_angles == pytest.approx(stood, abs=0.05)
        for _ in range(250):
            state = guided.cycle(HOME + 10.0)
        assert state.joint_angles == pytest.approx(HOME + 10.0, abs=1e-3)
    finally:
        guided.close()


# Words.

SETUP = r"EGMGetId id; EGMSetupUC ROB_1, id, 'default', 'UCdevice:'".replace("'", '"')
DATA = r"""
VAR egmident id;
VAR egmstate state;
VAR egm_minmax range := [-0.1, 0.1];
CONST pose none := [[0, 0, 0], [1, 0, 0, 0]];
"""


def run(statements: str, devices: dict[str, tuple[str, int]] | None = None) -> list[str]:
    """Return what a program prints that has no robot."""
    lines: list[str] = []
    program = loaded(f"MODULE Tried{DATA}PROC main()\n{statements}\nENDPROC\nENDMODULE")
    RapidTask(program, None, lines.append, egm=devices).run()
    return lines


def test_programs_are_read_as_people_write_them() -> None:
    r"""Forms of public programs: commas before options, small letters, colons of devices, an id that is reset first."""
    loaded(
        f"""MODULE Tried{DATA}
        PROC main()
          EGMReset id;
          EGMGetId id;
          state := EGMGetState(id);
          IF state <= EGM_STATE_CONNECTED THEN
            EGMSetupUC ROB_1, id, "default", "UCdevice:", \\Joint \\CommTimeout:=5;
          ENDIF
          EGMActJoint id \\Tool:=tool0 \\WObj:=wobj0, \\J1:=range \\J2:=range \\J3:=range \\J4:=range \\J5:=range
            \\J6:=range \\LpFilter:=100 \\Samplerate:=4 \\MaxPosDeviation:=1000 \\MaxSpeedDeviation:=1000;
          EGMRunJoint id, EGM_STOP_HOLD, \\J1 \\J2 \\J3 \\J4 \\J5 \\J6 \\CondTime:=5 \\RampOutTime:=5;
          EGMActPose id \\Tool:=tool0 \\WObj:=wobj0, none, EGM_FRAME_WOBJ, none, EGM_FRAME_BASE
            \\x:=range \\y:=range \\z:=range \\rx:=range \\ry:=range \\rz:=range \\LpFilter:=2 \\MaxSpeedDeviation:=40;
          EGMRunPose id, EGM_STOP_RAMP_DOWN \\x \\y \\z \\CondTime:=20 \\RampInTime:=0.05 \\RampOutTime:=0.5;
          EGMStop id, EGM_STOP_HOLD;
        ERROR
          IF ERRNO = ERR_UDPUC_COMM TRYNEXT;
        ENDPROC
        ENDMODULE"""
    )


def test_the_state_of_a_process_is_told() -> None:
    asked = r'TPWrite "" \Num:=EGMGetState(id);'
    order = (
        'TPWrite "" \\Bool:=EGM_STATE_DISCONNECTED < EGM_STATE_CONNECTED AND EGM_STATE_CONNECTED < EGM_STATE_RUNNING;'
    )
    told = run(rf"EGMReset id; {asked} {SETUP} \Joint; {asked} EGMReset id; {asked} {order}", {"ucDevice": ("::1", 1)})
    assert told == ["0", "1", "0", "TRUE"]


@pytest.mark.parametrize(
    ("statements", "words"),
    [
        (SETUP.partition(";")[2] + r" \Joint;", "this egmident has no process yet; EGMGetId gives it one"),
        (f"{SETUP};", r"EGMSetupUC needs \Joint or \Pose"),
        (rf"{SETUP} \Joint \CommTimeout:=0;", "CommTimeout is a time above 0 s, not 0"),
        (SETUP.replace("UC", "Pc", 2).replace("EGMSetupPc", "EGMSetupUC") + r" \Joint;", "no UDP device 'Pcdevice:'"),
        (rf"{SETUP} \Joint; EGMActPose id, none, EGM_FRAME_BASE, none, EGM_FRAME_BASE;", r"this process with \Pose"),
        (rf"{SETUP} \Joint; EGMActJoint id \SampleRate:=5;", "SampleRate is 4, 8, 12 ... ms, not 5"),
        (rf"{SETUP} \Joint; EGMActJoint id \MaxSpeedDeviation:=0;", "MaxSpeedDeviation is above 0, not 0"),
        (
            rf"{SETUP} \Joint; EGMRunJoint id, EGM_STOP_HOLD \J1;",
            "EGMActJoint has not said yet how this process guides",
        ),
        (rf"{SETUP} \Joint; EGMActJoint id;", "this program was started without a robot"),
    ],
)
def test_what_is_wrong_is_told(statements: str, words: str) -> None:
    with pytest.raises(RapidStopped) as caught:
        run(statements, {"UCdevice": ("127.0.0.1", 6510)})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("EGMStreamStart id;", "EGMStreamStart can't be used here yet"),
        (r"EGMActJoint id \StreamStart;", r"\StreamStart of EGMActJoint can't be used here yet"),
        (r"EGMRunJoint id, EGM_STOP_HOLD \NoWaitCond \J1;", r"\NoWaitCond of EGMRunJoint can't be used here yet"),
        (r'EGMSetupUC ROB_9, id, "a", "b" \Joint;', "'ROB_9' is not declared"),
    ],
)
def test_what_does_not_work_yet_is_refused_by_name(statement: str, words: str) -> None:
    assert words in fault_of(statement, DATA.replace("\n", " "))
