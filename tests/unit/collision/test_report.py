"""Reports: which events are told after which, and how many contacts are remembered."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.collision.report import Event, Failed, Report, thinned
from virtualrobot_kernel.collision.scene import Collision
from virtualrobot_kernel.collision.touching import MOST_POINTS, Contacts

from tests.unit.collision.worlds import pictured
from tests.unit.world.builders import empty


@pytest.mark.parametrize(
    ("after", "told", "missed"), [(0, [4, 5, 6], 3), (2, [4, 5, 6], 1), (3, [4, 5, 6], 0), (5, [6], 0), (6, [], 0)]
)
def test_a_reader_gets_what_came_after_and_how_much_is_forgotten(after: int, told: list[int], missed: int) -> None:
    """Of six events the last three are remembered."""
    world = empty()
    events = tuple(Event(number, 0, 0.0, Failed("")) for number in (4, 5, 6))
    report = Report(pictured(world.structure, world.state), events=events, event_count=6)
    assert ([event.number for event in report.after(after)[0]], report.after(after)[1]) == (told, missed)


def test_few_of_many_contacts_are_remembered(rng: np.random.Generator) -> None:
    counts = rng.integers(1, 5000, 20)
    normal = np.array([0.0, 0.0, 1.0])
    many = Collision(1, 2, tuple(Contacts(rng.normal(size=(count, 3)), normal) for count in counts))
    few = thinned(many)
    assert (few.first, few.second) == (1, 2)
    every = np.concatenate([one.points for one in many.contacts])
    left = np.concatenate([one.points for one in few.contacts])
    assert len(left) == min(len(every), MOST_POINTS)
    places = [int(np.flatnonzero((every == point).all(axis=1))[0]) for point in left]
    assert (places[0], places[-1]) == (0, len(every) - 1)
    steps = np.diff(places)
    assert steps.min() > 0 and np.ptp(steps) <= 1, "spread over all, in their order"
    assert all(len(one.points) for one in few.contacts)
    bare = Collision(1, 2, many.contacts[:0])
    assert thinned(bare) is bare
