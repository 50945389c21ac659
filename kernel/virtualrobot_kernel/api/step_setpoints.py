"""Setpoints that come with steps of the clock: a client's robots follow them from step to step, without a stream."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Iterable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass

import numpy as np
from virtualrobot.v1 import kernel_pb2

from virtualrobot_kernel.api.author import author, is_mine
from virtualrobot_kernel.api.convert.setpoints import followed, follows_twists, numbers
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import make_way
from virtualrobot_kernel.crafts.craft import CraftAtWork
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    EndSetpoints,
    SetSetpoint,
    StartSetpointMotion,
)
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Snapshot

Key = tuple[str, int, tuple[str, ...], int]
"""Author, robot (uid), joints and mode, by its number in the contract, of a motion that follows steps."""


@dataclass(frozen=True, slots=True, eq=False)
class _Wish:
    """A setpoint as it is asked for."""

    key: Key
    start: StartSetpointMotion
    craft: CraftAtWork | None
    values: tuple[float, ...] | None
    speeds: tuple[float, ...] | None
    """Values of its joints: of a craft's twist those of its drives."""
    busy_policy: int


class StepSetpoints:
    """Motions that follow the setpoints of steps, for the API's thread."""

    def __init__(self, kernel: KernelServices) -> None:
        """Begin with none."""
        self._kernel = kernel
        self._motions: dict[Key, str] = {}

    @asynccontextmanager
    async def given(
        self, requests: Iterable[kernel_pb2.StepSetpoint], context: object
    ) -> AsyncGenerator[tuple[str, ...], None]:
        """Start the motions that are missing, yield their ids, and give all their setpoints at the end of the block.

        Raises KernelError before anything is changed; what was started is stopped again when the block fails.
        """
        kernel = self._kernel
        self._forget()
        wishes = [await self._wish(request, f"setpoints[{place}]", context) for place, request in enumerate(requests)]
        if len({wish.key for wish in wishes}) < len(wishes):
            raise KernelError("a robot has two setpoints in one step; give one", field="setpoints")
        running = {wish.key: self._running(wish) for wish in wishes}
        for wish in wishes:
            if wish.speeds is not None and (motion := running[wish.key]) is not None:
                assert isinstance(motion.running, SetpointMotion)
                motion.running.set(wish.speeds)  # changes nothing: it raises for what it refuses
        started: dict[Key, str] = {}
        try:
            for wish in wishes:
                if running[wish.key] is None and wish.values is not None:
                    started[wish.key] = await self._started(wish, context)
            yield tuple(self._motions.get(wish.key, "") for wish in wishes)
            commands = [command for wish in wishes for command in await self._commands(wish)]
            if commands:
                await asyncio.wrap_future(kernel.submit(commands, context))
        except BaseException:
            for key, id in started.items():
                self._motions.pop(key, None)
                with suppress(KernelError):
                    reason = Cancellation(EndCause.SETPOINT_REFUSED, "the step that started it was refused")
                    kernel.world.submit([CancelMotion(id, reason)], "kernel")
            raise
        for wish in wishes:
            if wish.values is None:
                self._motions.pop(wish.key, None)

    def end(self, context: object) -> None:
        """Have the motions stop that follow the steps of a client."""
        self._forget()
        reason = Cancellation(EndCause.UNWATCHED, "the client that stepped time is gone")
        mine = is_mine(context)
        for key in [key for key in self._motions if mine(key[0])]:
            self._kernel.world.submit([CancelMotion(self._motions.pop(key), reason)], "kernel")

    def _forget(self) -> None:
        """Forget motions that the world has forgotten, such as those of clients that have gone."""
        state = self._kernel.world.snapshot.state
        known = {one.id for one in (*state.motions, *state.ended)}
        self._motions = {key: id for key, id in self._motions.items() if id in known}

    async def _wish(self, request: kernel_pb2.StepSetpoint, field: str, context: object) -> _Wish:
        """Return what a setpoint asks for; raise KernelError for what the robot never does."""
        if not request.HasField("target"):
            raise KernelError(f"{field} must say in `target` what is moved", field=f"{field}.target")
        snapshot = self._kernel.world.snapshot
        uid = snapshot.structure.robot(request.target.robot)[0].uid
        craft = self._kernel.crafts.to_drive(uid) if follows_twists(request.target) else None
        following = followed(snapshot, request.target, craft)
        start, names = following.start, following.names
        values = numbers(request.values, names, f"{field}.values") if request.values else None
        if values is not None:
            values = following.values(snapshot, values)
        speeds = values
        if craft is None and values is not None:
            self._kernel.crafts.check_told(uid, start.mode, names, values)
        if craft is not None and values is not None:
            about = np.array(values), snapshot.state.q, snapshot.tick_seconds
            speeds = tuple((await self._kernel.with_component(craft.component, craft.commands, *about)).tolist())
        key = author(context), uid, names, request.target.mode
        if values is None and not request.target.joint_names:  # whatever of the robot follows
            key = next((one for one in self._motions if (one[0], one[1], one[3]) == (key[0], uid, key[3])), key)
        return _Wish(key, start, craft, values, speeds, request.target.busy_policy)

    def _running(self, wish: _Wish) -> Motion | None:
        """Return the motion that follows already; raise KernelError, once, when it was stopped meanwhile."""
        id = self._motions.get(wish.key)
        if id is None:
            return None
        state = self._kernel.world.snapshot.state
        motion = next((one for one in (*state.motions, *state.ended) if one.id == id), None)
        if motion is not None and not motion.running.ended and motion.cancellation is None:
            return motion
        del self._motions[wish.key]
        if motion is None or motion.cancellation is None:
            return None
        raise KernelError(
            f"{id!r}, which followed these steps, was stopped: {motion.cancellation.reason}; the next setpoint starts "
            "anew",
            reason=Reason.WRONG_STATE,
            motion=id,
            cause=motion.cancellation.cause.name,
        )

    async def _started(self, wish: _Wish, context: object) -> str:
        """Start a motion; raise KernelError, with the motion stopped again, for a setpoint that it refuses."""
        robot = wish.key[1]

        def needed(_: Snapshot) -> set[tuple[int, str]]:
            return {(robot, name) for name in wish.start.joint_names}

        await make_way(self._kernel, needed, wish.busy_policy, context)
        applied = await asyncio.wrap_future(self._kernel.submit([wish.start], context))
        id = self._motions[wish.key] = str(applied.created[0])
        if wish.speeds is not None:
            motion = next(one for one in applied.snapshot.state.motions if one.id == id)
            assert isinstance(motion.running, SetpointMotion)
            try:
                motion.running.set(wish.speeds)
            except KernelError as error:
                del self._motions[wish.key]
                reason = Cancellation(EndCause.SETPOINT_REFUSED, str(error))
                self._kernel.world.submit([CancelMotion(id, reason)], "kernel")
                raise
        return id

    async def _commands(self, wish: _Wish) -> list[Command]:
        id = self._motions.get(wish.key)
        if id is None:
            return []
        if wish.values is None:
            return [EndSetpoints(id)]
        if wish.craft is None:
            return [SetSetpoint(id, wish.values)]
        about = id, wish.key[1], np.array(wish.values)
        speeds = await self._kernel.with_component(wish.craft.component, self._kernel.crafts.follow, *about)
        return [SetSetpoint(id, speeds)]
