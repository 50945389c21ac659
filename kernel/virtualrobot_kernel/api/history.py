"""HistoryService: steps, undo and redo, checkpoints."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import aclosing
from typing import ParamSpec, TypeVar

from google.protobuf.timestamp_pb2 import Timestamp
from virtualrobot.v1 import geometry_pb2, history_pb2, history_pb2_grpc

from virtualrobot_kernel.api.author import author, is_mine
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.repeats import Repeats
from virtualrobot_kernel.collision.readiness import is_to_be_ready, make_ready
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.history.checkpoints import Checkpoint
from virtualrobot_kernel.history.step import MOST_NAMED, Step, StepKind
from virtualrobot_kernel.history.steps import Mine, Wanted, page, taking_back
from virtualrobot_kernel.messages.values import stamp
from virtualrobot_kernel.world.apply_records import Conflict
from virtualrobot_kernel.world.commands import Command
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import Applied

USUAL_PAGE = 100
MOST_OF_A_PAGE = 1000
"""Number of steps of an answer, where none is asked for, and at most."""

FIRST_SECOND, LAST_SECOND = -62_135_596_800, 253_402_300_799
"""Seconds since 1970 that a Timestamp may have: of the years 1 to 9999, by its own definition."""

P = ParamSpec("P")
Answer = TypeVar("Answer")

KINDS = {kind: getattr(history_pb2, f"STEP_KIND_{kind.name}") for kind in StepKind}


class HistoryServicer(history_pb2_grpc.HistoryServiceServicer):
    """Servicer of HistoryService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._repeats = Repeats()

    async def ListSteps(self, request: history_pb2.ListStepsRequest, context: object) -> history_pb2.ListStepsResponse:
        """Tell steps, newest first."""
        snapshot, mine = self._kernel.world.snapshot, is_mine(context)
        size = request.page_size or USUAL_PAGE
        if size > MOST_OF_A_PAGE:
            raise KernelError(
                f"page_size is at most {MOST_OF_A_PAGE}, not {size}", field="page_size", limit=MOST_OF_A_PAGE
            )
        wanted, before = _wanted(snapshot, request, mine), _page_start(request.page_token)
        find = self._kernel.history.steps.store.find
        steps, more = await self._asked(lambda: page(find(wanted, before, whole=False), size))
        return history_pb2.ListStepsResponse(
            stamp=stamp(snapshot),
            steps=[self._message(snapshot, step, mine) for step in steps],
            next_page_token=str(steps[-1].number) if more else "",
        )

    async def WatchSteps(
        self, request: history_pb2.WatchStepsRequest, context: object
    ) -> AsyncIterator[history_pb2.WatchStepsResponse]:
        """Tell steps as they are done, from one on."""
        steps, mine = self._kernel.history.steps, is_mine(context)
        if 0 < request.from_number <= steps.store.forgotten:
            raise KernelError(
                f"the steps up to {steps.store.forgotten} are not all kept any more; watch from a later one",
                reason=Reason.WRONG_STATE,
                from_number=request.from_number,
                forgotten=steps.store.forgotten,
            )
        await self._kernel.in_worker(self._kernel.history.settle)  # what was done before is not new
        async with aclosing(self._kernel.publications.every(steps.subscribe)) as told:
            last: int | None = None
            async for some in told:
                new: Sequence[Step] = some
                if last is None:  # what came between listening and looking comes twice
                    if request.from_number:
                        new = await self._asked(steps.since, request.from_number)
                    last = max((one.number for one in new), default=0)
                else:
                    new = [step for step in some if step.number > last]
                    if not new:
                        continue
                for at in range(0, max(1, len(new)), USUAL_PAGE):
                    snapshot = self._kernel.world.snapshot
                    messages = [self._message(snapshot, step, mine) for step in new[at : at + USUAL_PAGE]]
                    yield history_pb2.WatchStepsResponse(stamp=stamp(snapshot), steps=messages)

    async def Undo(self, request: history_pb2.UndoRequest, context: object) -> history_pb2.UndoResponse:
        """Take a step back."""
        return await self._repeats.once(request, lambda: self._undo(request, context))

    async def _undo(self, request: history_pb2.UndoRequest, context: object) -> history_pb2.UndoResponse:
        steps, mine = self._kernel.history.steps, _mine_if(request.only_mine, context)
        undone = await self._asked(steps.to_undo, _number(request), mine)
        snapshot, step, undone = await self._take_back(undone, context)
        return history_pb2.UndoResponse(stamp=stamp(snapshot), step=step, undone=undone)

    async def Redo(self, request: history_pb2.RedoRequest, context: object) -> history_pb2.RedoResponse:
        """Take an undo back."""
        return await self._repeats.once(request, lambda: self._redo(request, context))

    async def _redo(self, request: history_pb2.RedoRequest, context: object) -> history_pb2.RedoResponse:
        steps = self._kernel.history.steps
        number, mine = _number(request), _mine_if(request.only_mine, context)

        def found() -> tuple[Step, Step | None]:
            undo = steps.to_redo(number, mine)
            return undo, steps.store.get(undo.undoes)

        undo, redone = await self._asked(found)
        snapshot, step, _ = await self._take_back(undo, context)
        told = self._message(snapshot, redone, is_mine(context)) if redone else None
        return history_pb2.RedoResponse(stamp=stamp(snapshot), step=step, redone=told)

    async def _take_back(self, step: Step, context: object) -> tuple[Snapshot, history_pb2.Step, history_pb2.Step]:
        """Take a step back; return the world then, what did it, and the step as it is then."""
        steps, mine = self._kernel.history.steps, is_mine(context)
        try:
            applied = await self._submit(taking_back(step), context)
        except Conflict as error:
            raise await self._asked(steps.conflict, step, error) from None
        snapshot = applied.snapshot
        made = self._message(snapshot, await self._asked(steps.taken_back_by, step.number), mine)
        return snapshot, made, self._message(snapshot, step, mine)

    async def CreateCheckpoint(
        self, request: history_pb2.CreateCheckpointRequest, context: object
    ) -> history_pb2.CreateCheckpointResponse:
        """Keep the world as it is."""

        async def create() -> history_pb2.CreateCheckpointResponse:
            made = await self._asked(self._kernel.history.checkpoints.create, request.name, author(context))
            return history_pb2.CreateCheckpointResponse(stamp=self._stamp(), checkpoint=_checkpoint(made))

        return await self._repeats.once(request, create)

    async def ListCheckpoints(
        self, request: history_pb2.ListCheckpointsRequest, context: object
    ) -> history_pb2.ListCheckpointsResponse:
        """Tell the checkpoints."""
        found = await self._asked(lambda: self._kernel.history.checkpoints.all)
        return history_pb2.ListCheckpointsResponse(stamp=self._stamp(), checkpoints=map(_checkpoint, found))

    async def RestoreCheckpoint(
        self, request: history_pb2.RestoreCheckpointRequest, context: object
    ) -> history_pb2.RestoreCheckpointResponse:
        """Put the world back to how it was."""

        async def restore() -> history_pb2.RestoreCheckpointResponse:
            checkpoints = self._kernel.history.checkpoints
            found = await self._asked(checkpoints.get, request.name)
            command = await self._kernel.in_worker(checkpoints.restoring, found)
            applied = await self._submit(command, context)
            before = await self._asked(checkpoints.left_by, command)
            return history_pb2.RestoreCheckpointResponse(
                stamp=stamp(applied.snapshot),
                checkpoint=_checkpoint(found),
                before=None if before is None else _checkpoint(before),
            )

        return await self._repeats.once(request, restore)

    async def RemoveCheckpoint(
        self, request: history_pb2.RemoveCheckpointRequest, context: object
    ) -> history_pb2.RemoveCheckpointResponse:
        """Forget a checkpoint."""
        gone = await self._asked(self._kernel.history.checkpoints.remove, request.name)
        return history_pb2.RemoveCheckpointResponse(stamp=self._stamp(), checkpoint=_checkpoint(gone))

    async def _asked(self, question: Callable[P, Answer], *about: P.args, **named: P.kwargs) -> Answer:
        """Return what the history answers once all that was told so far is in it."""

        def answer() -> Answer:
            self._kernel.history.settle()
            return question(*about, **named)

        return await self._kernel.in_worker(answer)

    def _stamp(self) -> geometry_pb2.Stamp:
        return stamp(self._kernel.world.snapshot)

    async def _submit(self, command: Command, context: object) -> Applied:
        snapshot = self._kernel.world.snapshot
        if is_to_be_ready(snapshot, [command]):
            await self._kernel.in_worker(make_ready, self._kernel.collisions.shapes, snapshot, [command])
        return await asyncio.wrap_future(self._kernel.submit([command], context))

    def _message(self, snapshot: Snapshot, step: Step, mine: Mine) -> history_pb2.Step:
        nodes, last = snapshot.structure.nodes, dict(step.names)
        names = (nodes[uid].name if uid in nodes else last.get(uid) for uid in sorted(step.touched)[:MOST_NAMED])
        return history_pb2.Step(
            number=step.number,
            first_number=step.first_number,
            kind=KINDS[step.kind],
            label=step.label,
            author=step.author,
            mine=mine(step.author),
            time=_timestamp(step.wall_time),
            tick=step.tick,
            nodes=[name for name in names if name is not None],
            undone=self._kernel.history.steps.is_undone(step),
            undoes=step.undoes,
        )


