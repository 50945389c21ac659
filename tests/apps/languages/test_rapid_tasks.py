"""Several tasks in RAPID side by side: shared persistents, points at which they meet, static tasks, and their ends."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner, Result
from virtualrobot.errors import WrongStateError
from virtualrobot.streams.watch import StreamWatch
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.cell import Cell
from virtualrobot_apps.languages.rapid.command import rapid
from virtualrobot_apps.languages.rapid.faults import RapidStopped
from virtualrobot_apps.languages.rapid.task import RapidTask, load_tasks

pytestmark = pytest.mark.long

LIST = 'PERS tasks all{2} := [["A"], ["B"]];\nVAR syncident meet;\nVAR syncident more{2};\n'


def ran(static: Iterable[str] = (), **modules: str) -> list[str]:
    """Return what tasks print, each by the text within its module, in the order in which they did."""
    lines: list[str] = []
    texts = {name: [Source(f"MODULE M\n{text}\nENDMODULE\n", f"{name}.mod")] for name, text in modules.items()}
    cell = Cell()
    for name, program in load_tasks(texts).items():
        RapidTask(program, write=lambda line, name=name: lines.append(f"{name} {line}"), name=name, cell=cell)
    cell.run(static=[cell.tasks[name.lower()] for name in static])
    return lines


def test_tasks_meet_and_share_global_persistents_alone() -> None:
    """The rules are those of ABB, *RAPID Instructions, Functions and Data types* (3HAC050917), WaitSyncTask.

    Persistents: *RAPID overview* (3HAC050947): global PERS of one name in several tasks are one datum, and TASK PERS
    is not.
    """
    data = "PERS num turn := {};\nTASK PERS num own := {};\n"
    first = r"""
    PROC main()
      TPWrite "turn " \Num:=turn;
      FOR i FROM 1 TO 3 DO
        WaitSyncTask meet, all;
        turn := turn + 1;
        WaitSyncTask \InPos, more{2}, all \TimeOut:=60;
      ENDFOR
      own := own + 1;
      WaitSyncTask more{1}, all;
    ENDPROC
    """
    second = r"""
    PROC main()
      FOR i FROM 1 TO 3 DO
        WaitSyncTask meet, all;
        WaitSyncTask more{2}, all;
        TPWrite "turn " \Num:=turn;
      ENDFOR
      WaitSyncTask more{1}, all;
      TPWrite GetTaskName() + " own " \Num:=own;
    ENDPROC
    """
    lines = ran(A=data.format(5, 1) + LIST + first, B=data.format(99, 7) + LIST + second)
    assert lines == ["A turn 5", "B turn 6", "B turn 7", "B turn 8", "B B own 7"]


def test_the_first_value_is_that_of_the_first_task_that_gives_one() -> None:
    main = 'PROC main()\nWaitSyncTask meet, all;\nTPWrite ""\\Num:=x;\nENDPROC\n'
    lines = ran(A="PERS num x;\n" + LIST + main, B="PERS num x := 4;\n" + LIST + main)
    assert sorted(lines) == ["A 4", "B 4"]


def test_a_point_that_is_not_reached_in_time_is_an_error_of_the_program() -> None:
    waiting = r"""
    PROC main()
      WaitSyncTask meet, all \TimeOut:=0.05;
    ERROR
      IF ERRNO = ERR_WAITSYNCTASK THEN
        TPWrite "late";
        over := TRUE;
        TRYNEXT;
      ENDIF
    ENDPROC
    """
    other = "PROC main()\nWaitUntil over;\nENDPROC\n"
    assert ran(A="PERS bool over := FALSE;\n" + LIST + waiting, B="PERS bool over := FALSE;\n" + other) == ["A late"]


@pytest.mark.parametrize(
    ("first", "second", "error"),
    [
        ("WaitSyncTask meet, all;", "", "at meet the task B is waited for, and has ended"),
        ("WaitSyncTask meet, all;", "WaitSyncTask meet, alone;", r"the same list, and others have|is not in its own"),
        ("WaitSyncTask meet, alone;", "", "the task A waits for others, and is not in its own list: B"),
        ("WaitSyncTask meet, strange;", "", "there is no task 'T_ROB1'; there are: A, B"),
        ("WaitTime -1;", "WHILE TRUE DO\nENDWHILE", "A.mod:8: "),
    ],
)
def test_tasks_that_can_not_meet_or_fail_stop_all(first: str, second: str, error: str) -> None:
    more = 'TASK PERS tasks alone{1} := [["B"]];\nTASK PERS tasks strange{2} := [["A"], ["T_ROB1"]];\n'
    texts = {
        name: LIST + more + f"PROC main()\n{statement}\nENDPROC" for name, statement in (("A", first), ("B", second))
    }
    with pytest.raises(RapidStopped, match=error):
        ran(**texts)


def test_a_persistent_of_two_tasks_has_one_type_and_a_task_its_name() -> None:
    with pytest.raises(ProgramError) as caught:
        ran(A="PERS num x := 1;\nPROC main()\nENDPROC", B='PERS string x := "";\nPROC main()\nENDPROC')
    said = "B.mod:2:1: 'x' is a num in the task A, and a persistent of both tasks has one type"
    assert [str(one) for one in caught.value.diagnostics] == [said]
    cell = Cell()
    program = load_tasks({"A": [Source("MODULE M\nPROC main()\nENDPROC\nENDMODULE\n", "a.mod")]})["A"]
    RapidTask(program, name="A", cell=cell)
    with pytest.raises(WrongStateError, match="there is a task 'a' already"):
        RapidTask(program, name="a", cell=cell)


def test_a_static_task_makes_rounds_until_the_others_have_ended() -> None:
    watch = r"""
    PERS num count := 0;
    VAR num own := 0;
    PROC main()
      own := own + 1;
      count := own;
      IF own = 2 ExitCycle;
    ENDPROC
    """
    main = 'PERS num count := 0;\nPROC main()\nWaitUntil count >= 4;\nTPWrite "enough";\nENDPROC\n'
    assert ran(["W"], A=main, W=watch) == ["A enough"]


@pytest.fixture
def arms(client: virtualrobot.Client) -> tuple[virtualrobot.Robot, virtualrobot.Robot]:
    """Return two arms that stand beside each other in a world whose time goes five times as fast."""
    client.clock.speed_factor = 5.0
    left = client.load_robot("model://irb120", name="left", pose=virtualrobot.pose(0.0, 0.8, 0.0))
    return left, client.load_robot("model://irb120", name="right", pose=virtualrobot.pose(0.0, -0.8, 0.0))


ARM = """
MODULE Arm
  PERS tasks both{2} := [["T_ROB1"], ["T_ROB_R"]];
  PERS bool ready := FALSE;
  VAR syncident start;
