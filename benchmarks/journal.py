"""The journal on disk: what it adds to an answer, to a tick and to ticks during a checkpoint; recovery and thinning."""

from __future__ import annotations

import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.folder import JOURNAL, Folder
from virtualrobot_kernel.history.history import History
from virtualrobot_kernel.history.rows import Row as Entry
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.upkeep import Rules
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    Command,
    CreateNodes,
    CreateSignal,
    SetSetpoint,
    SetSignal,
    StartSetpointMotion,
    StopMotions,
)
from virtualrobot_kernel.world.past_world import NoJournal
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec, PartData
from virtualrobot_kernel.world.tick_inputs import TickInput

from benchmarks.processes import echo
from benchmarks.rows import Row, row
from benchmarks.rpc import echoed
from benchmarks.tick import world_of

ARMS, JOINTS, NODES = 20, 7, 3_500
ROUNDS, CALLS, TICKS = 20, 200, 250
MILLION = 1_000_000
SWITCH_INTERVAL_SECONDS = 0.0005  # that of the kernel
NAMES = tuple(f"lbr_iiwa_joint_{joint}" for joint in range(1, JOINTS + 1))
CLOCK = Clock(Mode.STEPPED, 1.0, 4_000_000)
FAR = Rules(entries=10**9, bytes=10**15, motion_ticks=10**12)
"""Rules without checkpoints of their own."""


class Unwritten(NoJournal):
    """Journal that keeps nothing, of a world that is changed."""

    def admit(self, commands: Sequence[Command]) -> None:
        """Admit all."""


class Inputs:
    """Setpoints of all arms for each tick."""

    def __init__(self, ids: list[str]) -> None:
        """Begin."""
        self._ids, self._at = ids, 0

    def take(self) -> list[TickInput]:
        """Return those of the next tick."""
        self._at += 1
        values = (0.2 * float(np.sin(0.01 * self._at)),) * JOINTS
        return [TickInput(SetSetpoint(id, values), "bench", lambda error: None) for id in self._ids]


@contextmanager
def in_memory(begin: Snapshot, inputs: Inputs | None = None) -> Iterator[World]:
    """Give a world that keeps nothing."""
    source = inputs.take if inputs else tuple
    world = World(world_poses, Unwritten(), CLOCK, begin.structure, begin.state, source)
    world.start()
    yield world
    world.close()


@contextmanager
def on_disk(begin: Snapshot, inputs: Inputs | None = None, power: bool = False) -> Iterator[tuple[World, History]]:
    """Give the same world with its history in a folder."""
    source = inputs.take if inputs else tuple
    with tempfile.TemporaryDirectory() as folder:
        history = History(Folder(Path(folder), CLOCK.tick_nanoseconds), CLOCK.tick_seconds, world_poses, FAR, power)
        world = World(world_poses, history.journal, CLOCK, begin.structure, begin.state, source)
        history.start()
        world.start()
        yield world, history
        world.close()
        history.close()


def run() -> list[Row]:
    """Return the rows."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL_SECONDS)
    try:
        return [*answer_rows(), *tick_rows(), *checkpoint_rows(), *million_rows()]
    finally:
        sys.setswitchinterval(before)


def timed(work: Callable[[], object], count: int) -> NDArray[np.float64]:
    """Return how long each call takes, in milliseconds; (count,)."""
    times = np.empty(count)
    for at in range(count):
        start = time.perf_counter()
        work()
        times[at] = time.perf_counter() - start
    return times * 1e3


def answer_rows() -> list[Row]:
    """Return what the history adds to the answer of a SetSignal, in turn with the world without one."""
    small = world_of(1)
    small.submit([CreateSignal(Signal("s", 0))]).result()
    begin = small.snapshot
    small.close()
    with ExitStack() as stack:
        address, _ = stack.enter_context(echo())
        bare = float(np.median(timed(echoed(address), 1000)))
        worlds = {
            "memory": stack.enter_context(in_memory(begin)),
            "process": stack.enter_context(on_disk(begin))[0],
            "power": stack.enter_context(on_disk(begin, power=True))[0],
        }
        times: dict[str, list[float]] = {name: [] for name in worlds}
        for at in range(ROUNDS):
            for name, world in worlds.items():
                count = CALLS if name != "power" else CALLS // 10
                done = timed(lambda world=world, at=at: world.submit([SetSignal("s", at)]).result(), count)
                times[name].append(float(np.median(done)))
    added = {name: float(np.median(np.subtract(times[name], times["memory"]))) for name in ("process", "power")}
    return [
        row("added to the answer of a SetSignal", added["process"], bare, "grpc.aio echo", "ms, p50", 0.10),
        row("the same, safe from a loss of power", added["power"], bare, "grpc.aio echo", "ms, p50", None),
    ]


def following() -> tuple[Snapshot, list[str]]:
    """Return a world of arms that follow setpoints, and the motions' ids."""
    world = world_of(ARMS)
    world.submit([StopMotions()]).result()
    world.step(2000).result()
    robots = [f"arm{place}" for place in range(ARMS)]
    world.submit([StartSetpointMotion(robot, NAMES, SetpointMode.POSITION, 1e9) for robot in robots]).result()
    begin = world.snapshot
    world.close()
    return begin, [motion.id for motion in begin.state.motions]


