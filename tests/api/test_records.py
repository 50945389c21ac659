"""RecordService at a real kernel: records, their watches, holders and wishes, and what is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import grpc
import pytest
from virtualrobot.v1 import record_pb2, token_pb2

from tests.api.asking import refusal
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

LARGEST = 32_768


@pytest.fixture(scope="module")
def kernel(start_kernel: StartKernel) -> KernelProcess:
    return start_kernel()


@pytest.fixture
def stubs(kernel: KernelProcess) -> Iterator[Stubs]:
    made = kernel.stubs()
    for one in made.record.ListRecords(record_pb2.ListRecordsRequest()).records:
        made.record.ForgetRecord(record_pb2.ForgetRecordRequest(id=one.id))
    yield made
    made.channel.close()


def create(stubs: Stubs, kind: str = "note", *words: str, **fields: object) -> record_pb2.Record:
    request = record_pb2.CreateRecordRequest(kind=kind, keep=True, wishes=record_pb2.WishWords(words=words))
    for name, value in fields.items():
        setattr(request, name, value)
    return stubs.record.CreateRecord(request).record


def now(stubs: Stubs, *kinds: str) -> list[record_pb2.Record]:
    return [*stubs.record.ListRecords(record_pb2.ListRecordsRequest(kinds=kinds)).records]


def update(stubs: Stubs, id: str, **fields: object) -> record_pb2.Record:
    return stubs.record.UpdateRecord(record_pb2.UpdateRecordRequest(id=id, **fields)).record  # pyright: ignore[reportArgumentType]


def wish(stubs: Stubs, id: str, word: str, text: str = "") -> record_pb2.FileWishResponse:
    return stubs.record.FileWish(record_pb2.FileWishRequest(id=id, word=word, text=text))


def refused(call: Callable[[], object], code: grpc.StatusCode, reason: str, words: str) -> None:
    told = refusal(call)
    assert (told.code, told.reason) == (code, reason) and words in told.message, told


def test_records_are_made_changed_listed_watched_and_forgotten(stubs: Stubs) -> None:
    other = create(stubs, "other/1", content="no JSON, which is nobody's business here")
    watched = stubs.record.WatchRecords(record_pb2.WatchRecordsRequest(kinds=["note"]))
    assert not next(watched).records
    made = create(stubs, title="arm", state="new", content='{"text": "it sticks"}')
    assert (made.revision, made.kind, made.keep, made.is_over, made.is_held) == (1, "note", True, False, False)
    assert made.author == made.changed_by != ""
    assert list(next(watched).records) == [made]
    update(stubs, other.id, state="nobody is told that")
    changed = update(stubs, made.id, content="{}", expected_revision=1)
    assert (changed.revision, changed.title, changed.state, changed.content) == (2, "arm", "new", "{}")
    assert list(next(watched).records) == [changed] == now(stubs, "note")
    refused(
        lambda: update(stubs, made.id, expected_revision=1, state="old"),
        grpc.StatusCode.ABORTED,
        "STALE_REVISION",
        f"{made.id!r} has the revision 2, not 1",
    )
    stubs.record.ForgetRecord(record_pb2.ForgetRecordRequest(id=made.id, expected_revision=2))
    assert list(next(watched).removed_ids) == [made.id]
    assert [one.id for one in now(stubs)] == [other.id]
    watched.cancel()


def test_the_holder_of_a_record_is_told_what_others_wish(kernel: KernelProcess, stubs: Stubs) -> None:
    job = create(stubs, "task", "stop", "answer")
    unheard = (grpc.StatusCode.FAILED_PRECONDITION, "WRONG_STATE", "nobody holds")
    refused(lambda: wish(stubs, job.id, "stop"), *unheard)
    with kernel.channel() as channel:
        owner = Stubs(channel)
        hold = owner.record.HoldRecord(record_pb2.HoldRecordRequest(id=job.id))
        assert not next(hold).wishes
        assert now(stubs)[0].is_held
        wish(stubs, job.id, "answer", "yes")
        wish(stubs, job.id, "stop")
        heard: list[record_pb2.Wish] = []
        while len(heard) < 2:
            heard += next(hold).wishes
        assert [(one.word, one.text) for one in heard] == [("answer", "yes"), ("stop", "")]
        assert all(one.author for one in heard)
        update(owner, job.id, wishes=record_pb2.WishWords(words=["stop"]))
        refused(
            lambda: wish(stubs, job.id, "answer"),
            grpc.StatusCode.INVALID_ARGUMENT,
            "INVALID_ARGUMENT",
            "takes no wish 'answer'; those that it takes now: 'stop'",
        )
        for call, words in (
            (lambda: next(stubs.record.HoldRecord(record_pb2.HoldRecordRequest(id=job.id))), "another call holds"),
            (lambda: stubs.record.ForgetRecord(record_pb2.ForgetRecordRequest(id=job.id)), "wish 'stop' of that"),
        ):
            refused(call, grpc.StatusCode.FAILED_PRECONDITION, "WRONG_STATE", words)
    until(lambda: not now(stubs)[0].is_held)
    refused(lambda: wish(stubs, job.id, "stop"), *unheard)
    update(stubs, job.id, is_over=True)
    for call in (lambda: update(stubs, job.id, state="on"), lambda: wish(stubs, job.id, "stop")):
        refused(call, grpc.StatusCode.FAILED_PRECONDITION, "WRONG_STATE", "is over, and changes no more")


def test_a_record_of_a_client_that_dies_is_forgotten_unless_somebody_keeps_it(
    kernel: KernelProcess, stubs: Stubs
) -> None:
    with kernel.channel() as channel:
        owner = Stubs(channel)
        lost, kept = (create(owner, "task", "stop", keep=False) for _ in range(2))
        for one in (lost, kept):
            next(owner.record.HoldRecord(record_pb2.HoldRecordRequest(id=one.id)))
        update(stubs, kept.id, keep=True)
    until(lambda: [one.id for one in now(stubs)] == [kept.id])
    assert not now(stubs)[0].is_held


@pytest.mark.parametrize(
    ("request_", "code", "reason", "words"),
    [
        ({"kind": ""}, "INVALID_ARGUMENT", "INVALID_ARGUMENT", "kind is made of 1 to 100 letters"),
        ({"kind": "two words"}, "INVALID_ARGUMENT", "INVALID_ARGUMENT", "'two words'"),
        ({"kind": "n", "title": "x" * 201}, "INVALID_ARGUMENT", "INVALID_ARGUMENT", "title is one line of at most 200"),
        ({"kind": "n", "state": "a\nb"}, "INVALID_ARGUMENT", "INVALID_ARGUMENT", "state is one line"),
        ({"kind": "n", "content": "ö" * (LARGEST // 2) + "!"}, "RESOURCE_EXHAUSTED", "TOO_LARGE", "not 32769"),
        (
            {"kind": "n", "wishes": record_pb2.WishWords(words=map(str, range(11)))},
            "INVALID_ARGUMENT",
            "INVALID_ARGUMENT",
            "at most 10 wishes, not 11",
        ),
        (
            {"kind": "n", "wishes": record_pb2.WishWords(words=[""])},
            "INVALID_ARGUMENT",
            "INVALID_ARGUMENT",
            "wishes is",
        ),
    ],
)
def test_bad_records_are_refused(stubs: Stubs, request_: dict[str, object], code: str, reason: str, words: str) -> None:
    request = record_pb2.CreateRecordRequest(**request_)  # pyright: ignore[reportArgumentType]
    refused(lambda: stubs.record.CreateRecord(request), grpc.StatusCode[code], reason, words)
    assert not now(stubs)


def test_the_largest_content_is_taken_and_unknown_records_are_refused(stubs: Stubs) -> None:
    assert len(create(stubs, content="x" * LARGEST).content) == LARGEST
    for call in (
        lambda: update(stubs, "record-0"),
        lambda: wish(stubs, "record-0", "stop"),
        lambda: stubs.record.ListRecords(record_pb2.ListRecordsRequest(ids=["record-0"])),
        lambda: stubs.record.ForgetRecord(record_pb2.ForgetRecordRequest(id="record-0")),
        lambda: next(stubs.record.HoldRecord(record_pb2.HoldRecordRequest(id="record-0"))),
    ):
        refused(call, grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME", "no record named 'record-0'")


def test_observers_see_records_and_operators_change_them(start_kernel: StartKernel) -> None:
    kernel = start_kernel(token=True)
    admin = kernel.stubs()
    secret = admin.token.CreateToken(token_pb2.CreateTokenRequest(name="looker", role=token_pb2.ROLE_OBSERVER)).secret
    observer = replace(kernel, token=secret).stubs()
    job = create(admin, "task", "stop")
    assert now(observer) == [job]
    assert list(next(observer.record.WatchRecords(record_pb2.WatchRecordsRequest())).records) == [job]
    for call in (
        lambda: create(observer),
        lambda: update(observer, job.id),
        lambda: wish(observer, job.id, "stop"),
        lambda: next(observer.record.HoldRecord(record_pb2.HoldRecordRequest(id=job.id))),
        lambda: observer.record.ForgetRecord(record_pb2.ForgetRecordRequest(id=job.id)),
    ):
        refused(call, grpc.StatusCode.PERMISSION_DENIED, "ROLE_TOO_LOW", "")
