"""Looking ahead in a stepped world: who stops when and for what, and who doesn't; by formulas, and by the ticks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from virtualrobot_kernel.api.motion_plans import contact_of
from virtualrobot_kernel.collision import ahead
from virtualrobot_kernel.collision.ahead import LookAhead, foreseen
from virtualrobot_kernel.collision.joint_path import JointPath
from virtualrobot_kernel.collision.monitor import Monitor
from virtualrobot_kernel.collision.report import Stopped, Touch
from virtualrobot_kernel.collision.scene import CollisionScene, Detail
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.moves import Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep, SetSignalStep, WaitSignalStep
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    CreateNodes,
    CreateSignal,
    PauseMotion,
    ResumeMotion,
    SetCollisionSettings,
    SetJointPositions,
    SetSignal,
    SetSpeedFactor,
    StartMotion,
)
from virtualrobot_kernel.world.figures import Box
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Cancellation, EndCause, Signal, Snapshot
from virtualrobot_kernel.world.store import World

from tests.unit.collision.carts import WAIT, replayed
from tests.unit.collision.sweepers import BALL, body, slider, sweeper, turning
from tests.unit.collision.worlds import SHAPES, scene_of
from tests.unit.planning.cell import chain
from tests.unit.world.builders import shifted

TICK = 0.004
AHEAD = 1.0
"""More than the carts need to stop: 0.35 s."""

Step = MoveStep | DwellStep | SetSignalStep | WaitSignalStep


class Cell:
    """A stepped world with a monitor that looks ahead."""

    def __init__(self, monitored: bool = True) -> None:
        """Begin with nothing but the settings."""
        self.world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
        self.monitor = Monitor(self.world, SHAPES)
        if not monitored:
            self.monitor.close()
        self.world.start()
        self.set(look_ahead=AHEAD, mode=CollisionMode.STOP)

    def do(self, *commands: Command) -> Snapshot:
        """Give commands as one batch."""
        return self.world.submit(commands).result(WAIT).snapshot

    def set(self, look_ahead: float | None = None, mode: CollisionMode | None = None, **robots: CollisionMode) -> None:
        """Change what is done about collisions."""
        self.do(SetCollisionSettings(mode, tuple(robots.items()), look_ahead))

    def start(self, *moves: Move, steps: tuple[Step, ...] = ()) -> str:
        """Plan moves or a program, start it and return its id."""
        command = plan_motion(self.world.snapshot, MotionSpec(moves, steps), chain).command
        return self.do(command).state.motions[-1].id

    def command(self, *moves: Move) -> StartMotion:
        """Return what starts moves."""
        return plan_motion(self.world.snapshot, MotionSpec(moves), chain).command

    def step(self, ticks: int = 1) -> Snapshot:
        """Let time go on; fail when a check does."""
        for _ in range(ticks):
            self.world.step(1).result(WAIT)
            assert not self.monitor.latest.fault
        return self.world.snapshot

    def until_stopped(self, id: str, ticks: int = 5000) -> int:
        """Let time go on until a motion is being stopped; return the tick of it."""
        for _ in range(ticks):
            motion = next((one for one in self.step().state.motions if one.id == id), None)
            if motion is None or motion.cancellation is not None:
                assert motion is not None, f"{id} was not stopped"
                return self.world.snapshot.state.tick
        raise AssertionError(f"{id} goes on")

    def ended(self, ticks: int = 5000) -> Snapshot:
        """Let time go on until nothing moves."""
        for _ in range(ticks):
            if not self.world.snapshot.state.motions:
                return self.world.snapshot
            self.step()
        raise AssertionError("something moves for ever")

    def cancellation(self, id: str) -> Cancellation | None:
        """Return why a motion that has ended was cancelled."""
        return next(one for one in self.world.snapshot.state.ended if one.id == id).cancellation

    @property
    def touched(self) -> bool:
        """Whether anything has ever touched."""
        return any(isinstance(event.what, Touch) for event in self.monitor.latest.events)

    @property
    def stopped(self) -> list[str]:
        """Why anything was stopped."""
        return [event.what.reason for event in self.monitor.latest.events if isinstance(event.what, Stopped)]

    def close(self) -> None:
        """End."""
        self.monitor.close()
        self.world.close()


@pytest.fixture
def cell() -> Iterator[Cell]:
    """Return a cell."""
    made = Cell()
    yield made
    made.close()


def slide(way: float, robot: str = "slider") -> PointToPoint:
    return PointToPoint(robot, {"slide": way})


def wall(x: float) -> CreateNodes:
    """Return a wall of 0.1 m whose face towards the slide is at x."""
    return CreateNodes((body("wall", Box((0.1, 1.0, 1.0)), shifted(x=x + 0.05)),))


def contact_time(cell: Cell, *moves: Move) -> float:
    """Return after how many seconds moves touch something, as CheckMotion tells."""
    command = cell.command(*moves)
    found = contact_of(CollisionScene(SHAPES), cell.world.snapshot, command, np.inf, RESOLUTION, lambda: False)
    assert found is not None
    return found.time


@pytest.mark.parametrize("factor", [1.0, 0.37])
def test_a_motion_stops_in_the_first_tick_from_which_the_contact_can_be_seen(cell: Cell, factor: float) -> None:
    """At any speed factor: so many seconds of simulation time before."""
    cell.do(CreateNodes(slider()), wall(2.0), SetSpeedFactor("", factor))
    contact = contact_time(cell, slide(2.5)) / factor
    id = cell.start(slide(2.5))
    tick = cell.until_stopped(id)
    assert tick == int(np.ceil((contact - AHEAD) / TICK - 1e-6))
    place = float(cell.ended().state.q[0])
    assert place < 2.0 - BALL - RESOLUTION and not cell.touched
    told = cell.cancellation(id)
    assert told is not None and told.cause is EndCause.COLLISION
    assert told.reason.startswith("'slider.ball' would touch 'wall' in ")
    assert float(told.reason.split(" in ")[1].split(" ")[0]) == pytest.approx(contact - tick * TICK, abs=1e-2)
    assert cell.stopped == [told.reason]


def test_what_is_in_the_way_of_nothing_stops_nothing(cell: Cell) -> None:
    """All steps of a program, with dwells; the way back passes the wall again, by less than a millimetre."""
    cell.do(CreateNodes(slider()), wall(2.0 + BALL + 0.0005))
    steps = (MoveStep((slide(2.0),)), DwellStep(0.2), MoveStep((slide(-1.0),)))
    id = cell.start(steps=steps)
    cell.ended()
    assert cell.cancellation(id) is None and not cell.stopped


@pytest.mark.parametrize("seconds", [0.05, 0.6, 1.4])
def test_what_is_put_in_the_way_stops_the_motion_before_it_is_touched(cell: Cell, seconds: float) -> None:
    """In the tick in which it is put there; each tick after it is free."""
    cell.do(CreateNodes(slider()))
    id = cell.start(slide(2.5))
    cell.step(int(seconds / TICK))
    here = float(cell.world.snapshot.state.q[0])
    cell.do(wall(here + BALL + 0.6))
    motion = cell.world.snapshot.state.motions[0]
    assert motion.cancellation is not None and motion.cancellation.cause is EndCause.COLLISION
    scene = CollisionScene(SHAPES)
    while cell.world.snapshot.state.motions:
        scene.place(cell.step())
        assert not scene.collisions(Detail.FIRST)
    assert cell.cancellation(id) is not None and not cell.touched
    assert float(cell.world.snapshot.state.q[0]) > here


def crossing(cell: Cell) -> None:
    """Make two slides whose ways cross at x = 0.7, y = 0."""
    cell.do(CreateNodes((*slider("along"), *slider("across", shifted(x=0.7, y=-1.5) @ turning(np.pi / 2.0)))))


def test_two_that_pass_each_other_in_time_are_let_pass(cell: Cell) -> None:
    """Their ways cross, the second comes there 0.8 s later; paused in the crossing, the first stands in its way."""
    crossing(cell)
    ids = cell.start(slide(2.0, "along")), cell.start(slide(2.8, "across"))
    while float(cell.world.snapshot.state.q[0]) < 0.6:
        cell.step()
    assert not cell.stopped
    cell.do(PauseMotion(ids[0]))
    while cell.world.snapshot.state.motions[-1].id == ids[1]:
        cell.step()
    told = cell.cancellation(ids[1])
    assert told is not None and told.cause is EndCause.COLLISION
    (first,) = cell.world.snapshot.state.motions
    assert first.id == ids[0] and first.cancellation is None
    cell.do(ResumeMotion(ids[0]))
    cell.ended()
    assert cell.cancellation(ids[0]) is None and not cell.touched


def test_two_that_meet_in_time_both_stop(cell: Cell) -> None:
    """Both have 0.7 m to go to the crossing; neither alone would touch anything."""
    crossing(cell)
    cell.do(SetJointPositions("across", {"slide": 0.8}))
    ids = cell.start(slide(2.0, "along")), cell.start(slide(2.9, "across"))
    cell.ended()
    causes = [cell.cancellation(id) for id in ids]
    assert all(one is not None and one.cause is EndCause.COLLISION for one in causes)
    assert not cell.touched


@pytest.mark.long
def test_a_slower_robot_is_looked_at_as_slow_as_it_is(cell: Cell) -> None:
    """At the same speed they meet; one at a tenth of it comes later, and is then stopped by nothing that stands."""
    crossing(cell)
    cell.do(SetJointPositions("across", {"slide": 0.8}), SetSpeedFactor("across", 0.1))
    ids = cell.start(slide(2.0, "along")), cell.start(slide(2.9, "across"))
    cell.ended(20000)
    assert [cell.cancellation(id) for id in ids] == [None, None]
    assert not cell.touched


def test_what_comes_after_a_wait_is_looked_at_when_the_wait_is_over(cell: Cell) -> None:
    cell.do(CreateNodes(slider()), wall(1.0), CreateSignal(Signal("go", False)))
    id = cell.start(steps=(MoveStep((slide(0.1),)), WaitSignalStep(Condition("go")), MoveStep((slide(2.0),))))
    cell.step(1000)
    assert not cell.stopped
    cell.do(SetSignal("go", True))
    cell.step(3)
    assert cell.stopped
    cell.ended()
    assert cell.cancellation(id) is not None and not cell.touched


@pytest.mark.parametrize("mode", [CollisionMode.OFF, CollisionMode.MONITOR])
def test_robots_that_are_not_to_be_stopped_are_not_looked_at(cell: Cell, mode: CollisionMode) -> None:
    cell.set(mode=mode)
    cell.do(CreateNodes(slider()), wall(1.0))
    id = cell.start(slide(2.0))
    cell.ended()
    assert cell.cancellation(id) is None and not cell.stopped


def test_zero_seconds_look_at_nothing(cell: Cell) -> None:
    """The motion goes on until it touches: then the monitor stops it."""
    cell.set(look_ahead=0.0)
    cell.do(CreateNodes(slider()), wall(1.0))
    cell.start(slide(2.0))
    cell.ended()
    assert cell.touched and cell.stopped == ["'slider.ball' touches 'wall'"]


def test_who_runs_into_a_robot_that_is_to_be_stopped_stops(cell: Cell) -> None:
    """The mode of the one that stands is STOP, that of the one that moves OFF."""
    cell.set(mode=CollisionMode.OFF)
    cell.do(CreateNodes((*slider(), *slider("other", shifted(x=1.5)))))
    cell.set(other=CollisionMode.STOP)
    id = cell.start(slide(2.0))
    cell.ended()
    assert cell.cancellation(id) is not None and not cell.touched


def test_what_touches_already_stops_nobody_but_what_comes_then_does(cell: Cell) -> None:
    """The ball slides off a block that it begins in, and stops before the wall behind it."""
    cell.do(CreateNodes((*slider(), body("block", Box((0.3, 0.3, 0.3)), shifted()))), wall(1.5))
    id = cell.start(slide(2.0))
    cell.step(30)
    assert not cell.stopped
    cell.ended()
    told = cell.cancellation(id)
    assert told is not None and "'wall'" in told.reason
    assert float(cell.world.snapshot.state.q[0]) < 1.5 - BALL


def test_braking_robots_are_looked_at_too(cell: Cell) -> None:
    """One that is cancelled needs its way to stop; another one that would cross it there stops as well."""
    crossing(cell)
    first = cell.start(slide(2.0, "along"))
    cell.step(130)
    cell.do(CancelMotion(first, Cancellation(EndCause.CALL, "")))
    state = cell.world.snapshot.state
    told = foreseen(cell.world.snapshot, AHEAD)
    assert told is not None and len(state.motions) == 1
    begin = state.tick
    while cell.world.snapshot.state.motions:
        here = cell.step()
        np.testing.assert_allclose(told.path.at(here.simulation_time), here.state.q, atol=1e-9)
    assert cell.world.snapshot.state.tick - begin > 20


def test_a_journal_gives_the_same_without_looking(cell: Cell) -> None:
    cell.do(CreateNodes(slider()), wall(2.0))
    cell.start(slide(2.5))
    cell.ended()
    again = replayed(cell.world)
    assert (again.q == cell.world.snapshot.state.q).all() and again.ended[0].cancellation is not None


def test_what_was_found_free_is_not_looked_at_again(monkeypatch: pytest.MonkeyPatch, cell: Cell) -> None:
    """A long motion: each part of its time is asked once, though something is looked at in each tick."""
    asked: list[tuple[float, float]] = []
    first_along: Any = ahead.first_along

    def counted(scene: CollisionScene, snapshot: Snapshot, path: JointPath, *others: Any, **options: Any) -> object:  # noqa: ANN401
        asked.append((path.begin, path.end))
        return first_along(scene, snapshot, path, *others, **options)

    monkeypatch.setattr(ahead, "first_along", counted)
    cell.do(CreateNodes(slider()), wall(2.9))
    cell.start(slide(2.5))
    cell.ended()
    assert all(one[1] == other[0] for one, other in pairwise(asked))
    assert asked[0][0] == pytest.approx(0.0, abs=2 * TICK)


def test_random_cells_are_stopped_before_anything_touches(rng: np.random.Generator) -> None:
    """Three levers with balls whose circles cross, at random speeds, paused and resumed: never a contact."""
    cell = Cell()
    try:
        for number in range(3):
            angle = 2.0 * np.pi * number / 3.0
            cell.do(CreateNodes(sweeper(f"s{number}", turning(angle) @ shifted(x=0.75))))
        for number in range(3):
            cell.do(SetSpeedFactor(f"s{number}", float(rng.uniform(0.2, 1.0))))
        for _ in range(12):
            snapshot = cell.world.snapshot
            if scene_of(snapshot).collisions(Detail.FIRST):
                raise AssertionError("they touch")
            moving = {robot for motion in snapshot.state.motions for robot in motion.robots}
            for number in range(3):
                uid = snapshot.structure.node(f"s{number}").uid
                if uid not in moving:
                    cell.start(PointToPoint(f"s{number}", {"turn": float(rng.uniform(-3.0, 3.0))}))
            for id in [motion.id for motion in cell.world.snapshot.state.motions]:
                # One that has not begun to move ends at once when another one goes on.
                motion = next((one for one in cell.world.snapshot.state.motions if one.id == id), None)
                if motion is not None and motion.cancellation is None and rng.random() < 0.3:
                    paused = motion.running.phase.value in ("PAUSED", "PAUSING")
                    cell.do(ResumeMotion(motion.id) if paused else PauseMotion(motion.id))
            cell.step(int(rng.integers(20, 150)))
        assert not cell.touched
    finally:
        cell.close()


def test_a_look_without_time_goes_on_with_the_next_one_the_next_moments_first() -> None:
    """Each look has time for one piece, 0.25 s; what is over meanwhile is not looked at any more."""
    cell = Cell(monitored=False)
    try:
        cell.set(look_ahead=2.5, mode=CollisionMode.STOP)
        cell.do(CreateNodes(slider()), wall(2.0))
        contact = contact_time(cell, slide(2.5))
        cell.start(slide(2.5))
        look, scene = LookAhead(), CollisionScene(SHAPES)
        assert 2.0 < contact < 2.5
        looks = 1
        while (stop := look.look(scene, cell.step(), enough=lambda: True)) is None:
            looks += 1
        assert looks == int(np.ceil((contact - TICK) / 0.25))
        late = LookAhead()
        assert late.look(scene, cell.step(), enough=lambda: True) is None
        cell.step(int((contact - cell.world.snapshot.simulation_time - 0.2) / TICK))
        found = late.look(scene, cell.world.snapshot, enough=lambda: True)
        assert found is not None and found.robots == stop.robots
        assert found.reason.endswith(f"in {contact - cell.world.snapshot.simulation_time:.3g} s")
    finally:
        cell.close()


def test_nothing_is_known_where_nothing_runs() -> None:
    cell = Cell()
    try:
        cell.do(CreateNodes(slider()), wall(1.0))
        assert LookAhead().look(scene_of(cell.world.snapshot), cell.world.snapshot) is None
    finally:
        cell.close()
