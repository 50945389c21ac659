"""Ways of a tool: curves, one after the other where they meet, as lines and arcs within a chord tolerance."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.curve import SAME, Curve, Floats, directions, points_on

SAMPLES = 9
"""Points of a stretch, its ends among them, at which it is compared with a line and an arc."""
MOST_HALVINGS = 20
MOST_TURN = 1.05 * np.pi
"""Angle (rad) up to which a stretch is one arc."""
ALONG = 1e-3
"""Sine of the angle between tool and way below which it is open how the tool is turned about itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Way of a tool centre point in meters, as lines and arcs between points.

    Attributes:
        places: (n,) whose curve each point is on, and which of its points, such as `C1, point 3`.
        points: (n, 3); `tangents` (n, 3) the unit directions of the way there, at a corner halfway between both.
        vias: (n - 1, 3) a point in the middle of each arc; not a number for a line.
        normals: (n, 3) the surface's normals, where the file tells them.
    """

    places: tuple[str, ...]
    points: Floats
    tangents: Floats
    vias: Floats
    normals: Floats | None = None

    def corners(self) -> Floats:
        """Return the angles (n,) in rad by which lines and arcs bend where they meet; 0 at both ends."""
        arrive, leave = self._slopes()
        cosines = np.clip(np.einsum("ij,ij->i", arrive[:-1], leave[1:]), -1.0, 1.0)
        return np.concatenate([[0.0], np.arccos(cosines), [0.0]])

    def lengths(self) -> Floats:
        """Return the lengths (n - 1,) of the lines and arcs; those of arcs a little less."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        halves = np.linalg.norm(self.vias - self.points[:-1], axis=1) + np.linalg.norm(
            self.points[1:] - self.vias, axis=1
        )
        return np.where(np.isnan(halves), steps, halves)

    def radii(self) -> Floats:
        """Return the radii (n - 1,) of the arcs in m, those of the circles through three points; lines have no end."""
        first, second, chord = self.vias - self.points[:-1], self.points[1:] - self.vias, np.diff(self.points, axis=0)
        sides = np.prod([np.linalg.norm(one, axis=1) for one in (first, second, chord)], axis=0)
        lines = np.isnan(sides)
        return np.where(
            lines, np.inf, sides / np.where(lines, 1.0, 2.0 * np.linalg.norm(np.cross(first, chord), axis=1))
        )

    def _slopes(self) -> tuple[Floats, Floats]:
        """Return the unit directions (n - 1, 3) in which each line and arc ends, and begins."""
        arrive, leave = [], []
        for start, via, end in zip(self.points[:-1], self.vias, self.points[1:], strict=True):
            along = end - start
            begins = ends = along
            if not np.isnan(via[0]):
                # Of the circle through three points, by the angles between its chords and tangents.
                begins = _mirrored(_unit(end - via), _unit(via - start) + _unit(along))
                ends = _mirrored(_unit(via - start), _unit(end - via) + _unit(along))
            arrive.append(_unit(ends))
            leave.append(_unit(begins))
        return np.array(arrive), np.array(leave)


def ways(curves: Iterable[Curve], tolerance: float, *, arcs: bool = True, joint: float = 1e-5) -> list[Way]:
    """Return the ways along curves: each from where the last one ends, if that is within `joint` (m).

    A curve whose end is there is followed backwards, and one with normals never goes on from one without. Lines, and
    arcs if they are wanted, are at most `tolerance` (m) away from the curve.
    """
    if not tolerance > 0.0:
        raise InvalidArgumentError(f"the tolerance is {tolerance:g} m; it must be above 0")
    runs: list[list[Curve]] = []
    for curve in curves:
        if runs and (curve.normals is None) == (runs[-1][-1].normals is None):
            gaps = np.linalg.norm(curve.ends - runs[-1][-1].ends[1], axis=1)
            if gaps.min() <= joint:
                runs[-1].append(curve if gaps[0] <= joint else curve.reversed())
                continue
        runs.append([curve])
    return [_way(run, tolerance, arcs) for run in runs]


