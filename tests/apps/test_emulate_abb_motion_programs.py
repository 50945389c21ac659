"""Programs of abb-motion-program-exec, unmodified, on the emulated ABB controller."""

from __future__ import annotations

import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from abb_motion_program_exec import (
    CirPathModeSwitch,
    EGMJointTargetConfig,
    MotionProgram,
    MotionProgramExecClient,
    confdata,
    egm_minmax,
    fine,
    jointtarget,
    pose,
    robtarget,
    tool0,
    tooldata,
    v300,
    v1000,
    z10,
)
from ABBRobotEGM import EGM

from tests.apps.abb import Served, served, stands
from tests.apps.languages.tracing import traced
from tests.kernels import KernelProcess
from tests.waiting import until

pytestmark = pytest.mark.long


@pytest.fixture
def abb(client: virtualrobot.Client, tmp_path: Path) -> Iterator[Served]:
    client.clock.speed_factor = 5.0
    client.load_robot("model://irb120", name="arm")
    with served(client, ["arm"], tmp_path) as one:
        one.controller.load_motion_programs()
        yield one


def client_of(url: str) -> Any:  # noqa: ANN401 what its calls return depends on their arguments
    """Return the package's client of a controller."""
    return MotionProgramExecClient(url)


def joints(*angles: float) -> jointtarget:
    """Return a place by six angles in degrees."""
    return jointtarget(np.array(angles), np.zeros(6))


def place(*position: float) -> robtarget:
    """Return a place of the tool centre point in mm, pointing down."""
    return robtarget(np.array(position), np.array([0.0, 0.0, 1.0, 0.0]), confdata(0, 0, 0, 0), np.zeros(6))


def first(count: int = 1, **more: object) -> MotionProgram:
    """Return a program whose commands begin with a number, and whose first one goes to a place by joints."""
    program = MotionProgram(first_cmd_num=count, **more)  # type: ignore[arg-type]
    program.MoveAbsJ(joints(0, 0, 0, 0, 30, 0), v1000, fine)
    return program


def test_a_program_moves_the_robot_and_its_log_comes_back(abb: Served, client: virtualrobot.Client) -> None:
    program = first(tool=tooldata(True, pose(np.array([0, 0, 50]), np.array([1, 0, 0, 0])), tool0.tload))
    program.MoveJ(place(400, 0, 300), v1000, fine)
    program.MoveL(place(400, 100, 300), v300, z10)
    program.MoveL(place(400, 100, 400), v300, fine)
    program.MoveC(place(400, 50, 450), place(400, 0, 400), v300, fine)
    program.WaitTime(0.2)
    run, logs = client_of(abb.url), []
    way = traced(client, lambda: logs.append(run.execute_motion_program(program)))
    (log,) = logs
    assert log.timestamp == program.get_timestamp()
    assert log.column_headers == ["timestamp", "cmdnum", "J1", "J2", "J3", "J4", "J5", "J6"]
    assert (np.diff(log.data[:, 0]) > 0.0).all() and (np.diff(log.data[:, 1]) >= 0.0).all()
    assert log.data[-1, 1] == 6 == run.get_current_cmdnum()
    np.testing.assert_allclose(log.data[-1, 2:], run.abb_client.get_jointtarget().robax, atol=1e-4)
    # The tip, 50 mm from the flange, went through the places: the corner of z10 may be cut, the others are met.
    for corner, near in (([0.4, 0.0, 0.3], 1e-5), ([0.4, 0.1, 0.3], 10e-3), ([0.4, 0.1, 0.4], 1e-5)):
        assert np.linalg.norm(way[:, 1:] - corner, axis=1).min() < near
    np.testing.assert_allclose(run.abb_client.get_robtarget().trans, [400.0, 0.0, 450.0], atol=1e-3)  # of the flange
    assert run.abb_client.list_files("$HOME") == ["motion_program.bin"]  # the client has deleted its log
    assert not run.is_motion_program_running()


def test_a_program_that_runs_gets_another_end(abb: Served, client: virtualrobot.Client) -> None:
    client.clock.speed_factor = 1.0  # the other end comes seconds before it is needed
    run, program = client_of(abb.url), first()
    for turn in range(1, 13):
        program.MoveAbsJ(joints(40 * (turn % 2), 0, 0, 0, 30, 0), v300, fine)
    before = run.execute_motion_program(program, wait=False)
    until(lambda: run.get_current_cmdnum() >= 2)
    other = MotionProgram(first_cmd_num=10)
    other.MoveAbsJ(joints(-33, 0, 0, 0, 30, 0), v1000, fine)
    run.preempt_motion_program(other, preempt_number=1, preempt_cmdnum=9)
    run.wait_motion_program_complete()
    assert (run.get_current_preempt_number(), run.get_current_cmdnum(), run.get_queued_cmdnum()) == (1, 10, 10)
    np.testing.assert_allclose(run.abb_client.get_jointtarget().robax[0], -33.0, atol=1e-6)
    assert run.read_motion_program_result_log(before).data[-1, 1] == 10


