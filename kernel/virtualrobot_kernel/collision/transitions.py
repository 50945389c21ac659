"""From one check to the next: which touches begin and end, and whom they stop. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from virtualrobot_kernel.collision.allowed import AllowedPairs, Pair
from virtualrobot_kernel.collision.node_pairs import movers, names_of
from virtualrobot_kernel.world.collisions import STOPPING, CollisionMode
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Structure


@dataclass(frozen=True, slots=True, eq=False)
class Scope:
    """Pairs that a check asks.

    Attributes:
        modes: of each robot (uid) that is watched, what is done about its collisions.
        bodies: the nodes (uids) that can collide.
        allowed: what may touch.
    """

    modes: Mapping[int, CollisionMode] = field(default_factory=dict)
    bodies: Collection[int] = ()
    allowed: AllowedPairs = field(default_factory=lambda: AllowedPairs({}, {}, {}))

    def asks(self, pair: Pair) -> bool:
        """Return whether a pair of nodes (uids) is asked."""
        one, other = pair
        return (
            one in self.bodies
            and other in self.bodies
            and bool(self.modes_of(pair))
            and self.allowed.why(one, other) is None
        )

    def modes_of(self, pair: Pair) -> set[CollisionMode]:
        """Return what is done about collisions of the robots of a pair that are watched."""
        groups = self.allowed.groups
        return {self.modes[groups[uid]] for uid in pair if groups[uid] in self.modes}


@dataclass(frozen=True, slots=True)
class RobotStop:
    """Robots (uids) that are to stop, and why in words; `by`: the robots whose mode wants that."""

    robots: tuple[int, ...]
    reason: str
    by: frozenset[int]


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """Pairs that touch anew, and whether that is tolerated; pairs that no longer do, and whether they are apart."""

    begun: Mapping[Pair, bool]
    ended: Mapping[Pair, bool]


def watched(snapshot: Snapshot) -> dict[int, CollisionMode]:
    """Return what is done about collisions of each robot (uid) that is watched: those that are not OFF."""
    settings = snapshot.state.collisions
    if settings.mode is CollisionMode.OFF and not settings.modes:
        return {}
    modes = settings.modes_of(snapshot.structure)
    return {uid: mode for uid, mode in modes.items() if mode is not CollisionMode.OFF}


def transitions(before: Scope, touching: Collection[Pair], now: Scope, found: Iterable[Pair]) -> Transitions:
    """Return what has changed between two checks.

    What touches is tolerated when the check before did not ask the pair: it touched when the watching of it began.

    Args:
        before: what the check before asked.
        touching: what it found.
        now: what this check asks.
        found: what it found.
    """
    found = set(found)
    return Transitions(
        {pair: not before.asks(pair) for pair in sorted(found.difference(touching))},
        {pair: now.asks(pair) for pair in touching if pair not in found},
    )


def stop_of(pair: Pair, scope: Scope, structure: Structure) -> RobotStop | None:
    """Return whom a touch that begins stops: all robots that move one of the nodes; None where no mode wants that."""
    groups = scope.allowed.groups
    by = frozenset(groups[uid] for uid in pair if scope.modes.get(groups[uid]) in STOPPING)
    if not by:
        return None
    first, second = names_of(pair, structure)
    return RobotStop(tuple(sorted(movers(pair, structure))), f"{first!r} touches {second!r}", by)
