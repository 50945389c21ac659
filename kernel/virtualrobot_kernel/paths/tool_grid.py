"""Ladder of a tool path: its rungs, the combinations of free values on each, and the postures of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.motion.free_path import FramePath, frame_t_tools, within_hull
from virtualrobot_kernel.numeric.ladder import cheapest_way, turns_of
from virtualrobot_kernel.paths.closed_forms import LedArm
from virtualrobot_kernel.paths.easing import eased
from virtualrobot_kernel.paths.tool_query import Tolerances, ToolPathQuery

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

Given = Callable[[Floats], Floats]
"""Values (n, m) of what carries an arm, at parameters (n,) of its path."""

RUNG, RUNG_TURN, MOST_RUNGS = 0.005, 0.1, 400
"""Distance (m) and turn of the frames (rad) from rung to rung, and about how many there are at the most."""

FEWEST_RUNGS = 9
"""Number of rungs, but for frames between them, below which none are left out for joints that are slow."""

NEAREST = 0.7
"""Part of that distance by which frames must be apart to be rungs all of them."""

STEPS = np.array([2e-3] * 3 + [np.radians(10.0)] * 3)
"""Distance of two free values in a row, in m and in rad."""

HELD_STEPS = (0.05, float(np.radians(10.0)))
"""The same of a joint that is free, in m and in rad."""

ROOM = 4.0
"""Factor of the time that a free joint has for a step of its values over what it needs: others make up for it."""

FEWEST, MOST = 3, 36
"""Number of values of a tolerance with ends at least, and of any at the most."""

MOST_EDGES = 540_000
"""Greatest number of combinations on all rungs together, times those from which each is reached."""

SHARE = 0.9
"""Part of its greatest speed that a joint may have on the mean from rung to rung: between them it may have more."""

ROUNDING = 1e-9
"""Part of a turn by which rounding may lead beyond a limit."""

SAME_PLACE = 0.3
"""Part of the mean distance of places below which two of them are one."""

EASY = 1e3
"""Stiffness of the values from which those are looked for that joints follow easily."""

CHANGE, WISH = 0.05, 0.02
"""Cost of a step of a free value, and of one that is as far from its frame as its tolerance is wide; as squares."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Combinations of free values (g, f), those from which each is reached (g, w), what that costs, and itself."""

    values: Floats
    neighbours: Integers
    changes: Floats
    wish: Floats


def freedom_of(tolerances: Tolerances, arm: LedArm, carried: bool = True) -> tuple[Tolerances, Floats]:
    """Return bounds (2, 6 + f) of all free values, those of joints within their limits, and steps (6 + f,).

    Where what carries is not free (`carried`), as where it is given, its values are 0.
    """
    ends, turns = np.stack([arm.lower, arm.upper]), arm.turns[arm.free]
    if not carried:
        ends[:, arm.held is not None :] = 0.0
    endless = turns & ~np.isfinite(ends).all(axis=0)
    bounds = np.concatenate([tolerances.bounds, np.where(endless, 0.0, ends)], axis=1)
    steps = np.where(turns, HELD_STEPS[1], HELD_STEPS[0])
    return Tolerances(bounds, np.concatenate([tolerances.endless, endless])), np.concatenate([STEPS, steps])


