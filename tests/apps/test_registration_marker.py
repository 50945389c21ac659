"""Printed markers without a kernel: sheets as readers see them, and poses in pictures made by a pinhole's formula."""

from __future__ import annotations

import dataclasses
import math
import re
import struct
import zlib
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
import virtualrobot
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, MissingFileError, TooLargeError
from virtualrobot_apps.registration.levelled import TILT, levelled
from virtualrobot_apps.registration.marker_pose import (
    CORNER,
    EDGE,
    SeenMarker,
    bits_of,
    camera_matrix,
    markers_in,
    posed,
    read_picture,
)
from virtualrobot_apps.registration.marker_sheet import DOTS, Sheet, as_pdf, as_png, as_svg, sheet
from virtualrobot_apps.registration.picture_size import size_of

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]

WIDTH, HEIGHT, FIELD = 1280, 720, 1.2
CAMERA = camera_matrix(WIDTH, HEIGHT, FIELD)
WALL, PAPER, INK = 150.0, 225.0, 30.0
"""Grey values of what is around a sheet, of the paper and of what is printed."""
RAYS = 3
"""Rays of a pixel in each direction."""
NOISE = 4.0
"""Standard deviation of a pixel's grey value."""


def made_picture(camera_t_marker: Floats, rng: np.random.Generator, number: int = 7) -> Picture:
    """Return the picture (720, 1280) of a sheet at a pose, by the formula of a pinhole: u = fx x / z + cx.

    A pixel is the mean of 9 rays; each meets the sheet's plane, and what is printed there is its grey.
    """
    squares, half = bits_of(number), 4.0 * EDGE / 6.0
    grey = np.full((HEIGHT, WIDTH), WALL)
    rim = np.array([[-half, -half, 0, 1], [half, -half, 0, 1], [half, half, 0, 1], [-half, half, 0, 1]])
    at = (camera_t_marker @ rim.T)[:3]
    u, v = (CAMERA @ at / at[2])[:2]
    left, right = max(int(u.min()) - 2, 0), min(int(u.max()) + 3, WIDTH)
    top, bottom = max(int(v.min()) - 2, 0), min(int(v.max()) + 3, HEIGHT)
    inside = (np.arange(RAYS) + 0.5) / RAYS - 0.5
    columns = (np.arange(left, right)[:, None] + inside).ravel()
    rows = (np.arange(top, bottom)[:, None] + inside).ravel()
    x, y = np.meshgrid((columns - CAMERA[0, 2]) / CAMERA[0, 0], (rows - CAMERA[1, 2]) / CAMERA[1, 1])
    rays = np.stack([x, y, np.ones_like(x)], axis=-1)
    turn, place = camera_t_marker[:3, :3], camera_t_marker[:3, 3]
    along = (turn[:, 2] @ place) / (rays @ turn[:, 2])
    on = (rays * along[..., None] - place) @ turn[:, :2]
    printed = np.full(x.shape, PAPER)
    cells = np.floor((on * [1.0, -1.0] + EDGE / 2.0) / (EDGE / 6.0)).astype(int)
    marked = ((cells >= 0) & (cells < 6)).all(axis=-1)
    column, row = np.clip(cells, 0, 5)[..., 0], np.clip(cells, 0, 5)[..., 1]
    printed[marked & ~squares[row, column]] = INK
    printed[(np.abs(on) > half).any(axis=-1)] = WALL
    grey[top:bottom, left:right] = printed.reshape(bottom - top, RAYS, right - left, RAYS).mean(axis=(1, 3))
    return np.clip(np.rint(grey + rng.normal(0.0, NOISE, grey.shape)), 0, 255).astype(np.uint8)


