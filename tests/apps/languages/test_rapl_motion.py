"""Programs in RAPL-II on the A255 and A465 of a real kernel: places, lines, curves, signals, the gripper, stops."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.rapl.command import rapl
from virtualrobot_apps.languages.rapl.faults import RaplStopped
from virtualrobot_apps.languages.rapl.task import RaplTask
from virtualrobot_apps.languages.rapl.world import World

from tests.apps.languages.rapl import LOCATIONS, loaded
from tests.apps.languages.tracing import traced
from tests.waiting import until

pytestmark = pytest.mark.long

SPEED_OF_TIME = 5.0
BASE = virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4)
"""Pose where the arm stands."""


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an A255 that stands somewhere, in a world whose time goes five times as fast."""
    client.clock.speed_factor = SPEED_OF_TIME
    return client.load_robot("model://a255", name="arm", pose=BASE)


class Run:
    """A program on the arm: what it shows, and its notes."""

    def __init__(self, client: virtualrobot.Client, text: str, locations: str = LOCATIONS, **more: str) -> None:
        """Load it."""
        self.shown: list[str] = []
        self.notes: list[str] = []
        self.world = World(client, "arm", self.notes.append)
        self.task = RaplTask(loaded(text, locations, **more), self.world, self.shown.append)

    def __call__(self) -> list[str]:
        """Run it, and return what it shows."""
        self.task.run()
        return self.shown


def numbers(line: str) -> list[float]:
    """Return the numbers of a line that W0 shows."""
    return [float(one) for one in line.split()[1:]]


def in_base(arm: virtualrobot.Robot) -> np.ndarray:
    """Return where the tool centre point is in the frame of the base, (3,) in mm."""
    return 1000.0 * (np.linalg.inv(BASE) @ arm.tcp)[:3, 3]


def traced_in_base(client: virtualrobot.Client, run: Callable[[], object]) -> np.ndarray:
    """Run something and return time and place (s, mm of the base) of the tool at each tick meanwhile, (n, 4)."""
    way = traced(client, run)
    way[:, 1:] = 1000.0 * (np.linalg.inv(BASE) @ np.c_[way[:, 1:], np.ones(len(way))].T).T[:, :3]
    return way


