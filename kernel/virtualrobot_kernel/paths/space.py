"""Configuration space of an arm as a search sees it: free configurations, and free straight lines between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.arm_contacts import ArmContacts
from virtualrobot_kernel.collision.certain import CertainlyFree, room_of
from virtualrobot_kernel.collision.joint_path import of_path
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.collision.swept import RESOLUTION, SweptContact, first_contact
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.path import joint_line
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

TREE, BATCH, BATCHES = 4000, 128, 100
"""Greatest number of configurations of a tree, number of samples between two looks at who waits, and of these looks."""

REACH = 0.2
"""Greatest length of a tree's edges, as a share of the diagonal of the room that the joints have; as OMPL has it."""


ON_LINE = 1e-9
"""Distance in any joint (rad or m) up to which a place is on a line."""


class Moved(Protocol):
    """Joints that a query is about, (k,), and their limits; see `PathQuery`."""

    @property
    def q_index(self) -> NDArray[np.int32]:
        """Places of the joints in q."""
        ...

    @property
    def lower(self) -> Floats:
        """Lower limits."""
        ...

    @property
    def upper(self) -> Floats:
        """Upper limits."""
        ...

    @property
    def ratios(self) -> Floats:
        """Ratios (a, k) of actuators with limits of their own."""
        ...

    @property
    def least(self) -> Floats:
        """Least of ratios @ q."""
        ...

    @property
    def most(self) -> Floats:
        """Greatest of ratios @ q."""
        ...


