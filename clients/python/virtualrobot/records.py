"""Records: what clients tell each other through the kernel: programs at work, results of processes, notes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from virtualrobot._wire.arguments import Text, checked
from virtualrobot._wire.messages import Stamp, stamp_of
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, shown, told
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import record_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A record as it was at one revision.

    Attributes:
        id: its name, never used again.
        revision: from 1, one more with each change.
        kind: the schema of its content, such as `task`.
        title: its subject in words.
        state: a word or line that its kind defines.
        content: what it holds, of JSON; text that is no JSON is as it is.
        wishes: the words that `wish` takes now.
        keep: it stays when nobody holds it.
        is_over: it changes no more.
        is_held: a client holds it, and hears wishes.
        author: who made it.
        changed_by: who changed it last.
    """

    id: str
    revision: int
    kind: str
    title: str
    state: str
    content: Any
    wishes: tuple[str, ...]
    keep: bool
    is_over: bool
    is_held: bool
    author: str
    changed_by: str

    @staticmethod
    def of(message: record_pb2.Record) -> Record:
        """Return what a message tells."""
        return Record(
            message.id,
            message.revision,
            message.kind,
            message.title,
            message.state,
            _read(message.content),
            tuple(message.wishes),
            message.keep,
            message.is_over,
            message.is_held,
            message.author,
            message.changed_by,
        )


@shown
@dataclass(frozen=True, slots=True)
class Wish:
    """A wish that somebody has filed: its word, more about it, and who that was."""

    word: str
    text: str
    author: str


@shown
@dataclass(frozen=True, slots=True, eq=False)
class RecordChange:
    """Records that are new or have changed, at one instant.

    Attributes:
        stamp: the instant.
        records: they, oldest first.
        removed: the names of those that the kernel has forgotten.
    """

    stamp: Stamp
    records: tuple[Record, ...]
    removed: tuple[str, ...]


class RecordWatch:
    """Changes of records as they come, until it is closed, which any thread may do."""

    def __init__(self, services: Services, kinds: Iterable[str]) -> None:
        """Watch those of some kinds, or all."""
        self._stream = services.record.WatchRecords(record_pb2.WatchRecordsRequest(kinds=kinds))

    def __iter__(self) -> Iterator[RecordChange]:
        """Yield all records, then those that change; of one that changes quickly the newest alone."""
        for response in self._stream:
            records = tuple(map(Record.of, response.records))
            yield RecordChange(stamp_of(response.stamp), records, tuple(response.removed_ids))

    def close(self) -> None:
        """End it; whoever waits for a change comes to the end."""
        self._stream.cancel()

    def __enter__(self) -> RecordWatch:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()


class RecordHold:
    """Wishes of a record as they are filed, none lost; it is held until this is closed, which any thread may do."""

    def __init__(self, services: Services, id: str) -> None:
        """Hold it from now on."""
        self._stream = services.record.HoldRecord(record_pb2.HoldRecordRequest(id=id))
        next(self._stream)

    def __iter__(self) -> Iterator[Wish]:
        """Yield wishes, until it is closed or the record is forgotten."""
        for response in self._stream:
            for one in response.wishes:
                yield Wish(one.word, one.text, one.author)

    def close(self) -> None:
        """Let the record go."""
        self._stream.cancel()

    def __enter__(self) -> RecordHold:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()


