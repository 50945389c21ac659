"""Planning and checking from the client library and from the command line: nothing moves."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot, ViolationKind, cli

from tests.api.client.conftest import PANDA, Run

BENT = [0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]


@pytest.fixture
def bent(iiwa: Robot) -> Robot:
    iiwa.set_positions(BENT)
    return iiwa


def test_a_plan_is_what_the_motion_does(client: Client, bent: Robot) -> None:
    goal = bent.tcp @ virtualrobot.pose(z=-0.1)
    plan = bent.plan(bent.linear(goal))
    told = plan.robots["iiwa"]
    assert np.array_equal(bent.positions, BENT), "nothing has moved"
    assert told.joint_names == tuple(bent.chain_joint_names)
    count = len(plan.times)
    assert told.positions.shape == told.velocities.shape == told.accelerations.shape == told.efforts.shape == (count, 7)
    assert told.world_t_tcp.shape == (count, 4, 4)
    assert plan.steps.tolist() == [0] * count
    assert (plan.times[-1], plan.notes) == (plan.duration, ())
    np.testing.assert_allclose(told.world_t_tcp[-1], goal, atol=1e-6)
    assert told.tcp_speeds.max() == pytest.approx(0.25, rel=1e-3)
    np.testing.assert_allclose(told.efforts[0], list(bent.gravity_torques().values()), atol=1e-9)
    motion = bent.move_linear(goal)
    assert motion.planned_duration == plan.duration
    np.testing.assert_allclose(bent.positions, told.positions[-1], atol=1e-12)


def test_robots_and_steps_are_planned_together(client: Client, bent: Robot) -> None:
    other = client.load_robot(PANDA, name="other", pose=virtualrobot.pose(y=1.0))
    moves = [bent.ptp({"lbr_iiwa_joint_1": 1.0}), other.ptp({"panda_joint1": 0.2})]
    plan = client.plan(moves, sample_time=0.05)
    assert set(plan.robots) == {"iiwa", "other"}
    assert plan.times[1] == pytest.approx(0.05)
    program = client.program().move(moves[0]).move(moves[1]).plan()
    assert set(program.steps.tolist()) == {0, 1}
    assert program.duration > plan.duration


def test_a_check_tells_the_first_violation(client: Client, bent: Robot) -> None:
    good = bent.check(bent.ptp({"lbr_iiwa_joint_4": 1.2}))
    assert good.ok and good.first_violation is None and good.duration > 0.0
    assert good.min_singular_value is not None and good.min_singular_value < 0.05, "it passes the stretched arm"
    near = client.check([bent.ptp({"lbr_iiwa_joint_4": 1.2})], min_singular_value=0.1)
    assert not near.ok and near.first_violation is not None
    assert near.first_violation.kind is ViolationKind.SINGULARITY
    assert near.first_violation.value < near.first_violation.limit == 0.1
    far = bent.check(bent.ptp({"lbr_iiwa_joint_4": -4.0})).first_violation
    assert far is not None
    assert (far.kind, far.joint, far.robot, far.step) == (ViolationKind.JOINT_POSITION, "lbr_iiwa_joint_4", "iiwa", 0)
    assert far.limit == bent.limits["lbr_iiwa_joint_4"].lower
    assert far.path_fraction == pytest.approx((far.limit + 1.2) / (-4.0 + 1.2), abs=1e-5)
    assert far.time is not None and far.world_t_tcp is not None and far.world_t_tcp.shape == (4, 4)
    assert str(far) == far.message
    reach = bent.check(bent.ptp(virtualrobot.pose(5.0, 0.0, 0.5))).first_violation
    assert reach is not None
    assert (reach.kind, reach.time, reach.path_fraction, reach.world_t_tcp) == (
        ViolationKind.REACH, None, None, None
    )  # fmt: skip
    with pytest.raises(virtualrobot.UnknownNameError):
        bent.check(bent.ptp("nowhere"))


def test_a_program_is_planned_and_checked(client: Client, bent: Robot) -> None:
    program = client.program().move(bent.ptp({"lbr_iiwa_joint_1": 0.4})).dwell(0.5)
    plan = program.plan(sample_time=0.02)
    assert set(plan.steps.tolist()) == {0, 1}
    found = program.check()
    assert found.ok and found.duration == plan.duration
    far = program.move(bent.ptp({"lbr_iiwa_joint_1": 4.0})).check().first_violation
    assert far is not None and far.time is not None
    assert (far.kind, far.step) == (ViolationKind.JOINT_POSITION, 2)
    assert far.time > plan.duration


def test_a_plan_is_checked_and_started_as_it_was_shown(client: Client, bent: Robot) -> None:
    client.scene.add_part("box", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(2.0))
    shown = bent.plan(bent.ptp({"lbr_iiwa_joint_1": 0.5}))
    checked = client.check_plan(shown)
    assert checked.ok and checked.reference != shown.reference
    # Bent by 0.5 and 1.2 rad it reaches 0.2 + 0.4 m ahead, 0.68 m high, and turns by 0.5 rad.
    client.scene.set_pose("box", virtualrobot.pose(0.5, 0.15, 0.68))
    with pytest.raises(virtualrobot.PlanOutdatedError, match=r"has changed of 'box', and .* touches 'box'") as refused:
        client.start_plan(checked)
    assert refused.value.metadata["changes"] == "where it is fixed on its parent has changed of 'box'"
    assert not client.check_plan(checked).ok
    client.scene.set_pose("box", virtualrobot.pose(2.5))  # elsewhere than before, and not in its way
    motion = client.start_plan(checked)
    assert motion.planned_duration == shown.duration
    np.testing.assert_allclose(bent.positions[0], 0.5, atol=1e-12)
    with pytest.raises(virtualrobot.PlanOutdatedError, match=r"'lbr_iiwa_joint_1' of 'iiwa' stands at 0\.5, not at 0"):
        client.start_plan(shown)
    with pytest.raises(virtualrobot.UnknownNameError, match="no plan 'plan-0' is remembered"):
        client.start_plan(virtualrobot.PlanReference("plan-0"))
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"is not to be started: .*leaves its range"):
        client.start_plan(bent.check(bent.ptp({"lbr_iiwa_joint_1": 4.0})))
    belt = virtualrobot.Tracking("box", window=0.1)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="leave out tracking"):
        client.start_plan(checked, tracking=belt)


def test_a_plan_is_started_from_the_command_line(run: Run, bent: Robot) -> None:
    *_, last = run("check", "iiwa", "lbr_iiwa_joint_1=0.3").splitlines()
    name = last.removeprefix("as it is here: virtualrobot start ")
    assert "has the digest" in run("start", name, "--digest", "0", code=1)
    assert run("start", name).endswith("reached its goal\n")
    np.testing.assert_allclose(bent.positions[0], 0.3, atol=1e-12)
    assert "stands at 0.3, not at 0" in run("start", name, code=1)
    assert "--hold needs a terminal" in run("start", name, "--hold", code=2)


PROGRAM = """
schema_version: 1
steps:
  - dwell: {seconds: 0.1}
  - move: {moves: [{robot: iiwa, point_to_point: {joints: {joint_positions: {lbr_iiwa_joint_1: GOAL}}}}]}
