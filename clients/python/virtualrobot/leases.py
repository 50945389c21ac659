"""Leases: robots that nobody else can move. A thread of each lease keeps it alive as long as this program lives."""

from __future__ import annotations

import getpass
import os
import socket
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from virtualrobot._wire import interruptions
from virtualrobot._wire.arguments import checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.transport import Stream
from virtualrobot.errors import KernelGoneError, LeaseEndedError, VirtualRobotError
from virtualrobot.v1 import lease_pb2

GRACE_SECONDS = 1.0
"""Time for which the kernel keeps a lease that no stream keeps alive (s)."""

_RETRY_SECONDS = 0.1


@dataclass(frozen=True, slots=True)
class LeaseInfo:
    """A lease as everybody may know it.

    Attributes:
        id: its name, never used again.
        robots: the names of the robots that it is for.
        owner: the owner in words.
        since: since when, by the kernel's wall clock.
    """

    id: str
    robots: tuple[str, ...]
    owner: str
    since: datetime


@checked
class Lease:
    """Robots that only this client can move, until the lease is released; a context manager.

    All calls of the client carry it from the moment that it is acquired. It ends with `release` or the `with` block; or
    when somebody takes the robots, or this program is gone for more than a second: then the robots stop.

    Example:
        >>> with client.lease("left", "right"):
        ...     client.move_together([left.ptp("home"), right.ptp("home")])
    """

    def __init__(self, services: Services, message: lease_pb2.Lease, token: str) -> None:
        """Hold a lease that the kernel has just given; `acquire` makes the usual ones."""
        self._services = services
        self._token = token
        self._info = _info(message)
        self._lost = ""
        self._changed = threading.Condition()
        services.channel.carry(token)
        self._stream = self._open()
        threading.Thread(target=self._keep_alive, name=f"lease {self.id}", daemon=True).start()

    @property
    def id(self) -> str:
        """The name of the lease, for people and logs."""
        return self._info.id

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it is for now; none once it has ended."""
        return self._info.robots

    @property
    def owner(self) -> str:
        """Owner of the lease, in words."""
        return self._info.owner

    @property
    def since(self) -> datetime:
        """Begin of the lease, by the kernel's wall clock."""
        return self._info.since

    @property
    def lost(self) -> str:
        """Reason for which it has lost robots, such as who took them; empty while it has all of them."""
        return self._lost

    def wait_for_loss(self, timeout: float | None = None) -> str:
        """Wait until it has lost robots, for at most `timeout` seconds; return why, or nothing when it has not."""
        with self._changed:
            interruptions.wait_for(self._changed, lambda: bool(self._lost), timeout)
        return self._lost

    def release(self) -> None:
        """Give the robots back; motions that run go on. Does nothing when the lease has ended already."""
        self._services.channel.drop(self._token)
        try:
            self._services.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=self._token))
        except LeaseEndedError:
            pass  # why, the stream has told
        finally:
            self._stream.cancel()
            self._tell(None, self._lost or "it was released")

    def _open(self) -> Stream[lease_pb2.KeepLeaseAliveResponse]:
        return self._services.lease.KeepLeaseAlive(lease_pb2.KeepLeaseAliveRequest(token=self._token))

    def _keep_alive(self) -> None:
        """Read what the kernel tells; open the stream again when the connection is lost, as long as that may help."""
        give_up = None
        while True:
            try:
                for response in self._stream:
                    give_up = None
                    self._tell(_info(response.lease), response.reason)
                return
            except KernelGoneError as error:
                now = time.monotonic()
                give_up = give_up or now + GRACE_SECONDS
                if now > give_up:
                    return self._tell(None, str(error))
            except VirtualRobotError as error:
                # Of a lease that was lost before the stream was open the kernel tells why as a refusal.
                return self._tell(None, error.metadata.get("loss", str(error)))
            time.sleep(_RETRY_SECONDS)
            try:
                self._stream = self._open()
            except VirtualRobotError as error:  # the client was closed meanwhile
                return self._tell(None, str(error))

    def _tell(self, info: LeaseInfo | None, reason: str) -> None:
        with self._changed:
            self._info = info or LeaseInfo(self.id, (), self.owner, self.since)
            self._lost = reason or self._lost
            self._changed.notify_all()

    def __enter__(self) -> Lease:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Give the robots back."""
        self.release()

    def __repr__(self) -> str:
        """Return a line for people."""
        what = ", ".join(self.robots) or "no robot any more"
        return f"<Lease {self.id} of {what} by {self.owner!r}>"


def acquire(services: Services, robots: Sequence[str], owner: str | None = None, take: bool = False) -> Lease:
    """Lease robots, all or none; with `take` whoever has them."""
    owner = owner or program_name()
    if take:
        response = services.lease.TakeLease(lease_pb2.TakeLeaseRequest(robots=robots, owner=owner))
    else:
        response = services.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=robots, owner=owner))
    return Lease(services, response.lease, response.token)


def list_leases(services: Services) -> list[LeaseInfo]:
    """Return who has leased what, oldest first."""
    return [_info(lease) for lease in services.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases]


def watch_leases(services: Services) -> Iterator[list[LeaseInfo]]:
    """Yield who has leased what, oldest first, at once and after each change."""
    with services.lease.WatchLeases(lease_pb2.WatchLeasesRequest()) as stream:
        yield from ([_info(lease) for lease in response.leases] for response in stream)


def _info(message: lease_pb2.Lease) -> LeaseInfo:
    return LeaseInfo(message.id, tuple(message.robots), message.owner, message.since.ToDatetime(UTC))


def program_name() -> str:
    """Return who this program is, for people: user, machine, program and process."""
    return f"{user_name()}, {Path(sys.argv[0]).name or 'python'} ({os.getpid()})"[:200]


def user_name() -> str:
    """Return the user of this program and the machine, for people."""
    try:
        user = getpass.getuser()
    except (OSError, KeyError):  # a user without a name, as in some containers
        user = "somebody"
    return f"{user} at {socket.gethostname()}"
