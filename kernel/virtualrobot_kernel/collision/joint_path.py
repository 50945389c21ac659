"""Ways of all joints over time, each with a bound of how far every joint goes in between: what a swept check is of."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import Array, PiecewisePolynomial
from virtualrobot_kernel.motion.program import Program

Indices = NDArray[np.integer]

PARTS, CELLS = 4, 96
"""Into how many parts a piece of a path is cut at least, and the whole path, each with a bound of its slope."""


@dataclass(frozen=True, slots=True, eq=False)
class Lengths:
    """Lengths that a path's components have gone at the most until each of its breaks, and their slopes after it."""

    breaks: list[float]
    gone: Array
    slopes: Array

    def until(self, u: float) -> Array:
        """Return how far each component has gone at a parameter at the most."""
        row = min(max(bisect_right(self.breaks, u) - 1, 0), len(self.slopes) - 1)
        inside = min(max(u, self.breaks[row]), self.breaks[row + 1])
        return self.gone[row] + (inside - self.breaks[row]) * self.slopes[row]


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Piece of a way on which coordinates go along one polynomial path, as compiled code takes it.

    Attributes:
        begin: the first time, and `end` the last one.
        columns: (k,) the coordinates that go; all others stand.
        path: where they are by its parameter.
        lengths: how far they go at the most.
        law: the parameter by the time since `after`.
        after: the time at which the law's is 0.
    """

    begin: float
    end: float
    columns: Indices
    path: PiecewisePolynomial
    lengths: Lengths
    law: PiecewisePolynomial
    after: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class JointPath:
    """A way of all coordinates of a world over time; before `begin` and after `end` it stands.

    Attributes:
        begin: the first time, and `end` the last one, in s or in whatever the way is told by.
        at: gives all coordinates (nq,) at a time.
        travel: gives at least how far each coordinate (nq,) goes between two times, the earlier first: the length of
            its way forth and back, not the difference.
        wobble: how far the true coordinates may be from `at` (nq,); None where it tells them exactly.
        pieces: the same way for compiled code, one after the other; empty where it is of another kind.
    """

    begin: float
    end: float
    at: Callable[[float], Array]
    travel: Callable[[float, float], Array]
    wobble: Array | None = None
    pieces: tuple[Piece, ...] = ()


def line(q_from: Array, q_to: Array, begin: float = 0.0, end: float = 1.0) -> JointPath:
    """Return the straight line between coordinates (nq,); floating joints go along it too, normalised at each place."""
    way, duration = np.subtract(q_to, q_from), max(end - begin, np.finfo(float).tiny)
    distance = np.abs(way)

    def share(time: float) -> float:
        return min(max((time - begin) / duration, 0.0), 1.0)

    columns = np.flatnonzero(way)
    lengths = Lengths([0.0, 1.0], np.stack([np.zeros(len(columns)), distance[columns]]), distance[None, columns])
    law = PiecewisePolynomial(np.array([begin, begin + duration]), np.array([[[0.0], [1.0 / duration]]]))
    goes = begin < end and len(columns)
    path = joint_line(q_from[columns], q_to[columns]) if goes else None
    return JointPath(
        begin,
        end,
        lambda time: q_from + share(time) * way,
        lambda first, last: (share(last) - share(first)) * distance,
        pieces=() if path is None else (Piece(begin, end, columns, path, lengths, law),),
    )


def through(times: Sequence[float] | Array, positions: Array, acceleration: Array | float = 0.0) -> JointPath:
    """Return the way through coordinates (m, nq) at rising times (m,), m >= 2, straight between them.

    Args:
        times: in s.
        positions: rad or m.
        acceleration: a bound of each coordinate's second derivative (nq,), or one for all that move, when the true way
            is curved: between two times h apart it is within A h² / 8 of the line.
    """
    knots = np.asarray(times, np.float64)
    positions = np.asarray(positions, np.float64)
    gone = np.concatenate([np.zeros((1, positions.shape[1])), np.cumsum(np.abs(np.diff(positions, axis=0)), axis=0)])
    steps, listed = np.diff(knots), knots.tolist()

    def between(time: float, values: Array) -> Array:
        row = min(max(bisect_right(listed, time) - 1, 0), len(steps) - 1)
        share = min(max((time - listed[row]) / steps[row], 0.0), 1.0)
        return values[row] + share * (values[row + 1] - values[row])

    bend = np.broadcast_to(acceleration, gone[0].shape) if np.ndim(acceleration) else (gone[-1] > 0.0) * acceleration
    return JointPath(
        listed[0],
        listed[-1],
        lambda time: between(time, positions),
        lambda first, last: between(last, gone) - between(first, gone),
        bend * (steps.max() ** 2 / 8.0) if np.any(bend) else None,
    )


def of_plan(q: Array, q_index: Indices, plan: Plan) -> JointPath:
    """Return the way of a plan by its nominal time: coordinates `q_index` (n,) move, all others stand at q (nq,)."""
    return of_laws(q, q_index, plan, tuple(track.time_law for track in plan.tracks), 0.0, plan.duration)


def of_path(
    q: Array, q_index: Indices, path: PiecewisePolynomial, lengths: Lengths | None = None, wobble: Array | None = None
) -> JointPath:
    """Return a path by its own parameter: coordinates `q_index` (n,) move, all others stand at q (nq,).

    `lengths` says how far they go, where that is known; `wobble` (nq,) as in `JointPath`.
    """
    table, everywhere = lengths or lengths_of(path), np.array(q, np.float64)

    def at(u: float) -> Array:
        found = everywhere.copy()
        found[q_index] = path.state(u, 0)[0]
        return found

    def travel(first: float, last: float) -> Array:
        found = np.zeros_like(everywhere)
        found[q_index] = table.until(last) - table.until(first)
        return found

    law = PiecewisePolynomial(path.breaks[[0, -1]], np.array([[[path.start], [1.0]]]))
    pieces = (Piece(path.start, path.end, q_index, path, table, law),) if path.start < path.end else ()
    return JointPath(path.start, path.end, at, travel, wobble, pieces)


def of_laws(
    q: Array, q_index: Indices, plan: Plan, laws: Sequence[PiecewisePolynomial], begin: float, end: float
) -> JointPath:
    """Return the way on a plan's paths by laws u(t), one for each track, that never run back: such as brakes.

    Args:
        q: (nq,) where all else stands.
        q_index: (n,) where the plan's columns are in q.
        plan: the paths.
        laws: the path parameter of each track by time; a law is over at its end.
        begin: the first time.
        end: the last one.
    """
    paths = [track.path for track in plan.tracks]
    tables = [lengths_of(path) for path in paths]
    everywhere = np.array(q, np.float64)

    def clamped(time: float) -> float:
        return min(max(time, begin), end)

    def at(time: float) -> Array:
        time, found = clamped(time), everywhere.copy()
        parts = [path.state(law.scalar_state(time)[0], 0)[0] for path, law in zip(paths, laws, strict=True)]
        found[q_index] = np.concatenate(parts)
        return found

    def travel(first: float, last: float) -> Array:
        first, last, found = clamped(first), clamped(last), np.zeros_like(everywhere)
        parts = [
            table.until(law.scalar_state(last)[0]) - table.until(law.scalar_state(first)[0])
            for table, law in zip(tables, laws, strict=True)
        ]
        found[q_index] = np.concatenate(parts)
        return found

    pieces = ()
    if len(paths) == 1 and begin < end and paths[0].start < paths[0].end:
        pieces = (Piece(begin, end, q_index, paths[0], tables[0], laws[0]),)
    return JointPath(begin, end, at, travel, pieces=pieces)


def of_program(q: Array, q_index: Indices, program: Program) -> JointPath:
    """Return the way of a program by its nominal time, at full rate; waiting for signals takes no time.

    Coordinates `q_index` (n,) move, which are the program's columns, and all others stand at q (nq,).
    """
    starts, stages, gone = [], [], [np.zeros(len(q))]
    pieces: list[Piece] = []
    stands = np.array(q, np.float64)
    stands[q_index] = program.start
    for begin, stage in zip(program.begins, program.stages, strict=False):
        path = line(stands, stands, 0.0, stage.duration)
        if stage.plan is not None:
            columns = q_index[list(stage.columns)]
            path = of_plan(stands, columns, stage.plan)
            stands = stands.copy()
            stands[columns] = stage.plan.goal
        pieces += [replace(one, begin=begin, end=begin + path.end, after=begin) for one in path.pieces]
        starts.append(begin)
        stages.append(path)
        gone.append(gone[-1] + path.travel(path.begin, path.end))

    def stage_at(time: float) -> int:
        return min(max(bisect_right(starts, time) - 1, 0), len(stages) - 1)

    def until(time: float) -> Array:
        row = stage_at(time)
        return gone[row] + stages[row].travel(0.0, time - starts[row])

    return JointPath(
        0.0,
        program.duration,
        lambda time: stages[stage_at(time)].at(time - starts[stage_at(time)]),
        lambda first, last: np.maximum(until(last) - until(first), 0.0),
        pieces=tuple(pieces) if all(one.pieces or not one.travel(one.begin, one.end).any() for one in stages) else (),
    )


def together(paths: Sequence[JointPath]) -> JointPath:
    """Return what several ways are at once, by the same time; each moves coordinates that no other one moves."""
    moved = [np.flatnonzero(path.travel(path.begin, path.end)) for path in paths]

    def at(time: float) -> Array:
        found = np.array(paths[0].at(time))
        for path, places in zip(paths[1:], moved[1:], strict=True):
            found[places] = path.at(time)[places]
        return found

    wobble = np.zeros(len(paths[0].at(paths[0].begin)))
    for path in paths:
        wobble += 0.0 if path.wobble is None else path.wobble
    return JointPath(
        min(path.begin for path in paths),
        max(path.end for path in paths),
        at,
        lambda first, last: np.sum([path.travel(first, last) for path in paths], axis=0),
        wobble if wobble.any() else None,
    )


@lru_cache(maxsize=128)
def lengths_of(path: PiecewisePolynomial) -> Lengths:
    """Return how far the components of a path go."""
    if path.start == path.end:
        nothing = np.zeros((1, path.dimension))
        return Lengths([path.start, path.end], nothing, nothing)
    pieces, terms = path.coefficients.shape[:2]
    breaks, slopes = path.slope_bounds(max(PARTS, -(-CELLS // pieces)) if terms > 2 else 1)
    gone = np.concatenate([np.zeros((1, path.dimension)), np.cumsum(slopes * np.diff(breaks)[:, None], axis=0)])
    return Lengths(breaks.tolist(), gone, slopes)
