"""Open programs: what the planner remembers of their ends, and AppendMotion, which plans on from there."""

from __future__ import annotations

import asyncio
from math import inf
from weakref import WeakValueDictionary

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.api.convert.program import NOTE, program_steps
from virtualrobot_kernel.api.convert.states import motion_message
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import find_motion
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import expected_revision, stamp
from virtualrobot_kernel.planning.blending import PlannedRun
from virtualrobot_kernel.planning.plan_append import plan_append
from virtualrobot_kernel.planning.program import MotionSpec, Step
from virtualrobot_kernel.planning.together import solved_robots
from virtualrobot_kernel.world.apply_motions import open_program, running_motion
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.store import Applied, check_revision

MARGINS = (0.1, 0.3, 0.9)
"""Times (s of the wall clock) that planning may take until the motion is past where it was to go on differently.

They are tried in turn; after the last one the steps begin from rest, for which it is never too late.
"""


class OpenPrograms:
    """Ends of the open programs, by motion id; in the API's event loop alone. Each program has one append at a time."""

    def __init__(self, kernel: KernelServices) -> None:
        """Know of no program yet."""
        self._kernel = kernel
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
            steps = program_steps(request.steps, request.programs, count, program.outer_count)
            clock = self._kernel.world.clock
            margins = (0.0,) if clock.mode is Mode.STEPPED else tuple(one * clock.speed_factor for one in MARGINS)
            for margin in margins:
                try:
                    return await self._appended(request, steps, margin, context)
                except KernelError as error:
                    if error.reason is not Reason.PLAN_OUTDATED:
                        raise
            return await self._appended(request, steps, inf, context)

    async def _appended(
        self, request: motion_pb2.AppendMotionRequest, steps: tuple[Step, ...], margin: float, context: object
    ) -> motion_pb2.AppendMotionResponse:
        kernel, end = self._kernel, self._ends.get(request.id)
        moves = MotionSpec(steps=steps).every_move
        near_of, last = near_by(kernel.collisions), request.last

        planned = await kernel.limiter.run_while_wanted(
            solved_robots(kernel.world.snapshot, moves),
            lambda given_up: plan_append(
                (now := kernel.world.snapshot),
                running_motion(now.state, request.id),
                steps,
                end,
                margin,
                kernel.solvers.of,
                given_up,
                near_of,
                last=last,
                outer_count=len(request.steps),
            ),
        )
        submitted = kernel.submit([planned.command], context, expected_revision(request))
        applied: Applied = await asyncio.wrap_future(submitted)
        self.remember(request.id, planned.end)
        snapshot = applied.snapshot
        return motion_pb2.AppendMotionResponse(
            stamp=stamp(snapshot),
            motion=motion_message(snapshot, find_motion(snapshot, request.id)),
            notes=map(NOTE.write, planned.notes),
        )
