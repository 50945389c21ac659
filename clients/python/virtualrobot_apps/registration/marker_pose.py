"""Markers in pictures: which are seen, and where they are for the camera, by OpenCV.

A marker is one of 50 of ArUco's dictionary 4X4_50 (Garrido-Jurado and others, Automatic generation and detection of
highly reliable fiducial markers under occlusion, 2014). Its frame: the middle, x to the right of the sheet, y up, z out
of it. The camera's: x to the right of the picture, y down, z ahead; the middle of the upper left pixel is (0, 0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot._wire.arguments import ArrayLike
from virtualrobot.errors import (
    InvalidArgumentError,
    MalformedFileError,
    MissingFileError,
    TooLargeError,
    WrongStateError,
)
from virtualrobot.geometry import Matrix, turn_between

from virtualrobot_apps.registration.lengths import length_of
from virtualrobot_apps.registration.marker_sheet import Bits
from virtualrobot_apps.registration.picture_size import size_of
from virtualrobot_apps.registration.square_fit import SeenSquare, moved

Floats = NDArray[np.float64]

MARKERS = 50
EDGE = 0.15
"""Edge (m) of a marker where nobody says another."""

MOST_PIXELS = 50_000_000
"""Pixels of a picture at most."""

CORNER = 0.15
"""Standard deviation (pixels) of each coordinate of a corner, as pictures of good light have it, and no less."""

MARGIN = 0.25
"""Width of what belongs to a marker around it, as a share of its longest edge: the white that a corner needs."""

CLEAR = 2.0
"""Factor of the deviation of corners, found or expected, from which a flat square's second pose is no answer."""

SAME = 0.02
"""Angle (rad) up to which two poses of a square are one."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenMarker:
    """Marker in a picture.

    Attributes:
        number: which it is.
        corners: (4, 2) in pixels: upper left, upper right, lower right, lower left of the sheet.
        camera_t_marker: (4, 4), m.
        deviation: of the corners from those of this pose, root of the mean square, pixels.
        second: (4, 4) the other pose that a flat square may have, or None where it is clearly worse.
        twist_covariance: (6, 6) of a small turn (rad) about the camera and shift (m) by which the pose may be off.
        straight: the corners as a camera without distortion has them.
    """

    number: int
    corners: Floats
    camera_t_marker: Matrix
    deviation: float
    second: Matrix | None
    twist_covariance: Floats
    straight: SeenSquare

    def error(self, point: ArrayLike, share: float = 0.95) -> float:
        """Return the distance (m) that a point (3,) of the marker's frame is off at most, in this share of cases."""
        at = self.camera_t_marker[:3, :3] @ np.asarray(point, dtype=float) + self.camera_t_marker[:3, 3]
        motion = moved(at)
        return length_of(motion @ self.twist_covariance @ motion.T, share)


def library() -> ModuleType:
    """Return OpenCV; raise WrongStateError, which says how to install it, where it is missing."""
    try:
        import cv2
    except ImportError:
        raise WrongStateError("markers are made and found by OpenCV: pip install 'virtualrobot[vision]'") from None
    return cv2


def bits_of(number: int) -> Bits:
    """Return the squares (6, 6) of a marker with its black border, True for white; raise for one that there isn't."""
    cv2: Any = library()
    if not 0 <= number < MARKERS:
        raise InvalidArgumentError(f"there is no marker {number}; they go from 0 to {MARKERS - 1}")
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return np.asarray(cv2.aruco.generateImageMarker(dictionary, number, dictionary.markerSize + 2)) > 0


def read_picture(file: Path) -> NDArray[np.uint8]:
    """Return the grey values (height, width) of a picture in a file."""
    try:
        return picture_of(file.read_bytes(), str(file))
    except OSError as error:
        raise MissingFileError(f"{file} cannot be read: {error.strerror or error}") from error


def picture_of(data: bytes, name: str) -> NDArray[np.uint8]:
    """Return the grey values (height, width) of a picture in bytes; `name` is what errors call it."""
    cv2: Any = library()
    size = size_of(data)
    if size is not None and size[0] * size[1] > MOST_PIXELS:
        raise TooLargeError(f"{name} has {size[0]} x {size[1]} pixels; a picture has at most {MOST_PIXELS:,}")
    grey = None if size is None else cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)
    if grey is None:
        raise MalformedFileError(f"{name} is no PNG and no JPEG, or a damaged one")
    return grey


def camera_matrix(width: int, height: int, horizontal_field: float) -> Floats:
    """Return the matrix (3, 3) of a pinhole camera with square pixels that looks through the middle of its picture.

    Raises:
        InvalidArgumentError: for a field of view (rad) that isn't between 0 and pi.
    """
    if not 0.0 < horizontal_field < math.pi:
        raise InvalidArgumentError(f"the field of view is {horizontal_field:g} rad; it lies between 0 and pi")
    focal = width / (2.0 * math.tan(horizontal_field / 2.0))
    return np.array([[focal, 0.0, (width - 1) / 2.0], [0.0, focal, (height - 1) / 2.0], [0.0, 0.0, 1.0]])