def drawn_pose(rng: np.random.Generator, distance: float) -> Floats:
    """Return the pose of a sheet at a distance that faces the camera but for up to 45 degrees, all in the picture."""
    tilt, way, turn = math.radians(rng.uniform(0.0, 45.0)), rng.uniform(0.0, math.tau), rng.uniform(0.0, math.tau)
    facing = virtualrobot.pose(roll=math.pi)
    tilted = cv2.Rodrigues(tilt * np.array([math.cos(way), math.sin(way), 0.0]))[0]
    pose = facing @ virtualrobot.pose(yaw=turn)
    pose[:3, :3] = tilted @ pose[:3, :3]
    middle = np.array([WIDTH / 2.0 + rng.uniform(-350.0, 350.0), HEIGHT / 2.0 + rng.uniform(-110.0, 110.0), 1.0])
    ray = np.linalg.solve(CAMERA, middle)
    pose[:3, 3] = distance * ray / np.linalg.norm(ray)
    return pose


def only(seen: list[SeenMarker]) -> SeenMarker:
    (one,) = seen
    return one


@pytest.mark.long
def test_markers_are_found_within_7_mm_from_half_a_meter_to_1_6_m() -> None:
    rng = np.random.default_rng(11)
    off = []
    for distance in np.linspace(1.6, 0.5, 15):
        pose = drawn_pose(rng, float(distance))
        seen = only(markers_in(made_picture(pose, rng), CAMERA))
        assert seen.number == 7
        off.append(np.linalg.norm(seen.camera_t_marker[:3, 3] - pose[:3, 3]))
    assert np.quantile(off, 0.95) <= 0.007


def test_exact_corners_give_the_exact_pose() -> None:
    """Corners by the formula, without a picture: what is left is rounding."""
    rng = np.random.default_rng(2)
    for distance in (0.5, 1.0, 1.6):
        pose = drawn_pose(rng, distance)
        assert np.abs(posed(corners_of(pose), 3, CAMERA).camera_t_marker - pose).max() < 1e-9


@pytest.mark.parametrize("distance", [0.5, 2.5])
def test_a_square_straight_before_the_camera_is_no_riddle(distance: float) -> None:
    """There both poses of a flat square are one, and a fit may step far beyond."""
    pose = virtualrobot.pose(z=distance, roll=np.pi)
    seen = posed(corners_of(pose), 3, CAMERA)
    assert np.abs(seen.camera_t_marker - pose).max() < 1e-5
    assert seen.second is None


@pytest.mark.long
def test_predicted_errors_are_those_of_drawn_corners() -> None:
    """Each coordinate of a corner is off by as much as is expected of pictures; a point 0.8 m beside the sheet."""
    rng, point = np.random.default_rng(8), np.array([0.7, 0.3, 0.2])
    pose = virtualrobot.pose(0.1, -0.05, 0.7, roll=np.pi + 0.6, pitch=0.4)
    corners = corners_of(pose)
    exact = posed(corners, 3, CAMERA)
    off = []
    for _ in range(120):
        seen = posed(corners + rng.normal(0.0, CORNER, (4, 2)), 3, CAMERA)
        off.append(np.linalg.norm(((seen.camera_t_marker - pose) @ np.append(point, 1.0))[:3]))
    for share in (0.5, 0.95):
        assert exact.error(point, share) == pytest.approx(np.quantile(off, share), rel=0.25)


def test_a_camera_that_knows_what_is_up_gives_the_exact_pose_of_exact_corners() -> None:
    rng, up = np.random.default_rng(3), np.array([0.2, 0.5, 0.8])
    for distance in (0.5, 1.0, 1.6):
        pose = drawn_pose(rng, distance)
        seen = levelled(posed(corners_of(pose), 3, CAMERA), up, pose[:3, :3] @ up)
        assert np.abs(seen.camera_t_marker - pose).max() < 1e-9
        assert seen.second is None


