"""Vehicles that meet what their map has not: boxes that are put in the way, another vehicle, wheels that slip."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError
from virtualrobot_apps.seeing.navigation import navigator
from virtualrobot_apps.seeing.navigation.floors import Box
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.mapping import Mapper
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator
from virtualrobot_apps.seeing.navigation.poses import Floats, distance
from virtualrobot_apps.seeing.navigation.scans import Scan
from virtualrobot_apps.seeing.navigation.sonars import Sonar

from tests.apps.seeing.flat_lidar import REACH
from tests.apps.seeing.flat_vehicles import BEHIND, PERIOD, UGV, Driven, drive, known, room, vehicle

pytestmark = pytest.mark.long
HUSKY = Footprint(-0.495, 0.495, -0.335, 0.335)
"""That of Clearpath's data sheet: 990 x 670 mm."""


def test_husky_crosses_a_room_in_which_boxes_are_put_in_its_way(rng: np.random.Generator) -> None:
    walls = room(7.0, 4.5)
    husky = vehicle(known(walls, 7.0, 4.5), (1.0, 2.3, 0.0), Goal(6.0, 2.3), HUSKY)
    boxes = [Box(3.2, 2.4, 0.5, 0.5, 1.0, "#a52"), Box(5.0, 1.5, 0.4, 0.6, 1.0, "#a52")]
    put = [2.0, 6.0]
    nearest = drive(
        [husky], lambda time: [*walls, *(box for box, at in zip(boxes, put, strict=True) if time > at)], rng
    )
    assert husky.navigator.reached, husky.told
    assert distance(husky.pose, (6.0, 2.3)) < 0.25 and nearest > 0.0


def test_a_crate_in_a_passage_is_passed_from_wherever_it_begins(rng: np.random.Generator) -> None:
    """As in the tutorial: on both sides of the crate there is room, on one 0.65 m; it needs no recovery for that."""
    walls = [*room(4.0, 3.0), Box(2.0, 0.6, 0.1, 1.2, 1.0, "#fff"), Box(3.6, 2.75, 0.8, 0.5, 1.0, "#fff")]
    walls.append(Box(0.3, 2.4, 0.6, 0.4, 1.0, "#fff"))
    grid, boxes = known(walls, 4.0, 3.0), [*walls, Box(2.0, 2.0, 0.3, 0.3, 1.0, "#a52")]
    for _ in range(8):
        start = np.array([3.0, 0.6, 0.0]) + rng.uniform(-1.0, 1.0, 3) * [0.1, 0.1, np.pi]
        ugv = vehicle(grid, start, Goal(0.8, 0.7), BEHIND)
        nearest = drive([ugv], lambda time: boxes, rng)
        assert ugv.navigator.reached and nearest > 0.0, (start, ugv.told)
        assert not any(words in one for one in ugv.told for words in ("nearer", "blocked")), (start, ugv.told)


def test_another_way_is_taken_where_the_first_is_shut(rng: np.random.Generator) -> None:
    """Meters that were gained on the first don't count on the other, longer one; it tells how long that is."""
    walls = [*room(5.0, 4.0), Box(2.5, 2.0, 0.2, 2.4, 1.0, "#fff")]
    shut = Box(2.5, 0.4, 0.2, 0.8, 1.0, "#a52")
    ugv = vehicle(known(walls, 5.0, 4.0), (0.6, 1.2, 0.0), Goal(4.2, 1.2), BEHIND)
    nearest = drive([ugv], lambda time: [*walls, shut] if time > 3.0 else walls, rng)
    assert ugv.navigator.reached and nearest > 0.0, ugv.told
    assert [one.split(",")[0] for one in ugv.told[:-1]] == ["takes another way"], ugv.told


def test_two_vehicles_share_an_aisle(rng: np.random.Generator) -> None:
    """Each begins where the other one wants to go; each sees the other one by its lidar alone."""
    wide, deep = 6.0, 1.6
    walls = room(wide, deep)
    grid = known(walls, wide, deep)
    first = vehicle(grid, (0.7, 0.8, 0.0), Goal(5.3, 0.8))
    second = vehicle(grid, (5.3, 0.8, np.pi), Goal(0.7, 0.8))
    nearest = drive([first, second], lambda time: walls, rng)
    assert first.navigator.reached and second.navigator.reached, (first.told, second.told)
    assert nearest > 0.0


