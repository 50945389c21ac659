"""Shelf of things that all clients share and that are no part of the world: by name, with revisions, told to watchers.

The API's thread alone reads and changes it.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Iterable
from contextlib import aclosing
from typing import Any, Generic, Protocol, TypeVar

from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world.listeners import Listeners

LONGEST_TEXT = 200
"""Greatest number of characters of a line for people, such as a title."""


class Shared(Protocol):
    """Thing on a shelf, at one revision; it never changes, another one takes its place."""

    @property
    def id(self) -> str:
        """Its name."""
        ...

    @property
    def revision(self) -> int:
        """Count of its changes, from 1."""
        ...

    @property
    def changed_by(self) -> str:
        """Name of who changed it last."""
        ...


Thing = TypeVar("Thing", bound=Shared)


class Shelf(Generic[Thing]):
    """Things of one noun by name, oldest first, so many at most."""

    def __init__(self, noun: str, most: int) -> None:
        """Begin with none; names are made of the noun and a number."""
        self._noun, self._most = noun, most
        self._by_id: dict[str, Thing] = {}
        self._count = 0
        self._listeners: Listeners[[object]] = Listeners()

    @property
    def all(self) -> list[Thing]:
        """All of them, oldest first."""
        return [*self._by_id.values()]

    def find(self, id: str, expected_revision: int | None = None) -> Thing:
        """Return a thing; raise KernelError for one that there is not, and for another revision than is expected."""
        thing = self._by_id.get(id)
        if thing is None:
            raise UnknownNameError(self._noun, id, self._by_id)
        if expected_revision is not None and expected_revision != thing.revision:
            raise KernelError(
                f"{id!r} has the revision {thing.revision}, not {expected_revision}: {thing.changed_by} has "
                "changed it meanwhile; look at it again",
                reason=Reason.STALE_REVISION,
                **{self._noun: id},
                expected=expected_revision,
                revision=thing.revision,
            )
        return thing

    def make_room(self, is_over: Callable[[Thing], bool], full: str) -> Thing | None:
        """Forget the oldest thing that is over where there are as many as may be, and return it.

        Raise KernelError (WRONG_STATE) where none is over; `full` says what to do then.
        """
        if len(self._by_id) < self._most:
            return None
        over = next((one for one in self._by_id.values() if is_over(one)), None)
        if over is None:
            raise KernelError(f"{len(self._by_id)} {full}", reason=Reason.WRONG_STATE)
        return self._by_id.pop(over.id)

    def new_id(self) -> str:
        """Return a name that was never used."""
        self._count += 1
        return f"{self._noun}-{self._count}"

    def put(self, thing: Thing) -> Thing:
        """Keep a thing in place of what had its name, tell of it, and return it."""
        self._by_id[thing.id] = thing
        self._listeners.tell(thing)
        return thing

    def remove(self, id: str) -> None:
        """Forget a thing, and tell of that."""
        self._listeners.tell(self._by_id.pop(id))

    def subscribe(self, listener: Callable[[object], None]) -> Callable[[], None]:
        """Call `listener` after each change, until the returned function is called."""
        return self._listeners.add(listener)

    async def changes(
        self, publications: Publications, wanted: Callable[[Thing], bool] = lambda _: True
    ) -> AsyncGenerator[tuple[list[Thing], list[str]], None]:
        """Yield all things that are wanted, then new or changed ones, with the names of those that are gone."""
        told: list[Thing] | None = None
        async with aclosing(publications.each(self.subscribe)) as woken:
            async for _ in woken:
                now = [one for one in self._by_id.values() if wanted(one)]
                changed, gone = changes(told or (), now)
                if changed or gone or told is None:
                    yield changed, gone
                told = now


def changes(told: Iterable[Thing], now: Iterable[Thing]) -> tuple[list[Thing], list[str]]:
    """Return which things are new or others than those that were told, and the names of those that are gone."""
    known, kept = {one.id: one for one in told}, [*now]
    gone = known.keys() - {one.id for one in kept}
    return [one for one in kept if known.get(one.id) is not one], [id for id in known if id in gone]


def seen_revision(request: Any) -> int | None:  # noqa: ANN401 any message with the field
    """Return the revision that a request is meant for; None: any."""
    return request.expected_revision if request.HasField("expected_revision") else None


def line_of(text: str, field: str, longest: int = LONGEST_TEXT) -> str:
    """Return a line for people; raise KernelError for more than is kept."""
    if len(text) > longest or not text.isprintable():
        raise KernelError(
            f"{field} is one line of at most {longest} characters that can be printed, not {text!r:.80}",
            field=field,
        )
    return text
