"""The guard: brakes in time and not sooner, refuses what would touch, tolerates what touched; replays need no guard."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.collision.guard import CollisionGuard, _Threat
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.moves import PointToPoint, ToolStateMove
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import DwellStep, MotionSpec, MoveStep
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    PauseMotion,
    PickPart,
    PlacePart,
    RemoveNode,
    SelectTool,
    SetAllowedPairs,
    SetJointPositions,
    SetSetpoint,
    SetSpeedFactor,
    SetToolState,
    StartSetpointMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec, ToolData

from tests.unit.collision.carts import RADIUS, WAIT, block, cart, drive, mode, place, replayed
from tests.unit.collision.sweepers import BALL, body, growing, slider
from tests.unit.collision.worlds import SHAPES
from tests.unit.journals import entries_of
from tests.unit.planning.cell import chain
from tests.unit.world.builders import part, shifted

NEAR = 0.001
"""How near (m) a cart comes at the least to what it may not touch: it goes at most 4 mm in a tick, and starts to brake
in the last one in which that is in time."""


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    made.start()
    yield made
    made.close()


@pytest.fixture
def guard(world: World) -> CollisionGuard:
    return CollisionGuard(SHAPES, world)


def do(world: World, *commands: Command) -> Snapshot:
    return world.submit(commands).result(WAIT).snapshot


def step(world: World, ticks: int = 1) -> Snapshot:
    return world.step(ticks).result(WAIT)


def refused(world: World, *commands: Command) -> str:
    before = world.snapshot
    with pytest.raises(KernelError) as error:
        do(world, *commands)
    assert error.value.reason is Reason.COLLISION
    assert world.snapshot is before, "nothing has changed"
    return str(error.value)


def last(world: World) -> Cancellation:
    """Return why the last motion was cancelled."""
    found = world.snapshot.state.ended[-1].cancellation
    assert found is not None
    return found


def test_a_cart_stops_before_a_block_in_the_last_tick_in_which_it_can(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 1.0), mode("guard"))
    do(world, drive(0.0, 1.9))
    farthest = max(place(step(world)) for _ in range(700))
    gap = 0.8 - farthest  # the box begins at 0.9, the ball has a radius of 0.1
    assert 0.0 < gap < 0.005
    assert last(world).cause is EndCause.COLLISION
    assert last(world).reason.startswith("'cart.ball' would touch 'block' in 0.")
    assert world.snapshot.state.v[0] == 0.0
    assert guard.cost.ticks > 100 and guard.cost.worst_seconds >= guard.cost.seconds / guard.cost.ticks
    assert entries_of(world)[-1].author == "collision guard"
    assert replayed(world).q.tobytes() == world.snapshot.state.q.tobytes()
    do(world, drive(float(world.snapshot.state.q[0]), 0.0))
    assert place(step(world, 700)) == 0.0, "back it may go"


def test_a_motion_that_touches_nothing_is_what_it_is_without_a_guard(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 1.0, y=RADIUS + 0.1 + NEAR), mode("guard"))
    do(world, drive(0.0, 1.9))
    step(world, 700)
    assert world.snapshot.state.ended[-1].cancellation is None
    assert [entry.author for entry in entries_of(world)] == ["", ""]
    assert place(world.snapshot) == 1.9


def test_where_only_others_are_guarded_nothing_is_done(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), cart("other", y=5.0), block("block", 1.0), mode("off", other="guard"))
    do(world, drive(0.0, 1.9))
    assert place(step(world, 700)) == 1.9


def test_whoever_would_run_into_a_guarded_robot_brakes_too(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), cart("other"), mode("off", other="guard"))
    do(world, SetJointPositions("other", {"x": 1.0}))
    do(world, drive(0.0, 1.9))
    gap = 1.0 - 2.0 * RADIUS - place(step(world, 700))
    assert 0.0 < gap < 0.005
    assert last(world).cause is EndCause.COLLISION


def test_two_carts_that_meet_both_brake_and_a_third_goes_on(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), cart("other"), cart("third", y=1.0), mode("guard"))
    do(world, SetJointPositions("other", {"x": 1.5}))
    do(world, drive(0.0, 1.5), drive(1.5, 0.0, "other"), drive(0.0, 1.0, "third"))
    for _ in range(700):
        now = step(world)
        assert place(now, "other") - place(now) > 2.0 * RADIUS
    assert place(now, "other") - place(now) < 2.0 * RADIUS + 0.01
    assert place(now, "third") == 1.0


def test_at_what_it_stands_it_does_not_start(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 0.2 + 0.0003), mode("guard"))
    do(world, drive(0.0, 1.0))
    assert abs(place(step(world, 50))) < 2e-4
    assert last(world).cause is EndCause.COLLISION


@pytest.mark.parametrize("following", [False, True])
@pytest.mark.parametrize("gap", [0.0003, 0.001])
def test_with_long_ticks_what_stands_near_may_go_away_and_no_nearer(gap: float, following: bool) -> None:
    """At 50 ms a way between two ticks is known to 2 * 40 * 0.05 * 0.05² / 8 = 1.25 mm only: jerk, tick, tick²."""
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 50_000_000))
    CollisionGuard(SHAPES, world)
    world.start()

    def went(goal: float) -> float:
        begin = float(world.snapshot.state.q[0])
        if following:
            (id,) = world.submit([StartSetpointMotion("cart", ("x",), SetpointMode.VELOCITY, 0.1)]).result(WAIT).created
        else:
            do(world, drive(begin, goal))
        for _ in range(40):
            if following and world.snapshot.state.motions:
                do(world, SetSetpoint(str(id), (float(np.sign(goal)),)))
            assert place(step(world)) < gap
        return place(world.snapshot) - begin

    try:
        do(world, cart("cart"), block("block", 0.2 + gap), mode("guard"))
        assert abs(went(1.0)) < gap
        assert last(world).cause is EndCause.COLLISION
        assert went(-1.0) < -0.9
    finally:
        world.close()


@pytest.mark.parametrize("speed", [1.0, 0.3])
def test_setpoints_lead_no_farther_than_to_what_is_in_the_way(
    world: World, guard: CollisionGuard, speed: float
) -> None:
    do(world, cart("cart"), block("block", 1.0), mode("guard"))
    (id,) = world.submit([StartSetpointMotion("cart", ("x",), SetpointMode.VELOCITY, 0.1)]).result(WAIT).created
    for _ in range(1200):
        if not world.snapshot.state.motions:
            break
        do(world, SetSetpoint(str(id), (speed,)))
        assert place(step(world)) < 0.8
    assert place(world.snapshot) > 0.795
    assert last(world).cause is EndCause.COLLISION


def test_what_is_put_into_touch_is_refused(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), cart("free", y=3.0), block("block", 1.0), mode("off", cart="guard"))
    assert "'cart.ball' would touch 'block'" in refused(world, SetJointPositions("cart", {"x": 0.9}))
    refused(world, UpdateNode("block", parent_t_node=shifted(x=0.1)))
    refused(world, block("new", 0.1))
    refused(world, AttachNode("block", "world", shifted(x=0.1)))
    refused(world, AttachNode("free", "world", shifted(x=0.1)))
    do(world, SetJointPositions("cart", {"x": 0.5}), UpdateNode("block", parent_t_node=shifted(x=1.5)))
    do(world, SetJointPositions("free", {"x": 0.5}))
    do(world, block("far", -0.5))


def test_what_touches_when_it_becomes_guarded_may_go_apart_and_then_no_more_touch(
    world: World, guard: CollisionGuard
) -> None:
    do(world, cart("cart"), block("block", 0.15), mode("guard"))
    assert len(guard.tolerated) == 1
    do(world, drive(0.0, -1.0))
    step(world, 700)
    assert place(world.snapshot) == -1.0
    assert not guard.tolerated
    do(world, drive(-1.0, 0.0))
    gap = -0.05 - place(step(world, 700))
    assert 0.0 < gap < 0.005


def test_what_is_let_go_may_touch_what_it_touched(world: World, guard: CollisionGuard) -> None:
    """A part that lies on a table is attached to the cart where it lies: its touch of the table is no new one."""
    do(world, cart("cart"), block("table", 1.0), block("part", 1.0, y=0.2, kind=Kind.PART), mode("guard"))
    do(world, AttachNode("part", "cart.ball"))
    assert len(guard.tolerated) == 1
    do(world, drive(0.0, -1.0))
    assert place(step(world, 700)) == -1.0
    assert not guard.tolerated


def test_what_a_tool_closes_on_picks_and_lets_go_is_tolerated(world: World, guard: CollisionGuard) -> None:
    """A cube of 0.1 m lies between two jaws that close to 0.1 m, and half in a table that it lies on."""
    jaws = tuple(
        Figure(Box((0.02, 0.02, 0.04)), shifted(x=side * gap, y=0.2), tool_state=state)
        for state, gap in (("open", 0.1), ("closed", 0.055))
        for side in (-1.0, 1.0)
    )
    states = {"open": {}, "closed": {}}
    hand = NodeSpec("hand", Kind.TOOL, "cart.ball", figures=jaws, data=ToolData(states=states))
    table = NodeSpec("table", Kind.OBJECT, "world", shifted(y=0.2, z=-0.1), figures=(Figure(Box((0.05, 0.05, 0.12))),))
    do(world, cart("cart"), CreateNodes((hand, table, part("cube", shifted(y=0.2)))))
    do(world, SetToolState("hand", "open"), SelectTool("cart", "hand"), mode("guard"))
    assert not guard.tolerated
    do(world, SetToolState("hand", "closed"))
    assert len(guard.tolerated) == 1, "the jaws and the cube"
    do(world, PickPart("cart", "cube"))
    assert len(guard.tolerated) == 2, "the cube and the table, too"
    do(world, drive(0.0, -1.0))
    assert place(step(world, 500)) == -1.0
    do(world, PlacePart("cart"), SetToolState("hand", "open"))
    do(world, UpdateNode("cube", parent_t_node=shifted(x=-1.0, y=5.0)))
    do(world, drive(-1.0, 0.0))
    assert place(step(world, 500)) == 0.0
    assert "'hand' would touch 'new'" in refused(world, block("new", 0.1, y=0.25))


def test_an_obstacle_that_is_put_where_it_would_brake_makes_it_brake_at_once(
    world: World, guard: CollisionGuard
) -> None:
    do(world, cart("cart"), block("block", 1.8, y=3.0), mode("guard"))
    do(world, drive(0.0, 1.9))
    now = step(world, 200)
    speed = float(now.state.v[0])
    assert speed == pytest.approx(1.0)
    do(world, UpdateNode("block", parent_t_node=shifted(x=place(now) + 0.25)))
    assert world.snapshot.state.motions[0].cancellation is not None
    assert entries_of(world)[-1].tick == now.state.tick


def test_what_was_put_into_the_way_too_late_keeps_nobody_from_going_away(world: World, guard: CollisionGuard) -> None:
    """The brake ends in the block; out of it the cart may go, and then no more into it."""
    do(world, cart("cart"), block("block", 1.8, y=3.0), mode("guard"))
    do(world, drive(0.0, 1.9))
    at = place(step(world, 200))
    do(world, UpdateNode("block", parent_t_node=shifted(x=at + 0.25)))
    inside = place(step(world, 200))
    assert inside > at + 0.05
    do(world, drive(inside, at - 0.5))
    assert place(step(world, 700)) == pytest.approx(at - 0.5)
    assert not guard.tolerated
    do(world, drive(at - 0.5, 1.9))
    assert 0.0 < at + 0.05 - place(step(world, 700)) < 0.005


@pytest.mark.parametrize("on", [(), (DwellStep(0.1),), (MoveStep((PointToPoint("slider", {"slide": 0.0}),)),)])
def test_a_tool_that_a_program_lets_grow_into_something_stays_as_it_is(
    world: World, guard: CollisionGuard, on: tuple[MoveStep | DwellStep, ...]
) -> None:
    """Whatever comes after it, and if nothing does; the tool is 0.5 m long then, and the wall 0.3 m away."""
    wall = body("wall", Box((0.01, 1.0, 1.0)), shifted(x=BALL + 0.6))
    do(world, CreateNodes((*slider(), growing("tool", "slider.ball"), wall)))
    do(world, SelectTool("slider", "tool", "tip"), SetToolState("tool", "small"), mode("guard"))
    grow = MoveStep((ToolStateMove("slider", "tool", "large"),))
    steps = (MoveStep((PointToPoint("slider", {"slide": 0.3}),)), grow, *on)
    do(world, plan_motion(world.snapshot, MotionSpec(steps=steps), chain).command)
    state = step(world, 700).state
    assert list(state.tool_states.values()) == ["small"]
    assert "'tool' would touch 'wall'" in last(world).reason
    assert state.q[0] == pytest.approx(0.3)


def test_a_pause_or_another_speed_comes_through_where_it_does_no_harm(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 1.0), mode("guard"))
    (id,) = world.submit([drive(0.0, 1.9)]).result(WAIT).created
    step(world, 60)
    do(world, SetSpeedFactor("", 0.5))
    step(world, 60)
    do(world, PauseMotion(str(id)))
    for _ in range(1500):
        assert place(step(world)) < 0.8
        do(world, SetSpeedFactor("", float(np.random.default_rng(world.snapshot.state.tick).uniform(0.2, 1.0))))


def test_a_pause_that_would_touch_is_refused_in_company_too(
    world: World, guard: CollisionGuard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A brake that touches is told by hand; that of the tick is not asked for."""
    do(world, cart("cart"), cart("other", y=3.0), mode("guard"))
    (id,) = world.submit([drive(0.0, 1.9)]).result(WAIT).created
    step(world, 60)
    monkeypatch.setattr(guard, "_threat", lambda *_: _Threat(frozenset(), "it would touch"))
    assert "it would touch; the motion goes on" in refused(world, PauseMotion(str(id)), drive(0.0, 1.0, "other"))
    do(world, drive(0.0, 1.0, "other"))


