"""Named checkpoints in a store: how many there are, and that a thinned history keeps what it begins with."""

from __future__ import annotations

import pytest
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.history.checkpoints import AUTOMATIC, MOST_AUTOMATIC, MOST_CHECKPOINTS, Checkpoints
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.journal import Told
from virtualrobot_kernel.history.recovery import recovered
from virtualrobot_kernel.history.rows import Row
from virtualrobot_kernel.history.store import Store
from virtualrobot_kernel.history.upkeep import Moment, Rules, Upkeep
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.journal import Entry

from tests.unit.world.builders import TICK
from tests.unit.world.edits import cell

CODEC = world_codec()
CELL = cell()
ENTRIES = 5


@pytest.fixture
def store() -> Store:
    """Return a store with some entries that changed nothing."""
    store = Store()
    store.write([Row(number, 0, 0.0, "ann", CODEC.encode(())) for number in range(1, ENTRIES + 1)])
    return store


@pytest.fixture
def checkpoints(store: Store) -> Checkpoints:
    return Checkpoints(store, CODEC, Upkeep(store, CODEC, Rules(), Moment(ENTRIES, CELL.structure, CELL.state)))


@pytest.mark.parametrize("thinned", [True, False])
def test_what_a_history_begins_with_stays_when_its_name_goes(
    store: Store, checkpoints: Checkpoints, thinned: bool
) -> None:
    checkpoints.create("noon", "ann")
    while thinned and store.forget(ENTRIES, 0):
        pass
    assert checkpoints.remove("noon").node_count == len(CELL.structure.nodes)
    assert checkpoints.all == []
    moment, warnings = recovered(store, CODEC, 0, TICK, world_poses)
    assert not warnings
    # Else all entries are there, and these have created nothing.
    assert len(moment.structure.nodes) == (len(CELL.structure.nodes) if thinned else 1)


def test_a_checkpoint_before_a_gap_is_no_begin(store: Store, checkpoints: Checkpoints) -> None:
    checkpoints.create("noon", "ann")
    store.write([Row(number, 0, 0.0, "ann", CODEC.encode(())) for number in range(ENTRIES + 1, ENTRIES + 4)])
    while store.forget(ENTRIES + 2, 0):
        pass
    with pytest.raises(KernelError, match="no checkpoint can be read"):
        recovered(store, CODEC, 0, TICK, world_poses)


def test_there_are_so_many_and_no_more(checkpoints: Checkpoints) -> None:
    for _ in range(MOST_CHECKPOINTS):
        checkpoints.create("", "ann")
    with pytest.raises(KernelError, match=r"there are 100 checkpoints already") as error:
        checkpoints.create("", "ann")
    assert error.value.reason is Reason.TOO_LARGE
    checkpoints.remove("checkpoint 7")
    assert checkpoints.create("", "ann").name == "checkpoint 7"


def test_of_the_kernels_own_the_newest_stay(checkpoints: Checkpoints) -> None:
    for number in range(1, MOST_AUTOMATIC + 4):
        command = checkpoint_of(CELL, "noon")
        checkpoints.keep([Told(number, Entry(0, "ann", (command,)), CELL, CELL)])
        left = checkpoints.left_by(command)
        assert left is not None
        assert (left.name, left.automatic) == (f"{AUTOMATIC}{number}", True)
    numbers = sorted(int(one.name.removeprefix(AUTOMATIC)) for one in checkpoints.all)
    assert numbers == list(range(4, MOST_AUTOMATIC + 4))


@pytest.mark.parametrize("name", [" noon", "no\non", "n" * 201, f"{AUTOMATIC}7"])
def test_wrong_names(checkpoints: Checkpoints, name: str) -> None:
    with pytest.raises(KernelError, match="name"):
        checkpoints.create(name, "ann")
    with pytest.raises(UnknownNameError, match="there is none yet"):
        checkpoints.get(name)