def tick_rows() -> list[Row]:
    """Return what a tick costs, with a setpoint for each arm, beside the world without a history."""
    begin, ids = following()
    with in_memory(begin, Inputs(ids)) as bare, on_disk(begin, Inputs(ids)) as (kept, _):
        times: dict[World, list[NDArray[np.float64]]] = {bare: [], kept: []}
        for _ in range(ROUNDS):
            for world, series in times.items():
                series.append(timed(lambda world=world: (world.step(1).result(), time.sleep(0.002)), TICKS) - 2.0)
    ours, peer = np.concatenate(times[kept]), np.concatenate(times[bare])
    rows = []
    for name, share, budget in (("p50", 50, 1.05), ("p99", 99, 1.10)):
        a, b = float(np.percentile(ours, share)), float(np.percentile(peer, share))
        rows.append(row(f"tick, {ARMS} arms following setpoints, {name}", a, b, "without a history", "ms", budget))
    return rows


def checkpoint_rows() -> list[Row]:
    """Return ticks of seconds in which a checkpoint of a large world is made, and what the second one costs.

    Ticks come in real time, each second with a checkpoint after one without; each second has its own p99.
    """
    begin, ids = following()
    with on_disk(begin, Inputs(ids)) as (world, history):

        def checkpoint() -> None:
            history.settle()
            history.upkeep.checkpoint()

        def second() -> float:
            """Return the p99 of the ticks of a second, in milliseconds."""
            times = np.empty(TICKS)
            due = time.perf_counter()
            for at in range(TICKS):
                due += CLOCK.tick_seconds
                time.sleep(max(0.0, due - time.perf_counter()))
                times[at] = timed(lambda: world.step(1).result(), 1)[0]
            return float(np.percentile(times, 99))

        parts = (NodeSpec(f"part {k}", Kind.PART, data=PartData()) for k in range(NODES))
        world.submit([CreateNodes(tuple(parts))]).result()
        world.step(10).result()
        first = timed(checkpoint, 1)[0]
        world.step(10).result()
        history.settle()
        start = time.thread_time()
        history.upkeep.checkpoint()
        again = (time.thread_time() - start) * 1e3
        one = history.store.checkpoint(1)
        assert one is not None
        size = sum(map(len, (one.body, *history.store.parts(one.parts))))
        seconds: list[tuple[float, float]] = []
        for _ in range(ROUNDS):
            quiet = second()
            thread = threading.Thread(target=lambda: (time.sleep(0.3), checkpoint()))
            thread.start()
            seconds.append((second(), quiet))
            thread.join()
    a, b = np.median(seconds, axis=0).tolist()
    note = (
        f"one a second, {ROUNDS} pairs of seconds, medians; the first has {size / 1e6:.1f} MB and took {first:.0f} ms"
    )
    return [
        row("tick of a second with a checkpoint, p99", a, b, "of one without", "ms", 1.25, note),
        row("second checkpoint, of a core", again, 4.0, "the goal", "ms", 1.0),
    ]


def million_rows() -> list[Row]:
    """Return how long a kernel takes to go on from a million entries, and what thinning them out takes."""
    codec = world_codec()
    batch = [codec.encode((SetSignal("s", value),)) for value in range(100)]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Folder(Path(name), CLOCK.tick_nanoseconds)
        history = History(folder, CLOCK.tick_seconds, world_poses, FAR)
        world = World(world_poses, history.journal, CLOCK)
        history.start()
        world.start()
        world.submit([CreateSignal(Signal("s", 0))]).result()
        world.close()
        history.close()
        store = Store(Path(name) / JOURNAL, folder.project.seed)
        for start in range(2, MILLION, 5000):
            store.write([Entry(seq, 0, 0.0, "bench", batch[seq % 100]) for seq in range(start, start + 5000)])
        checkpoint = store.checkpoint(store.checkpoints()[-1].id)
        assert checkpoint is not None
        last = store.last_seq - Rules().entries  # as if one had been made each 50,000 entries
        object.__setattr__(checkpoint, "seq", last)
        store.add_checkpoint(checkpoint, {})
        store.close()
        begin = time.perf_counter()
        history = History(Folder(Path(name)), CLOCK.tick_seconds, world_poses, FAR)
        took = time.perf_counter() - begin
        rows.append(row("going on from a million entries", took, 10.0, "the goal", "s", 1.0))
        slowest, begin = 0.0, time.perf_counter()
        more = True
        while more:
            start = time.perf_counter()
            more = history.store.forget(last, 0)
            slowest = max(slowest, time.perf_counter() - start)
        note = f"{slowest * 1e3:.0f} ms at a time at most"
        took = time.perf_counter() - begin
        rows.append(row("thinning out 950,000 entries", took, 1.0, "the goal for a demo's hour", "s", None, note))
        history.close_files()
    return rows
