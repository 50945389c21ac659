"""Programs in RAPID on a robot of a real kernel: places, frames, speeds, zones, configurations, signals, refusals."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import WrongStateError
from virtualrobot_apps.languages.core.task import TaskStopped
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.recording import recorded
from virtualrobot_apps.languages.rapid.task import RapidTask
from virtualrobot_apps.languages.rapid.world import World

from tests.apps.languages.rapid import loaded, numbers
from tests.apps.languages.tracing import traced

DATA = r"""
PERS tooldata grip := [TRUE, [[0, 0, 100], [1, 0, 0, 0]], [1, [0, 0, 50], [1, 0, 0, 0], 0, 0, 0]];
PERS wobjdata table := [FALSE, TRUE, "", [[350, 0, 200], [0.70711, 0, 0, 0.70711]], [[0, 0, 0], [1, 0, 0, 0]]];
CONST jointtarget ready := [[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
CONST robtarget above := [[0, 0, 150], [0, 0, 1, 0], [0, 0, 0, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];
"""


@pytest.fixture
def arm(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an IRB 120 that stands somewhere in a world whose time goes five times as fast."""
    client.clock.speed_factor = 5.0
    return client.load_robot("model://irb120", name="arm", pose=virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4))


class Run:
    """A program on the arm: its pendant and its notes."""

    def __init__(self, client: virtualrobot.Client, statements: str, more: str = "") -> None:
        """Load it, with the data above."""
        program = loaded(
            f"MODULE Tried\n{DATA.strip()}{more}\nPROC main()\n{statements}\nENDPROC\nENDMODULE", client.signals
        )
        self.printed: list[str] = []
        self.notes: list[str] = []
        self.world = World(client, "arm", self.notes.append)
        self.task = RapidTask(program, self.world, self.printed.append)

    def __call__(self) -> list[str]:
        """Run it, and return its pendant."""
        self.task.run()
        return self.printed


def in_table(way: np.ndarray) -> np.ndarray:
    """Return the places of a way in the frame of the table, (n, 3) in m, by the poses where robot and table stand."""
    world_t_table = virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4) @ virtualrobot.pose(0.35, 0.0, 0.2, yaw=math.pi / 2)
    return (np.linalg.inv(world_t_table) @ np.c_[way[:, 1:], np.ones(len(way))].T).T[:, :3]


def paced(way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (n, 3) of a way in the table's frame, in m, and the speeds (n - 1,) between them, in m/s."""
    places = in_table(way)
    return places, np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(way[:, 0])


def test_joints_and_places_are_those_of_the_program(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    """The place by hand: the table is at (350, 0, 200) of the base, turned by a quarter; the tool is 100 mm, down."""
    run = Run(
        client,
        r"""
        MoveAbsJ ready, v1000, fine, tool0;
        TPWrite ValToStr(CJointT());
        MoveJ above, v1000, z50, grip \WObj:=table;
        MoveL Offs(above, 40, 0, -50), v500, fine, grip \WObj:=table;
        TPWrite ValToStr(CPos(\Tool:=grip \WObj:=table));
        TPWrite ValToStr(CPos(\Tool:=tool0));
        TPWrite ValToStr(CPos());
        """,
    )
    joints, in_table, flange, tip = map(numbers, run())
    assert joints[:6] == pytest.approx([0, 0, 0, 0, 30, 0], abs=1e-4)
    assert in_table == pytest.approx([40, 0, 100], abs=1e-3)
    assert flange == pytest.approx([350, 40, 400], abs=0.01)
    assert tip == pytest.approx([350, 40, 300], abs=0.01)
    assert run.world.client.scene.nodes("tool") == []
    assert arm.state.tool == ""
    # The flange in the world, by the pose where the robot stands.
    at = virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4) @ np.array([0.350, 0.040, 0.400, 1.0])
    assert arm.tcp[:3, 3] == pytest.approx(at[:3], abs=1e-5)


def test_lines_are_as_fast_as_their_speed_and_arcs_pass_their_point(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    run = Run(
        client,
        r"""
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        MoveL Offs(above, 100, 0, 0), v100, fine, tool0 \WObj:=table;
        MoveC Offs(above, 50, 50, 0), Offs(above, 0, 0, 0), v1000 \V:=50, fine, tool0 \WObj:=table;
        """,
    )
    places, speeds = paced(traced(client, run))
    on_line = (np.abs(places[:-1, 1:] - [0, 0.15]).max(axis=1) < 1e-6) & (speeds > 1e-9)
    assert speeds[on_line].max() == pytest.approx(0.1, rel=1e-3)
    center = np.array([0.05, 0.0, 0.15])
    on_arc = (places[:-1, 1] > 1e-3) & (np.abs(places[:-1, 2] - 0.15) < 1e-6)
    assert np.linalg.norm(places[:-1][on_arc] - center, axis=1) == pytest.approx(0.05, abs=1e-5)
    assert speeds[on_arc].max() == pytest.approx(0.05, rel=1e-3)
    assert np.linalg.norm(places - [0.05, 0.05, 0.15], axis=1).min() < 3e-4


@pytest.mark.long
@pytest.mark.parametrize(("rate", "time"), [(20, ""), (150, ""), (150, r" \T:=9")], ids=["slow", "quick", "timed"])
def test_a_tool_turns_on_the_spot_as_fast_as_v_ori_says(
    client: virtualrobot.Client, arm: virtualrobot.Robot, rate: float, time: str
) -> None:
    """The axis of the flange alone turns, by 90 degrees; without v_ori the kernel's lines turn by 2 rad/s at most."""
    velocity = np.degrees(arm.limits["joint_6"].velocity)
    acceleration = np.degrees(arm.limits["joint_6"].acceleration)
    statements = rf"MoveL RelTool(here, 0, 0, 0 \Rz:=90), [100, {rate}, 100, 100]{time}, fine, tool0;"
    program = loaded(
        "MODULE T\nVAR robtarget here;\nPROC main()\nConfL \\Off;\n"
        "here := CalcRobT([[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], tool0);\n"
        "MoveAbsJ [[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v1000, fine, tool0;\n"
        f"{statements}\nENDPROC\nENDMODULE",
        client.signals,
    )
    plan = recorded(client, "arm", program).plan()
    turning = np.degrees(np.abs(np.diff(plan.robots["arm"].positions[:, 5]))) / np.diff(plan.times)
    if time:
        (moves,) = np.nonzero(turning)
        assert plan.times[moves[-1] + 1] - plan.times[moves[0]] == pytest.approx(9.0, abs=0.05)
        return
    reachable = math.sqrt(90.0 * acceleration)
    assert turning.max() == pytest.approx(min(rate, velocity, reachable), rel=0.02)


def test_a_move_with_a_time_takes_it_exactly_from_rest_to_rest(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """A line of 100 mm and half a circle take 2 s each, 60 degrees 4 s; a zone has the way's speed instead."""
    run = Run(
        client,
        r"""
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        MoveL Offs(above, 100, 0, 0), v1000 \T:=2, fine, tool0 \WObj:=table;
        MoveC Offs(above, 50, 50, 0), Offs(above, 0, 0, 0), v1000 \T:=2, fine, tool0 \WObj:=table;
        """,
    )
    way = traced(client, run)
    places, speeds = paced(way)
    seconds = np.diff(way[:, 0])
    on_line = (np.abs(places[:-1, 1:] - [0, 0.15]).max(axis=1) < 1e-6) & (speeds > 1e-9)
    assert seconds[on_line].sum() == pytest.approx(2.0, abs=0.05)
    on_arc = (places[:-1, 1] > 1e-6) & (np.abs(places[:-1, 2] - 0.15) < 1e-6)
    assert seconds[on_arc].sum() == pytest.approx(2.0, abs=0.1)
    Run(client, "MoveAbsJ ready, v1000, fine, tool0;")()
    turn = r"MoveAbsJ [[60, 0, 0, 0, 30, 0], [0, 0, 0, 0, 0, 0]], v1000 \T:=4, fine, tool0;"
    way = traced(client, Run(client, turn))
    from_axis = way[:, 1:3] - [0.5, -0.3]
    turned = np.abs(np.diff(np.unwrap(np.arctan2(from_axis[:, 1], from_axis[:, 0]))))
    assert turned.sum() == pytest.approx(math.radians(60), abs=1e-6)
    assert np.diff(way[:, 0])[turned > 0.0].sum() == pytest.approx(4.0, abs=0.05)
    run = Run(
        client,
        r"""
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        MoveL Offs(above, 100, 0, 0), v1000 \T:=2, z10, tool0 \WObj:=table;
        MoveL Offs(above, 100, 100, 0), v1000, fine, tool0 \WObj:=table;
        """,
    )
    places, speeds = paced(traced(client, run))
    on_line = (np.abs(places[:-1, 1:] - [0, 0.15]).max(axis=1) < 1e-6) & (places[:-1, 0] < 0.08)
    assert speeds[on_line].max() == pytest.approx(0.05, rel=1e-3)
    with pytest.raises(RapidStopped, match=r"a move takes more than 0 s \(T\), not 0"):
        Run(client, r"MoveAbsJ ready, v1000 \T:=0, fine, tool0;")()


def test_joint_moves_keep_the_speed_of_the_tool_centre_point(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """The speed is set by the way in eight pieces, of which each is gone a little faster than its chord."""
    run = Run(client, "MoveAbsJ [[60, 30, -20, 40, 50, 0], [0, 0, 0, 0, 0, 0]], v200, fine, tool0;")
    way = traced(client, run)
    speeds = np.linalg.norm(np.diff(way[:, 1:], axis=0), axis=1) / np.diff(way[:, 0])
    assert 0.19 < speeds.max() < 0.21


@pytest.mark.parametrize(("zone", "radius"), [("z20", 0.02), ("fine", 0.0)])
def test_a_zone_rounds_the_corner_off_by_its_parabola(
    client: virtualrobot.Client, arm: virtualrobot.Robot, zone: str, radius: float
) -> None:
    """The radius of z20 is 20 mm (ABB, zonedata); the parabola passes a corner of 90 degrees at radius √2 / 4."""
    client.signals.create("begin")
    run = Run(
        client,
        rf"""
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        WaitDI begin, 1;
        MoveL Offs(above, 100, 0, 0), v200, {zone}, tool0 \WObj:=table;
        MoveL Offs(above, 100, 100, 0), v200, fine, tool0 \WObj:=table;
        """,
    )

    def begun_when_all_is_planned() -> None:
        thread = threading.Thread(target=run)
        thread.start()
        while not any(motion.step_count == 4 for motion in client.motions()):
            assert thread.is_alive()
            time.sleep(0.01)
        client.signals["begin"] = True
        thread.join(60)

    way = traced(client, begun_when_all_is_planned)[:, 1:]
    world_t_table = virtualrobot.pose(0.5, -0.3, 0.2, yaw=0.4) @ virtualrobot.pose(0.35, 0.0, 0.2, yaw=math.pi / 2)
    corner = (world_t_table @ [0.1, 0.0, 0.15, 1.0])[:3]
    assert run.world.queue.notes == []
    first, ways = way[:-1], np.diff(way, axis=0)
    share = ((corner - first) * ways).sum(axis=1) / np.maximum((ways**2).sum(axis=1), 1e-18)
    off = np.linalg.norm(first + np.clip(share, 0.0, 1.0)[:, None] * ways - corner, axis=1).min()
    assert off == pytest.approx(radius * math.sqrt(2.0) / 4.0, rel=0.01, abs=1e-6)


@pytest.mark.parametrize("model", ["irb120", "irb140", "irb6640_180_255"])
def test_a_place_with_its_configuration_is_one_posture(
    client: virtualrobot.Client, model: str, draws: Callable[[int], int], rng: np.random.Generator
) -> None:
    """CalcJointT of CalcRobT gives the joints again: cf1, cf4, cf6 and cfx tell all branches and turns apart."""
    arm = client.load_robot(f"model://{model}", name="arm")
    world = World(client, "arm")
    world.begin(RapidTask(loaded("MODULE T\nENDMODULE")))
    tool = [True, [[10.0, 0.0, 150.0], [0.92388, 0.0, 0.38268, 0.0]]]
    limits = [arm.limits[name] for name in arm.joint_names]
    low, high = (np.array([getattr(one, side) for one in limits]) for side in ("lower", "upper"))
    for _ in range(draws(100)):
        joints = rng.uniform(np.maximum(low, -math.pi), np.minimum(high, math.pi))
        if abs(joints[4]) < 0.05:
            continue  # there axes 4 and 6 are one
        again = world.joints_for(world.target_at(joints, tool, None), tool, None)
        assert again == pytest.approx(joints, abs=1e-5)
    world.close()


def test_a_configuration_that_no_posture_has_is_told_and_the_nearest_one_taken(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    run = Run(
        client,
        r"""
        VAR robtarget sloppy;
        sloppy := above;
        sloppy.robconf := [3, 3, 3, 7];
        FOR i FROM 1 TO 2 DO
          MoveJ sloppy, v1000, fine, tool0 \WObj:=table;
        ENDFOR
        ConfJ \Off;
        MoveJ sloppy, v1000, fine, tool0 \WObj:=table;
        """,
    )
    run()
    assert len(run.notes) == 1
    assert "no posture within limits has the configuration [3, 3, 3, 7]; the nearest one is taken" in run.notes[0]
    assert run.notes[0].startswith("test.mod:12: ")


def test_a_target_out_of_reach_calls_the_handler_and_else_ends_the_program_at_its_line(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    far = r"MoveL Offs(above, 2000, 0, 0), v500, fine, tool0 \WObj:=table;"
    run = Run(
        client,
        f"""
        MoveJ above, v1000, fine, tool0 \\WObj:=table;
        {far}
        TPWrite ValToStr(CPos(\\WObj:=table));
        ERROR
          IF ERRNO = ERR_ROBLIMIT THEN
            TPWrite "too far";
            TRYNEXT;
          ENDIF
        """,
    )
    said, place = run()
    assert said == "too far"
    assert numbers(place) == pytest.approx([0, 0, 150], abs=1e-3)
    with pytest.raises(RapidStopped, match=r"^test.mod:8: ERR_ROBLIMIT: "):
        Run(client, f"MoveJ above, v1000, fine, tool0 \\WObj:=table;\n{far}")()


def test_what_can_not_be_done_is_said_at_its_line(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.signals.create("part")
    for statements, expected in [
        (
            "grip.robhold := FALSE; MoveJ above, v100, fine, grip;",
            "a stationary tool (robhold FALSE) needs a work object that the robot holds",
        ),
        (r"table.robhold := TRUE; MoveJ above, v100, fine, grip \WObj:=table;", "a work object that the robot holds"),
        (r"table.ufprog := FALSE; MoveJ above, v100, fine, grip \WObj:=table;", "is on the mechanical unit"),
        (r"MoveJ above, v100 \V:=0, fine, tool0 \WObj:=table;", "the speed 0 mm/s is not above 0"),
        (
            r"table.uframe.rot := [1, 1, 0, 0]; MoveJ above, v100, fine, tool0 \WObj:=table;",
            "has the length 1.41421 and not 1",
        ),
        ("VelSet 0, 100;", "VelSet takes more than 0 to 100 percent"),
        ("SetDO part, 2;", "the signal 'part' is 0 or 1, not 2"),
        ("WaitTime -1;", "WaitTime takes 0 s or more, not -1"),
        (
            "MoveAbsJ [[0, 0, 0, 0, 600, 0], [0, 0, 0, 0, 0, 0]], v100, fine, tool0;",
            "ERR_ROBLIMIT: axis 5 can't be at 600 degrees; its limits are -120 to 120",
        ),
    ]:
        with pytest.raises(RapidStopped) as caught:
            Run(client, statements)()
        code = expected.partition(":")[0] if expected.startswith("ERR_") else "ERR_ARGVALERR"
        assert str(caught.value).startswith(f"test.mod:7: {code}: ")
        assert expected in str(caught.value)
    assert client.motions() == []


def test_signals_are_set_in_order_and_read_when_the_robot_is_there(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    for name in ("grip done", "part", "Count", "level"):
        client.signals.create(name.replace(" ", "_"), {"Count": 0, "level": 0.0}.get(name, False))
    changes: list[tuple[float, str]] = []
    with client.signals.follow() as watch:
        told = iter(watch)
        next(told)
        run = Run(
            client,
            r"""
            MoveAbsJ ready, v1000, z50, tool0;
            Set PART;
            MoveAbsJ [[20, 0, 0, 0, 30, 0], [0, 0, 0, 0, 0, 0]], v500, fine, tool0;
            SetGO count, 3;
            SetAO Level, 2.5;
            IF part = 1 AND TestDI(part) AND GOutput(count) = 3 TPWrite ValToStr(AOutput(level));
            TPWrite ValToStr(CJointT());
            InvertDO part;
            SetDO grip_done, high;
            """,
        )
        lines = run()
        while len(changes) < 5:
            change = next(told)
            changes += [(change.stamp.simulation_time, name) for name in change.values]
    assert lines[0] == "2.5"
    assert numbers(lines[1])[0] == pytest.approx(20, abs=1e-3)
    assert [name for _, name in changes] == ["part", "Count", "level", "part", "grip_done"]
    assert changes[0][0] < changes[1][0], "the first one is set in the zone, while the robot moves"


def test_waiting_for_signals_times_and_conditions(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.signals.create("go")
    client.signals.create("stop")
    run = Run(
        client,
        r"""
        VAR bool late;
        WaitDI go, 1 \MaxTime:=0.2 \TimeFlag:=late;
        TPWrite "late " \Bool:=late;
        ClkReset clock1;
        ClkStart clock1;
        WaitTime 0.5;
        ClkStop clock1;
        TPWrite "waited " \Bool:=ClkRead(clock1) >= 0.5;
        WaitDI go, 1;
        TPWrite "go";
        WaitUntil stop = 1 AND late;
        WaitUntil stop = 1 \MaxTime:=0.1 \TimeFlag:=late;
        TPWrite "late " \Bool:=late;
        WaitUntil stop = 0 \MaxTime:=0.1;
        TPWrite "never";
        ERROR
          TPWrite "too late " \Bool:=ERRNO = ERR_WAIT_MAXTIME;
          RETURN;
        """,
    )
    thread = threading.Thread(target=run)
    thread.start()
    while "waited TRUE" not in run.printed:
        assert thread.is_alive()
        time.sleep(0.01)
    client.signals["go"] = True
    while "go" not in run.printed:
        assert thread.is_alive()
        time.sleep(0.01)
    client.signals["stop"] = True
    thread.join(60)
    assert run.printed == ["late TRUE", "waited TRUE", "go", "late FALSE", "too late TRUE"]


def test_a_stop_brakes_the_robot_and_puts_its_tool_back(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.scene.add_tool("own", parent=arm.flange, tool_center_points={"tip": virtualrobot.pose(z=0.05)})
    run = Run(
        client,
        r"""
        WHILE TRUE DO
          MoveJ above, v100, z50, grip \WObj:=table;
          MoveJ Offs(above, 100, 50, 0), v100, z50, grip \WObj:=table;
        ENDWHILE
        """,
    )
    threading.Timer(0.5, run.task.stop, ["by hand"]).start()
    with pytest.raises(TaskStopped, match="by hand"):
        run()
    while client.motions():
        time.sleep(0.01)
    assert arm.state.tool == "own"
    assert [node.name for node in client.scene.nodes("tool")] == ["own"]


def test_a_program_ends_when_somebody_stops_its_robot(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    run = Run(
        client,
        """
        WHILE TRUE DO
          MoveAbsJ ready, v100, fine, tool0;
          MoveAbsJ [[90, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]], v100, fine, tool0;
        ENDWHILE
        """,
    )
    threading.Timer(0.5, client.stop).start()
    with pytest.raises(RapidStopped, match=r"test.mod:\d+: motion .* was cancelled"):
        run()


def test_signals_and_robots_that_do_not_fit_are_told_before_anything_moves(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    with pytest.raises(WrongStateError, match=r"the world has no signal doGrip \(test.mod:7\), other \(test.mod:8\)"):
        Run(client, "SetDO doGrip, 1;\nWaitDI other, 1;")
    client.load_robot("model://iiwa", name="seven", pose=virtualrobot.pose(y=2.0))
    with pytest.raises(WrongStateError, match="'seven' has 7 joints"):
        World(client, "seven")
    with pytest.raises(RapidStopped, match=r"test.mod:3: .*started without a robot"):
        RapidTask(
            loaded("MODULE T\nPROC main() WaitTime 1;\nENDPROC\nENDMODULE".replace(" WaitTime", "\nWaitTime"))
        ).run()


def test_traps_run_between_statements_and_while_the_robot_moves(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    client.signals.create("button")
    client.signals.create("moving")
    run = Run(
        client,
        r"""
        CONNECT pressed WITH on_button;
        ISignalDI button, edge, pressed;
        CONNECT ticking WITH on_timer;
        ITimer 0.2, ticking;
        Set moving;
        MoveAbsJ [[90, 0, 0, 0, 30, 0], [0, 0, 0, 0, 0, 0]], v50, fine, tool0;
        WaitUntil presses = 2;
        IDelete ticking;
        IDisable;
        SetDO button, 1;
        WaitTime 0.1;
        TPWrite "kept back " \Num:=presses;
        IEnable;
        WaitTime 0.1;
        TPWrite "presses " \Num:=presses;
        TPWrite "ticks " \Bool:=ticks >= 5;
        ISleep pressed;
        SetDO button, 0;
        WaitTime 0.1;
        TPWrite "asleep " \Num:=presses;
        """,
        r"""
        VAR intnum pressed;
        VAR intnum ticking;
        VAR num presses := 0;
        VAR num ticks := 0;
        TRAP on_button
          presses := presses + 1;
          IF INTNO <> pressed TPWrite "another one";
        ENDTRAP
        TRAP on_timer
          Incr ticks;
        ENDTRAP
        """,
    )
    thread = threading.Thread(target=run)
    thread.start()
    client.signals.wait_for("moving", timeout=60)
    client.signals["button"] = True
    client.signals["button"] = False
    thread.join(60)
    assert run.printed == ["kept back 2", "presses 3", "ticks TRUE", "asleep 3"]


def test_changes_of_groups_of_signals_call_traps_and_a_group_is_set_later(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    client.signals.create("code", 0)
    client.signals.create("all_set")
    run = Run(
        client,
        r"""
        CONNECT changed WITH on_code;
        ISignalGI code, changed;
        SetGO code, 5;
        SetGO \SDelay:=0.2, code, 7;
        SetDO \Sync, all_set, 1;
        WaitUntil count = 2;
        IDelete changed;
        CONNECT changed WITH on_code;
        ISignalGO \Single, code, changed;
        SetGO code, 8;
        SetGO code, 9;
        WaitTime 0.2;
        """,
        r"""
        VAR intnum changed;
        VAR num count := 0;
        TRAP on_code
          Incr count;
          TPWrite "code " \Num:=count;
        ENDTRAP
        """,
    )
    assert run() == ["code 1", "code 2", "code 3"]
    assert client.signals["code"] == 9


def test_an_error_in_a_trap_ends_the_program_at_its_line(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    """ABB, RAPID Reference Manual 5-34: an error that leaves a trap is dealt with by the system's error handler."""
    run = Run(
        client,
        """
        CONNECT soon WITH broken;
        ITimer \\Single, 0.01, soon;
        WHILE TRUE DO ENDWHILE
        ERROR
          TRYNEXT;
        """,
        "VAR intnum soon; TRAP broken reg1 := 1 / 0; ENDTRAP",
    )
    with pytest.raises(RapidStopped, match=r"test.mod:5: ERR_DIVZERO: a division by zero, in a trap"):
        run()
    with pytest.raises(RapidStopped, match="ERR_UNKINO: there is no interrupt 0; CONNECT it with a trap first"):
        Run(client, "ITimer 1, soon;", "VAR intnum soon;")()


@pytest.mark.parametrize(("acceleration", "jerk"), [(50, 100), (100, 25), (3, 3)], ids=["soft", "smooth", "least"])
def test_acc_set_counts_for_joint_moves_too(
    client: virtualrobot.Client, arm: virtualrobot.Robot, acceleration: float, jerk: float
) -> None:
    """One axis turns by a degree, too little for its speed: by half its jerk-limited law of four pieces, or of six."""
    limits = arm.limits["joint_1"]
    program = loaded(
        "MODULE T\nPROC main()\n"
        f"AccSet {acceleration}, {jerk};\n"
        "MoveAbsJ [[1, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]], v5000, fine, tool0;\n"
        "ENDPROC\nENDMODULE",
        client.signals,
    )
    arm.set_positions({"joint_5": math.radians(30)})
    plan = recorded(client, "arm", program).plan()
    a, j = max(acceleration, 20) / 100 * limits.acceleration, max(jerk, 10) / 100 * limits.jerk
    way = math.radians(1)
    # With the acceleration reached the way is a t1 (t1 + a / j), with t1 the time to the greatest speed less a / j.
    short = 4.0 * (way / (2.0 * j)) ** (1 / 3)
    seconds = short if short <= 4.0 * a / j else a / j + math.sqrt((a / j) ** 2 + 4.0 * way / a)
    assert plan.duration == pytest.approx(seconds, rel=1e-3)


def test_accelerations_and_singular_places_are_done_as_far_as_they_can_be_and_told(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    run = Run(
        client,
        r"""
        ConfJ \Off;
        ConfL \Off;
        SingArea \Off;
        AccSet 100, 100;
        VelSet 50, 5000;
        MoveJ above, v1000, fine, tool0 \WObj:=table;
        FOR i FROM 1 TO 2 DO
          AccSet 20, 100;
          SingArea \Wrist;
        ENDFOR
        MoveL Offs(above, 100, 0, 0), v200, fine, tool0 \WObj:=table;
        TPWrite GetSysInfo(\RobotType) + GetSysInfo(\SerialNo);
        """,
    )
    way = traced(client, run)
    assert run.printed == ["armvirtualrobot"]
    assert [note.partition(": ")[2].partition(" ")[0] for note in run.notes] == ["a"]
    places = in_table(way)
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(way[:, 0])
    on_line = (np.abs(places[:-1, 1:] - [0, 0.15]).max(axis=1) < 1e-6) & (speeds > 1e-9)
    assert speeds[on_line].max() == pytest.approx(0.1, rel=1e-3), "half of v200, by VelSet"
    changes = np.diff(speeds[on_line]) / np.diff(way[:-1, 0][on_line])
    assert 0.5 < np.abs(changes).max() < 1.05, "a fifth of 5 m/s², where that is less than the joints' fifth lets"
