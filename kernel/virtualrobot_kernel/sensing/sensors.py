"""All sensors of the world at work: who reads, when each reading is due, and the latest of each."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from dataclasses import fields
from functools import partial

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing.cpu_slots import CpuSlots
from virtualrobot_kernel.sensing.readers import READERS, SensingRoom
from virtualrobot_kernel.sensing.reading import Reader, Reading, SensorState
from virtualrobot_kernel.sensing.schedule import Instant, Schedule
from virtualrobot_kernel.sensing.sensor_worker import SensorWorker
from virtualrobot_kernel.sensing.settings import rate_hertz
from virtualrobot_kernel.world.apply_sensors import sensor_node, sensor_nodes
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.sensing import CameraSensor, ContactSensor, MotionSensor, RangeSensor, Sensor
from virtualrobot_kernel.world.state import SensorStart, Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, Node, Structure

LONGEST_HISTORY_SECONDS = 1.0
"""Past (s) that is kept while it is not known yet how much a sensor that starts needs."""

MOST_RUNNING = 200
"""Largest number of sensors that run at once: each has a thread."""

MOST_IDLE = 50
"""So many sensors that do not run stay ready for the next single reading, with their threads and processes."""

MOST_SHORT = 2
"""So many motion sensors read at once. Each reading is short and mostly the interpreter's: measured, 200 threads that
all wanted it left the world 19 ticks a second instead of 250."""

UNUSED_SHAPES = 100
"""Number of shapes of figures that are gone which are kept, besides as many as there are."""

Listener = Callable[[Reading | None], None]


class Sensors:
    """Has a worker for each sensor that runs, or was asked for a reading since it was changed last.

    The world thread tells it each structure, which sensors run and, while some do, each tick; it notes what is due and
    goes on. In STEPPED mode it waits there for each sensor in the order of the nodes. Readings are told to listeners by
    the sensors' threads, and None when a sensor is gone; listeners must return at once.
    """

    def __init__(self, world: World, room: SensingRoom) -> None:
        """Look after the sensors of `world` from now on."""
        self._world, self.room = world, room
        self.workers: Mapping[int, SensorWorker] = {}
        """By uid; replaced, never changed."""
        self.latest: Mapping[int, Reading] = {}
        """The last reading of each sensor that was started, by uid; replaced, never changed."""
        self._structure: Structure | None = None
        self.starts: Mapping[int, SensorStart] = {}
        """Start of each sensor that reads (by uid): those of the world, and those that somebody watches."""
        self._started_by_world: Mapping[int, SensorStart] = {}
        self._watches: Mapping[object, frozenset[int]] = {}
        self._followed_watches = self._watches
        self._watch_starts: dict[int, SensorStart] = {}
        self._watch_count = 0
        self._epoch = world.snapshot.state.epoch
        self._running: tuple[SensorWorker, ...] = ()
        self._asked: dict[int, int] = {}
        self._history: tuple[Snapshot, ...] = ()
        self._listeners: Listeners[[Reading | None]] = Listeners()
        self._lock = threading.Lock()
        self._telling = threading.Lock()
        self._closed = False
        # Motion sensors are read in no time and often: they wait behind no picture, and few of them wake at once.
        # Who reads quickly has turns of his own: a lidar would else read as seldom as a camera beside it.
        self._turns, self._quick_turns, self._short_turns = CpuSlots(), CpuSlots(), CpuSlots(MOST_SHORT)
        self._most_shapes = UNUSED_SHAPES
        # Starting a thread waits for it, and forgetting shapes takes long: not in the world thread.
        self._chores: queue.SimpleQueue[SensorWorker | Structure | None] = queue.SimpleQueue()
        self._helper = threading.Thread(target=self._do_chores, name="sensors", daemon=True)
        self._helper.start()
        self._end_ticks: Callable[[], None] = lambda: None
        self._published()
        self._end_publications = world.listen(self._published)

    def close(self) -> None:
        """End all sensors; none starts any more."""
        self._closed = True
        self._end_publications()
        self._end_ticks()
        self._chores.put(None)
        self._helper.join(10.0)
        for worker in self.workers.values():
            worker.end()
        for worker in self.workers.values():
            worker.join(2.0)

    def subscribe(self, listener: Listener) -> Callable[[], None]:
        """Have `listener` called with each new reading of any sensor; call what this returns to end that."""
        return self._listeners.add(listener)

    def run_for(self, uids: Iterable[int]) -> tuple[Future[Snapshot], Callable[[], None]]:
        """Have sensors read at their rates for somebody, whether the world has them read or not.

        Returns what is done once they do, and what ends it; who reads for others goes on.
        """
        key = object()
        with self._lock:
            self._watches = {**self._watches, key: frozenset(uids)}
        begun = self._world.between_ticks(self._published)

        def end() -> None:
            with self._lock:
                self._watches = {other: kept for other, kept in self._watches.items() if other is not key}
            self._world.between_ticks(self._published)

        return begun, end

    def read(self, name: str, kinds: object | None = None) -> tuple[SensorWorker, Future[Reading]]:
        """Have one reading made of the world as it is now, whether the sensor runs or not.

        Returns who makes it, and the reading to come; that raises KernelError where it cannot be made. Raises
        UnknownNameError for a sensor that there isn't.
        """
        snapshot = self._world.snapshot
        node = sensor_node(snapshot.structure, name)
        with self._lock:
            number = self._asked[node.uid] = self._asked.get(node.uid, 0) + 1
            worker = self.workers.get(node.uid)
            if worker is None or (worker.ended and worker.schedule is None):
                worker = self._worker(node, None)
                self.workers = {**self._spared(), node.uid: worker}
            return worker, worker.ask(Instant(snapshot, self._history), number, kinds)

    def _spared(self) -> Mapping[int, SensorWorker]:
        """Return the workers without the oldest of too many that do not run; those end."""
        idle = [uid for uid, one in self.workers.items() if one.schedule is None]
        ended = set(idle[: max(len(idle) - MOST_IDLE + 1, 0)])
        for uid in ended:
            self.workers[uid].end()
        return {uid: one for uid, one in self.workers.items() if uid not in ended}

    def _published(self) -> None:
        """Follow changes of the structure and of what runs; called by the world thread after each snapshot."""
        snapshot, watches = self._world.snapshot, self._watches
        anew = snapshot.state.epoch != self._epoch
        same = self._structure is snapshot.structure and self._started_by_world is snapshot.state.running_sensors
        if (same and self._followed_watches is watches and not anew) or self._closed:
            return
        self._structure, self._epoch, self._followed_watches = snapshot.structure, snapshot.state.epoch, watches
        self._started_by_world = snapshot.state.running_sensors
        starts, self.starts = self.starts, self._starts_of(snapshot, watches)
        now = self.starts
        if anew:
            self._history = ()
        with self._lock:
            old, workers = self.workers, {}
            for node in sensor_nodes(snapshot.structure):
                count = sum(one.schedule is not None for one in workers.values())
                begun = starts.get(node.uid) != now.get(node.uid)
                before = None if anew else old.get(node.uid)
                worker = self._followed(before, node, snapshot, begun, count)
                if worker is not None:
                    workers[node.uid] = worker
            self.workers = workers
            self._asked = {uid: count for uid, count in self._asked.items() if uid in snapshot.structure.nodes}
        for uid, worker in old.items():
            if workers.get(uid) is not worker:
                worker.end()
                node = snapshot.structure.nodes.get(uid)
                if worker.schedule is not None and node is not None and uid not in now:
                    self._tell(worker.silent(snapshot, SensorState.STOPPED))
        self._forget(snapshot.structure)
        if self._shapes_kept() > self._most_shapes:
            self._chores.put(snapshot.structure)
        self._run(tuple(one for one in workers.values() if one.schedule is not None), snapshot)

    def _starts_of(self, snapshot: Snapshot, watches: Mapping[object, frozenset[int]]) -> Mapping[int, SensorStart]:
        """Return the starts of the world's sensors, and of those that somebody watches: their numbers are below 0."""
        watched = frozenset().union(*watches.values()) & snapshot.structure.nodes.keys()
        self._watch_starts = {uid: start for uid, start in self._watch_starts.items() if uid in watched}
        for uid in sorted(watched - self._watch_starts.keys()):
            self._watch_count += 1
            self._watch_starts[uid] = SensorStart(-self._watch_count, snapshot.state.tick)
        return {**self._watch_starts, **snapshot.state.running_sensors}

    def _followed(
        self, worker: SensorWorker | None, node: Node, snapshot: Snapshot, begun: bool, running: int
    ) -> SensorWorker | None:
        """Return the worker of a sensor after a change: the same, another one, or none; `begun`: or stopped."""
        if worker is None or worker.node is not node or begun:
            same = worker is not None and not worker.fault and _unchanged(worker.node, node)
            wanted, at_work = (
                node.uid in self.starts,
                worker is not None and worker.schedule is not None,
            )
            if worker is None or not same or wanted != at_work:
                return self._started(node, snapshot, worker, running) if wanted else None
            worker.node = node
        return worker

    def _started(self, node: Node, snapshot: Snapshot, before: SensorWorker | None, running: int) -> SensorWorker:
        """Return a new worker that reads at its rate; the readings of one that was well go on to be counted."""
        rate, fault = 1.0, ""
        try:
            rate = rate_hertz(data_of(node), self.room.presets)
        except KernelError as error:
            fault = str(error)
        if running >= MOST_RUNNING:
            fault = f"{MOST_RUNNING} sensors run already; stop some of them first"
        # By the state alone: so a kernel that goes on after another one gives the same readings as that would have.
        start = self.starts[node.uid].tick
        schedule = Schedule(start, max(1.0, 1.0 / (rate * snapshot.tick_seconds)))
        schedule.due(snapshot.state.tick)
        first = schedule.count if before is None or not before.fault else 0
        if before is not None and (before.schedule is None or before.fault):
            before = None
        return self._worker(node, schedule, before, fault, first)

    def _worker(
        self,
        node: Node,
        schedule: Schedule | None,
        before: SensorWorker | None = None,
        fault: str = "",
        first: int = 0,
    ) -> SensorWorker:
        short = node.kind is Kind.MOTION_SENSOR
        turns = (self._short_turns, self._short_turns) if short else (self._quick_turns, self._turns)
        made = partial(self._make, node)
        worker = SensorWorker(node, made, self._tell, self._now, turns, self._waits, schedule, before, first)
        if fault:
            worker.give_up(fault)
        else:
            self._chores.put(worker)
        return worker

    def _make(self, node: Node) -> Reader:
        if node.kind not in READERS:
            raise KernelError(f"this kernel has no reader for a {node.kind.value}")
        return READERS[node.kind](self._now(), node, self.room)

    def _now(self) -> Snapshot:
        return self._world.snapshot

    def _waits(self) -> bool:
        """Return whether time waits for readings: where it goes by steps."""
        return self._world.clock.mode is Mode.STEPPED

    def _do_chores(self) -> None:
        while (chore := self._chores.get()) is not None:
            if isinstance(chore, SensorWorker):
                chore.start()
            elif self._shapes_kept() > self._most_shapes:
                used = {figure.geometry for node in chore.nodes.values() for figure in node.figures}
                self.room.solids.keep(used)
                self.room.shapes.keep(used)
                self._most_shapes = 2 * self._shapes_kept() + UNUSED_SHAPES

    def _shapes_kept(self) -> int:
        return max(len(self.room.shapes), len(self.room.solids))

    def _run(self, running: tuple[SensorWorker, ...], snapshot: Snapshot) -> None:
        """Have these sensors told each tick from now on."""
        before, self._running = self._running, running
        if running and not before:
            self._end_ticks = self._world.listen_ticks(self._ticked)
        elif before and not running:
            self._end_ticks()
            self._history = ()
        if running:
            self._keep(snapshot)

    def _ticked(self, snapshot: Snapshot) -> None:
        """Have what is due read; called by the world thread each tick, while sensors run."""
        instant = Instant(snapshot, self._history)
        for worker in self._running:
            worker.tick(instant)
        self._keep(snapshot)
        if self._world.clock.mode is Mode.STEPPED:
            for worker in self._running:
                worker.settle()

    def _keep(self, snapshot: Snapshot) -> None:
        """Keep as much of the past as the sensors that run need, this snapshot as its last."""
        needs = [worker.history_seconds for worker in self._running]
        longest = max((LONGEST_HISTORY_SECONDS if one is None else one for one in needs), default=0.0)
        oldest = snapshot.state.tick - math.ceil(longest / snapshot.tick_seconds - 1e-6)
        if longest == 0.0:
            self._history = ()
            return
        kept = self._history
        first = next((i for i, one in enumerate(kept) if one.state.tick >= oldest), len(kept))
        end = len(kept) - 1 if kept and kept[-1].state.tick == snapshot.state.tick else len(kept)
        self._history = (*kept[first:end], snapshot)

    def _tell(self, reading: Reading) -> None:
        with self._telling:
            self.latest = {**self.latest, reading.uid: reading}
        self._listeners.tell(reading)

    def _forget(self, structure: Structure) -> None:
        """Forget sensors that are gone, and say so."""
        if all(uid in structure.nodes for uid in self.latest):
            return
        with self._telling:
            self.latest = {uid: one for uid, one in self.latest.items() if uid in structure.nodes}
        self._listeners.tell(None)


def data_of(node: Node) -> Sensor:
    """Return how a sensor is set."""
    assert isinstance(node.data, RangeSensor | CameraSensor | ContactSensor | MotionSensor)
    return node.data


def _unchanged(before: Node, after: Node) -> bool:
    """Return whether a sensor is set as before and still in its place of the tree."""
    old, new = data_of(before), data_of(after)
    same = type(old) is type(new) and all(getattr(old, one.name) is getattr(new, one.name) for one in fields(old))
    return same and before.parent == after.parent and before.kind is after.kind
