"""Overlays of sensors at work, as points, lines and pictures: pure, for whatever draws them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.sensing.color_maps import turbo
from virtualrobot_kernel.sensing.lenses import FIELD, size_of
from virtualrobot_kernel.world.sensing import CameraSensor, ImageKind, Intrinsics, Projection

MOST_ANGLE = 1.45
"""A fisheye whose edge lies farther from its axis is shown without a pyramid, in radians."""
MOST_POINTS = 30_000
"""Of a scan with more points, every second, third, ... one is shown."""
MOST_RAYS = 2_000
"""Likewise of rays."""
MISS_LENGTH = 0.3
"""Length (m) that is shown of a ray without an echo."""
MISS_COLOR = (150, 155, 160)
FRUSTUM_DEPTH = 0.3
"""Distance (m) from the eye at which the base of a camera's pyramid is shown."""

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]


class PointColor(Enum):
    """Quantity that colours points; the values are the contract's numbers."""

    DISTANCE = 1
    INTENSITY = 2


@dataclass(frozen=True, slots=True)
class SensorOverlay:
    """Overlay of the sensor `uid`; a field that says nothing about its kind is passed over."""

    uid: int
    rays: bool = False
    points: bool = False
    color_by: PointColor = PointColor.DISTANCE
    frustum: bool = False
    image: bool = False


class Beams(Protocol):
    """Origins, (n, 3) or (1, 3), and directions, (n, 3), of the n beams of a scan, in the sensor's frame."""

    @property
    def origins(self) -> Floats:
        """Return (n, 3) or (1, 3), meters."""
        ...

    @property
    def directions(self) -> Floats:
        """Return (n, 3) unit vectors."""
        ...


class Scan(Protocol):
    """Readings of a range sensor, in any shape of n beams."""

    @property
    def distances(self) -> Singles:
        """Return meters."""
        ...

    @property
    def valid(self) -> Bytes:
        """Return 1 where there is an echo, else 0."""
        ...

    @property
    def intensities(self) -> Singles:
        """Return 0 to 1."""
        ...

    @property
    def beams(self) -> Beams:
        """Return where the beams go."""
        ...


class Pictures(Protocol):
    """Pictures of a camera: one for each eye, with a field for each kind, such as `color`."""

    @property
    def kinds(self) -> Sequence[ImageKind]:
        """Return the kinds that were taken."""
        ...

    @property
    def pictures(self) -> Sequence[Any]:
        """Return the pictures, the left one first."""
        ...


def scan_points(scan: Scan, color_by: PointColor, most: int = MOST_POINTS) -> tuple[Singles, Bytes]:
    """Return the echoes (m, 3) in the sensor's frame, meters, and their colours (m, 3).

    Distances are coloured from the nearest to the farthest echo, intensities from 0 to 1.
    """
    echoes = _thinned(np.flatnonzero(scan.valid.ravel()), most)
    distances = scan.distances.ravel()[echoes].astype(np.float64)
    origins, directions = _beams(scan, echoes)
    parts = scan.intensities.ravel()[echoes] if color_by is PointColor.INTENSITY else _spread(distances)
    return (origins + distances[:, None] * directions).astype(np.float32), turbo(parts)


def scan_rays(scan: Scan, color_by: PointColor, most: int = MOST_RAYS) -> tuple[Singles, Bytes]:
    """Return the beams as lines (m, 2, 3) in the sensor's frame, meters, and their colours (m, 3).

    They end at their echoes; of those without one the first MISS_LENGTH is shown, in grey.
    """
    chosen = _thinned(np.arange(scan.valid.size), most)
    valid = scan.valid.ravel()[chosen].astype(bool)
    lengths = np.where(valid, scan.distances.ravel()[chosen].astype(np.float64), MISS_LENGTH)
    origins, directions = _beams(scan, chosen)
    segments = np.stack([origins, origins + lengths[:, None] * directions], axis=1).astype(np.float32)
    parts = np.zeros(len(chosen))
    parts[valid] = (
        scan.intensities.ravel()[chosen][valid] if color_by is PointColor.INTENSITY else _spread(lengths[valid])
    )
    return segments, np.where(valid[:, None], turbo(parts), np.array(MISS_COLOR, np.uint8))


