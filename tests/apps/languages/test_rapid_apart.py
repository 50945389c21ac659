"""Stationary tools in RAPID, with work objects that the robot holds: the way of the tool on these, by formula.

The tool is at tframe in the frame of the base, the work object at uframe * oframe on the flange, so that a place P in
it has the flange at tframe * inv(P) * inv(uframe * oframe).
"""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest
import virtualrobot
from virtualrobot.geometry import Matrix
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded, numbers

BASE = virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4)
SPINDLE = virtualrobot.pose(0.42, 0.05, 0.3, pitch=math.pi)
PIECE = virtualrobot.pose(0.01, 0.0, 0.06) @ virtualrobot.pose(0.0, 0.02, 0.0, yaw=math.pi / 2)
DATA = r"""
PERS tooldata spindle := [FALSE, [[420, 50, 300], [0, 0, 1, 0]], [1, [0, 0, 1], [1, 0, 0, 0], 0, 0, 0]];
PERS wobjdata piece := [TRUE, TRUE, "", [[10, 0, 60], [1, 0, 0, 0]], [[0, 20, 0], [0.7071068, 0, 0, 0.7071068]]];
VAR robtarget there;
VAR jointtarget joints;
VAR jointtarget now;
CONST robtarget square := [[30, 10, 5], [1, 0, 0, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
"""


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an IRB 120 that stands somewhere."""
    client.clock.speed_factor = 5.0
    arm = client.load_robot("model://irb120", name="arm", pose=BASE)
    arm.set_positions({"joint_5": math.radians(60)})
    return arm


def task(client: virtualrobot.Client, statements: str) -> tuple[RapidTask, list[str]]:
    """Return a program on the arm, and its pendant."""
    text = f"MODULE Tried\n{DATA.strip()}\nPROC main()\nConfJ \\Off; ConfL \\Off;\n{statements}\nENDPROC\nENDMODULE"
    printed: list[str] = []
    return RapidTask(loaded(text, client.signals), World(client, "arm"), printed.append), printed


def on_piece(client: virtualrobot.Client, arm: virtualrobot.Robot) -> Matrix:
    """Return where the spindle is on the piece (4, 4), by where the flange is."""
    return np.linalg.inv(client.scene.pose(arm.flange) @ PIECE) @ BASE @ SPINDLE


def test_places_are_those_of_the_tool_on_the_work_object(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    run, printed = task(
        client,
        r"""
        MoveJ square, v500, fine, spindle \WObj:=piece;
        there := CRobT(\Tool:=spindle \WObj:=piece);
        TPWrite ValToStr(there.trans);
        TPWrite ValToStr(there.rot);
        MoveL RelTool(Offs(square, 20, 0, 10), 0, 0, 0 \Rz:=30), v100, fine, spindle \WObj:=piece;
        TPWrite ValToStr(CPos(\Tool:=spindle \WObj:=piece));
        there := CalcRobT(CJointT(), spindle \WObj:=piece);
        TPWrite ValToStr(there.trans);
        joints := CalcJointT(there, spindle \WObj:=piece);
        now := CJointT();
        reg1 := 0;
        reg2 := Abs(joints.robax.rax_4 - now.robax.rax_4);
        IF reg2 < 0.01 AND Abs(joints.robax.rax_1 - now.robax.rax_1) < 0.01 reg1 := 1;
        TPWrite NumToStr(reg1, 0);
        """,
    )
    run.run()
    first, turned, second, third, same = map(numbers, printed)
    assert first == pytest.approx([30, 10, 5], abs=1e-3)
    assert np.abs(turned) == pytest.approx([1, 0, 0, 0], abs=1e-5)
    assert second == pytest.approx([50, 10, 15], abs=1e-3)
    assert third == pytest.approx([50, 10, 15], abs=1e-3)
    assert same == [1], "and the joints that reach it are those that are there"
    expected = virtualrobot.pose(0.05, 0.01, 0.015, yaw=math.radians(30))
    np.testing.assert_allclose(on_piece(client, arm), expected, atol=1e-5)
    assert client.scene.nodes("tool") == [] and "arm.rapid-tool-2" not in client.scene


def test_lines_and_arcs_are_those_of_the_tool(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    """A line on which the piece turns by 60 degrees, a zone, a line, and half a circle of 20 mm radius."""
    task(client, r"MoveJ square, v500, fine, spindle \WObj:=piece;")[0].run()
    client.clock.speed_factor = 1.0
    run, _ = task(
        client,
        r"""
        MoveL RelTool(Offs(square, 40, 0, 0), 0, 0, 0 \Rz:=60), v50, z5, spindle \WObj:=piece;
        MoveL RelTool(Offs(square, 40, 40, 0), 0, 0, 0 \Rz:=60), v50, fine, spindle \WObj:=piece;
        MoveC Offs(square, 60, 60, 0), Offs(square, 40, 80, 0), v50, fine, spindle \WObj:=piece;
        """,
    )
    mover = threading.Thread(target=run.run)
    mover.start()
    places = []
    while mover.is_alive():
        places.append(on_piece(client, arm)[:3, 3] - [0.03, 0.01, 0.005])
    way = np.array(places)
    x, y = way[:, 0], way[:, 1]
    assert np.abs(way[:, 2]).max() < 2e-5
    first, second = (y < 1e-5) & (x < 0.035), (np.abs(x - 0.04) < 1e-5) & (y > 0.005) & (y < 0.04)
    zone = np.linalg.norm(way[:, :2] - [0.04, 0.0], axis=1) < 0.0055
    arc = np.abs(np.linalg.norm(way[:, :2] - [0.04, 0.06], axis=1) - 0.02) < 2e-5
    assert np.all(first | second | zone | arc)
    assert min(first.sum(), second.sum(), zone.sum(), arc.sum()) > 3
    assert np.linalg.norm(way[-1] - [0.04, 0.08, 0.0]) < 2e-5


@pytest.mark.parametrize(
    ("statements", "told"),
    [
        (
            "MoveL square, v50, fine, spindle;",
            r"a stationary tool \(robhold FALSE\) needs a work object that the robot",
        ),
        (r"MoveL square, v50, fine, tool0 \WObj:=piece;", r"needs a stationary tool \(robhold FALSE\)"),
        (r"reg1 := CPos(\Tool:=spindle).x;", "needs a work object that the robot holds"),
        (
            r"SearchL \Stop, part, there, square, v50, spindle \WObj:=piece;",
            "a stationary tool can't move with triggers or in a search yet",
        ),
    ],
)
def test_what_goes_not_together_is_told_at_its_line(
    client: virtualrobot.Client, arm: virtualrobot.Robot, statements: str, told: str
) -> None:
    client.signals.create("part")
    if "there" in statements:
        statements = f"MoveJ square, v500, fine, spindle \\WObj:=piece;\n{statements}"
    run, _ = task(client, statements.replace("CPos(\\Tool:=spindle).x", "VectMagn(CPos(\\Tool:=spindle))"))
    with pytest.raises(RapidStopped, match=told):
        run.run()


def test_a_program_with_a_stationary_tool_is_not_written_down(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    text = (
        f"MODULE T\n{DATA.strip()}\nPROC main()\nMoveJ square, v500, fine, spindle \\WObj:=piece;\nENDPROC\nENDMODULE"
    )
    with pytest.raises(RapidStopped, match="works with a stationary tool"):
        recorded(client, "arm", loaded(text, client.signals))