def test_places_are_those_of_the_base_and_pulses_those_of_the_gears(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """By hand: 72 and 1,000 pulses a turn of the motor are 200 a degree, 16 are 44.44, 8 are 22.22 (A255, page 8)."""
    shown = Run(
        client,
        """
        10 SPEED 100
        20 MOVE A
        30 W0
        40 MOTOR 1, 2000
        50 W0
        60 JOINT 5, 45
        70 FINISH
        80 W2
        90 MA 0, 1.5707963, -1.5707963, 0, 0
        100 MI 0.1, 0, 0, 0, 0
        110 W0
        120 HERE P
        130 HERE #P
        140 LISTL P
        150 LISTL #P
        """,
    )()
    at_a, turned, rolled, bent = shown[0:3], shown[3:6], shown[6:9], shown[9:12]
    assert numbers(at_a[2]) == pytest.approx([300, 0, 175, 0, 90, 0], abs=0.01)
    assert numbers(turned[1])[0] == pytest.approx(10.0, abs=1e-3)
    assert numbers(turned[0])[0] == 2000
    # Turned by 10 degrees about axis 1: 300 mm times cosine and sine.
    assert numbers(turned[2])[:3] == pytest.approx([295.442, 52.094, 175], abs=0.01)
    assert numbers(rolled[0])[4] == pytest.approx(1000.0 + numbers(turned[0])[4], abs=1)
    # Upper arm up, lower arm forwards: 254 + 50.8 from axis 1, 254 + 254 high, turned by 0.1 rad.
    reach = 254 + 50.8
    place = [reach * math.cos(0.1), reach * math.sin(0.1), 508, math.degrees(0.1), 0, 0]
    assert numbers(bent[2]) == pytest.approx(place, abs=0.01)
    assert shown[12] == f"POINT P {', '.join(f'{one:.3f}' for one in place)}"
    assert shown[13] == "POINT #P 1146, 18000, -18000, 0, 0"
    assert in_base(arm) == pytest.approx(place[:3], abs=0.01)


def test_the_program_runs_on_while_the_arm_moves_unless_it_says_finish(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    client.signals.create("output_1", False)
    run = Run(
        client,
        """
        10 SPEED 20
        20 MOVE A
        30 FINISH
        40 TIME T0
        50 MOVE B
        60 TIME T1
        70 OUTPUT 1
        80 FINISH
        90 TIME T2
        100 ! RUNSON = T1 - T0
        110 ! TAKES = T2 - T0
        120 TYPEV RUNSON, TAKES
        """,
    )
    runs_on, takes = map(float, run()[0].split())
    assert takes > 1.0
    assert runs_on < takes / 2
    assert client.signals["output_1"] is True
    assert in_base(arm) == pytest.approx([200, 150, 250], abs=0.01)
    assert run.notes == []


def test_straight_moves_are_lines_at_their_share_of_508_mm_a_second(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """The speed is that of the A255's page 8."""
    Run(client, "10 SPEED 100\n20 APPRO A, 100")()
    assert in_base(arm) == pytest.approx([300, 0, 275], abs=0.01)
    down = traced_in_base(client, Run(client, "10 SPEED 20\n20 MOVE A, S"))
    assert np.abs(down[:, 1:3] - [300, 0]).max() < 1e-3
    speed = np.linalg.norm(np.diff(down[:, 1:], axis=0), axis=1) / np.diff(down[:, 0])
    assert speed.max() == pytest.approx(0.2 * 508, rel=1e-3)
    Run(client, "10 SPEED 50\n20 DEPART 60, S\n30 JOG 0, 40, -10")()
    assert in_base(arm) == pytest.approx([300, 40, 225], abs=0.01)
    Run(client, "10 SPEED 50\n20 APPRO A, 30, S\n30 DEPART 20")()
    assert in_base(arm) == pytest.approx([300, 0, 225], abs=0.01)


def test_paths_pass_their_locations_without_a_stop(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    locations = "POINT A001 300 0 250 0 90 0\nPOINT A002 300 60 200 11.3 90 0\nPOINT A003 260 100 250 21.04 90 0\n"
    for text in ("20 CPATH A002, A003", "20 VIA A002, A003", "20 CTPATH 1, A, 2, 3, 30\n30 GOPATH 1"):
        Run(client, "10 SPEED 50\n20 MOVE A001", locations)()
        way = traced_in_base(client, Run(client, f"10 SPEED 30\n{text}", locations))
        passed = np.linalg.norm(way[:, 1:] - [300, 60, 200], axis=1)
        assert passed.min() < 2.0, text
        speed = np.linalg.norm(np.diff(way[:, 1:], axis=0), axis=1) / np.diff(way[:, 0])
        assert speed[passed.argmin()] > 10.0, text
        assert in_base(arm) == pytest.approx([260, 100, 250], abs=0.01), text


def test_inputs_are_waited_for_and_outputs_are_set(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    for name in ("input_1", "input_2", "output_4", "output_5"):
        client.signals.create(name, name == "output_5")
    client.signals.create("analog_1", 0.0)
    run = Run(
        client,
        """
        10 OUTPUT 4, -5
        20 WAIT 1
        30 IFSIG 1, -2 THEN 50
        40 STOP wrong
        50 IFSIG 2 THEN 70
        60 AOUT 1, -2.5
        70 DELAY 0.1
        80 OUTPUT -4
        90 TYPE 'done'
        """,
    )
    thread = threading.Thread(target=run)
    thread.start()
    try:
        until(lambda: client.signals["output_4"] is True and client.signals["output_5"] is False)
        assert not run.shown
        client.signals["input_1"] = True
    finally:
        run.task.ask("look")
        thread.join(30.0)
    assert run.shown == ["done"]
    assert client.signals["output_4"] is False
    assert client.signals["analog_1"] == -2.5


def test_halt_and_halt_on_stop_the_arm_on_its_way(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.signals.create("input_3", False)
    halted = Run(
        client,
        """
        10 SPEED 10
        20 MOVE #C
        30 DELAY 1
        40 HALT
        50 ACTUAL #P
        60 DELAY 0.5
        70 ACTUAL #Q
        80 LISTL #P
        90 LISTL #Q
        """,
    )()
    assert halted[0].removeprefix("POINT #P") == halted[1].removeprefix("POINT #Q")
    assert not np.allclose(arm.positions, np.radians([34.285, 73.03, -113.88, -49.14, 34.29]), atol=0.05)
    run = Run(client, "10 SPEED 10\n20 HALT ON 3\n30 MOVE #C\n40 TYPE 'after'")
    thread = threading.Thread(target=run)
    thread.start()
    try:
        until(lambda: bool(arm.state.motion_ids))
        client.signals["input_3"] = True
    finally:
        thread.join(30.0)
    assert run.shown == ["after"]
    assert not np.allclose(arm.positions, np.radians([34.285, 73.03, -113.88, -49.14, 34.29]), atol=0.05)


def test_tools_stances_and_the_posture_home(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    locations = f"{LOCATIONS}\nPOINT T 100, 0, 0, 0, 0, 0\nPOINT H 350 0 300 0 30 0\n"
    Run(client, "10 SPEED 100\n20 TOOL T\n30 MOVE A\n40 ALIGN", locations)()
    assert client.scene.nodes("tool") == []
    # The tool was 100 mm long and pointed down: the flange is 100 mm above the place.
    assert in_base(arm) == pytest.approx([300, 0, 275], abs=0.01)
    elbows = []
    for side in ("UP", "DOWN"):
        try:
            Run(client, f"10 SPEED 100\n20 ELBOW {side}\n30 MOVE H", locations)()
            elbows.append(side)
        except RaplStopped as error:
            assert "no posture within limits is" in str(error)
    assert "UP" in elbows
    Run(client, "10 SPEED 100\n20 READY")()
    assert np.degrees(arm.positions) == pytest.approx([0, 90, -90, 0, 0], abs=1e-3)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10 ;\n20 MOVE FAR", "main.rpl:2: line 20: "),
        ("10 SPEED 200", "main.rpl:1: line 10: the speed is 1 to 100 percent, not 200"),
        ("10 JOINT 6, 1", "main.rpl:1: line 10: the arm has joints 1 to 5, and no joint 6"),
        ("10 MOTOR 0, 1", "main.rpl:1: line 10: the arm has motors 1 to 5, and no motor 0"),
        ("10 MA 1, 2", "main.rpl:1: line 10: the arm has 5 joints, and 2 values are given"),
        ("10 JOINT 1, 200", "main.rpl:1: line 10: "),
        ("10 CPATH A, #C", "main.rpl:1: line 10: CPATH takes cartesian locations or precision points, and not both"),
        ("10 CPATH A, A", "main.rpl:1: line 10: two places in a row are the same"),
        ("10 GRIP 10", "main.rpl:1: line 10: the arm has no gripper with fingers"),
        ("10 HALT ON", "main.rpl:1: line 10: it is HALT, or HALT ON with an input"),
        ("10 TOOL #C", "main.rpl:1: line 10: #C is a precision point, and a tool is a cartesian location"),
    ],
)
def test_what_the_arm_cannot_do_ends_the_program_at_its_line(
    client: virtualrobot.Client, arm: virtualrobot.Robot, text: str, expected: str
) -> None:
    with pytest.raises(RaplStopped) as caught:
        Run(client, text, f"{LOCATIONS}\nPOINT FAR 900 0 200 0 90 0")()
    assert str(caught.value).startswith(expected)


def test_what_the_world_has_not_is_told_before_anything_moves(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    with pytest.raises(WrongStateError, match="the world has no signal input_2, output_1; create it by"):
        Run(client, "10 MOVE A\n20 OUTPUT 1\n30 WAIT 2")
    with pytest.raises(WrongStateError, match=r"^main\.rpl:2: the arm has no gripper to open and close"):
        Run(client, "10 FINISH\n20 CLOSE")
    with pytest.raises(WrongStateError, match="pulses are told for 2 joints, and 'arm' has 5"):
        World(client, "arm", pulses=[1.0, 2.0])
    client.load_robot("model://cobra600", name="scara")
    with pytest.raises(WrongStateError, match="RAPL-II moves arms with five or six here"):
        World(client, "scara")


def test_the_tool_of_an_arm_with_five_joints_points_from_axis_1(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    run = Run(client, "10 SPEED 100\n20 MOVE H\n30 W0", "POINT H 300 225 300 0 30 0")
    assert numbers(run()[2]) == pytest.approx([300, 225, 300, 36.87, 30, 0], abs=0.01)
    assert run.notes == ["the tool of an arm with five joints points from axis 1: turned by 36.87 degrees"]


def test_an_arm_of_six_joints_turns_its_wrist(client: virtualrobot.Client) -> None:
    """A465: its posture home is 330.2 + 304.8 mm high and 330.2 + 76.2 forwards; a wrist turned over is 180 degrees."""
    client.clock.speed_factor = SPEED_OF_TIME
    client.load_robot("model://a465", name="arm", pose=BASE)
    shown = Run(
        client,
        """
        10 SPEED 100
        20 READY
        30 W0
        40 MA 0.2, 0.3, -1.2, 0.4, 0.8, 0.1
        50 HERE P
        55 ELBOW UP
        60 WRIST FLIP
        70 MOVE P
        80 W0
        90 WRIST NOFLIP
        100 MOVE P
        110 W0
        """,
    )()
    assert numbers(shown[2])[:3] == pytest.approx([406.4, 0, 635], abs=0.01)
    assert numbers(shown[5]) == pytest.approx(numbers(shown[8]), abs=0.01)
    flipped, straight = numbers(shown[4]), numbers(shown[7])
    assert flipped[:3] == pytest.approx(straight[:3], abs=0.01)
    assert flipped[4] == pytest.approx(-straight[4], abs=0.01)
    assert abs(flipped[3] - straight[3]) == pytest.approx(180, abs=0.01)


PALLET = """
10 SPEED 100
20 ! N = 0
30 OPEN
40 SET P = FIRST
50 GOSUB PICK
60 SHIFT DROP, 0, 60, 0
70 SHIFT FIRST, 0, 50, 0
80 ++ N
90 IF N < 2 THEN 40
100 READY
"""
PICK = """
10 APPRO P, 60
20 MOVE P, S
30 FINISH
40 CLOSE
50 DEPART 60, S
60 APPRO DROP, 60
70 MOVE DROP, S
80 OPEN
90 DEPART 60, S
"""


def test_a_palletizing_program_moves_parts(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    arm.mount("model://vacuum_gripper", name="vacuum")
    high = 150.0
    for number, (x, y) in enumerate([(300, -50), (300, 0)], 1):
        pose = BASE @ virtualrobot.pose(x / 1000, y / 1000, high / 1000 - 0.02)
        client.scene.add_part(f"part {number}", virtualrobot.box(0.03, 0.03, 0.04), pose=pose)
    locations = f"POINT FIRST 300 -50 {high} 0 90 0\nPOINT DROP 200 150 {high} 0 90 0\n"
    run = Run(client, PALLET.strip(), locations, pick=PICK.strip())
    run()
    places = [1000 * (np.linalg.inv(BASE) @ client.scene.pose(f"part {number}"))[:3, 3] for number in (1, 2)]
    assert places[0] == pytest.approx([200, 150, high - 20], abs=0.1)
    assert places[1] == pytest.approx([200, 210, high - 20], abs=0.1)


def test_the_command_runs_a_program(client: virtualrobot.Client, arm: virtualrobot.Robot, tmp_path: Path) -> None:
    program = tmp_path / "job.rpl"
    program.write_text("10 SPEED 100\n20 MA 0.5, 1, -1, 0, 0\n30 OUTPUT 2\n40 TYPE 'there'\n50 CLOSE\n")
    address = client.address
    words = ["run", str(program), "--robot", "arm", "--create-signals", "--address", address]
    done = CliRunner().invoke(rapl, words, standalone_mode=False)
    assert done.exception is None, done.output
    assert done.output == "there\n"
    assert arm.positions[0] == pytest.approx(0.5, abs=1e-6)
    assert client.signals["output_2"] is True
    assert client.signals["gripper"] is True