@dataclass(frozen=True, slots=True)
class Frustum:
    """The pyramid that a camera sees, about its z: tangents of its left, right, upper and lower edge (y is down)."""

    left: float
    right: float
    top: float
    bottom: float

    @property
    def vertical_field(self) -> float:
        """Return the angle between the upper and the lower edge of the same pyramid about its middle, in radians."""
        return 2.0 * math.atan(0.5 * (self.bottom - self.top))

    @property
    def aspect(self) -> float:
        """Return the width over the height."""
        return (self.right - self.left) / (self.bottom - self.top)

    def lines(self, depth: float = FRUSTUM_DEPTH) -> Singles:
        """Return the edges (9, 2, 3) in the camera's frame, its base at `depth` meters; the ninth marks the top."""
        corners = depth * np.array(
            [[x, y, 1.0] for x, y in ((self.left, self.top), (self.right, self.top))]
            + [[x, y, 1.0] for x, y in ((self.right, self.bottom), (self.left, self.bottom))]
        )
        sides = np.stack([np.zeros((4, 3)), corners], axis=1)
        base = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
        mark = 0.5 * (corners[0] + corners[1])
        tick = np.stack([mark, mark - [0.0, 0.15 * depth * (self.bottom - self.top), 0.0]])
        return np.concatenate([sides, base, tick[None]]).astype(np.float32)


def frustum_of(camera: CameraSensor) -> Frustum | None:
    """Return the pyramid that a camera sees, without its distortion; None where it sees half of all or more."""
    if camera.projection is Projection.SPHERICAL:
        return None
    width, height = size_of(camera)
    fisheye = camera.projection is Projection.FISHEYE
    lens = camera.intrinsics
    if lens is None:
        half = 0.5 * (camera.horizontal_field_radians or FIELD)
        focal = 0.5 * width / (half if fisheye else math.tan(half))
        lens = Intrinsics(focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    edges = [(-0.5 - lens.cx) / lens.fx, (width - 0.5 - lens.cx) / lens.fx]
    edges += [(-0.5 - lens.cy) / lens.fy, (height - 0.5 - lens.cy) / lens.fy]
    if fisheye:
        # Distances from the middle are angles there.
        if max(map(abs, edges)) > MOST_ANGLE:
            return None
        edges = [math.tan(edge) for edge in edges]
    return Frustum(*edges)


def seen_picture(said: Pictures, most: int = 0) -> Bytes:
    """Return the first kind of picture of the left eye as people see it, (h, w, 3), of at most `most` pixels a side."""
    kind = said.kinds[0]
    pixels = getattr(said.pictures[0], kind.name.lower())
    # Made small first: to colour a depth of full size takes 13 ms.
    return colored(kind, shrunk(pixels, most) if most else pixels)


def colored(kind: ImageKind, pixels: NDArray[Any]) -> Bytes:
    """Return a picture of any kind as people see it, (h, w, 3).

    Depth is coloured from the nearest to the farthest, elements by their number, normals by their axes; what is nothing
    is grey.
    """
    if kind is ImageKind.COLOR:
        return np.ascontiguousarray(pixels, np.uint8)
    if kind is ImageKind.NORMALS:
        return np.rint(127.5 * (1.0 + np.clip(pixels, -1.0, 1.0))).astype(np.uint8)
    flat = pixels.ravel()
    seen = np.isfinite(flat) if kind is ImageKind.DEPTH else flat >= 0
    # The golden ratio keeps the colours of neighbouring numbers apart.
    parts = _spread(flat[seen]) if kind is ImageKind.DEPTH else (0.618033988749895 * flat[seen]) % 1.0
    picture = np.full((flat.size, 3), MISS_COLOR, np.uint8)
    picture[seen] = turbo(parts)
    return picture.reshape(*pixels.shape, 3)


def shrunk(picture: NDArray[Any], most: int) -> NDArray[Any]:
    """Return a picture (h, w) or (h, w, 3) of at most `most` pixels a side, by leaving out rows and columns."""
    step = -(-max(picture.shape[:2]) // most)
    return np.ascontiguousarray(picture[::step, ::step])


def _thinned(places: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    return places[:: -(-len(places) // most)] if len(places) > most else places


def _beams(scan: Scan, chosen: Sequence[int] | NDArray[np.intp]) -> tuple[Floats, Floats]:
    origins, directions = scan.beams.origins, scan.beams.directions[chosen]
    return np.broadcast_to(origins if len(origins) == 1 else origins[chosen], directions.shape), directions


def _spread(values: NDArray[Any]) -> Floats:
    """Return numbers (n,) from 0 for the least to 1 for the greatest."""
    if not values.size:
        return np.zeros(0)
    least, most = float(values.min()), float(values.max())
    return (values - least) / (most - least) if most > least else np.zeros(len(values))
