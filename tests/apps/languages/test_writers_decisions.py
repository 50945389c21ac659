"""Programs that decide, in the languages of controllers: what is done is what the kernel does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Program, Robot
from virtualrobot_apps.emulators.body import SimulatedArm
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.scripts import run_script
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.task import RapidTask, load
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.writers import fanuc, krl, rapid, urscript
from virtualrobot_apps.languages.writers.resolve import robot_program
from virtualrobot_apps.languages.writers.statements import If, Line, PointToPoint, RobotProgram, While, every
from virtualrobot_apps.languages.writers.words import Language

from tests.apps.languages.controllers import read_krl, read_tp
from tests.waiting import PATIENCE_SECONDS, repeated

pytestmark = pytest.mark.long

pose = virtualrobot.pose
HOME, LEFT = [0.0, -1.2, 1.4, -1.6, -1.5, 0.3], [0.4, -1.2, 1.4, -1.6, -1.5, 0.3]
RIGHT = [-0.4, -1.1, 1.4, -1.6, -1.5, 0.3]
SIGNALS = ("more", "big", "done")


@pytest.fixture
def arm(steps: Client) -> Robot:
    """Return a UR5e before a tray, and signals that are off, in a stepped world."""
    arm = steps.load_robot("model://ur5e", name="arm")
    arm.set_positions(HOME)
    steps.scene.add_object("tray", pose=arm.tcp @ pose(x=0.05, z=0.02, yaw=0.5))
    for name in SIGNALS:
        steps.signals.create(name)
    return arm


def sorting(client: Client, arm: Robot) -> Program:
    """Return a program of two rounds, of which the first takes one branch, and the second the other one.

    It sets the signals that it decides by, so that nobody else need do anything. Each move begins where all ways meet.
    """
    new = client.program
    small = new().move(arm.ptp(RIGHT)).dwell(0.4).set("more", False)
    big = new().move(arm.linear(pose(z=-0.04), reference="tray", velocity=0.3), zone=0.01)
    big.move(arm.linear(pose(x=0.03), reference="tray")).dwell(0.4).set("big", False)
    around = new().move(arm.ptp(LEFT, speed_factor=0.5)).dwell(0.4).if_("big", then=big, otherwise=small)
    around.move(arm.ptp(HOME)).dwell(0.4)
    never = new().move(arm.ptp(LEFT))
    program = new().set("more", True).set("big", True).while_(around, "more").if_("big", then=never)
    return program.if_("more", False, then=new().set("done", True))


def done(program: RobotProgram) -> list[np.ndarray]:
    """Return the goals (6,) that the program of `sorting` goes to, one after the other: first where it begins."""
    (loop,) = [one for _, one in program.statements if isinstance(one, While)]
    (inner,) = [one for _, one in loop.body if isinstance(one, If)]
    goals = [np.array(HOME)]
    for way in (inner.then, inner.otherwise):
        for _, one in loop.body:
            statements = way if one is inner else [("", one)]
            goals += [each.goal.joints for _, each in statements if isinstance(each, PointToPoint | Line)]
    return goals


def rests(client: Client, arm: Robot, run: Callable[[], object]) -> list[np.ndarray]:
    """Return where the joints stand still meanwhile, one posture after the other, as something runs."""
    found = [arm.positions]
    last = found

    def step() -> None:
        nonlocal last
        client.clock.step(10)
        now = [arm.positions]
        if np.array_equal(now[0], last[0]) and np.abs(now[0] - found[-1]).max() > 1e-4:
            found.append(now[0])
        last = now

    with repeated(step, 0.0):
        run()
    return found


def test_the_kernel_and_rapid_do_the_same(arm: Robot, steps: Client) -> None:
    program = sorting(steps, arm)
    found = robot_program(steps, program, arm, "sorting")
    kernel = rests(steps, arm, lambda: program.start(wait=False).wait(timeout=PATIENCE_SECONDS))
    assert steps.signals["done"] is True
    goals = done(found)
    places = [*goals[:2], *goals[3:]]  # the first line's corner is cut
    np.testing.assert_allclose(kernel, places, atol=1e-6)
    steps.signals["done"] = False
    text = rapid.write(found, Language({}))
    assert "IF DOutput(big) = 1 THEN" in text and "WHILE DOutput(more) = 1 DO" in text and "ELSE" in text
    task = RapidTask(load([Source(text, "sorting.mod")], steps.signals), World(steps, "arm", lambda _: None), print)
    np.testing.assert_allclose(rests(steps, arm, task.run), places, atol=1e-6)
    assert steps.signals["done"] is True


def test_krl_and_tp_do_the_same(arm: Robot, steps: Client) -> None:
    program = robot_program(steps, sorting(steps, arm), arm, "sorting")
    addresses = {name: f"$OUT[{number}]" for number, name in enumerate(SIGNALS, 1)}
    text = krl.write(program, Language(addresses))
    found = read_krl(text)
    kinds = ["PTP", "PTP", "LIN", "LIN", "PTP", "PTP", "PTP", "PTP"]
    given = [one for one in found.steps if one[0] in ("PTP", "LIN")]
    assert [one[0] for one in given] == kinds and found.signals["$OUT[3]"] == "TRUE"
    goals = done(program)
    for (kind, places, speed, _, _), goal in zip(given, goals, strict=True):
        if kind == "PTP":
            np.testing.assert_allclose(places[0], goal, atol=1e-9)
        else:
            assert speed in (0.3, 0.25)
    assert [given[place][2] for place in (0, 1, 4, 5)] == [0.1, 0.5, 1.0, 0.5]
    addresses = {name: f"DO[{number}]" for number, name in enumerate(SIGNALS, 1)}
    tp = read_tp(fanuc.write(program, Language(addresses)), 1.0)
    moved = [one for one in tp.steps if one[0] in "JL"]
    assert [one[0] for one in moved] == ["J" if one == "PTP" else "L" for one in kinds] and tp.signals["DO[3]"] == "ON"
    np.testing.assert_allclose([one[1][0] for one in moved], goals, atol=2e-8)


def test_a_script_does_the_same_on_the_controller_of_a_ur(arm: Robot, steps: Client) -> None:
    program = robot_program(steps, sorting(steps, arm), arm, "sorting")
    addresses = {name: f"standard_out[{number}]" for number, name in enumerate(SIGNALS)}
    controller = Controller(SimulatedArm(arm.positions.copy()))
    run_script(controller, urscript.write(program, Language(addresses)))
    targets = []
    while controller.program is not None and len(targets) < 20_000:
        controller.cycle()
        targets.append(controller.target.copy())
    assert not controller.words and controller.digital_outputs == 0b100
    way, begin = np.array(targets), 0
    for number, goal in enumerate(done(program)):
        if number == 2:
            continue  # its corner is cut
        near = np.flatnonzero(np.abs(way[begin:] - goal).max(axis=1) < 1e-4)
        assert near.size
        begin += int(near[0])
    np.testing.assert_allclose(way[-1], HOME, atol=1e-4)


def test_speeds_from_several_places_are_the_slowest(arm: Robot, steps: Client) -> None:
    """A joint move keeps its share; in languages that tell the speed of its tool or joint, that of the slower way."""
    new = steps.program
    program = new().move(arm.ptp(HOME)).if_("big", then=new().move(arm.ptp(RIGHT))).move(arm.ptp(LEFT))
    found = robot_program(steps, program, arm, "slower")
    alone = [robot_program(steps, new().move(arm.ptp(one)).move(arm.ptp(LEFT)), arm, "alone") for one in (HOME, RIGHT)]
    speeds = [[one for _, one in each.statements if isinstance(one, PointToPoint)][-1].speed for each in alone]
    last = found.statements[-1][1]
    assert isinstance(last, PointToPoint)
    assert last.speed == pytest.approx(min(speeds)) and last.share == 1.0
    assert ("step 2: its speed is that of the slowest of the ways that lead to it" in found.notes) == (
        not np.isclose(speeds[0], speeds[1])
    )


def test_a_loop_without_an_end_has_nothing_after_it(arm: Robot, steps: Client) -> None:
    """A first move within a decision is led to, and what is planned from the end of a round is the same."""
    new = steps.program
    steps.signals.create("level", 0.5)
    around = new().move(arm.linear(arm.tcp @ pose(z=-0.02))).move(arm.ptp(HOME)).wait("level", 0.2, comparison=">")
    program = new().while_(around.if_("level", 0.7, ">=", then=new().set("big", True))).move(arm.ptp(LEFT))
    found = robot_program(steps, program, arm, "forever")
    assert [type(one).__name__ for _, one in found.statements] == ["UseTool", "PointToPoint", "While"]
    assert found.notes == (
        "step 1 and what follows it are never reached: the loop before it has no end",
        "step 0: it begins where the robot stands now, so the program goes there first",
    )
    assert sum(1 for _ in every(found.statements)) == 8
    text = rapid.write(found, Language({}))
    assert "WHILE TRUE DO" in text and "IF level >= 0.7 THEN" in text
    load([Source(text, "forever.mod")], steps.signals)
    assert "LOOP" in krl.write(found, Language({"level": "$ANIN[1]", "big": "$OUT[1]"}))
    text = fanuc.write(found, Language({"level": "AI[1]", "big": "DO[1]"}))
    assert "IF AI[1]<0.7,JMP LBL[1]" in text and "JMP LBL[2]" in text
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"step 0\[0\].2: a digital signal that is > a number"):
        urscript.write(found, Language({"level": "standard_in[1]", "big": "standard_out[1]"}))


def test_a_tool_that_stands_apart_is_not_left_out(arm: Robot, steps: Client) -> None:
    steps.scene.add_frame("workpiece", parent=arm.flange)
    steps.scene.add_frame("spindle", pose=arm.tcp)
    line = arm.linear(pose(z=0.01), reference="workpiece", fixed_tool="spindle")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="the tool 'spindle' stands apart from the robot"):
        robot_program(steps, steps.program().move(line), arm, "apart")
