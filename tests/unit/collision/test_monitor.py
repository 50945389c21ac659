"""The monitor in a stepped world: what it tells in which tick, whom it stops, and what it tolerates."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from threading import Event, Thread
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.collision.monitor import Monitor
from virtualrobot_kernel.collision.report import Ended, Failed, Stopped, Touch
from virtualrobot_kernel.collision.report import Event as Told
from virtualrobot_kernel.collision.scene import Collision, CollisionScene, Detail
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    AttachNode,
    ClearWorld,
    Command,
    CreateNodes,
    RemoveNode,
    SetAllowedPairs,
    SetJointPositions,
    StopRobots,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Box
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind

from tests.unit.collision.carts import ACCELERATION, WAIT, block, cart, drive, first_tick, mode, place, replayed
from tests.unit.collision.sweepers import body
from tests.unit.collision.worlds import SHAPES
from tests.unit.journals import entries_of
from tests.unit.world.builders import shifted

Happened = list[tuple[int, str]]


class Cell:
    """A world with a monitor."""

    def __init__(self, mode: Mode = Mode.STEPPED) -> None:
        """Begin empty."""
        self.world = World(world_poses, MemoryJournal(), Clock(mode, 1.0, 4_000_000))
        self.monitor = Monitor(self.world, SHAPES)
        self.world.start()

    def do(self, *commands: Command) -> Snapshot:
        """Give commands as one batch."""
        return self.world.submit(commands).result(WAIT).snapshot

    def step(self, ticks: int = 1) -> Snapshot:
        """Let time go on."""
        return self.world.step(ticks).result(WAIT)

    @property
    def told(self) -> Happened:
        """All that was told, as (tick, words)."""
        return [(event.tick, words(event)) for event in self.monitor.latest.events]

    @property
    def now(self) -> set[tuple[str, str]]:
        """What touches now."""
        return {one.names for one in self.monitor.latest.touching}

    def close(self) -> None:
        """End."""
        self.monitor.close()
        self.world.close()


def words(event: Told) -> str:
    """Return an event in words."""
    what = event.what
    if isinstance(what, Touch):
        return f"{'/'.join(what.names)} {'tolerated' if what.tolerated else 'begun'}"
    if isinstance(what, Ended):
        return f"{'/'.join(what.touch.names)} {'apart' if what.apart else 'unwatched'}"
    if isinstance(what, Stopped):
        return f"stopped {' '.join(what.robots)}: {what.reason}"
    assert isinstance(what, Failed)
    return what.fault or "well again"


@pytest.fixture
def cell() -> Iterator[Cell]:
    made = Cell()
    yield made
    made.close()


def test_a_touch_is_told_in_its_tick_and_stops_in_it(cell: Cell, rng: np.random.Generator) -> None:
    """A ball of 0.1 m that drives towards a box touches where its centre is 0.2 m from the box's."""
    wall = float(rng.uniform(0.6, 1.2))
    cell.do(cart("cart"), block("box", wall), mode("stop"))
    tick = first_tick(cell.world, lambda now: place(now) >= wall - 0.2, drive(0.0, 1.5))
    cell.do(drive(0.0, 1.5))
    cell.step(1000)
    assert cell.told == [(tick, "cart.ball/box begun"), (tick, "stopped cart: 'cart.ball' touches 'box'")]
    ended = cell.world.snapshot.state.ended[-1]
    assert ended.cancellation == Cancellation(EndCause.COLLISION, "'cart.ball' touches 'box'")
    assert entries_of(cell.world)[-1].tick == tick
    assert entries_of(cell.world)[-1].author == "collision monitor"
    # Braking from at most 1 m/s takes v^2 / 2a = 0.125 m, and v a / 2j more until the jerk has let it begin.
    assert place(cell.world.snapshot) < wall - 0.2 + 0.125 + 1.0 * ACCELERATION / 80.0 + 0.01
    touch = cell.monitor.latest.touching[0]
    assert touch.tick == tick
    assert touch.pair.depth is not None
    assert touch.pair.contacts[0].points.shape[1] == 3


