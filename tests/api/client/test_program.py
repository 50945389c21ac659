"""Programs with the client library and on the command line, on a real kernel."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Phase, Robot

from tests.api.client.conftest import Run

BENT = [0.0, 0.5, 0.0, -1.2, 0.0, 1.4, 0.0]
FILE = """\
schema_version: 1
steps:
  - move:
      moves: [{robot: iiwa, point_to_point: {joints: {joint_positions: {lbr_iiwa_joint_1: 0.3}}}}]
  - set_signal: {signal: there, value: {boolean: true}}
"""


@pytest.fixture
def arm(client: Client, iiwa: Robot) -> Robot:
    """Return an arm in a good posture, and three signals."""
    iiwa.move_joints(BENT)
    for name in ("gripper", "part", "touch"):
        client.signals.create(name)
    client.clock.set_realtime(speed_factor=10.0)
    return iiwa


def test_a_program_reads_like_one(client: Client, arm: Robot) -> None:
    above = arm.tcp
    at = above @ virtualrobot.pose(z=0.1)
    program = client.program().move(arm.linear(at)).set("gripper").dwell(0.1).move(arm.linear(above), zone_percent=40)
    program.set("part").move(arm.ptp(BENT)).wait("part", timeout=1.0).set("gripper", False)
    assert len(program) == 8
    motion = program.start()
    assert (motion.phase, motion.step, motion.step_count, motion.search) == (Phase.SUCCEEDED, 7, 8, None)
    assert dict(client.signals) == {"gripper": False, "part": True, "touch": False}
    np.testing.assert_allclose(arm.tcp, above, atol=1e-5)
    assert all(note.step == 3 for note in motion.notes)


def test_what_runs_already_is_no_step(client: Client, arm: Robot) -> None:
    for use in (client.program().move, lambda motion: client.move_together([motion])):
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"moves.* is <Motion.* which start nothing"):
            use(arm.move_joints(BENT))  # type: ignore[arg-type]
    program = client.program()
    with pytest.raises(virtualrobot.InvalidArgumentError, match="give a first step or move"):
        program.start()
    wrong: list[dict[str, Any]] = [{"tracking": "conveyor.belt"}, {"on_disconnect": "keep"}]
    for bad in wrong:
        with pytest.raises(virtualrobot.InvalidArgumentError, match=r"Tracking|'stop' or 'continue'"):
            arm.move_joints(BENT, **bad)


@pytest.mark.parametrize("call", ["ptp", "move_pose", "start", "plan", "check", "move_linear", "jog", "spline"])
def test_an_option_that_there_is_not_is_refused_with_those_that_there_are(
    client: Client, arm: Robot, call: str
) -> None:
    goals: dict[str, Any] = {name: arm.linear(arm.tcp) for name in ("start", "plan", "check")}
    goals |= {"jog": [0, 0, 1], "spline": [arm.tcp]}
    with pytest.raises(
        TypeError, match=r"no option 'speed'; .* takes (.*, )?(speed_factor|preempt|sample_time|resolution)"
    ):
        getattr(arm, call)(goals.get(call, arm.tcp), speed=0.5)
    assert not client.motions()
    with pytest.raises(virtualrobot.InvalidArgumentError, match="reference_t_tcp is 'home'; it must be a 4x4 array"):
        arm.move_pose("home")


def test_a_search_takes_what_a_line_takes(arm: Robot) -> None:
    goal = arm.tcp @ virtualrobot.pose(z=0.05)
    motion = arm.search(goal, "touch", time_law="time_optimal", lock=["lbr_iiwa_joint_3"], prefer="limits")
    assert motion.search is not None
    assert not motion.search.found
    np.testing.assert_allclose(arm.tcp, goal, atol=1e-6)
    assert arm.positions[2] == pytest.approx(BENT[2], abs=1e-9)


def test_an_arc_searches_too(client: Client, arm: Robot) -> None:
    center = arm.tcp[:3, 3] + (0.03, 0.0, 0.0)
    arc = arm.circular(center=center, axis=[0, 0, 1], angle=1.0, until=("touch", True))
    missed = client.program().move(arc).start().search
    assert missed is not None
    assert not missed.found
    np.testing.assert_allclose(missed.world_t_tcp, arm.tcp, atol=1e-6)


def test_what_became_of_a_zone_is_told(client: Client, arm: Robot) -> None:
    motion = client.program().move(arm.ptp(BENT), zone=0.05).dwell(0.01).start()
    (note,) = motion.notes
    assert (note.step, note.robot, note.wanted, note.kept) == (0, "iiwa", 0.05, 0.0)
    assert "step 1 waits" in note.message
    with pytest.raises(virtualrobot.InvalidArgumentError, match="zone_extended goes with zone_radius"):
        client.program().move(arm.ptp(BENT), zone=0.05, zone_extended=0.1)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="one of zone, zone_percent and zone_radius"):
        client.program().move(arm.ptp(BENT), zone=0.05, zone_percent=10)


def test_errors_name_the_step(client: Client, arm: Robot) -> None:
    with pytest.raises(virtualrobot.UnreachableError) as refused:
        client.program().dwell(0.1).move(arm.linear(virtualrobot.pose(x=9))).start()
    assert refused.value.metadata["step"] == "1"
    assert str(refused.value).startswith("step 1: ")
    with pytest.raises(virtualrobot.UnknownNameError, match=r"step 0: .* named 'prt'; did you mean 'part'"):
        client.program().wait("prt").start()
    with pytest.raises(virtualrobot.MotionAbortedError, match=r"step 0: the signal 'part' was not on"):
        client.program().wait("part", timeout=0.05).start()


def test_a_program_waits_and_is_told_to_go_on(client: Client, arm: Robot) -> None:
    motion = client.program().wait("part").move(arm.ptp({"lbr_iiwa_joint_1": 0.2})).start(wait=False)
    next(message for message in motion.watch() if Phase(message.phase) is Phase.WAITING)
    assert motion.step == 0
    client.signals["part"] = True
    assert motion.wait().phase is Phase.SUCCEEDED
    assert arm.positions[0] == pytest.approx(0.2, abs=1e-12)


def test_a_search_tells_where(client: Client, arm: Robot) -> None:
    above = arm.tcp
    goal = above @ virtualrobot.pose(z=0.1)
    missed = arm.search(goal, "touch").search
    assert missed is not None and not missed.found
    np.testing.assert_allclose(missed.world_t_tcp, goal, atol=1e-5)
    client.clock.set_realtime(speed_factor=1.0)
    motion = arm.search(above, ("touch", True), velocity=0.01, wait=False)
    next(message for message in motion.watch() if message.progress > 0.1)
    client.signals["touch"] = True
    found = motion.wait().search
    assert found is not None and found.found
    # On the line, beyond its first tenth in time; what the arm stands at is farther.
    on_the_way = [float((pose - goal)[2, 3] / (above - goal)[2, 3]) for pose in (found.world_t_tcp, arm.tcp)]
    assert 0.05 < on_the_way[0] < on_the_way[1] < 1.0


def test_a_file_is_run(run: Run, client: Client, arm: Robot, tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    file.write_text(FILE)
    assert "there is no signal named 'there'" in run("run", str(file), code=1)
    client.signals.create("there")
    assert run("run", str(file)).endswith("is done\n")
    assert client.signals["there"]
    assert arm.positions[0] == pytest.approx(0.3, abs=1e-12)
    assert len(client.read_program(file)) == 2
    file.write_text(FILE.replace("boolean: true", "boolean: on"))
    refused = run("run", str(file), code=1)
    assert "cell.yaml:5: steps[1].set_signal.value.boolean: expected true or false, got 'on'" in refused
    with pytest.raises(virtualrobot.InvalidArgumentError, match="is no program file"):
        client.read_program(tmp_path / "other.yaml")


def test_a_file_that_searches_and_one_that_goes_on(run: Run, client: Client, arm: Robot, tmp_path: Path) -> None:
    x, y, z = arm.tcp[:3, 3] - [0, 0, 0.05]
    turned = virtualrobot.quaternion_of(arm.tcp[:3, :3])
    a, b, c, d = turned
    goal = f"{{position: {{x: {x}, y: {y}, z: {z}}}, orientation: {{x: {a}, y: {b}, z: {c}, w: {d}}}}}"
    until = "{signal: touch, value: {boolean: true}}"
    line = f"linear: {{goal: {{reference_t_tcp: {goal}}}, until: {until}}}"
    file = tmp_path / "touch.yaml"
    file.write_text(f"schema_version: 1\nmoves:\n  - robot: iiwa\n    {line}\n")
    assert run("run", str(file)).endswith("found nothing\n")
    client.signals["touch"] = True
    assert "found at" in run("run", str(file))
    file.write_text("schema_version: 1\nsteps:\n  - wait_signal: {condition: {signal: part, value: {boolean: true}}}\n")
    assert "started" in run("run", str(file), "--no-wait")
    assert re.search(r"motion motion-\d+: (waiting|running), \d+%, step 0 of 1", run("state"))
    client.stop()


@pytest.mark.skipif(os.name == "nt", reason="a process cannot be sent Ctrl-C alone on Windows")
@pytest.mark.long
def test_ctrl_c_cancels_a_program(client: Client, environment: None, arm: Robot, tmp_path: Path) -> None:
    file = tmp_path / "waits.yaml"
    file.write_text("schema_version: 1\nsteps:\n  - wait_signal: {condition: {signal: part, value: {boolean: true}}}\n")
    command = [sys.executable, "-m", "virtualrobot", "run", str(file)]
    for _ in range(5):  # at whatever place inside the start of its calls it is struck
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            while not (going := client.motions()):
                pass
            id = going[0].id
            process.send_signal(signal.SIGINT)
            assert process.wait(30) == 130
        # By the command, or, if it was interrupted before it knew the motion, by its watch that ended.
        while not (ended := next(one for one in client.motions(False) if one.id == id)).phase.ended:
            pass
        assert ended.state.end_cause in ("call", "unwatched")


def test_an_open_program_is_fed_line_by_line(client: Client, arm: Robot) -> None:
    above = arm.tcp
    corners = [above @ virtualrobot.pose(x=x, z=z) for x, z in ((0.0, 0.1), (0.1, 0.1), (0.1, 0.0))]
    motion = client.program().move(arm.linear(corners[0]), zone_percent=30).start(open=True)
    for corner in corners[1:]:
        motion.append(client.program().set("part").move(arm.linear(corner), zone_percent=30))
    notes = motion.append(last=True)
    assert [(note.step, note.message.endswith("no moves follow")) for note in notes] in ([], [(4, True)])
    assert motion.wait().step_count == 5 and client.signals["part"] is True
    np.testing.assert_allclose(arm.tcp, corners[-1], atol=1e-5)
    with pytest.raises(virtualrobot.WrongStateError, match="has ended"):
        motion.append(client.program().dwell(0.1))


def test_a_file_stands_before_a_step_and_asks(
    arm: Robot, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file := tmp_path / "program.yaml").write_text(FILE.replace("there", "part") + "  - dwell: {seconds: 0.02}\n")
    monkeypatch.setattr("sys.stdin", io.StringIO("s\n\n"))
    told = run("run", str(file), "--break", "0")
    assert re.findall(r"before step (\S+):", told) == ["0", "1"]
    assert told.splitlines()[-1].endswith("is done")
    assert arm.positions[0] == pytest.approx(0.3, abs=1e-9)
