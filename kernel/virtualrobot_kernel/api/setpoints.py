"""Streams of setpoints: what a client sends goes to the mailbox of the next tick, where the newest counts."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Coroutine
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.author import author
from virtualrobot_kernel.api.convert.setpoints import Followed, followed, follows_twists, progress, setpoint
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.lease_table import CARRIED
from virtualrobot_kernel.api.motion_calls import find_motion, make_way
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.commands import CancelMotion, EndSetpoints, SetSetpoint, StartSetpointMotion
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import Applied, Permit
from virtualrobot_kernel.world.tick_inputs import TickInput

MAX_RATE_HERTZ = 60.0
"""Greatest rate (Hz) of a stream's reports on its motion, while time follows the wall clock."""

CLOSING_SECONDS = 0.01
"""Time (s) in which a lost connection looks like a stream that its client has ended, until the call is cancelled."""

LEASE_LOST = (EndCause.LEASE_TAKEN, EndCause.LEASE_EXPIRED)
NO_LEASE = (Reason.LEASED, Reason.LEASE_ENDED)
GONE = (Reason.WRONG_STATE, Reason.UNKNOWN_NAME)
"""Reasons for refusing a setpoint of a motion that has ended."""

Requests = AsyncIterator[motion_pb2.StreamSetpointsRequest]


async def stream_setpoints(
    kernel: KernelServices, requests: Requests, context: object
) -> AsyncGenerator[motion_pb2.StreamSetpointsResponse, None]:
    """Start a motion, hand setpoints on to it, and tell how it follows until it has ended.

    Raises KernelError, and stops the motion, when a setpoint is refused. The motion stops too when the call ends
    before it.
    """
    first = await anext(aiter(requests), None)
    if first is None or not first.HasField("target"):
        raise KernelError("the first message of the stream must say in `target` what is moved", field="target")
    snapshot = kernel.world.snapshot
    uid = snapshot.structure.robot(first.target.robot)[0].uid
    craft = kernel.crafts.to_drive(uid) if follows_twists(first.target) else None
    following = followed(snapshot, first.target, craft)
    command, frame = following.start, following.frame
    values = setpoint(first, following.names) if first.values else None
    await make_way(kernel, lambda snapshot: _needed(snapshot, command), first.target.busy_policy, context)
    writer, tokens = author(context), CARRIED.get()
    # A client that vanishes here leaves a motion that is stopped by its own timeout.
    applied = await asyncio.wrap_future(kernel.submit([command], context))
    id, snapshot = str(applied.created[0]), applied.snapshot
    robots = find_motion(snapshot, id).robots
    follow = partial(kernel.crafts.follow, id, uid)
    by_twists = partial(kernel.with_component, craft.component, follow) if craft is not None else None
    feed = _Feed(kernel, id, following, writer, kernel.permit(), by_twists)
    working = {
        asyncio.create_task(_or_stop(kernel, id, work)) for work in (feed.read(values, requests), feed.refusal())
    }
    try:
        while True:
            motion = find_motion(snapshot, id)
            if craft is not None and uid in snapshot.structure.robots:
                yield await kernel.with_component(craft.component, progress, snapshot, motion, feed.given, craft)
            else:
                yield progress(snapshot, motion, feed.given, None, frame)
            if motion.running.ended:
                break
            snapshot = await _later(feed.news(snapshot), working)
        if motion.cancellation and motion.cancellation.cause is EndCause.SETPOINT_REFUSED:
            await asyncio.gather(*working)  # what has refused it says why, once its stop is kept
        if motion.cancellation and motion.cancellation.cause in LEASE_LOST:
            kernel.leases.check(snapshot, robots, tokens)
    finally:
        for task in working:
            task.cancel()
        if any(motion.id == id and not motion.cancellation for motion in kernel.world.snapshot.state.motions):
            _cancel(kernel, id, EndCause.UNWATCHED, "the client that sent setpoints is gone")


