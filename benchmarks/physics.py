"""Cost of physics to a tick: 1, 10 and 100 boxes that fall on each other, 1 and 10 robots on wheels, beside the engine.

Both are taken in the same ticks, as processor time: of a tick that of this process, of the engine that of its calls.
The engine runs in this process; what is left is the world's part, from its poses to the journal. The peer is the engine
with the pipe that it would be behind in a process of its own: the processor time of both ends for what its calls take
and answer.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection

import numpy as np
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.physics.forces import Forces
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import Command, CreateNodes, UpdateNode
from virtualrobot_kernel.world.figures import Box, Cylinder, Figure, Material, Sphere
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.motors import JointMotor, MotorMode
from virtualrobot_kernel.world.physics_commands import SetJointEfforts, SetPhysics
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import (
    Inertial,
    Joint,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    PartData,
    RobotData,
)
from virtualrobot_sdk.compiled.cache import compile_all

from benchmarks.rows import Row, row

BOXES = (1, 10, 100)
ROBOTS = (1, 10)
TICKS = 80
"""Ticks of a turn: the boxes still fall and hit each other, the robots gather speed."""
TURNS = 7
EXCHANGES = 2000
"""Number of exchanges through a pipe that are timed."""
BUDGET = 1.3


class Timed:
    """Engine whose calls are timed: processor time of the thread that makes them (s)."""

    def __init__(self, handle: ComponentHandle) -> None:
        """Time this engine from now on."""
        self.calls, self.seconds = 0, 0.0
        self.last: tuple[object, object] = None, None
        """Arguments and answer of the last call."""
        self._call = handle.call
        handle.call = self  # pyright: ignore[reportAttributeAccessIssue] for this benchmark alone

    def __call__(self, method: str, *arguments: object) -> object:
        """Call it."""
        begin = time.thread_time()
        answer = self._call(method, *arguments)
        self.seconds += time.thread_time() - begin
        self.calls += 1
        self.last = arguments, answer
        return answer


def pipe_seconds(question: object, answer: object) -> float:
    """Return what a question and its answer cost through a pipe, processor time of both ends (s)."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_answer, args=(theirs, answer))
    process.start()
    ours.send(question)
    ours.recv()
    begin = time.process_time()
    for _ in range(EXCHANGES):
        ours.send(question)
        ours.recv()
    used = time.process_time() - begin
    ours.send(None)
    used += ours.recv()
    process.join()
    return used / EXCHANGES


def _answer(pipe: Connection, answer: object) -> None:
    """Answer each question, and at last tell the processor time of these answers after the first (s)."""
    pipe.recv()
    pipe.send(answer)
    begin = time.process_time()
    while pipe.recv() is not None:
        pipe.send(answer)
    pipe.send(time.process_time() - begin)


