"""Ways of a tool: points with lines or arcs between them, and the normals of the surface there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import InvalidArgumentError

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Way of a tool, on a part or along curves of a file.

    Attributes:
        points: (n, 3) in m; those of a loop end where they begin.
        normals: (n, k, 3) unit normals of the surface, out of the part: none, where a file doesn't tell them (k = 0);
            of the surface (k = 1); or of the faces on the left and on the right of an edge, seen from outside and along
            the way (k = 2).
        closed: true for a loop.
        vias: (n - 1, 3) a point in the middle of each arc, not a number for a line; None for lines alone.
        directions: (n, 3) the unit directions of the way at the points, at a corner halfway between both, where the
            curve that it is from tells them.
        names: (n,) whose curve each point is on, and which of its points, such as `C1, point 3`; empty without a file.
    """

    points: Floats
    normals: Floats
    closed: bool = False
    vias: Floats | None = None
    directions: Floats | None = None
    names: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Its length (m); that of arcs a little less."""
        return float(self.lengths().sum())

    @property
    def outward(self) -> Floats:
        """The directions (n, 3) out of the part: its normals, or the bisectors of two of them.

        Raises InvalidArgumentError where two faces are back to back, and where it has no normals.
        """
        if not self.normals.shape[1]:
            raise InvalidArgumentError(f"{place(self, 0)} the surface's normal is not known; give one")
        total = self.normals.sum(axis=1)
        sizes = np.linalg.norm(total, axis=1)
        if (sizes < 1e-6).any():
            row = int(sizes.argmin())
            raise InvalidArgumentError(f"{place(self, row)} the faces beside the way are back to back")
        return total / sizes[:, None]

    @property
    def tangents(self) -> Floats:
        """Its unit directions (n, 3) at the points; at those of a loop's start the same as at its end.

        Raises InvalidArgumentError where it turns back, unless its curve tells them.
        """
        if self.directions is not None:
            return self.directions
        found = slopes(self.points, self.closed)
        sizes = np.linalg.norm(found, axis=1)
        if (sizes < 1e-6).any():
            row = int(sizes.argmin())
            raise InvalidArgumentError(f"{place(self, row)} it turns back on itself, which leaves its direction open")
        return found / sizes[:, None]

    def reversed(self) -> Way:
        """Return the way from its end to its start; left and right change places."""
        return Way(
            self.points[::-1].copy(),
            self.normals[::-1, ::-1].copy(),
            self.closed,
            None if self.vias is None else self.vias[::-1].copy(),
            None if self.directions is None else -self.directions[::-1],
            self.names[::-1],
        )

    def facing(self, axis: ArrayLike) -> Way:
        """Return the way with the normal against an axis (3,) in which the tool points, where it has none of its own.

        Raises InvalidArgumentError for an axis without length.
        """
        wanted = np.asarray(axis, dtype=np.float64)
        if wanted.shape != (3,) or not np.isfinite(wanted).all() or not wanted.any():
            raise InvalidArgumentError(f"the tool's axis is three numbers that are not all 0, not {wanted.tolist()}")
        if self.normals.shape[1]:
            return self
        return replace(self, normals=np.tile(-wanted / np.linalg.norm(wanted), (len(self.points), 1, 1)))

    def corners(self) -> Floats:
        """Return the angles (n,) in rad by which lines and arcs bend where they meet; 0 at both ends."""
        arrive, leave = self._slopes()
        cosines = np.clip(np.einsum("ij,ij->i", arrive[:-1], leave[1:]), -1.0, 1.0)
        return np.concatenate([[0.0], np.arccos(cosines), [0.0]])

    def lengths(self) -> Floats:
        """Return the lengths (n - 1,) of the lines and arcs; those of arcs a little less."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        if self.vias is None:
            return steps
        halves = np.linalg.norm(self.vias - self.points[:-1], axis=1) + np.linalg.norm(
            self.points[1:] - self.vias, axis=1
        )
        return np.where(np.isnan(halves), steps, halves)

    def radii(self) -> Floats:
        """Return the radii (n - 1,) of the arcs in m, those of the circles through three points; lines have no end."""
        if self.vias is None:
            return np.full(len(self.points) - 1, np.inf)
        first, second, chord = self.vias - self.points[:-1], self.points[1:] - self.vias, np.diff(self.points, axis=0)
        sides = np.prod([np.linalg.norm(one, axis=1) for one in (first, second, chord)], axis=0)
        lines = np.isnan(sides)
        return np.where(
            lines, np.inf, sides / np.where(lines, 1.0, 2.0 * np.linalg.norm(np.cross(first, chord), axis=1))
        )

    def _slopes(self) -> tuple[Floats, Floats]:
        """Return the unit directions (n - 1, 3) in which each line and arc ends, and begins."""
        arrive, leave = [], []
        vias = np.full((len(self.points) - 1, 3), np.nan) if self.vias is None else self.vias
        for start, via, end in zip(self.points[:-1], vias, self.points[1:], strict=True):
            along = end - start
            begins = ends = along
            if not np.isnan(via[0]):
                # Of the circle through three points, by the angles between its chords and tangents.
                begins = _mirrored(_unit(end - via), _unit(via - start) + _unit(along))
                ends = _mirrored(_unit(via - start), _unit(end - via) + _unit(along))
            arrive.append(_unit(ends))
            leave.append(_unit(begins))
        return np.array(arrive), np.array(leave)


