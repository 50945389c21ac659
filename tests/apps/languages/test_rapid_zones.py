"""World zones of RAPID: shapes, outputs that follow the robot, and zones that end the program."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.languages.core.trial import Trial
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World
from virtualrobot_apps.languages.rapid.zones import Shape, box, cylinder, joints_between, outside, sphere

from tests.apps.languages.rapid import loaded

NONE = 9e9
RANGE = joints_between([-10, NONE, 20, NONE, NONE, NONE], [10, NONE, 30, NONE, NONE, NONE])


@pytest.mark.parametrize(
    ("shape", "within", "without"),
    [
        (box([0, 20, 0], [10, -20, 5]), [(0, 0, 0), (10, -20, 5)], [(0, 0, 5.1), (-0.1, 0, 0), (5, 21, 1)]),
        (cylinder([1, 2, 3], 10, 5), [(11, 2, 3), (1, 2, 8)], [(11.1, 2, 3), (1, 2, 8.1), (1, 2, 2.9)]),
        (cylinder([1, 2, 3], 10, -5), [(1, 12, 3), (1, 2, -2)], [(1, 2, 3.1), (1, 2, -2.1)]),
        (sphere([1, 2, 3], 5), [(1, 2, 8), (4, 6, 3)], [(1, 2, 8.1), (5, 6, 3)]),
    ],
)
def test_shapes_have_their_places(
    shape: Shape, within: list[tuple[float, ...]], without: list[tuple[float, ...]]
) -> None:
    joints = np.zeros(6)
    assert [shape(np.array(place), joints) for place in within] == [True] * len(within)
    assert [shape(np.array(place), joints) for place in without] == [False] * len(without)
    assert not outside(shape)(np.array(within[0]), joints)


def test_joints_without_a_bound_may_be_anywhere() -> None:
    place = np.zeros(3)
    assert RANGE(place, np.array([10, 170, 20, -90, 0, 0]))
    assert not RANGE(place, np.array([10, 170, 19, -90, 0, 0]))
    assert not RANGE(place, np.array([10.1, 170, 25, -90, 0, 0]))


PROGRAM = r"""
MODULE Tried
  CONST jointtarget ready := [[0, 0, 0, 0, 60, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST jointtarget wide := [[5, 5, 9E9, 9E9, 9E9, 9E9], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget over := [[350, 0, 400], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  CONST robtarget left := [[350, 200, 400], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
  VAR wztemporary zone;
  VAR wzstationary home := [0];
  VAR shapedata volume;
  PROC main()
    VAR shapedata posture;
    ConfL \Off;
    MoveAbsJ ready, v1000, fine, tool0;
    WZBoxDef \Inside, volume, [300, -50, 500], [400, 50, 300];
STATEMENTS
  ENDPROC
  PROC tell()
    TPWrite "zone " + ValToStr(DOutput(out)) + ", home " + ValToStr(DOutput(atHome));
  ENDPROC
ENDMODULE
"""
"""At `ready` the flange of an IRB 120 is at (338, 0, 568), above the volume, in whose middle `over` is."""

FOLLOWED = r"""
    WZFree zone;
    WZDOSet \Temp, zone \Inside, volume, out, 1;
    WZHomeJointDef \Inside, posture, ready, wide;
    WZDOSet \Stat, home \Inside, posture, atHome, 1;
    tell;
    MoveJ over, v1000, fine, tool0;
    tell;
    MoveJ left, v1000, fine, tool0;
    tell;
    WZDisable zone;
    MoveJ over, v1000, fine, tool0;
    tell;
    WZEnable zone;
    tell;
    WZFree zone;
    MoveAbsJ ready, v1000, fine, tool0;
    tell;
"""
INTO = r"""
    WZLimSup \Stat, home, volume;
    MoveJ left, v1000, fine, tool0;
    MoveL Offs(left, 0, -400, 0), v50, fine, tool0;
"""


def task_of(client: virtualrobot.Client, statements: str, lines: list[str]) -> tuple[RapidTask, World]:
    """Return a task in a world with an IRB 120, and the world."""
    client.load_robot("model://irb120", name="arm")
    for name in ("out", "atHome"):
        client.signals.create(name)
    world = World(client, "arm")
    return RapidTask(
        loaded(PROGRAM.replace("STATEMENTS", statements.strip("\n")), client.signals), world, lines.append
    ), world


@pytest.mark.long
def test_outputs_follow_the_robot(steps: virtualrobot.Client) -> None:
    lines: list[str] = []
    task, world = task_of(steps, FOLLOWED, lines)
    trial = Trial(steps, {task: world}, 10.0)
    trial.run(task.run)
    assert trial.findings == []
    each = [(0, 1), (1, 0), (0, 0), (0, 0), (1, 0), (1, 1)]
    assert lines == [f"zone {zone}, home {home}" for zone, home in each]


@pytest.mark.long
def test_a_trial_tells_the_move_that_leads_into_a_zone(steps: virtualrobot.Client) -> None:
    task, world = task_of(steps, INTO, [])
    trial = Trial(steps, {task: world}, 10.0)
    trial.run(task.run)
    (found,) = trial.findings
    assert (found.line, found.message) == (16, "the robot is in a world zone that WZLimSup keeps it out of")


@pytest.mark.long
def test_a_zone_ends_the_program_at_the_move_that_leads_into_it(client: virtualrobot.Client) -> None:
    """The line goes from y = 200 mm through the zone, which begins at 50 mm, and brakes within its first half."""
    task, _ = task_of(client, INTO, [])
    with pytest.raises(RapidStopped, match=r"^test\.mod:16: the robot is in a world zone"):
        task.run()
    y = 1000.0 * client.robot("arm").state.world_t_tcp[1, 3]
    assert 0.0 < y < 50.0