def at(x: float, y: float, z: float) -> np.ndarray:
    """Return a pose that is not turned."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def boxes(count: int) -> dict[str, np.ndarray]:
    """Return where boxes are that fall on each other, by name."""
    return {f"box {i}": at(0.12 * (i % 5), 0.12 * (i // 5 % 5), 0.06 + 0.11 * (i // 25)) for i in range(count)}


def box_nodes(count: int) -> list[NodeSpec]:
    """Return these boxes."""
    figure, part = (Figure(Box((0.1, 0.1, 0.1))),), PartData(1.0, dynamic=True)
    return [NodeSpec(name, Kind.PART, "world", pose, False, figure, part) for name, pose in boxes(count).items()]


def inertial(mass: float, *moments: float) -> Inertial:
    """Return a mass about the origin of a link (kg, kg m^2)."""
    x, y, z = moments
    return Inertial(mass, at(0.0, 0.0, 0.0), (x, y, z))


def robot_nodes(count: int) -> list[NodeSpec]:
    """Return robots of 5.6 kg with two driven wheels and a ball that slides, a meter apart."""
    nodes: list[NodeSpec] = []
    turned = np.eye(4)
    turned[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    wheel = Figure(Cylinder(0.05, 0.004), turned, Material(friction=0.8))
    for i in range(count):
        name = f"robot {i}"
        motors = tuple(JointMotor(side, MotorMode.EFFORT) for side in ("left", "right"))
        data = RobotData(dynamic=True, motors=motors)
        nodes.append(NodeSpec(name, Kind.ROBOT, "world", at(i % 5, i // 5, 0.0), False, (), data))
        hull, ball = Figure(Box((0.28, 0.2, 0.06)), at(-0.04, 0.0, 0.08)), Sphere(0.02)
        slides = Figure(ball, at(-0.1, 0.0, 0.02), Material(friction=0.0))
        base = LinkData(Joint("base", JointType.FLOATING), inertial(5.0, 0.018, 0.034, 0.049))
        nodes.append(NodeSpec(f"{name}.base", Kind.LINK, name, at(0.0, 0.0, 0.0), False, (hull, slides), base))
        for side, y in (("left", 0.12), ("right", -0.12)):
            joint = Joint(side, JointType.CONTINUOUS, (0.0, 1.0, 0.0))
            link = LinkData(joint, inertial(0.3, 0.0002, 0.000375, 0.0002))
            place = at(0.0, y, 0.05)
            nodes.append(NodeSpec(f"{name}.{side}", Kind.LINK, f"{name}.base", place, False, (wheel,), link))
    return nodes


def costs_of(
    nodes: list[NodeSpec], again: Sequence[Command], order: Sequence[Command] = ()
) -> tuple[float, float, float]:
    """Return what a tick of a world costs, the engine in it, and a pipe for the engine's calls (ms).

    `again` begins each turn, `order` the first.
    """
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    forces = Forces(world, Catalog(), lambda mesh: ())
    world.start()
    floor = NodeSpec("floor", Kind.OBJECT, "world", at(0.0, 0.0, -0.5), False, (Figure(Box((60.0, 60.0, 1.0))),))
    world.submit([CreateNodes((floor, *nodes)), SetPhysics("mujoco"), *order]).result()
    world.step(1).result()
    (handle,) = forces.uses()
    timed = Timed(handle)
    ticks, engine = [], []
    for _ in range(TURNS):
        if again:
            world.submit(again).result()
        world.step(1).result()
        timed.calls, timed.seconds = 0, 0.0
        begin = time.process_time()
        world.step(TICKS).result()
        ticks.append((time.process_time() - begin) / TICKS)
        engine.append(timed.seconds / TICKS)
        if timed.calls != TICKS or forces.fault:
            raise RuntimeError(forces.fault or "the engine was not asked in each tick")
    world.close()
    forces.close()
    return 1000.0 * float(np.median(ticks)), 1000.0 * float(np.median(engine)), 1000.0 * pipe_seconds(*timed.last)


def run() -> list[Row]:
    """Return all rows."""
    compile_all(lambda done, total, name: None)
    rows = []
    for count in BOXES:
        again = [UpdateNode(name, parent_t_node=pose) for name, pose in boxes(count).items()]
        name = f"tick with {count} box{'es' if count > 1 else ''} that fall{'s' if count == 1 else ''}"
        rows.append(_row(name, costs_of(box_nodes(count), again), BUDGET if count == max(BOXES) else None))
    for count in ROBOTS:
        # A small torque on each wheel: they gather speed all the time, and no motion adds to the tick.
        push = [SetJointEfforts(f"robot {i}", {"left": 0.02, "right": 0.02}) for i in range(count)]
        name = f"tick with {count} robot{'s' if count > 1 else ''} on wheels under physics"
        rows.append(_row(name, costs_of(robot_nodes(count), (), push), BUDGET))
    return rows


def _row(name: str, costs: tuple[float, float, float], budget: float | None) -> Row:
    tick, engine, pipe = costs
    note = f"{4.0 / tick:.1f} times real time; the engine alone takes {engine:.3f} ms"
    return row(name, tick, engine + pipe, "the engine and its pipe", "ms", budget, note)


if __name__ == "__main__":
    for result in run():
        print(result)
