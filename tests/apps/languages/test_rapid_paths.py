"""Paths of programs in RAPID that are stopped, put aside, searched along and acted upon; displaced frames."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import virtualrobot
from virtualrobot_apps.languages.rapid.arcs import Arc
from virtualrobot_apps.languages.rapid.faults import RapidStopped

from tests.apps.languages.test_rapid_motion import Run, arm, in_table, numbers
from tests.apps.languages.tracing import traced

__all__ = ["arm"]

pytestmark = pytest.mark.long

HOME = r"MoveJ above, v1000, fine, tool0 \WObj:=table;"


def test_an_arc_passes_its_points_and_its_share_is_that_of_its_angle() -> None:
    """Three quarters of a circle of radius 2 about (1, 0, 0), by hand."""
    way = Arc(np.array([3.0, 0, 0]), np.array([1.0, 2, 0]), np.array([1.0, -2, 0]))
    assert way.length == pytest.approx(2.0 * 1.5 * np.pi)
    assert way.center == pytest.approx([1, 0, 0])
    assert way.point(2 / 3) == pytest.approx([-1, 0, 0])
    assert way.share(np.array([1.0, 2, 0])) == pytest.approx(1 / 3)
    assert (way.share(np.array([2.99, -0.01, 0])), way.share(np.array([1.1, -2, 0]))) == (0.0, 1.0)
    with pytest.raises(ValueError, match="on one line"):
        Arc(np.zeros(3), np.ones(3), 2 * np.ones(3))


def test_a_stopped_path_is_put_aside_by_a_trap_and_taken_up_again(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """The trap is that of the manual (3HAC050917, StorePath): stop, store, away, back, restore, start."""
    client.signals.create("button")
    client.signals.create("moving")
    run = Run(
        client,
        rf"""
        {HOME}
        CONNECT pressed WITH away;
        ISignalDI button, 1, pressed;
        SetDO moving, 1;
        MoveC Offs(above, 50, 50, 0), Offs(above, 100, 0, 0), v20, fine, tool0 \WObj:=table;
        TPWrite "there " + ValToStr(CPos(\WObj:=table));
        """,
        r"""
        VAR intnum pressed;
        TRAP away
          VAR robtarget back;
          StopMove;
          TPWrite "stopped " \Bool:=IsStopMoveAct();
          StorePath;
          back := CRobT(\Tool:=tool0 \WObj:=table);
          MoveL Offs(back, 0, 0, 40), v500, fine, tool0 \WObj:=table;
          MoveL back, v500, fine, tool0 \WObj:=table;
          RestoPath;
          TPWrite "at " + ValToStr(back.trans);
          StartMove;
        ENDTRAP
        """,
    )

    def press() -> None:
        client.signals.wait_for("moving", timeout=60)
        start = arm.tcp[:3, 3]
        while np.linalg.norm(arm.tcp[:3, 3] - start) < 0.03:
            threading.Event().wait(0.002)
        client.signals["button"] = True

    thread = threading.Thread(target=press)
    thread.start()
    way = in_table(traced(client, run))
    thread.join(60)
    stopped, at, there = run.printed
    assert stopped == "stopped TRUE"
    assert numbers(there.removeprefix("there ")) == pytest.approx([100, 0, 150], abs=0.01)
    assert np.linalg.norm(np.array(numbers(at.removeprefix("at "))[:2]) - [50, 0]) == pytest.approx(50, abs=0.05)
    level = way[np.abs(way[:, 2] - 0.15) < 1e-5]
    on_arc = level[level[:, 1] > 1e-3]
    assert np.linalg.norm(on_arc[:, :2] - [0.05, 0.0], axis=1) == pytest.approx(0.05, abs=2e-4)
    first = int(np.argmax((np.abs(way[:, 2] - 0.15) < 1e-5) & (way[:, 1] > 1e-3)))
    assert way[first:, 2].max() == pytest.approx(0.19, abs=1e-3)


def test_a_path_that_was_not_stopped_is_put_aside_at_the_end_of_its_move(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    client.signals.create("moving")
    run = Run(
        client,
        rf"""
        {HOME}
        CONNECT soon WITH away;
        ITimer \Single, 0.2, soon;
        MoveL Offs(above, 100, 0, 0), v100, z10, tool0 \WObj:=table;
        MoveL Offs(above, 100, 60, 0), v500, fine, tool0 \WObj:=table;
        TPWrite ValToStr(CPos(\WObj:=table));
        RestoPath;
        """,
        r"""
        VAR intnum soon;
        TRAP away
          StorePath;
          TPWrite ValToStr(CPos(\Tool:=tool0 \WObj:=table));
          RestoPath;
        ENDTRAP
        """,
    )
    with pytest.raises(RapidStopped, match="RestoPath needs a StorePath before it"):
        run()
    aside, there = (numbers(one) for one in run.printed)
    assert aside == pytest.approx([100, 0, 150], abs=0.01)
    assert there == pytest.approx([100, 60, 150], abs=0.01)


def test_with_conc_the_program_goes_on_while_the_robot_moves_and_a_path_is_cleared(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    client.signals.create("out")
    run = Run(
        client,
        rf"""
        {HOME}
        WaitRob \InPos;
        MoveL \Conc, Offs(above, 100, 0, 0), v50, fine, tool0 \WObj:=table;
        WaitTime 0.2;
        SetDO out, 1;
        WaitDO out, 1;
        TPWrite ValToStr(CPos(\WObj:=table));
        StopMove;
        ClearPath;
        StartMove;
        WaitRob \InPos;
        TPWrite ValToStr(CPos(\WObj:=table));
        ClearPath;
        """,
    )
    with pytest.raises(RapidStopped, match="ClearPath needs a StopMove before it"):
        run()
    first, second = (numbers(one) for one in run.printed)
    assert 0.0 < first[0] <= second[0] < 100.0


def test_a_search_along_an_arc_stays_on_its_circle(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    """By hand: the half circle of radius 50 mm about (50, 0), before what is found, while it brakes, and after it."""
    client.signals.create("touch")
    Run(client, HOME)()
    run = Run(
        client,
        r"""
        VAR robtarget found;
        CONNECT soon WITH touches;
        ITimer \Single, 1, soon;
        SearchC touch, found, Offs(above, 50, 50, 0), Offs(above, 100, 0, 0), v50, tool0 \WObj:=table;
        TPWrite ValToStr(found.trans);
        TPWrite ValToStr(CPos(\WObj:=table));
        SearchC \Stop, touch, found, Offs(above, 50, 50, 0), above, v50, tool0 \WObj:=table;
        ERROR
          TPWrite "" \Bool:=ERRNO = ERR_SIGSUPSEARCH;
          TRYNEXT;
        """,
        "VAR intnum soon; TRAP touches SetDO touch, 1; ENDTRAP",
    )
    way = in_table(traced(client, run))
    found, stands, error = run.printed
    x, y, z = numbers(found)
    assert (np.hypot(x - 50, y), z) == pytest.approx((50, 150), abs=0.01)
    assert 1.0 < x < 99.0
    assert y > 0
    assert numbers(stands) == pytest.approx([100, 0, 150], abs=0.01)
    assert error == "TRUE"
    np.testing.assert_allclose(np.hypot(way[:, 0] - 0.05, way[:, 1]), 0.05, atol=1e-5)


def test_a_search_finds_the_place_of_a_signal(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.signals.create("touch")
    run = Run(
        client,
        rf"""
        VAR robtarget found;
        {HOME}
        CONNECT soon WITH touches;
        ITimer \Single, 1, soon;
        SearchL \Stop, touch, found, Offs(above, 100, 0, 0), v50, tool0 \WObj:=table;
        TPWrite ValToStr(found.trans);
        TPWrite ValToStr(CPos(\WObj:=table));
        SearchL touch, found, Offs(above, 100, 0, 0), v50, tool0 \WObj:=table;
        ERROR
          TPWrite "" \Bool:=ERRNO = ERR_SIGSUPSEARCH;
          SetDO touch, 0;
          MoveL Offs(above, 0, 0, 0), v500, fine, tool0 \WObj:=table;
          IF ERRNO = ERR_WHLSEARCH TRYNEXT;
          RETRY;
        """,
        "VAR intnum soon; TRAP touches SetDO touch, 1; ENDTRAP",
    )
    found, stands, *errors = run()
    assert errors == ["TRUE", "FALSE"]
    assert numbers(found)[1:] == pytest.approx([0, 150], abs=0.01)
    assert 0.0 < numbers(found)[0] < numbers(stands)[0] < 100.0


def test_triggers_act_at_their_places_while_the_tool_keeps_its_speed(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """The tool's place at the tick in which a signal changes, along the way: it passes 0.1 m/s * 4 ms within a tick.

    Then one just before the end of an arc of radius 50 mm, by hand: its last millimetre is 1 / 400 mm off its chord, no
    arc for the kernel.
    """
    kinds = {"TriggC": "TriggC Offs(above, 50, 50, 0),", "TriggJ": "TriggJ", "TriggL": "TriggL"}
    for name in ("first", "last", "soon", "out", "never", "later"):
        client.signals.create(name)
    ends = r"fine, tool0 \WObj:=table"
    moves = [
        rf"""
        {HOME}
        Reset first; Reset last; Reset soon;
        {move} Offs(above, 100, 0, 0), v100, begins \T2:=ends \T3:=calls \T4:=nearly \T5:=again \T6:=left_out \T7:=done
          \T8:=uncalled, {ends};
        WaitRob \InPos;
        WaitUntil count >= {called};
        TPWrite "" \Num:=count;
        """
        for called, move in zip((2, 4, 6), kinds.values(), strict=True)
    ]
    run = Run(
        client,
        rf"""
        TriggIO begins, 30 \Start \DOp:=first, 1;
        TriggEquip ends, 30, 0.1 \DOp:=last, 1;
        CONNECT passed WITH passes;
        TriggInt calls, 50, passed;
        TriggIO nearly, 0.2 \Time \DOp:=soon, 1;
        TriggIO left_out, 40 \DOp:=never, 1 \Inhib:=off;
        TriggIO done, 20 \DOp:=later, 1 \Inhib:=on;
        TriggInt uncalled, 60, passed \Inhib:=off;
        TriggInt again, 0.3 \Time, passed;
        {"".join(moves)}
        {HOME}
        TriggIO ends, 1 \DOp:=out, 1;
        {kinds["TriggC"]} Offs(above, 100, 0, 0), v100, ends, {ends};
        TPWrite ValToStr(CPos(\WObj:=table));
        TPWrite "" \Num:=out;
        """,
        """
        VAR intnum passed; VAR num count := 0; PERS bool off := TRUE; PERS bool on := FALSE;
        VAR triggdata left_out; VAR triggdata done; VAR triggdata uncalled;
        VAR triggdata begins; VAR triggdata ends; VAR triggdata calls; VAR triggdata nearly; VAR triggdata again;
        TRAP passes Incr count; ENDTRAP
        """,
    )
    changes: dict[str, list[float]] = {name: [] for name in ("first", "last", "soon", "out", "never", "later")}
    with client.signals.follow() as watch:
        told = iter(watch)
        next(told)
        way = traced(client, run)
        while not changes["out"]:
            change = next(told)
            for name, value in change.values.items():
                if value:
                    changes[name].append(change.stamp.simulation_time)
    *counted, place, out = run.printed
    assert changes["never"] == []
    assert len(changes["later"]) == 1
    assert (counted, out, run.world.queue.notes) == (["2", "4", "6"], "1", [])
    assert numbers(place) == pytest.approx([100, 0, 150], abs=0.01)
    places, before = in_table(way), 0
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    for kind, first, last, soon in zip(kinds, changes["first"], changes["last"], changes["soon"], strict=True):
        middle = int(np.searchsorted(way[:, 0], first))
        begin = middle - int(np.argmin(np.linalg.norm(places[middle:before:-1] - [0.0, 0.0, 0.15], axis=1)))
        stands = int(np.argmax((steps < 1e-12) & (way[:-1, 0] > soon)))
        before, times = stands, way[begin : stands + 1, 0]
        gone = np.cumsum([0.0, *steps[begin:stands]])
        assert np.interp(first, times, gone) == pytest.approx(0.03, abs=2e-3)
        # The lag of 0.1 s lies where the tool keeps its speed.
        assert np.interp(last, times, gone) == pytest.approx(gone[-1] - 0.03 - 0.1 * 0.1, abs=3e-3)
        assert times[-1] - soon == pytest.approx(0.2, abs=0.008)
        if kind != "TriggJ":
            speeds = np.diff(gone) / np.diff(times)
            inner = speeds[(gone[1:] > 0.02) & (gone[1:] < gone[-1] - 0.02)]
            assert inner.min() > 0.098, "no trigger slows the tool"


def test_moves_that_set_outputs(client: virtualrobot.Client, arm: virtualrobot.Robot) -> None:
    client.signals.create("out")
    run = Run(
        client,
        r"""
        MoveJDO above, v1000, fine, tool0 \WObj:=table, out, 1;
        TPWrite "" \Num:=out;
        MoveLDO Offs(above, 50, 0, 0), v500, fine, tool0 \WObj:=table, out, 0;
        TPWrite "" \Num:=out;
        MoveCDO Offs(above, 25, 25, 0), above, v500, fine, tool0 \WObj:=table, out, 1;
        TPWrite "" \Num:=out;
        """,
    )
    assert run() == ["1", "0", "1"]


def test_displacements_and_frames_are_those_of_their_places(
    client: virtualrobot.Client, arm: virtualrobot.Robot
) -> None:
    """By hand: displaced by 40 mm in y, a place is told unchanged, and 40 mm on without displacement."""
    run = Run(
        client,
        rf"""
        {HOME}
        PDispSet [[0, 40, 0], [1, 0, 0, 0]];
        MoveL above, v500, fine, tool0 \WObj:=table;
        TPWrite ValToStr(CPos(\WObj:=table));
        TPWrite ValToStr(ORobT(above));
        PDispOff;
        TPWrite ValToStr(CPos(\WObj:=table));
        PDispOn \Rot, Offs(above, 10, 0, 0), tool0 \WObj:=table;
        TPWrite ValToStr(CPos(\WObj:=table));
        PDispOff;
        EOffsOff;
        GripLoad load0;
        MotionSup \Off;
        TPWrite ValToStr(DefFrame(above, Offs(above, 0, 10, 0), Offs(above, -10, 5, 0)));
        TPWrite "" \Bool:=CWObj() = table AND CTool() = tool0;
        """,
    )
    displaced, there, plain, on, frame, same = run()
    assert numbers(displaced) == pytest.approx([0, 0, 150], abs=1e-2)
    assert numbers(there)[:3] == pytest.approx([0, 40, 150])
    assert numbers(plain) == pytest.approx([0, 40, 150], abs=1e-2)
    assert numbers(on) == pytest.approx([10, 0, 150], abs=1e-2)
    assert numbers(frame) == pytest.approx([0, 0, 150, 0.707107, 0, 0, 0.707107], abs=1e-5)
    assert same == "TRUE"
