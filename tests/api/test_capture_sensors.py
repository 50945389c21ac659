"""What is shown of sensors in pictures without a browser; places as in `test_capture`, colours by the map's formula."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot.v1 import geometry_pb2, kernel_pb2, nodes_pb2, scene_pb2, sensing_pb2, sensor_pb2, view_pb2
from virtualrobot_kernel.sensing.overlays import MISS_COLOR, turbo

from tests.api.asking import apply, create
from tests.api.reading import array
from tests.api.test_capture import BACKGROUND, GREEN, capture, change, near, node, pixel
from tests.api.test_capture import stage as stage
from tests.kernels import Stubs

Vector = geometry_pb2.Vector3
NEAREST, FARTHEST = (turbo(np.array([part]))[0].astype(int) for part in (0.0, 1.0))


@pytest.fixture
def scene(stage: Stubs) -> Iterator[Stubs]:
    """Return stubs to a world with a wall at x = 1 and a lidar at the origin that runs, seen from the side.

    Its beams lie in the plane y = 0: three of them meet the wall at z = 0, 0.5 and -0.5, a fourth one goes down and
    meets nothing. Thin lines are blended with what is behind them, up to one half.
    """
    beams = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 0.0, -0.5], [0.0, 0.0, -1.0]])
    pattern = sensing_pb2.ScanPattern(
        free=sensing_pb2.FreeBeams(
            directions=geometry_pb2.NumericArray(
                type=geometry_pb2.NUMERIC_TYPE_FLOAT64, shape=[4, 3], data=beams.tobytes()
            )
        )
    )
    wall = node("wall", 1.05, 0.0, 0.0, box=nodes_pb2.Box(size=Vector(x=0.1, y=0.001, z=2.0)), color=GREEN)
    lidar = nodes_pb2.Node(name="lidar", range_sensor=sensing_pb2.RangeSensor(pattern=pattern, running=True))
    apply(stage, wall, create(lidar))
    stage.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=25))
    yield stage


def show(stubs: Stubs, **fields: object) -> None:
    shown = view_pb2.SensorOverlay(sensor="lidar", **fields)  # pyright: ignore[reportArgumentType]
    change(stubs, view_pb2.View(sensors=[shown]), "sensors")


def colors(picture: np.ndarray, x: float, z: float, reach: int = 1) -> np.ndarray:
    """Return the colours (n, 3) of the pixels around a place in the plane y = 0."""
    column, row = (round(one) for one in pixel(x, 0.0, z))
    return picture[row - reach : row + reach + 1, column - reach : column + reach + 1].reshape(-1, 3)


def has(picture: np.ndarray, x: float, z: float, color: np.ndarray | tuple[int, int, int], reach: int = 1) -> bool:
    return bool((np.abs(colors(picture, x, z, reach) - np.array(color)).max(axis=1) < 80).any())


def test_points_and_rays_are_drawn_where_they_are_and_in_their_colours(scene: Stubs) -> None:
    assert not has(capture(scene), 0.5, 0.0, NEAREST)
    show(scene, points=True)
    picture = capture(scene)
    assert has(picture, 1.0, 0.0, NEAREST) and has(picture, 1.0, 0.5, FARTHEST) and has(picture, 1.0, -0.5, FARTHEST)
    assert (colors(picture, 0.5, 0.0) == BACKGROUND).all()
    show(scene, rays=True)
    picture = capture(scene)
    assert has(picture, 0.5, 0.0, NEAREST) and has(picture, 0.5, 0.25, FARTHEST)
    # Without an echo, 0.3 m are shown.
    assert has(picture, 0.0, -0.2, MISS_COLOR) and (colors(picture, 0.0, -0.4) == BACKGROUND).all()
    assert (colors(capture(scene, plain=True), 0.5, 0.0) == BACKGROUND).all()


def test_a_sensor_that_is_stopped_shows_nothing(scene: Stubs) -> None:
    show(scene, rays=True)
    apply(scene, scene_pb2.Command(stop_sensors=sensor_pb2.StopSensors(sensors=["lidar"])))
    assert (colors(capture(scene), 0.5, 0.0) == BACKGROUND).all()


def test_films_show_sensors_too(scene: Stubs) -> None:
    show(scene, rays=True)
    shot = view_pb2.Shot(camera=view_pb2.Camera(position=Vector(y=-4.0)), width=320, height=240)
    shot.format = view_pb2.IMAGE_FORMAT_RAW
    film = scene.view.RecordFilm(view_pb2.RecordFilmRequest(shot=shot, frames_per_second=50, duration_seconds=0.02))
    first = np.frombuffer(next(iter(film)).image, np.uint8).reshape(240, 320, 3).astype(int)
    assert has(first, 0.5, 0.0, NEAREST)
    film.cancel()


def test_a_camera_has_its_pyramid_and_its_picture(stage: Stubs) -> None:
    """A camera at y = -0.3 that looks as the eye does: the base of its pyramid is at y = 0; it sees red at 10 m."""
    place = geometry_pb2.Pose(position=Vector(y=-0.3), orientation=geometry_pb2.Quaternion(x=-(0.5**0.5), w=0.5**0.5))
    sensor = sensing_pb2.CameraSensor(width=64, height=48, horizontal_field_radians=1.2, running=True)
    far = node("far", 0.0, 10.0, 0.0, box=nodes_pb2.Box(size=Vector(x=40.0, y=0.1, z=40.0)))
    apply(stage, far, create(nodes_pb2.Node(name="eye", parent_t_node=place, camera_sensor=sensor)))
    stage.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=25))
    half = 0.3 * np.tan(0.6)
    behind = capture(stage)
    overlay = view_pb2.SensorOverlay(sensor="eye", frustum=True)
    change(stage, view_pb2.View(sensors=[overlay]), "sensors")
    picture = capture(stage)
    edge = np.abs(colors(picture, half, 0.0) - colors(behind, half, 0.0)).max(axis=1)
    assert edge.max() > 40 and (colors(picture, 0.75 * half, 0.0) == colors(behind, 0.75 * half, 0.0)).all()
    # Something green before its eye fills its picture alone, since it is nearer than the eye's own figures.
    near = node("near", 0.0, -0.2, 0.0, box=nodes_pb2.Box(size=Vector(x=0.2, y=0.001, z=0.2)), color=GREEN)
    apply(stage, near)
    stage.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=25))
    overlay.image = True
    change(stage, view_pb2.View(sensors=[overlay]), "sensors")
    at_edge = colors(capture(stage), 0.75 * half, 0.0)
    assert (at_edge[:, 1] > 1.5 * at_edge[:, 0]).all()
    # Through the camera itself there is neither.
    through = capture(stage, camera=None, camera_sensor="eye", width=0, height=0)
    assert (through[20:28, 28:36, 1] > 1.5 * through[20:28, 28:36, 0]).all()


def test_what_is_behind_a_cameras_picture_is_hidden_by_it(stage: Stubs) -> None:
    """The picture stands at y = 0: lines behind it are hidden as far as it goes, those before it are not."""
    place = geometry_pb2.Pose(position=Vector(y=-0.3), orientation=geometry_pb2.Quaternion(x=-(0.5**0.5), w=0.5**0.5))
    sensor = sensing_pb2.CameraSensor(width=64, height=48, horizontal_field_radians=1.2, running=True)
    across = array([[[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]], [[-1.0, -0.5, 0.05], [1.0, -0.5, 0.05]]])
    apply(
        stage,
        node("far", 0.0, 10.0, 0.0, box=nodes_pb2.Box(size=Vector(x=40.0, y=0.1, z=40.0))),
        create(nodes_pb2.Node(name="eye", parent_t_node=place, camera_sensor=sensor)),
        node("lines", 0.0, 0.0, 0.0, color=GREEN, lines=nodes_pb2.Lines(segments=across, width_pixels=3.0)),
    )
    stage.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=25))

    def is_green(picture: np.ndarray, *place: float) -> bool:
        red, green, _ = near(picture, *place).T
        return bool((green > 1.5 * red).any())

    places = [(0.1, 1.0, 0.0), (0.6, 1.0, 0.0), (0.1, -0.5, 0.05)]
    assert [is_green(capture(stage), *place) for place in places] == [True, True, True]
    change(stage, view_pb2.View(sensors=[view_pb2.SensorOverlay(sensor="eye", image=True)]), "sensors")
    assert [is_green(capture(stage), *place) for place in places] == [False, True, True]
