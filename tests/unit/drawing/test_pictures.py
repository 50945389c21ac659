"""What is drawn over pictures and how they are framed: places against lenses, strokes against geometry."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from virtualrobot_kernel.drawing.additions import with_arrows
from virtualrobot_kernel.drawing.framing import Framing
from virtualrobot_kernel.drawing.overlay import Overlay, Words, draw_over, write_words
from virtualrobot_kernel.drawing.renderer import LARGEST_KEPT, Renderer, Sight
from virtualrobot_kernel.drawing.renderer_pool import RendererPool
from virtualrobot_kernel.drawing.shots import ImageFormat, Shot, packed
from virtualrobot_kernel.drawing.smoothing import smoothed
from virtualrobot_kernel.drawing.view import ViewSettings
from virtualrobot_kernel.drawing.viewpoint import Viewpoint, look_at
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.numeric.strokes import BIAS, draw_discs, draw_floor, draw_lines
from virtualrobot_kernel.sensing.appearance import AppearanceLibrary
from virtualrobot_kernel.sensing.lenses import Lens, lens_of, pinhole
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.sensing import CameraSensor, Intrinsics, Projection

from tests.drawing.cell import Cell

WHITE = np.array([[255.0, 255.0, 255.0, 1.0]], np.float32)
FRONT = look_at((0.0, -4.0, 0.0), (0.0, 0.0, 0.0))
LENSES = {
    "pinhole": CameraSensor(60, 40),
    "distorted": CameraSensor(60, 40, distortion=(-0.2, 0.05, 0.002, -0.001, 0.01)),
    "rational": CameraSensor(60, 40, distortion=(0.3, 0.02, 0.0, 0.001, 0.0, 0.25, 0.03, 0.001)),
    "intrinsics": CameraSensor(60, 40, intrinsics=Intrinsics(50.0, 55.0, 20.0, 25.0)),
    "fisheye": CameraSensor(
        60, 40, Projection.FISHEYE, horizontal_field_radians=3.0, distortion=(0.02, -0.01, 0.003, 0.0)
    ),
    "spherical": CameraSensor(60, 30, Projection.SPHERICAL),
}


def canvas(height: int = 40, width: int = 60) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return a black picture and a depth without surfaces."""
    return np.zeros((height, width, 3), np.float32), np.full((height, width), np.inf, np.float32)


