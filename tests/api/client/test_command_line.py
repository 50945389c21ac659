"""The command line on a real kernel: what it prints, its exit codes, and Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Phase, Robot, cli
from virtualrobot.kernel_process import KernelProcess as ChildKernel

from tests.api.client.conftest import IIWA, MODELS, Run


def test_first_steps(run: Run, client: Client) -> None:
    """The steps that the help shows to newcomers."""
    assert run("load", IIWA, "--name", "arm") == "loaded robot arm\n"
    assert run("ls") == "world (world)\n└─ arm (robot)\n"
    assert "arm.lbr_iiwa_link_7 (link)" in run("ls", "--links")
    assert "lbr_iiwa_joint_1" in run("state", "arm")
    assert "reached its goal" in run("move", "arm", "--joints", "0,0.5,0,-1.2,0,0.8,0")
    np.testing.assert_allclose(client.robot("arm").positions, [0, 0.5, 0, -1.2, 0, 0.8, 0], atol=1e-9)


def test_models_are_loaded_where_they_belong(run: Run, client: Client) -> None:
    client.scene.add_object("table", pose=virtualrobot.pose(x=1))
    duck = str(MODELS / "duck.obj")
    run("load", duck, "--as", "part", "--name", "duck", "--at", "0,0,0.5,90,0,0", "--degrees", "--parent", "table")
    np.testing.assert_allclose(client.scene.pose("duck"), virtualrobot.pose(1, 0, 0.5, roll=np.pi / 2), atol=1e-12)
    assert client.scene.node("duck").kind == "part"
    run("load", duck, "--name", "still", "--scale", "0.5,0.5,-1", "--at", "-1,-1,0")
    scale = client.scene.node("still")._message.figures[0].mesh.scale
    assert (client.scene.node("still").kind, scale.x, scale.z) == ("object", 0.5, -1)


def test_a_package_is_told(run: Run, tmp_path: Path) -> None:
    (tmp_path / "cube.stl").write_bytes((MODELS / "l_finger.stl").read_bytes())
    assert "'told'" in run("load", "package://told/cube.stl", code=1)
    assert "loaded object" in run("load", "package://told/cube.stl", "--package", f"told={tmp_path}")


def test_scenes_are_saved_and_loaded(run: Run, client: Client, tmp_path: Path) -> None:
    run("load", str(MODELS / "duck.obj"), "--name", "duck")
    file = tmp_path / "cell.yaml"
    assert re.match(rf"saved {re.escape(str(file))} and \d+ files under", run("save", str(file), "--bundle"))
    client.scene.remove("duck")
    client.scene.add_object("table")
    run("load", str(file))
    assert run("ls") == "world (world)\n└─ duck (object)\n"
    client.scene.remove("duck")
    client.scene.add_object("table")
    run("load", str(file), "--add")
    assert {node.name for node in client.scene.nodes()} == {"world", "table", "duck"}


def test_a_robot_moves(run: Run, client: Client, iiwa: Robot) -> None:
    run("move", "iiwa", "--joints", "0,30,0,-60,0,30,0", "--degrees")
    bent = np.radians([0, 30, 0, -60, 0, 30, 0])
    np.testing.assert_allclose(iiwa.positions, bent, atol=1e-9)
    run("move", "iiwa", "--joints", "lbr_iiwa_joint_1=0.1", "lbr_iiwa_joint_7=-0.2", "--speed", "0.9")
    np.testing.assert_allclose(iiwa.positions[[0, 6]], [0.1, -0.2], atol=1e-9)
    start = iiwa.tcp
    goal = ",".join(f"{value:.17g}" for value in start[:3, 3] + (0.0, 0.0, 0.05))
    run("move", "iiwa", "--linear", "--pose", goal)
    np.testing.assert_allclose(iiwa.tcp[:3, 3], start[:3, 3] + (0, 0, 0.05), atol=1e-3)
    np.testing.assert_allclose(iiwa.tcp[:3, :3], start[:3, :3], atol=3e-3)  # without angles it is not turned
    via, back = (",".join(f"{value:.17g}" for value in start[:3, 3] + end) for end in ((0, 0.03, 0.02), (0, 0, 0)))
    run("move", "iiwa", "--via", via, "--pose", back)
    np.testing.assert_allclose(iiwa.tcp[:3, 3], start[:3, 3], atol=1e-8)
    run("move", "iiwa", "--pose", "0.5,0,0.5,0,180,0", "--degrees", "--reference", "iiwa")
    np.testing.assert_allclose(iiwa.tcp, virtualrobot.pose(0.5, 0, 0.5, pitch=np.pi), atol=3e-3)
    assert "45.0000" in (run("move", "iiwa", "lbr_iiwa_joint_1=45", "--degrees"), run("state", "--degrees"))[1]


def test_the_state_tells_the_step_by_its_path_and_asks_once(run: Run, client: Client, iiwa: Robot) -> None:
    client.signals.create("go")
    client.load_denavit_hartenberg([(0.5, 0.0, 0.0, 0.0)], convention="standard", name="other")
    steps = client.program().dwell(100.0).set("go", True)
    client.clock.set_stepped()
    motion = client.program().repeat(2, steps).start(wait=False)
    client.clock.step(2)
    assert motion.step_path == "0[0].0"
    assert repr(motion).endswith(", step 0[0].0>")
    assert f"motion {motion.id}: waiting, " in (said := run("state")) and said.endswith(" (0[0].0)\n")
    answers = [json.loads(line)["rpc"] for line in run("--json", "state").splitlines() if line.startswith("{")]
    assert (answers.count("GetRobotStates"), answers.count("GetSignals")) == (1, 1)
    motion.cancel()


def test_refusals_are_one_line(run: Run, iiwa: Robot) -> None:
    assert "there is no robot named 'iiwo'; did you mean 'iiwa'" in run("move", "iiwo", "--to", "home", code=1)
    assert "-2.96706 to 2.96706" in run("move", "iiwa", "--joints", "lbr_iiwa_joint_1=9", code=1)
    assert "has no joint 'j1'" in run("move", "iiwa", "--joints", "j1=9", "--degrees", code=1)
    assert "it has 7 joints" in run("move", "iiwa", "--joints", "1,2", code=1)
    twice = run("move", "iiwa", "--joints", "lbr_iiwa_joint_1=1,lbr_iiwa_joint_1=0.5", code=2)
    assert "the joint 'lbr_iiwa_joint_1' is given twice" in twice
    assert "it has 7 joints" in run("move", "iiwa", "--joints", "1,2", "--degrees", code=1)
    assert "iiwa" in run("state", "arm", code=1)
    assert "is not there; tried" in run("load", "none.urdf", code=1)
    assert "the folder '/dev/null' is not there" in run("save", "/dev/null/x.yaml", code=1)
    assert "a scene file ends with .yaml or .yml" in run("save", "cell.txt", code=2)


def test_motions_go_on_and_are_stopped(run: Run, client: Client, iiwa: Robot) -> None:
    assert "started motion-" in run("move", "iiwa", "lbr_iiwa_joint_1=1", "--speed", "0.001", "--no-wait")
    motion = client.motions()[0]
    assert f"motion {motion.id} of iiwa: running" in run("state")
    assert motion.id in run("move", "iiwa", "lbr_iiwa_joint_1=0", code=1)
    assert run("stop", "iiwa") == f"stopped {motion.id} of iiwa\n"
    with pytest.raises(virtualrobot.MotionCancelledError):
        motion.wait()
    assert run("stop") == "nothing moves\n"


@pytest.mark.skipif(os.name == "nt", reason="a process cannot be sent Ctrl-C alone on Windows")
def test_ctrl_c_stops_the_robot(client: Client, environment: None, iiwa: Robot) -> None:
    command = [sys.executable, "-m", "virtualrobot", "move", "iiwa", "lbr_iiwa_joint_1=1", "--speed", "0.001"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        next(state for state in iiwa.watch() if state.motion_ids)
        motion = client.motions()[0]
        # Two seconds later the command knows its motion, too.
        next(message for message in motion.watch() if message.progress > 0.02)
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
        assert process.stderr.read() == f"{motion.id} cancelled\n"
    with pytest.raises(virtualrobot.MotionCancelledError, match="keyboard"):
        motion.wait()
    assert motion.phase is Phase.CANCELLED


def test_signals(run: Run, client: Client) -> None:
    assert run("signal") == ""
    run("signal", "box arrived", "--create")
    assert run("signal") == "box arrived: off\n"
    run("signal", "box arrived", "on")
    assert run("signal", "box arrived") == "on\n"
    run("signal", "box arrived", "--wait", "--timeout", "10")
    assert "was not off within 0.1 s" in run("signal", "box arrived", "off", "--wait", "--timeout", "0.1", code=1)
    assert "did you mean 'box arrived'" in run("signal", "box arived", code=1)
    assert "signal box arrived: on" in run("state")
    run("signal", "pressure", "5.5", "--create", "--type", "number", "--unit", "bar")
    run("signal", "pressure", "6")
    assert run("signal", "pressure") == "6.0 bar\n"
    run("signal", "pressure", "5", "--wait", "--is", ">=")
    assert "is a number, not 'x'" in run("signal", "pressure", "x", code=2)
    run("signal", "bus", "0110", "--create", "--type", "group", "--direction", "input")
    assert client.signals["bus"] == (False, True, True, False)
    for name in ("pressure", "bus"):
        run("signal", name, "--remove")
    run("signal", "box arrived", "--remove")
    assert dict(client.signals) == {}


def test_time_is_stepped(run: Run, client: Client) -> None:
    client.clock.set_stepped()
    before = client.clock.read().stamp.tick
    assert run("step", "25") == f"tick {before + 25}, {0.004 * (before + 25):.3f} s\n"
    assert run("step").startswith(f"tick {before + 26},")
    assert run("state").startswith("stepped clock:")
    run("step", "--realtime")
    assert client.clock.mode == "realtime"


def test_whoever_stops_time_hears_it(
    client: Client, iiwa: Robot, environment: None, capsys: pytest.CaptureFixture[str]
) -> None:
    """Else the next motion would seem to hang."""
    with pytest.raises(SystemExit):
        cli.main(["step"])
    assert "virtualrobot step --realtime" in capsys.readouterr().err
    command = [sys.executable, "-m", "virtualrobot", "move", "iiwa", "lbr_iiwa_joint_1=0.1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert process.stdout is not None
        assert "time stands still" in process.stderr.readline()
        next(state for state in iiwa.watch() if state.motion_ids)
        client.clock.set_realtime()
        assert "reached its goal" in process.stdout.read()


def test_a_scene_file_is_loaded_as_it_is(environment: None, capsys: pytest.CaptureFixture[str]) -> None:
    for option in (["--at", "1,2,3"], ["--name", "cell"], ["--parent", "table"]):
        with pytest.raises(SystemExit) as ended:
            cli.main(["load", "cell.yaml", *option])
        assert ended.value.code == 2
        assert option[0] in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_watch_goes_on_until_its_reader_has_enough(client: Client, environment: None) -> None:
    command = [sys.executable, "-m", "virtualrobot", "state", "--watch"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        clocks = [line for _, line in zip(range(5), process.stdout, strict=False) if "clock" in line]
        assert len(set(clocks)) > 1  # time goes on
        process.stdout.close()  # as `head` does
        assert process.wait(30) == 1  # as Click ends programs whose reader is gone
        assert process.stderr.read() == ""


@pytest.mark.long
def test_a_kernel_is_started_and_ended_as_a_child() -> None:
    with ChildKernel(headless=True) as kernel:
        with virtualrobot.connect(kernel.address) as client:
            assert client.info.viewer_url == kernel.viewer_url == ""
        pid = client.info.process_id
    with pytest.raises(virtualrobot.KernelGoneError):
        virtualrobot.connect(kernel.address)
    if os.name != "nt":
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_a_child_that_does_not_start_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(virtualrobot.KernelGoneError, match="ended with code 2 before it answered"):
        ChildKernel("--no-such-option", headless=True)
    assert "--no-such-option" in capfd.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ("load", IIWA, "--name", ""),
        ("load", IIWA, "--parent", ""),
        ("move", "iiwa", "--pose", "0,0,1", "--reference", ""),
        ("move", "iiwa", "--to", ""),
        ("jog", "iiwa", "--along", "0,0,1", "--node", ""),
        ("path", "iiwa", "--joints", "0,0,0,0,0,0,0", "--group", ""),
        ("signal", "part", "--create", "--owner", ""),
    ],
    ids=lambda arguments: f"{arguments[0]} {arguments[-2]}",
)
def test_empty_names_are_refused_with_a_word(run: Run, client: Client, arguments: tuple[str, ...]) -> None:
    assert f"Invalid value for '{arguments[-2]}': is empty; give the name of a" in run(*arguments, code=2)
    assert [node.name for node in client.scene.nodes()] == ["world"]
