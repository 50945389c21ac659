"""MotionService: start, plan, check, watch, pause, resume, cancel, stop."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import aclosing, contextmanager, suppress
from functools import partial
from operator import is_

from virtualrobot.v1 import motion_pb2, motion_pb2_grpc

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.collision import TURN
from virtualrobot_kernel.api.convert.expansion import flat_program
from virtualrobot_kernel.api.convert.program import NOTE, program_text
from virtualrobot_kernel.api.convert.states import add_step_events, motion_message
from virtualrobot_kernel.api.holding import Holds, check_can_be_held, held_at_start
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.motion_calls import find_motion, make_way, requested, touching_notes
from virtualrobot_kernel.api.motion_plans import (
    check_for_real_robot,
    check_startable,
    checked_again,
    checked_motion,
    found_plan,
    planned_motion,
)
from virtualrobot_kernel.api.open_programs import OpenPrograms
from virtualrobot_kernel.api.program_decisions import Decisions
from virtualrobot_kernel.api.proposals import Proposal
from virtualrobot_kernel.api.publications import pause_seconds
from virtualrobot_kernel.api.repeats import Repeats
from virtualrobot_kernel.api.replacing import as_shown, check_can_replace, replacing
from virtualrobot_kernel.api.roles import check_commands
from virtualrobot_kernel.api.setpoints import stream_setpoints
from virtualrobot_kernel.api.shown_plans import ShownPlan
from virtualrobot_kernel.api.token_table import CALLER
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.collision.swept import RESOLUTION
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats import program_file
from virtualrobot_kernel.messages.values import check_enum, expected_revision, stamp
from virtualrobot_kernel.motion.step_events import StepEvents
from virtualrobot_kernel.planning.plan_motion import PlannedMotion, plan_motion
from virtualrobot_kernel.planning.program import GivenUp
from virtualrobot_kernel.world.commands import (
    CancelMotion,
    Command,
    PauseMotion,
    ResumeMotion,
    StepMotion,
    StopMotions,
)
from virtualrobot_kernel.world.state import Cancellation, EndCause, Snapshot
from virtualrobot_kernel.world.store import Applied, check_revision

GRACE_SECONDS = 1.0
"""Time for which a motion bound to its watch goes on when nobody watches, in seconds of the wall clock."""

HELD_GRACE_SECONDS = 10.0
"""The same for a motion that runs only while it is held, and so stands when nobody is there."""

LATE_SECONDS = 0.2
"""Time (s) by which the kernel itself may be late as it looks whether somebody watches."""

MOST_CHECKS = 3
"""Greatest number of times that a plan is checked again at its start, where the world changes meanwhile."""

LONG_SECONDS = 3600.0
"""Time (s of the wall clock) for which nobody looks whether a motion has ended, which is told."""


class MotionServicer(motion_pb2_grpc.MotionServiceServicer):
    """Servicer of MotionService; remembers watchers, answers by request id, and the ends of open programs."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._watchers: Counter[str] = Counter()
        self._repeats = Repeats()
        self._programs = OpenPrograms(kernel)
        self._decisions = Decisions(kernel, self._programs)
        self._bound: dict[str, tuple[float, asyncio.TimerHandle]] = {}
        self._holds = Holds(kernel)
        self._plans = kernel.plans
        self._followed: set[asyncio.Task[None]] = set()

    async def StartMotion(
        self, request: motion_pb2.StartMotionRequest, context: object
    ) -> motion_pb2.StartMotionResponse:
        """Plan in a worker thread, then start between two ticks."""
        check_enum(request, "busy_policy")
        check_enum(request, "on_disconnect")
        return await self._repeats.once(request, lambda: self._start(request, context))

    async def _start(self, request: motion_pb2.StartMotionRequest, context: object) -> motion_pb2.StartMotionResponse:
        world = self._kernel.world
        check_revision(world.snapshot.structure, expected_revision(request))
        if request.HasField("proposal"):
            return await self._start_proposed(request, context)
        if request.HasField("plan"):
            return await self._start_shown(request, found_plan(self._plans, request), context)
        said = request.spec
        if request.hold:
            check_can_be_held(said)
        text = await self._kernel.in_worker(program_text, said.steps, said.programs, request.breakpoints)
        spec, joints, robots = await requested(self._kernel, said, text)
        replaces = request.busy_policy == motion_pb2.BUSY_POLICY_REPLACE
        if replaces:
            check_can_replace(self._kernel, request, spec, joints)
        else:
            await make_way(self._kernel, lambda _: joints, request.busy_policy, context)
        near_of = near_by(self._kernel.collisions)
        is_played = self._kernel.links.is_executing({uid for uid, _ in joints})

        def work(given_up: GivenUp) -> PlannedMotion:
            # From the snapshot of the moment when it is planned: the robots may have moved while they waited.
            snapshot, is_open = world.snapshot, request.open or text.rest is not None
            planned = plan_motion(snapshot, spec, self._kernel.solvers.of, given_up, near_of, open=is_open)
            if replaces:
                planned = replacing(planned)
            if is_played:
                check_for_real_robot(self._kernel, snapshot, spec, planned, given_up)
            return planned

        planned = await self._kernel.limiter.run_while_wanted({*robots, TURN} if is_played else robots, work)
        submit = self._kernel.submitting(context)
        response = await self._submitted(request, planned, submit)
        if text.rest is not None:
            self._decisions.take_on(response.motion.id, text.rest, submit, open=request.open)
        return response

    async def _start_proposed(
        self, request: motion_pb2.StartMotionRequest, context: object
    ) -> motion_pb2.StartMotionResponse:
        """Approve a proposal: start its plan, and note what becomes of it."""
        for field in ("spec", "plan"):
            if request.HasField(field):
                raise KernelError(f"a proposal is started as it was seen; leave out `{field}`", field=field)
        proposals, asked, by = self._kernel.proposals, request.proposal, person(context)
        with proposals.approving(asked.id, asked.revision) as shown:
            response = await self._start_shown(request, shown, context)
            approved = proposals.approved(asked.id, response.motion.id, by)
        following = asyncio.create_task(self._follow_proposal(approved))
        self._followed.add(following)
        following.add_done_callback(self._followed.discard)
        return response

    async def _follow_proposal(self, proposal: Proposal) -> None:
        """Note the end of the motion that a proposal was approved with."""
        world, id = self._kernel.world, proposal.motion
        with suppress(KernelError):  # the kernel is ending
            while any(motion.id == id for motion in world.snapshot.state.motions):
                await self._kernel.publications.end_of_motion(id, LONG_SECONDS)
            ended = next((motion for motion in world.snapshot.state.ended if motion.id == id), None)
            self._kernel.proposals.ended(proposal, ended)

    async def _start_shown(
        self, request: motion_pb2.StartMotionRequest, shown: ShownPlan, context: object
    ) -> motion_pb2.StartMotionResponse:
        """Start a plan as it was shown, checked again where what its check used is another one now.

        Whoever asked for it, its steps are those of who starts it.
        """
        check_commands(shown.said, CALLER.get())
        for field in ("open", "breakpoints"):
            if getattr(request, field):
                raise KernelError(f"a plan is started as it was shown; leave out `{field}`", field=field)
        if request.busy_policy in (motion_pb2.BUSY_POLICY_PREEMPT, motion_pb2.BUSY_POLICY_REPLACE):
            raise KernelError(
                "a plan starts where its joints stood when it was made, so it can't take over from a motion; leave out "
                "the policy, or give the motion as `spec`",
                field="busy_policy",
            )
        await make_way(self._kernel, lambda _: set(shown.joints), request.busy_policy, context)
        if shown.surroundings is None and self._kernel.links.is_executing({uid for uid, _ in shown.joints}):
            shown = await self._checked_for_real_robot(shown)
        for left in reversed(range(MOST_CHECKS)):
            shown = await checked_again(self._kernel, shown)
            try:
                submit = self._kernel.submitting(context, shown.check)
                return await self._submitted(request, as_shown(shown.planned), submit)
            except KernelError as error:
                if error.reason is not Reason.PLAN_OUTDATED or not left:
                    raise
        raise AssertionError("the last check is answered")

    async def _checked_for_real_robot(self, shown: ShownPlan) -> ShownPlan:
        """Return a plan as it is once it was checked as a whole; raise KernelError with its first violation."""

        def work(given_up: GivenUp) -> ShownPlan:
            snapshot = self._kernel.world.snapshot
            check_startable(shown, snapshot)
            check_for_real_robot(self._kernel, snapshot, shown.spec, shown.planned, given_up)
            return shown.checked_in(snapshot, RESOLUTION)

        return await self._kernel.limiter.run_while_wanted({*shown.robots, TURN}, work)

    async def _submitted(
        self,
        request: motion_pb2.StartMotionRequest,
        planned: PlannedMotion,
        submit: Callable[..., Future[Applied]],
    ) -> motion_pb2.StartMotionResponse:
        """Start what was planned, between two ticks."""
        command = held_at_start(planned.command) if request.hold else planned.command
        applied = submit([command], expected_revision(request))
        if request.on_disconnect != motion_pb2.DISCONNECT_POLICY_CONTINUE:
            # Not after an await: a client that vanishes there would leave a motion that nothing stops.
            applied.add_done_callback(partial(self._started, asyncio.get_running_loop(), request.hold))
        snapshot = (done := await asyncio.wrap_future(applied)).snapshot
        motion = find_motion(snapshot, str(done.created[0]))
        self._programs.remember(motion.id, planned.end)
        if request.hold:
            self._holds.remember(motion.id)
        notes = (*planned.notes, *touching_notes(self._kernel.monitor.latest, snapshot, motion))
        return motion_pb2.StartMotionResponse(
            stamp=stamp(snapshot), motion=motion_message(snapshot, motion), notes=map(NOTE.write, notes)
        )

    async def AppendMotion(
        self, request: motion_pb2.AppendMotionRequest, context: object
    ) -> motion_pb2.AppendMotionResponse:
        """Plan steps in a worker thread, then append them between two ticks."""
        return await self._repeats.once(request, lambda: self._programs.append(request, context))

    async def PlanMotion(self, request: motion_pb2.PlanMotionRequest, context: object) -> motion_pb2.PlanMotionResponse:
        """Tell what StartMotion would do."""
        return await planned_motion(self._kernel, self._plans, request)

    async def CheckMotion(
        self, request: motion_pb2.CheckMotionRequest, context: object
    ) -> motion_pb2.CheckMotionResponse:
        """Tell whether a motion keeps all limits."""
        return await checked_motion(self._kernel, self._plans, request)

    async def StreamSetpoints(
        self, request_iterator: AsyncIterator[motion_pb2.StreamSetpointsRequest], context: object
    ) -> AsyncIterator[motion_pb2.StreamSetpointsResponse]:
        """Move joints by setpoints as they come."""
        async with aclosing(stream_setpoints(self._kernel, request_iterator, context)) as responses:
            async for response in responses:
                yield response

    async def ReadProgram(
        self, request: motion_pb2.ReadProgramRequest, context: object
    ) -> motion_pb2.ReadProgramResponse:
        """Read a program file, or a program, and tell its flat steps if they are wanted."""
        if request.HasField("spec"):
            if request.text:
                raise KernelError("a program is read from its text or its spec: give one of them", field="text")
            spec = request.spec
        else:
            spec = await self._kernel.read(partial(program_file.parse, request.text, request.uri or "program.yaml"))
        flat, paths = await self._kernel.in_worker(flat_program, spec) if request.flat else (spec, [])
        return motion_pb2.ReadProgramResponse(spec=flat, step_paths=paths)

    async def GetMotion(self, request: motion_pb2.GetMotionRequest, context: object) -> motion_pb2.GetMotionResponse:
        """Tell how a motion is doing."""
        snapshot = self._kernel.world.snapshot
        motion = motion_message(snapshot, find_motion(snapshot, request.id))
        return motion_pb2.GetMotionResponse(stamp=stamp(snapshot), motion=motion)

    async def ListMotions(
        self, request: motion_pb2.ListMotionsRequest, context: object
    ) -> motion_pb2.ListMotionsResponse:
        """Tell which motions run, and which have ended lately."""
        snapshot = self._kernel.world.snapshot
        state = snapshot.state
        motions = state.motions if request.running_only else (*state.ended, *state.motions)
        return motion_pb2.ListMotionsResponse(
            stamp=stamp(snapshot),
            motions=[motion_message(snapshot, motion) for motion in motions],
            speed_factor=state.speed_factor,
        )

    async def WatchMotion(
        self, request: motion_pb2.WatchMotionRequest, context: object
    ) -> AsyncIterator[motion_pb2.WatchMotionResponse]:
        """Tell progress until the end; whoever watches keeps the motion alive."""
        id = request.id
        pause = pause_seconds(request.max_rate_hertz)
        snapshot = self._kernel.world.snapshot
        find_motion(snapshot, id)
        with self._watching(id):
            while True:
                motion = find_motion(snapshot, id)
                yield motion_pb2.WatchMotionResponse(stamp=stamp(snapshot), motion=motion_message(snapshot, motion))
                if motion not in snapshot.state.motions:
                    return
                snapshot = await self._progressed(snapshot, id, pause)

    async def WatchMotions(
        self, request: motion_pb2.WatchMotionsRequest, context: object
    ) -> AsyncIterator[motion_pb2.WatchMotionsResponse]:
        """Tell all motions that run, and each that has ended; while nothing of them changes, nothing."""
        before: Snapshot | None = None
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz):
            state, ended = snapshot.state, ()
            if before is not None:
                known = {motion.id for motion in before.state.ended}
                ended = tuple(motion for motion in state.ended if motion.id not in known)
                if not ended and _same_motions(before, snapshot):
                    continue
            before = snapshot
            yield motion_pb2.WatchMotionsResponse(
                stamp=stamp(snapshot),
                motions=[motion_message(snapshot, motion) for motion in (*ended, *state.motions)],
                speed_factor=state.speed_factor,
            )

    async def WatchMotionSteps(
        self, request: motion_pb2.WatchMotionStepsRequest, context: object
    ) -> AsyncIterator[motion_pb2.WatchMotionStepsResponse]:
        """Tell what becomes of a motion's steps, none left out, until its end."""
        id, events, told = request.id, StepEvents(), False
        find_motion(self._kernel.world.snapshot, id)
        async with aclosing(self._kernel.publications.every_tick(request.max_rate_hertz)) as parts:
            async for part in parts:
                response, over = motion_pb2.WatchMotionStepsResponse(), False
                for lost, snapshot in part:
                    if lost:
                        said = f"the reader of this watch is late, and {lost} ticks are lost; watch again"
                        raise KernelError(said, reason=Reason.WRONG_STATE, motion=id)
                    motion = find_motion(snapshot, id)
                    add_step_events(response, snapshot, events.look(motion.running, motion.step_count))
                    over = motion not in snapshot.state.motions
                    if over or snapshot is part[-1][1]:
                        response.stamp.CopyFrom(stamp(snapshot))
                        response.motion.CopyFrom(motion_message(snapshot, motion))
                        break
                if response.events or over or not told:
                    yield response
                    told = True
                if over:
                    return

    async def HoldMotion(
        self, request_iterator: AsyncIterator[motion_pb2.HoldMotionRequest], context: object
    ) -> AsyncIterator[motion_pb2.HoldMotionResponse]:
        """Let a motion run while beats come."""
        first = await anext(aiter(request_iterator), motion_pb2.HoldMotionRequest())
        id = first.id
        find_motion(self._kernel.world.snapshot, id)
        with self._watching(id):
            async with aclosing(self._holds.hold(first, request_iterator, context)) as snapshots:
                async for snapshot in snapshots:
                    motion = motion_message(snapshot, find_motion(snapshot, id))
                    yield motion_pb2.HoldMotionResponse(stamp=stamp(snapshot), motion=motion)

    async def PauseMotion(
        self, request: motion_pb2.PauseMotionRequest, context: object
    ) -> motion_pb2.PauseMotionResponse:
        """Slow a motion to standstill."""
        snapshot, motion = await self._changed(PauseMotion(request.id), request.id, context)
        return motion_pb2.PauseMotionResponse(motion=motion, stamp=stamp(snapshot))

    async def ResumeMotion(
        self, request: motion_pb2.ResumeMotionRequest, context: object
    ) -> motion_pb2.ResumeMotionResponse:
        """Resume a motion that was paused; one that runs stays as it is."""
        self._holds.check_free(request.id)
        snapshot, motion = await self._changed(ResumeMotion(request.id), request.id, context)
        return motion_pb2.ResumeMotionResponse(motion=motion, stamp=stamp(snapshot))

    async def StepMotion(self, request: motion_pb2.StepMotionRequest, context: object) -> motion_pb2.StepMotionResponse:
        """Let a motion go on to the end of its present step."""
        self._holds.check_free(request.id)
        snapshot, motion = await self._changed(StepMotion(request.id), request.id, context)
        return motion_pb2.StepMotionResponse(motion=motion, stamp=stamp(snapshot))

    async def CancelMotion(
        self, request: motion_pb2.CancelMotionRequest, context: object
    ) -> motion_pb2.CancelMotionResponse:
        """Slow a motion to standstill and end it."""
        command = CancelMotion(request.id, Cancellation(EndCause.CALL, request.reason or "cancelled"))
        snapshot, motion = await self._changed(command, request.id, context)
        return motion_pb2.CancelMotionResponse(motion=motion, stamp=stamp(snapshot))

    async def Stop(self, request: motion_pb2.StopRequest, context: object) -> motion_pb2.StopResponse:
        """Cancel all motions, or all of some robots."""
        going = {motion.id for motion in self._kernel.world.snapshot.state.motions if not motion.cancellation}
        applied = await self._submit([StopMotions(tuple(request.robots), f"stopped by {person(context)}")], context)
        snapshot = applied.snapshot
        motions = (*snapshot.state.motions, *snapshot.state.ended)
        stopped = [one for one in motions if one.cancellation and one.id in going]
        told = [motion_message(snapshot, motion) for motion in stopped]
        return motion_pb2.StopResponse(motions=told, stamp=stamp(snapshot))

    async def _progressed(self, seen: Snapshot, id: str, pause: float) -> Snapshot:
        """Return a later snapshot, after `pause` seconds or once the motion has ended."""
        await self._kernel.publications.end_of_motion(id, pause)
        return await self._kernel.publications.newer_than(seen)

    async def _changed(self, command: Command, id: str, context: object) -> tuple[Snapshot, motion_pb2.Motion]:
        snapshot = (await self._submit([command], context)).snapshot
        return snapshot, motion_message(snapshot, find_motion(snapshot, id))

    async def _submit(self, commands: Sequence[Command], context: object) -> Applied:
        return await asyncio.wrap_future(self._kernel.submit(commands, context))

    @contextmanager
    def _watching(self, id: str) -> Iterator[None]:
        """Count as somebody who watches a motion, for the length of a block."""
        self._watchers[id] += 1
        try:
            yield
        finally:
            self._watchers[id] -= 1
            if not self._watchers[id]:
                del self._watchers[id]
            self._check_later(id)

    def _started(self, loop: asyncio.AbstractEventLoop, hold: bool, started: Future[Applied]) -> None:
        """Bind a motion to its watch; called by the world thread once it is started, or refused."""
        if not (started.cancelled() or started.exception() or loop.is_closed()):
            grace = HELD_GRACE_SECONDS if hold else GRACE_SECONDS
            loop.call_soon_threadsafe(self._bind, str(started.result().created[0]), grace)

    def _bind(self, id: str, grace: float) -> None:
        loop = asyncio.get_running_loop()
        self._bound[id] = grace, loop.call_later(grace, self._check, id, loop.time() + grace)

    def _check_later(self, id: str) -> None:
        """Give a motion that is bound to its watch the whole grace from now on."""
        if id in self._bound:
            grace, timer = self._bound[id]
            timer.cancel()
            self._bind(id, grace)

    def _check(self, id: str, due: float) -> None:
        """Cancel a motion when nobody watches it; else the end of its watch checks again.

        A kernel that is late itself has not looked yet who wants to watch: then it waits once more.
        """
        if self._watchers[id]:
            return
        if asyncio.get_running_loop().time() > due + LATE_SECONDS:
            self._bind(id, self._bound[id][0])
            return
        grace, _ = self._bound.pop(id)
        if any(motion.id == id for motion in self._kernel.world.snapshot.state.motions):
            reason = f"nobody has watched it for {grace:g} s"
            self._kernel.world.submit([CancelMotion(id, Cancellation(EndCause.UNWATCHED, reason))], "kernel")


def _same_motions(before: Snapshot, after: Snapshot) -> bool:
    """Return whether the same motions run, as far as they did, under the same names."""
    one, other = before.state, after.state
    running = len(one.motions) == len(other.motions) and all(map(is_, one.motions, other.motions))
    named = not other.motions or before.structure is after.structure
    return running and named and one.speed_factor == other.speed_factor