"""


def test_two_arms_and_a_watching_task_run_by_the_command(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    """A persistent that is set after a move to a fine point is seen by others when the robot is there."""
    joints = "[[{}, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
    texts = {
        "left": f"""{ARM}
          PROC main()
            WaitSyncTask start, both;
            MoveAbsJ {joints.format(50)}, v500, fine, tool0;
            ready := TRUE;
          ENDPROC
        ENDMODULE""",
        "right": f"""{ARM}
          PERS bool seen := FALSE;
          PROC main()
            MoveAbsJ {joints.format(20)}, v500, fine, tool0;
            WaitSyncTask \\InPos, start, both;
            WaitUntil ready;
            WaitUntil seen;
            SetDO doDone, 1;
            MoveAbsJ {joints.format(-40)}, v500, fine, tool0;
            TPWrite "there";
          ENDPROC
        ENDMODULE""",
        "watch": r"""
        MODULE Watch
          PERS bool ready := FALSE;
          PERS bool seen := FALSE;
          PROC main()
            IF ready AND NOT seen THEN
              SetDO doSeen, 1;
              WaitTime 0.05;
              IF NOT TaskRunRob() TPWrite "seen";
              seen := TRUE;
            ENDIF
            WaitTime 0.01;
          ENDPROC
        ENDMODULE""",
    }
    files = {name: tmp_path / f"{name}.mod" for name in texts}
    for name, text in texts.items():
        files[name].write_text(text.strip() + "\n")
    left, right = arms
    options = ["run", str(files["left"]), "--robot", "left", "--task", f"T_ROB_R@right={files['right']}"]
    more = ["--static", f"T_WATCH={files['watch']}", "--create-signals", "--address", client.address]
    run = CliRunner().invoke(rapid, [*options, *more], standalone_mode=False)
    assert (run.return_value, run.exception) == (0, None)
    assert run.output.splitlines() == ["T_WATCH: seen", "T_ROB_R: there"]
    assert (client.signals["doSeen"], client.signals["doDone"]) == (True, True)
    np.testing.assert_allclose(np.degrees(left.state.positions), [50, 0, 0, 0, 30, 0], atol=1e-6)
    np.testing.assert_allclose(np.degrees(right.state.positions), [-40, 0, 0, 0, 30, 0], atol=1e-6)


def test_a_persistent_that_another_task_sets_interrupts_a_move(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    """As public servers have it: one task gets goals, and the other one leaves its way for a new goal."""
    data = (
        "PERS jointtarget goal := [[0, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]];\n"
        "PERS bool fresh := FALSE;\nPERS bool done := FALSE;"
    )
    motion = rf"""MODULE Motion
      {data}
      VAR intnum changed;
      PERS num left := 0;
      PROC main()
        IDelete changed;
        CONNECT changed WITH on_change;
        IPers fresh, changed;
        WaitUntil fresh;
        fresh := FALSE;
        SetDO doMoves, 1;
        MoveAbsJ goal, v50, fine, tool0;
        TPWrite "there, after " \Num:=left;
        done := TRUE;
        EXIT;
      UNDO
        TPWrite "a round is over";
      ENDPROC
      TRAP on_change
        IF NOT fresh RETURN;
        left := left + 1;
        IF NOT IsStopMoveAct(\FromMoveTask) StopMove;
        ClearPath;
        StartMove;
        ExitCycle;
      ENDTRAP
    ENDMODULE
    """
    server = rf"""MODULE Server
      {data}
      VAR jointtarget here;
      PROC main()
        here := CJointT();
        TPWrite "at " \Num:=here.robax.rax_1;
        goal.robax.rax_1 := 90;
        fresh := TRUE;
        WaitDO doMoves, 1;
        WaitTime 0.5;
        goal.robax.rax_1 := -10;
        fresh := TRUE;
        WaitUntil done;
        EXIT;
      ENDPROC
    ENDMODULE
    """
    for name, text in (("motion", motion), ("server", server)):
        tmp_path.joinpath(f"{name}.mod").write_text(text)
    words = ["run", str(tmp_path / "motion.mod"), "--robot", "left", "--task", f"T_SERVER={tmp_path}/server.mod"]
    words += ["--continuous", "--create-signals", "--address", client.address]
    run = CliRunner().invoke(rapid, words, standalone_mode=False)
    assert (run.return_value, run.exception) == (0, None), run.output
    over = "T_ROB1: a round is over"
    assert run.output.splitlines() == ["T_SERVER: at 0", over, "T_ROB1: there, after 1", over]
    np.testing.assert_allclose(np.degrees(arms[0].state.positions), [-10, 0, 0, 0, 30, 0], atol=1e-6)


def test_an_error_of_one_arm_stops_the_other_on_its_way(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    left, right = tmp_path / "left.mod", tmp_path / "right.mod"
    far = "[[160, 0, 0, 0, 30, 0], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]"
    left.write_text(f"{ARM}PROC main()\nMoveAbsJ {far}, v10, fine, tool0;\nENDPROC\nENDMODULE\n".strip() + "\n")
    right.write_text("MODULE R\nPROC main()\nWaitTime 0.2;\nRAISE 5;\nENDPROC\nENDMODULE\n")
    tasks = ["--task", f"L@left={left}", "--task", f"R@right={right}", "--address", client.address]
    run = CliRunner().invoke(rapid, ["run", *tasks], standalone_mode=False)
    assert isinstance(run.exception, RapidStopped)
    assert str(run.exception).startswith(f"{right}:4: error 5")
    state = arms[0].state
    assert np.degrees(state.positions[0]) < 100.0
    assert np.abs(state.velocities).max() == 0.0


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ([], "name the program's files, or give each task by --task"),
        (["--task", "A"], r"a task is given as NAME\[@ROBOT\]=FILE"),
        (["--task", "A=a.mod", "--robot", "left"], "--robot is that of the task T_ROB1, which has no files"),
        (["a.mod", "--task", "T_ROB1=a.mod"], "two tasks are called T_ROB1"),
        (["--task", "A@left=a.mod", "--task", "B@left=a.mod"], "two tasks move the robot left"),
        (["a.mod", "--static", "B@left=a.mod"], "the static task B moves no robot: leave @left out"),
    ],
)
def test_tasks_that_are_given_wrongly_are_told(options: list[str], error: str) -> None:
    run = CliRunner().invoke(rapid, ["run", *options], standalone_mode=False)
    with pytest.raises(Exception, match=error):
        raise run.exception or AssertionError("no error")


SYNC = """
MODULE Arm
  PERS tasks both{2} := [["L"], ["R"]];
  VAR syncident on;
  VAR syncident off;
  TASK PERS tooldata grip := [TRUE, [[0, 0, 100], [1, 0, 0, 0]], [1, [0, 0, 50], [1, 0, 0, 0], 0, 0, 0]];
