"""A world that replays: time goes through the past at any speed and to any moment, and nothing changes it."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.clock import Clock, Mode, Recorded
from virtualrobot_kernel.world.commands import Command, StopMotions
from virtualrobot_kernel.world.past_world import PastWorld
from virtualrobot_kernel.world.state import Snapshot

from tests.unit.history.runs import Run, random_run
from tests.unit.world.builders import TICK

GUARD = 30.0


class Played:
    """Past that is a list of worlds."""

    def __init__(self, run: Run) -> None:
        """Begin at the first world."""
        self._worlds = [Change(*run.worlds[0]), *(Change(*one) for one in run.ticks)]
        self._at = 0

    first_tick = 0

    @property
    def last_tick(self) -> int:
        """Return the last tick."""
        return len(self._worlds) - 1

    def later(self) -> Change:
        """Go on by a tick."""
        return self.at(self._at + 1)

    def at(self, tick: int) -> Change:
        """Go to a tick."""
        self._at = tick
        return self._worlds[tick]


class Overseer:
    """Supervisor that wants all stopped, always."""

    author = "overseer"

    def __init__(self) -> None:
        """Have seen nothing."""
        self.seen: list[int] = []

    def admit(self, before: Snapshot, after: Snapshot, batch: Sequence[Command]) -> None:
        """Let all be."""

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Stop all."""
        return (StopMotions(),)

    def after_change(self, now: Snapshot) -> Sequence[Command]:
        """Stop all."""
        self.seen.append(now.state.tick)
        return (StopMotions(),)


@pytest.fixture
def run(rng: np.random.Generator) -> Run:
    return random_run(rng, 20)


@pytest.fixture
def world(run: Run) -> Iterator[PastWorld]:
    made = PastWorld(world_poses, Clock(Mode.STEPPED, 1.0, round(TICK * 1e9)), Played(run))
    made.start()
    yield made
    made.close()


def test_steps_go_through_what_was(world: PastWorld, run: Run) -> None:
    overseer, ticks = Overseer(), list[int]()
    world.supervise(overseer)
    world.listen_ticks(lambda snapshot: ticks.append(snapshot.state.tick))
    assert world.clock.recorded == Recorded(0, len(run.ticks))
    for tick in range(1, 30):
        snapshot = world.step(1).result(GUARD)
        assert (snapshot.structure, snapshot.state) == run.ticks[tick - 1]
        np.testing.assert_array_equal(snapshot.world_t_node, world_poses(*run.ticks[tick - 1]))
    assert world.step(20).result(GUARD).state is run.ticks[48][1]
    assert ticks == overseer.seen == [*range(1, 50)]
    with pytest.raises(
        KernelError, match=f"the record ends {len(run.ticks) - 49} ticks from here, at {len(run.ticks) * TICK:.9g} s"
    ) as refused:
        world.step(len(run.ticks) - 48).result(GUARD)
    assert refused.value.reason is Reason.WRONG_STATE


def test_nothing_changes_it(world: PastWorld) -> None:
    before = world.snapshot
    with pytest.raises(KernelError, match="this is a replay, and what was can only be looked at") as refused:
        world.submit([StopMotions()]).result(GUARD)
    assert refused.value.reason is Reason.WRONG_STATE
    assert world.snapshot is before


def test_it_goes_to_any_moment_in_another_epoch(world: PastWorld, run: Run, rng: np.random.Generator) -> None:
    epochs = [world.snapshot.state.epoch]
    for tick in rng.integers(1, len(run.ticks), 10).tolist():
        snapshot = world.seek(tick).result(GUARD)
        np.testing.assert_array_equal(snapshot.state.q, run.ticks[tick - 1][1].q)
        np.testing.assert_array_equal(snapshot.world_t_node, world_poses(*run.ticks[tick - 1]))
        epochs.append(snapshot.state.epoch)
    assert np.diff(epochs).tolist() == [1] * 10
    assert world.step(1).result(GUARD).state.epoch == epochs[-1]
    for tick in (-1, len(run.ticks) + 1):
        with pytest.raises(KernelError, match=f"from 0 s to {len(run.ticks) * TICK:.9g} s, not to {tick * TICK:.9g} s"):
            world.seek(tick).result(GUARD)


def test_at_the_end_it_stands(world: PastWorld, run: Run) -> None:
    stands = threading.Event()
    world.listen(lambda: stands.set() if world.clock.mode is Mode.STEPPED else None)
    world.seek(len(run.ticks) - 5).result(GUARD)
    stands.clear()
    world.set_clock(Mode.REALTIME, 1.0).result(GUARD)
    assert stands.wait(GUARD)
    assert world.snapshot.state.tick == len(run.ticks)
