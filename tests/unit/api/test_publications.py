"""What watchers are told, and in which order, when the world changes at the worst moment."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from typing import Any

import pytest
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, SetSignal, StartMotion
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.store import World

from tests.unit.world.builders import arm
from tests.unit.world.test_consistency import plan


class ChangingWorld(World):
    """A world whose signal changes twice as soon as somebody listens after `armed`."""

    armed = False

    def listen(self, published: Callable[[], None]) -> Callable[[], None]:
        """Listen, then change."""
        end = super().listen(published)
        if self.armed:
            self.armed = False
            for value in (True, False):
                self.submit([SetSignal("s", value)]).result()
        return end


@pytest.fixture
def world() -> Iterator[ChangingWorld]:
    world = ChangingWorld(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    world.submit([CreateSignal(Signal("s", False))]).result()
    yield world
    world.close()


def test_signal_changes_never_go_back_in_time(world: ChangingWorld) -> None:
    async def run() -> list[Snapshot]:
        publications = Publications(world, asyncio.get_running_loop())
        world.armed = True
        changes = publications.every_signal_change()
        told = [await anext(changes)]
        world.submit([SetSignal("s", True)]).result()
        told.append(await anext(changes))
        await changes.aclose()  # pyright: ignore[reportAttributeAccessIssue] an async generator
        return told

    first, second = asyncio.run(run())
    assert (first.state.signals["s"].value, second.state.signals["s"].value) == (False, True)
    assert second.revision == first.revision + 1


def counted(monkeypatch: pytest.MonkeyPatch, method: str) -> list[object]:
    """Return what the running loop is given by `method` from now on."""
    loop = asyncio.get_running_loop()
    real, calls = getattr(loop, method), []

    def counting(callback: Callable[..., object], *args: object, **options: Any) -> asyncio.Handle:  # noqa: ANN401 any
        calls.append(callback)
        return real(callback, *args, **options)

    monkeypatch.setattr(loop, method, counting)
    return calls


READERS, TICKS = 20, 10


def test_a_tick_costs_one_callback_for_each_reader_and_one_for_all(
    world: ChangingWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def run() -> tuple[int, int]:
        loop = asyncio.get_running_loop()
        publications = Publications(world, loop)
        told, everybody = 0, loop.create_future()

        async def read() -> None:
            nonlocal told
            async for _ in publications.snapshots(1e6):
                told += 1
                if told % READERS == 0:
                    everybody.set_result(None)

        readers = [asyncio.ensure_future(read()) for _ in range(READERS)]
        await everybody
        wakings, calls = counted(monkeypatch, "call_soon_threadsafe"), counted(monkeypatch, "call_soon")
        for _ in range(TICKS):
            everybody = loop.create_future()
            world.step(1).result()
            await everybody
        told_in_all = len(wakings), len(calls)
        for reader in readers:
            reader.cancel()
        return told_in_all

    # This test waits as well, for `everybody`: one callback more.
    assert asyncio.run(run()) == (TICKS, TICKS * (READERS + 1))


def test_ticks_do_not_wake_who_waits_for_the_end_of_a_motion(
    world: ChangingWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    world.submit([arm()]).result()
    moves = [StartMotion((("arm", joint),), plan(**{joint: (0.0, goal)})) for joint, goal in (("a", 0.5), ("b", 1.5))]
    world.submit(moves).result()

    async def run() -> tuple[int, str]:
        publications = Publications(world, asyncio.get_running_loop())
        wakings = counted(monkeypatch, "call_soon_threadsafe")
        ends = [asyncio.ensure_future(publications.end_of_motion(id, 1000.0)) for id in ("motion-1", "motion-2")]
        await asyncio.sleep(0.0)
        for _ in range(100):
            world.step(1).result()
        woken = len(wakings)
        while len(world.snapshot.state.motions) == 2:
            world.step(1).result()
        await asyncio.wait_for(ends[0], 30.0)
        assert not ends[1].done()
        while world.snapshot.state.motions:
            world.step(1).result()
        await asyncio.wait_for(ends[1], 30.0)
        return woken, world.snapshot.state.ended[-1].id

    assert asyncio.run(run()) == (0, "motion-2")


def test_a_motion_that_goes_on_is_not_waited_for_longer_than_asked(world: ChangingWorld) -> None:
    world.submit([arm(), StartMotion((("arm", "a"),), plan(a=(0.0, 1.0)))]).result()

    async def run() -> None:
        publications = Publications(world, asyncio.get_running_loop())
        await asyncio.wait_for(publications.end_of_motion("motion-1", 0.01), 30.0)

    asyncio.run(run())
    assert world.snapshot.state.motions


def test_who_waits_for_long_work_is_told_when_it_is_done_and_between(world: ChangingWorld) -> None:
    async def run() -> tuple[bool, bool]:
        loop = asyncio.get_running_loop()
        publications, work = Publications(world, loop), loop.create_future()
        goes_on = await publications.is_done(work)
        loop.call_soon(work.set_result, None)
        return goes_on, await asyncio.wait_for(publications.is_done(work), 30.0)

    assert asyncio.run(run()) == (False, True)


def test_a_reader_that_leaves_hurts_no_other(world: ChangingWorld) -> None:
    async def run() -> Snapshot:
        publications = Publications(world, asyncio.get_running_loop())
        seen = world.snapshot
        readers = [asyncio.ensure_future(publications.newer_than(seen)) for _ in range(3)]
        await asyncio.sleep(0.0)
        readers[1].cancel()
        await asyncio.wait(readers[1:2])
        world.step(1).result()
        first, last = await asyncio.wait_for(asyncio.gather(readers[0], readers[2]), 30.0)
        assert first is last
        return first

    assert asyncio.run(run()) is world.snapshot


def test_the_end_of_the_kernel_ends_all_waiting(world: ChangingWorld) -> None:
    world.submit([arm(), StartMotion((("arm", "a"),), plan(a=(0.0, 1.0)))]).result()

    async def second(messages: AsyncIterator[object]) -> None:
        await anext(messages)
        await anext(messages)

    async def run() -> list[object]:
        publications = Publications(world, asyncio.get_running_loop())
        calls = [
            publications.newer_than(world.snapshot),
            publications.end_of_motion("motion-1", 1000.0),
            publications.pause(1000.0),
            publications.is_done(asyncio.get_running_loop().create_future()),
            second(publications.every_signal_change()),
            second(publications.each(lambda listener: lambda: None)),
        ]
        waiting = [asyncio.ensure_future(call) for call in calls]
        await asyncio.sleep(0.0)
        publications.close()
        ended = await asyncio.wait_for(asyncio.gather(*waiting, return_exceptions=True), 30.0)
        late = await asyncio.gather(publications.pause(0.01), return_exceptions=True)
        return [*ended, *late]

    for error in asyncio.run(run()):
        assert isinstance(error, KernelError)
        assert error.reason is Reason.SHUTTING_DOWN