def grid_of(tolerances: Tolerances, steps: Floats, rungs: int) -> Grid:
    """Return the combinations of what tolerances leave free, about steps (f,) apart; fewer for many rungs."""
    bounds, endless = tolerances.bounds, tolerances.endless
    width = bounds[1] - bounds[0]
    counts = np.ones(len(steps), np.int64)
    for axis, step in enumerate(steps.tolist()):
        if endless[axis]:
            counts[axis] = MOST
        elif width[axis] > 0.0:
            counts[axis] = np.clip(np.ceil(width[axis] / step) + 1, FEWEST, MOST)
    while counts.prod() * rungs * 3 ** int((counts > 1).sum()) > MOST_EDGES and counts.max() > FEWEST:
        counts[counts.argmax()] -= 1
    ends = np.where(endless, [[-np.pi], [np.pi]], bounds).T.tolist()
    axes = [
        np.linspace(lower, upper, count, not ring)
        for (lower, upper), count, ring in zip(ends, counts.tolist(), endless.tolist(), strict=True)
    ]
    places = np.array(list(product(*(range(count) for count in counts.tolist()))))
    values = np.array(list(product(*axes)))
    offsets = np.array(list(product(*((-1, 0, 1) if count > 1 else (0,) for count in counts.tolist()))))
    reached = places[:, None] + offsets
    inside = ((reached >= 0) & (reached < counts) | endless).all(axis=2)
    rows = np.ravel_multi_index(tuple(np.moveaxis(reached % counts, 2, 0)), tuple(counts.tolist()))
    # Where any turn will do none is wished, and neither is a place of a joint within its limits.
    scale = np.where(endless | (width <= 0.0) | (np.arange(len(steps)) > 5), np.inf, width)
    return Grid(
        values,
        np.where(inside, rows, -1),
        CHANGE * (offsets**2).sum(axis=1, dtype=np.float64),
        WISH * ((values / scale) ** 2).sum(axis=1),
    )


def rungs_of(path: FramePath, least: float = 0.0) -> Floats:
    """Return the parameters (n,) of rungs, n >= 4: frames, as far as they are not too near, and places between them.

    They are `least` (m) apart, as far as there are enough of them then.
    """
    turn = RUNG_TURN * path.length / max(path.curve.angle, 1e-9)
    step = (
        max(min(max(min(RUNG, turn), least), path.length / (FEWEST_RUNGS - 1)), path.length / MOST_RUNGS) / path.length
    )
    kept = [0.0]
    for place in path.frames[1:-1].tolist():
        if min(place - kept[-1], 1.0 - place) >= NEAREST * step:
            kept.append(place)
    kept.append(1.0)
    parts = [np.linspace(begin, end, max(1, round((end - begin) / step)), False) for begin, end in pairwise(kept)]
    return np.append(np.concatenate(parts), 1.0)


def laid_out(path: FramePath, freedom: Tolerances, steps: Floats, pace: Floats) -> tuple[Floats, Grid]:
    """Return rungs and combinations, so far apart that each free joint has the time for a step of its values.

    pace (f,): the way (m) on which a free joint goes by one rad, or m. Fewer rungs leave room for more values, so that
    both are found in turns.
    """
    least = 0.0
    while True:
        rungs = rungs_of(path, least)
        grid = grid_of(freedom, steps, len(rungs))
        apart = [float(np.diff(np.unique(column)).max(initial=0.0)) for column in grid.values[:, 6:].T]
        needed = float((np.array(apart) * pace).max(initial=0.0))
        if needed <= least * (1.0 + 1e-9) or len(rungs) <= FEWEST_RUNGS:
            return rungs, grid
        least = max(needed, 1.05 * least)


def halved(rungs: Floats, frames: Floats) -> Floats:
    """Return rungs and frames, but for such as are next to another, and the middles between them: (m,)."""
    found = np.union1d(rungs, frames)
    apart = np.diff(found) > SAME_PLACE * np.diff(found).mean()
    found = np.concatenate([found[:1], found[1:][apart]])
    found[-1] = 1.0
    return np.sort(np.concatenate([found, 0.5 * (found[:-1] + found[1:])])) if len(found) <= MOST_RUNGS else found