def test_a_goal_that_is_taken_is_waited_for_near_it(rng: np.random.Generator) -> None:
    """A box on a goal may go; one that stays ends the way 10 s after it was come to, in words with numbers."""
    walls = room(4.0, 2.0)
    crate = Box(3.3, 1.0, 0.3, 0.3, 1.0, "#a52")
    waits = vehicle(known(walls, 4.0, 2.0), (0.6, 1.0, 0.0), Goal(3.3, 1.0))
    nearest = drive([waits], lambda time: [*walls, crate], rng)
    assert not waits.navigator.reached and nearest > 0.0
    assert 0.3 < distance(waits.pose, (3.3, 1.0)) < 1.1, waits.told
    assert waits.told[0] == "something stands on its goal now: goes on towards it"
    assert waits.told[-1].startswith("gives up: the goal (3.30, 1.00) is"), waits.told
    assert waits.told[-1].endswith("with what stands there now")


def test_wheels_that_slip_are_told_and_the_lidar_goes_on(rng: np.random.Generator) -> None:
    """For 3 s the wheels turn four times as much as they move it: it says so, and comes to its goal all the same."""
    boxes = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52"), Box(1.2, 2.7, 0.6, 0.3, 1.0, "#a52")]
    slips = vehicle(known(boxes, 4.0, 3.0), (0.6, 1.5, 0.0), Goal(3.4, 1.8))
    slips.slips = lambda time: 3.0 if 1.0 < time < 4.0 else 0.0
    nearest = drive([slips], lambda time: boxes, rng)
    assert slips.navigator.reached and nearest > 0.0, slips.told
    assert distance(slips.pose, (3.4, 1.8)) < 0.25, slips.told
    assert distance(slips.odometry, slips.pose) > 1.0
    assert any(one.startswith("its wheels slip: odometry says") for one in slips.told), slips.told


def test_odometry_that_stands_is_told_and_the_lidar_goes_on(rng: np.random.Generator) -> None:
    """Encoders that tell the same for ever: scans alone say where it is, at half the speed."""
    boxes = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52"), Box(1.2, 2.7, 0.6, 0.3, 1.0, "#a52")]
    frozen = vehicle(known(boxes, 4.0, 3.0), (0.6, 1.5, 0.0), Goal(3.2, 1.8))
    frozen.slips = lambda time: -1.0
    nearest = drive([frozen], lambda time: boxes, rng)
    assert frozen.navigator.reached and nearest > 0.0, frozen.told
    assert distance(frozen.pose, (3.2, 1.8)) < 0.25, frozen.told
    assert any(one.startswith("its odometry stands: the lidar says") for one in frozen.told), frozen.told


FURNISHED = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52"), Box(1.2, 2.7, 0.6, 0.3, 1.0, "#a52")]
OTHERS = [*room(3.0, 2.2), Box(1.5, 1.1, 0.7, 0.5, 1.0, "#a52")]