"""
AXES = "[9E9, 9E9, 9E9, 9E9, 9E9, 9E9]"


def together(tmp_path: Path, client: virtualrobot.Client, left: str, right: str) -> Result:
    """Return what becomes of statements of two tasks with an arm each."""
    tasks = []
    for name, arm, statements in (("L", "left", left), ("R", "right", right)):
        file = tmp_path / f"{arm}.mod"
        file.write_text(f"{SYNC}PROC main()\n{statements}\nENDPROC\nENDMODULE\n".strip() + "\n")
        tasks += ["--task", f"{name}@{arm}={file}"]
    options = [*tasks, "--create-signals", "--address", client.address]
    return CliRunner().invoke(rapid, ["run", *options], standalone_mode=False)


def test_synchronized_moves_start_and_end_together(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    """Both arms move in the same ticks, though one has a sixth of the other's way.

    Rules of ABB, *Application manual MultiMove* (3HAC050961): simultaneous moves have one ID, start and end together.
    """
    joints = f"[[{{}}, 0, 0, 0, 30, 0], {AXES}]"
    statements = [
        rf"""
        SyncMoveOn on, both;
        MoveAbsJ {joints.format(way)} \ID:=10, v500, {zone}, tool0;
        {set_signal}
        MoveAbsJ {joints.format(way / 2)} \ID:=20, v1000, fine, tool0;
        IF IsSyncMoveOn() TPWrite "together";
        MoveL RelTool(CRobT(\Tool:=tool0), 0, 0, 40) \ID:=30, v100, fine, tool0;
        SyncMoveOff off;
        IF NOT IsSyncMoveOn() TPWrite "alone";
        """
        for way, zone, set_signal in ((60, "z50", "SetDO doThere, 1;"), (-10, "z20", ""))
    ]
    for arm in arms:
        arm.move_joints({arm.joint_names[4]: np.radians(30)})
    with client.streams.watch("/robots/left/tcp") as left, client.streams.watch("/robots/right/tcp") as right:
        run = together(tmp_path, client, *statements)
        assert (run.return_value, run.exception) == (0, None)
        end = client.clock.simulation_time
        ways = [way_until(end, watch) for watch in (left, right)]
    assert sorted(run.output.splitlines()) == ["L: alone", "L: together", "R: alone", "R: together"]
    assert client.signals["doThere"] is True
    times = sorted(ways[0].keys() & ways[1].keys())
    moving = [
        [float(np.abs(way[after] - way[before]).max()) > 1e-10 for before, after in pairwise(times)] for way in ways
    ]
    assert sum(moving[0]) > 100
    assert moving[0] == moving[1]
    # Two stretches, as the corner is passed without standing; three where the second move came late on a busy machine.
    assert sum(not before and after for before, after in pairwise([False, *moving[0]])) in (2, 3)
    np.testing.assert_allclose(np.degrees(arms[0].state.positions[0]), 30, atol=0.5)


def way_until(end: float, watch: StreamWatch) -> dict[float, np.ndarray]:
    """Return the places (m) of a tool centre point by time (s), until a time."""
    way = {}
    while (sample := watch.next(1.0)) is not None and sample.time < end:
        assert sample.lost == 0
        way[sample.time] = np.array([sample.values[axis] for axis in "xyz"])
    return way


@pytest.mark.parametrize(
    ("left", "right", "error"),
    [
        (
            "SyncMoveOn on, both;\nMoveAbsJ {} \\ID:=1, v500, fine, tool0;",
            "MoveAbsJ {} \\ID:=2, v500, fine, tool0;",
            "not 1|not 2",
        ),
        ("SyncMoveOn on, both;\nMoveAbsJ {}, v500, fine, tool0;", "", r"between SyncMoveOn and SyncMoveOff needs \\ID"),
        (
            "SyncMoveOn on, both;\nMoveAbsJ {} \\ID:=1, v500, fine, tool0;",
            "EXIT;",
            "r has ended, and this move would go",
        ),
        ("SyncMoveOn on, both;\nStorePath;", "", "a path that is put aside can't be used yet while moves go together"),
        ("MoveAbsJ {} \\ID:=1, v500, fine, tool0;", "", r"\\ID is for moves between SyncMoveOn and SyncMoveOff"),
        ("SyncMoveOff off;", "", "SyncMoveOff needs a SyncMoveOn before it"),
    ],
)
def test_moves_that_can_not_go_together_end_both_tasks(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot],
    client: virtualrobot.Client,
    tmp_path: Path,
    left: str,
    right: str,
    error: str,
) -> None:
    place = f"[[10, 0, 0, 0, 30, 0], {AXES}]"
    first = "SyncMoveOn on, both;\n" if left.startswith("SyncMoveOn") else ""
    run = together(tmp_path, client, left.format(place), first + right.format(place))
    assert isinstance(run.exception, RapidStopped)
    assert re.search(error, str(run.exception))


def test_a_move_out_of_reach_is_an_error_of_all_that_go_together(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    statements = [
        rf"""
        SyncMoveOn on, both;
        MoveAbsJ [[{axis}, 0, 0, 0, 30, 0], {AXES}] \ID:=1, v500, fine, tool0;
        MoveAbsJ [[5, 0, 0, 0, 30, 0], {AXES}] \ID:=2, v500, fine, grip;
        SyncMoveOff off;
        ERROR
          IF ERRNO = ERR_ROBLIMIT TPWrite "far";
          TRYNEXT;
        """
        for axis in (10, 400)
    ]
    run = together(tmp_path, client, *statements)
    assert (run.return_value, run.exception) == (0, None)
    assert sorted(run.output.splitlines()) == ["L: far", "R: far"]
    for arm in arms:
        np.testing.assert_allclose(np.degrees(arm.state.positions[0]), 5, atol=1e-6)


def test_a_robot_moves_alone_again_in_an_undo_part(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    """The left one fails on its way; both undo what was together, and go home by themselves."""
    statements = [
        rf"""
        SyncMoveOn on, both;
        MoveAbsJ [[10, 0, 0, 0, 30, 0], {AXES}] \ID:=1, v500, fine, tool0;
        {fails}
        MoveAbsJ [[20, 0, 0, 0, 30, 0], {AXES}] \ID:=2, v500, fine, tool0;
        SyncMoveOff off;
        UNDO
          SyncMoveUndo;
          SyncMoveUndo;
          MoveAbsJ [[{home}, 0, 0, 0, 30, 0], {AXES}], v500, fine, tool0;
          TPWrite "alone " \Bool:=NOT IsSyncMoveOn();
        """
        for fails, home in (("WaitRob \\InPos;\nreg1 := 1 / 0;", 3), ("", 4))
    ]
    run = together(tmp_path, client, *statements)
    assert isinstance(run.exception, RapidStopped) and "ERR_DIVZERO" in str(run.exception)
    assert {"L: alone TRUE", "R: alone TRUE"} <= set(run.output.splitlines())
    for arm, home in zip(arms, (3, 4), strict=True):
        np.testing.assert_allclose(np.degrees(arm.state.positions[0]), home, atol=1e-6)


def test_a_task_sees_where_the_robot_of_another_one_is(
    arms: tuple[virtualrobot.Robot, virtualrobot.Robot], client: virtualrobot.Client, tmp_path: Path
) -> None:
    """Another task is told of a robot what its own task says of it, of a tool and of the last one used."""
    left = rf"""
    MoveAbsJ [[10, 20, -10, 30, 40, 50], {AXES}], v1000, fine, grip;
    TPWrite ValToStr(CJointT());
    TPWrite ValToStr(CPos(\Tool:=tool0));
    TPWrite ValToStr(CPos());
    WaitSyncTask on, both;
    WaitSyncTask off, both;
    """
    right = r"""
    VAR robtarget place;
    WaitSyncTask on, both;
    TPWrite ValToStr(CJointT(\TaskName:="L"));
    place := CRobT(\TaskName:="l" \Tool:=tool0);
    TPWrite ValToStr(place.trans);
    place := CRobT(\TaskName:="L");
    TPWrite ValToStr(place.trans);
    WaitSyncTask off, both;
    """
    run = together(tmp_path, client, left, right)
    assert (run.return_value, run.exception) == (0, None)
    lines = run.output.splitlines()
    assert [line.removeprefix("R: ") for line in lines[3:]] == [line.removeprefix("L: ") for line in lines[:3]]
    assert lines[0].startswith("L: [[10,20,-10,30,40,50]")
    run = together(tmp_path, client, r'TPWrite ValToStr(CJointT(\TaskName:="T_ROB1"));', "")
    assert isinstance(run.exception, RapidStopped)
    assert "there is no task 'T_ROB1'; there are: L, R" in str(run.exception)
