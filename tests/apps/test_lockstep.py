"""Lockstep with outside controllers: time waits for each command, and a controller that fails is told in words."""

from __future__ import annotations

import json
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import CallTimeoutError, InvalidArgumentError, LimitError, RobotBusyError, WrongStateError
from virtualrobot.motions.state import Phase
from virtualrobot_apps.lockstep.exchange import Lockstep
from virtualrobot_apps.lockstep.wire import ProgramWire, SocketWire, listen

from tests.kernels import KernelProcess
from tests.waiting import until

DOCS = Path(__file__).resolve().parents[2] / "docs" / "lockstep.md"
COMMANDS = DOCS.with_name("command-line.md")
OCTAVE = shutil.which("octave-cli")
GUARD = 60.0


@pytest.fixture
def ugv(steps: virtualrobot.Client) -> virtualrobot.Client:
    """Return a client of a stepped world with a UGV."""
    steps.load_robot("model://ugv", name="ugv", base="planar")
    return steps


class Played:
    """A controller of the test: it answers states by lines, and keeps what it was told."""

    def __init__(self, *lines: str | None) -> None:
        """Answer these lines one after the other; None: never."""
        self.lines, self.told = list(lines), []

    def send(self, line: str) -> None:
        self.told.append(json.loads(line))

    def receive(self, seconds: float) -> str | None:
        if not self.lines:
            return None
        line = self.lines.pop(0)
        if line is None:
            raise CallTimeoutError(f"the controller has not answered for {seconds:g} s")
        return line

    def close(self) -> None:
        pass


def block(language: str) -> str:
    """Return the controller that the page has in a language."""
    found = re.findall(rf"```{language}\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)
    return found[0]


def pose(client: virtualrobot.Client) -> np.ndarray:
    return client.robot("ugv").tcp[:2, 3]


def test_time_goes_on_by_a_period_for_each_command(ugv: virtualrobot.Client) -> None:
    wire = Played(*['{"twist": [0.3, 0, 0]}'] * 20)
    run = Lockstep(ugv, "ugv", 0.05).run(wire, GUARD)
    assert (run.steps, run.seconds, run.end) == (20, pytest.approx(1.0), "the controller has ended")
    times = [state["time"] for state in wire.told]
    # 50 ms are 12.5 ticks of 4 ms: what a period leaves over the next one makes up for.
    np.testing.assert_allclose(times, [round(0.05 * k / 0.004) * 0.004 for k in range(21)], atol=1e-12)
    assert wire.told[-1]["robot"]["position"][0] > 0.2
    assert not ugv.robot("ugv").state.velocities.any()  # it rests


def test_the_state_has_sensors_and_signals_and_a_command_may_set_some(ugv: virtualrobot.Client) -> None:
    ugv.signals.create("lamp", False)
    wire = Played('{"signals": {"lamp": true}}', '{"done": true}')
    run = Lockstep(ugv, "ugv", 0.05, ["ugv.lidar", "ugv.imu", "ugv.encoders"]).run(wire, GUARD)
    assert (run.steps, run.end) == (1, "the controller is done")
    assert [state["signals"]["lamp"] for state in wire.told] == [False, True]
    sensors = wire.told[1]["sensors"]
    assert len(sensors["ugv.lidar"]["distances"]) == 360 and sensors["ugv.lidar"]["distances"][0] is None
    assert sensors["ugv.imu"]["linear_acceleration"][2] == pytest.approx(9.81, abs=0.5)  # gravity, at rest
    assert set(wire.told[0]["robot"]) == {
        *("name", "positions", "velocities", "position", "heading", "world_t_tcp"),
    }


def test_joints_are_commanded_as_well(steps: virtualrobot.Client) -> None:
    arm = steps.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
    goal = '{"velocities": {"lbr_iiwa_joint_1": 0.5}}'
    Lockstep(steps, "arm", 0.02).run(Played(*[goal] * 50), GUARD)
    assert arm.positions[0] > 0.3 and not arm.state.velocities.any()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("stop!", "no JSON: 'stop!'"),
        ("[1, 2]", "an object with twist"),
        ('{"twits": [1, 0, 0]}', r"not \['twits'\]"),
        ('{"twist": "fast"}', "'twist' is a list of finite numbers"),
        ('{"twist": [NaN, 0, 0]}', "'twist' is a list of finite numbers"),
        ('{"twist": [0.1]}', "vx, vy, omega|3 joints"),
        ('{"signals": 3}', "'signals' are values by name"),
        ('{"signals": {"lamp": true}}', "lamp"),
    ],
)
def test_what_is_no_command_is_told_and_the_robot_rests(ugv: virtualrobot.Client, line: str, words: str) -> None:
    with pytest.raises(virtualrobot.VirtualRobotError, match=words):
        Lockstep(ugv, "ugv", 0.05).run(Played(*['{"twist": [0.3, 0, 0]}'] * 5, line), GUARD)
    assert not ugv.robot("ugv").state.velocities.any()


