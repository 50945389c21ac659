"""What sensors say, as people see it: pixels of the viewer's page in a real browser."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from virtualrobot_kernel.sensing.overlays import PointColor, SensorOverlay, turbo
from virtualrobot_kernel.sensing.reading import Reading, SensorState
from virtualrobot_kernel.world.commands import RemoveNode, UpdateNode
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, RangeSensor
from virtualrobot_kernel.world.structure import Kind

from tests.drawing.cell import at
from tests.drawing.conftest import Stage
from tests.unit.sensing.test_overlays import Beams, Scan

pytestmark = pytest.mark.long

NEAR, FAR = (turbo(np.array([part]))[0].astype(int) for part in (0.0, 1.0))
"""The colours of the nearest and of the farthest echo."""


@dataclass
class Picture:
    color: np.ndarray


@dataclass
class Pictures:
    pictures: tuple[Picture]
    kinds: tuple[ImageKind] = (ImageKind.COLOR,)


def is_like(seen: np.ndarray, color: np.ndarray, most: int = 40) -> bool:
    return bool(np.abs(seen - color).max() <= most)


def reading(stage: Stage, name: str, content: object) -> Reading:
    """Return what a sensor says where it is now."""
    snapshot = stage.cell.snapshot
    uid = stage.cell.uid(name)
    return Reading(snapshot, uid, name, SensorState.RUNNING, "", 1, 0, snapshot.world_t(uid), content, 0.001)


def say(stage: Stage, name: str, content: object) -> None:
    told = reading(stage, name, content)
    stage.readings[told.uid] = told


def wall(columns: int = 160, rows: int = 160) -> Scan:
    """Return echoes of a wall of 1 m x 1 m across x at 2 m: the lower half strong, the middle nearest."""
    y, z = np.meshgrid(np.linspace(-0.5, 0.5, columns), np.linspace(0.5, -0.5, rows))
    places = np.stack([np.full(y.size, 2.0), y.ravel(), z.ravel()], axis=1)
    distances = np.linalg.norm(places, axis=1)
    strengths = np.where(places[:, 2] < 0.0, 1.0, 0.0).astype(np.float32)
    return Scan(
        distances.astype(np.float32),
        np.ones(len(places), np.uint8),
        strengths,
        Beams(np.zeros((1, 3)), places / distances[:, None]),
    )


def scanner(stage: Stage) -> int:
    """Add a range sensor that looks along y, as FRONT does; what is 2 m before it is at y = 0. Return its uid."""
    pose = at(0.0, -2.0, 0.0)
    pose[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    stage.cell.add("scanner", kind=Kind.RANGE_SENSOR, data=RangeSensor(), pose=pose)
    return stage.cell.uid("scanner")


def test_points_have_the_colours_of_their_distances_and_of_their_strength(stage: Stage) -> None:
    uid = scanner(stage)
    say(stage, "scanner", wall())
    assert is_like(stage.pixel(0.0, 0.0), np.array([51, 102, 153]), 2)  # nothing is shown before it is asked for
    stage.view.update(sensors=(SensorOverlay(uid, points=True),))
    stage.wait(lambda: is_like(stage.pixel(0.01, 0.01), NEAR) and is_like(stage.pixel(0.49, 0.49), FAR))
    stage.view.update(sensors=(SensorOverlay(uid, points=True, color_by=PointColor.INTENSITY),))
    stage.wait(lambda: is_like(stage.pixel(0.0, -0.2), FAR) and is_like(stage.pixel(0.0, 0.2), NEAR))
    # Another scan, of another number of points, takes its place.
    fewer = wall(150, 150)
    say(stage, "scanner", replace(fewer, intensities=1.0 - fewer.intensities))
    stage.wait(lambda: is_like(stage.pixel(0.01, -0.2), NEAR) and is_like(stage.pixel(0.01, 0.21), FAR))
    # Points stay where they were seen, wherever the sensor goes; without the sensor they are gone.
    stage.cell.do(UpdateNode("scanner", parent_t_node=at(5.0, 0.0, 0.0)))
    stage.wait(lambda: is_like(stage.pixel(0.01, -0.2), NEAR))
    stage.cell.do(RemoveNode("scanner"))
    stage.wait(lambda: is_like(stage.pixel(0.01, -0.2), np.array([51, 102, 153]), 2))


def test_rays_go_from_the_sensor_to_their_echoes(stage: Stage) -> None:
    """A sensor that looks along x, across the picture: one echo at 1 m, and one beam downwards without."""
    stage.cell.add("scanner", kind=Kind.RANGE_SENSOR, data=RangeSensor())
    scan = Scan(
        np.array([1.0, np.inf], np.float32),
        np.array([1, 0], np.uint8),
        np.ones(2, np.float32),
        Beams(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])),
    )
    say(stage, "scanner", scan)
    stage.view.update(sensors=(SensorOverlay(stage.cell.uid("scanner"), rays=True),))

    def rows(x: float) -> int:
        """Return how many pixels of a column are drawn on between 4 cm above and below the beam."""
        offsets = np.linspace(-0.04, 0.04, 17)
        return sum(not is_like(stage.pixel(x, z), np.array([51, 102, 153]), 12) for z in offsets)

    stage.wait(lambda: rows(0.5) > 0)
    assert rows(0.95) > 0 and rows(1.1) == 0 and rows(-0.1) == 0
    columns = [not is_like(stage.pixel(x, -0.15), np.array([51, 102, 153]), 12) for x in np.linspace(-0.04, 0.04, 17)]
    assert any(columns)
    assert all(is_like(stage.pixel(x, -0.5), np.array([51, 102, 153]), 12) for x in np.linspace(-0.04, 0.04, 17))
    # A scan without any beam that says something is no picture, and no fault.
    say(stage, "scanner", replace(scan, valid=np.zeros(2, np.uint8)))
    stage.wait(lambda: rows(0.5) == 0)


def test_a_camera_shows_its_pyramid_and_its_picture(stage: Stage) -> None:
    """The camera looks along y as FRONT does; its picture, red at the left and green at the right, is at y = 0."""
    pose = at(0.0, -0.3, 0.0)
    pose[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    data = CameraSensor(width=64, height=48, horizontal_field_radians=1.2)
    stage.cell.add("eye", kind=Kind.CAMERA_SENSOR, data=data, pose=pose)
    uid = stage.cell.uid("eye")
    half = 0.3 * np.tan(0.6)
    blue = np.array([51, 102, 153])
    stage.view.update(sensors=(SensorOverlay(uid, frustum=True),))

    def edge() -> bool:
        return any(not is_like(stage.pixel(x, 0.0), blue, 12) for x in np.linspace(half - 0.03, half + 0.03, 13))

    stage.wait(edge)
    assert is_like(stage.pixel(0.5 * half, 0.03), blue, 12)
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[:, :32, 0] = pixels[:, 32:, 1] = 255
    say(stage, "eye", Pictures((Picture(pixels),)))
    stage.view.update(sensors=(SensorOverlay(uid, image=True),))
    left, right = (lambda: stage.pixel(-0.5 * half, 0.03)), (lambda: stage.pixel(0.5 * half, 0.03))
    stage.wait(lambda: left()[0] > 150 > 60 > left()[1] and right()[1] > 150 > 60 > right()[0])
    say(stage, "eye", Pictures((Picture(pixels[:, ::-1]),)))
    stage.wait(lambda: left()[1] > 150 > 60 > left()[0])
    stage.view.update(sensors=())
    stage.wait(lambda: is_like(left(), blue, 2))
