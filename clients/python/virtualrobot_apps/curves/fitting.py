"""Lines and arcs along curves, within a tolerance: the ways that a tool goes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.curves.curve import SAME, Curve, Floats, directions, points_on
from virtualrobot_apps.curves.way import Way, units

SAMPLES = 9
"""Points of a stretch, its ends among them, at which it is compared with a line and an arc."""
MOST_HALVINGS = 20
MOST_TURN = 1.05 * np.pi
"""Angle (rad) up to which a stretch is one arc."""


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


def _way(curves: list[Curve], tolerance: float, arcs: bool) -> Way:
    """Return the way along curves that meet."""
    names, points, vias, normals = list[str](), list[Floats](), list[Floats](), list[Floats]()
    arrive, leave = list[Floats](), list[Floats]()
    for curve in curves:
        count = 1
        for number, piece in enumerate(curve.pieces):
            stretches = list(_stretches(piece, 0.0, 1.0, tolerance, arcs))
            at = np.array([0.0, *(end for end, _ in stretches)])
            (on, _), slopes = points_on(piece, at), directions(piece, at)
            if not points:
                points.append(on[0])
                names.append(f"{curve.name}, point 1")
                arrive.append(slopes[0])
                if curve.normals is not None:
                    normals.append(curve.normals[0])
            leave += list(slopes[:-1])
            arrive += list(slopes[1:])
            points += list(on[1:])
            vias += [via for _, via in stretches]
            names += [f"{curve.name}, point {count + one}" for one in range(1, len(at))]
            count += len(stretches)
            if curve.normals is not None:
                normals += list(np.linspace(curve.normals[number], curve.normals[number + 1], len(at))[1:])
    leave.append(arrive[-1])
    tangents = np.array(arrive) + np.array(leave)
    back = np.linalg.norm(tangents, axis=1) < 1e-6  # where it turns back there is no halfway
    tangents[back] = np.array(leave)[back]
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    known = units(np.array(normals)).reshape(len(points), -1, 3) if normals else np.empty((len(points), 0, 3))
    return Way(np.array(points), known, vias=np.array(vias) if arcs else None, directions=tangents, names=tuple(names))


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