def place(way: Way, row: int) -> str:
    """Return where a point of a way is, as the beginning of a sentence."""
    if way.names:
        return f"{way.names[row]}:"
    return f"at points[{row}] of the way, ({', '.join(f'{1e3 * one:.6g}' for one in way.points[row])}) mm,"


def checked_way(points: ArrayLike, normals: ArrayLike, closed: bool = False) -> Way:
    """Return a way of points (n, 3) in m and of normals (3,), (n, 3) or (n, k, 3) of any length above 0.

    Raises:
        InvalidArgumentError: for fewer than two points, for those that are the same in a row or not finite, for normals
            without length, and for a loop that doesn't end where it begins.
    """
    places = np.array(points, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 3 or len(places) < 2:
        raise InvalidArgumentError(f"the points of a way have the shape (n, 3), n at least 2, not {places.shape}")
    given = np.array(normals, dtype=np.float64)
    if given.shape == (3,):
        given = np.tile(given, (len(places), 1))
    if given.ndim == 2:
        given = given[:, None]
    if given.ndim != 3 or given.shape[0] != len(places) or given.shape[1] not in (1, 2) or given.shape[2] != 3:
        raise InvalidArgumentError(
            f"the normals of {len(places)} points have the shape (3,), ({len(places)}, 3) or ({len(places)}, 2, 3), "
            f"not {np.shape(normals)}"
        )
    for what, values in (("points", places), ("normals", given)):
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values).reshape(len(places), -1).all(axis=1))[0])
            raise InvalidArgumentError(f"{what}[{row}] of the way is {values[row].tolist()}; it must be finite")
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    if not steps.all():
        row = int(steps.argmin())
        raise InvalidArgumentError(f"points[{row + 1}] of the way is the same as points[{row}]; leave it out")
    sizes = np.linalg.norm(given, axis=2)
    if not sizes.all():
        raise InvalidArgumentError(f"normals[{int(sizes.min(axis=1).argmin())}] of the way has no length")
    if closed and (len(places) < 4 or not np.array_equal(places[0], places[-1])):
        raise InvalidArgumentError("a loop has at least three points and ends with the one that it begins with")
    return Way(places, given / sizes[:, :, None], closed)


def slopes(points: Floats, closed: bool) -> Floats:
    """Return derivatives (n, 3) by length of the parabolas through each point (n, 3) and the two beside it."""
    around = np.concatenate([points[-2:-1], points, points[1:2]]) if closed else points
    steps = np.linalg.norm(np.diff(around, axis=0), axis=1)[:, None]
    lines = np.diff(around, axis=0) / steps
    if len(lines) == 1:
        return lines.repeat(2, axis=0)
    inner = (lines[:-1] * steps[1:] + lines[1:] * steps[:-1]) / (steps[:-1] + steps[1:])
    if closed:
        return inner
    first = lines[0] + (lines[0] - lines[1]) * steps[0] / (steps[0] + steps[1])
    last = lines[-1] + (lines[-1] - lines[-2]) * steps[-1] / (steps[-1] + steps[-2])
    return np.concatenate([first[None], inner, last[None]])


def units(vectors: Floats) -> Floats:
    """Return vectors (..., 3) of length 1 along others."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def above_zero(what: str, value: float) -> None:
    """Raise InvalidArgumentError for a length (m) that is not finite and above 0."""
    if not (np.isfinite(value) and value > 0.0):
        raise InvalidArgumentError(f"the {what} is {value:g} m; it must be above 0")


def _unit(along: Floats) -> Floats:
    return along / np.linalg.norm(along)


def _mirrored(along: Floats, at: Floats) -> Floats:
    """Return a direction mirrored at another one."""
    unit = _unit(at)
    return 2.0 * (along @ unit) * unit - along