class PathSpace:
    """Configurations of one arm in a world in which all else stands; used by one thread at a time."""

    def __init__(self, scene: CollisionScene, snapshot: Snapshot, query: Moved, given_up: Callable[[], bool]) -> None:
        """Take the world at the start of the path, and what tells that nobody waits any more."""
        self._scene, self._snapshot, self._query, self._given_up = scene, snapshot, query, given_up
        self.start: Floats = snapshot.state.q[query.q_index]
        self.checks = 0
        """Number of configurations and lines checked."""
        self._contacts = ArmContacts(scene, snapshot, query.q_index)
        self._robots, self._counts = self._contacts.robots, self._contacts.counts
        self._certain = CertainlyFree(scene, snapshot, query.q_index, self._robots, self._counts)
        self._room = room_of(query.lower, query.upper, query.ratios, query.least, query.most)

    def contact(self, q: Floats) -> Pair | None:
        """Return two nodes (uids) that touch at q (k,) and may not, or None."""
        self.checks += 1
        return self._contacts.contact(q)

    def contacts(self, configurations: Floats) -> list[Pair | None]:
        """Return what touches, as `contact` tells it, at each of some configurations (m, k)."""
        certain = self._certain.places(configurations)
        self.checks += int(certain.sum())
        return [None if free else self.contact(q) for q, free in zip(configurations, certain.tolist(), strict=True)]

    def within(self, q: Floats) -> bool:
        """Return whether joints and actuators are within their limits at q, (k,) or (m, k)."""
        query, turned = self._query, q @ self._query.ratios.T
        inside = ((query.lower <= q) & (q <= query.upper)).all()
        return bool(inside and ((query.least <= turned) & (turned <= query.most)).all())

    def free(self, q: Floats) -> bool:
        """Return whether a configuration (k,) is within limits and touches nothing."""
        return self._are_free(q[None])

    def looks_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether configurations on a line are free, at most `step` (rad or m) apart, its begin left out."""
        count = max(1, int(np.ceil(np.abs(end - begin).max() / step)))
        # What collides does so for a while: places far apart find it soonest.
        order, stride = [], 1 << (count.bit_length() - 1)
        while stride:
            order += range(stride, count, 2 * stride)
            stride //= 2
        between = begin + (end - begin) * (np.array(order, np.float64) / count)[:, None]
        return self._are_free(np.concatenate([end[None], between]))

    def is_certain(self, begin: Floats, end: Floats, step: float, margin: float) -> bool:
        """Return whether `looks_free` is true without a doubt, and all is farther than `margin` (m) from touching."""
        self.checks += 1
        return self._certain.line(self._room, begin, end, step, margin)

    def connected(
        self, goals: Floats, step: float, margin: float, rng: np.random.Generator, go_on: Callable[[int], bool]
    ) -> Floats | None:
        """Return a way (n, k) to one of the goals (m, k), all certain at steps and by a margin (m); None: none.

        Two trees grow towards each other (`numeric.connecting`); `go_on` is told their size, and returns whether to.
        """
        query, k, seen = self._query, goals.shape[1], np.zeros(2, np.int64)
        trees, parents = np.empty((2, TREE, k)), np.full((2, TREE), -1)
        trees[0, 0], trees[1, : len(goals)] = self.start, goals
        sizes, ends = np.array([1, len(goals)]), np.zeros(2, np.int64)
        reach = REACH * float(np.linalg.norm(query.upper - query.lower))
        for _ in range(BATCHES):
            samples, before = rng.uniform(query.lower, query.upper, (BATCH, k)), int(seen[1])
            found = self._certain.meet(self._room, samples, reach, step, margin, trees, parents, sizes, ends, seen)
            self.checks += int(seen[1]) - before
            if not go_on(int(sizes.sum())):
                return None
            if found:
                ways = [trees[side, _up(parents[side], ends[side])] for side in range(2)]
                return np.concatenate([ways[0][::-1], ways[1][1:]])
        return None

    def _are_free(self, configurations: Floats) -> bool:
        """Return whether configurations (m, k) are within limits and touch nothing."""
        if not self.within(configurations):
            return False
        certain = self._certain.places(configurations)
        self.checks += int(certain.sum())
        return not any(self.contact(q) for q in configurations[~certain])

    def is_free(self, begin: Floats, end: Floats, step: float) -> bool:
        """Return whether a line is free: proven, after a look at places on it, which refutes most lines sooner."""
        return self.looks_free(begin, end, step) and self.meets(begin, end) is None

    def meets(self, begin: Floats, end: Floats) -> SweptContact | None:
        """Return the first contact on the straight line between configurations (k,): proven, not sampled.

        Its begin is free: what is not inside of something gets there only through its surface.
        """
        return self.first_on(joint_line(begin, end))

    def meets_program(self, program: Program, index: NDArray[np.int32], proven: Floats) -> SweptContact | None:
        """Return the first contact of a program from the start, whose columns are at `index` in q: proven.

        The lines between `proven` (n, k) are free, so only what leaves them is looked at.
        """
        for begin, stage in zip(program.begins, program.stages, strict=False):
            if stage.plan is None:
                continue
            assert np.array_equal(index[list(stage.columns)], self._query.q_index), "it moves the arm's joints alone"
            (track,) = stage.plan.tracks
            contacts = (self.first_on(track.path, stretch) for stretch in off_lines(track.path, proven))
            contact = next(filter(None, contacts), None)
            if contact is not None:
                return replace(contact, time=begin + nominal_time(track.time_law, contact.time, 0.0))
        return None

    def first_on(self, path: PiecewisePolynomial, stretch: tuple[float, float] | None = None) -> SweptContact | None:
        """Return the first contact on a path of the arm's joints, or on a stretch of it, by its parameter: proven.

        Its begin is free.
        """
        self.checks += 1
        way = of_path(self._snapshot.state.q, self._query.q_index, path)
        way = replace(way, begin=stretch[0], end=stretch[1]) if stretch else way
        for begin, end in self._certain.doubts(way, 0.5 * RESOLUTION):
            contact = first_contact(
                self._scene,
                self._snapshot,
                replace(way, begin=begin, end=end, pieces=()),
                robots=self._robots,
                given_up=self._given_up,
            )
            if contact is not None:
                return contact
        return None


def off_lines(path: PiecewisePolynomial, waypoints: Floats) -> list[tuple[float, float]]:
    """Return the stretches of a path, by its parameter, that are not on the lines between waypoints (n, k)."""
    found: list[tuple[float, float]] = []
    way, breaks = np.diff(waypoints, axis=0), path.breaks.tolist()
    apart = path.evaluate(path.breaks)[:, None] - waypoints[:-1]
    share = np.clip((apart * way).sum(axis=2) / (way**2).sum(axis=1), 0.0, 1.0)
    on_line = np.abs(apart - share[:, :, None] * way).max(axis=2) < ON_LINE
    straight = ~path.coefficients[:, 2:].any(axis=(1, 2)) & (on_line[:-1] & on_line[1:]).any(axis=1)
    for row in np.flatnonzero(~straight).tolist():
        begin = found.pop()[0] if found and found[-1][1] == breaks[row] else breaks[row]
        found.append((begin, breaks[row + 1]))
    return found


def _up(parents: NDArray[np.int64], row: int) -> list[int]:
    """Return the rows of a tree from one to where it begins."""
    rows = [int(row)]
    while parents[rows[-1]] >= 0:
        rows.append(int(parents[rows[-1]]))
    return rows
