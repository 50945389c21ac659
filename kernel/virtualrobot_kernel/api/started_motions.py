"""Answers of starts that carry a request id, so that a repeated start is harmless."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from contextlib import AbstractAsyncContextManager, nullcontext
from hashlib import sha256
from weakref import WeakValueDictionary

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.errors import KernelError

REMEMBERED = 1000
"""Number of request ids remembered."""

LONGEST = 256
"""Greatest number of characters of a request id."""

Answer = asyncio.Task[motion_pb2.StartMotionResponse]


class StartedMotions:
    """Newest starts by their request ids. Used by the thread “api” only."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._answers: OrderedDict[str, tuple[bytes, Answer]] = OrderedDict()
        self._turns: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()

    def turn(self, id: str) -> AbstractAsyncContextManager[object]:
        """Return what lets one start after the other of the same id pass; all of them where it is empty."""
        if len(id) > LONGEST:
            raise KernelError(f"request_id has at most {LONGEST} characters, not {len(id)}", field="request_id")
        return self._turns.setdefault(id, asyncio.Lock()) if id else nullcontext()

    def find(self, request: motion_pb2.StartMotionRequest) -> Answer | None:
        """Return the answer of an earlier start of the same id, None where there is none or it was refused.

        Raises KernelError when the id was that of another request.
        """
        digest, answer = self._answers.get(request.request_id, (b"", None))
        if answer is None or (answer.done() and (answer.cancelled() or answer.exception())):
            return None
        if digest != _digest(request):
            raise KernelError(
                f"request_id {request.request_id!r} was that of another request; give each start an id of its own",
                field="request_id",
            )
        return answer

    def remember(self, request: motion_pb2.StartMotionRequest, answer: Answer) -> None:
        """Remember the answer of a start that has an id, and forget the oldest."""
        # Its caller may be gone, and nobody else asks for its error.
        answer.add_done_callback(lambda done: done.cancelled() or done.exception())
        if request.request_id:
            self._answers[request.request_id] = _digest(request), answer
            if len(self._answers) > REMEMBERED:
                self._answers.popitem(last=False)


def _digest(request: motion_pb2.StartMotionRequest) -> bytes:
    return sha256(request.SerializeToString(deterministic=True)).digest()