def test_allowed_pairs_are_not_guarded(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 1.0), mode("guard"))
    do(world, SetAllowedPairs((("cart.ball", "block", ""),)))
    do(world, drive(0.0, 1.9))
    assert place(step(world, 700)) == 1.9
    assert not guard.tolerated
    do(world, drive(1.9, 1.0))
    step(world, 400)
    do(world, SetAllowedPairs(forbid=(("cart.ball", "block"),)))
    assert len(guard.tolerated) == 1
    do(world, RemoveNode("block"))
    assert not guard.tolerated


def test_a_guard_that_fails_stops_what_moves(
    world: World, guard: CollisionGuard, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    do(world, cart("cart"), mode("guard"), drive(0.0, 1.9))
    step(world, 100)

    def fail(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(guard, "_threat", fail)
    step(world, 100)
    assert "failed inside the kernel: ZeroDivisionError" in last(world).reason
    assert "ZeroDivisionError" in caplog.text


def test_a_guard_that_fails_refuses_what_it_cannot_look_at_and_can_be_ended(
    world: World, guard: CollisionGuard, monkeypatch: pytest.MonkeyPatch
) -> None:
    do(world, cart("cart"), mode("guard"))

    def fail(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(guard, "_all_touching", fail)
    with pytest.raises(ZeroDivisionError):
        do(world, SetJointPositions("cart", {"x": 1.0}))
    assert place(world.snapshot) == 0.0
    do(world, mode("off"))
    do(world, SetJointPositions("cart", {"x": 1.0}))
    assert place(world.snapshot) == 1.0


def test_without_a_guarded_robot_it_costs_nothing(world: World, guard: CollisionGuard) -> None:
    do(world, cart("cart"), block("block", 1.0), mode("stop"), drive(0.0, 1.0))
    step(world, 50)
    assert guard.cost.ticks == 0
    do(world, mode("guard"))
    step(world, 10)
    assert guard.cost.ticks == 10
    do(world, mode("off"))
    step(world, 10)
    assert guard.cost.ticks == 10