def frames(way: Way, axis: ArrayLike, *, turn: bool = True) -> Floats:
    """Return frames (n, 4, 4) of the tool centre point: z along `axis` (3,), x along the way as far as it is across z.

    Where the file tells normals of the surface, z is against them. Without `turn` the tool is turned about itself as
    little as can be, beginning along the way.

    Raises InvalidArgumentError for an axis along the way, and for one without length.
    """
    wanted = np.asarray(axis, dtype=np.float64)
    if wanted.shape != (3,) or not np.isfinite(wanted).all() or not wanted.any():
        raise InvalidArgumentError(f"the tool's axis is three numbers that are not all 0, not {wanted.tolist()}")
    z = np.broadcast_to(wanted, way.points.shape) if way.normals is None else -way.normals
    z = z / np.linalg.norm(z, axis=1)[:, None]
    found = np.tile(np.eye(4), (len(z), 1, 1))
    along = way.tangents[0]
    for place, (point, tangent) in enumerate(zip(way.points, way.tangents, strict=True)):
        if turn:
            along = tangent
        across = along - (along @ z[place]) * z[place]
        size = np.linalg.norm(across)
        if size < ALONG:
            raise InvalidArgumentError(
                f"{way.places[place]}: the tool's axis is along the way, which leaves open how the tool is turned "
                "about it; give another --tool-axis"
            )
        x = across / size
        found[place, :3, :] = np.stack([x, np.cross(z[place], x), z[place], point], axis=1)
        along = x
    return found


def _way(curves: list[Curve], tolerance: float, arcs: bool) -> Way:
    places, points, vias, normals = list[str](), list[Floats](), list[Floats](), list[Floats]()
    arrive, leave = list[Floats](), list[Floats]()
    for curve in curves:
        count = 1
        for number, piece in enumerate(curve.pieces):
            stretches = list(_stretches(piece, 0.0, 1.0, tolerance, arcs))
            at = np.array([0.0, *(end for end, _ in stretches)])
            (on, _), slopes = points_on(piece, at), directions(piece, at)
            if not points:
                points.append(on[0])
                places.append(f"{curve.name}, point 1")
                arrive.append(slopes[0])
                if curve.normals is not None:
                    normals.append(curve.normals[0])
            leave += list(slopes[:-1])
            arrive += list(slopes[1:])
            points += list(on[1:])
            vias += [via for _, via in stretches]
            places += [f"{curve.name}, point {count + one}" for one in range(1, len(at))]
            count += len(stretches)
            if curve.normals is not None:
                normals += list(np.linspace(curve.normals[number], curve.normals[number + 1], len(at))[1:])
    leave.append(arrive[-1])
    tangents = np.array(arrive) + np.array(leave)
    back = np.linalg.norm(tangents, axis=1) < 1e-6  # where it turns back there is no halfway
    tangents[back] = np.array(leave)[back]
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    return Way(tuple(places), np.array(points), tangents, np.array(vias), np.array(normals) if normals else None)


def _stretches(
    piece: Floats, begin: float, end: float, tolerance: float, arcs: bool, halvings: int = 0
) -> Iterator[tuple[float, Floats]]:
    """Yield the parameters at which the lines and arcs of a piece end, and a point in the middle of each arc."""
    points, _ = points_on(piece, np.linspace(begin, end, SAMPLES))
    middle = points[SAMPLES // 2]
    if _off_line(points) <= tolerance or halvings == MOST_HALVINGS:
        yield end, np.full(3, np.nan)
    elif arcs and _off_arc(points, middle) <= tolerance:
        yield end, middle
    else:
        half = 0.5 * (begin + end)
        yield from _stretches(piece, begin, half, tolerance, arcs, halvings + 1)
        yield from _stretches(piece, half, end, tolerance, arcs, halvings + 1)


def _off_line(points: Floats) -> float:
    """Return the greatest distance of points (k, 3) from the line between the first and the last, if that is one."""
    chord = points[-1] - points[0]
    size = chord @ chord
    if size <= SAME**2:
        return np.inf
    shares = np.clip((points - points[0]) @ chord / size, 0.0, 1.0)
    return float(np.linalg.norm(points - points[0] - shares[:, None] * chord, axis=1).max())


def _off_arc(points: Floats, middle: Floats) -> float:
    """Return the greatest distance of points (k, 3) from the arc through the first, the middle and the last one."""
    a, b = middle - points[0], points[-1] - points[0]
    normal = np.cross(a, b)
    size = normal @ normal
    if size <= 1e-12 * (a @ a) * (b @ b):
        return np.inf
    to_center = np.cross((a @ a) * b - (b @ b) * a, normal) / (2.0 * size)
    radius = float(np.linalg.norm(to_center))
    spokes = points - points[0] - to_center
    turned = np.linalg.norm(np.diff(spokes, axis=0), axis=1).sum() / radius
    if turned > MOST_TURN:
        return np.inf
    above = spokes @ (normal / np.sqrt(size))
    across = np.linalg.norm(np.cross(spokes, normal / np.sqrt(size)), axis=1)
    return float(np.hypot(above, across - radius).max())


def _unit(along: Floats) -> Floats:
    return along / np.linalg.norm(along)


def _mirrored(along: Floats, at: Floats) -> Floats:
    """Return a direction mirrored at another one."""
    unit = _unit(at)
    return 2.0 * (along @ unit) * unit - along
