"""What a camera says as a sensor: pictures of each eye, their noise, and the truth in them."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image
from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.camera_reader import CameraContent, CameraReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.commands import RemoveNode, UpdateNode
from virtualrobot_kernel.world.figures import Box, Figure, Material, Mesh, Sphere
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Light, Projection
from virtualrobot_kernel.world.structure import Kind
from virtualrobot_sdk.srgb import to_linear

from tests.drawing.cell import Cell
from tests.unit.sensing.studio import at, looking

ALL = tuple(ImageKind)
GREY = Material((0.5, 0.5, 0.5, 1.0))
Read = Callable[..., CameraContent]


@contextmanager
def reading(cell: Cell, camera: CameraSensor, pose: np.ndarray | None = None) -> Iterator[Read]:
    """Give what reads a camera at `pose` (looking along z): read(number, kinds)."""
    cell.add("camera", Figure(Box((0.1, 0.1, 0.1))), pose=pose, kind=Kind.CAMERA_SENSOR, data=camera)
    node = cell.snapshot.structure.node("camera")

    def read(number: int = 1, kinds: object | None = None) -> CameraContent:
        rng = np.random.default_rng((camera.seed, number))
        return reader.read(Moment(cell.snapshot, (), number, rng), kinds)

    try:
        with closing(CameraReader(node, ShapeLibrary(cell.meshes), AppearanceLibrary(cell.meshes))) as reader:
            yield read
    finally:
        cell.do(RemoveNode("camera"))


def pixels(content: CameraContent, name: str, eye: int = 0) -> np.ndarray:
    values = getattr(content.pictures[eye], name)
    assert values is not None
    return values


@pytest.fixture
def cell() -> Cell:
    """Return a grey wall at z = 3 that fills the picture, and a ball before it."""
    cell = Cell()
    cell.add("wall", Figure(Box((20, 20, 1)), material=GREY), pose=at(0, 0, 3.5))
    cell.add("ball", Figure(Sphere(0.3)), Figure(Box((0.1, 2.0, 0.1))), pose=at(0, 0, 2.0))
    return cell


def test_segmentation_names_nodes_and_the_camera_does_not_see_itself(cell: Cell) -> None:
    with reading(cell, CameraSensor(64, 48, images=(ImageKind.SEGMENTATION,))) as read:
        content = read()
        assert content.kinds == (ImageKind.SEGMENTATION,)
        assert content.pictures[0].color is None
        places = pixels(content, "segmentation")
        assert {content.element_names[place] for place in np.unique(places)} == {"wall", "ball"}
        assert content.element_names[places[24, 32]] == "ball"
        assert content.element_names[places[2, 32]] == "ball"  # the bar is another figure of the same node
        assert content.element_names[places[0, 0]] == "wall"
        cell.do(UpdateNode("ball", hidden=True))
        content = read()
        assert {content.element_names[place] for place in np.unique(pixels(content, "segmentation"))} == {"wall"}


def test_a_camera_without_images_takes_colour_and_one_that_is_asked_what_is_asked(cell: Cell) -> None:
    with reading(cell, CameraSensor(32, 24)) as read:
        assert read().kinds == (ImageKind.COLOR,)
        content = read(1, (ImageKind.NORMALS, ImageKind.DEPTH))
        assert content.kinds == (ImageKind.DEPTH, ImageKind.NORMALS)
        assert content.pictures[0].color is None


def test_the_noise_of_colour_has_its_mean_and_deviation(cell: Cell, seed: int) -> None:
    cell.do(UpdateNode("ball", hidden=True))
    camera = CameraSensor(200, 150, color_noise=0.04, seed=seed)
    cell.add("lamp", kind=Kind.LIGHT, data=Light(intensity=1e-9))
    with reading(cell, camera) as read:
        first = pixels(read(1), "color").astype(float)
        truth = float(np.median(first))  # ambient light only: every pixel is equal
        noise = first - truth
        # 90,000 draws of deviation 10.2, rounded: the mean is within 5 standard errors, the deviation within 2 %.
        assert abs(noise.mean()) < 5 * 10.2 / np.sqrt(noise.size) + 0.5
        assert noise.std() == pytest.approx(0.04 * 255, rel=0.02)
        np.testing.assert_array_equal(pixels(read(1), "color"), first)
        assert (pixels(read(2), "color") != first).mean() > 0.9
        # What else is asked for does not change it.
        np.testing.assert_array_equal(pixels(read(1, ALL), "color"), first)


def test_the_noise_of_depth_grows_with_its_square(cell: Cell, seed: int) -> None:
    camera = CameraSensor(200, 150, images=(ImageKind.DEPTH,), depth_noise_meters=0.002, seed=seed)
    with reading(cell, replace(camera, depth_noise_meters=0.0)) as read:
        truth = pixels(read(), "depth")
    with reading(cell, camera) as read:
        noise = pixels(read(), "depth") - truth
    for near, far in ((1.6, 2.4), (2.9, 3.1)):
        there = (truth > near) & (truth < far)
        parts = noise[there] / truth[there] ** 2
        count = there.sum()
        assert count > 300
        assert abs(parts.mean()) < 6 * 0.002 / np.sqrt(count)
        assert parts.std() == pytest.approx(0.002, rel=6 / np.sqrt(2 * count))


WATER = (0.4, 0.1, 0.0)


def through(cell: Cell, camera: CameraSensor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the picture without water, that in water, as linear light, and the depth (m)."""
    with reading(cell, replace(camera, water_attenuation_per_meter=None, water_color=None)) as read:
        content = read(1, (ImageKind.COLOR, ImageKind.DEPTH))
        plain, depth = pixels(content, "color"), pixels(content, "depth")
    with reading(cell, camera) as read:
        content = read(1)
        assert content.kinds == (ImageKind.COLOR,) and content.pictures[0].depth is None
        seen = pixels(content, "color")
        np.testing.assert_array_equal(pixels(read(1, ALL), "color"), seen)
        np.testing.assert_array_equal(pixels(read(1, ALL), "depth"), depth)
    return to_linear(plain / 255.0), to_linear(seen / 255.0), depth


