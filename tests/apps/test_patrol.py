"""The patrol in steps in a real kernel: what comes and what goes is said, and another room is, without an alarm."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.demos.patrol import room, run
from virtualrobot_apps.seeing.changes.comparing import Change


@pytest.mark.long
def test_a_round_tells_what_came_and_what_is_gone(capsys: pytest.CaptureFixture[str]) -> None:
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        result = run.main(client, seed=3, stops=room.STOPS[1:2])
    assert (result.found, result.false, result.quiet) == (2, 0, 0), capsys.readouterr().out
    assert result.other.startswith("the second scan fits the first one to")
    told = capsys.readouterr().out
    assert "stands now at" in told and "stood at" in told and "found 2 of 2 changes, 0 false alarms" in told


def test_what_changes_is_in_sight_and_apart_from_furniture() -> None:
    """By seeds: each has other places, the same each time."""
    plots = [room.plot_of(seed) for seed in range(5)]
    assert room.plot_of(3) == plots[3] and all(one != other for one, other in pairwise(plots))
    for plot in plots:
        for box in (plot.crate, plot.stool):
            place = np.array([box.x, box.y])
            assert any(room.in_sight(np.array(stop), place) for stop in room.STOPS)
            assert min(float(one.apart(place)) for one in room.ROOM) > 0.45


def test_a_thing_that_stops_tell_is_told_once_by_the_one_with_most_points_of_it() -> None:
    """A thing at the place of one that stands there now is another, and so is one that is further off than SAME."""

    def change(appeared: bool, x: float, points: int) -> Change:
        return Change(appeared, np.array([x, 0.0, 0.0]), np.full(3, 0.3), points)

    least, most = change(True, 0.0, 10), change(True, 0.1, 90)
    gone, far = change(False, 0.1, 20), change(True, 0.1 + 1.01 * run.SAME, 30)
    assert run.once([least, gone, most, far]) == [most, far, gone]