def markers_in(
    picture: NDArray[np.uint8], matrix: ArrayLike, *, edge: float = EDGE, distortion: ArrayLike = ()
) -> list[SeenMarker]:
    """Return the markers in a picture, by their numbers.

    Poses are those of Collins and Bartoli (Infinitesimal Plane-Based Pose Estimation, 2014), then least squares of the
    corners.

    Args:
        picture: (height, width) grey values.
        matrix: (3, 3) the camera's, as OpenCV has it.
        edge: of the black squares, m.
        distortion: OpenCV's coefficients of a pinhole camera; none by default.

    Raises:
        InvalidArgumentError: for what is no picture, no camera's matrix or no edge.
        WrongStateError: without OpenCV.
    """
    cv2: Any = library()
    if picture.ndim != 2 or picture.dtype != np.uint8:
        raise InvalidArgumentError(f"a picture is grey: uint8 (height, width), not {picture.dtype} {picture.shape}")
    camera, bent = np.asarray(matrix, dtype=float), np.asarray(distortion, dtype=float)
    if camera.shape != (3, 3) or not np.isfinite(camera).all() or min(camera[0, 0], camera[1, 1]) <= 0.0:
        raise InvalidArgumentError(f"a camera's matrix is 3x3 with focal lengths above 0, not\n{camera}")
    if not (math.isfinite(edge) and edge > 0.0):
        raise InvalidArgumentError(f"the edge of a marker is {edge:g} m; it is above 0")
    seen = [
        posed(_sharpened(picture, number, corners), number, camera, edge=edge, distortion=bent)
        for number, corners in _found(picture, cv2.aruco.CORNER_REFINE_SUBPIX)
    ]
    return sorted(seen, key=lambda one: one.number)


def _found(picture: NDArray[np.uint8], refinement: int) -> list[tuple[int, Floats]]:
    """Return the numbers and corners (4, 2) of the markers in a picture."""
    cv2: Any = library()
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = refinement
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), settings)
    corners, numbers, _ = detector.detectMarkers(picture)
    if numbers is None:
        return []
    return [(int(one), rows.reshape(4, 2).astype(float)) for one, rows in zip(numbers.ravel(), corners, strict=True)]


def _sharpened(picture: NDArray[np.uint8], number: int, corners: Floats) -> Floats:
    """Return corners where lines along the edges meet, as AprilTag has them; as they are where it finds none.

    A corner by itself is drawn inwards by a fifth of a pixel, which at 1.6 m is 6 mm of distance. AprilTag looks at
    the marker's part of the picture alone, since all of it takes a third of a second; the middle of its upper left
    pixel is (0.5, 0.5).
    """
    cv2: Any = library()
    margin = MARGIN * float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max())
    left, top = np.maximum(corners.min(axis=0) - margin, 0.0).astype(int)
    right, bottom = (corners.max(axis=0) + margin).astype(int) + 1
    part = np.ascontiguousarray(picture[top:bottom, left:right])
    again = [rows for one, rows in _found(part, cv2.aruco.CORNER_REFINE_APRILTAG) if one == number]
    return again[0] + [left - 0.5, top - 0.5] if len(again) == 1 else corners


def posed(
    corners: ArrayLike, number: int, matrix: ArrayLike, *, edge: float = EDGE, distortion: ArrayLike = ()
) -> SeenMarker:
    """Return the marker whose corners (4, 2) are these, such as the mean of those in several pictures."""
    cv2: Any = library()
    corners, camera, distortion = (np.asarray(one, dtype=float) for one in (corners, matrix, distortion))
    half = edge / 2.0
    square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
    points = np.ascontiguousarray(corners).reshape(4, 1, 2)
    bent = distortion if distortion.size else None
    straight = corners if bent is None else cv2.undistortPoints(points, camera, bent, P=camera).reshape(4, 2)
    seen = SeenSquare(square, straight, camera)
    _, turns, shifts, _ = cv2.solvePnPGeneric(
        square, np.ascontiguousarray(straight).reshape(4, 1, 2), camera, None, flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    # Of a square straight before the camera OpenCV's poses may be far off.
    starts = [_facing(straight, camera, edge)]
    for turn, shift in zip(turns, shifts, strict=True):
        start = np.eye(4)
        start[:3, :3], start[:3, 3] = cv2.Rodrigues(turn)[0], np.ravel(shift)
        starts.append(start)
    found = list[tuple[float, Matrix, Floats]]()
    for start in starts:
        pose, covariance = seen.fit(start, CORNER)
        found.append((seen.deviation(pose), pose, covariance))
    found.sort(key=lambda one: one[0])
    (deviation, best, covariance), *others = found
    least = max(CORNER, deviation)
    rivals = [pose for off, pose, _ in others if off < CLEAR * least and turn_between(best, pose) > SAME]
    second = rivals[0] if rivals else None
    return SeenMarker(number, corners, best, deviation, second, (least / CORNER) ** 2 * covariance, seen)


def _facing(corners: Floats, camera: Floats, edge: float) -> Matrix:
    """Return the pose of a square that faces the camera and is about where the corners (4, 2) are."""
    rays = np.linalg.solve(camera, np.concatenate([corners, np.ones((4, 1))], axis=1).T).T
    length = float(np.linalg.norm(rays - np.roll(rays, 1, axis=0), axis=1).mean())
    right = rays[1] + rays[2] - rays[0] - rays[3]
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross([0.0, 0.0, -1.0], right), [0.0, 0.0, -1.0]], axis=1)
    pose[:3, 3] = rays.mean(axis=0) * edge / length
    return pose