class _Feed:
    """Feed of setpoints from a client to the world's mailbox, where the newest one waits for the next tick."""

    def __init__(
        self,
        kernel: KernelServices,
        id: str,
        following: Followed,
        writer: str,
        permit: Permit,
        follow: Callable[[NDArray[np.float64]], Awaitable[tuple[float, ...]]] | None,
    ) -> None:
        """Feed a motion with what `writer` sends; `follow` makes setpoints of joints of twists."""
        self._follow = follow
        self.given = 0
        """Number of setpoints given to the motion, those that were replaced by newer ones included."""
        self._kernel = kernel
        self._id = id
        self._following = following
        self._writer = writer
        self._permit = permit
        self._handed = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self._refused: asyncio.Future[None] = self._loop.create_future()

    async def read(self, first: tuple[float, ...] | None, requests: Requests) -> None:
        """Hand on setpoints as fast as the client sends them, and tell the motion when no more will come."""
        if first is not None:
            await self._give(first)
        async for message in requests:
            if message.HasField("target"):
                raise KernelError("a stream moves the target of its first message and no other", field="target")
            await self._give(setpoint(message, self._following.names))
        await asyncio.sleep(CLOSING_SECONDS)
        self._put(EndSetpoints(self._id))

    async def refusal(self) -> None:
        """Raise the error with which the world refuses a setpoint."""
        await self._refused

    async def _give(self, values: tuple[float, ...]) -> None:
        """Have a setpoint count in the next tick; raise KernelError when the world as it is refuses it already."""
        snapshot = self._kernel.world.snapshot
        motion = next((motion for motion in snapshot.state.motions if motion.id == self._id), None)
        if motion is None:
            return  # it has ended
        assert isinstance(motion.running, SetpointMotion)
        if self._follow is not None:
            values = await self._follow(np.array(values))
        else:
            values = self._following.values(snapshot, values)
            motion.running.set(values)  # changes nothing: it raises for what it refuses
            joints = [joint for _, joint in motion.joints]
            self._kernel.crafts.check_told(motion.joints[0][0], motion.running.mode, joints, values)
        self._put(SetSetpoint(self._id, values))
        self.given += 1
        self._handed.set()

    def _put(self, command: SetSetpoint | EndSetpoints) -> None:
        target = f"{type(command).__name__} {self._id}"
        self._kernel.mailbox.put(target, TickInput(command, self._writer, self._refuse, self._permit))

    def _refuse(self, error: KernelError) -> None:
        """Tell the API's thread of an error; called in the world thread."""

        def fail() -> None:
            if not self._refused.done():
                self._refused.set_exception(error)

        if error.reason not in GONE:
            with suppress(RuntimeError):  # the kernel is ending
                self._loop.call_soon_threadsafe(fail)

    async def news(self, seen: Snapshot) -> Snapshot:
        """Return the latest snapshot, at most `MAX_RATE_HERTZ` times a second and once the motion has ended.

        In STEPPED mode, where the client may wait for it, at once, and also when a setpoint has been handed on.
        """
        publications = self._kernel.publications
        if self._kernel.world.clock.mode is Mode.REALTIME:
            await publications.end_of_motion(self._id, 1.0 / MAX_RATE_HERTZ)
            return await publications.newer_than(seen)
        newer = asyncio.create_task(publications.newer_than(seen))
        handed = asyncio.create_task(self._handed.wait())
        try:
            await asyncio.wait({newer, handed}, return_when=asyncio.FIRST_COMPLETED)
            return newer.result() if newer.done() else self._kernel.world.snapshot
        finally:
            self._handed.clear()
            newer.cancel()
            handed.cancel()


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


async def _or_stop(kernel: KernelServices, id: str, work: Coroutine[Any, Any, None]) -> None:
    """Do a part of the work for a motion; when that is refused stop the motion, also while its client reads nothing."""
    try:
        await work
    except KernelError as error:
        cause = EndCause.LEASE_TAKEN if error.reason in NO_LEASE else EndCause.SETPOINT_REFUSED
        with suppress(KernelError):  # it has ended
            await asyncio.wrap_future(_cancel(kernel, id, cause, str(error)))
        raise


def _needed(snapshot: Snapshot, command: StartSetpointMotion) -> set[tuple[int, str]]:
    robot = snapshot.structure.robot(command.robot)[0]
    return {(robot.uid, name) for name in command.joint_names}


def _cancel(kernel: KernelServices, id: str, cause: EndCause, reason: str) -> Future[Applied]:
    return kernel.world.submit([CancelMotion(id, Cancellation(cause, reason))], "kernel")
