"""RecordService: records that clients make, hold and change, and wishes that others file for their holders."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import aclosing
from typing import Any

from virtualrobot.v1 import record_pb2, record_pb2_grpc

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.records import LARGEST_BYTES, Record, Wish
from virtualrobot_kernel.api.shelf import line_of, seen_revision
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.values import stamp

MOST_WORDS = 10
"""Greatest number of words for wishes."""

LONGEST_WISH = 1000
"""Greatest number of characters of the text of a wish."""

_WORD = re.compile(r"[A-Za-z0-9._/-]{1,100}")


class RecordServicer(record_pb2_grpc.RecordServiceServicer):
    """Servicer of RecordService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel, self._records = kernel, kernel.records

    async def ListRecords(
        self, request: record_pb2.ListRecordsRequest, context: object
    ) -> record_pb2.ListRecordsResponse:
        """Tell records as they are."""
        chosen = [self._records.find(id) for id in request.ids] if request.ids else self._records.all
        wanted = filter(_of_kinds(request.kinds), chosen)
        return record_pb2.ListRecordsResponse(stamp=stamp(self._kernel.world.snapshot), records=map(_message, wanted))

    async def WatchRecords(
        self, request: record_pb2.WatchRecordsRequest, context: object
    ) -> AsyncIterator[record_pb2.WatchRecordsResponse]:
        """Tell all records, then what changes."""
        changes = self._records.changes(self._kernel.publications, _of_kinds(request.kinds))
        async with aclosing(changes) as told:
            async for changed, gone in told:
                yield record_pb2.WatchRecordsResponse(
                    stamp=stamp(self._kernel.world.snapshot), records=map(_message, changed), removed_ids=gone
                )

    async def CreateRecord(
        self, request: record_pb2.CreateRecordRequest, context: object
    ) -> record_pb2.CreateRecordResponse:
        """Make a record."""
        made = self._records.create(
            person(context),
            kind=_word(request.kind, "kind"),
            title=line_of(request.title, "title"),
            state=line_of(request.state, "state"),
            content=_content(request.content),
            wishes=_words(request.wishes),
            keep=request.keep,
            is_over=request.is_over,
        )
        return record_pb2.CreateRecordResponse(stamp=stamp(self._kernel.world.snapshot), record=_message(made))

    async def UpdateRecord(
        self, request: record_pb2.UpdateRecordRequest, context: object
    ) -> record_pb2.UpdateRecordResponse:
        """Change what is given of a record."""
        seen = self._records.find(request.id, seen_revision(request))
        given = {name: getattr(request, name) for name in _FIELDS if request.HasField(name)}
        read = {name: _FIELDS[name](value) for name, value in given.items()}
        now = self._records.update(seen, person(context), **read)
        return record_pb2.UpdateRecordResponse(stamp=stamp(self._kernel.world.snapshot), record=_message(now))

    async def HoldRecord(
        self, request: record_pb2.HoldRecordRequest, context: object
    ) -> AsyncIterator[record_pb2.HoldRecordResponse]:
        """Hold a record, and tell the wishes that are filed."""
        async with aclosing(self._records.hold(request.id, self._kernel.publications)) as told:
            async for wishes in told:
                yield record_pb2.HoldRecordResponse(
                    stamp=stamp(self._kernel.world.snapshot),
                    wishes=[record_pb2.Wish(word=one.word, text=one.text, author=one.author) for one in wishes],
                )

    async def FileWish(self, request: record_pb2.FileWishRequest, context: object) -> record_pb2.FileWishResponse:
        """Tell a wish to who holds a record."""
        seen = self._records.find(request.id, seen_revision(request))
        self._records.file(seen, Wish(request.word, line_of(request.text, "text", LONGEST_WISH), person(context)))
        return record_pb2.FileWishResponse(stamp=stamp(self._kernel.world.snapshot), record=_message(seen))

    async def ForgetRecord(
        self, request: record_pb2.ForgetRecordRequest, context: object
    ) -> record_pb2.ForgetRecordResponse:
        """Forget a record."""
        self._records.forget(self._records.find(request.id, seen_revision(request)))
        return record_pb2.ForgetRecordResponse(stamp=stamp(self._kernel.world.snapshot))


def _of_kinds(kinds: Iterable[str]) -> Callable[[Record], bool]:
    """Return what says whether a record is of one of some kinds; none: all are."""
    wanted = {*kinds}
    return lambda record: not wanted or record.kind in wanted


def _message(record: Record) -> record_pb2.Record:
    return record_pb2.Record(
        id=record.id,
        revision=record.revision,
        kind=record.kind,
        title=record.title,
        state=record.state,
        content=record.content,
        wishes=record.wishes,
        keep=record.keep,
        is_over=record.is_over,
        is_held=record.is_held,
        author=record.author,
        changed_by=record.changed_by,
    )


def _content(content: str) -> str:
    """Return a content; raise KernelError for one that is too large."""
    if (size := len(content.encode())) > LARGEST_BYTES:
        raise KernelError(
            f"the content of a record has at most {LARGEST_BYTES} bytes, not {size}; keep what is larger as an "
            "asset, and name that",
            reason=Reason.TOO_LARGE,
            field="content",
            bytes=size,
            most=LARGEST_BYTES,
        )
    return content


def _words(wishes: record_pb2.WishWords) -> tuple[str, ...]:
    """Return words for wishes; raise KernelError for too many."""
    if len(wishes.words) > MOST_WORDS:
        raise KernelError(f"a record names at most {MOST_WORDS} wishes, not {len(wishes.words)}", field="wishes")
    return tuple(dict.fromkeys(_word(one, "wishes") for one in wishes.words))


def _word(text: str, field: str) -> str:
    if not _WORD.fullmatch(text):
        raise KernelError(
            f"{field} is made of 1 to 100 letters, digits, '.', '_', '-' and '/', as 'task', not {text!r:.80}",
            field=field,
        )
    return text


_FIELDS: dict[str, Callable[[Any], Any]] = {
    "title": lambda text: line_of(text, "title"),
    "state": lambda text: line_of(text, "state"),
    "content": _content,
    "wishes": _words,
    "keep": bool,
    "is_over": bool,
}
