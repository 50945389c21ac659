"""The shell on a real kernel: commands from a pipe, from a terminal, and jog by keys."""

from __future__ import annotations

import subprocess
import sys
import threading

import numpy as np
import pytest
from prompt_toolkit.input import create_pipe_input
from prompt_toolkit.output import DummyOutput
from virtualrobot import Client, Phase, Robot
from virtualrobot.cli.key_hold import hold_by_key
from virtualrobot.cli.key_jog import jog_by_keys
from virtualrobot.cli.options import Session, Target
from virtualrobot.cli.shell import begun_word, interactive, run_line, split

from tests.waiting import until

COMMAND = [sys.executable, "-m", "virtualrobot", "shell"]


def test_lines_are_split_as_people_write_them() -> None:
    assert split('attach "a box" table # there') == ["attach", "a box", "table"]
    assert split(r"load C:\cell\arm.urdf") == ["load", r"C:\cell\arm.urdf"]
    assert begun_word("move ar") == (["move"], "ar")
    assert begun_word("move ") == (["move"], "")
    assert begun_word('attach "a b') == (["attach"], "a b")


def test_lines_of_a_pipe_run_in_one_process(client: Client, environment: None) -> None:
    lines = "add box a --size 1,1,1\n\n# a comment\nvirtualrobot rename a b\nlease nobody\nadd box c --size 1,1,1\n"
    done = subprocess.run(COMMAND, input=lines, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (1, "added a\nrenamed a to b\n")
    assert "'nobody'" in done.stderr and "line 5 failed: lease nobody" in done.stderr
    assert {node.name for node in client.scene.nodes()} == {"world", "b"}
    done = subprocess.run(COMMAND, input="ls\nexit\nremove b\n", capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout) == (0, "world (world)\n└─ b (object)\n")


def test_a_terminal_has_leases_history_and_goes_on_after_errors(
    client: Client, iiwa: Robot, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    monkeypatch.setattr("platformdirs.user_state_path", lambda name: tmp_path)
    target = Target(session=Session(client))
    with create_pipe_input() as keys:
        keys.send_text("lease iiwa\nmvoe\nshell\nhelp\nlease --end\nexit\n")
        assert interactive(target, keys, DummyOutput()) == 0
    printed = capsys.readouterr()
    assert "leased iiwa as lease" in printed.out and "Commands:" in printed.out and "released" in printed.out
    assert "did you mean 'move'" in printed.err and "a shell already" in printed.err
    assert client.leases() == []
    assert "+lease iiwa" in (tmp_path / "shell_history").read_text("utf-8")  # pyright: ignore[reportOperatorIssue]
    assert run_line('rename "', target) == 2


def test_keys_jog(client: Client, iiwa: Robot) -> None:
    """Each key is a step: of 20 mm along the base's z, then of ten times as many radians of the second joint."""
    iiwa.set_positions([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])
    above = iiwa.tcp[:3, 3]
    _keys(client, iiwa, "]Zq")
    np.testing.assert_allclose(iiwa.tcp[:3, 3], above - [0.0, 0.0, 0.02], atol=1e-4)
    before = iiwa.positions
    _keys(client, iiwa, "2+q")
    np.testing.assert_allclose(iiwa.positions - before, [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-9)
    _keys(client, iiwa, "[[2-fxRq\x1b")
    assert client.motions() == []


@pytest.mark.long
def test_the_space_key_holds_a_motion(iiwa: Robot) -> None:
    """It runs while the key is held, stands on its path when it is let go, and ends at q."""
    motion = iiwa.move_joints([1.0] * 7, speed_factor=0.03, hold=True)
    with create_pipe_input() as keys:
        over = threading.Event()

        def hold_until(progress: float) -> None:
            while motion.progress < progress and not over.is_set():  # a terminal repeats the key of who holds it
                keys.send_text(" ")
                over.wait(0.05)

        def press() -> None:
            try:
                hold_until(0.01)
                until(lambda: motion.phase is Phase.PAUSED)
                hold_until(0.05)
            finally:
                keys.send_text("q")

        presser = threading.Thread(target=press)
        presser.start()
        try:
            hold_by_key(motion, keys, DummyOutput())
        finally:
            over.set()
            presser.join()
    assert motion.phase is Phase.CANCELLED and 0.05 <= motion.progress < 1.0
    np.testing.assert_allclose(iiwa.positions, iiwa.positions[0], atol=1e-9)  # on its path, which is a straight one


def test_a_motion_that_is_held_to_its_end_ends_the_wait(iiwa: Robot) -> None:
    motion = iiwa.move_joints([0.05] * 7, hold=True)
    with create_pipe_input() as keys:
        over = threading.Event()

        def press() -> None:
            while not over.is_set():
                keys.send_text(" ")
                over.wait(0.05)

        presser = threading.Thread(target=press)
        presser.start()
        try:
            hold_by_key(motion, keys, DummyOutput())
        finally:
            over.set()
            presser.join()
    assert motion.phase is Phase.SUCCEEDED


def _keys(client: Client, robot: Robot, text: str) -> None:
    """Press keys, and wait for the motion of the last one."""
    with create_pipe_input() as keys:
        keys.send_text(text)
        jog_by_keys(robot, keys, DummyOutput())
    for motion in client.motions():
        motion.wait()
