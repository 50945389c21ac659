"""Parts of navigation: each by formulas, on floors whose walls are known exactly."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError
from virtualrobot.sensors.range_sensors import RangeReading
from virtualrobot_apps.seeing.navigation import floors
from virtualrobot_apps.seeing.navigation.following import Limits, Surroundings, choose
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.grid import MOST, Grid, load
from virtualrobot_apps.seeing.navigation.localising import Localiser
from virtualrobot_apps.seeing.navigation.mapping import Mapper
from virtualrobot_apps.seeing.navigation.matching import Cloud, normals_of
from virtualrobot_apps.seeing.navigation.navigator import Goal, Navigator, Observation
from virtualrobot_apps.seeing.navigation.planning import Costmap, NoWayError, Planner, length
from virtualrobot_apps.seeing.navigation.pose_graph import Relation, optimised
from virtualrobot_apps.seeing.navigation.poses import Floats, arc, between, compose, distance, moved, wrapped
from virtualrobot_apps.seeing.navigation.regions import Distances, apart
from virtualrobot_apps.seeing.navigation.scans import QUIET, OdometryTrack, ScanMaker
from virtualrobot_apps.seeing.navigation.unforeseen import Unforeseen

from tests.apps.seeing.flat_lidar import scan_at
from tests.apps.seeing.flat_vehicles import room

FOOTPRINT = Footprint(-0.2, 0.1, -0.134, 0.134)


def wall(first: tuple[float, float], second: tuple[float, float], count: int = 120) -> Floats:
    """Return points along a wall, its ends among them."""
    return np.linspace(first, second, count)


def cloud_of(*walls: Floats) -> tuple[Floats, Floats]:
    """Return points of walls as seen from the origin, and their normals."""
    points = np.vstack(walls)
    return points, np.vstack([normals_of(one, np.zeros(2)) for one in walls])


def test_poses_chain_as_groups_do(rng: np.random.Generator) -> None:
    """Laws: a (a⁻¹ b) = b; an arc of t1 + t2 is that of t1, then that of t2; points go the way of their frame."""
    a, b = rng.uniform(-3.0, 3.0, (2, 50, 3))
    np.testing.assert_allclose(between(compose(a, between(a, b)), b), 0.0, atol=1e-12)
    twist = rng.uniform(-1.0, 1.0, (50, 2))
    np.testing.assert_allclose(between(compose(arc(twist, 0.3), arc(twist, 0.5)), arc(twist, 0.8)), 0.0, atol=1e-12)
    there = moved(a[0], moved(b[0], np.eye(2)))
    np.testing.assert_allclose(there, moved(compose(a[0], b[0]), np.eye(2)), atol=1e-12)


def test_a_scan_made_while_turning_is_straight_again() -> None:
    """Rays of one turn in 0.2 s, each from where the lidar was then on a circle; the wall is x = 2 in the world."""
    twist, mount = np.array([0.5, 1.0]), np.array([0.05, -0.02, 0.3])
    ages = np.linspace(0.2, 0.0, 40)
    track = OdometryTrack()
    for time in np.arange(0.0, 1.0005, 0.001):
        track.add(time, arc(twist, time))
    then = compose(arc(twist, 1.0 - ages), mount)
    rays = np.linspace(-0.6, 0.4, 40) - then[:, 2]
    heading = then[:, 2] + rays
    reach = (2.0 - then[:, 0]) / np.cos(heading)
    points = np.column_stack([reach * np.cos(rays), reach * np.sin(rays), np.zeros(40)])
    reading = RangeReading(
        reach[None].astype(np.float32),
        np.ones((1, 40), bool),
        None,
        None,
        (),
        points[None].astype(np.float32),
        "sensor",
        ages.astype(np.float32),
    )
    scan = ScanMaker(mount, 3.5).scan(1.0, reading, track)
    met = moved(arc(twist, 1.0), scan.points)
    np.testing.assert_allclose(met[:, 0], 2.0, atol=1e-6)
    np.testing.assert_allclose(met[:, 1], then[:, 1] + reach * np.sin(heading), atol=1e-6)


def test_rays_that_tell_zero_have_passed_what_is_far() -> None:
    """A lidar whose distance is 0 without echo: where its neighbours are far, and not where something may be too near.

    Ray 0 has had no echo at all yet: its direction goes on from those of the others.
    """
    angles = np.arange(8) * np.pi / 4.0
    distances = np.array([0.0, 2.0, 3.0, 0.3, 0.0, 0.3, 3.0, 2.0], np.float32)[None]
    valid = distances > 0.0
    points = np.stack([distances * np.cos(angles), distances * np.sin(angles), 0.0 * distances], axis=2)
    points[~valid] = np.nan
    reading = RangeReading(distances, valid, None, None, (), points.astype(np.float32), "sensor", None)
    track = OdometryTrack()
    track.add(0.0, np.zeros(3))
    scan = ScanMaker(np.zeros(3), 3.5).scan(0.0, reading, track)
    assert len(scan.points) == 6 and not len(scan.empty)
    np.testing.assert_allclose(scan.quiet, [(QUIET * 3.5, 0.0)], atol=1e-6)


def test_a_match_is_exact_without_noise_and_corners(rng: np.random.Generator) -> None:
    points, normals = cloud_of(wall((2, -1), (2, 1)), wall((-1, 1.5), (1, 1.5)), wall((-2, -1), (-1.5, 1)))
    cloud = Cloud(points, normals)
    for true in rng.uniform(-0.08, 0.08, (5, 3)):
        back = between(true, np.zeros(3))
        inner = np.vstack([one[20:-20] for one in np.split(points, 3)])
        facing = np.vstack([one[20:-20] for one in np.split(normals, 3)])
        turn = np.array([0.0, 0.0, back[2]])
        found = cloud.match(moved(back, inner), moved(turn, facing), np.zeros(3))
        np.testing.assert_allclose(between(true, found.pose), 0.0, atol=1e-6)
        assert found.share == 1.0 and not found.weak


def test_both_sides_of_a_thin_wall_are_told_apart() -> None:
    """A wall 80 mm thick, seen from one side and matched with what is seen of its other side: nothing draws."""
    points, normals = cloud_of(wall((1.0, -1), (1.0, 1)))
    found = Cloud(points, normals).match(points + np.array([0.08, 0.0]), -normals, np.zeros(3))
    np.testing.assert_array_equal(found.pose, 0.0)


def test_along_a_corridor_odometry_tells() -> None:
    points, normals = cloud_of(wall((-2, 0.8), (2, 0.8), 300), wall((-2, -0.8), (2, -0.8), 300))
    true = np.array([0.3, 0.05, 0.02])
    back, guess = between(true, np.zeros(3)), np.array([0.3, 0.0, 0.0])
    seen = np.abs(points[:, 0]) < 1.2
    turned = moved(np.array([0.0, 0.0, back[2]]), normals[seen])
    found = Cloud(points, normals).match(moved(back, points[seen]), turned, guess, (0.05, 0.05))
    np.testing.assert_allclose(found.pose, true, atol=2e-4)
    assert found.weak


def test_a_pose_graph_spreads_what_a_loop_is_off(rng: np.random.Generator) -> None:
    """A square driven around by odometry that turns 2% too much; the loop says that the end is the beginning."""
    step = np.array([0.5, 0.0, np.pi / 8])
    true = [np.zeros(3)]
    thought = [np.zeros(3)]
    for _ in range(16):
        true.append(compose(true[-1], step))
        thought.append(compose(thought[-1], step * [1.0, 1.0, 1.02]))
    relations = [Relation(n, n + 1, step * [1.0, 1.0, 1.02], 0.01, 0.01) for n in range(16)]
    relations.append(Relation(0, 16, np.zeros(3), 0.001, 0.001))
    found = optimised(np.array(thought), relations)
    assert distance(thought[-1], true[-1]) > 0.05 and distance(found[-1], true[-1]) < 0.005
    exact = [Relation(n, n + 1, step, 0.01, 0.01) for n in range(16)]
    rough = np.array(true) + np.vstack([np.zeros(3), rng.normal(0.0, 0.02, (16, 3))])
    np.testing.assert_allclose(between(np.array(true), optimised(rough, exact)), 0.0, atol=1e-6)


@pytest.mark.long
def test_a_map_of_noisy_scans_is_true(rng: np.random.Generator, seed: int) -> None:
    """Down a corridor and back with 3% too much way and 4% too much turn by odometry."""
    boxes, mapper = floors.floor(seed), Mapper(np.array(floors.START))
    pose, odometry = np.array(floors.START), np.zeros(3)
    off = []
    twists = [(0.0, 0.0), *[(0.4, 0.0)] * 30, *[(0.0, 1.0)] * 16, *[(0.4, 0.0)] * 20]
    for number, twist in enumerate(twists):
        step = arc(np.array(twist), 0.2)
        pose, odometry = compose(pose, step), compose(odometry, step * [1.03, 1.0, 1.04])
        found = mapper.update(scan_at(boxes, pose, odometry, rng, 0.2 * number))
        off.append(between(pose, found))
    errors = np.array(off)
    assert np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean()) < 0.05 and np.abs(errors[:, 2]).max() < 0.04
    assert distance(compose(np.array(floors.START), odometry), pose) > 0.1
    # What it has as occupied is so: within noise and two cells.
    true = np.min([box.apart(mapper.grid.obstacles()) for box in boxes], axis=0)
    assert np.quantile(true, 0.9) < 0.1


@pytest.mark.long
def test_half_of_a_room_that_looks_like_the_other_is_no_loop(rng: np.random.Generator) -> None:
    """Around a partition to its far side, and around there: most draws slid by 2 m once, and tore the map."""
    furniture = [(2.0, 0.6, 0.1, 1.2), (3.6, 2.75, 0.8, 0.5), (0.3, 2.4, 0.6, 0.4)]
    boxes = [*room(4.0, 3.0), *(floors.Box(*one, 0.5, "#a52") for one in furniture)]
    corners = np.array([(0.7, 0.7), (1.7, 1.58), (2.46, 1.97), (3.6, 2.15), (3.65, 1.5), (2.85, 0.65), (2.44, 0.37)])
    way, heading = list[Floats](), 0.0
    for first, second in itertools.pairwise(corners):
        turn = float(wrapped(np.arctan2(*(second - first)[::-1]) - heading))
        turns = heading + turn * np.linspace(0.0, 1.0, max(2, int(abs(turn) / 0.2)))
        heading += turn
        steps = np.linspace(first, second, int(distance(first, second) / 0.1))
        way += [*(np.array([*first, one]) for one in turns), *(np.array([*one, heading]) for one in steps)]
    way += [np.array([*corners[-1], heading + one]) for one in np.arange(0.0, 2.0 * np.pi, 0.2)]
    for _ in range(3):
        mapper = Mapper(way[0])
        off = [distance(mapper.update(scan_at(boxes, pose, pose, rng)), pose) for pose in way]
        assert mapper.loops > 3 and max(off) < 0.1


@pytest.mark.long
def test_a_lost_vehicle_is_found_in_its_own_map_alone(rng: np.random.Generator, seed: int) -> None:
    """It drives in a room until one place alone fits; in a map of another floor it stays lost."""
    boxes = floors.floor(seed)
    places = floors.places(boxes, 2, seed, 0.5)
    localiser = Localiser(floors.true_grid(boxes, 0.05))
    other = Localiser(floors.true_grid(floors.floor(seed + 1), 0.05))
    pose = np.array([*places[0], 1.0])
    for number in range(8):
        step = arc(np.array([0.0, 0.8]), 0.2)
        pose = compose(pose, step)
        scan = scan_at(boxes, pose, pose, rng, 0.2 * number)
        found = localiser.update(scan)
        if number < 2:
            other.update(scan)
            assert other.lost
    assert not localiser.lost
    assert distance(found, pose) < 0.1 and abs(between(pose, found)[2]) < 0.05


def test_maps_are_files_as_ros_has_them(tmp_path: Path, rng: np.random.Generator) -> None:
    grid = Grid(0.05, np.array([-1.5, 2.0]), rng.choice([-MOST, 0.0, MOST], (30, 40)))
    grid.save(tmp_path / "floor.yaml")
    again = load(tmp_path / "floor.yaml")
    np.testing.assert_array_equal(again.log_odds, grid.log_odds)
    np.testing.assert_array_equal(again.origin, grid.origin)
    # Of a picture the first row is at the top: the last of the map.
    picture = (tmp_path / "floor.pgm").read_bytes()[-1200:]
    assert picture[0] == {-MOST: 254, 0.0: 205, MOST: 0}[float(grid.log_odds[-1, 0])]
    with pytest.raises(MissingFileError, match="there is no map"):
        load(tmp_path / "none.yaml")
    for text, words in (("- 1", "no map"), ("image: floor.pgm\nresolution: 0\norigin: [0, 0]", "edge of a cell")):
        (tmp_path / "bad.yaml").write_text(text, "utf-8")
        with pytest.raises(MalformedFileError, match=words):
            load(tmp_path / "bad.yaml")


def two_rooms() -> Grid:
    """Return a map of 4 m x 4 m with a wall along x = 2 that has a door 0.8 m wide at y = 3."""
    log_odds = np.full((80, 80), -MOST)
    log_odds[:, 40] = MOST
    log_odds[52:68, 40] = -MOST
    return Grid(0.05, np.zeros(2), log_odds)


def test_a_way_leads_through_the_door_and_refusals_have_numbers() -> None:
    planner = Planner(Costmap.of(two_rooms(), FOOTPRINT, np.zeros((0, 2))))
    way = planner.way(np.array([1.0, 1.0]), np.array([3.0, 1.0]))
    straight = 2.0 * np.hypot(1.0, 2.0)
    assert straight - 0.6 < length(way) < 1.15 * straight
    through = way[np.argmin(np.abs(way[:, 0] - 2.025))]
    assert abs(through[1] - 3.0) < 0.2
    for goal, words in (
        ((9.0, 9.0), "off the map"),
        ((2.02, 1.0), "inside an obstacle"),
        ((2.15, 1.0), "needs 0.16 m"),
    ):
        with pytest.raises(NoWayError, match=words):
            planner.way(np.array([1.0, 1.0]), np.array(goal))
    shut = Planner(Costmap.of(two_rooms(), Footprint(-0.6, 0.6, -0.5, 0.5), np.zeros((0, 2))))
    with pytest.raises(NoWayError, match=r"widest passage to the goal \(3\.00, 1\.00\) is 0\.\d+ m, .* needs 1\.06 m"):
        shut.way(np.array([1.0, 1.0]), np.array([3.0, 1.0]))


def test_distances_that_are_kept_are_those_measured_anew(rng: np.random.Generator) -> None:
    """Bit by bit, with what is seen near and far from walls that change now and then, and with no walls at all."""
    distances, walls = Distances(), np.zeros((40, 60), bool)
    for number in range(30):
        if number % 10 == 5:
            walls = rng.random(walls.shape) < 0.01
        rows, columns = rng.integers(0, 40, number % 4), rng.integers(0, 60, number % 4)
        both = walls.copy()
        both[rows, columns] = True
        np.testing.assert_array_equal(distances.of(walls, rows, columns), apart(both))


def test_what_is_chosen_touches_nothing_and_nothing_where_all_is_near() -> None:
    way = np.column_stack([np.linspace(0.0, 3.0, 60), np.zeros(60)])
    free = choose(np.zeros(3), (0.3, 0.0), way, Surroundings(np.zeros((0, 2))), FOOTPRINT, Limits())
    assert free is not None and free.twist[0] > 0.3 and abs(free.twist[1]) < 0.1
    block = Surroundings(wall((0.5, -0.3), (0.5, 0.3)))
    around = choose(np.zeros(3), (0.3, 0.0), way, block, FOOTPRINT, Limits())
    assert around is not None and around.clearance > 0.02
    driven = arc(np.array(around.twist), np.linspace(0.0, 1.6, 30))
    apart = moved(driven, FOOTPRINT.outline()[None])[..., None, :] - wall((0.5, -0.3), (0.5, 0.3))
    assert np.hypot(apart[..., 0], apart[..., 1]).min() > 0.0
    inside = Surroundings(wall((0.1, -0.1), (0.1, 0.1)))
    assert choose(np.zeros(3), (0.0, 0.0), way, inside, FOOTPRINT, Limits()) is None


def test_what_stood_in_the_way_is_forgotten_once_rays_go_through() -> None:
    boxes = [floors.Box(2.0, 0.0, 0.1, 4.0, 1.0, "#fff")]
    empty = Grid(0.05, np.array([-3.0, -3.0]), np.full((120, 120), -MOST))
    for row, column in zip(*empty.cells(wall((1.97, -2.0), (1.97, 2.0))), strict=True):
        empty.log_odds[row, column] = MOST
    unforeseen = Unforeseen()
    crate = floors.Box(1.0, 0.0, 0.3, 0.3, 1.0, "#fff")
    unforeseen.update(scan_at([*boxes, crate], np.zeros(3), time=1.0), np.zeros(3), empty)
    assert len(unforeseen.points()) > 3
    assert crate.apart(unforeseen.points()).max() < 0.01
    unforeseen.update(scan_at(boxes, np.zeros(3), time=1.2), np.zeros(3), empty)
    assert not len(unforeseen.points())


def led(
    boxes: list[floors.Box], grid: Grid, start: Floats, goal: Goal, silent: bool = False
) -> tuple[list[str], Floats]:
    """Lead a vehicle that does as told, in a world whose clock has gone before; return what was told, and its end."""
    told: list[str] = []
    navigator = Navigator(Localiser(grid, start), FOOTPRINT, say=told.append)
    navigator.go(goal)
    pose, time = start, 800.0
    while navigator.end is None and time < 920.0:
        scan = None if silent or round(20.0 * time) % 4 else scan_at(boxes, pose, pose, time=time)
        twist = navigator.step(Observation(time, pose, scan))
        pose, time = compose(pose, arc(np.array(twist), 0.05)), time + 0.05
    return told, pose


@pytest.mark.long
def test_each_end_is_told_in_words(seed: int) -> None:
    boxes = floors.floor(seed)
    grid, start = floors.true_grid(boxes, 0.05), np.array(floors.START)
    told, pose = led(boxes, grid, start, Goal(2.5, 4.5))
    assert told == ["has come to (2.50, 4.50)"] and distance(pose, (2.5, 4.5)) < 0.12
    told, pose = led(boxes, grid, start, Goal(6.0, -0.05))
    assert told[-1].startswith("gives up: the goal (6.00, -0.05) is") and distance(pose, start) < 0.01
    told, pose = led(boxes, grid, start, Goal(2.5, 4.5), silent=True)
    assert told[-1] == "gives up: no scan of 'lidar' comes, for 10 s" and distance(pose, start) == 0.0
    # The corridor is shut where the map has nothing: it waits, and then says how wide the passage is.
    shut = [*boxes, floors.Box(2.0, 4.5, 0.2, 1.6, 1.0, "#fff")]
    told, pose = led(shut, grid, start, Goal(2.5, 4.5))
    assert told[-1].startswith("gives up") and pose[0] < 1.9


def test_a_goal_has_finite_numbers() -> None:
    """It is refused when it is made, before anything drives."""
    for numbers in ((np.nan, 0.0), (0.0, np.inf), ("a", 1.0), (1.0, None), (0.0, 0.0, np.nan)):
        with pytest.raises(InvalidArgumentError, match=r"a goal has finite numbers, not Goal\("):
            Goal(*numbers)  # pyright: ignore[reportArgumentType]
    assert Goal(1, np.float32(2.0)).heading is None  # pyright: ignore[reportArgumentType]
