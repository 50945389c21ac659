"""Open programs: what the planner remembers of their ends, and AppendMotion, which plans on from there."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from math import inf
from weakref import WeakValueDictionary

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.program import NOTE, program_text
from virtualrobot_kernel.api.convert.states import motion_message
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import find_motion
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import expected_revision, stamp
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.notes import Note
from virtualrobot_kernel.planning.plan_append import plan_append
from virtualrobot_kernel.planning.program import MotionSpec, Step
from virtualrobot_kernel.planning.together import solved_robots
from virtualrobot_kernel.world.apply_motions import open_program, running_motion
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied, check_revision

MARGINS = (0.1, 0.3, 0.9)
"""Times (s of the wall clock) that planning may take until the motion is past where it was to go on differently.

They are tried in turn; after the last one the steps begin from rest, for which it is never too late.
"""


@dataclass(frozen=True, slots=True)
class _End:
    """End of a program with more steps: whether they close it, and how many its text has more outside of others."""

    last: bool
    outer_count: int


class OpenPrograms:
    """Ends of the open programs, by motion id; in the API's event loop alone. Each program has one append at a time."""

    def __init__(self, kernel: KernelServices) -> None:
        """Know of no program yet."""
        self._kernel = kernel
        self.decided: dict[str, bool] = {}
        """Programs whose own text is not over yet, and whether more may be appended when it is."""
        self._ends: dict[str, PlannedRun] = {}
        self._turns: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    def remember(self, id: str, end: PlannedRun | None) -> None:
        """Remember the run at the end of a program (None: nothing can be joined to it); forget programs that ended."""
        self._ends.pop(id, None)
        if end is not None:
            going = {motion.id for motion in self._kernel.world.snapshot.state.motions}
            self._ends = {one: run for one, run in self._ends.items() if one in going} | {id: end}

    async def append(self, request: motion_pb2.AppendMotionRequest, context: object) -> motion_pb2.AppendMotionResponse:
        """Plan steps and append them; planned again where the motion has meanwhile gone too far."""
        check_revision(self._kernel.world.snapshot.structure, expected_revision(request))
        async with self._turns.setdefault(request.id, asyncio.Lock()):
            program = open_program(running_motion(self._kernel.world.snapshot.state, request.id)).program
            count = program.step_count
            if request.HasField("expected_step_count") and request.expected_step_count != count:
                raise KernelError(
                    f"{request.id!r} has {count} steps, not {request.expected_step_count}",
                    reason=Reason.WRONG_STATE,
                    motion=request.id,
                    step_count=count,
                )
            if request.id in self.decided:
                open = self.decided[request.id]
                why = (
                    " before its text has come to its last decision" if open else ": it was not started as an open one"
                )
                raise KernelError(
                    f"nothing can be appended to {request.id!r}{why}", reason=Reason.WRONG_STATE, motion=request.id
                )
            text = program_text(request.steps, request.programs, request.breakpoints, count, program.outer_count)
            if text.rest is not None:
                raise KernelError("steps that decide what comes next can't be appended; start a program of them")
            submit = partial(self._kernel.submit, context=context, expected_revision=expected_revision(request))
            end = _End(request.last, text.outer_count)
            snapshot, notes = await self._soon_enough(request.id, text.steps, end, submit)
        return motion_pb2.AppendMotionResponse(
            stamp=stamp(snapshot),
            motion=motion_message(snapshot, find_motion(snapshot, request.id)),
            notes=map(NOTE.write, notes),
        )

    async def go_on(
        self, id: str, steps: tuple[Step, ...], submit: Callable[..., Future[Applied]], *, last: bool
    ) -> None:
        """Plan the next steps of a program's own text and append them; `last` closes it."""
        async with self._turns.setdefault(id, asyncio.Lock()):
            await self._soon_enough(id, steps, _End(last, 0), submit)

    async def _soon_enough(
        self, id: str, steps: tuple[Step, ...], end: _End, submit: Callable[..., Future[Applied]]
    ) -> tuple[Snapshot, tuple[Note, ...]]:
        """Append steps, planned again where the motion has meanwhile gone too far; return the world and notes."""
        clock = self._kernel.world.clock
        margins = (0.0,) if clock.mode is Mode.STEPPED else tuple(one * clock.speed_factor for one in MARGINS)
        for margin in margins:
            try:
                return await self._appended(id, steps, end, margin, submit)
            except KernelError as error:
                if error.reason is not Reason.PLAN_OUTDATED:
                    raise
        return await self._appended(id, steps, end, inf, submit)

    async def _appended(
        self, id: str, steps: tuple[Step, ...], end: _End, margin: float, submit: Callable[..., Future[Applied]]
    ) -> tuple[Snapshot, tuple[Note, ...]]:
        kernel, tail = self._kernel, self._ends.get(id)
        near_of, moves = near_by(kernel.collisions), MotionSpec(steps=steps).every_move

        planned = await kernel.limiter.run_while_wanted(
            solved_robots(kernel.world.snapshot, moves),
            lambda given_up: plan_append(
                (now := kernel.world.snapshot),
                running_motion(now.state, id),
                steps,
                tail,
                margin,
                kernel.solvers.of,
                given_up,
                near_of,
                last=end.last,
                outer_count=end.outer_count,
            ),
        )
        applied: Applied = await asyncio.wrap_future(submit([planned.command]))
        self.remember(id, planned.end)
        return applied.snapshot, planned.notes
