"""Records that all clients share: what one tells of itself, and what others wish of it. None is part of the world."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncGenerator
from dataclasses import dataclass, replace
from typing import Any

from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.shelf import Shelf
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.listeners import Listeners

MOST_REMEMBERED = 100
"""Greatest number of records that are remembered; of those that are over the oldest goes first."""

LARGEST_BYTES = 32_768
"""Greatest size of a content (bytes): all records are told in one message, and gRPC clients take 4 MiB by default."""

MOST_WISHES = 100
"""Greatest number of wishes that wait for the client that holds a record."""

UNHELD_SECONDS = 5.0
"""Time (s of the wall clock) for which a record stays that nobody holds and nobody keeps."""


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """Record at one revision; the attributes are those of `Record` in the contract."""

    id: str
    revision: int
    kind: str
    title: str
    state: str
    content: str
    wishes: tuple[str, ...]
    keep: bool
    is_over: bool
    author: str
    changed_by: str
    is_held: bool = False


@dataclass(frozen=True, slots=True)
class Wish:
    """Word that somebody files for the holder of a record, with more about it."""

    word: str
    text: str
    author: str


class Records(Shelf[Record]):
    """Records by name, oldest first, and the wishes on their way to who holds them."""

    def __init__(self, unheld_seconds: float = UNHELD_SECONDS) -> None:
        """Begin with none."""
        super().__init__("record", MOST_REMEMBERED)
        self._unheld_seconds = unheld_seconds
        self._wishes: dict[str, deque[Wish]] = {}
        self._filed: Listeners[[object]] = Listeners()
        self._timers: dict[str, asyncio.TimerHandle] = {}

    def create(self, author: str, **fields: Any) -> Record:  # noqa: ANN401 fields of a record
        """Make a record; raise KernelError (WRONG_STATE) where all that are remembered go on."""
        self.make_room(
            lambda one: one.is_over and not one.is_held,
            "records are kept that are not over, and no more than that; forget some, or have them be over",
        )
        made = self.put(Record(self.new_id(), 1, author=author, changed_by=author, **fields))
        self._forget_later(made)
        return made

    def update(self, seen: Record, by: str, **fields: Any) -> Record:  # noqa: ANN401 fields of a record
        """Change a record and return it; raise KernelError (WRONG_STATE) for one that is over."""
        self._check_goes_on(seen)
        now = self._changed(seen, changed_by=by, **fields)
        self._forget_later(now)
        return now

    def forget(self, seen: Record) -> None:
        """Forget a record; raise KernelError (WRONG_STATE) where a client holds it and it is not over."""
        if seen.is_held and not seen.is_over:
            said = f"wish {' or '.join(map(repr, seen.wishes))} of that" if seen.wishes else "wait for its end"
            raise KernelError(f"{seen.id!r} is held by its client; {said}", reason=Reason.WRONG_STATE, record=seen.id)
        self.remove(seen.id)

    def file(self, seen: Record, wish: Wish) -> None:
        """Tell a wish to who holds a record; raise KernelError where nobody does, and for another word."""
        self._check_goes_on(seen)
        waiting = self._wishes.get(seen.id)
        if waiting is None:
            raise KernelError(
                f"nobody holds {seen.id!r}: its client is gone, and hears no wishes",
                reason=Reason.WRONG_STATE,
                record=seen.id,
            )
        if wish.word not in seen.wishes:
            there = ", ".join(map(repr, seen.wishes)) or "none"
            raise KernelError(
                f"{seen.id!r} takes no wish {wish.word!r}; those that it takes now: {there}",
                field="word",
                record=seen.id,
            )
        if len(waiting) >= MOST_WISHES:
            raise KernelError(
                f"{MOST_WISHES} wishes wait for the client that holds {seen.id!r}, which does not hear them",
                reason=Reason.WRONG_STATE,
                record=seen.id,
            )
        waiting.append(wish)
        self._filed.tell(wish)

    async def hold(self, id: str, publications: Publications) -> AsyncGenerator[list[Wish], None]:
        """Hold a record until this ends: yield nothing at once, then wishes as they are filed."""
        seen = self.find(id)
        if id in self._wishes:
            raise KernelError(f"another call holds {id!r} already", reason=Reason.WRONG_STATE, record=id)
        waiting = self._wishes[id] = deque()
        each = publications.each(self._both)
        try:
            self._forget_later(self._changed(seen, is_held=True))
            yield []
            async for _ in each:
                if not self._has(id):
                    return
                if waiting:
                    told = [*waiting]
                    waiting.clear()
                    yield told
        finally:
            await each.aclose()
            del self._wishes[id]
            if self._has(id):
                self._forget_later(self._changed(self.find(id), is_held=False))

    def _both(self, listener: Any) -> Any:  # noqa: ANN401 as `subscribe`
        """Call `listener` after each wish and each change, until the returned function is called."""
        ends = (self._filed.add(listener), self.subscribe(listener))
        return lambda: [end() for end in ends]

    def _has(self, id: str) -> bool:
        return id in self._by_id

    def _changed(self, record: Record, **changes: Any) -> Record:  # noqa: ANN401 fields of a record
        return self.put(replace(record, revision=record.revision + 1, **changes))

    def _check_goes_on(self, record: Record) -> None:
        if record.is_over:
            raise KernelError(
                f"{record.id!r} is over, and changes no more; make another record",
                reason=Reason.WRONG_STATE,
                record=record.id,
            )

    def _forget_later(self, record: Record) -> None:
        """Forget a record in a while, unless somebody holds it or keeps it then."""
        if (timer := self._timers.pop(record.id, None)) is not None:
            timer.cancel()
        if record.keep or record.is_held:
            return

        def forget() -> None:
            del self._timers[record.id]
            if self._has(record.id):
                self.remove(record.id)

        self._timers[record.id] = asyncio.get_running_loop().call_later(self._unheld_seconds, forget)
