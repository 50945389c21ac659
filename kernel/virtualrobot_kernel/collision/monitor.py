"""The collision monitor: tells what touches and may not whenever something has moved, and stops robots for it.

It looks ahead, too, where the settings say so: then it stops robots before they touch (`collision/ahead.py`).
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from virtualrobot_kernel.collision.ahead import LookAhead
from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.bodies import made_of
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.node_pairs import names_of
from virtualrobot_kernel.collision.report import REMEMBERED, Ended, Event, Failed, Report, Stopped, Touch, What, thinned
from virtualrobot_kernel.collision.scene import Collision, CollisionScene, Detail
from virtualrobot_kernel.collision.transitions import RobotStop, Scope, stop_of, transitions, watched
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.collisions import STOPPING
from virtualrobot_kernel.world.commands import Command, StopRobots
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Snapshot, unchanged
from virtualrobot_kernel.world.store import World

PERIOD_SECONDS = 0.02
"""The least time from one check to the next where time follows the wall clock."""

AHEAD_SECONDS = 0.01
"""After how long looking ahead gives way to the next check where time follows the wall clock; then it goes on."""

PATIENCE_SECONDS = 0.1
"""Interval (s) at which the world, while it waits for a check, looks whether the thread is still there."""

Listener = Callable[[Report], None]

log = logging.getLogger(__name__)


class Monitor:
    """Owns the thread that checks; it sleeps while nothing moves, and while no robot is watched.

    In REALTIME it checks the newest snapshot, at most every `PERIOD_SECONDS`. In STEPPED the world waits for the check
    of each tick and each change. Robots are stopped in the world thread, between two ticks.
    """

    author = "collision monitor"

    def __init__(self, world: World, shapes: CollisionShapes) -> None:
        """Watch over `world` from now on, as far as its collision settings say so."""
        self._world, self._shapes = world, shapes
        self.latest = Report(world.snapshot)
        """Report of the last check; replaced, never changed."""
        self._scene: CollisionScene | None = None
        self._ahead = LookAhead()
        self._scope = Scope()
        self._checked: Snapshot | None = None
        self._stops: tuple[RobotStop, ...] = ()
        self._held: list[tuple[int, float, What]] | None = None
        self._listeners: Listeners[[Report]] = Listeners()
        self._telling = threading.Lock()
        self._newest = self._seen = world.snapshot
        self._asked: tuple[Snapshot, threading.Event] | None = None
        self._wake = threading.Event()
        self._ended = False
        self._supervising = False
        self._stopped: frozenset[str] = frozenset()
        self._past: Sequence[Motion] = world.snapshot.state.ended
        self._thread = threading.Thread(target=self._run, name="monitor", daemon=True)
        self._thread.start()
        self._end_listening = world.listen(self._published)

    def close(self) -> None:
        """End the thread; nothing is checked any more."""
        self._end_listening()
        self._world.unsupervise(self)
        self._ended = True
        self._wake.set()
        self._thread.join(10.0)

    def subscribe(self, listener: Listener) -> Callable[[], None]:
        """Have `listener` called whenever something happened; call what this returns to end that."""
        return self._listeners.add(listener)

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Let all be."""

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Want nothing: the monitor looks at what is."""
        return ()

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Have the world checked when something has moved, and return what stops the robots that it found to touch."""
        before, stepped = self._newest, self._world.clock.mode is Mode.STEPPED
        if _differ(before, now) or (stepped and self._seen is not before):
            self._newest = now
            if stepped:
                self._settle(now)
            elif before is self._seen:
                self._wake.set()
        with self._telling:
            stops, self._stops = self._stops, ()
        if not watched(now):
            self._supervising = False
            self._world.unsupervise(self)
            return ()
        self._tell_stopped(now)
        return self._commands(stops, now)

    def _published(self) -> None:
        """Oversee the world once a robot is watched; called by the world thread after each snapshot."""
        now = self._world.snapshot
        if not self._supervising and watched(now):
            self._supervising = True
            self._world.supervise(self)

    def _settle(self, now: Snapshot) -> None:
        """Wait until a snapshot is checked."""
        done = threading.Event()
        self._asked = now, done
        self._wake.set()
        while not done.wait(PATIENCE_SECONDS) and self._thread.is_alive():
            pass

    def _commands(self, stops: Sequence[RobotStop], now: Snapshot) -> list[Command]:
        """Return the commands for these stops, as far as something runs that they stop and its mode still wants it."""
        commands: list[Command] = []
        stopped: list[What] = []
        modes = watched(now) if stops else {}
        going = [motion for motion in now.state.motions if not motion.running.ended and motion.cancellation is None]
        for stop in stops:
            own = [motion for motion in going if not set(stop.robots).isdisjoint(motion.robots)]
            if not own or not any(modes.get(uid) in STOPPING for uid in stop.by):
                continue
            going = [motion for motion in going if motion not in own]
            commands.append(StopRobots(stop.robots, Cancellation(EndCause.COLLISION, stop.reason)))
            stopped.append(_stopped(own, now, stop.reason))
            self._remember(now, {motion.id for motion in own})
        if stopped:
            self._tell(now, stopped)
        return commands

    def _tell_stopped(self, now: Snapshot) -> None:
        """Tell of motions that somebody else has stopped because of collisions: the guard."""
        before, self._past = self._past, now.state.ended
        there = now.state.motions if now.state.ended is before else (*now.state.motions, *now.state.ended)
        reasons: dict[str, list[Motion]] = {}
        for motion in there:
            why = motion.cancellation
            if why is not None and why.cause is EndCause.COLLISION and motion.id not in self._stopped:
                reasons.setdefault(why.reason, []).append(motion)
        if reasons:
            self._remember(now, {motion.id for motions in reasons.values() for motion in motions})
            self._tell(now, [_stopped(motions, now, reason) for reason, motions in reasons.items()])

    def _remember(self, now: Snapshot, stopped: Collection[str]) -> None:
        """Remember whose stop was told, as long as the world remembers the motions (ids)."""
        there = {motion.id for motion in (*now.state.motions, *now.state.ended)}
        self._stopped = self._stopped & there | frozenset(stopped)

    def _run(self) -> None:
        due = 0.0
        while not self._ended:
            pending = self._newest is not self._seen
            self._wake.wait(max(due - time.monotonic(), 0.0) if pending else None)
            self._wake.clear()
            if self._ended:
                break
            if self._asked is not None:
                (snapshot, done), self._asked = self._asked, None
                self._seen = snapshot
                self._check(snapshot)
                done.set()
            elif self._newest is not self._seen and time.monotonic() >= due:
                self._seen = snapshot = self._newest
                due = time.monotonic() + PERIOD_SECONDS
                self._check(snapshot)

    def _check(self, snapshot: Snapshot) -> None:
        """Check a snapshot and tell what has changed; a check that fails stops who is to be stopped, to be safe."""
        if self._checked is not None and not _differ(self._checked, snapshot, closely=True):
            return
        began = time.perf_counter()
        try:
            happened, touching, stops = self._compared(snapshot)
            fault = ""
        except Exception as error:
            fault = f"collisions cannot be checked: {type(error).__name__}: {error}"
            happened, touching, stops = [], self.latest.touching, _all_stopped(snapshot, fault)
            self._scene = None
            if fault != self.latest.fault:
                log.exception("collisions cannot be checked")
        self._checked = None if fault else snapshot
        if fault != self.latest.fault:
            happened.append(Failed(fault))
        seconds, checks = self.latest.seconds + time.perf_counter() - began, self.latest.checks + 1
        self._tell(
            snapshot, happened, snapshot=snapshot, touching=touching, fault=fault, checks=checks, seconds=seconds
        )
        with self._telling:
            self._stops = (*self._stops, *stops) if watched(snapshot) else ()

    def _compared(self, snapshot: Snapshot) -> tuple[list[What], tuple[Touch, ...], list[RobotStop]]:
        """Return what has happened since the check before, what touches now, and whom what is to come stops.

        Who touches is stopped already.
        """
        modes = watched(snapshot)
        touches: dict[Pair, Touch] = {(one.pair.first, one.pair.second): one for one in self.latest.touching}
        scope, found = Scope(), frozenset[Pair]()
        if modes:
            scene = self._scene = self._scene or CollisionScene(self._shapes)
            scene.place(snapshot)
            bodies = scene.bodies
            scope = Scope(modes, bodies.elements.keys(), bodies.allowed)
            found = frozenset(scene.touching(modes.keys()))
        changed = transitions(self._scope, touches.keys(), scope, found)
        happened: list[What] = [Ended(touches.pop(pair), apart) for pair, apart in changed.ended.items()]
        structure = snapshot.structure
        stopping = (stop_of(pair, scope, structure) for pair, tolerated in changed.begun.items() if not tolerated)
        # Before contacts and depths are known: with meshes these take ten times as long as finding the pairs.
        self._stop_at_once([stop for stop in stopping if stop])
        for pair, collision in self._contacts(changed.begun.keys(), modes.keys()).items():
            when, names = (snapshot.state.tick, snapshot.simulation_time), names_of(pair, structure)
            touches[pair] = Touch(thinned(collision), names, *when, changed.begun[pair])
            happened.append(touches[pair])
        ahead = self._ahead.look(self._scene, snapshot, found, self._enough()) if self._scene is not None else None
        self._scope = scope
        return happened, tuple(touches[pair] for pair in sorted(touches)), [ahead] if ahead else []

    def _stop_at_once(self, stops: Sequence[RobotStop]) -> None:
        """Have robots stopped while the check goes on; that is told after it."""
        if stops:
            with self._telling:
                self._stops, self._held = (*self._stops, *stops), []

    def _enough(self) -> Callable[[], bool]:
        """Return what tells when to look ahead no longer; in STEPPED mode the world waits for all of it."""
        end = time.monotonic() + AHEAD_SECONDS
        return lambda: self._world.clock.mode is not Mode.STEPPED and time.monotonic() > end

    def _contacts(self, pairs: Collection[Pair], robots: Collection[int]) -> dict[Pair, Collision]:
        """Return where pairs touch."""
        if not pairs or self._scene is None:
            return {}
        told = self._scene.collisions(Detail.CONTACTS, robots, pairs)
        return {pair: Collision(*pair) for pair in pairs} | {(one.first, one.second): one for one in told}

    def _tell(self, now: Snapshot, happened: Sequence[What], **changed: Any) -> None:  # noqa: ANN401 fields of a report
        """Replace the report, and tell listeners what has happened in a tick.

        `changed` ends a check: what robots were stopped for in the middle of it is told then, after what it found.
        """
        new = [(now.state.tick, now.simulation_time, what) for what in happened]
        with self._telling:
            if changed:
                new, self._held = [*new, *(self._held or ())], None
            elif self._held is not None:
                self._held.extend(new)
                return
            latest = self.latest
            numbered = (Event(number, *what) for number, what in enumerate(new, latest.event_count + 1))
            events, count = (*latest.events, *numbered)[-REMEMBERED:], latest.event_count + len(new)
            self.latest = replace(latest, **changed, events=events, event_count=count)
        if new:
            self._listeners.tell(self.latest)


def _differ(before: Snapshot, now: Snapshot, closely: bool = False) -> bool:
    """Return whether something has moved or is checked otherwise; `closely`: places are compared, not only asked for.

    A motion that waits makes new arrays of equal places.
    """
    old, new = before.world_t_node, now.world_t_node
    return (
        before.state.collisions is not now.state.collisions
        or not unchanged(made_of(before), made_of(now))
        or not (old is new or (closely and np.array_equal(old, new)))
    )


def _stopped(motions: Sequence[Motion], now: Snapshot, reason: str) -> Stopped:
    nodes = now.structure.nodes
    robots = dict.fromkeys(nodes[uid].name for motion in motions for uid in motion.robots if uid in nodes)
    return Stopped(tuple(robots), tuple(motion.id for motion in motions), reason)


def _all_stopped(snapshot: Snapshot, reason: str) -> list[RobotStop]:
    """Return what stops all robots whose collisions are to stop them."""
    robots = tuple(uid for uid, mode in watched(snapshot).items() if mode in STOPPING)
    return [RobotStop(robots, reason, frozenset(robots))] if robots else []
