"""Robots that are spheres on rails: when they touch follows from one number."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from virtualrobot_kernel.motion.limits import JointLimits as MotionLimits
from virtualrobot_kernel.motion.plan import plan_ptp
from virtualrobot_kernel.motion.program import of_plan
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, CreateNodes, SetCollisionSettings, StartMotion
from virtualrobot_kernel.world.figures import Box, Figure, Sphere
from virtualrobot_kernel.world.journal import MemoryJournal, replay
from virtualrobot_kernel.world.state import Snapshot, State, empty_state
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.journals import entries_of
from tests.unit.world.builders import shifted

RADIUS = 0.1
SPEED, ACCELERATION, JERK = 1.0, 4.0, 40.0
WAIT = 30.0
"""Seconds after which a test gives up waiting."""


def cart(name: str, y: float = 0.0, parent: str = "world") -> CreateNodes:
    """Return a robot whose joint `x` moves a sphere along x; at 0 the sphere is over the robot's origin."""
    joint = Joint("x", JointType.PRISMATIC, (1.0, 0.0, 0.0), JointLimits(-2.0, 2.0, SPEED, ACCELERATION, JERK))
    ball = (Figure(Sphere(RADIUS)),)
    return CreateNodes(
        (
            NodeSpec(name, Kind.ROBOT, parent, shifted(y=y), data=RobotData()),
            NodeSpec(f"{name}.ball", Kind.LINK, name, shifted(), figures=ball, data=LinkData(joint)),
        )
    )


def block(name: str, x: float, y: float = 0.0, kind: Kind = Kind.OBJECT, parent: str = "world") -> CreateNodes:
    """Return a box of 0.2 m: a ball beside it touches from 0.2 m on, along x or y."""
    return CreateNodes((NodeSpec(name, kind, parent, shifted(x=x, y=y), figures=(Figure(Box((0.2, 0.2, 0.2))),)),))


def drive(start: float, goal: float, robot: str = "cart") -> StartMotion:
    """Return a motion of a cart."""
    limits = MotionLimits(
        ("x",), *(np.array([value]) for value in (-2.0, 2.0, SPEED, ACCELERATION)), jerk=np.array([JERK])
    )
    return StartMotion(((robot, "x"),), of_plan(plan_ptp([start], [goal], limits)))


def mode(name: str = "", **robots: str) -> SetCollisionSettings:
    """Return what sets modes, without looking ahead: of all, and of robots; an empty one takes a robot's own away."""
    own = tuple((robot, CollisionMode(one) if one else None) for robot, one in robots.items())
    return SetCollisionSettings(CollisionMode(name) if name else None, own, look_ahead_seconds=0.0)


def first_tick(world: World, touches: Callable[[Snapshot], bool], *commands: Command, ticks: int = 2000) -> int:
    """Return the tick at which something is first so, in a copy of a world to which commands are given now."""
    now = world.snapshot
    copy = World(world_poses, MemoryJournal(), world.clock, now.structure, now.state)
    copy.start()
    try:
        copy.submit(commands).result(WAIT)
        for _ in range(ticks):
            if touches(copy.step(1).result(WAIT)):
                return copy.snapshot.state.tick
    finally:
        copy.close()
    raise AssertionError("it never is")


def replayed(world: World) -> State:
    """Return the state of a world replayed from its journal alone, from the beginning."""
    now = world.snapshot
    begin = empty_state()
    return replay(index.empty(), begin, entries_of(world), now.state.tick, now.tick_seconds, world_poses).state


def place(snapshot: Snapshot, name: str = "cart") -> float:
    """Return where the ball of a cart is along x, in the world."""
    return float(snapshot.world_t(snapshot.structure.node(f"{name}.ball").uid)[0, 3])