def _wanted(snapshot: Snapshot, request: history_pb2.ListStepsRequest, mine: Mine) -> Wanted:
    kinds = {number: kind for kind, number in KINDS.items()}
    for number in request.kinds:
        if number not in kinds:
            raise KernelError(f"there is no kind of steps with the number {number}", field="kinds", value=number)
    uid = snapshot.structure.uid_by_name.get(request.node)
    return Wanted(
        node=request.node,
        uids=frozenset() if uid is None else frozenset({uid}),
        author=request.author,
        mine=mine if request.only_mine else None,
        since=_seconds(request, "since"),
        until=_seconds(request, "until"),
        kinds=frozenset(kinds[number] for number in request.kinds),
    )


def _page_start(token: str) -> int | None:
    if token and not (token.isascii() and token.isdigit() and len(token) < 19):
        raise KernelError(
            f"page_token must be the next_page_token of another answer, not {token[:40]!r}", field="page_token"
        )
    return int(token) if token else None


def _number(request: history_pb2.UndoRequest | history_pb2.RedoRequest) -> int | None:
    return request.number if request.HasField("number") else None


def _mine_if(only_mine: bool, context: object) -> Callable[[str], bool] | None:
    return is_mine(context) if only_mine else None


def _seconds(request: history_pb2.ListStepsRequest, field: str) -> float | None:
    if not request.HasField(field):
        return None
    time: Timestamp = getattr(request, field)
    if not (FIRST_SECOND <= time.seconds <= LAST_SECOND and 0 <= time.nanos < 10**9):
        raise KernelError(
            f"{field} is no time between the years 1 and 9999: {time.seconds} s and {time.nanos} ns since 1970",
            field=field,
        )
    return time.seconds + time.nanos * 1e-9


def _timestamp(seconds: float) -> Timestamp:
    message = Timestamp()
    message.FromNanoseconds(round(seconds * 1e9))
    return message


def _checkpoint(checkpoint: Checkpoint) -> history_pb2.Checkpoint:
    return history_pb2.Checkpoint(
        name=checkpoint.name,
        author=checkpoint.author,
        time=_timestamp(checkpoint.wall_time),
        tick=checkpoint.tick,
        node_count=checkpoint.node_count,
        automatic=checkpoint.automatic,
    )
