"""Exploration of rooms in the plane: the map has what can be seen from where the vehicle comes to; the rest is told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_apps.seeing.navigation.exploring import Explorer
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.mapping import Mapper
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator
from virtualrobot_apps.seeing.navigation.poses import Floats
from virtualrobot_apps.seeing.navigation.scans import QUIET, Scan

from tests.apps.seeing import flat_vehicles, own_rooms
from tests.apps.seeing.flat_lidar import REACH, scan_at
from tests.apps.seeing.flat_vehicles import BEHIND, Driven, drive, known, room, vehicle
from tests.apps.seeing.own_rooms import START, Size, box


def explored(
    boxes: Sequence[Box], rng: np.random.Generator, longest: float = 1800.0
) -> tuple[Mapper, Explorer, Driven]:
    """Return how a vehicle whose wheels turn 3% more than it moves has explored; it has touched nothing."""
    mapper, told = Mapper(START), list[str]()
    navigator = Navigator(mapper, BEHIND, say=told.append)
    ugv = Driven(navigator, START.copy(), START.copy(), slips=lambda time: 0.03, told=told)
    nearest = np.inf

    def period() -> None:
        nonlocal nearest
        ugv.step(boxes, rng)
        nearest = min(nearest, *(float(one.apart(ugv.corners()).min()) for one in boxes))

    while not mapper.grid.log_odds.size:
        period()
    explorer = Explorer(navigator, mapper, REACH)
    explorer.run(period, longest)
    assert nearest > 0.0, told
    return mapper, explorer, ugv


def check(boxes: Sequence[Box], size: Size, rng: np.random.Generator) -> None:
    """Assert that the map has 98% of what can be seen, and that a patch that it hasn't is told."""
    mapper, explorer, ugv = explored(boxes, rng)
    share, patch = own_rooms.missing(mapper.grid, *own_rooms.coverable(boxes, size, START, BEHIND))
    left = [str(one) for one in explorer.unseen]
    assert share < 0.02 and (patch < 0.05 or left), (share, patch, left, ugv.told)


@pytest.mark.long
@pytest.mark.parametrize("layout", own_rooms.ROOMS, ids=lambda layout: layout.__name__)
def test_what_can_be_seen_of_a_room_is_on_its_map(
    layout: Callable[[], tuple[list[Box], Size]], rng: np.random.Generator
) -> None:
    """Walls between rooms, doors of 1 m, corridors, niches that are too narrow to turn in, furniture."""
    check(*layout(), rng)


@pytest.mark.long
def test_what_can_be_seen_of_a_drawn_room_is_on_its_map(rng: np.random.Generator) -> None:
    check(*own_rooms.split(rng), rng)


def gap() -> list[Box]:
    """Return two rooms with a gap of 0.3 m between them, and a screen behind it."""
    return [*room(4.0, 2.0), box(1.9, 0.0, 2.0, 0.8), box(1.9, 1.1, 2.0, 2.0), box(2.4, 0.3, 2.5, 1.6)]


@pytest.mark.long
def test_a_lidar_that_does_not_tell_that_nothing_is_there_maps_a_room_too(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such as the LDS-01, whose distance is 0 where it has no echo, as where something is too near."""

    def scan(
        boxes: Sequence[Box], pose: Floats, odometry: Floats | None, rng: np.random.Generator | None, time: float
    ) -> Scan:
        made = scan_at(boxes, pose, odometry, rng, time)
        return replace(made, empty=np.zeros((0, 2)), quiet=QUIET * made.empty)

    monkeypatch.setattr(flat_vehicles, "scan_at", scan)
    check(*own_rooms.divided(), rng)


@pytest.mark.long
def test_what_cannot_be_seen_is_told(rng: np.random.Generator) -> None:
    """It needs more than 0.3 m to pass, and of the room behind the gap sees a part at most."""
    mapper, explorer, _ = explored(gap(), rng)
    left = [str(one) for one in explorer.unseen]
    assert left and all(one.startswith("leaves an edge of ") and " unseen: " in one for one in left), left
    middles = np.vstack([one.edge.cells for one in explorer.unseen])
    assert (middles[:, 0] > 1.8).all(), left
    whole, seen = own_rooms.coverable(gap(), (4.0, 2.0), START, BEHIND)
    seen[:, whole.cells(np.array([[1.9, 0.0]]))[1][0] :] = False
    assert own_rooms.missing(mapper.grid, whole, seen)[0] < 0.02


def test_time_that_is_over_is_told(rng: np.random.Generator) -> None:
    _, explorer, ugv = explored(own_rooms.divided()[0], rng, longest=1.0)
    assert explorer.unseen and all(one.why == "1 s are over" for one in explorer.unseen)
    assert ugv.navigator.last_time < 1.5


ALCOVES = [*room(4.0, 3.0), box(0.0, 2.0, 1.8, 3.0), box(2.3, 2.0, 4.0, 3.0)]
DESK = [*room(4.0, 3.0), box(1.0, 0.9, 2.2, 1.5)]
SLOT = [*room(4.0, 3.0), box(1.0, 0.42, 2.2, 1.5), box(0.9, 0.0, 1.0, 1.5)]


@pytest.mark.long
@pytest.mark.parametrize(
    ("boxes", "start"),
    [(ALCOVES, (2.05, 2.6, np.pi / 2)), (DESK, (1.0 - 0.063 - 0.1, 0.87, 0.0)), (SLOT, (1.25, 0.21, np.pi))],
    ids=["an alcove of 0.5 m", "63 mm before a desk's corner", "a dead end of 0.42 m"],
)
def test_it_comes_out_of_where_it_cannot_turn(boxes: list[Box], start: Floats, rng: np.random.Generator) -> None:
    """It sweeps a radius of 0.245 m where it turns: it backs out, says so, and goes on to its goal."""
    ugv = vehicle(known(boxes, 4.0, 3.0), start, Goal(3.2, 1.6), BEHIND)
    assert drive([ugv], lambda time: boxes, rng) > 0.0
    assert ugv.navigator.reached, ugv.told
    assert ugv.told[0].startswith("has no room to turn to its way: backs out by "), ugv.told


@pytest.mark.long
def test_it_comes_out_again_of_a_place_that_was_its_goal(rng: np.random.Generator) -> None:
    ugv = vehicle(known(ALCOVES, 4.0, 3.0), (0.8, 0.8, 0.0), Goal(2.05, 2.6), BEHIND)
    for goal in (Goal(2.05, 2.6), Goal(0.8, 0.8)):
        ugv.navigator.go(goal)
        assert drive([ugv], lambda time: ALCOVES, rng) > 0.0
        assert ugv.navigator.reached, ugv.told
