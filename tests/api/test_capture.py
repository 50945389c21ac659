"""ViewService.CaptureImage and ViewService.PickPixel: pictures without a browser, against projections computed here.

The eye looks along +y from 4 m away, so column = middle + f x / depth and row = middle - f z / depth, with
f = height / 2 / tan(0.9 / 2).
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator

import numpy as np
import pytest
from google.protobuf.field_mask_pb2 import FieldMask
from PIL import Image
from virtualrobot.v1 import geometry_pb2, nodes_pb2, scene_pb2, sensing_pb2, sensor_pb2, view_pb2

from tests.api.asking import PANDA, apply, create, load, refusal
from tests.api.reading import array, pose, values
from tests.api.test_scene import remove, update
from tests.kernels import Stubs

WIDTH, HEIGHT = 320, 240
DISTANCE = 4.0
FOCAL = 0.5 * HEIGHT / math.tan(0.45)
MIDDLE = 0.5 * (WIDTH - 1), 0.5 * (HEIGHT - 1)
BACKGROUND = (51, 102, 153)
Vector = geometry_pb2.Vector3
RED = geometry_pb2.Color(red=0.8, green=0.1, blue=0.1, alpha=1.0)
GREEN = geometry_pb2.Color(red=0.1, green=0.7, blue=0.2, alpha=1.0)
FRONT = view_pb2.Camera(position=Vector(y=-DISTANCE), target=Vector())
NAN = float("nan")


@pytest.fixture
def stage(stepped: Stubs) -> Iterator[Stubs]:
    """Return stubs to an empty world before a plain background, without a grid."""
    view = view_pb2.View(background=geometry_pb2.Color(red=0.2, green=0.4, blue=0.6), grid_hidden=True)
    change(stepped, view, "background", "grid_hidden")
    yield stepped
    change(stepped, view_pb2.View(), *[field.name for field in view_pb2.View.DESCRIPTOR.fields])


def change(stubs: Stubs, view: view_pb2.View, *fields: str) -> None:
    stubs.view.UpdateView(view_pb2.UpdateViewRequest(view=view, update_mask=FieldMask(paths=fields)))


def capture(stubs: Stubs, **fields: object) -> np.ndarray:
    """Return a picture (h, w, 3) as signed numbers."""
    shot = view_pb2.Shot(**{"camera": FRONT, "width": WIDTH, "height": HEIGHT, **fields})  # pyright: ignore[reportArgumentType]
    shot.format = view_pb2.IMAGE_FORMAT_RAW
    answer = stubs.view.CaptureImage(view_pb2.CaptureImageRequest(shot=shot))
    return np.frombuffer(answer.image, np.uint8).reshape(answer.height, answer.width, 3).astype(int)


def node(name: str, *place: float, parent: str = "", **figure: object) -> scene_pb2.Command:
    """Return the command that adds a node with one figure."""
    at = geometry_pb2.Pose(position=Vector(x=place[0], y=place[1], z=place[2]))
    color = figure.pop("color", RED)
    shown = nodes_pb2.Figure(material=nodes_pb2.Material(color=color), **figure)  # pyright: ignore[reportArgumentType]
    return create(nodes_pb2.Node(name=name, parent=parent, part=nodes_pb2.Part(), parent_t_node=at, figures=[shown]))


def pixel(x: float, y: float, z: float) -> tuple[float, float]:
    """Return column and row of a point of the world."""
    depth = y + DISTANCE
    return MIDDLE[0] + FOCAL * x / depth, MIDDLE[1] - FOCAL * z / depth


def foreground(picture: np.ndarray) -> np.ndarray:
    return np.abs(picture - BACKGROUND).max(axis=2) > 10


def near(picture: np.ndarray, x: float, y: float, z: float) -> np.ndarray:
    """Return the colours (n, 3) of the pixel of a point and its neighbours."""
    column, row = (round(value) for value in pixel(x, y, z))
    return picture[row - 1 : row + 2, column - 1 : column + 2].reshape(-1, 3)


def test_a_sphere_has_the_silhouette_of_the_formula(stage: Stubs, rng: np.random.Generator) -> None:
    """Seen from its middle's axis, a sphere's outline is a circle of radius f r / sqrt(d^2 - r^2)."""
    radius = float(rng.uniform(0.3, 0.8))
    apply(stage, node("ball", 0.0, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=radius)))
    picture = capture(stage)
    seen = foreground(picture)
    outline = FOCAL * radius / math.sqrt(DISTANCE**2 - radius**2)
    # A pixel on the edge counts however little of it is covered: half a pixel more all around, on average.
    assert math.sqrt(seen.sum() / math.pi) == pytest.approx(outline + 0.4, abs=0.4)
    rows, columns = np.nonzero(seen)
    for found, middle in ((rows, MIDDLE[1]), (columns, MIDDLE[0])):
        assert found.min() == pytest.approx(middle - outline, abs=1.0)
        assert found.max() == pytest.approx(middle + outline, abs=1.0)
    assert (picture[~seen] == BACKGROUND).all(axis=1).mean() > 0.99
    red, green, blue = picture[seen].T
    assert (red > 2 * np.maximum(green, blue))[10:-10].mean() > 0.95
    stage.view.CaptureImage(view_pb2.CaptureImageRequest())  # framed by itself


def test_points_and_lines_are_where_they_project_and_hidden_behind_a_box(stage: Stubs) -> None:
    positions = array([[0.5, 0.0, 0.4], [-0.5, 0.0, 0.4]])
    segments = array([[[-0.8, 0.0, -0.5], [0.8, 0.0, -0.5]]])
    apply(
        stage,
        node("dots", 0.0, 0.0, 0.0, color=GREEN, points=nodes_pb2.Points(positions=positions, size_meters=0.05)),
        node("line", 0.0, 0.0, 0.0, color=GREEN, lines=nodes_pb2.Lines(segments=segments, width_pixels=3.0)),
    )

    def is_green(picture: np.ndarray, *place: float) -> bool:
        red, green, blue = near(picture, *place).T
        return bool((green > 1.5 * np.maximum(red, blue)).any())

    places = [(0.5, 0.0, 0.4), (-0.5, 0.0, 0.4), (-0.7, 0.0, -0.5), (0.7, 0.0, -0.5)]
    picture = capture(stage)
    assert [is_green(picture, *place) for place in places] == [True] * 4
    assert foreground(picture).mean() < 0.02, "and nothing else"
    assert not foreground(capture(stage, plain=True)).any()
    # A box before the left half hides its halves of both; behind everything it hides nothing.
    size = Vector(x=1.0, y=0.1, z=2.0)
    apply(stage, node("box", -0.6, -0.5, 0.0, box=nodes_pb2.Box(size=size)))
    picture = capture(stage)
    assert [is_green(picture, *place) for place in places] == [True, False, False, True]
    apply(stage, remove("box"))
    apply(stage, node("box", -0.6, 0.5, 0.0, box=nodes_pb2.Box(size=size)))
    picture = capture(stage)
    assert [is_green(picture, *place) for place in places] == [True] * 4


def test_boxes_axes_measurements_labels_and_the_grid_are_drawn(stage: Stubs) -> None:
    """Each of them changes the picture, and a plain one has the grid alone."""
    apply(stage, node("box", 0.0, 0.0, 0.0, box=nodes_pb2.Box(size=Vector(x=0.5, y=0.5, z=0.5))))
    above = view_pb2.Camera(position=Vector(y=-DISTANCE, z=1.0), target=Vector())
    before = capture(stage, camera=above)
    shown = {
        "bounding_boxes": view_pb2.View(bounding_boxes=["box"]),
        "measurements": view_pb2.View(
            measurements=[view_pb2.Measurement(name="m", first=at("box", 0.3), second=at("", 1.0))]
        ),
        "grid_hidden": view_pb2.View(grid_hidden=False),
    }
    for field, view in shown.items():
        change(stage, view, field)
        after = capture(stage, camera=above)
        assert (after != before).any(axis=2).sum() > 50, field
        before = after
    apply(stage, node("note", 0.0, 0.0, 0.5, label=nodes_pb2.Label(text="here")))
    apply(stage, node("axes", 0.8, 0.0, 0.0, frame=nodes_pb2.Frame(length_meters=0.4)))
    with_words = capture(stage, camera=above)
    assert (with_words != before).any(axis=2).sum() > 100
    plain = capture(stage, camera=above, plain=True)
    change(stage, view_pb2.View(), "bounding_boxes", "measurements")
    apply(stage, remove("note"), remove("axes"))
    assert (plain == capture(stage, camera=above)).all()
    assert foreground(plain).sum() > foreground(capture(stage)).sum(), "the grid is there"


def at(name: str, x: float) -> view_pb2.NodePoint:
    return view_pb2.NodePoint(node=name, point=Vector(x=x))


def test_files_are_of_the_asked_format_and_size(stage: Stubs) -> None:
    apply(stage, node("ball", 0.0, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=0.5)))
    exact = capture(stage)
    for format, name, error in (
        (view_pb2.IMAGE_FORMAT_UNSPECIFIED, "PNG", 0),
        (view_pb2.IMAGE_FORMAT_PNG, "PNG", 0),
        (view_pb2.IMAGE_FORMAT_JPEG, "JPEG", 1.0),
    ):
        shot = view_pb2.Shot(camera=FRONT, width=WIDTH, height=HEIGHT, format=format)
        answer = stage.view.CaptureImage(view_pb2.CaptureImageRequest(shot=shot))
        image = Image.open(io.BytesIO(answer.image))
        assert (image.format, image.size) == (name, (WIDTH, HEIGHT))
        assert np.abs(np.asarray(image).astype(int) - exact).mean() <= error
    answer = stage.view.CaptureImage(view_pb2.CaptureImageRequest())
    assert (answer.width, answer.height) == Image.open(io.BytesIO(answer.image)).size == (1280, 720)
    shot = view_pb2.Shot(width=37, height=1)
    assert stage.view.CaptureImage(view_pb2.CaptureImageRequest(shot=shot)).width == 37


def test_a_hidden_node_is_not_seen_and_a_moved_one_elsewhere(stage: Stubs) -> None:
    apply(stage, node("ball", 0.0, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=0.4)))
    assert foreground(capture(stage)).any()
    for hidden in (True, False):
        apply(stage, update("ball", "hidden", hidden=hidden))
        assert foreground(capture(stage)).any() != hidden
    apply(stage, update("ball", "parent_t_node", parent_t_node=geometry_pb2.Pose(position=Vector(x=0.7))))
    columns = np.nonzero(foreground(capture(stage)))[1]
    assert columns.mean() == pytest.approx(pixel(0.7, 0.0, 0.0)[0], abs=2.0)


def test_a_pick_meets_the_sphere_where_geometry_says(stage: Stubs, rng: np.random.Generator) -> None:
    radius, turn = 0.6, 0.7
    ball = node("ball", 0.0, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=radius))
    ball.create_node.node.parent_t_node.orientation.CopyFrom(
        geometry_pb2.Quaternion(z=math.sin(turn / 2), w=math.cos(turn / 2))
    )
    apply(stage, ball)
    for _ in range(10):
        column, row = rng.uniform(-0.4, 0.4, 2) * FOCAL * radius / DISTANCE + MIDDLE
        request = view_pb2.PickPixelRequest(camera=FRONT, width=WIDTH, height=HEIGHT, column=column, row=row)
        found = stage.view.PickPixel(request)
        direction = np.array([(column - MIDDLE[0]) / FOCAL, 1.0, -(row - MIDDLE[1]) / FOCAL])
        direction /= np.linalg.norm(direction)
        eye = np.array([0.0, -DISTANCE, 0.0])
        along = -eye @ direction
        distance = along - math.sqrt(along**2 - DISTANCE**2 + radius**2)
        point = eye + distance * direction
        assert found.node == "ball"
        assert found.distance_meters == pytest.approx(distance, abs=1e-5)
        np.testing.assert_allclose(three(found.world_point), point, atol=2e-5)
        np.testing.assert_allclose(three(found.normal), point / radius, atol=1e-4)
        cosine, sine = math.cos(turn), math.sin(turn)
        np.testing.assert_allclose(
            three(found.node_point),
            [cosine * point[0] + sine * point[1], cosine * point[1] - sine * point[0], point[2]],
            atol=2e-5,
        )
        color = found.color.red, found.color.green, found.color.blue
        np.testing.assert_allclose(color, (0.8, 0.1, 0.1), atol=0.003)
    nothing = stage.view.PickPixel(view_pb2.PickPixelRequest(camera=FRONT, width=WIDTH, height=HEIGHT))
    assert (nothing.node, nothing.distance_meters) == ("", math.inf)


def three(vector: geometry_pb2.Vector3) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def sensor(name: str, world_t_sensor: np.ndarray, **fields: object) -> scene_pb2.Command:
    camera = sensing_pb2.CameraSensor(**fields)  # pyright: ignore[reportArgumentType]
    return create(nodes_pb2.Node(name=name, camera_sensor=camera, parent_t_node=pose(world_t_sensor)))


FORWARD = np.array([[1.0, 0, 0, 0], [0, 0, 1, -DISTANCE], [0, -1, 0, 0], [0, 0, 0, 1]])
"""Where an optical frame sees what FRONT sees."""


def test_a_camera_of_the_scene_sees_through_its_own_lens(stage: Stubs) -> None:
    """Its focal length is (width / 2) / tan(field / 2)."""
    apply(
        stage,
        node("ball", 0.5, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=0.3)),
        sensor("eye", FORWARD, width=200, height=100, horizontal_field_radians=0.8),
    )
    picture = capture(stage, camera_sensor="eye", camera=None, width=0, height=0)
    assert picture.shape == (100, 200, 3)
    focal = 100.0 / math.tan(0.4)
    is_red = picture[..., 0] > 1.5 * picture[..., 2]
    rows, columns = np.nonzero(is_red)
    assert columns.mean() == pytest.approx(99.5 + focal * 0.5 / DISTANCE, abs=1.5)
    assert rows.mean() == pytest.approx(49.5, abs=0.5)
    larger = capture(stage, camera_sensor="eye", camera=None, width=400, height=200)
    assert np.nonzero(larger[..., 0] > 1.5 * larger[..., 2])[1].mean() == pytest.approx(2 * columns.mean() + 0.5, abs=2)
    request = view_pb2.PickPixelRequest(camera_sensor="eye", column=99.5 + focal * 0.5 / (DISTANCE - 0.3), row=49.5)
    found = stage.view.PickPixel(request)
    np.testing.assert_allclose(three(found.world_point), (0.5, -0.3, 0.0), atol=0.04)


@pytest.mark.long
def test_a_plain_picture_through_a_camera_is_the_cameras_own(stage: Stubs) -> None:
    """Whatever its lens; colours are compared with what the sensor says of the same tick."""
    load(stage, PANDA, "arm")
    apply(stage, node("ball", 0.5, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=0.3)))
    lenses = {
        "pinhole": {"distortion": [0.1, -0.05, 0.001, 0.002]},
        "fisheye": {"projection": sensing_pb2.CAMERA_PROJECTION_FISHEYE, "horizontal_field_radians": 2.5},
        "spherical": {"projection": sensing_pb2.CAMERA_PROJECTION_SPHERICAL},
    }
    for name, settings in lenses.items():
        apply(stage, sensor(name, FORWARD, width=120, height=80, **settings))
        reading = stage.sensor.ReadSensor(sensor_pb2.ReadSensorRequest(sensor=name)).reading.camera
        own = values(reading.images[0].pixels)
        captured = capture(stage, camera_sensor=name, camera=None, width=0, height=0, plain=True)
        assert (captured == own).all(), name
        assert len(np.unique(own.reshape(-1, 3), axis=0)) > 3, "there is something to see"


@pytest.mark.parametrize("projection", ["PINHOLE", "FISHEYE", "SPHERICAL"])
def test_points_are_where_each_lens_sees_what_is_there(stage: Stubs, projection: str) -> None:
    """A point on the front of a small ball is drawn over the ball, wherever in the picture that is."""
    at_least = 1.0 if projection == "PINHOLE" else 2.0
    apply(
        stage,
        sensor(
            "eye",
            FORWARD,
            width=240,
            height=160,
            projection=sensing_pb2.CameraProjection.Value(f"CAMERA_PROJECTION_{projection}"),
            horizontal_field_radians=at_least,
            distortion=[] if projection == "SPHERICAL" else [0.05, -0.02, 0.001, 0.001],
        ),
    )
    for number, (x, z) in enumerate([(0.0, 0.0), (1.2, 0.5), (-1.3, -0.7), (0.9, -0.9)]):
        apply(stage, node(f"ball{number}", x, 0.0, z, sphere=nodes_pb2.Sphere(radius_meters=0.1)))
    balls = capture(stage, camera_sensor="eye", camera=None, width=0, height=0)
    places = array([[x, -0.1, z] for x, z in [(0.0, 0.0), (1.2, 0.5), (-1.3, -0.7), (0.9, -0.9)]])
    apply(stage, node("dots", 0.0, 0.0, 0.0, color=GREEN, points=nodes_pb2.Points(positions=places, size_meters=0.03)))
    drawn = capture(stage, camera_sensor="eye", camera=None, width=0, height=0)
    rows, columns = np.nonzero((drawn != balls).any(axis=2))
    assert len(rows) >= 4 * 4
    is_red = balls[rows, columns, 0] > 1.5 * balls[rows, columns, 2]
    assert is_red.mean() > 0.9, "they are on the balls"


def test_what_no_picture_can_be_taken_of_is_refused_by_its_field(stage: Stubs) -> None:
    apply(stage, sensor("eye", FORWARD), node("ball", 0.0, 0.0, 0.0, sphere=nodes_pb2.Sphere(radius_meters=0.5)))
    here = Vector(x=1.0)
    for field, reason, shot in (
        ("shot.width", "INVALID_ARGUMENT", view_pb2.Shot(width=100_000)),
        ("shot.height", "INVALID_ARGUMENT", view_pb2.Shot(height=4097)),
        ("shot.camera.position", "INVALID_ARGUMENT", camera_shot(Vector(x=NAN), here)),
        ("shot.camera.target", "INVALID_ARGUMENT", camera_shot(here, Vector(y=math.inf))),
        ("camera.position", "INVALID_ARGUMENT", camera_shot(here, here)),
        ("shot.camera.field_of_view_radians", "INVALID_ARGUMENT", camera_shot(here, Vector(), NAN)),
        ("format", "INVALID_ARGUMENT", view_pb2.Shot(format=9)),  # pyright: ignore[reportArgumentType]
        (None, "UNKNOWN_NAME", view_pb2.Shot(camera_sensor="nobody")),
        (None, "UNKNOWN_NAME", view_pb2.Shot(camera_sensor="ball")),
    ):
        for ask in (stage.view.CaptureImage, lambda request: next(stage.view.RecordFilm(request))):
            make = view_pb2.CaptureImageRequest if ask == stage.view.CaptureImage else view_pb2.RecordFilmRequest
            refused = refusal(lambda ask=ask, make=make, shot=shot: ask(make(shot=shot)))
            assert (refused.reason, refused.metadata.get("field")) == (reason, field)
    for field, request in (
        ("column", view_pb2.PickPixelRequest(camera=FRONT, column=NAN)),
        ("column", view_pb2.PickPixelRequest(camera=FRONT, column=1280.0)),
        ("row", view_pb2.PickPixelRequest(camera=FRONT, row=-1.0)),
        ("row", view_pb2.PickPixelRequest(camera_sensor="eye", row=480.0)),
        ("width", view_pb2.PickPixelRequest(camera_sensor="eye", width=100)),
        ("width", view_pb2.PickPixelRequest(camera=FRONT, width=100_000)),
        ("camera.position", view_pb2.PickPixelRequest(camera=view_pb2.Camera(position=Vector(z=NAN)))),
    ):
        refused = refusal(lambda request=request: stage.view.PickPixel(request))
        assert (refused.reason, refused.metadata["field"]) == ("INVALID_ARGUMENT", field)
    assert (
        refusal(lambda: stage.view.PickPixel(view_pb2.PickPixelRequest(camera_sensor="nobody"))).reason
        == "UNKNOWN_NAME"
    )


def camera_shot(position: Vector, target: Vector, field: float = 0.0) -> view_pb2.Shot:
    return view_pb2.Shot(camera=view_pb2.Camera(position=position, target=target, field_of_view_radians=field))
