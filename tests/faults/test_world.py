"""Random clients at a real kernel: they edit, move, lease and vanish; the world stays whole, and a run is replayed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import grpc
import pytest
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.kernel import Kernel
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.journal import Entry, replay

from tests.faults.machine import WorldOfFaults
from tests.faults.running import APART, run
from tests.inside import kernel_inside
from tests.kernels import Stubs
from tests.tiers import Draws


class Recorder:
    """Keeper of all that has been told since it was cleared."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.told: list[Told] = []

    def keep(self, told: Sequence[Told]) -> None:
        self.told += told


class RecordedWorld(WorldOfFaults):
    """World of faults whose run is replayed at its end, from what the codec has written."""

    kernel: Kernel
    recorder: Recorder

    def __init__(self) -> None:
        """Forget what was told before."""
        super().__init__()
        self.kernel.world.submit((), "test").result()  # what was told before is kept now
        self.recorder.told.clear()

    def teardown(self) -> None:
        super().teardown()
        if self.seen is not None:
            self.kernel.world.submit((), "test").result()
            self._check_replay()

    def _check_replay(self) -> None:
        told, last = list(self.recorder.told), self.kernel.world.snapshot
        codec = world_codec()
        first = image_of(told[0].before.structure, told[0].before.state)
        commands = tuple((one.entry.tick, one.entry.commands) for one in told)
        image, read = codec.decode(codec.encode((first, commands)))
        entries = [Entry(tick, "", those) for tick, those in read]
        again = replay(image.structure, image.state, entries, last.state.tick, last.tick_seconds, world_poses)
        assert not (where := same(image_of(last.structure, last.state), image_of(again.structure, again.state))), where
        assert last.world_t_node.tobytes() == world_poses(again.structure, again.state).tobytes()


@pytest.fixture(scope="module")
def world(arm: Path) -> Iterator[type[WorldOfFaults]]:
    """Return the machine of a kernel in this process, whose journal is kept."""
    recorder = Recorder()
    with kernel_inside(recorder) as (kernel, address):
        connect = staticmethod(lambda: Stubs(grpc.insecure_channel(address, APART)))
        fields = {"kernel": kernel, "recorder": recorder, "connect": connect, "arm": arm}
        yield type("World", (RecordedWorld,), fields)


@pytest.mark.long
def test_whatever_clients_do_the_world_stays_whole(world: type[WorldOfFaults], seed: int, draws: Draws) -> None:
    run(world, seed, draws(30))
