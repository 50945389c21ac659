"""Commands that are told for a tick are put into it: the same bits as when all motions are advanced again."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.world import store
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.tick import advance

from tests.unit.crafts.rover import rover, yard
from tests.unit.crafts.test_crafts import planned


def run(advances: list[int]) -> tuple[Snapshot, list[np.ndarray]]:
    """Return a world after a craft has gone on a curve, and where all was in each tick."""
    seen: list[np.ndarray] = []
    with yard(rover()) as course:
        course.world.listen_ticks(lambda now: seen.append(now.state.q))
        course.do(planned("rover", {"left": 8.0, "right": 20.0}))
        before = len(advances)
        last = course.step(300)
        del advances[:before]
    return last, seen


def test_a_tick_with_what_was_told_for_it_is_the_same_and_advances_motions_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    advances: list[int] = []

    def counted(*arguments: object) -> object:
        advances.append(1)
        return advance(*arguments)  # pyright: ignore[reportArgumentType]

    monkeypatch.setattr(store, "advance", counted)
    last, seen = run(advances)
    assert len(advances) == 300
    monkeypatch.setattr(store, "told_more", lambda *arguments: None)
    again, seen_again = run(advances)
    assert len(advances) == 600
    assert same(image_of(last.structure, last.state), image_of(again.structure, again.state)) == ""
    np.testing.assert_array_equal(seen, seen_again)
    assert last.state.q[0] > 0.3
