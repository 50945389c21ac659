"""What WatchScene costs while nothing changes."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.api import scene
from virtualrobot_kernel.api.publications import Publications
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import CreateSignal, SetJointPositions, StartMotion
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Signal
from virtualrobot_kernel.world.store import World

from tests.unit.world.builders import arm
from tests.unit.world.test_consistency import plan

NO_LINKS = SimpleNamespace(measured=lambda _: {})
"""Links to real robots: none."""


@pytest.fixture
def world() -> Iterator[World]:
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    world.submit([arm()]).result()
    yield world
    world.close()


def test_snapshots_in_which_nothing_has_moved_are_not_compared(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[int] = []
    real = scene._difference

    def difference(before: Any, after: Any, wanted: Any, fields: Any) -> scene_pb2.WatchSceneResponse:  # noqa: ANN401 any
        compared.append(after.revision)
        return real(before, after, wanted, fields)

    monkeypatch.setattr(scene, "_difference", difference)

    async def run() -> list[scene_pb2.WatchSceneResponse]:
        publications = Publications(world, asyncio.get_running_loop())
        kernel: Any = SimpleNamespace(world=world, publications=publications, links=NO_LINKS)
        watch: Any = scene.SceneServicer(kernel).WatchScene(scene_pb2.WatchSceneRequest(max_rate_hertz=1e6), None)
        told = [await anext(watch)]
        next = asyncio.ensure_future(anext(watch))
        for _ in range(20):
            world.step(1).result()
            await asyncio.sleep(0.001)
        world.submit([CreateSignal(Signal("s", True))]).result()
        await asyncio.sleep(0.001)
        assert not next.done()
        world.submit([SetJointPositions("arm", {"a": 0.5})]).result()
        told.append(await asyncio.wait_for(next, 30.0))
        world.submit([StartMotion((("arm", "a"),), plan(a=(0.5, 1.0)))]).result()
        world.step(1).result()
        told.append(await asyncio.wait_for(anext(watch), 30.0))
        await watch.aclose()
        return told

    told = asyncio.run(run())
    assert [message.stamp.state_revision for message in told] == compared
    names = {node.uid: node.name for node in told[0].nodes}
    moving = ["arm.one", "arm.two", "arm.hand", "arm.left", "arm.right", "arm_gripper"]
    assert [sorted(names[uid] for uid in message.moved_uids) for message in told[1:]] == [sorted(moving)] * 2
