"""Occupancy grid of a floor, from scans by Bayes' rule, and in files as ROS has them.

A. Elfes, Using Occupancy Grids for Mobile Robot Perception and Navigation, Computer 22, 1989: with cells and readings
independent, each reading adds log(p / (1 - p)) to a cell's log-odds.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray
from virtualrobot.errors import MalformedFileError, MissingFileError

from virtualrobot_apps.seeing.navigation.poses import Floats, moved
from virtualrobot_apps.seeing.navigation.regions import blurred, widened
from virtualrobot_apps.seeing.navigation.scans import Scan

HIT, MISS, MOST = 0.85, -0.4, 4.0
"""Log-odds of a cell with an echo (p = 0.7) and of one that a ray passes (0.4), as OctoMap has them; and the most."""
LIKELY = 0.3
"""Log-odds from which on to either side a cell counts as occupied or as free: one echo, or one ray that passes."""
OCCUPIED, FREE = 0.65, 0.196
"""Shades from which on, and up to which, a pixel of a file is occupied and free: those of ROS's map_server."""
MOST_CELLS = 25_000_000
"""Most cells of a map."""
BEHIND = 0.3
"""Distance (m) by which a ray that has passed a wall of the map must have gone on."""
_RAYS = 60


class Grid:
    """Log-odds (rows, columns) of cells being occupied, 0 where nothing is known; rows go along y, columns along x."""

    def __init__(self, resolution: float = 0.05, origin: Floats | None = None, log_odds: Floats | None = None) -> None:
        """Take the edge of a cell (m), the corner (2,) of the first one (m), and the cells; begin with none."""
        self.resolution = resolution
        self.origin = np.zeros(2) if origin is None else np.asarray(origin, np.float64)
        self.log_odds = np.zeros((0, 0)) if log_odds is None else np.asarray(log_odds, np.float64)

    def insert(self, scan: Scan, pose: Floats) -> None:
        """Take in a scan made at a pose (3,) of its base; the grid grows where it has to."""
        origin = moved(pose, scan.origin[None])[0]
        echoes, empty = moved(pose, scan.points), moved(pose, np.vstack([scan.empty, scan.quiet]))
        ends = np.vstack([echoes, empty])
        if not len(ends):
            return
        self._grow(np.vstack([ends, origin[None]]))
        # Half a cell before the echo a ray has passed: what lies there is that cell itself.
        _, passed = self._passed(origin, ends, self.resolution)
        change = np.zeros_like(self.log_odds)
        change[self.cells(passed)] = MISS
        change[self.cells(echoes)] = HIT  # an echo outdoes what passes the same cell
        np.clip(self.log_odds + change, -MOST, MOST, out=self.log_odds)

    def stops(self, origin: Floats, ends: Floats, short: float) -> NDArray[np.bool_]:
        """Return which rays from a place (2,) to ends (n, 2) meet an occupied cell so far before these (m)."""
        rays, passed = self._passed(origin, ends, short)
        inside = self.has(passed)
        met = self.occupied[self.cells(passed[inside])]
        found = np.zeros(len(ends), bool)
        found[rays[inside][met]] = True
        return found

    def about(self, place: Floats, reach: float) -> float:
        """Return in which part of all directions from a place (2,) a ray so long (m) has to end at an occupied cell."""
        turns = np.arange(_RAYS) * 2.0 * np.pi / _RAYS
        return float(self.stops(place, place + reach * np.column_stack([np.cos(turns), np.sin(turns)]), BEHIND).mean())

    def cells(self, points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns (n,) of points (n, 2), which may lie outside."""
        keys = np.floor((np.asarray(points, np.float64) - self.origin) / self.resolution).astype(np.int64)
        return keys[..., 1], keys[..., 0]

    def middles(self, rows: NDArray, columns: NDArray) -> Floats:
        """Return the middles (n, 2) of cells (m)."""
        return self.origin + (np.stack([columns, rows], axis=-1) + 0.5) * self.resolution

    def has(self, points: Floats) -> NDArray[np.bool_]:
        """Return which of points (n, 2) lie in the grid."""
        rows, columns = self.cells(points)
        return (
            (rows >= 0)
            & (columns >= 0)
            & (rows < len(self.log_odds))
            & (columns < self.log_odds.size // max(1, len(self.log_odds)))
        )

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Return which cells count as occupied, (rows, columns)."""
        return self.log_odds > LIKELY

    @property
    def free(self) -> NDArray[np.bool_]:
        """Return which cells count as free, (rows, columns)."""
        return self.log_odds < -LIKELY

    def obstacles(self) -> Floats:
        """Return the middles (n, 2) of occupied cells (m)."""
        return self.middles(*np.nonzero(self.occupied))

    def faces(self) -> tuple[Floats, Floats]:
        """Return the middles (n, 2) of occupied cells beside free ones (m), and normals (n, 2) towards what is free."""
        free = blurred(self.free, 1.5)
        rows, columns = np.nonzero(self.occupied & widened(self.free))
        up, right = np.gradient(free, axis=0), np.gradient(free, axis=1)
        normals = np.column_stack([right[rows, columns], up[rows, columns]])
        lengths = np.hypot(*normals.T)
        sure = lengths > 1e-6
        return self.middles(rows, columns)[sure], normals[sure] / lengths[sure, None]

    def save(self, path: Path) -> None:
        """Write the map as ROS's map_server does: `path` is its .yaml, beside which the picture is put as .pgm.

        Occupied cells are black, free ones white, unknown ones grey (205).
        """
        pixels = np.full(self.log_odds.shape, 205, np.uint8)
        pixels[self.occupied], pixels[self.free] = 0, 254
        picture = path.with_suffix(".pgm")
        height, width = pixels.shape
        picture.write_bytes(b"P5\n%d %d\n255\n" % (width, height) + pixels[::-1].tobytes())
        told = {
            "image": picture.name,
            "mode": "trinary",
            "resolution": float(self.resolution),
            "origin": [float(self.origin[0]), float(self.origin[1]), 0.0],
            "negate": 0,
            "occupied_thresh": OCCUPIED,
            "free_thresh": FREE,
        }
        path.write_text(yaml.safe_dump(told, sort_keys=False), "utf-8")

    def _passed(self, origin: Floats, ends: Floats, short: float) -> tuple[NDArray[np.int64], Floats]:
        """Return places (m, 2) that rays from one (2,) to ends (n, 2) pass, up to so far before them (m), and whose."""
        away = ends - origin
        lengths = np.linalg.norm(away, axis=1)
        steps = np.arange(0.0, lengths.max(initial=0.0) + self.resolution, 0.7 * self.resolution)
        rays, marks = np.nonzero(steps[None, :] < (lengths - short)[:, None])
        return rays, origin + away[rays] * (steps[marks] / np.maximum(lengths[rays], 1e-9))[:, None]

    def _grow(self, points: Floats) -> None:
        """Let the grid hold points (n, 2), by whole meters."""
        shape = np.array(self.log_odds.shape[::-1])
        low = np.floor((points.min(axis=0) - self.origin) / self.resolution).astype(int)
        high = np.floor((points.max(axis=0) - self.origin) / self.resolution).astype(int) + 1
        if not self.log_odds.size:
            self.origin = np.floor(points.min(axis=0)) - 1.0
            shape = np.ceil((np.ceil(points.max(axis=0)) + 1.0 - self.origin) / self.resolution).astype(int)
            self.log_odds = np.zeros(shape[::-1])
            return
        metre = max(1, round(1.0 / self.resolution))
        before = np.where(low < 0, -low + metre, 0)
        after = np.where(high > shape, high - shape + metre, 0)
        if not (before.any() or after.any()):
            return
        if np.prod(shape + before + after) > MOST_CELLS:
            raise ValueError(f"a map of more than {MOST_CELLS:,} cells: give a coarser resolution")
        self.log_odds = np.pad(self.log_odds, ((before[1], after[1]), (before[0], after[0])))
        self.origin = self.origin - before * self.resolution


def load(path: Path) -> Grid:
    """Return the map of a file .yaml with its picture, as ROS's map_server has them.

    Raises:
        MissingFileError: where file or picture is not there.
        MalformedFileError: where they are none, with what is wrong.
    """
    if not path.is_file():
        raise MissingFileError(f"there is no map {path}: `virtualrobot navigate explore` makes one")
    try:
        told = yaml.safe_load(path.read_text("utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise MalformedFileError(f"{path} is no YAML: {' '.join(str(error).split())}") from error
    if not isinstance(told, dict):
        raise MalformedFileError(f"{path} is no map: it has no keys image, resolution and origin")
    if missing := [key for key in ("image", "resolution", "origin") if key not in told]:
        raise MalformedFileError(f"{path} is no map: it lacks {', '.join(missing)}")
    resolution, origin = told["resolution"], told["origin"]
    if not (_is_number(resolution) and 0.0 < resolution <= 10.0):
        raise MalformedFileError(f"{path}: 'resolution' is the edge of a cell in meters, not {resolution!r}")
    if not (isinstance(origin, list) and len(origin) in (2, 3) and all(map(_is_number, origin))):
        raise MalformedFileError(f"{path}: 'origin' is x, y and yaw of the lower left corner, not {origin!r}")
    if len(origin) == 3 and origin[2] != 0.0:
        raise MalformedFileError(f"{path}: a map turned by {origin[2]} rad is not known here: turn its picture")
    pixels = _pgm(path.parent / str(told["image"]))
    shade = pixels / 255.0 if told.get("negate") else 1.0 - pixels / 255.0
    occupied, free = float(told.get("occupied_thresh", OCCUPIED)), float(told.get("free_thresh", FREE))
    log_odds = np.where(shade > occupied, MOST, np.where(shade < free, -MOST, 0.0))[::-1]
    return Grid(float(resolution), np.array(origin[:2], np.float64), np.ascontiguousarray(log_odds))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _pgm(path: Path) -> NDArray[np.uint8]:
    """Return the pixels of a picture in PGM (P5, 8 bits)."""
    if not path.is_file():
        raise MissingFileError(f"there is no picture {path} of the map")
    data = path.read_bytes()
    fields, at = [], 0
    while len(fields) < 4:
        end = at
        while end < len(data) and not data[end : end + 1].isspace():
            end += 1
        word = data[at:end]
        if word.startswith(b"#"):
            end = data.find(b"\n", at)
            end = len(data) if end < 0 else end
        elif word:
            fields.append(word)
        elif end >= len(data):
            break
        at = end + 1
    if len(fields) < 4 or fields[0] != b"P5" or not all(field.isdigit() for field in fields[1:]) or fields[3] != b"255":
        raise MalformedFileError(f"{path} is no picture in PGM of 8 bits (P5)")
    width, height = int(fields[1]), int(fields[2])
    if width * height > MOST_CELLS or len(data) - at != width * height or not width * height:
        raise MalformedFileError(f"{path} has {len(data) - at} pixels, not {width} x {height}")
    return np.frombuffer(data, np.uint8, offset=at).reshape(height, width)
