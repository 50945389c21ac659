"""Programs at work in processes of their own: others see them, stop them and answer what they ask."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.tasks import ProgramTask
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script

from tests.kernels import KernelProcess
from tests.waiting import until

RAPID = r"""MODULE Turns
  CONST jointtarget here := [[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget there := [[60, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  PROC main()
    VAR num answer;
    TPReadFK answer, "Go on?", "Yes", "No", stEmpty, stEmpty, stEmpty;
    TPWrite "answer " \Num:=answer;
    WHILE TRUE DO
      MoveAbsJ there, v200, fine, tool0;
      MoveAbsJ here, v200, fine, tool0;
    ENDWHILE
  ENDPROC
ENDMODULE
"""
RAPL = "10 INPUT COUNT\n20 DELAY 0.1\n30 TYPE 'ROUND'\n40 GOTO 20\n"
SCRIPT = 'def spin():\n  textmsg("off it goes")\n  while True:\n    sleep(0.01)\n  end\nend\n'


@contextmanager
def running(kernel: KernelProcess, *arguments: str | Path) -> Iterator[subprocess.Popen[str]]:
    """Give a command at work, whose terminal nobody types at."""
    command = [sys.executable, "-m", "virtualrobot", *map(str, arguments), "--address", kernel.address]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, text=True, stdin=pipe, stdout=pipe, stderr=pipe)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def found(client: virtualrobot.Client, name: str, **wanted: str) -> ProgramTask:
    """Return a task once it is so."""

    def matching() -> list[ProgramTask]:
        tasks = [one for one in client.tasks.list() if one.name == name and not one.is_over]
        return [one for one in tasks if all(getattr(one, key) == value for key, value in wanted.items())]

    until(lambda: bool(matching()))
    return matching()[0]


def test_a_program_in_rapid_is_seen_answered_and_stopped_from_elsewhere(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    arm = client.load_robot("model://irb120", name="arm")
    file = tmp_path / "turns.mod"
    file.write_text(RAPID)
    with running(kernel, "rapid", "run", file, "--robot", "arm") as process:
        one = found(client, "T_ROB1", state="asking")
        assert (one.language, one.robot, one.files, one.question) == ("RAPID", "arm", (str(file),), "Go on?")
        assert one.choices == ("Yes", "No") and one.program_pointer == f"{file}:6" and one.is_held
        client.tasks.answer("T_ROB1", "maybe")
        client.tasks.answer("T_ROB1", "No")
        one = found(client, "T_ROB1", state="running", motion_pointer=f"{file}:9")
        assert one.lines[-1] == "answer 2" and any("none of them" in line for line in one.lines)
        with pytest.raises(virtualrobot.InvalidArgumentError, match="takes no wish 'answer'"):
            client.tasks.answer("T_ROB1", "Yes")
        client.tasks.stop("T_ROB1")
        assert process.wait(60.0) == 1
        assert process.communicate()[1].startswith("stopped by ")
    over = client.tasks.get(one.id)
    assert over.is_over and over.state.startswith("stopped by ") and over.program_pointer == ""
    assert not np.any(arm.state.velocities)
    with pytest.raises(virtualrobot.WrongStateError, match=r"^no task T_ROB1 runs: .* is over .stopped by"):
        client.tasks.stop(one.id)
    client.records.forget(one.id)


def test_a_program_whose_process_dies_is_forgotten(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    client.load_robot("model://irb120", name="arm")
    file = tmp_path / "turns.mod"
    file.write_text(RAPID)
    with running(kernel, "rapid", "run", file, "--robot", "arm") as process:
        one = found(client, "T_ROB1", state="asking")
        process.kill()
        until(lambda: one.id not in [each.id for each in client.tasks.list()])


def test_a_program_in_rapl_is_answered_and_stopped(
    kernel: KernelProcess, client: virtualrobot.Client, tmp_path: Path
) -> None:
    client.load_robot("model://a255", name="arm")
    file = tmp_path / "ROUNDS.rpl"
    file.write_text(RAPL)
    with running(kernel, "rapl", "run", file, "--robot", "arm") as process:
        one = found(client, "ROUNDS", state="asking")
        assert (one.language, one.question, one.program_pointer) == ("RAPL-II", "COUNT?", f"{file}:1")
        client.tasks.answer("ROUNDS", "7")
        until(lambda: "ROUND" in client.tasks.get(one.id).lines)
        client.tasks.stop("ROUNDS")
        assert process.wait(60.0) == 1
    assert client.tasks.get(one.id).is_over
    client.records.forget(one.id)


def test_a_script_on_an_emulated_controller_is_stopped(client: virtualrobot.Client) -> None:
    controller = Controller(SimulatedArm(np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])))
    controller.begun = lambda program: program.tell(client, "arm")

    def cycles() -> bool:
        controller.cycle()
        return controller.program is None

    run_script(controller, SCRIPT)
    until(lambda: cycles() or [one.lines for one in client.tasks.list()] == [("off it goes",)])
    one = found(client, "spin", state="running")
    assert (one.language, one.robot, one.program_pointer) == ("URScript", "arm", "script:4")
    assert controller.pause()
    client.tasks.stop("spin")
    until(cycles)
    until(lambda: client.tasks.get(one.id).is_over)
    assert client.tasks.get(one.id).state.startswith("stopped by ")
    client.records.forget(one.id)


def test_a_script_that_fails_says_why(client: virtualrobot.Client) -> None:
    controller = Controller(SimulatedArm(np.zeros(6)))
    controller.begun = lambda program: program.tell(client, "arm")
    run_script(controller, "def wrong():\n  x = 1 / (get_joint_temp(0) * 0)\nend\n")
    if controller.program is None:
        pytest.fail(str(controller.words))
    controller.cycle()
    until(lambda: any(one.state.startswith("failed: script:2") for one in client.tasks.list()))
