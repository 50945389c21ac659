"""The guard: no tick is made from which what moves could not brake before it touches anything.

Of every published state it is known that all that moves could brake now and touch nothing that a guarded robot is of. A
tick is admitted only if that holds of the state after it, too; otherwise motions begin to brake before it, by a command
like any other: first those of the robots that would touch, at last all, and what that leads to is known to be free.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.brake_check import APART, contact_on, distance, pictured
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.collision.guard_commands import check
from virtualrobot_kernel.collision.node_pairs import movers, moves, names_of
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import SweptContact
from virtualrobot_kernel.collision.verified_paths import Unverified, VerifiedPaths
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.braking import HARMLESS, RATES, BrakePath, braking, going, takes_over
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, StopRobots
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot, State, unchanged
from virtualrobot_kernel.world.store import World

LOOKS = 12
"""At so many ticks of a way at the most, the first and the last among them, it is asked whether two come nearer."""

ROUNDING = 1e-9
"""Times (s) and distances (m) that differ by no more than this are the same."""

log = logging.getLogger(__name__)


Floats = NDArray[np.float64]


def _nothing_carried(now: Snapshot, positions: Floats) -> None:
    """Leave all bases where they are."""


@dataclass(frozen=True, slots=True)
class GuardCost:
    """Cost of the guard: how many ticks it has looked at, the seconds of all of them, and the most of one."""

    ticks: int = 0
    seconds: float = 0.0
    worst_seconds: float = 0.0

    def and_tick(self, seconds: float) -> GuardCost:
        """Return the cost with one more tick."""
        return GuardCost(self.ticks + 1, self.seconds + seconds, max(self.worst_seconds, seconds))


@dataclass(frozen=True, slots=True)
class _Threat:
    """Contact that would be: the robots (uids) that move one of the two or carry it, and the words for people."""

    robots: frozenset[int]
    reason: str


class CollisionGuard:
    """A supervisor of a world (`world/supervisor.py`); asked by the world thread alone, but for `cost`.

    What touches already when a robot becomes guarded, or is picked, let go or grasped, is tolerated until it is apart,
    and so is what was put so near that the brake came too late: such pairs are left out of the swept check, but may not
    touch anew once they don't.
    """

    author = "collision guard"

    def __init__(
        self, shapes: CollisionShapes, world: World, carried: Callable[[Snapshot, Floats], None] = _nothing_carried
    ) -> None:
        """Guard from now on what the world says is to be guarded.

        `carried` puts into the coordinates of a brake (m, nq), a row for each tick, where drives take bases.
        """
        self._carried = carried
        self._scene = CollisionScene(shapes)
        self._verified = VerifiedPaths(self._scene)
        self._world = world
        self._oversees = False
        self._robots: frozenset[int] = frozenset()
        self._settings: tuple[object, ...] = ()
        self._seen: tuple[object, ...] = ()
        self._tolerated: frozenset[Pair] = frozenset()
        self._in_touch: frozenset[Pair] = frozenset()
        self._later: tuple[int, frozenset[Pair], frozenset[Pair]] | None = None
        self._touching: tuple[Snapshot, frozenset[Pair]] | None = None
        self.cost = GuardCost()
        world.listen(self._published)

    @property
    def tolerated(self) -> frozenset[Pair]:
        """Return the pairs (uids) that touched before anybody could keep them from it, and are not apart yet."""
        return self._later[1] if self._later else self._tolerated

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Raise KernelError (COLLISION) when commands bring a guarded robot into touch with something.

        Also when a motion that they pause, resume, slow down or speed up could not brake in time then.
        """
        kinds = {type(command) for command in batch}
        if kinds <= HARMLESS and not any(takes_over(command) for command in batch):
            return
        if kinds <= RATES | HARMLESS:
            threat = self._threat(after, None)
            if threat is not None:
                raise KernelError(f"{threat.reason}; the motion goes on as it does", reason=Reason.COLLISION)
            return
        guarded = _guarded(after)
        if not guarded:
            return  # a guard that fails can be ended, too
        self._reach(before)
        touching = self._all_touching(after, guarded)
        self._touching = after, touching
        groups = self._scene.bodies.allowed.groups
        new = [pair for pair in touching - self._tolerated if self._robots & {groups[uid] for uid in pair}]
        check(before, after, batch, new)

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Return the stop without which the tick must not be made; nothing when it may be."""
        robots = going(now.state)
        if not robots:
            return ()  # what brakes already was known to be free when it began to
        begin = time.perf_counter()
        try:
            threat = self._threat(now, later.state)
        except Exception as error:
            log.exception("the guard failed inside the kernel; what moves brakes")
            threat = _Threat(robots, f"the guard failed inside the kernel: {type(error).__name__}")
        self.cost = self.cost.and_tick(time.perf_counter() - begin)
        return [_stop_for(threat.robots & robots or robots, threat)] if threat else ()

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Return the stop that a change of the world asks for: something was put where motions would brake."""
        if not self._changed(now):
            return ()
        self._reach(now)
        touching = self._touching
        self._touching = None
        found = touching[1] if touching and touching[0] is now else self._all_touching(now, self._robots)
        alive = {pair for pair in self._tolerated if all(uid in now.structure.nodes for uid in pair)}
        self._tolerated, self._in_touch, self._later = frozenset(alive | found), found, None
        robots = going(now.state)
        threat = self._threat(now, None) if robots else None
        return [_stop_for(robots, threat)] if threat else ()

    def _published(self) -> None:
        """Oversee the world while a robot is guarded; told in the world thread of all that is published."""
        now = self._world.snapshot
        settings = now.structure, now.state.collisions
        if unchanged(self._settings, settings):
            return
        self._settings = settings
        robots = self._robots = _guarded(now)
        if bool(robots) != self._oversees:
            self._oversees = bool(robots)
            self._tolerated, self._in_touch, self._later, self._seen = frozenset(), frozenset(), None, ()
            (self._world.supervise if robots else self._world.unsupervise)(self)

    def _changed(self, now: Snapshot) -> bool:
        """Return whether there is more in the world than time that goes on since this was asked last."""
        state = now.state
        seen = (now.structure, state.collisions, state.parent_t_node, state.allowed_pairs)
        changed = not unchanged(self._seen, seen)
        self._seen = seen
        return changed or (self._touching is not None and self._touching[0] is now)

    def _all_touching(self, snapshot: Snapshot, robots: frozenset[int]) -> frozenset[Pair]:
        self._scene.place(snapshot)
        return frozenset(self._scene.touching(robots))

    def _threat(self, now: Snapshot, later: State | None) -> _Threat | None:
        """Return what would touch on the way to `later`, if it is not None, and on the brake from there; or None."""
        begin = now.state if later is None else later
        self._reach(now)
        held, touching = self._tolerated, self._in_touch
        unverified = self._verified.unverified(now, later, self._robots, held)
        asked = frozenset(pair for pair in held if unverified.follow(*(now.structure.rows[uid] for uid in pair)))
        motions = unverified.of_motions(begin.motions)
        if not motions and not unverified.groups.any():
            self._later = (begin.tick, held, touching) if later is not None else None
            return None
        way = braking(now.structure, replace(begin, motions=motions), now.tick_seconds, world_poses)
        if not way.ends:
            robots = frozenset(uid for motion in motions for uid in motion.robots)
            return _Threat(robots, "it takes too long to brake for it to be known whether it touches anything")
        self._carried(now, way.positions)
        if later is not None:
            way = way.after(now.structure, now.state, motions)
        unverified.add_reached(way.reached)
        sure = ~unverified.coordinates()
        way.positions[:, sure] = now.state.q[sure]
        if asked:
            parted, touching, anew = self._parted(now, way, asked)
            if anew is not None:
                return self._told(now, anew, now.tick_seconds)
            held -= parted
            for pair in parted:
                unverified.add_pair(*(now.structure.rows[uid] for uid in pair))
        passing: set[Pair] = set()
        while contact := self._contact(now, way, held | passing, unverified):
            pair = contact.first, contact.second
            if pair not in self._tolerated and contact.time <= now.simulation_time + ROUNDING:
                found = self._all_touching(now, self._robots)
                if pair in found:
                    # Something was put where the brake was too late: what touches may go apart.
                    self._tolerated |= found
                    self._in_touch |= found
                    return self._threat(now, later)
            if pair not in self._tolerated and not self._recedes(now, way, contact):
                return self._told(now, pair, contact.time - now.simulation_time)
            if contact.distance > APART:
                passing.add(pair)  # for this tick: it is guarded, and must not be put into touch
            else:
                held |= {pair}
        self._later = (begin.tick, held, touching) if later is not None else None
        return None

    def _contact(
        self, now: Snapshot, way: BrakePath, held: frozenset[Pair], unverified: Unverified
    ) -> SweptContact | None:
        if not unverified.groups.any():
            return None
        return contact_on(self._scene, now, way, self._robots, held, unverified.asked)

    def _reach(self, now: Snapshot) -> None:
        """Take what was found of a tick for true, once it was made."""
        if self._later and self._later[0] == now.state.tick:
            (_, self._tolerated, self._in_touch), self._later = self._later, None

    def _parted(
        self, now: Snapshot, way: BrakePath, asked: frozenset[Pair]
    ) -> tuple[frozenset[Pair], frozenset[Pair], Pair | None]:
        """Return which tolerated pairs are apart after a tick, which touch, and one that touches anew by the way's end.

        Asked are all that may move. What is near and does not touch any more must not touch again.
        """
        after, end = pictured(now, way, min(1, len(way.positions) - 1)), pictured(now, way, -1)
        moving = frozenset(pair for pair in asked if moves(now, after, pair) or moves(now, end, pair))
        if not moving:
            return frozenset(), self._in_touch, None
        self._scene.place(after)
        robots = self._robots & {self._scene.bodies.allowed.groups[uid] for pair in moving for uid in pair}
        touching = self._all_touching(after, robots) & moving
        near = {pair for pair in moving - touching if distance(self._scene, after, pair) <= APART}
        again = touching - self._in_touch
        if near:
            again |= self._all_touching(end, robots) & near - self._in_touch
        return moving - touching - near, self._in_touch - moving | touching, min(again, default=None)

    def _recedes(self, now: Snapshot, way: BrakePath, contact: SweptContact) -> bool:
        """Return whether a contact is of two nodes that stand nearer than can be told apart, and come no nearer.

        How near that is grows with the ticks: the way between two of them is known to a bound only.
        """
        if contact.time > now.simulation_time + ROUNDING or contact.distance == 0.0:
            return False
        pair, reach = (contact.first, contact.second), 2.0 * (contact.distance + APART)
        rows = np.unique(np.linspace(1, max(len(way.positions) - 1, 1), LOOKS).round().astype(int)).tolist()
        return all(
            distance(self._scene, pictured(now, way, row), pair, reach) >= contact.distance - ROUNDING for row in rows
        )

    def _told(self, now: Snapshot, pair: Pair, seconds: float) -> _Threat:
        first, second = names_of(pair, now.structure)
        return _Threat(
            movers(pair, now.structure), f"{first!r} would touch {second!r} in {max(seconds, 0.0):.3f} s if it went on"
        )


def _guarded(snapshot: Snapshot) -> frozenset[int]:
    """Return the guarded robots (uids)."""
    modes = snapshot.state.collisions.modes_of(snapshot.structure)
    return frozenset(uid for uid, mode in modes.items() if mode is CollisionMode.GUARD)


def _stop_for(robots: frozenset[int], threat: _Threat) -> StopRobots:
    return StopRobots(tuple(sorted(robots)), Cancellation(EndCause.COLLISION, threat.reason))
