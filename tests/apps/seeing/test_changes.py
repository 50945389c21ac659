"""Surveillance: what changed between two scans of a furnished room, by rays met by formula, with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import virtualrobot
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.sensors.range_sensors import RangeReading
from virtualrobot_apps.seeing.changes.comparing import OtherPlaceError, compare
from virtualrobot_apps.seeing.changes.registering import registered
from virtualrobot_apps.seeing.changes.scan import Floats, Scan, scan_of

from tests.apps.seeing import box_scanner
from tests.apps.seeing.box_scanner import Box, rays, room

RAYS = rays(np.radians(120.0), np.radians(50.0), np.radians(0.4))
COARSE = rays(np.radians(120.0), np.radians(50.0), np.radians(1.0))
SIGMA = 0.005
"""Deviation (m) of a distance."""
POSE = virtualrobot.pose(0.6, 2.4, 1.5, pitch=0.25)
FURNITURE: list[Box] = [
    ((5.0, 0.2, 0.0), (6.4, 1.0, 0.8)),
    ((2.5, 4.2, 0.0), (3.9, 5.0, 1.9)),
    ((4.5, 3.2, 0.0), (4.9, 3.6, 1.1)),
    ((6.2, 2.0, 0.7), (7.0, 3.4, 0.75)),
]
ROOM = [*room(7.0, 5.0, 2.6), *FURNITURE]


def again(rng: np.random.Generator) -> Floats:
    """Return where the sensor stands when it comes again: 15 mm and half a degree off in each direction (1 sigma)."""
    return POSE @ virtualrobot.pose(*rng.normal(0.0, 0.015, 3), *rng.normal(0.0, np.radians(0.5), 3))


def scanned(boxes: list[Box], pose: Floats, rng: np.random.Generator, along: Floats = RAYS) -> Scan:
    """Return a scan; the robot says that the sensor is where it was the first time."""
    return box_scanner.scan_of(boxes, pose, along, rng, SIGMA, POSE)


@pytest.mark.long
def test_nothing_is_new_where_nothing_changed(rng: np.random.Generator) -> None:
    """The second scan's pose, which the robot has wrong by centimeters, is found to 3 mm, and nothing is alarmed on."""
    before = scanned(ROOM, POSE, rng)
    for _ in range(2):
        pose = again(rng)
        found = compare(before, scanned(ROOM, pose, rng))
        assert not found.changes
        off = np.linalg.inv(np.linalg.inv(POSE) @ pose) @ found.registration.pose
        assert np.linalg.norm(off[:3, 3]) < 0.003 and np.arccos(0.5 * (np.trace(off[:3, :3]) - 1.0)) < 0.002


@pytest.mark.long
def test_boxes_of_80_mm_are_found_where_they_stand_and_where_they_stood(rng: np.random.Generator) -> None:
    """Within 4.5 m, where five rays or more meet one; its place is off by less than half of its size."""
    before = scanned(ROOM, POSE, rng)
    for appeared in (True, False):
        while True:
            place = np.array([*rng.uniform((2.7, 1.0), (4.4, 3.6)), 0.04])
            if all((place + 0.3 < low).any() or (place - 0.3 > high).any() for low, high in FURNITURE):
                break
        cube = (tuple((place - 0.04).tolist()), tuple((place + 0.04).tolist()))
        other = scanned([*ROOM, cube], again(rng), rng)  # pyright: ignore[reportArgumentType]
        found = compare(before, other) if appeared else compare(other, before)
        (change,) = found.changes
        assert change.appeared == appeared
        assert np.linalg.norm(change.place[:2] - place[:2]) < (0.04 if appeared else 0.1)
        assert change.size.max() < 0.12 and change.volume < 0.08**3 * 1.5
        # Down to the floor, 5 mm deviate; across, up to a ray's spacing is missing on either side.
        if appeared:
            assert abs(change.size[2] - 0.08) < 0.02 and abs(change.place[2] - 0.04) < 0.01
            assert 0.03 < change.size[:2].min()
        words = "stands now at" if appeared else "stood at"
        assert words in str(change)


@pytest.mark.long
def test_a_scan_of_another_room_is_said_and_no_alarm(rng: np.random.Generator) -> None:
    before = scanned(ROOM, POSE, rng, COARSE)
    for other in (
        [*room(7.0, 4.0, 3.1), ((3.0, 1.0, 0.0), (4.0, 2.0, 1.0))],
        [*room(4.0, 8.0, 2.6), ((2.0, 3.0, 0.0), (2.5, 4.0, 2.0))],
    ):
        with pytest.raises(OtherPlaceError, match=r"fits the first one to \d+%, and 80% at least are needed"):
            compare(before, scanned(other, again(rng), rng, COARSE))  # pyright: ignore[reportArgumentType]