@pytest.mark.parametrize("name", LENSES)
def test_a_point_on_a_pixels_ray_is_at_that_pixel(name: str, rng: np.random.Generator) -> None:
    """The way forward through a lens undoes the way back, which other code computes."""
    lens = lens_of(LENSES[name])
    viewpoint = Viewpoint(lens, look_at(tuple(rng.uniform(-1, 1, 3)), (3.0, 2.0, 1.0)))
    looking = np.isfinite(lens.directions).all(axis=1)
    seen = lens.directions[looking] * rng.uniform(0.5, 9.0, (looking.sum(), 1))
    pose = viewpoint.world_t_camera
    places = viewpoint.places(seen @ pose[:3, :3].T + pose[:3, 3])
    pixels = lens.pixels[looking]
    found = np.isfinite(places).all(axis=1)
    # At the edge of what a lens maps one to one rounding decides.
    assert found.mean() > 0.98
    assert np.abs(places[found, 0] - pixels[found] % lens.width).max() < 0.02
    assert np.abs(places[found, 1] - pixels[found] // lens.width).max() < 0.02
    depth = seen[found, 2] if lens.depth_is_z else np.linalg.norm(seen[found], axis=1)
    np.testing.assert_allclose(1.0 / places[found, 2], depth, rtol=1e-4)
    for place in rng.choice(np.flatnonzero(looking), 5):
        column, row = lens.pixels[place] % lens.width, lens.pixels[place] // lens.width
        np.testing.assert_allclose(viewpoint.ray(float(column), float(row)), lens.directions[place], atol=1e-5)


@pytest.mark.parametrize("name", LENSES)
def test_a_line_goes_through_the_places_of_its_points(name: str, rng: np.random.Generator) -> None:
    viewpoint = Viewpoint(lens_of(LENSES[name]), FRONT)
    ends = np.array([[[-0.8, 0.0, -0.4], [0.9, 1.0, 0.5]]])
    picture, depth = canvas(viewpoint.lens.height)
    overlay = Overlay()
    overlay.add_lines(ends, (255, 255, 255), 3.0)
    draw_over(picture, depth, viewpoint, overlay)
    along = ends[0, 0] + rng.uniform(0.0, 1.0, (50, 1)) * (ends[0, 1] - ends[0, 0])
    columns, rows, _ = np.rint(viewpoint.places(along)).astype(int).T
    inside = (columns >= 0) & (columns < picture.shape[1]) & (rows >= 0) & (rows < picture.shape[0])
    assert inside.any()
    assert (picture[rows[inside], columns[inside], 0] > 100).all()


def test_lines_behind_the_eye_are_cut_off() -> None:
    viewpoint = Viewpoint(lens_of(LENSES["pinhole"]), np.eye(4))
    ends, rows = viewpoint.lines(
        np.array([[[0.0, 0, -1], [0, 0, -2]], [[0.1, 0, -1], [0.1, 0, 1]], [[0.0, 0, 1], [0.1, 0, 2]]])
    )
    assert rows.tolist() == [1, 2]
    assert 1.0 / ends[0, 0, 2] == pytest.approx(viewpoint.lens.near)
    assert 1.0 / ends[0, 1, 2] == pytest.approx(1.0)


def test_a_line_covers_its_width_times_its_length(rng: np.random.Generator) -> None:
    """Partly covered pixels count in part; the ends are round, half a width longer each.

    Where rows of pixels are 1 / n apart across the line, and its edges a pixel wide, it is by Poisson's formula up to
    the sum over m of 2 |sin(pi m n)| / (pi m n)^2 too wide or narrow: an eighth of a pixel on a diagonal, n^2 = 2.
    """
    width = float(rng.uniform(2.0, 6.0))
    a, b = rng.uniform(15, 25, 2), rng.uniform(60, 85, 2)
    picture, depth = canvas(100, 100)
    ends = np.array([[[*a, 1.0], [*b, 1.0]]])
    draw_lines(picture, depth, ends, WHITE, np.array([width]), BIAS)
    length = float(np.linalg.norm(b - a))
    area = length * width + np.pi * (width / 2) ** 2
    assert picture[..., 0].sum() / 255.0 == pytest.approx(area, abs=0.13 * length)


def test_a_disc_covers_its_area_about_its_middle() -> None:
    picture, depth = canvas()
    draw_discs(picture, depth, np.array([[20.3, 14.6, 0.5]]), WHITE, np.array([6.0]), BIAS)
    weight = picture[..., 0] / 255.0
    assert weight.sum() == pytest.approx(np.pi * 36.0, rel=0.02)
    rows, columns = np.indices(weight.shape)
    assert (weight * columns).sum() / weight.sum() == pytest.approx(20.3, abs=0.02)
    assert (weight * rows).sum() / weight.sum() == pytest.approx(14.6, abs=0.02)


def test_what_goes_through_a_surface_is_seen_up_to_it() -> None:
    """From 1 m to 3 m deep, with a wall at 2 m: 1 / depth is 1 / 2 a quarter from the far end, by 1/1 - 1/3 = 2/3."""
    picture, depth = canvas()
    depth[:] = 2.0
    ends = np.array([[[5.0, 20.0, 1.0], [53.0, 20.0, 1.0 / 3.0]]])
    draw_lines(picture, depth, ends, WHITE, np.array([1.0]), BIAS)
    seen = np.flatnonzero(picture[20, :, 0] > 128)
    assert (seen.min(), seen.max()) == (5, pytest.approx(5 + 0.75 * 48, abs=1))


def test_what_is_off_the_picture_or_not_finite_draws_nothing_there() -> None:
    picture, depth = canvas()
    far = np.array([[[-1e7, -1e7, 1.0], [-1e6, 1e7, 1.0]], [[1e9, 0.0, 1.0], [1e9, 1e9, 1.0]]])
    draw_lines(picture, depth, far, np.repeat(WHITE, 2, axis=0), np.array([3.0, 3.0]), BIAS)
    draw_discs(picture, depth, np.array([[-1e9, 5.0, 1.0]]), WHITE, np.array([20.0]), BIAS)
    assert not picture.any()


def test_the_floors_lines_are_where_they_project() -> None:
    """Straight down from 2 m, lines of whole meters are f / 2 pixels apart; what covers the floor hides them."""
    lens = pinhole(101, 101, 0.9)
    assert lens.intrinsics is not None
    eye = lens.intrinsics
    picture, depth = canvas(101, 101)
    pose = look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    floor = (
        np.array([eye.fx, eye.fy, eye.cx, eye.cy]),
        pose,
        np.array([[0.0, 0, 0], [255.0, 255, 255]]),
        np.array([0.0, 1.0]),
    )
    draw_floor(picture, depth, *floor, 22.0, 1.5, BIAS)
    spacing = eye.fx / 2.0
    lit = np.flatnonzero(picture[20, :, 0] > 60)
    assert {round((column - 50) / spacing) for column in lit} == set(range(-int(50 / spacing), int(50 / spacing) + 1))
    covered, _ = canvas(101, 101)
    draw_floor(covered, np.full((101, 101), 1.9, np.float32), *floor, 22.0, 1.5, BIAS)
    assert not covered.any()


def test_words_stand_above_their_place_and_need_none() -> None:
    viewpoint = Viewpoint(pinhole(200, 150, 0.9), FRONT)
    picture = np.zeros((150, 200, 3), np.uint8)
    write_words(picture, viewpoint, [Words("here", np.zeros(3))])
    rows, columns = np.nonzero(picture.any(axis=2))
    assert columns.mean() == pytest.approx(99.5, abs=1.5)
    assert 60 < rows.max() <= 75 and rows.min() > 40
    again = picture.copy()
    write_words(again, viewpoint, [Words("behind", np.array([0.0, -9.0, 0.0])), Words("aside", np.array([99.0, 0, 0]))])
    assert (again == picture).all()
    write_words(again, viewpoint, [Words("a very long text that does not fit\nin two lines", np.array([-1.9, 0, 1.4]))])
    assert (again != picture).any()


def test_smoothing_takes_the_mean_of_an_edge_and_leaves_the_rest() -> None:
    """A vertical edge at x = 0 between black and white: of four rays through its pixel two are white."""
    lens = pinhole(31, 21, 0.9)

    def taken(fine: Lens) -> NDArray[np.uint8]:
        return np.repeat(np.where(fine.directions[None, :, :1] > 0.0, 255, 0), 3, axis=2).astype(np.uint8)

    coarse = taken(lens)[0]
    picture = np.zeros((21 * 31, 3), np.uint8)
    picture[lens.pixels] = coarse
    picture = picture.reshape(21, 31, 3)
    smooth = smoothed(picture, lens, taken)
    assert (smooth[:, 15] == 128).all()
    others = [column for column in range(31) if column != 15]
    assert (smooth[:, others] == picture[:, others]).all()
    flat = np.full((21, 31, 3), 7, np.uint8)
    assert smoothed(flat, lens, taken) is flat


def test_a_film_is_framed_anew_only_when_the_world_outgrows_the_frame() -> None:
    framing, small = Framing(), np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])
    empty = framing.camera(None, 1.5)
    first = framing.camera(small, 1.5)
    assert first != empty
    assert framing.camera(small * 1.05, 1.5) is first
    assert framing.camera(small * 0.5, 1.5) is first
    assert framing.camera(small * 1.5, 1.5) != first