@pytest.mark.long
def test_gravity_halves_the_error_beside_a_sheet_that_is_seen_from_before() -> None:
    """Corners and what is up are drawn about the true ones; a flat sheet 1.2 m below, and a point 0.8 m beside it."""
    rng, up, point = np.random.default_rng(9), np.array([0.0, 0.0, 1.0]), np.array([0.7, 0.3, 0.2])
    pose = virtualrobot.pose(0.05, 0.02, 1.2, roll=np.pi + 0.25, yaw=0.3)
    corners, exact = corners_of(pose), levelled(posed(corners_of(pose), 3, CAMERA), up, pose[:3, :3] @ up)
    off = []
    for _ in range(60):
        seen = posed(corners + rng.normal(0.0, CORNER, (4, 2)), 3, CAMERA)
        leaning = virtualrobot.pose(0.0, 0.0, 0.0, *rng.normal(0.0, TILT, 3))[:3, :3]
        found = levelled(seen, up, leaning @ pose[:3, :3] @ up)
        off.append(np.linalg.norm(((found.camera_t_marker - pose) @ np.append(point, 1.0))[:3]))
    for share in (0.5, 0.95):
        assert exact.error(point, share) == pytest.approx(np.quantile(off, share), rel=0.25)
    assert exact.error(point) < 0.5 * posed(corners, 3, CAMERA).error(point)


def test_gravity_chooses_between_the_two_poses_of_a_flat_square() -> None:
    """Of a small square far away both poses are near what is seen; the one that is upright comes out."""
    up = np.array([0.0, 1.0, 0.0])
    for lean in (0.15, -0.15):
        pose = virtualrobot.pose(0.0, 0.0, 2.5, roll=np.pi + lean)
        seen = posed(corners_of(pose), 0, CAMERA)
        assert seen.second is not None
        swapped = dataclasses.replace(seen, camera_t_marker=seen.second, second=seen.camera_t_marker)
        for one in (seen, swapped):
            assert np.abs(levelled(one, up, pose[:3, :3] @ up).camera_t_marker - pose).max() < 1e-8


def corners_of(camera_t_marker: Floats) -> Floats:
    """Return the corners (4, 2) of a marker at a pose by a pinhole's formula, pixels."""
    half = EDGE / 2.0
    square = np.array([[-half, half, 0, 1], [half, half, 0, 1], [half, -half, 0, 1], [-half, -half, 0, 1]])
    at = (camera_t_marker @ square.T)[:3]
    return (CAMERA @ at / at[2])[:2].T


def raster(page: Sheet) -> Picture:
    """Return a sheet's rectangles as a picture of 4 pixels a millimetre."""
    pixels = np.full((round(4 * page.height), round(4 * page.width)), 255, np.uint8)
    for x, y, w, h in page.rectangles:
        pixels[round(4 * y) : round(4 * (y + h)), round(4 * x) : round(4 * (x + w))] = 0
    return pixels


def edge_seen(picture: Picture, number: int) -> float:
    """Return the mean edge (pixels) of the one marker in a picture, which is this one and stands upright."""
    seen = only(markers_in(picture, camera_matrix(picture.shape[1], picture.shape[0], 1.0)))
    assert seen.number == number
    right = seen.corners[1] - seen.corners[0]
    assert right[0] > 0 and abs(right[1]) < 1.0
    return float(np.linalg.norm(seen.corners - np.roll(seen.corners, 1, axis=0), axis=1).mean())


def test_every_format_has_the_marker_in_its_true_size() -> None:
    page = sheet(bits_of(12), EDGE, 12, "letter")
    svg = ElementTree.fromstring(as_svg(page))
    assert svg.attrib["width"] == f"{page.width:g}mm"
    boxes = [
        tuple(float(one.attrib[name]) for name in ("x", "y", "width", "height"))
        for one in svg.iter("{http://www.w3.org/2000/svg}rect")
        if "x" in one.attrib
    ]
    drawn = Sheet(page.width, page.height, tuple(boxes), ())  # pyright: ignore[reportArgumentType] four of each
    assert edge_seen(raster(drawn), 12) == pytest.approx(600.0, abs=2.0)
    assert edge_seen(raster(pdf_page(as_pdf(page))), 12) == pytest.approx(600.0, abs=2.0)
    png = as_png(page)
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    assert edge_seen(np.asarray(picture, np.uint8), 12) == pytest.approx(150.0 / 25.4 * DOTS, abs=3.0)
    per_meter = struct.unpack(">II", png[png.index(b"pHYs") + 4 :][:8])
    assert per_meter == (11811, 11811)