def test_light_fades_in_water_by_the_distance_along_the_ray(cell: Cell) -> None:
    """Beer and Lambert: e^(-c d) of it is left; at the edge of a picture d is more than the depth."""
    plain, seen, depth = through(
        cell, CameraSensor(65, 49, horizontal_field_radians=1.6, water_attenuation_per_meter=WATER)
    )
    half = np.tan(0.8) / 32.5
    x, y = np.meshgrid((np.arange(65) - 32) * half, (np.arange(49) - 24) * half)
    distance = depth * np.sqrt(1.0 + x**2 + y**2)
    assert distance.max() > 1.3 * depth.max()
    exact = plain * np.exp(-distance[..., None] * np.array(WATER))
    # A step of a screen is 2 % of its light at the most, here.
    np.testing.assert_allclose(seen, exact, atol=0.01)
    np.testing.assert_allclose(seen[..., 2], plain[..., 2], atol=1e-3)


def test_what_is_nowhere_is_water(cell: Cell) -> None:
    color = (0.1, 0.4, 0.6, 1.0)
    camera = CameraSensor(32, 24, far_meters=1.0, water_attenuation_per_meter=(0.5, 0.5, 0.5), water_color=color)
    with reading(cell, camera) as read:
        seen = pixels(read(), "color")
    assert np.abs(seen - 255.0 * np.array(color[:3])).max() <= 1.0


def test_nothing_stays_nothing_with_noise() -> None:
    cell = Cell()
    cell.add("ball", Figure(Sphere(0.3)), pose=at(0, 0, 2))
    with reading(cell, CameraSensor(32, 24, depth_noise_meters=0.01)) as read:
        depth = pixels(read(1, [ImageKind.DEPTH]), "depth")
    assert np.isinf(depth[0, 0]) and np.isfinite(depth[12, 16])
    assert not np.isnan(depth).any()


def speckle(rng: np.random.Generator) -> bytes:
    grain = cv2.resize(rng.integers(0, 255, (128, 128, 3), np.uint8), (512, 512), interpolation=cv2.INTER_CUBIC)
    packed = io.BytesIO()
    Image.fromarray(grain).save(packed, "PNG")
    return packed.getvalue()


