"""What watchers are told, and in which order, when the world changes at the worst moment."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator

import pytest
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, SetSignal
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.store import World


class ChangingWorld(World):
    """A world whose signal changes twice as soon as somebody listens after `armed`."""

    armed = False

    def listen(self, published: Callable[[], None]) -> None:
        """Listen, then change."""
        super().listen(published)
        if self.armed:
            self.armed = False
            for value in (True, False):
                self.submit([SetSignal("s", value)]).result()


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
