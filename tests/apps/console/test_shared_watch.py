"""A watch that many pages share: each sees the world as it is in the end, however slow it is and whenever it came."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator
from contextlib import aclosing

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, robot_pb2
from virtualrobot_apps.console import upstream
from virtualrobot_apps.console.contract import QUICK_BYTES, Answer, methods
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.upstream import SharedWatch, Upstream

from tests.kernels import KernelProcess, Stubs
from tests.tiers import Draws

METHOD = methods()["/virtualrobot.v1.RobotService/WatchRobotStates"]


class World:
    """Robots whose first joint changes now and then, watched as the kernel's are: all first, then those that change."""

    def __init__(self) -> None:
        """Have three robots."""
        self.positions = {name: 0.0 for name in "abc"}
        self.revision = 1
        self.watches = 0
        self.changed = asyncio.Condition()

    async def change(self, name: str, position: float) -> None:
        async with self.changed:
            self.positions[name] = position
            self.revision += 1
            self.changed.notify_all()

    async def watch(self) -> AsyncGenerator[Answer, None]:
        self.watches += 1
        told: dict[str, float] = {}
        while True:
            async with self.changed:
                while told == self.positions:
                    await self.changed.wait()
                new = {name: at for name, at in self.positions.items() if told.get(name) != at}
                told = dict(self.positions)
                stamp = geometry_pb2.Stamp(epoch=1, state_revision=self.revision)
            robots = [robot_pb2.RobotState(name=name, positions=[at]) for name, at in new.items()]
            message = robot_pb2.WatchRobotStatesResponse(stamp=stamp, robots=robots)
            yield Answer(METHOD, message.SerializeToString())


async def read(watch: SharedWatch, slow: list[int], world: World) -> list[dict[str, float]]:
    """Return the states that a reader passes through, which yields as often as it is slow, until the world's last."""
    seen: dict[str, float] = {}
    states = []
    async with aclosing(watch.read()) as answers:
        async for answer in answers:
            message = robot_pb2.WatchRobotStatesResponse.FromString(answer.data)
            seen |= {robot.name: robot.positions[0] for robot in message.robots}
            states.append(dict(seen))
            if seen.get("c") == -1.0:
                return states
            for _ in range(slow.pop() if slow else 0):
                await asyncio.sleep(0)
    return states


def test_all_readers_end_with_the_world_as_it_is(rng: np.random.Generator, draws: Draws) -> None:
    async def once() -> None:
        world, ended = World(), []
        watch = SharedWatch(world.watch, ended.append)
        readers = []
        for number in range(40):
            if number % 8 == 0:
                slow = rng.integers(0, rng.choice([1, 100]), 20).tolist()
                readers.append(asyncio.create_task(read(watch, slow, world)))
            await world.change(str(rng.choice(list("ab"))), float(number))
            for _ in range(int(rng.integers(0, 6))):
                await asyncio.sleep(0)
        await world.change("c", -1.0)
        for states in await asyncio.gather(*readers):
            assert states[-1] == world.positions and states[0].keys() == set("abc")
        assert ended[0] is watch
        assert world.watches < 40  # one, and one for each time that somebody came late or fell behind

    for _ in range(draws(50)):
        asyncio.run(once())


async def until_changed(answers: AsyncGenerator[Answer, None]) -> Answer:
    """Return the answer that tells of one robot; a reader may be told twice how everything is."""
    async for answer in answers:
        if len(robot_pb2.WatchRobotStatesResponse.FromString(answer.data).robots) == 1:
            return answer
    raise AssertionError("the watch has ended")


def test_readers_that_keep_up_share_one_watch_and_its_json() -> None:
    async def once() -> None:
        world = World()
        watch = SharedWatch(world.watch, lambda _: None)
        readers = [watch.read() for _ in range(20)]
        await asyncio.gather(*(anext(reader) for reader in readers))
        asked = world.watches
        await world.change("a", 1.0)
        answers = await asyncio.gather(*(until_changed(reader) for reader in readers))
        assert len(set(map(id, answers))) == 1 and answers[0].json is answers[-1].json
        assert world.watches == asked <= 20
        for reader in readers:
            await reader.aclose()

    asyncio.run(once())


def test_a_large_answer_becomes_json_while_other_calls_go_on() -> None:
    async def once() -> None:
        robots = [robot_pb2.RobotState(name=f"arm {number}", positions=[0.1] * 7) for number in range(2000)]
        answer = Answer(METHOD, robot_pb2.WatchRobotStatesResponse(robots=robots).SerializeToString())
        assert len(answer.data) > QUICK_BYTES
        making = asyncio.create_task(answer.make_json())
        await asyncio.sleep(0)  # it has begun
        await asyncio.sleep(0)  # and here somebody else's call is answered
        assert not making.done()
        await making
        assert answer.json.count(b'"name":"arm ') == 2000

    asyncio.run(once())


def test_a_reader_that_is_far_behind_asks_anew() -> None:
    async def once() -> None:
        world = World()
        watch = SharedWatch(world.watch, lambda _: None)
        quick, slow = watch.read(), watch.read()
        await anext(quick)
        await anext(slow)
        asked = world.watches
        for number in range(1, 4 * upstream.MOST_BEHIND):
            await world.change("a", float(number))
            await anext(quick)
        message = robot_pb2.WatchRobotStatesResponse.FromString((await anext(slow)).data)
        assert message.robots[0].positions == [4 * upstream.MOST_BEHIND - 1] and len(message.robots) == 3
        assert world.watches == asked + 1
        await quick.aclose()
        await slow.aclose()

    asyncio.run(once())


def test_a_kernel_has_one_watch_for_equal_requests(kernel: KernelProcess, stubs: Stubs) -> None:
    async def nothing() -> AsyncGenerator[bytes, None]:
        yield b""

    async def once() -> None:
        there = Upstream(kernel.address, None)
        pages = [there.call(METHOD, nothing(), (("client-name", f"page {number}"),)) for number in range(5)]
        others = there.call(METHOD, nothing(), (("authorization", "Bearer other"),))
        for page in (*pages, others):
            await anext(page)
        assert there.watch_count == 2
        for page in (*pages, others):
            await page.aclose()
        assert there.watch_count == 0
        await there.close()

    asyncio.run(once())


def test_watches_of_every_tick_are_each_page_s_own(kernel: KernelProcess) -> None:
    request = robot_pb2.WatchRobotStatesRequest(every_tick=True).SerializeToString()

    async def one() -> AsyncGenerator[bytes, None]:
        yield request

    async def once() -> None:
        there = Upstream(kernel.address, None)
        pages = [there.call(METHOD, one(), ()) for _ in range(2)]
        for page in pages:
            await anext(page)
        assert there.watch_count == 0
        for page in pages:
            await page.aclose()
        await there.close()

    asyncio.run(once())
    assert not METHOD.is_shared(request) and METHOD.is_shared(b"")
    assert not METHOD.is_shared(b"\xff")  # no message: the kernel refuses it


def test_readers_are_told_that_no_kernel_is_there() -> None:
    async def nothing() -> AsyncGenerator[bytes, None]:
        yield b""

    async def once() -> None:
        there = Upstream("127.0.0.1:1", None)
        for _ in range(2):
            with pytest.raises(Refusal, match="nothing listens there"):
                await anext(there.call(METHOD, nothing(), ()))
        assert there.watch_count == 0
        await there.close()

    asyncio.run(once())
