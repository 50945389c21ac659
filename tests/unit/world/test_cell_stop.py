"""The stop of a cell as commands: what it refuses, what it keeps, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.apply_cell import MOVING
from virtualrobot_kernel.world.apply_checkpoint import checkpoint_of
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import ClearWorld, ReleaseCell, SetJointPositions, StopCell
from virtualrobot_kernel.world.history_commands import RestartWorld
from virtualrobot_kernel.world.physics_commands import SetJointEfforts
from virtualrobot_kernel.world.state import CellStop

from tests.unit.world.builders import after, arm, empty

FIRE = CellStop("Ada at ipv4:10.0.0.7", "fire", 1_700_000_000.25)
SMOKE = CellStop("Bob at ipv4:10.0.0.8", "smoke", 1_700_000_009.0)

KINDS = sorted(MOVING, key=lambda kind: kind.__name__)


@pytest.fixture
def stopped() -> Change:
    return after(empty(), arm(), StopCell(FIRE))


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_moves_something_is_refused_by_who_when_and_why(stopped: Change, kind: type) -> None:
    """1700000000 s after 1970 is 2023-11-14 22:13:20 UTC (`date -u -d @1700000000`)."""
    command = object.__new__(kind)  # nothing of it is looked at
    with pytest.raises(KernelError) as refused:
        after(stopped, command)
    assert "Ada at ipv4:10.0.0.7 stopped it at 22:13:20 UTC on 2023-11-14 (fire)" in str(refused.value)
    assert refused.value.metadata["stop_time"] == "2023-11-14T22:13:20.250+00:00"
    assert (refused.value.metadata["aspect"], refused.value.metadata["stop_reason"]) == ("cell", "fire")


def test_a_batch_that_stops_and_then_moves_is_refused_as_a_whole() -> None:
    world = after(empty(), arm())
    with pytest.raises(KernelError, match="the cell is stopped"):
        after(world, StopCell(FIRE), SetJointEfforts("arm", {}))
    assert world.state.stop is None


def test_the_first_stop_counts_until_it_is_released(stopped: Change) -> None:
    assert after(stopped, StopCell(SMOKE)).state.stop == FIRE
    assert after(stopped, ReleaseCell(), StopCell(SMOKE)).state.stop == SMOKE
    assert after(stopped, ReleaseCell(), ReleaseCell()).state.stop is None


def test_edits_and_new_worlds_leave_it_alone(stopped: Change) -> None:
    moved = after(stopped, SetJointPositions("arm", {"a": 0.5}))
    assert np.isclose(moved.state.q, 0.5).any()
    free = replace(stopped, state=replace(stopped.state, stop=None))
    for command in (ClearWorld(), RestartWorld(), checkpoint_of(free, "a")):
        assert after(stopped, command).state.stop == FIRE
    assert after(free, checkpoint_of(stopped, "b")).state.stop is None
