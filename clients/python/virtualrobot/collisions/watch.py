"""Reports of the collision monitor: collisions now, and events."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot._wire.messages import Stamp, stamp_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot.collisions.values import Collision, collision_of, where
from virtualrobot.v1 import collision_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ReportedCollision:
    """Two nodes that touch and may not.

    Attributes:
        collision: the nodes, and the points and depth when it began.
        tolerated: true where they touched already when watching them began; this stops nothing.
        tick: the tick in which it began, or the watching did, and `simulation_time` the same in seconds.
    """

    collision: Collision
    tolerated: bool
    tick: int
    simulation_time: float


@shown
@dataclass(frozen=True, slots=True, eq=False)
class CollisionEvent:
    """Event of the collision monitor in a tick; as a text it is a line for people.

    Attributes:
        kind: `begun`: two nodes begin to touch; `ended`: they touch no more; `stopped`: robots were stopped; `fault`:
            checks fail from now on, or, without a reason, succeed again.
        tick: the tick of the event, and `simulation_time` the same in seconds.
        begun: the nodes that begin to touch; None for other kinds.
        nodes: the names of the two nodes; empty where it is not about two.
        apart: of nodes that ended, true where they are apart; else they are not watched any more.
        robots: the names of robots that were stopped, and `motion_ids` the motions that were cancelled.
        reason: the reason for which robots were stopped, or checks fail.
    """

    kind: str
    tick: int
    simulation_time: float
    begun: ReportedCollision | None = None
    nodes: tuple[str, ...] = ()
    apart: bool = False
    robots: tuple[str, ...] = ()
    motion_ids: tuple[str, ...] = ()
    reason: str = ""

    def __str__(self) -> str:
        """Return a line for people."""
        return f"{self.simulation_time:.3f} s  {self._words()}"

    def _words(self) -> str:
        if self.kind == "stopped":
            return f"{', '.join(self.robots)} stopped: {self.reason}"
        if self.kind == "fault":
            return self.reason or "collisions are checked again"
        pair = " and ".join(self.nodes)
        if self.begun is None:
            return f"{pair} are apart" if self.apart else f"{pair} are not watched any more"
        return f"{pair} touch{' already' if self.begun.tolerated else ''}{where(self.begun.collision)}"


@shown
@dataclass(frozen=True, slots=True, eq=False)
class CollisionReport:
    """Report of the collision monitor: collisions now, and events since the report before.

    Attributes:
        stamp: the instant of the world that was checked last.
        touching: all that touches and may not, of robots whose mode is not off; where, only the first report tells.
        events: the events, the oldest first; none in the first report.
        missed_events: number of older events that are not told, since there were more than 1,000.
        fault: the reason for which the last check failed; empty where it did not.
        checks: number of checks.
        check_time: the time that these took together.
    """

    stamp: Stamp
    touching: tuple[ReportedCollision, ...]
    events: tuple[CollisionEvent, ...]
    missed_events: int
    fault: str
    checks: int
    check_time: float


def watch_collisions(services: Services) -> Iterator[CollisionReport]:
    """Yield what touches now, and then what begins and ends as it happens."""
    with services.collision.WatchCollisions(collision_pb2.WatchCollisionsRequest()) as stream:
        for message in stream:
            yield CollisionReport(
                stamp_of(message.stamp),
                tuple(map(_reported, message.touching)),
                tuple(map(event_of, message.events)),
                message.missed_events,
                message.fault,
                message.checks,
                message.check_seconds,
            )


def _reported(message: collision_pb2.ReportedCollision) -> ReportedCollision:
    return ReportedCollision(
        collision_of(message.pair), message.tolerated, message.tick, message.simulation_time_seconds
    )


def event_of(message: collision_pb2.CollisionEvent) -> CollisionEvent:
    """Return the event that a message tells."""
    kind = message.WhichOneof("what") or ""
    when = message.tick, message.simulation_time_seconds
    if kind == "begun":
        begun = _reported(message.begun)
        return CollisionEvent(kind, *when, begun=begun, nodes=(begun.collision.first, begun.collision.second))
    if kind == "ended":
        return CollisionEvent(kind, *when, nodes=(message.ended.first, message.ended.second), apart=message.ended.apart)
    if kind == "stopped":
        stopped = message.stopped
        return CollisionEvent(
            kind,
            *when,
            robots=tuple(stopped.robots),
            motion_ids=tuple(stopped.motion_ids),
            reason=stopped.reason,
        )
    return CollisionEvent(kind, *when, reason=message.fault)
