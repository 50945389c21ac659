"""Engine on a thread of its own, so that the world never waits long for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from virtualrobot_kernel.components.catalog import Offer
from virtualrobot_kernel.components.running import ComponentHandle, start
from virtualrobot_kernel.lateness import Aside, Late, awaited
from virtualrobot_kernel.physics.running import Running

Question = tuple[object, ...]
"""Name of a method of the engine, and its arguments."""


class Engine:
    """Engine of a world, which is made when it is first asked."""

    def __init__(self, offer: Offer, settings: Mapping[str, Any]) -> None:
        """Begin a thread for the engine that a plugin offers, with its own settings."""
        self.handle: ComponentHandle | None = None
        """Component, None until it is made."""
        self._offer, self._settings = offer, settings
        self._aside = Aside("physics engine")
        self._closed = False

    def ask(self, questions: Sequence[Question]) -> Future[object]:
        """Have questions asked one after another; return the answer to the last one that is to come.

        It raises KernelError, as `start` and the calls of components do.
        """
        return self._aside.ask(lambda: self._answer(questions))

    def awaited(self, answer: Future[object]) -> object:
        """Return an answer, or raise its KernelError; raises Late where it does not come at once."""
        try:
            return awaited(answer)
        except Late:
            if self.handle is not None and (hung := self.handle.hung) is not None:
                raise self.handle.failed(hung) from None  # what hangs in this process never answers
            raise

    def close(self) -> None:
        """End the engine; what it is asked just now fails."""
        self._closed = True
        if self.handle is not None:
            self.handle.close()
        self._aside.close()

    def _answer(self, questions: Sequence[Question]) -> object:
        if self.handle is None:
            self.handle = start(self._offer, self._settings, user=" of the world")
        if self._closed:
            self.handle.close()
        answer: object = None
        for method, *arguments in questions:
            answer = self.handle.call(str(method), *arguments)
        return answer


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """Tick that an engine was asked for.

    running: the scene that it has, and how the world was. same: whether of motors the same was commanded as in the
    tick before. answer: what is to come.
    """

    running: Running
    same: bool
    answer: Future[object]