@checked
class Records:
    """The records of one kernel, which all of its clients share.

    Whoever changes one names it as it was seen, a `Record`, and is refused by StaleRevisionError where somebody has
    changed it meanwhile; or by its name, whatever it is by then.

    Example:
        >>> note = client.records.create("note", {"text": "the gripper sticks"}, title="arm")
        >>> client.records.update(note, {"text": "oiled"})
        >>> [one.content["text"] for one in client.records.list("note")]
        ['oiled']
    """

    def __init__(self, services: Services) -> None:
        """Handle the records of one kernel."""
        self._services = services

    def list(self, *kinds: str) -> list[Record]:
        """Return the records of some kinds, or all, oldest first: 100 at most, until the kernel ends."""
        request = record_pb2.ListRecordsRequest(kinds=kinds)
        return [Record.of(message) for message in self._services.record.ListRecords(request).records]

    def get(self, id: str) -> Record:
        """Return a record as it is now.

        Raises:
            UnknownNameError: when there is none of this name.
        """
        response = self._services.record.ListRecords(record_pb2.ListRecordsRequest(ids=[id]))
        return Record.of(response.records[0])

    def create(
        self,
        kind: str,
        content: Any = None,  # noqa: ANN401 anything that is JSON
        *,
        title: Text = "",
        state: Text = "",
        wishes: Iterable[str] = (),
        keep: bool = True,
        is_over: bool = False,
    ) -> Record:
        """Make a record and return it.

        Args:
            kind: the schema of its content: letters, digits, `.`, `_`, `-` and `/`.
            content: what it holds, of JSON: 32 KiB at most.
            title: its subject, one line of up to 200 characters.
            state: a word or line that its kind defines.
            wishes: the words that `wish` takes.
            keep: it stays when nobody holds it; others are forgotten 5 s after.
            is_over: it changes no more.

        Raises:
            InvalidArgumentError: for a content that is no JSON, such as NaN.
            TooLargeError: for more than 32 KiB.
            WrongStateError: while there are 100 that are not over.
            RoleTooLowError: for observers.
        """
        request = record_pb2.CreateRecordRequest(
            kind=kind,
            title=title,
            state=state,
            content=_written(content),
            wishes=record_pb2.WishWords(words=wishes),
            keep=keep,
            is_over=is_over,
        )
        return Record.of(self._services.record.CreateRecord(request).record)

    def update(
        self,
        seen: Record | str,
        content: Any = None,  # noqa: ANN401 anything that is JSON
        *,
        title: Text | None = None,
        state: Text | None = None,
        wishes: Iterable[str] | None = None,
        keep: bool | None = None,
        is_over: bool | None = None,
    ) -> Record:
        """Change what is given of a record, leave the rest, and return it; arguments and errors are those of `create`.

        Raises:
            StaleRevisionError: when it is not the one any more that was seen.
            WrongStateError: when it is over.
        """
        id, revision = _named(seen)
        request = record_pb2.UpdateRecordRequest(
            id=id,
            expected_revision=revision,
            title=title,
            state=state,
            content=None if content is None else _written(content),
            wishes=None if wishes is None else record_pb2.WishWords(words=wishes),
            keep=keep,  # pyright: ignore[reportArgumentType] None leaves it as it is
            is_over=is_over,  # pyright: ignore[reportArgumentType]
        )
        return Record.of(self._services.record.UpdateRecord(request).record)

    def wish(self, seen: Record | str, word: str, text: Text = "") -> None:
        """Tell the client that holds a record to do something; `seen` as of `update`.

        Args:
            seen: the record.
            word: one of its `wishes`.
            text: more about it, one line of up to 1000 characters.

        Raises:
            InvalidArgumentError: for another word.
            WrongStateError: when nobody holds it, or it is over.
        """
        id, revision = _named(seen)
        self._services.record.FileWish(
            record_pb2.FileWishRequest(id=id, expected_revision=revision, word=word, text=text)
        )

    def hold(self, seen: Record | str) -> RecordHold:
        """Hold a record, and return the wishes that are filed, a context manager; it is held when this returns.

        Raises:
            WrongStateError: when somebody else holds it.

        Example:
            >>> with client.records.hold(job) as wishes:
            ...     for wish in wishes:
            ...         print(wish.word, wish.text, wish.author)
        """
        return RecordHold(self._services, _named(seen)[0])

    def forget(self, seen: Record | str) -> None:
        """Have the kernel forget a record; `seen` as of `update`.

        Raises:
            WrongStateError: when somebody holds it and it is not over.
        """
        id, revision = _named(seen)
        self._services.record.ForgetRecord(record_pb2.ForgetRecordRequest(id=id, expected_revision=revision))

    def watch(self, *kinds: str) -> RecordWatch:
        """Return a watch of the records of some kinds, or of all, a context manager.

        Example:
            >>> with client.records.watch("note") as watch:
            ...     for change in watch:
            ...         print([one.content for one in change.records])
        """
        return RecordWatch(self._services, kinds)

    def __repr__(self) -> str:
        """Return names, kinds and states."""
        return told("Records", lambda: listed((f"{one.id} {one.kind} {one.state}" for one in self.list()), "none yet"))


def _named(seen: Record | str) -> tuple[str, int | None]:
    """Return the name of a record, and the revision that is expected."""
    return (seen, None) if isinstance(seen, str) else (seen.id, seen.revision)


def _written(content: Any) -> str:  # noqa: ANN401 anything that is JSON
    """Return a content as JSON; raises InvalidArgumentError for what is none."""
    if content is None:
        return ""
    try:
        return json.dumps(content, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidArgumentError(
            f"content is made of dictionaries, lists, texts, finite numbers, truths and None: {error}"
        ) from error


def _read(content: str) -> Any:  # noqa: ANN401 anything that is JSON
    """Return what a content says, or itself where it is no JSON."""
    if not content:
        return None
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return content