def smoothed(values: Floats, freedom: Tolerances, stiffness: float) -> Floats:
    """Return free values (n + 2, f) that are near to others (n, f), the smoother the stiffer, within their bounds.

    They are one more at either end, as they go on there. Endless ones go on beyond a turn.
    """
    endless, found = freedom.endless, values.copy()
    found[:, endless] = np.unwrap(found[:, endless], axis=0)
    if stiffness:
        third = np.diff(np.eye(len(found)), 3, axis=0)
        found = np.linalg.solve(np.eye(len(found)) + stiffness * third.T @ third, found)
    found = np.where(endless, found, np.clip(found, *freedom.bounds))
    found = np.concatenate([2.0 * found[:1] - found[1:2], found, 2.0 * found[-1:] - found[-2:-1]])
    return np.where(endless, found, np.clip(found, *freedom.bounds))


def turned_within(joints: Floats, limits: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return by how much each joint of a way (n, k) is turned to be in the middle of limits (2, k), as whole turns.

    And whether it is beyond them at all turns: (k,) both. Where there are no limits, it stays.
    """
    turn, bounded = 2.0 * np.pi, np.isfinite(limits).all(axis=0)
    lower, upper = np.where(bounded, limits, 0.0)
    least, most = joints.min(axis=0), joints.max(axis=0)
    first, last = np.ceil((lower - least) / turn - ROUNDING), np.floor((upper - most) / turn + ROUNDING)
    middle = np.round(0.5 * (lower + upper - least - most) / turn)
    return np.where(bounded, turn * np.clip(middle, first, np.maximum(first, last)), 0.0), bounded & (first > last)


def beyond_limits(q: Floats, limits: Floats, turning: NDArray[np.bool_]) -> Floats:
    """Return by how much joints q (..., k) are beyond limits (2, k) at the best turns; inf without a posture."""
    lower, upper = limits
    middle = np.where(np.isfinite(lower + upper), 0.5 * (lower + upper), q)
    near = q - np.where(turning, 2.0 * np.pi * np.round((q - middle) / (2.0 * np.pi)), 0.0)
    beyond = np.maximum(lower - near, near - upper)
    return np.where(np.isnan(beyond), np.inf, np.maximum(beyond, 0.0))


class Ladder:
    """Postures of an arm on all rungs of a tool path, and the search among those that are not blocked."""

    def __init__(
        self, query: ToolPathQuery, path: FramePath, arm: LedArm, velocity: Floats, given: Given | None = None
    ) -> None:
        """Solve all rungs for an arm by its closed form; its joints have greatest velocities (k,) in rad/s or m/s.

        What carries it is free, or where it is given (n, m) at parameters (n,) of the path.
        """
        self._arm, self._path, self._given, self._own = arm, path, given, int(arm.held is not None)
        self.freedom, steps = freedom_of(query.tolerances, arm, given is None)
        pace = ROOM * query.velocity / (SHARE * velocity[arm.free])
        self.rungs, self.grid = laid_out(path, self.freedom, steps, pace)
        self._limits, self.turning = np.stack([query.lower, query.upper]), arm.turns
        self._tcp_t_tip, frames = inverse(query.tip_t_tcp), path.poses(self.rungs)
        offsets = frame_t_tools(self.grid.values[:, :6]) @ self._tcp_t_tip
        free = self._free(np.repeat(self.rungs, len(self.grid.values)), np.tile(self.grid.values, (len(self.rungs), 1)))
        q, wrist = arm.postures((frames[:, None] @ offsets).reshape(-1, 4, 4), free)
        shape = len(self.rungs), len(self.grid.values), q.shape[1]
        self.q, self._wrist = q.reshape(*shape, len(velocity)), wrist.reshape(shape)
        self.blocked = np.zeros(shape, np.int8)
        seconds = np.diff(self.rungs) * path.length / query.velocity
        self.most = np.minimum(SHARE * velocity * seconds[:, None], 0.9 * np.pi)
        if given is not None:
            # Those before have kept their speeds.
            self.most[:, arm.free[self._own :]] = 0.9 * np.pi
        # What slides has no turns, which the search tells by limits, and free values are within theirs.
        self._turned = np.where(self.turning, self._limits, [[-np.inf], [np.inf]])
        self._turned[:, arm.free] = [[-np.inf], [np.inf]]
        # All turns of six joints of two turns each are hundreds: those of a joint are told apart once a way left it.
        self._apart = np.array(turns_of(self._turned)) == 1

    @property
    def carried(self) -> Floats:
        """Values (g, m) of what carries the arm, in each combination of free values."""
        return self.grid.values[:, 6 + self._own :]

    def _free(self, at: Floats, values: Floats) -> Floats:
        """Return where free joints are (n, f) at parameters (n,), by free values (n, 6 + f)."""
        if self._given is None:
            return values[:, 6:]
        return np.concatenate([values[:, 6 : 6 + self._own], self._given(at)], axis=1)

    def excess(self) -> Floats:
        """Return by how much each joint is beyond its limits at the best turns, (n, g, b, k); inf without a posture."""
        return beyond_limits(self.q, self._limits, self.turning)

    def searched(self) -> tuple[int, Integers, Floats]:
        """Return the number of rungs that are reached, combination and branch on each (n, 2), and joints (n, k)."""
        n, g, b, k = self.q.shape
        grid = self.grid
        while True:
            limits = np.where(self._apart, self._turned, [[-np.inf], [np.inf]])
            turns = int(np.prod(turns_of(limits)))
            back, way, joints = np.empty((n, g * b * turns), np.int32), np.zeros((n, 2), np.int64), np.zeros((n, k))
            reached = cheapest_way(
                *(self.q, self._wrist, self.blocked, limits, self.most),
                *(grid.neighbours, grid.changes, grid.wish, back, way, joints),
            )
            shifts, left = turned_within(joints, self._turned)
            left &= ~self._apart
            if reached < n or not left.any():
                return reached, way, joints + np.where(self._apart, 0.0, shifts)
            self._apart |= left

    def smoothed(self, way: Integers, stiffness: float) -> Floats:
        """Return the free values (n + 2, 6 + f) of a way, smoothed, and as they go on at its ends; within bounds."""
        return smoothed(self.grid.values[way[:, 0]], self.freedom, stiffness)

    def eased(self, way: Integers, joints: Floats, most: Floats) -> tuple[Floats, Floats, float]:
        """Return places (m,), free values there (m + 2, f), by which joints accelerate less; and the share they need.

        way (n, 2) and joints (n, k): on the rungs. most (k,): the greatest second derivatives of the joints by the
        path's parameter. Places are the frames, the rungs, and between them, so that what turns at a frame is seen.
        """
        places = halved(self.rungs, self._path.frames)
        found = smoothed(self.grid.values[way[:, 0]], self.freedom, EASY)
        values = within_hull(self.rungs, found).evaluate(places)
        branch = int(way[0, 1])

        def postures(at: Floats, values: Floats) -> Floats:
            tips = self._path.poses(at) @ frame_t_tools(values[:, :6]) @ self._tcp_t_tip
            found = self._arm.postures(tips, self._free(at, values))[0][:, branch]
            near = np.stack([np.interp(at, self.rungs, column) for column in joints.T], axis=1)
            turns = 2.0 * np.pi * np.round((near - found) / (2.0 * np.pi))
            return np.where(self.turning, found + turns, found)

        return places, *eased(places, values, self.freedom, postures, most)

    def around(self, combination: int, reach: int) -> Integers:
        """Return the combinations that are up to `reach` steps of free values from one, with itself."""
        found = np.array([combination])
        for _ in range(reach):
            found = np.unique(self.grid.neighbours[found])
            found = found[found >= 0]
        return found

    def block(self, rung: int, combination: int, branch: int, reach: int) -> None:
        """Block a posture, and those that are up to `reach` rungs and steps of free values from it."""
        first = max(0, rung - reach)
        self.blocked[first : rung + reach + 1, self.around(combination, reach), branch] = 1
