"""Leases of robots by clients. The API's thread alone changes the table; the world thread reads it by one reference.

Leases are not in the world: they say whose commands are let in, not what is. What their end does to the world (it stops
the robots) is a command like any other, so that a journal replays without them.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from enum import Enum

from virtualrobot_kernel.api.token_table import Role
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.affected_robots import affected_robots
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.listeners import Listeners
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Permit

REMEMBERED = 100
"""Number of ended leases remembered, so that their owners are told why."""

CARRIED: ContextVar[tuple[str, ...]] = ContextVar("CARRIED", default=())
"""Tokens of the leases that the call being served carries; set by the interceptor, for methods that need leases."""


class Loss(Enum):
    """Reason for a lease's loss of robots; the names equal those of `LeaseLoss` in the contract, but for EXPIRED."""

    RELEASED = "released"
    TAKEN = "taken"
    EXPIRED = "expired"


@dataclass(frozen=True, slots=True)
class Lease:
    """Lease of robots: of none once it has ended. `since` is in seconds since 1970, `loss` why it lost robots last."""

    id: str
    token: str
    owner: str
    robots: frozenset[int]
    since: float
    loss: Loss | None = None
    reason: str = ""
    holder: str = ""
    """Name of the token that it was acquired with; "" for the kernel's own."""


@dataclass(frozen=True, slots=True)
class _Table:
    leases: Mapping[str, Lease] = field(default_factory=dict)
    """Leases by token, oldest first, with the last ones that ended."""
    by_robot: Mapping[int, Lease] = field(default_factory=dict)


class LeaseTable:
    """Table of the leases, for the API's thread; only what a permit does may be called from the world thread."""

    def __init__(self) -> None:
        """Begin with no lease."""
        self._table = _Table()
        self._count = 0
        self._listeners: Listeners[[object]] = Listeners()

    @property
    def held(self) -> list[Lease]:
        """Leases that have robots, oldest first."""
        return [lease for lease in self._table.leases.values() if lease.robots]

    def has_leased(self, robot: int) -> bool:
        """Return whether anybody has leased a robot (a uid); for any thread."""
        return robot in self._table.by_robot

    def record(self, token: str) -> Lease:
        """Return a lease, ended ones included; raise KernelError when nothing is known of it."""
        return _record(self._table, token)

    def held_by(self, token: str) -> Lease:
        """Return a lease that has robots; raise KernelError, which tells why it has ended."""
        return _held(self._table, token)

    def acquire(self, snapshot: Snapshot, robots: Collection[int], owner: str, holder: str = "") -> Lease:
        """Lease robots (uids), all or none; raise KernelError, which names who has one of them."""
        self.check(snapshot, robots, ())
        lease = self._made(robots, owner, holder)
        self._publish(lease)
        return lease

    def take(self, robots: Collection[int], owner: str, holder: str = "") -> tuple[Lease, list[Lease]]:
        """Lease robots (uids) whoever had them; return the lease, and those that lost robots as they were before."""
        losers = [lease for lease in self.held if not lease.robots.isdisjoint(robots)]
        reason = f"taken over by {owner!r}"
        left = [replace(one, robots=one.robots.difference(robots), loss=Loss.TAKEN, reason=reason) for one in losers]
        lease = self._made(robots, owner, holder)
        # At once: between two tables the robots would be free.
        self._publish(*left, lease)
        return lease, losers

    def end(self, lease: Lease, loss: Loss, reason: str) -> None:
        """Make the robots of a lease free."""
        self._publish(replace(lease, robots=frozenset(), loss=loss, reason=reason))

    def check(
        self, snapshot: Snapshot, robots: Collection[int], tokens: Sequence[str], leased_only: bool = False
    ) -> None:
        """Raise KernelError when a lease of `tokens` has ended, or one of the robots is leased by none of them.

        With `leased_only` it may not be free either.
        """
        table = self._table
        for token in tokens:
            _held(table, token)
        for uid in robots:
            lease = table.by_robot.get(uid)
            # A robot that was removed has nobody to move it.
            if uid not in snapshot.structure.nodes:
                continue
            name = snapshot.structure.nodes[uid].name
            if lease is None and leased_only:
                raise KernelError(
                    f"an operator moves and changes what the call has leased, and the robot {name!r} is free: lease it",
                    reason=Reason.ROLE_TOO_LOW,
                    robot=name,
                    needs=Role.ENGINEER.word,
                    has=Role.OPERATOR.word,
                )
            if lease is not None and lease.token not in tokens:
                since = datetime.fromtimestamp(lease.since, UTC).isoformat(timespec="seconds")
                raise KernelError(
                    f"the robot {name!r} is leased by {lease.owner!r} since {since}; wait for its release, or take it",
                    reason=Reason.LEASED,
                    robot=name,
                    owner=lease.owner,
                    since=since,
                    lease=lease.id,
                )

    def permit(self, tokens: Sequence[str], leased_only: bool = False) -> Permit:
        """Return what lets those commands into the world that a call with these leases may give; as `check`."""

        def check(snapshot: Snapshot, commands: Sequence[Command]) -> None:
            if tokens or leased_only or self._table.by_robot:
                self.check(snapshot, affected_robots(snapshot, commands), tokens, leased_only)

        return check

    def subscribe(self, listener: Callable[[object], None]) -> Callable[[], None]:
        """Call `listener` after each change, until the returned function is called."""
        return self._listeners.add(listener)

    def _made(self, robots: Collection[int], owner: str, holder: str) -> Lease:
        self._count += 1
        id, token = f"lease-{self._count}", secrets.token_urlsafe(16)
        return Lease(id, token, owner, frozenset(robots), time.time(), holder=holder)

    def _publish(self, *changed: Lease) -> None:
        """Publish a table with these leases as they are now, and without those that ended long ago."""
        leases = {**self._table.leases, **{lease.token: lease for lease in changed}}
        ended = [token for token, other in leases.items() if not other.robots]
        for token in ended[:-REMEMBERED]:
            del leases[token]
        self._table = _Table(leases, {uid: other for other in leases.values() for uid in other.robots})
        self._listeners.tell(changed)


def _record(table: _Table, token: str) -> Lease:
    lease = table.leases.get(token)
    if lease is None:
        raise KernelError(
            "the call names a lease that there is not, or that ended long ago; acquire one",
            reason=Reason.LEASE_ENDED,
            cause="unknown",
        )
    return lease


def _held(table: _Table, token: str) -> Lease:
    lease = _record(table, token)
    if not lease.robots:
        raise KernelError(
            f"the lease {lease.id!r} of {lease.owner!r} has ended: {lease.reason}; acquire another one",
            reason=Reason.LEASE_ENDED,
            lease=lease.id,
            owner=lease.owner,
            cause=lease.loss.value if lease.loss else "",
            loss=lease.reason,
        )
    return lease
