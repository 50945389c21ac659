"""Films: which snapshots they catch, and that nothing is left of one that has ended."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any

import pytest
from virtualrobot.v1 import view_pb2
from virtualrobot_kernel.api.capture import CaptureCalls
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.drawing import film as film_module
from virtualrobot_kernel.drawing.film import Film
from virtualrobot_kernel.drawing.renderer import Sight
from virtualrobot_kernel.drawing.view import ViewSettings, ViewStore
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World

GUARD = 30.0


@pytest.fixture
def world() -> Iterator[World]:
    """Give a world of ticks of 4 ms that goes on by steps."""
    made = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    made.start()
    yield made
    made.close()


def sight(snapshot: Snapshot) -> Sight:
    return Sight(snapshot, ViewSettings(), {})


def is_listened_to(world: World) -> bool:
    return bool(world._tick_listeners)


def taken(film: Film) -> list[tuple[int, int]]:
    """Return number and tick of all that waits."""
    frames = iter(film.take, None)
    return [(frame.number, frame.sight.snapshot.state.tick) for frame in frames if frame is not None]


def test_it_catches_the_first_tick_at_or_after_each_time(world: World) -> None:
    """At 30 a second and ticks of 4 ms: 33.3 ms lie between tick 8 and 9, 66.7 between 16 and 17, 100 is tick 25."""
    film = Film(world, sight, 30.0, 4)
    told: list[object] = []
    end = film.subscribe(told.append)
    world.step(200).result(GUARD)
    assert taken(film) == [(0, 0), (1, 9), (2, 17), (3, 25)]
    assert (len(told), film.is_over, film.behind) == (3, True, 0)
    end()
    assert not is_listened_to(world)


def test_times_do_not_drift(world: World) -> None:
    """After an hour picture 90,000 is still at its time: 1000 pictures of 25 a second stand for it here."""
    film = Film(world, sight, 25.0, None)
    film.subscribe(lambda _: None)
    world.step(9_990).result(GUARD)
    assert taken(film)[-1] == (999, 9_990)


def test_what_nobody_takes_is_bounded(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film_module, "MOST_BEHIND", 7)
    film = Film(world, sight, 250.0, None)
    film.subscribe(lambda _: None)
    world.step(6).result(GUARD)
    assert film.behind == 7
    world.step(10).result(GUARD)
    assert film.behind == 7
    frames = [film.take() for _ in range(7)]
    assert [frame.number for frame in frames if frame] == list(range(7)), "what was kept is a film still"
    world.step(10).result(GUARD)
    with pytest.raises(KernelError, match="7 pictures behind") as refused:
        film.take()
    assert (refused.value.reason, film.behind) == (Reason.TOO_LARGE, 0)


def test_a_large_world_is_bounded_by_its_memory(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = world.snapshot.world_t_node.nbytes
    monkeypatch.setattr(film_module, "MOST_BYTES", 3 * film_module.PARTS * nodes)
    film = Film(world, sight, 250.0, None)
    film.subscribe(lambda _: None)
    world.step(3).result(GUARD)
    for _ in range(3):
        assert film.take()
    with pytest.raises(KernelError, match="3 pictures behind"):
        film.take()


class DrawnNowhere:
    """A studio that gives back one byte a picture."""

    def submit(self, work: object, is_gone: object = None) -> Future[bytes]:
        done: Future[bytes] = Future()
        done.set_result(b"x")
        return done


class Capturing(CaptureCalls):
    """Calls that take pictures, of services without a kernel."""

    def __init__(self, world: World, publications: Publications) -> None:
        """Take pictures of `world`."""
        kernel = SimpleNamespace(
            world=world,
            publications=publications,
            view=ViewStore(),
            renderers=DrawnNowhere(),
            sensors=SimpleNamespace(latest={}),
            monitor=SimpleNamespace(latest=SimpleNamespace(touching=())),
            links=SimpleNamespace(measured=lambda _: {}),
        )
        self._kernel = kernel  # pyright: ignore[reportAttributeAccessIssue] no more of them is asked for


@pytest.mark.parametrize("leaving", ["while it waits", "while there is more"])
def test_a_reader_that_goes_leaves_no_listener(world: World, leaving: str) -> None:
    async def watch() -> bool:
        calls = Capturing(world, Publications(world, asyncio.get_running_loop()))
        stream: Any = calls.RecordFilm(view_pb2.RecordFilmRequest(frames_per_second=250.0), None)
        assert (await anext(stream)).frame == 0
        assert is_listened_to(world)
        if leaving == "while there is more":
            world.step(20).result(GUARD)
            await stream.aclose()
        else:
            waiting = asyncio.ensure_future(anext(stream))
            await asyncio.sleep(0.01)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
        return is_listened_to(world)

    assert not asyncio.run(watch())
