"""Planar and floating bases among things: the guard, the look ahead and the check of a motion see where they go."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.collision.guard import CollisionGuard
from virtualrobot_kernel.collision.monitor import Monitor
from virtualrobot_kernel.collision.program_sweep import first_of_program
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.moves import PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import (
    Command,
    CreateNodes,
    SetCollisionSettings,
    SetSetpoint,
    StartMotion,
    StartSetpointMotion,
)
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import EndCause, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import JointType, Kind, NodeSpec

from tests.unit.collision.carts import WAIT, replayed
from tests.unit.collision.worlds import SHAPES
from tests.unit.planning.cell import chain
from tests.unit.planning.crafts import AXES, FLOATING, PLANAR, SPEED, craft
from tests.unit.world.builders import TICK, shifted

TURN = {PLANAR: {"base/theta": 3.0}, FLOATING: {"base/qx": 0.0, "base/qy": 0.0, "base/qz": 1.0, "base/qw": 0.0}}
"""About z, by which the tip at 0.5 m comes round."""
FACE = 0.9
"""Place x (m) of the wall's face: that of the craft's box of 0.4 m is 0.7 m before it."""


@pytest.fixture
def world() -> Iterator[World]:
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    made.start()
    yield made
    made.close()


def do(world: World, *commands: Command) -> Snapshot:
    return world.submit(commands).result(WAIT).snapshot


def wall(face: float) -> CreateNodes:
    """Return a wall across x with its face at an x (m)."""
    box = (Figure(Box((0.2, 4.0, 4.0))),)
    return CreateNodes((NodeSpec("wall", Kind.OBJECT, "world", shifted(x=face + 0.1), figures=box),))


def going(snapshot: Snapshot, goal: dict[str, float]) -> StartMotion:
    return plan_motion(snapshot, MotionSpec((PointToPoint("craft", goal),)), chain).command


@pytest.mark.parametrize("kind", [PLANAR, FLOATING])
def test_a_guarded_base_stops_before_what_it_would_touch(world: World, kind: JointType) -> None:
    CollisionGuard(SHAPES, world)
    do(world, craft(kind), wall(FACE), SetCollisionSettings(CollisionMode.GUARD))
    do(world, going(world.snapshot, {"base/x": 2.0}))
    world.step(700).result(WAIT)
    end = world.snapshot.state.ended[-1]
    assert end.cancellation and end.cancellation.cause is EndCause.COLLISION
    assert 0.0 < FACE - 0.2 - world.snapshot.state.q[0] < 0.005
    assert replayed(world).q.tobytes() == world.snapshot.state.q.tobytes()


@pytest.mark.parametrize("kind", [PLANAR, FLOATING])
def test_a_guarded_base_that_turns_stops_before_a_corner_meets(world: World, kind: JointType) -> None:
    CollisionGuard(SHAPES, world)
    # A corner of the box, 0.283 m from the middle at -45 degrees, comes round to the face at 0.24 m.
    do(world, craft(kind), wall(0.24), SetCollisionSettings(CollisionMode.GUARD))
    do(world, going(world.snapshot, TURN[kind]))
    world.step(1500).result(WAIT)
    angle = 2.0 * np.arctan2(*world.snapshot.state.q[5:7]) if kind is FLOATING else world.snapshot.state.q[2]
    touches = np.pi / 4.0 - np.arccos(0.24 / np.hypot(0.2, 0.2))
    assert 0.0 < touches - angle < 0.01


@pytest.mark.parametrize("kind", [PLANAR, FLOATING])
def test_a_guarded_base_that_follows_velocities_stops_too(world: World, kind: JointType) -> None:
    CollisionGuard(SHAPES, world)
    do(world, craft(kind), wall(FACE), SetCollisionSettings(CollisionMode.GUARD))
    names = tuple(f"base/{axis}" for axis in AXES[kind])
    do(world, StartSetpointMotion("craft", names, SetpointMode.VELOCITY, 9.0))
    rates = {"base/x": 0.5, "base/y": 0.3, "base/theta": 0.8, "base/qx": 0.2, "base/qy": -0.3, "base/qz": 0.8}
    do(world, SetSetpoint(world.snapshot.state.motions[0].id, tuple(rates.get(name, 0.0) for name in names)))
    corners = np.array([[x, y, z, 1.0] for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (-0.2, 0.2)])
    body = world.snapshot.structure.node("craft.body").uid
    for _ in range(700):
        now = world.step(1).result(WAIT)
        gap = FACE - float((now.world_t(body) @ corners.T)[0].max())
        assert gap > 0.0
    assert gap < 0.05
    assert now.state.ended[-1].cancellation and now.state.ended[-1].cancellation.cause is EndCause.COLLISION


@pytest.mark.parametrize("kind", [PLANAR, FLOATING])
def test_a_check_tells_the_time_at_which_a_base_touches(world: World, kind: JointType) -> None:
    now = do(world, craft(kind), wall(FACE))
    command = going(now, {"base/x": 2.0, "base/y": 0.01})
    joints = [(now.structure.node(robot).uid, name) for robot, name in command.joints]
    scene = CollisionScene(SHAPES)
    found = first_of_program(
        scene, [(0.0, now)], command.program, joint_places(now.structure, joints)[0], [], np.inf, 1e-4
    )
    assert found is not None
    x = float(command.program.stages[0].plan.derivatives(np.array([found.time]))[0, 0, 0])  # pyright: ignore[reportOptionalMemberAccess]
    assert x == pytest.approx(FACE - 0.2, abs=1.1e-4)


def test_who_is_watched_ahead_stops_in_time(world: World) -> None:
    monitor = Monitor(world, SHAPES)
    do(world, craft(PLANAR), wall(FACE), SetCollisionSettings(CollisionMode.STOP, (), 0.5))
    do(world, going(world.snapshot, {"base/x": 2.0}))
    world.step(700).result(WAIT)
    monitor.close()
    assert world.snapshot.state.ended[-1].cancellation
    # It brakes half a second before it would touch, at full speed, and needs less than that to stand.
    assert 0.0 < FACE - 0.2 - world.snapshot.state.q[0] < 0.5 * SPEED + SPEED * TICK
