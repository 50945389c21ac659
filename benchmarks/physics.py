"""Cost of parts under physics to a tick: 1, 10 and 100 boxes that fall on each other, beside the engine alone.

Both are taken in the same ticks, as processor time: of a tick that of this process, of the engine that of its calls.
The engine runs in this process; what is left is the world's part, from its poses to the journal.
"""

from __future__ import annotations

import time

import numpy as np
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.physics.forces import Forces
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateNodes, SetPhysics, UpdateNode
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec, PartData
from virtualrobot_sdk.compiled.cache import compile_all

from benchmarks.rows import Row, row

COUNTS = (1, 10, 100)
TICKS = 80
"""Ticks of a turn: the boxes still fall and hit each other."""
TURNS = 7
BUDGET = 1.3


class Timed:
    """Engine whose calls are timed: processor time of the thread that makes them (s)."""

    def __init__(self, handle: ComponentHandle) -> None:
        """Time this engine from now on."""
        self.calls, self.seconds = 0, 0.0
        self._call = handle.call
        handle.call = self  # pyright: ignore[reportAttributeAccessIssue] for this benchmark alone

    def __call__(self, method: str, *arguments: object) -> object:
        """Call it."""
        begin = time.thread_time()
        answer = self._call(method, *arguments)
        self.seconds += time.thread_time() - begin
        self.calls += 1
        return answer


def at(x: float, y: float, z: float) -> np.ndarray:
    """Return a pose that is not turned."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def costs_of(count: int) -> tuple[float, float]:
    """Return what a tick costs, and the engine in it (ms), with so many boxes."""
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    forces = Forces(world, Catalog(), lambda mesh: ())
    world.start()
    boxes = {f"box {i}": at(0.12 * (i % 5), 0.12 * (i // 5 % 5), 0.06 + 0.11 * (i // 25)) for i in range(count)}
    figure, part = (Figure(Box((0.1, 0.1, 0.1))),), PartData(1.0, dynamic=True)
    floor = NodeSpec("floor", Kind.OBJECT, "world", at(0.0, 0.0, -0.5), False, (Figure(Box((60.0, 60.0, 1.0))),))
    specs = [NodeSpec(name, Kind.PART, "world", pose, False, figure, part) for name, pose in boxes.items()]
    world.submit([CreateNodes((floor, *specs)), SetPhysics("mujoco")]).result()
    world.step(1).result()
    (handle,) = forces.uses()
    timed = Timed(handle)
    ticks, engine = [], []
    for _ in range(TURNS):
        world.submit([UpdateNode(name, parent_t_node=pose) for name, pose in boxes.items()]).result()
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
    return 1000.0 * float(np.median(ticks)), 1000.0 * float(np.median(engine))


def run() -> list[Row]:
    """Return all rows."""
    compile_all(lambda done, total, name: None)
    rows = []
    for count in COUNTS:
        tick, engine = costs_of(count)
        name = f"tick with {count} box{'es' if count > 1 else ''} that fall{'s' if count == 1 else ''}"
        budget = BUDGET if count == max(COUNTS) else None
        rows.append(row(name, tick, engine, "the engine in it", "ms", budget, f"{4.0 / tick:.1f} times real time"))
    return rows


if __name__ == "__main__":
    for result in run():
        print(result)