def test_a_replay_needs_no_monitor(cell: Cell) -> None:
    cell.do(cart("cart"), block("box", 1.0), mode("stop"))
    cell.do(drive(0.0, 1.5))
    cell.step(500)
    assert replayed(cell.world).q.tobytes() == cell.world.snapshot.state.q.tobytes()


def test_one_step_of_many_ticks_is_as_many_steps() -> None:
    ends = []
    for ticks in (1, 7, 700):
        cell = Cell()
        try:
            cell.do(cart("cart"), block("box", 0.9), mode("stop"))
            cell.do(drive(0.0, 1.5))
            for _ in range(700 // ticks):
                cell.step(ticks)
            ends.append((cell.told, cell.world.snapshot.state.q.tobytes()))
        finally:
            cell.close()
    assert ends[0] == ends[1] == ends[2]


def test_monitor_tells_and_stops_nothing_and_off_tells_nothing(cell: Cell) -> None:
    cell.do(cart("cart"), block("box", 0.6), mode("monitor"))
    cell.do(drive(0.0, 1.2))
    cell.step(1000)
    assert [what for _, what in cell.told] == ["cart.ball/box begun", "cart.ball/box apart"]
    assert place(cell.world.snapshot) == pytest.approx(1.2)
    checks = cell.monitor.latest.checks
    cell.do(mode("off"))
    cell.do(drive(1.2, 0.0))
    cell.step(1000)
    assert len(cell.told) == 2
    assert cell.monitor.latest.checks == checks + 1, "switching off is looked at once"


def test_a_world_at_rest_is_not_checked(cell: Cell) -> None:
    cell.do(cart("cart"), block("box", 0.6), mode("stop"))
    checks = cell.monitor.latest.checks
    cell.step(100)
    assert cell.monitor.latest.checks == checks == 1


def test_what_touches_when_it_begins_is_tolerated_until_it_is_apart(cell: Cell) -> None:
    cell.do(cart("cart"), block("box", 0.15))
    assert cell.told == []
    cell.do(mode("stop"))
    assert [what for _, what in cell.told] == ["cart.ball/box tolerated"]
    cell.do(drive(0.0, -0.5))
    cell.step(500)
    cell.do(drive(-0.5, 1.0))
    cell.step(500)
    assert [what for _, what in cell.told][1:] == [
        "cart.ball/box apart",
        "cart.ball/box begun",
        "stopped cart: 'cart.ball' touches 'box'",
    ]
    assert place(cell.world.snapshot) < 0.5


@pytest.mark.parametrize("modes", [{"left": "stop"}, {"right": "stop"}, {"left": "monitor", "right": "guard"}])
def test_whoever_runs_into_a_robot_that_is_to_stop_stops_too(cell: Cell, modes: dict[str, str]) -> None:
    cell.do(cart("left"), cart("right"), UpdateNode("right", parent_t_node=shifted(x=1.0)), mode(**modes))
    cell.do(drive(0.0, 0.8, "left"), drive(0.0, -0.8, "right"))
    cell.step(1000)
    (_, begun), (_, first), *rest = cell.told
    assert begun == "left.ball/right.ball begun"
    assert first.startswith("stopped left")
    robots = [what.split(":")[0] for _, what in cell.told[1:] if what.startswith("stopped")]
    assert " ".join(robots) == "stopped left right"
    assert not cell.world.snapshot.state.motions
    assert not [what for _, what in rest if "apart" in what]


def test_robots_without_a_mode_run_into_each_other_unseen(cell: Cell) -> None:
    cell.do(cart("left"), cart("right"), UpdateNode("right", parent_t_node=shifted(x=1.0)))
    cell.do(cart("third", y=5.0), mode(third="stop"))
    cell.do(drive(0.0, 0.8, "left"), drive(0.0, -0.8, "right"))
    cell.step(1000)
    assert cell.told == []
    cell.do(mode("monitor", third="off"))
    assert not cell.told


def test_what_carries_a_robot_is_stopped_for_it(cell: Cell) -> None:
    """A robot that stands on another one's ball is run into a box by the one below."""
    cell.do(cart("below"), cart("above", y=1.0, parent="below.ball"), block("box", 0.6, y=1.0), mode(above="stop"))
    cell.do(drive(0.0, 1.2, "below"))
    cell.step(1000)
    assert cell.told[1][1] == "stopped below: 'above.ball' touches 'box'"


def test_what_is_new_is_tolerated_and_what_is_gone_ends(cell: Cell) -> None:
    cell.do(cart("cart"), mode("stop"))
    cell.do(block("box", 0.1))
    cell.do(SetAllowedPairs(allow=(("box", "cart.ball", "why not"),)))
    cell.do(SetAllowedPairs(forbid=(("box", "cart.ball"),)))
    cell.do(UpdateNode("box", new_name="crate"))
    cell.do(RemoveNode("crate"))
    cell.do(block("box", 0.1))
    cell.do(mode("off"))
    cell.do(mode("stop"))
    cell.do(ClearWorld())
    touch = "cart.ball/box"
    assert [what for _, what in cell.told] == [f"{touch} tolerated", f"{touch} unwatched"] * 4
    assert cell.now == set()


def test_what_is_put_into_the_way_stops_at_once(cell: Cell) -> None:
    """A box that was there before is put onto a robot that moves, between two steps."""
    cell.do(cart("cart"), block("box", 0.0, y=1.0), mode("stop"))
    cell.do(drive(0.0, 1.0))
    at = place(cell.step(100))
    cell.do(UpdateNode("box", parent_t_node=shifted(x=at)))
    assert cell.told == [(100, "cart.ball/box begun"), (100, "stopped cart: 'cart.ball' touches 'box'")]


def test_a_part_counts_from_when_it_is_held(cell: Cell) -> None:
    """A part on a table is nobody's; held, it touches the table until it is lifted, and then may not again."""
    cell.do(cart("cart"), block("table", 0.0, y=1.0), block("part", 0.1, y=1.0, kind=Kind.PART), mode("stop"))
    cell.do(AttachNode("part", "cart.ball"))
    cell.do(drive(0.0, 0.5))
    cell.step(500)
    cell.do(drive(0.5, -1.0))
    cell.step(1000)
    assert [what for _, what in cell.told][:4] == [
        "table/part tolerated",
        "table/part apart",
        "table/part begun",
        "stopped cart: 'table' touches 'part'",
    ]


def test_stops_by_others_are_told_too(cell: Cell) -> None:
    """The guard, or whoever else stops robots for collisions, is told of in the tick in which it does."""
    cell.do(cart("cart"), cart("other", y=1.0), mode("monitor"))
    cell.do(drive(0.0, 1.5), drive(0.0, 1.5, "other"))
    cell.step(100)
    node = cell.world.snapshot.structure.node
    cell.do(StopRobots((node("cart").uid,), Cancellation(EndCause.COLLISION, "it would touch")))
    cell.do(StopRobots((node("other").uid,), Cancellation(EndCause.STOP, "enough")))
    cell.step(500)
    assert cell.told == [(100, "stopped cart: it would touch")]


def test_jumps_are_seen(cell: Cell) -> None:
    cell.do(cart("cart"), block("box", 0.5), mode("stop"))
    cell.do(SetJointPositions("cart", {"x": 0.5}))
    cell.do(SetJointPositions("cart", {"x": 0.0}))
    assert [what for _, what in cell.told] == ["cart.ball/box begun", "cart.ball/box apart"]


def test_a_check_that_fails_is_told_and_stops(
    cell: Cell, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    cell.do(cart("cart"), cart("other", y=3.0), block("box", 0.9), mode("stop", other="monitor"))
    cell.do(drive(0.0, 1.5), drive(0.0, 1.0, "other"))
    cell.step(50)
    with monkeypatch.context() as broken, caplog.at_level(logging.ERROR):
        broken.setattr(CollisionScene, "place", lambda *_: 1 / 0)
        cell.step(200)
        assert cell.monitor.latest.fault == "collisions cannot be checked: ZeroDivisionError: division by zero"
        assert [motion.robots for motion in cell.world.snapshot.state.motions if not motion.cancellation] == [
            (cell.world.snapshot.structure.node("other").uid,)
        ]
    assert len(caplog.records) == 1, "a fault that stays is told once"
    at = place(cell.world.snapshot)
    cell.do(drive(at, 1.5))
    cell.step(1000)
    fault = "collisions cannot be checked: ZeroDivisionError: division by zero"
    assert [what for _, what in cell.told] == [
        fault,
        f"stopped cart: {fault}",
        "well again",
        "cart.ball/box begun",
        "stopped cart: 'cart.ball' touches 'box'",
    ]


def test_a_listener_that_fails_harms_nobody(cell: Cell, caplog: pytest.LogCaptureFixture) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError

    heard: list[int] = []
    cell.monitor.subscribe(fail)
    end = cell.monitor.subscribe(lambda report: heard.append(report.event_count))
    cell.do(cart("cart"), block("box", 0.1))
    with caplog.at_level(logging.ERROR):
        cell.do(mode("stop"))
        end()
        cell.do(mode("off"))
    assert heard == [1]
    assert cell.monitor.latest.event_count == 2


def test_it_ends_while_the_world_waits_for_it(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel that ends in the middle of a step: the check in hand is the last one, and the world goes on."""
    cell.do(cart("cart"), block("box", 0.9), mode("stop"))
    cell.do(drive(0.0, 0.5))
    begun, go_on = Event(), Event()
    place = CollisionScene.place

    def held(scene: CollisionScene, snapshot: Snapshot) -> None:
        begun.set()
        go_on.wait(WAIT)
        place(scene, snapshot)

    monkeypatch.setattr(CollisionScene, "place", held)
    step = cell.world.step(500)
    assert begun.wait(WAIT)
    ending = Thread(target=cell.monitor.close)
    ending.start()
    go_on.set()
    ending.join(WAIT)
    assert not ending.is_alive()
    assert step.result(WAIT).state.tick == 500
    assert cell.monitor.latest.checks < 500


def test_in_real_time_the_world_waits_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """While one check takes its time, a robot goes all its way; then the newest state is checked."""
    cell = Cell(Mode.REALTIME)
    try:
        cell.do(cart("cart"), block("box", 1.5), mode("stop"))
        begun, go_on, told = Event(), Event(), Event()
        place = CollisionScene.place

        def held(scene: CollisionScene, snapshot: Snapshot) -> None:
            begun.set()
            go_on.wait(WAIT)
            place(scene, snapshot)

        monkeypatch.setattr(CollisionScene, "place", held)
        cell.do(drive(0.0, 1.5))
        assert begun.wait(WAIT)
        while cell.world.snapshot.state.motions:
            told.wait(0.01)
        now = cell.world.snapshot
        assert now.state.ended[-1].cancellation is None
        cell.monitor.subscribe(lambda _: told.set())
        go_on.set()
        assert told.wait(WAIT)
        assert cell.now == {("cart.ball", "box")}
        assert cell.monitor.latest.touching[0].tick >= now.state.ended[-1].end_tick - 1
    finally:
        cell.close()


def test_robots_stop_before_contacts_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where things touch takes longer to find than that they do; a stop waits for the latter only."""
    cell = Cell(Mode.REALTIME)
    try:
        # So long that it is touched until the end of the way: a check may be late.
        box = body("box", Box((3.0, 0.2, 0.2)), shifted(x=2.0))
        cell.do(cart("cart"), CreateNodes((box,)), mode("stop"))
        go_on, told = Event(), Event()
        collisions = CollisionScene.collisions

        def held(scene: CollisionScene, detail: Detail, *asked: Any) -> list[Collision]:  # noqa: ANN401
            if detail is Detail.CONTACTS:
                assert go_on.wait(WAIT)
            return collisions(scene, detail, *asked)

        monkeypatch.setattr(CollisionScene, "collisions", held)
        cell.do(drive(0.0, 1.8))
        while cell.world.snapshot.state.motions:
            told.wait(0.01)
        assert cell.world.snapshot.state.ended[-1].cancellation is not None
        assert not cell.told
        cell.monitor.subscribe(lambda _: told.set())
        go_on.set()
        assert told.wait(WAIT)
        assert [what for _, what in cell.told][:2] == [
            "cart.ball/box begun",
            "stopped cart: 'cart.ball' touches 'box'",
        ]
        assert cell.told[0][0] <= cell.told[1][0] <= cell.world.snapshot.state.tick
    finally:
        cell.close()