def test_a_program_is_stopped_and_runs_without_a_log(abb: Served) -> None:
    run, program = client_of(abb.url), first()
    program.MoveAbsJ(joints(90, 0, 0, 0, 30, 0), v300, fine)
    run.disable_motion_logging()
    assert not run.get_motion_logging_enabled()
    run.execute_motion_program(program, wait=False)
    until(lambda: run.abb_client.get_jointtarget().robax[0] > 5.0)
    run.stop_motion_program()
    until(stands(run.abb_client))
    assert run.abb_client.get_jointtarget().robax[0] < 89.0
    assert run.execute_motion_program(first()).data.shape == (0, 8)
    run.enable_motion_logging()
    assert len(run.execute_motion_program(first()).data) > 0


def test_a_program_is_guided_by_egm_until_it_has_converged_or_is_stopped(
    client: virtualrobot.Client, tmp_path: Path
) -> None:
    """The example of the package's documentation (docs/egm.md), with goals that the arm has."""
    client.load_robot("model://irb120", name="arm")
    guide: Any = EGM(port=0)
    port = guide.socket.getsockname()[1]
    over = False
    asked = np.array([5.0, 0.0, 0.0, 0.0, 30.0, -5.0])
    seen: list[bool] = []

    def answer() -> None:
        while not over:
            there, state = guide.receive_from_robot(0.05)
            if there:
                guide.send_to_robot(asked)
                seen.append(state.robot_message.mciConvergenceMet)

    thread = threading.Thread(target=answer)
    with served(client, ["arm"], tmp_path, egm={"UCdevice": ("127.0.0.1", port)}) as one:
        thread.start()
        try:
            one.controller.load_motion_programs()
            run, near = client_of(one.url), egm_minmax(-0.05, 0.05)
            config = EGMJointTargetConfig(near, near, near, near, near, near, 1000, 60)
            for condition in (0.1, 1000.0):
                program = first(egm_config=config)
                program.EGMRunJoint(condition, 0.05, 0.05)
                seen.clear()
                run.execute_motion_program(program, wait=False)
                if condition > 1.0:
                    until(lambda: False in seen and seen[-1])  # the last word of the run before may come late
                    run.stop_egm()
                run.wait_motion_program_complete()
                np.testing.assert_allclose(run.abb_client.get_jointtarget().robax, asked, atol=0.06)
        finally:
            over = True
            thread.join()
            guide.socket.close()


def test_programs_that_cannot_be_run_are_told(abb: Served) -> None:
    run = client_of(abb.url)
    circle, far, egm, path, together = first(), first(), first(), first(), first()
    circle.CirPathMode(CirPathModeSwitch.ObjectFrame)
    far.MoveL(place(4000, 0, 0), v1000, fine)
    egm.EGMRunJoint(1.0, 0.1, 0.1)
    path.EGMMoveL(place(400, 0, 300), v300, fine)
    together.SyncMoveOn()
    for program, words in (
        (circle, "in command 2 CirPathMode does not work here yet"),
        (far, "in command 2 error .* program of .* the log tells more"),
        (egm, "in command 2 the program has no EGM configuration for this command"),
        (path, "in command 2 path correction by EGM does not work here yet"),
        (together, "in command 2 SyncMoveOn and SyncMoveOff do not work here yet"),
    ):
        with pytest.raises(Exception, match=words):
            run.execute_motion_program(program)
    error = next(one for one in run.abb_client.read_event_log() if one.args and "ERR_ROBLIMIT" in one.args[0])
    assert error.args[0].startswith("motion_program_exec.mod:")
    good = first().get_program_bytes()
    for data, words in (
        (struct.pack("<f", 10010.0) + good[4:], "its format is 10010 and not 10011"),
        (good[:-6], "its file ends within a command"),
        (good[:268] + struct.pack("<2f", 1.0, 99.0), "there is no command code 99"),
        (b"", "its file ends within a command"),
    ):
        rws = run.abb_client
        rws.upload_file("RAMDISK:/motion_program.bin", data)
        rws.resetpp()
        rws.start(cycle="once")
        until(stands(rws))
        told = next(one for one in rws.read_event_log() if one.args[0] == "Motion Program Failed")
        assert told.args[2] == words


def test_the_command_brings_what_runs_them(kernel: KernelProcess, client: virtualrobot.Client) -> None:
    client.load_robot("model://irb120", name="arm")
    command = [sys.executable, "-m", "virtualrobot", "emulate", "abb", "arm", "--port", "0", "--motion-programs"]
    command += ["--until-input-ends", "--address", kernel.address]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            url = process.stdout.readline().split()[4].rstrip(";")
            log = client_of(url).execute_motion_program(first())
            np.testing.assert_allclose(log.data[-1, 2:], [0.0, 0.0, 0.0, 0.0, 30.0, 0.0], atol=1e-4)
        finally:
            process.kill()
