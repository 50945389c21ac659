"""Guarded worlds of real arms among thin walls, random things for them to do, and what coal says of all of it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from virtualrobot_kernel.collision.guard import CollisionGuard
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.moves import CartesianJog, JointJog, Linear, Move, PointToPoint
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.program import MotionSpec, MoveStep, Zone
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import (
    Command,
    CreateNodes,
    EndSetpoints,
    SetCollisionSettings,
    SetJointPositions,
    SetSetpoint,
    StartMotion,
    StartSetpointMotion,
    StopRobots,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot, State
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec, Structure
from virtualrobot_kernel.world.tick import advance

from tests.unit.collision.worlds import ROBOTS, SHAPES, asked, coal_distances, coal_touches, robot_nodes
from tests.unit.planning.cell import chain
from tests.unit.planning.cell import pictured as pictured_change
from tests.unit.planning.tracking_cell import random_cell
from tests.unit.world.builders import after, empty, random_pose, shifted

WAIT = 120.0
TICK = 0.004
FINE = 11
"""Into how many parts a tick is cut: ten points between two."""
CLEAR = 0.03
"""How far (m) walls are from the arms in the beginning."""


@dataclass
class Cell:
    """A world, its guard, and of each tick the last picture that was published, and the last one before a stop."""

    world: World
    guard: CollisionGuard
    begin: tuple[Structure, State] = field(default_factory=lambda: (empty().structure, empty().state))
    pictures: dict[int, Snapshot] = field(default_factory=dict)
    befores: dict[int, Snapshot] = field(default_factory=dict)

    def do(self, *commands: Command) -> tuple[int | str, ...]:
        return self.world.submit(commands).result(WAIT).created

    def step(self, ticks: int = 1) -> Snapshot:
        return self.world.step(ticks).result(WAIT)

    def keep(self) -> None:
        now = self.world.snapshot
        self.pictures[now.state.tick] = now
        if not any(motion.cancellation for motion in now.state.motions):
            self.befores[now.state.tick] = now


def cell_of(kind: str, rng: np.random.Generator, arms: int, walls: int) -> Cell:
    """Return a cell with arms side by side, at random postures, among thin walls; all of them guarded."""
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)))
    cell = Cell(world, CollisionGuard(SHAPES, world))
    world.start()
    for row in range(arms):
        cell.do(
            CreateNodes(robot_nodes(ROBOTS[kind], f"arm{row}")), UpdateNode(f"arm{row}", None, shifted(x=0.7 * row))
        )
    scene = CollisionScene(SHAPES)
    while True:
        cell.do(*(SetJointPositions(f"arm{row}", posture(world.snapshot, f"arm{row}", rng)) for row in range(arms)))
        scene.place(world.snapshot)
        if not coal_touches(scene, asked(scene)):
            break
    placed = 0
    while placed < walls:
        pose = random_pose(rng)
        pose[:3, 3] = rng.uniform([-0.8, -0.8, 0.05], [0.8 + 0.7 * (arms - 1), 0.8, 1.1])
        figure = Figure(Box((0.001, *rng.uniform(0.1, 0.5, 2))))
        cell.do(CreateNodes((NodeSpec(f"wall{placed}", Kind.OBJECT, "world", pose, figures=(figure,)),)))
        scene.place(world.snapshot)
        uid = world.snapshot.structure.node(f"wall{placed}").uid
        if scene.distances([uid], scene.bodies.elements.keys() - {uid}, CLEAR):
            cell.do(UpdateNode(f"wall{placed}", f"gone{placed}.{rng.integers(1 << 40)}", shifted(z=-50.0)))
            continue
        placed += 1
    cell.do(SetCollisionSettings(CollisionMode.GUARD))
    world.listen(cell.keep)
    cell.keep()
    return cell


def belt_cell(rng: np.random.Generator) -> tuple[Cell, StartMotion, StartMotion]:
    """Return a cell with an arm over a belt that leads to a thin wall, and the starts of both."""
    while True:
        made = random_cell(rng, "iiwa", "belt", 0.6, 0.3)
        snapshot, scene = pictured_change(made.change), CollisionScene(SHAPES)
        scene.place(snapshot)
        if coal_touches(scene, asked(scene)):
            continue
        structure = snapshot.structure
        wall = snapshot.world_t(structure.node("conveyor.tray").uid).copy()
        wall[:3, 3] = flange(snapshot, "arm")[:3, 3] + wall[:3, 0] * rng.uniform(0.15, 0.25)
        figures = (Figure(Box((0.001, 0.6, 0.6))),)
        change = after(made.change, CreateNodes((NodeSpec("wall", Kind.OBJECT, "world", wall, figures=figures),)))
        snapshot = pictured_change(change)
        scene.place(snapshot)
        uid = snapshot.structure.node("wall").uid
        if not scene.distances([uid], scene.bodies.elements.keys() - {uid}, CLEAR):
            break
    clock = Clock(Mode.STEPPED, 1.0, round(TICK * 1e9))
    world = World(world_poses, MemoryJournal(), clock, change.structure, change.state)
    cell = Cell(world, CollisionGuard(SHAPES, world), (change.structure, change.state))
    world.start()
    cell.do(SetCollisionSettings(CollisionMode.GUARD))
    world.listen(cell.keep)
    cell.keep()
    run_belt = plan_motion(snapshot, MotionSpec((PointToPoint("conveyor", {"run": 0.35}, 0.5),)), chain).command
    return cell, made.command, run_belt


def posture(snapshot: Snapshot, robot: str, rng: np.random.Generator) -> dict[str, float]:
    """Return random positions of a robot's joints within nine tenths of their limits."""
    found = {}
    for joint in snapshot.structure.robot(robot)[1].joints:
        lower, upper = max(joint.limits.lower, -2.5), min(joint.limits.upper, 2.5)
        found[joint.name] = 0.5 * (lower + upper) + 0.45 * (upper - lower) * float(rng.uniform(-1.0, 1.0))
    return found


