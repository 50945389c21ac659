"""LeaseService: acquire, take, keep alive, release."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Sequence
from contextlib import aclosing

from google.protobuf.timestamp_pb2 import Timestamp
from virtualrobot.v1 import lease_pb2, lease_pb2_grpc

from virtualrobot_kernel.api.author import author, person
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.lease_table import Lease, Loss
from virtualrobot_kernel.api.token_table import CALLER, Account
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.world.commands import StopRobots
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot

GRACE_SECONDS = 1.0
"""Lifetime of a lease that no stream keeps alive, in seconds of the wall clock."""

LONGEST_OWNER = 200
"""Greatest number of characters of an owner's name."""

LOSSES = {loss: getattr(lease_pb2, f"LEASE_LOSS_{loss.name}") for loss in (Loss.RELEASED, Loss.TAKEN)}


class LeaseServicer(lease_pb2_grpc.LeaseServiceServicer):
    """Servicer of LeaseService; remembers how many streams keep which lease alive."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._keepers: Counter[str] = Counter()
        self._timers: dict[str, asyncio.TimerHandle] = {}
        kernel.tokens.subscribe(self._end_leases)

    async def AcquireLease(
        self, request: lease_pb2.AcquireLeaseRequest, context: object
    ) -> lease_pb2.AcquireLeaseResponse:
        """Lease robots, all or none."""
        world = self._kernel.world
        robots, owner = _robots(world.snapshot, request.robots), _owner(request.owner, context)
        lease = self._kernel.leases.acquire(world.snapshot, robots, owner, CALLER.get().name)
        self._expire_later(lease.token)
        # Behind what was let into the queue before; so nobody else's command is applied once this call is answered.
        applied = await asyncio.wrap_future(world.submit([], f"{lease.id} acquired by {author(context)}"))
        return lease_pb2.AcquireLeaseResponse(
            stamp=stamp(applied.snapshot), lease=_message(applied.snapshot, lease), token=lease.token
        )

    async def TakeLease(self, request: lease_pb2.TakeLeaseRequest, context: object) -> lease_pb2.TakeLeaseResponse:
        """Lease robots whoever had them, and stop their motions."""
        world = self._kernel.world
        robots, owner = _robots(world.snapshot, request.robots), _owner(request.owner, context)
        lease, losers = self._kernel.leases.take(robots, owner, CALLER.get().name)
        self._expire_later(lease.token)
        cancellation = Cancellation(EndCause.LEASE_TAKEN, f"the robot was taken over by {owner!r}")
        stop = world.submit([StopRobots(robots, cancellation)], f"{lease.id} taken by {author(context)}")
        applied = await asyncio.wrap_future(stop)
        return lease_pb2.TakeLeaseResponse(
            stamp=stamp(applied.snapshot),
            lease=_message(applied.snapshot, lease),
            token=lease.token,
            taken_from=[_message(applied.snapshot, loser) for loser in losers],
        )

    async def KeepLeaseAlive(
        self, request: lease_pb2.KeepLeaseAliveRequest, context: object
    ) -> AsyncIterator[lease_pb2.KeepLeaseAliveResponse]:
        """Hold a lease while the stream is open, and tell what it loses."""
        world, leases, token = self._kernel.world, self._kernel.leases, request.token
        told = leases.held_by(token)
        self._keepers[token] += 1
        try:
            snapshot = world.snapshot
            yield lease_pb2.KeepLeaseAliveResponse(stamp=stamp(snapshot), lease=_message(snapshot, told))
            async with aclosing(self._kernel.publications.each(leases.subscribe)) as changes:
                async for _ in changes:
                    now = leases.record(token)
                    if now.robots == told.robots:
                        continue
                    told = now
                    snapshot = world.snapshot
                    yield lease_pb2.KeepLeaseAliveResponse(
                        stamp=stamp(snapshot),
                        lease=_message(snapshot, now),
                        loss=LOSSES[now.loss] if now.loss else None,
                        reason=now.reason,
                    )
                    if not now.robots:
                        return
        finally:
            self._keepers[token] -= 1
            if not self._keepers[token]:
                del self._keepers[token]
            self._expire_later(token)

    async def ReleaseLease(
        self, request: lease_pb2.ReleaseLeaseRequest, context: object
    ) -> lease_pb2.ReleaseLeaseResponse:
        """Make the robots of a lease free."""
        lease = self._kernel.leases.held_by(request.token)
        self._kernel.leases.end(lease, Loss.RELEASED, "it was released")
        snapshot = self._kernel.world.snapshot
        return lease_pb2.ReleaseLeaseResponse(stamp=stamp(snapshot), lease=_message(snapshot, lease))

    async def ListLeases(self, request: lease_pb2.ListLeasesRequest, context: object) -> lease_pb2.ListLeasesResponse:
        """Tell who has leased what."""
        snapshot = self._kernel.world.snapshot
        return lease_pb2.ListLeasesResponse(
            stamp=stamp(snapshot), leases=[_message(snapshot, lease) for lease in self._kernel.leases.held]
        )

    async def WatchLeases(
        self, request: lease_pb2.WatchLeasesRequest, context: object
    ) -> AsyncIterator[lease_pb2.WatchLeasesResponse]:
        """Tell who has leased what, then again after each change; a slow reader gets the latest."""
        leases, told = self._kernel.leases, None
        async with aclosing(self._kernel.publications.each(leases.subscribe)) as changes:
            async for _ in changes:
                snapshot = self._kernel.world.snapshot
                now = [_message(snapshot, lease) for lease in leases.held]
                if now != told:
                    told = now
                    yield lease_pb2.WatchLeasesResponse(stamp=stamp(snapshot), leases=now)

    def _expire_later(self, token: str) -> None:
        """Give a lease the whole grace from now on."""
        if timer := self._timers.pop(token, None):
            timer.cancel()
        self._timers[token] = asyncio.get_running_loop().call_later(GRACE_SECONDS, self._check, token)

    def _check(self, token: str) -> None:
        """End a lease that no stream keeps alive, and stop its robots; else the end of a stream checks again."""
        del self._timers[token]
        lease = next((one for one in self._kernel.leases.held if one.token == token), None)
        if not self._keepers[token] and lease is not None:
            self._expire(lease, f"nobody has kept it alive for {GRACE_SECONDS:g} s")

    def _end_leases(self, account: Account) -> None:
        """End the leases of a token that was withdrawn, and stop their robots."""
        for lease in self._kernel.leases.held:
            if lease.holder == account.name:
                self._expire(lease, f"the token {account.name!r} was withdrawn")

    def _expire(self, lease: Lease, reason: str) -> None:
        self._kernel.leases.end(lease, Loss.EXPIRED, reason)
        cancellation = Cancellation(EndCause.LEASE_EXPIRED, f"the lease of {lease.owner!r} expired: {reason}")
        self._kernel.world.submit([StopRobots(tuple(sorted(lease.robots)), cancellation)], "kernel")


def _robots(snapshot: Snapshot, names: Sequence[str]) -> tuple[int, ...]:
    """Return the uids of robots by name, each once; raise KernelError for none and for unknown ones."""
    if not names:
        raise KernelError("robots must name at least one robot", field="robots")
    return tuple(sorted({snapshot.structure.robot(name)[0].uid for name in names}))


def _owner(asked: str, context: object) -> str:
    if len(asked) > LONGEST_OWNER:
        raise KernelError(
            f"owner may have {LONGEST_OWNER} characters, not {len(asked)}", field="owner", limit=LONGEST_OWNER
        )
    return asked or person(context)


def _message(snapshot: Snapshot, lease: Lease) -> lease_pb2.Lease:
    """Return a lease without its token."""
    nodes = snapshot.structure.nodes
    since = Timestamp()
    since.FromNanoseconds(round(lease.since * 1e9))
    return lease_pb2.Lease(
        id=lease.id,
        robots=[nodes[uid].name for uid in sorted(lease.robots) if uid in nodes],
        owner=lease.owner,
        since=since,
    )