"""


def test_a_program_file_is_checked(run: Run, bent: Robot, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "program.yaml"
    file.write_text(PROGRAM.replace("GOAL", "0.5"))
    assert f"{file} keeps all limits and touches nothing: the motion takes " in run("run", str(file), "--check")
    file.write_text(PROGRAM.replace("GOAL", "5"))
    assert code_of("run", str(file), "--check") == 1
    assert capsys.readouterr().out.startswith("step 1: the joint 'lbr_iiwa_joint_1' of 'iiwa' leaves its range")
    np.testing.assert_array_equal(bent.positions, BENT)


def test_a_start_for_another_revision_is_refused(client: Client, bent: Robot) -> None:
    revision = bent.state.stamp.structure_revision
    client.scene.add_object("table")
    with pytest.raises(virtualrobot.StaleRevisionError):
        bent.move_joints(BENT, expected_structure_revision=revision)
    bent.move_joints(BENT, expected_structure_revision=revision + 1)


def code_of(*arguments: str) -> object:
    with pytest.raises(SystemExit) as ended:
        cli.main(arguments)
    return ended.value.code


def test_check_has_a_verdict_and_an_exit_code(run: Run, bent: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    told = run("check", "iiwa", "lbr_iiwa_joint_1=0.5")
    assert told.startswith("iiwa keeps all limits and touches nothing: the motion takes ")
    assert told.count("\n") == 2
    assert code_of("check", "iiwa", "lbr_iiwa_joint_1=4") == 1
    captured = capsys.readouterr()
    assert captured.out.startswith("the joint 'lbr_iiwa_joint_1' of 'iiwa' leaves its range") and not captured.err
    assert code_of("check", "iiwa", "lbr_iiwa_joint_4=1.2", "--min-singular-value", "0.1") == 1
    assert "too near to a singularity" in capsys.readouterr().out
    assert "no robot named 'iiwo'" in run("check", "iiwo", "--to", "home", code=1)
    np.testing.assert_array_equal(bent.positions, BENT)


def test_plan_shows_peaks_or_samples(run: Run, bent: Robot, tmp_path: Path) -> None:
    told = run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "lbr_iiwa_joint_4=-1").splitlines()
    plan = bent.plan(bent.ptp({"lbr_iiwa_joint_1": 0.5, "lbr_iiwa_joint_4": -1.0}))
    robot = plan.robots["iiwa"]
    assert told[0].split() == ["joint", "from", "to", "velocity", "acceleration", "effort"]
    name, start, end, velocity, share = told[1].split()[:5]
    assert (name, float(start), float(end)) == ("lbr_iiwa_joint_1", 0.0, 0.5)
    peak = np.abs(robot.velocities[:, 0]).max()
    assert float(velocity) == pytest.approx(peak, abs=6e-4)
    assert share == f"({100.0 * peak / bent.limits[name].velocity:.0f}%)"
    assert told[-2].startswith(f"{plan.duration:.3f} s; the tool centre point moves at up to ")

    table = run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--table", "--every", "0.1").splitlines()
    assert table[0].split() == ["time", "lbr_iiwa_joint_1", "x", "y", "z", "tcp_speed"]
    assert [line.split()[0] for line in table[1:3]] == ["0.0000", "0.1000"]

    file = tmp_path / "plan.csv"
    run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--csv", str(file))
    with file.open() as opened:
        rows = list(csv.reader(opened))
    exact = bent.plan(bent.ptp({"lbr_iiwa_joint_1": 0.5}))
    assert rows[0][:2] == ["time", "lbr_iiwa_joint_1"]
    np.testing.assert_array_equal(np.array(rows[1:], float)[:, 0], exact.times)
    np.testing.assert_array_equal(np.array(rows[1:], float)[:, 1], exact.robots["iiwa"].positions[:, 0])
    # What was written is a trajectory, which takes as long and is the same curve but between its samples.
    again = bent.plan(bent.read_trajectory(file)).robots["iiwa"].positions[:, 0]
    np.testing.assert_allclose(again, exact.robots["iiwa"].positions[:, 0], atol=1e-6)
    assert "keeps all limits" in run("check", "iiwa", "--trajectory", str(file))
    missing = str(tmp_path / "none.csv")
    assert "none.csv cannot be read" in run("move", "iiwa", "--trajectory", missing, code=1)
    file.write_text(file.read_text().replace("lbr_iiwa_joint_1", "joint_1"))
    assert "plan.csv:1: column 2 (joint_1): 'iiwa' has no joint" in run(
        "move", "iiwa", "--trajectory", str(file), code=1
    )
    run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--csv", str(file))
    shown = run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--csv", "-")
    assert shown == file.read_text()
    run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--every", "0.1", code=2)
    nowhere = str(tmp_path / "no" / "a.csv")
    assert "cannot be written" in run("plan", "iiwa", "lbr_iiwa_joint_1=0.5", "--csv", nowhere, code=1)

    goal = ",".join(f"{value:.17g}" for value in bent.tcp[:3, 3] + (0.0, 0.1, 0.0))
    line = run("plan", "iiwa", "--pose", goal, "--linear", "--velocity", "0.08")
    *_, told, start = line.splitlines()
    assert told.endswith("moves at up to 0.0800 m/s") and "virtualrobot start plan-" in start
    for wrong in (["--velocity", "0.08"], ["--linear", "--velocity", "0"]):
        run("plan", "iiwa", "--pose", goal, *wrong, code=2)

    degrees = run("plan", "iiwa", "lbr_iiwa_joint_1=30", "--degrees").splitlines()
    _, start, end, velocity, share = degrees[1].split()[:5]
    turning = bent.plan(bent.ptp({"lbr_iiwa_joint_1": np.radians(30.0)})).robots["iiwa"]
    peak = np.abs(turning.velocities[:, 0]).max()
    assert (float(start), float(end)) == (0.0, 30.0)
    assert float(velocity) == pytest.approx(np.degrees(peak), abs=6e-4)
    assert share == f"({100.0 * peak / bent.limits['lbr_iiwa_joint_1'].velocity:.0f}%)"
    np.testing.assert_array_equal(bent.positions, BENT)