def test_stereo_depth_is_the_true_depth(rng: np.random.Generator) -> None:
    """Disparity is focal length times baseline by depth; OpenCV finds it within a quarter of a pixel, mostly."""
    cell = Cell()
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    part = Submesh(
        corners,
        np.array([[0, 2, 1], [0, 3, 2]], np.int32),
        uv=(0.5 * corners[:, :2] + np.float32(0.5)),
        texture=speckle(rng),
    )
    for name, size, place in (("wall", 3.0, at(0, 0, 4.0)), ("board", 0.5, at(0.2, 0.1, 2.5))):
        mesh = Mesh(f"{name}.obj", name)
        cell.told[mesh.uri] = (Submesh(part.vertices * size, part.faces, uv=part.uv, texture=part.texture),)
        cell.add(name, Figure(mesh), pose=place)
    camera = CameraSensor(320, 240, horizontal_field_radians=1.0, stereo_baseline_meters=0.12)
    with reading(cell, camera) as read:
        content = read(1, (ImageKind.COLOR, ImageKind.DEPTH))
    left, right = (cv2.cvtColor(pixels(content, "color", eye), cv2.COLOR_RGB2GRAY) for eye in (0, 1))
    matcher = cv2.StereoSGBM.create(0, 32, 5, P1=8 * 25, P2=32 * 25, uniquenessRatio=5)
    found = matcher.compute(left, right).astype(float) / 16.0
    truth = content.lens.intrinsics.fx * content.baseline / pixels(content, "depth")
    valid = (found > 0) & np.isfinite(truth)
    error = np.abs(found - truth)[valid]
    assert valid.mean() > 0.7
    assert np.median(error) < 0.25
    assert np.percentile(error, 90) < 1.0  # the rest are edges, which one eye alone sees
    both = [content.lens.intrinsics.fx * 0.12 / z for z in (4.0, 2.5)]
    np.testing.assert_allclose(np.unique(np.round(truth[valid], 3)), both, atol=1e-3)


def test_the_eyes_stand_apart_along_x_of_the_camera() -> None:
    cell = Cell()
    cell.add("floor", Figure(Box((50, 50, 1))), pose=at(0, 0, -0.5))
    cell.add("post", Figure(Box((0.02, 0.02, 9))), pose=at(0.3, 0, 0))
    # Looks down the y axis from y = -2: x of the picture is x of the world.
    camera = CameraSensor(321, 241, images=(ImageKind.SEGMENTATION,), stereo_baseline_meters=0.6)
    with reading(cell, camera, looking([0, -2, 1], [0, 0, 1])) as read:
        content = read()
    place = content.element_names.index("post")
    middles = [np.flatnonzero(pixels(content, "segmentation", eye)[100] == place).mean() for eye in (0, 1)]
    offset = content.lens.intrinsics.fx * 0.3 / 1.995
    np.testing.assert_allclose(middles, [160 + offset, 160 - offset], atol=1.0)


def test_pictures_that_no_message_can_carry_are_refused(cell: Cell) -> None:
    with (
        pytest.raises(LimitError, match=r"4000 x 4000 pixels, 2 eyes, kinds .* take 736,000,000 bytes; at most"),
        reading(cell, CameraSensor(4000, 4000, images=ALL, stereo_baseline_meters=0.1)),
    ):
        pass
    with reading(cell, CameraSensor(4000, 4000)) as read, pytest.raises(LimitError, match="fewer pixels or kinds"):
        read(1, ALL)


def test_a_moved_camera_sees_from_where_it_is(cell: Cell) -> None:
    with reading(cell, CameraSensor(33, 25, images=(ImageKind.DEPTH,))) as read:
        assert pixels(read(), "depth")[12, 16] == pytest.approx(1.7, abs=1e-3)
        cell.do(UpdateNode("camera", parent_t_node=at(0, 0, 1.0)))
        assert pixels(read(), "depth")[12, 16] == pytest.approx(0.7, abs=1e-3)
        cell.do(UpdateNode("ball", parent_t_node=at(0, 0, 2.5)))
        assert pixels(read(), "depth")[12, 16] == pytest.approx(1.2, abs=1e-3)


def test_a_spherical_camera_sees_all_around() -> None:
    cell = Cell()
    for name, place in {"front": (0, 0, 3), "right": (3, 0, 0), "below": (0, 3, 0), "back": (0, 0, -3)}.items():
        cell.add(name, Figure(Sphere(0.6)), pose=at(*place))
    camera = CameraSensor(128, projection=Projection.SPHERICAL, images=(ImageKind.SEGMENTATION,))
    with reading(cell, camera) as read:
        content = read()
    seen = pixels(content, "segmentation")
    assert seen.shape == (64, 128)
    for name, (row, column) in {"front": (32, 64), "right": (32, 96), "below": (62, 10), "back": (32, 0)}.items():
        assert content.element_names[seen[row, column]] == name
