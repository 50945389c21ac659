"""The table of leases: what it forgets, and that what the world thread reads is never half changed."""

from __future__ import annotations

import threading

import pytest
from virtualrobot_kernel.api.lease_table import REMEMBERED, LeaseTable, Loss
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World

from tests.unit.world.builders import arm


@pytest.fixture
def snapshot() -> Snapshot:
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    world.start()
    result = world.submit([arm()]).result().snapshot
    world.close()
    return result


def test_ended_leases_are_forgotten_at_last_and_held_ones_never(snapshot: Snapshot) -> None:
    table = LeaseTable()
    (robot,) = snapshot.structure.robots
    held = table.acquire(snapshot, [10**6], "keeps another one")
    ended = []
    for _ in range(REMEMBERED + 5):
        lease = table.acquire(snapshot, [robot], "comes and goes")
        table.end(lease, Loss.RELEASED, "it was released")
        ended.append(lease.token)
    assert table.held == [held]
    for token, cause in ((ended[0], "unknown"), (ended[-1], "released")):
        with pytest.raises(KernelError) as refused:
            table.held_by(token)
        assert (refused.value.reason, refused.value.metadata["cause"]) == (Reason.LEASE_ENDED, cause)


def test_a_permit_judges_by_the_table_of_the_moment(snapshot: Snapshot) -> None:
    table = LeaseTable()
    (robot,) = snapshot.structure.robots
    name = snapshot.structure.nodes[robot].name
    commands = [SetJointPositions(name, {})]
    anyone = table.permit(())
    anyone(snapshot, commands)
    lease = table.acquire(snapshot, [robot], "Ada")
    hers = table.permit((lease.token,))
    hers(snapshot, commands)
    with pytest.raises(KernelError, match="leased by 'Ada'"):
        anyone(snapshot, commands)
    table.end(lease, Loss.EXPIRED, "nobody kept it alive")
    anyone(snapshot, commands)
    with pytest.raises(KernelError, match="nobody kept it alive"):
        hers(snapshot, commands)


def test_a_reader_never_sees_a_robot_free_while_it_changes_hands(snapshot: Snapshot) -> None:
    table = LeaseTable()
    (robot,) = snapshot.structure.robots
    table.take([robot], "first")
    anyone, ended, seen = table.permit(()), threading.Event(), []
    commands = [SetJointPositions(snapshot.structure.nodes[robot].name, {})]

    def read() -> None:
        while not ended.is_set():
            try:
                anyone(snapshot, commands)
            except KernelError as error:
                seen.append(error.reason)
            else:
                seen.append(None)

    reader = threading.Thread(target=read)
    reader.start()
    for number in range(2000):
        table.take([robot], f"owner {number}")
    ended.set()
    reader.join()
    assert set(seen) == {Reason.LEASED}


def test_a_robot_that_was_removed_is_in_nobody_s_way(snapshot: Snapshot) -> None:
    """A stream of setpoints asks once its motion has ended, when the robot may be gone with the lease on it."""
    table = LeaseTable()
    table.acquire(snapshot, [10**6], "Ada")
    table.check(snapshot, [10**6], ())