@pytest.mark.parametrize(
    ("line", "error", "words"),
    [
        ('{"velocities": {"left_wheeel": 1}}', virtualrobot.UnknownNameError, "left_wheeel"),
        ('{"velocities": [1, 2, 3]}', InvalidArgumentError, "values"),
        ('{"velocities": {"left_wheel": 999}}', virtualrobot.VirtualRobotError, "left_wheel|motion-"),
        ('{"velocities": {"left_wheel": 1, "right_wheel": 1}}', RobotBusyError, "ugv"),
        ('{"twist": [0.1, 0, 0], "velocities": {"left_wheel": 1}}', RobotBusyError, "ugv"),
    ],
)
def test_a_refused_command_of_another_kind_leaves_nothing_that_drives_on(
    ugv: virtualrobot.Client, line: str, error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        Lockstep(ugv, "ugv", 0.05).run(Played(*['{"twist": [0.3, 0, 0]}'] * 5, line), GUARD)
    there = pose(ugv)
    ugv.clock.step(250)
    np.testing.assert_array_equal(pose(ugv), there)
    run = Lockstep(ugv, "ugv", 0.05).run(Played('{"velocities": {"left_wheel": 1, "right_wheel": 1}}'), GUARD)
    assert run.steps == 1  # nothing moves it any more


def test_a_step_ends_the_twist_or_the_velocities_of_a_robot_that_follows_both(steps: virtualrobot.Client) -> None:
    steps.load_robot("model://frankie", base="planar")
    arm = "panda_joint1"
    wire = Played(*[json.dumps({"twist": [0.2, 0, 0], "velocities": {arm: 0.3}})] * 10)
    Lockstep(steps, "frankie", 0.05).run(wire, GUARD)
    assert not steps.robot("frankie").state.velocities.any()
    assert wire.told[-1]["robot"]["positions"][arm] > 0.05


@contextmanager
def lockstep_of_ugv(kernel: KernelProcess) -> Iterator[subprocess.Popen[bytes]]:
    """Give the command as a process, whose controller drives ahead; it is gone at the end of the block."""
    drives = "import sys\nfor _ in sys.stdin: print('{\"twist\": [0.3, 0, 0]}', flush=True)"
    command = [sys.executable, "-m", "virtualrobot", "--address", kernel.address, "lockstep", "ugv", "--"]
    process = subprocess.Popen([*command, sys.executable, "-c", drives])
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("number", [signal.SIGTERM, pytest.param(signal.SIGHUP, marks=pytest.mark.long)])
def test_a_signal_lets_the_robot_rest_and_time_go_on(
    client: virtualrobot.Client, kernel: KernelProcess, number: int
) -> None:
    """The command as a process: everybody's time goes on after it, as it did before."""
    if signal.getsignal(number) is signal.SIG_IGN:
        pytest.skip("who runs the tests ignores this signal, as nohup does, and so does the command")
    client.load_robot("model://ugv", name="ugv", base="planar")
    with lockstep_of_ugv(kernel) as process:
        while client.robot("ugv").tcp[0, 3] < 0.05:
            assert process.poll() is None
        process.send_signal(number)
        assert process.wait(GUARD) == 130
    until(lambda: client.clock.read().mode == "realtime")  # the end of its connection says so where its own word can't
    assert not client.robot("ugv").state.velocities.any()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_time_goes_on_and_the_robot_stops_after_a_kill(client: virtualrobot.Client, kernel: KernelProcess) -> None:
    """Nobody steps any more: so says the end of the connection, by which the clock was held."""
    client.load_robot("model://ugv", name="ugv", base="planar")
    with lockstep_of_ugv(kernel) as process:
        until(lambda: client.robot("ugv").tcp[0, 3] > 0.05)
        assert client.clock.read().mode == "stepped"
        (motion,) = client.motions()
        process.kill()
        process.wait()
        until(lambda: client.clock.read().mode == "realtime" and motion.phase is Phase.ABORTED)
    assert "the client that stepped time is gone" in motion.state.end_reason
    assert not client.robot("ugv").state.velocities.any()


def test_a_speed_beyond_limits_is_refused_with_them(ugv: virtualrobot.Client) -> None:
    with pytest.raises(LimitError):
        Lockstep(ugv, "ugv", 0.05).run(Played('{"twist": [99, 0, 0]}'), GUARD)


@pytest.mark.long
def test_a_controller_that_never_answers_is_told_with_the_state_that_it_was_given(ugv: virtualrobot.Client) -> None:
    program = ProgramWire([sys.executable, "-c", "import time; input(); print('{}', flush=True); time.sleep(600)"])
    try:
        with pytest.raises(CallTimeoutError, match=r"not answered for 2 s; it was given the state of 0.048 s, and ugv"):
            Lockstep(ugv, "ugv", 0.05).run(program, 2.0)
    finally:
        program._process.kill()
        program.close()


@pytest.mark.parametrize(
    ("program", "words"),
    [("raise SystemExit(3)", "exit code 3"), ("import os; os.kill(os.getpid(), 11)", "signal 11")],
)
def test_a_controller_that_crashes_has_not_just_ended(ugv: virtualrobot.Client, program: str, words: str) -> None:
    wire = ProgramWire([sys.executable, "-c", f"input(); print('{{\"twist\": [0.3, 0, 0]}}', flush=True); {program}"])
    with pytest.raises(WrongStateError, match=f"ended with {words}; it was given the state of 0.048 s, and ugv"):
        Lockstep(ugv, "ugv", 0.05).run(wire, GUARD)
    wire.close()
    assert not ugv.robot("ugv").state.velocities.any()


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (r"import sys; sys.stdout.buffer.write(b'\xff\xfe\x00{}\n'); sys.stdout.flush()", "no JSON: '.*xff.*xfe"),
        pytest.param(
            "import os, time; os.close(1); time.sleep(600)",
            "has closed its output, and runs on",
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_controller_that_writes_no_text_or_nothing_more_has_not_just_ended(
    ugv: virtualrobot.Client, program: str, words: str
) -> None:
    wire = ProgramWire([sys.executable, "-c", program])
    with pytest.raises(virtualrobot.VirtualRobotError, match=words):
        Lockstep(ugv, "ugv", 0.05).run(wire, GUARD)
    wire.close()


def test_a_period_and_names_are_looked_at_first(ugv: virtualrobot.Client) -> None:
    with pytest.raises(InvalidArgumentError, match="a tick"):
        Lockstep(ugv, "ugv", 0.001)
    with pytest.raises(virtualrobot.UnknownNameError):
        Lockstep(ugv, "ugb", 0.05)
    with pytest.raises(virtualrobot.UnknownNameError):
        Lockstep(ugv, "ugv", 0.05, ["radar"])
    with pytest.raises(InvalidArgumentError, match="cannot be started"):
        ProgramWire(["no-such-program-anywhere"])


@pytest.mark.long
def test_the_controller_of_the_page_drives_its_square(ugv: virtualrobot.Client, tmp_path: Path) -> None:
    program = tmp_path / "controller.py"
    program.write_text(block("python"))
    wire = ProgramWire([sys.executable, str(program)])
    run = Lockstep(ugv, "ugv", 0.05).run(wire, GUARD)
    wire.close()
    assert run.end == "the controller is done"
    # Within 0.1 m of its last waypoint, the origin, and what it rolls on by at 0.5 m/s until it rests.
    assert np.hypot(*pose(ugv)) < 0.1 + 0.15
    told = re.search(r"(\d+) steps, ([\d.]+) s: the controller is done", COMMANDS.read_text("utf-8"))
    assert told is not None
    assert (run.steps, run.seconds) == (pytest.approx(int(told[1]), abs=1), pytest.approx(float(told[2]), abs=0.05))


@pytest.mark.long
@pytest.mark.skipif(
    OCTAVE is None, reason="no Octave: install the package octave to run the controller of docs/lockstep.md"
)
def test_octave_drives_as_python_does(ugv: virtualrobot.Client, tmp_path: Path) -> None:
    """The same law in two languages: the same way, to what their arithmetic differs by."""
    ways = []
    for language, ending, start in (("python", "py", [sys.executable]), ("octave", "m", [str(OCTAVE), "--quiet"])):
        program = tmp_path / f"controller.{ending}"
        program.write_text(block(language))
        ugv.scene.clear()
        ugv.load_robot("model://ugv", name="ugv", base="planar")
        wire = ProgramWire([*start, str(program)])
        seen: list[np.ndarray] = []
        run = Lockstep(ugv, "ugv", 0.05).run(wire, GUARD, 6.0, lambda _, seen=seen: seen.append(pose(ugv)))
        wire.close()
        assert run.end == "the time is over"
        ways.append(np.array(seen))
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-9)


def test_a_controller_connects_over_tcp(ugv: virtualrobot.Client) -> None:
    server = listen(0)
    port = server.getsockname()[1]
    told: list[dict] = []

    def control() -> None:
        with socket.create_connection(("127.0.0.1", port), GUARD) as there, there.makefile("rw") as file:
            for _ in range(3):
                told.append(json.loads(file.readline()))
                file.write('{"twist": [0.2, 0, 0]}\n')
                file.flush()

    thread = threading.Thread(target=control, daemon=True)
    thread.start()
    wire = SocketWire(server, GUARD)
    run = Lockstep(ugv, "ugv", 0.05).run(wire, GUARD)
    wire.close()
    server.close()
    thread.join(GUARD)
    assert (run.steps, run.end, len(told)) == (3, "the controller has ended", 3)
    with pytest.raises(CallTimeoutError, match="no controller has connected to port"):
        lonely = listen(0)
        try:
            SocketWire(lonely, 0.05)
        finally:
            lonely.close()