def test_raw_is_the_pixels_row_by_row(rng: np.random.Generator) -> None:
    picture = rng.integers(0, 255, (5, 7, 3)).astype(np.uint8)
    assert packed(picture, ImageFormat.RAW) == picture.tobytes()


@pytest.mark.parametrize("size", [(640, 480), (2048, 1100)])
def test_a_picture_that_nobody_waits_for_is_given_up_and_a_large_lens_is_not_kept(size: tuple[int, int]) -> None:
    cell, asked = Cell(), list[bool]()
    load = cell.meshes
    renderers = RendererPool(
        ShapeLibrary(load), AppearanceLibrary(with_arrows(load)), load, lambda snapshot, wanted: {}
    )
    sight, shot = Sight(cell.snapshot, ViewSettings(), {}), Shot(width=size[0], height=size[1])

    def is_gone() -> bool:
        asked.append(True)
        return len(asked) > 4

    def paint(painter: Renderer) -> tuple[int, bool]:
        picture = painter.paint(sight, shot, Framing())
        return len(packed(picture, ImageFormat.PNG, painter.check)), painter._lens is not None

    with pytest.raises(KernelError) as given_up:
        renderers.submit(paint, is_gone).result()
    assert given_up.value.reason is Reason.SHUTTING_DOWN
    assert len(asked) == 5
    length, kept = renderers.submit(paint).result()
    assert length > 0 and kept == (size[0] * size[1] <= LARGEST_KEPT)
    renderers.close()