@pytest.mark.parametrize(
    ("boxes", "map_of"),
    [(FURNISHED, known(OTHERS, 3.0, 2.2)), (room(5.3, 6.8), known(room(4.0, 3.0), 4.0, 3.0))],
    ids=["furnished", "empty"],
)
def test_a_map_of_another_building_is_told(
    boxes: list[Box], map_of: Grid, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody tells it where it is: it drives about without touching anything, and says what is wrong.

    Walls of an empty room fit each corner whose other walls are out of the lidar's reach, but for these.
    """
    monkeypatch.setattr(navigator, "LOST_SECONDS", 8.0)
    told: list[str] = []
    pose = np.array([0.6, 1.5, 0.0])
    lost = Driven(Navigator(Localiser(map_of), UGV, say=told.append), pose, pose.copy(), told=told)
    lost.navigator.go(Goal(2.5, 1.8))
    assert drive([lost], lambda time: boxes, rng) > 0.0
    assert told[0] == "is lost: looks for its place in the map"
    assert told[-1].startswith("gives up: no place of this map fits what the lidar sees (the best one to "), told
    assert told[-1].endswith("is it the map of this building?")


class Fickle(Localiser):
    """Localiser that finds its place and loses it, two scans after each other."""

    scans = 0

    @property
    def lost(self) -> bool:
        """Return whether it has lost its place now."""
        return self.scans // 2 % 2 == 1

    def update(self, scan: Scan) -> Floats:
        """Count scans."""
        self.scans += 1
        return super().update(scan)


def test_places_that_are_found_in_vain_come_to_an_end(rng: np.random.Generator) -> None:
    pose, told = np.array([0.6, 1.5, 0.0]), list[str]()
    ugv = Driven(
        Navigator(Fickle(known(FURNISHED, 4.0, 3.0), pose), UGV, say=told.append), pose, pose.copy(), told=told
    )
    ugv.navigator.go(Goal(3.5, 2.6))
    drive([ugv], lambda time: FURNISHED, rng)
    assert sum(one.startswith("knows its place again") for one in told) == 3, told
    assert told[-1].startswith("gives up: it has found its place 3 times, and none of them fits any more"), told


def test_a_map_without_walls_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="the map has 0 cells of walls beside free ones, and 20 at least"):
        Localiser(known([], 4.0, 3.0))


def test_a_goal_that_the_map_refuses_is_refused_before_a_search(rng: np.random.Generator) -> None:
    """A vehicle that is lost needn't know its place to say that a goal is in a wall."""
    boxes = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52")]
    told: list[str] = []
    pose = np.array([0.6, 1.5, 0.0])
    lost = Driven(Navigator(Localiser(known(boxes, 4.0, 3.0)), UGV, say=told.append), pose, pose.copy(), told=told)
    for goal in (Goal(2.2, 0.4), Goal(90.0, 90.0)):
        lost.navigator.go(goal)
        drive([lost], lambda time: boxes, rng)
    assert lost.periods == 2 and told == [
        "gives up: the goal (2.20, 0.40) is inside an obstacle",
        "gives up: the goal (90.00, 90.00) is off the map",
    ]


def test_a_vehicle_that_is_carried_elsewhere_finds_its_place_again(rng: np.random.Generator) -> None:
    """Its wheels tell nothing of it: what the lidar sees fits no more, it says so, and goes on from where it is."""
    boxes = [*room(4.0, 3.0), Box(2.2, 0.4, 0.5, 0.5, 1.0, "#a52"), Box(1.2, 2.7, 0.6, 0.3, 1.0, "#a52")]
    boxes.append(Box(3.7, 2.2, 0.4, 0.9, 1.0, "#a52"))
    carried = vehicle(known(boxes, 4.0, 3.0), (0.6, 1.5, 0.0), Goal(3.2, 1.0))
    for _ in range(40):
        carried.step(boxes, rng)
    carried.pose = np.array([3.2, 0.6, 2.0])
    carried.navigator.go(Goal(0.6, 2.2))
    assert drive([carried], lambda time: boxes, rng) > 0.0
    assert carried.navigator.reached and distance(carried.pose, (0.6, 2.2)) < 0.2, carried.told
    assert "is lost: looks for its place in the map" in carried.told
    assert any(one.startswith("knows its place again: (3.") for one in carried.told), carried.told


def test_a_wrong_place_to_begin_with_leaves_no_way_behind(rng: np.random.Generator) -> None:
    """It thinks that it is beyond the partition, is found before it, and goes around."""
    walls = [*room(4.0, 3.0), Box(2.0, 0.6, 0.1, 1.2, 1.0, "#fff"), Box(3.6, 2.75, 0.8, 0.5, 1.0, "#fff")]
    walls.append(Box(0.3, 2.4, 0.6, 0.4, 1.0, "#fff"))
    wrong = vehicle(known(walls, 4.0, 3.0), (3.5, 0.5, 0.0), Goal(3.0, 0.6), BEHIND)
    wrong.pose = np.array([0.7, 0.7, 0.0])
    assert drive([wrong], lambda time: walls, rng) > 0.0
    assert wrong.navigator.reached and distance(wrong.pose, (3.0, 0.6)) < 0.2, wrong.told
    assert any(one.startswith("knows its place again: (0.") for one in wrong.told), wrong.told


def test_where_the_lidar_sees_nothing_it_says_so(rng: np.random.Generator) -> None:
    """In the middle of a hall walls are out of reach."""
    walls = room(12.0, 12.0)
    ugv = vehicle(known(walls, 12.0, 12.0), (6.0, 6.0, 0.0), Goal(6.8, 6.0))
    drive([ugv], lambda time: walls, rng)
    assert ugv.navigator.reached
    assert ugv.told[0] == "sees nothing in the lidar's reach: goes on by odometry alone"


def test_odometry_alone_leads_no_further_than_some_meters(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(navigator, "ALONE_METERS", 1.0)
    walls = room(12.0, 12.0)
    ugv = vehicle(known(walls, 12.0, 12.0), (5.0, 6.0, 0.0), Goal(7.5, 6.0))
    drive([ugv], lambda time: walls, rng)
    assert ugv.told[-1].startswith(
        "gives up: it has gone 1.0 m by odometry alone, with nothing in the reach of 'lidar'"
    )
    assert ugv.pose[0] < 6.1


BLIND = [Box(90.0, 90.0, 1.0, 1.0, 1.0, "white")]
"""Boxes of which the lidar sees nothing."""
HARDLY = "the scans of 'lidar' have hardly an echo"
MAPPED = f"{HARDLY} though the map has walls in its reach"


@pytest.mark.parametrize("lost", [False, True])
def test_a_blind_lidar_drives_nowhere(lost: bool, rng: np.random.Generator) -> None:
    """No ray has an echo where the map has walls, or where it looks for its place: it waits 10 s, and gives up."""
    pose, told = np.array([0.6, 1.5, 0.0]), list[str]()
    where = Localiser(known(FURNISHED, 4.0, 3.0), None if lost else pose)
    ugv = Driven(Navigator(where, UGV, say=told.append, reach=REACH), pose, pose.copy(), told=told)
    ugv.navigator.go(Goal(3.5, 2.6))
    drive([ugv], lambda time: BLIND, rng)
    words = HARDLY if lost else MAPPED
    assert told == [f"stands: {words}", f"gives up: {words}, for 10 s"] and not ugv.navigator.reached
    np.testing.assert_array_equal(ugv.pose, pose)


@pytest.mark.parametrize("blind", [5.0, 50.0])
def test_a_lidar_that_is_blind_for_a_while_is_waited_for(blind: float, rng: np.random.Generator) -> None:
    """It goes blind on the way: it stops at once, and goes on when echoes come back, if that is within 10 s."""
    ugv = vehicle(known(FURNISHED, 4.0, 3.0), (0.6, 1.5, 0.0), Goal(3.5, 2.6))
    drive([ugv], lambda time: BLIND if 2.0 <= time < 2.0 + blind else FURNISHED, rng)
    stopped = [place for period, place in enumerate(ugv.way) if 2.0 <= period * PERIOD < 2.0 + min(blind, 10.0)]
    assert distance(stopped[0], stopped[-1]) < 0.1 and f"stands: {MAPPED}" in ugv.told, ugv.told
    if blind < 10.0:
        assert "goes on: 'lidar' sees again" in ugv.told and ugv.navigator.reached, ugv.told
    else:
        assert ugv.told[-1] == f"gives up: {MAPPED}, for 10 s", ugv.told


def test_a_lidar_that_goes_blind_draws_no_map(rng: np.random.Generator) -> None:
    """Scans without echo don't wipe out walls that it has seen: the mapper isn't told them."""
    pose, mapper = np.array([0.6, 1.5, 0.0]), Mapper(np.array([0.6, 1.5, 0.0]))
    maps = Driven(Navigator(mapper, UGV, reach=REACH), pose, pose.copy())
    maps.step(FURNISHED, rng)
    before = mapper.grid.log_odds.copy()
    for _ in range(20):
        mapper.keep_next = True
        maps.step(BLIND, rng)
    np.testing.assert_array_equal(mapper.grid.log_odds, before)


def test_places_that_look_alike_are_told(rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch) -> None:
    """A square room on its own map: four places fit, a quarter of a turn about its middle apart."""
    monkeypatch.setattr(navigator, "LOST_SECONDS", 3.0)
    square, pose, told = room(3.0, 3.0), np.array([0.8, 1.1, 0.3]), list[str]()
    lost = Driven(Navigator(Localiser(known(square, 3.0, 3.0)), UGV, say=told.append), pose, pose.copy(), told=told)
    lost.navigator.go(Goal(2.0, 2.0))
    assert drive([lost], lambda time: square, rng) > 0.0
    assert told[-1].startswith("gives up: several places of this map look alike to the lidar: ("), told
    assert told[-1].endswith(": say where it starts with --from") and told[-1].count("°") == 4, told


@pytest.mark.parametrize("sonars", [0, 3])
def test_what_lies_below_the_lidar_is_heard(sonars: int, rng: np.random.Generator) -> None:
    """A flat box in the way, which the lidar's rays pass above: only with sonars, as of the UGV, it is gone around."""
    walls = room(4.0, 2.4)
    ugv = vehicle(known(walls, 4.0, 2.4), (0.6, 1.2, 0.0), Goal(3.4, 1.2))
    ugv.low = (Box(2.0, 1.15, 0.3, 0.5, 0.05, "#a52"),)
    mounts = np.array([(0.14, 0.0, 0.0), (0.12, 0.08, 0.6), (0.12, -0.08, -0.6)])
    ugv.sonars = tuple(Sonar(mount, np.radians(15.0), 3.0) for mount in mounts[:sonars])
    nearest = drive([ugv], lambda time: walls, rng)
    assert (nearest > 0.0) == (sonars > 0)
    assert ugv.navigator.reached and distance(ugv.pose, (3.4, 1.2)) < 0.2, ugv.told


def test_an_echo_that_the_lidar_explains_is_no_obstacle() -> None:
    """A wall 1 m ahead is heard at 1 m; a thing at 0.5 m before it, which the lidar doesn't see, is across the cone."""
    sonar = Sonar(np.array([0.1, 0.0, 0.0]), np.radians(15.0), 3.0)
    wall = np.column_stack([np.full(50, 1.0), np.linspace(-1.0, 1.0, 50)])
    assert not len(sonar.unseen(0.9, wall)) and not len(sonar.unseen(np.inf, wall)) and not len(sonar.unseen(3.5, wall))
    found = sonar.unseen(0.4, wall)
    np.testing.assert_allclose(np.hypot(found[:, 0] - 0.1, found[:, 1]), 0.4)
    assert np.ptp(np.arctan2(found[:, 1], found[:, 0] - 0.1)) == pytest.approx(np.radians(30.0))
