"""Streams of setpoints: what a client sends becomes commands, the newest one of each tick."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Coroutine
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.setpoints import followed, progress, setpoint
from virtualrobot_kernel.api.lease_table import CARRIED
from virtualrobot_kernel.api.motion_calls import find_motion, make_way
from virtualrobot_kernel.api.rooms import Rooms
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.commands import CancelMotion, EndSetpoints, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.state import CancelCause, Cancellation, Snapshot
from virtualrobot_kernel.world.store import Applied

MAX_RATE_HERTZ = 60.0
"""How often a stream tells how its motion follows while time follows the wall clock."""

CLOSING_SECONDS = 0.01
"""A lost connection looks like a stream that its client has ended, until a moment later the call is cancelled."""

LEASE_LOST = (CancelCause.LEASE_TAKEN, CancelCause.LEASE_EXPIRED)
NO_LEASE = (Reason.LEASED, Reason.LEASE_ENDED)
GONE = (Reason.WRONG_STATE, Reason.UNKNOWN_NAME)
"""Why a setpoint is refused whose motion has ended."""

Requests = AsyncIterator[motion_pb2.StreamSetpointsRequest]


async def stream_setpoints(
    rooms: Rooms, requests: Requests, context: object
) -> AsyncGenerator[motion_pb2.StreamSetpointsResponse, None]:
    """Start a motion, hand setpoints on to it, and tell how it follows until it has ended.

    Raises KernelError, and stops the motion, when a setpoint is refused. The motion stops too when the call ends
    before it.
    """
    first = await anext(aiter(requests), None)
    if first is None or not first.HasField("target"):
        raise KernelError("the first message of the stream must say in `target` what is moved", field="target")
    command = followed(rooms.world.snapshot, first.target)
    values = setpoint(first, command.joint_names) if first.values else None
    await make_way(rooms, lambda snapshot: _needed(snapshot, command), first.target.busy_policy, context)
    submit, tokens = rooms.submitting(context), CARRIED.get()
    # A client that vanishes here leaves a motion that is stopped by its own timeout.
    applied = await asyncio.wrap_future(submit([command]))
    id, snapshot = str(applied.created[0]), applied.snapshot
    robots = find_motion(snapshot, id).robots
    feed = _Feed(rooms, submit, id, command.joint_names, values)
    working = {asyncio.create_task(_or_stop(rooms, id, work)) for work in (feed.read(requests), feed.hand_on())}
    try:
        while True:
            motion = find_motion(snapshot, id)
            yield progress(snapshot, motion, feed.given)
            if motion.running.ended:
                break
            snapshot = await _later(feed.news(snapshot), working)
        if motion.cancellation and motion.cancellation.cause in LEASE_LOST:
            rooms.leases.check(snapshot, robots, tokens)
    finally:
        for task in working:
            task.cancel()
        if any(motion.id == id and not motion.cancellation for motion in rooms.world.snapshot.state.motions):
            _cancel(rooms, id, CancelCause.UNWATCHED, "the client that sent setpoints is gone")


class _Feed:
    """Takes setpoints from a client to a motion: what is newer replaces what has not been handed on yet."""

    def __init__(
        self,
        rooms: Rooms,
        submit: Callable[..., Future[Applied]],
        id: str,
        joint_names: tuple[str, ...],
        values: tuple[float, ...] | None,
    ) -> None:
        """Begin with the setpoint `values`, or with none."""
        self.given = 0
        """How many setpoints the motion has got, those that were replaced by newer ones included."""
        self._rooms = rooms
        self._submit = submit
        self._id = id
        self._joint_names = joint_names
        self._newest = values
        self._count = 0 if values is None else 1
        self._ended = False
        self._arrived = asyncio.Event()
        self._handed = asyncio.Event()

    async def read(self, requests: Requests) -> None:
        """Keep the newest setpoint that the client has sent, as fast as it sends: none waits in a queue."""
        async for message in requests:
            if message.HasField("target"):
                raise KernelError("a stream moves the target of its first message and no other", field="target")
            self._newest = setpoint(message, self._joint_names)
            self._count += 1
            self._arrived.set()
        await asyncio.sleep(CLOSING_SECONDS)
        self._ended = True
        self._arrived.set()

    async def hand_on(self) -> None:
        """Give the motion the newest setpoint of each tick, and tell it when no more will come."""
        world = self._rooms.world
        try:
            while True:
                command, count = await self._next()
                applied = await asyncio.wrap_future(self._submit([command]))
                if isinstance(command, EndSetpoints):
                    return
                self.given = count
                self._handed.set()
                snapshot = world.snapshot
                # In STEPPED mode nobody knows how many will come before the next tick, and the newest one shall count.
                while world.clock.mode is Mode.REALTIME and snapshot.state.tick == applied.snapshot.state.tick:
                    snapshot = await self._rooms.publications.newer_than(snapshot)
        except KernelError as error:
            if error.reason not in GONE:
                raise

    async def news(self, seen: Snapshot) -> Snapshot:
        """Return the latest snapshot, at most `MAX_RATE_HERTZ` times a second and once the motion has ended.

        In STEPPED mode, where the client may wait for it, at once, and also when a setpoint has been handed on.
        """
        publications = self._rooms.publications
        if self._rooms.world.clock.mode is Mode.REALTIME:
            await publications.end_of_motion(self._id, 1.0 / MAX_RATE_HERTZ)
            return await publications.newer_than(seen)
        newer = asyncio.create_task(publications.newer_than(seen))
        handed = asyncio.create_task(self._handed.wait())
        try:
            await asyncio.wait({newer, handed}, return_when=asyncio.FIRST_COMPLETED)
            return newer.result() if newer.done() else self._rooms.world.snapshot
        finally:
            self._handed.clear()
            newer.cancel()
            handed.cancel()

    async def _next(self) -> tuple[SetSetpoint | EndSetpoints, int]:
        """Return what to do next, and which setpoint it is."""
        while self._newest is None and not self._ended:
            self._arrived.clear()
            await self._arrived.wait()
        values, self._newest = self._newest, None
        return (EndSetpoints(self._id) if values is None else SetSetpoint(self._id, values)), self._count


async def _later(news: Coroutine[Any, Any, Snapshot], working: set[asyncio.Task[None]]) -> Snapshot:
    """Return the news; raise what one of the working tasks raises meanwhile."""
    telling = asyncio.create_task(news)
    try:
        while True:
            for task in [task for task in working if task.done()]:
                task.result()
                working.discard(task)
            if telling.done():
                return telling.result()
            await asyncio.wait({telling, *working}, return_when=asyncio.FIRST_COMPLETED)
    finally:
        telling.cancel()


async def _or_stop(rooms: Rooms, id: str, work: Coroutine[Any, Any, None]) -> None:
    """Do a part of the work for a motion; when that is refused stop the motion, also while its client reads nothing."""
    try:
        await work
    except KernelError as error:
        cause = CancelCause.LEASE_TAKEN if error.reason in NO_LEASE else CancelCause.SETPOINT_REFUSED
        with suppress(KernelError):  # it has ended
            await asyncio.wrap_future(_cancel(rooms, id, cause, str(error)))
        raise


def _needed(snapshot: Snapshot, command: StartSetpointMotion) -> set[tuple[int, str]]:
    robot = snapshot.structure.robot(command.robot)[0]
    return {(robot.uid, name) for name in command.joint_names}


def _cancel(rooms: Rooms, id: str, cause: CancelCause, reason: str) -> Future[Applied]:
    return rooms.world.submit([CancelMotion(id, Cancellation(cause, reason))], "kernel")