def test_a_registration_is_exact_without_noise(rng: np.random.Generator) -> None:
    """Of the same points, moved by a pose: it is found to a hundredth of a millimeter."""
    points = box_scanner.scan_of(ROOM, POSE, COARSE, rng, 0.0, POSE).points
    pose = virtualrobot.pose(0.02, -0.01, 0.015, 0.01, -0.008, 0.012)
    back = np.linalg.inv(pose)
    found = registered(points, points @ back[:3, :3].T + back[:3, 3], np.eye(4))
    np.testing.assert_allclose(found.pose, pose, atol=1e-4)
    assert found.share == 1.0


def test_the_robot_says_how_far_it_has_come_along_a_corridor(rng: np.random.Generator) -> None:
    """Walls tell all but that; clouds alone, each with its noise, would be laid on each other anywhere along it."""
    corridor: list[Box] = [
        ((-30.0, 1.0, -0.1), (30.0, 4.0, 0.0)),
        ((-30.0, 1.0, 2.6), (30.0, 4.0, 2.7)),
        ((-30.0, 0.9, 0.0), (30.0, 1.0, 2.6)),
        ((-30.0, 4.0, 0.0), (30.0, 4.1, 2.6)),
    ]
    pose = again(rng)
    first, second = (scanned(corridor, each, rng, COARSE).points for each in (POSE, pose))
    off = (POSE @ registered(first, second, np.eye(4)).pose)[:3, 3] - pose[:3, 3]
    assert abs(off[0] - (POSE - pose)[0, 3]) < 0.005 and np.abs(off[1:]).max() < 0.005


def test_things_that_have_moved_lead_no_scan_astray(rng: np.random.Generator) -> None:
    """Each by 0.1 to 0.25 m, so that its points are within reach of where they were: the walls outvote it."""
    moved: list[Box] = [
        ((5.0, 0.3, 0.0), (6.4, 1.1, 0.8)),
        ((2.7, 4.1, 0.0), (4.1, 4.9, 1.9)),
        ((4.3, 3.0, 0.0), (4.7, 3.4, 1.1)),
        ((6.0, 2.0, 0.7), (6.8, 3.4, 0.75)),
    ]
    pose = again(rng)
    first = scanned(ROOM, POSE, rng, COARSE).points
    found = registered(first, scanned([*room(7.0, 5.0, 2.6), *moved], pose, rng, COARSE).points, np.eye(4)).pose
    off = np.linalg.inv(np.linalg.inv(POSE) @ pose) @ found
    assert np.linalg.norm(off[:3, 3]) < 0.006


def test_a_scan_without_noise_that_is_the_same_is_no_change(rng: np.random.Generator) -> None:
    scan = box_scanner.scan_of(ROOM, POSE, COARSE, rng, 0.0, POSE)
    found = compare(scan, replace(scan, points=scan.points.copy()))
    assert found.identical and not found.changes and found.registration.share == 1.0
    assert not compare(scan, scanned(ROOM, POSE, rng, COARSE)).identical


def test_bad_scans_are_refused_in_words(rng: np.random.Generator) -> None:
    scan = scanned(ROOM, POSE, rng, COARSE)
    with pytest.raises(InvalidArgumentError, match=r"1 of \d+ points of the scan are not .* is number 7"):
        Scan(np.where(np.arange(len(scan.points))[:, None] == 7, np.nan, scan.points), POSE)
    with pytest.raises(InvalidArgumentError, match=r"points of the scan have the shape \(n, 3\), not \(300, 2\)"):
        Scan(np.zeros((300, 2)), POSE)
    with pytest.raises(InvalidArgumentError, match="world_t_sensor is a pose"):
        Scan(scan.points, np.full((4, 4), np.nan))
    patch = Scan(np.array([2.0, 0.0, 0.0]) + rng.uniform(0.0, 0.05, (300, 3)), POSE)
    with pytest.raises(InvalidArgumentError, match=r"the second cloud fills \d cubes of 0.06 m, and 20 at least"):
        compare(scan, patch)
    with pytest.raises(InvalidArgumentError, match="the scan has 0 echoes, and 200 at least"):
        Scan(np.zeros((0, 3)), POSE)
    distances = np.full((2, 3), np.inf, np.float32)
    nothing = np.zeros((2, 3), bool)
    reading = RangeReading(distances, nothing, None, None, (), None, "sensor", None)
    with pytest.raises(InvalidArgumentError, match="the reading has no points in its sensor's frame"):
        scan_of(reading, POSE)
    empty = RangeReading(distances, nothing, None, None, (), np.full((2, 3, 3), np.nan, np.float32), "sensor", None)
    with pytest.raises(InvalidArgumentError, match="the scan has 0 echoes"):
        scan_of(empty, POSE)
