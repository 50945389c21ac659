"""The history of the world: listed, watched, undone, and kept as checkpoints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot._wire.arguments import Count, Text, checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.history.values import KINDS, Checkpoint, Step, kind_name
from virtualrobot.v1 import history_pb2

_PAGE = 1000


@checked
class History:
    """The steps of one kernel's world, newest last in number, and its checkpoints.

    Example:
        >>> for step in client.history.list(node="table"):
        ...     print(step.number, step.author, step.label)
        >>> client.undo()
        >>> client.history.checkpoint("before lunch")
        >>> client.history.restore("before lunch")
    """

    def __init__(self, services: Services) -> None:
        """Handle the history of one kernel."""
        self._services = services

    def list(
        self,
        *,
        node: str | None = None,
        author: Text | None = None,
        mine: bool = False,
        since: datetime | None = None,
        until: datetime | None = None,
        kinds: Sequence[str] = (),
        limit: Count = 100,
    ) -> list[Step]:
        """Return steps, newest first.

        Args:
            node: only those that changed this node, by its present name or one that it had.
            author: only those whose author has these words in its name, in any case.
            mine: only those of this client.
            since: only those at this time or later, by the kernel's clock; without a time zone it is local time.
            until: only those before this time.
            kinds: only those of these kinds, such as `edit`; see `Step.kind`.
            limit: the greatest number of them.
        """
        for kind in kinds:
            if kind not in KINDS:
                raise InvalidArgumentError(f"a kind of steps is one of {', '.join(KINDS)}, not {kind!r}")
        request = history_pb2.ListStepsRequest(
            node=node,
            author=author,
            only_mine=mine,
            since=_timestamp(since),
            until=_timestamp(until),
            kinds=map(kind_name, kinds),
        )
        steps: list[Step] = []
        while True:
            request.page_size = min(limit - len(steps), _PAGE)
            answer = self._services.history.ListSteps(request)
            steps += map(Step.of, answer.steps)
            request.page_token = answer.next_page_token
            if not request.page_token or len(steps) >= limit:
                return steps

    def watch(self, since: int | None = None) -> Iterator[Step]:
        """Yield steps as they are done, none left out; what is dragged comes again as it grows, with its first number.

        `since` is the number of the first one; by default those that come from now on. It is watched from the call on.

        Raises:
            WrongStateError: when the step of this number is not kept any more.
        """
        stream = self._services.history.WatchSteps(history_pb2.WatchStepsRequest(from_number=since))
        first = next(stream)  # the kernel watches from here on

        def steps() -> Iterator[Step]:
            with stream:
                yield from map(Step.of, first.steps)
                for response in stream:
                    yield from map(Step.of, response.steps)

        return steps()

    def undo(self, number: int | None = None, *, mine: bool = False, request_id: str | None = None) -> Step:
        """Take a step back: by default the newest edit that stands, with `mine` of this client's; return the undo.

        An undo is a change like any other: others see it, and it is undone by `redo`. It changes what the step changed
        and nothing else. Motion, values of signals and readings stay; `restore` brings the whole world back.

        Args:
            number: the step's number.
            mine: takes back only what this client has done.
            request_id: a name of this call: sent again it does nothing twice.

        Raises:
            ConflictError: when something of it was changed since; the message says what, and by whom.
            RobotBusyError: when it would change a robot that moves.
            LeasedError: when it would change a robot that somebody else has leased.
            WrongStateError: when there is nothing to undo.

        Example:
            >>> client.scene.set_pose("table", virtualrobot.pose(0.1))
            >>> client.undo().label
            "took back: moved 'table' by 0.10 m"
        """
        request = history_pb2.UndoRequest(only_mine=mine, number=number, request_id=request_id)
        return Step.of(self._services.history.Undo(request).step)

    def redo(self, number: int | None = None, *, mine: bool = False, request_id: str | None = None) -> Step:
        """Take an undo back: by default the newest one, when nothing was edited since; return the redo.

        Args:
            number: the number of the undo, or of the step that it took back.
            mine: takes back only what this client has undone.
            request_id: a name of this call: sent again it does nothing twice.

        Raises:
            ConflictError: as `undo` does.
            WrongStateError: when there is nothing to redo.
        """
        request = history_pb2.RedoRequest(only_mine=mine, number=number, request_id=request_id)
        return Step.of(self._services.history.Redo(request).step)

    def checkpoint(self, name: str | None = None, *, request_id: str | None = None) -> Checkpoint:
        """Keep the world as it is under a name, by default one that the kernel gives; return the checkpoint.

        Raises:
            NameTakenError: when another checkpoint has the name.
        """
        request = history_pb2.CreateCheckpointRequest(name=name, request_id=request_id)
        return Checkpoint.of(self._services.history.CreateCheckpoint(request).checkpoint)

    @property
    def checkpoints(self) -> dict[str, Checkpoint]:
        """The checkpoints by name, oldest first."""
        answer = self._services.history.ListCheckpoints(history_pb2.ListCheckpointsRequest())
        return {message.name: Checkpoint.of(message) for message in answer.checkpoints}

    def restore(self, name: str, *, request_id: str | None = None) -> Checkpoint:
        """Put the world back to how it was at a checkpoint, joints included; return one of how it was before.

        Motions end and all stands still; time goes on. What this returns is the way back.

        Raises:
            UnknownNameError: when there is no such checkpoint.
            LeasedError: when somebody else has leased a robot.
        """
        request = history_pb2.RestoreCheckpointRequest(name=name, request_id=request_id)
        return Checkpoint.of(self._services.history.RestoreCheckpoint(request).before)

    def remove_checkpoint(self, name: str) -> None:
        """Forget a checkpoint; the world stays as it is."""
        self._services.history.RemoveCheckpoint(history_pb2.RemoveCheckpointRequest(name=name))

    def __repr__(self) -> str:
        """Return the newest steps."""
        return told("History", lambda: listed((step.label for step in self.list(limit=9)), "nothing yet"))


def _timestamp(time: datetime | None) -> Timestamp | None:
    if time is None:
        return None
    message = Timestamp()
    message.FromDatetime(time.astimezone(UTC).replace(tzinfo=None))
    return message
