"""Records by themselves: how long they stay, who holds them, and which wishes reach whom."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

import pytest
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.api.records import MOST_REMEMBERED, MOST_WISHES, Record, Records, Wish
from virtualrobot_kernel.errors import KernelError, Reason

STAY = {"kind": "note", "title": "", "state": "", "content": "", "wishes": ("stop",), "keep": True, "is_over": False}


def run(day: Callable[[Records, Publications], Awaitable[None]], unheld_seconds: float = 0.01) -> None:
    """Run a test inside of an event loop; of the world only that it tells counts here."""
    world: Any = SimpleNamespace(
        snapshot=SimpleNamespace(state=SimpleNamespace(ended=())), listen=lambda listener: None
    )

    async def inside() -> None:
        await day(Records(unheld_seconds), Publications(world, asyncio.get_running_loop()))

    asyncio.run(inside())


def make(records: Records, **fields: Any) -> Record:  # noqa: ANN401 fields of a record
    return records.create("ann", **{**STAY, **fields})


async def forgotten(records: Records, id: str) -> None:
    """Wait until a record is there no more."""
    while id in [one.id for one in records.all]:
        await asyncio.sleep(0.001)


def test_a_record_that_nobody_keeps_lives_as_long_as_it_is_held() -> None:
    async def day(records: Records, publications: Publications) -> None:
        kept, left, held = make(records), make(records, keep=False), make(records, keep=False)
        hold = records.hold(held.id, publications)
        assert await anext(hold) == []
        assert records.find(held.id).is_held
        await forgotten(records, left.id)
        assert [one.id for one in records.all] == [kept.id, held.id]
        await hold.aclose()
        assert not records.find(held.id).is_held
        await forgotten(records, held.id)
        assert records.all == [kept]

    run(day)


def test_a_record_that_somebody_keeps_outlives_its_client() -> None:
    async def day(records: Records, publications: Publications) -> None:
        one, other = make(records, keep=False), make(records, keep=False)
        hold = records.hold(one.id, publications)
        await anext(hold)
        records.update(records.find(one.id), "bob", keep=True)
        await hold.aclose()
        await forgotten(records, other.id)
        await asyncio.sleep(0.03)
        assert [(one.id, one.is_held, one.changed_by) for one in records.all] == [(one.id, False, "bob")]

    run(day)


def test_wishes_come_in_order_and_none_is_lost() -> None:
    async def day(records: Records, publications: Publications) -> None:
        one = make(records)
        hold = records.hold(one.id, publications)
        await anext(hold)
        for number in range(MOST_WISHES):
            records.file(records.find(one.id), Wish("stop", str(number), "bob"))
        with pytest.raises(KernelError, match=f"{MOST_WISHES} wishes wait") as full:
            records.file(records.find(one.id), Wish("stop", "", "bob"))
        assert full.value.reason is Reason.WRONG_STATE
        told = await anext(hold)
        assert [wish.text for wish in told] == list(map(str, range(MOST_WISHES)))
        records.update(records.find(one.id), "ann", is_over=True)
        records.forget(records.find(one.id))
        with pytest.raises(StopAsyncIteration):
            await anext(hold)

    run(day)


def test_those_that_are_over_are_forgotten_first() -> None:
    async def day(records: Records, publications: Publications) -> None:
        made = [make(records) for _ in range(MOST_REMEMBERED)]
        with pytest.raises(KernelError, match="100 records are kept that are not over") as full:
            make(records)
        assert full.value.reason is Reason.WRONG_STATE
        records.update(made[7], "ann", is_over=True)
        new = make(records)
        assert [one.id for one in records.all] == [one.id for one in (*made[:7], *made[8:], new)]

    run(day)