def wish(snapshot: Snapshot, robot: str, rng: np.random.Generator) -> MotionSpec:
    """Return a random motion of an arm: point to point, a line, corners that are cut, a jog."""

    def line(scale: float) -> Linear:
        goal = flange(snapshot, robot).copy()
        goal[:3, 3] += rng.uniform(-scale, scale, 3)
        return Linear(robot, PoseGoal(goal), max_velocity=1.0, max_acceleration=5.0)

    kind = rng.integers(5)
    names = [joint.name for joint in snapshot.structure.robot(robot)[1].joints]
    if kind == 0:
        return MotionSpec((line(0.5),))
    if kind == 1:
        steps = [MoveStep((line(0.4),), Zone(0.05)) for _ in range(3)]
        return MotionSpec(steps=tuple(steps))
    if kind == 2:
        direction = rng.normal(size=3)
        jog: Move = CartesianJog(robot, tuple(direction.tolist()), velocity=0.5)
        return MotionSpec((jog,))
    if kind == 3:
        return MotionSpec((JointJog(robot, str(rng.choice(names[:4])), float(rng.choice([-1.0, 1.0]))),))
    return MotionSpec((PointToPoint(robot, posture(snapshot, robot, rng)),))


def flange(snapshot: Snapshot, robot: str) -> np.ndarray:
    """Return where a robot's flange is in the world."""
    return snapshot.world_t(snapshot.structure.robot(robot)[1].flange)


def started(cell: Cell, robot: str, rng: np.random.Generator) -> StartMotion:
    """Return the start of a random motion that can be planned."""
    for _ in range(100):
        try:
            return plan_motion(cell.world.snapshot, wish(cell.world.snapshot, robot, rng), chain).command
        except KernelError:
            continue
    raise AssertionError("nothing could be planned")


def stream(cell: Cell, robot: str, rng: np.random.Generator, ticks: int) -> None:
    """Send random setpoints, of positions or velocities, until the guard or time ends it."""
    joints = cell.world.snapshot.structure.robot(robot)[1].joints
    mode = SetpointMode(rng.choice(["POSITION", "VELOCITY"]))
    (id,) = cell.do(StartSetpointMotion(robot, tuple(joint.name for joint in joints), mode, 0.5))
    fastest = np.array([joint.limits.velocity for joint in joints])
    speed = fastest * rng.uniform(-0.8, 0.8, len(joints))
    at = np.array(cell.world.snapshot.state.q[list(cell.world.snapshot.structure.robot(robot)[1].q_start)])
    for _ in range(ticks):
        at = at + speed * TICK
        if not cell.world.snapshot.state.motions:
            return
        try:
            cell.do(SetSetpoint(str(id), tuple((at if mode is SetpointMode.POSITION else speed).tolist())))
        except KernelError:
            break
        cell.step()
    if cell.world.snapshot.state.motions:
        cell.do(EndSetpoints(str(id)))


def run(cell: Cell, ticks: int = 2000) -> None:
    """Let time go on until nothing moves."""
    for _ in range(ticks):
        if not cell.world.snapshot.state.motions:
            return
        cell.step()
    raise AssertionError("it never ends")


def between(picture: Snapshot) -> Iterator[Snapshot]:
    """Yield the world at ten points between a tick and the next, as its motions have it."""
    for part in range(1, FINE):
        yield pictured(picture, advance(picture.structure, picture.state, TICK * part / FINE, world_poses))


def pictured(picture: Snapshot, state: State) -> Snapshot:
    return replace(picture, state=state, world_t_node=world_poses(picture.structure, state))


def touching(pictures: Collection[Snapshot], left_out: Collection[tuple[int, int]] = ()) -> set[tuple[int, int]]:
    """Return all pairs that touch, by coal, at one of these moments or at ten points after each."""
    scene, found = CollisionScene(SHAPES), set()
    for picture in pictures:
        for one in (picture, *between(picture)):
            scene.place(one)
            found |= coal_touches(scene, [pair for pair in asked(scene) if pair not in left_out])
    return found


def nearest_later(before: Snapshot, pair: Sequence[int], seconds: float) -> float:
    """Return how near two nodes (uids) come, by coal, if all goes on for one more tick and only then brakes (m).

    It is looked at around so many seconds from now, when they are said to touch.
    """
    structure = before.structure
    state = advance(structure, before.state, TICK, world_poses)
    robots = tuple({uid for motion in state.motions for uid in motion.robots})
    stopped = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)), structure, state)
    stopped.start()
    now = stopped.submit([StopRobots(robots, Cancellation(EndCause.CALL, ""))]).result(WAIT).snapshot
    scene, least = CollisionScene(SHAPES), np.inf
    try:
        last = before.state.tick + int(seconds / TICK) + 2
        while now.state.tick <= last:
            for one in (now, *between(now)) if now.state.tick >= last - 4 else ():
                scene.place(one)
                least = min(least, *coal_distances(scene, [(pair[0], pair[1])]))
            now = stopped.step(1).result(WAIT)
        return float(least)
    finally:
        stopped.close()