def pdf_page(data: bytes) -> Sheet:
    """Return what a PDF draws, by its table of objects."""
    assert data.startswith(b"%PDF-1.6\n") and data.endswith(b"%%EOF\n")
    start = int(data.rsplit(b"startxref\n", 1)[1].split(b"\n")[0])
    assert data[start:].startswith(b"xref\n0 6\n")
    rows = data[start:].splitlines()[3:8]
    things = []
    for number, row in enumerate(rows, 1):
        place = int(row.split()[0])
        assert data[place:].startswith(b"%d 0 obj\n" % number)
        things.append(data[place : data.index(b"endobj", place)])
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", things[2])
    assert box is not None
    width, height = (float(one) * 25.4 / 72.0 for one in box.groups())
    length = re.search(rb"/Length (\d+)", things[3])
    assert length is not None
    stream = things[3].split(b"stream\n", 1)[1].rsplit(b"\nendstream", 1)[0]
    assert len(stream) == int(length[1])
    boxes = [
        tuple(float(one) * 25.4 / 72.0 for one in line.split()[:4])
        for line in stream.decode().splitlines()
        if line.endswith(" re")
    ]
    return Sheet(width, height, tuple((x, height - y - h, w, h) for x, y, w, h in boxes), ())


def test_a_sheet_too_small_for_its_marker_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match="160 mm doesn't go on a4: it is above 0 and at most 157 mm"):
        sheet(bits_of(0), 0.16, 0)
    with pytest.raises(InvalidArgumentError, match="no paper 'a5'; there are a4, a3, letter"):
        sheet(bits_of(0), EDGE, 0, "a5")
    with pytest.raises(InvalidArgumentError, match="no marker 50; they go from 0 to 49"):
        bits_of(50)


def test_what_is_no_picture_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "picture.png"
    with pytest.raises(MissingFileError, match="cannot be read"):
        read_picture(file)
    page = as_png(sheet(bits_of(4), EDGE, 4))
    for data in (b"", b"no picture", zlib.compress(b"none"), page[:60], b"\xff\xd8\xff\xe0\x00\x10JFIF"):
        file.write_bytes(data)
        with pytest.raises(MalformedFileError, match="no PNG and no JPEG, or a damaged one"):
            read_picture(file)
    file.write_bytes(page)
    assert only(markers_in(read_picture(file), CAMERA)).number == 4
    # A file of a few bytes that says it is 40,000 pixels wide and high is not unpacked.
    file.write_bytes(page[:16] + struct.pack(">II", 40_000, 40_000) + page[24:])
    with pytest.raises(TooLargeError, match="40000 x 40000 pixels; a picture has at most 50,000,000"):
        read_picture(file)


def test_sizes_are_read_from_the_first_bytes_of_files() -> None:
    grey = np.zeros((37, 53), np.uint8)
    for ending in (".png", ".jpg"):
        done, data = cv2.imencode(ending, grey)
        assert done
        assert size_of(data.tobytes()) == (53, 37)
    assert size_of(b"BM" + bytes(60)) is None


def test_bad_cameras_are_refused() -> None:
    grey = np.zeros((20, 30), np.uint8)
    assert markers_in(grey, CAMERA) == []
    with pytest.raises(InvalidArgumentError, match="a picture is grey"):
        markers_in(np.zeros((20, 30, 3), np.uint8), CAMERA)
    with pytest.raises(InvalidArgumentError, match="a camera's matrix is 3x3"):
        markers_in(grey, np.zeros((3, 3)))
    with pytest.raises(InvalidArgumentError, match="the edge of a marker is 0 m"):
        markers_in(grey, CAMERA, edge=0.0)
    with pytest.raises(InvalidArgumentError, match="between 0 and pi"):
        camera_matrix(640, 480, 70.0)
