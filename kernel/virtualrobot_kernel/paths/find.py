"""Path search, from query to answer; runs in a process of its own, as a job of `collision/processes.py`."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from math import inf
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.node_pairs import names_of
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.paths.program import free_program
from virtualrobot_kernel.paths.query import PathQuery
from virtualrobot_kernel.paths.search import BETTER, DEFAULT, FIRST, library, search
from virtualrobot_kernel.paths.shorter import distinct, length_of, shortened, straightened
from virtualrobot_kernel.paths.space import PathSpace
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

STEPS = ((0.1, False), (0.025, False), (0.1, True))
"""Spacing of the checked places on lines while a path is searched, in rad or m, and whether lines are proven then.
Looking is much quicker: where what it found turns out not to be free, it is searched again by the next ones."""

LOOKS = 0.05
"""Spacing of the checked places on shortcuts, in rad or m."""

CERTAIN_STEPS = (0.1, 4e-3), (0.025, 1e-3)
"""The same where balls alone are asked, and how far (m) all is to be from touching there: what goes by more closely is
seldom free between the places. All of it is proven in the end, and searched again where it is not free."""

CERTAIN_SEARCHES = 5
"""Number of such searches, which take a few milliseconds each; the shortest path that is free counts."""

HOPELESS = 2.0
"""Length of a path, as a multiple of the shortest one's so far, from which on it isn't shortened: that takes longer
than finding it, and seldom halves one that goes on to the farthest waypoint in sight already."""

SEARCHES = 3
"""Number of searches of a planner that ends with the first path; the shortest path counts."""

GOOD = 1.3
"""Greatest length of a path that is good enough, as a multiple of the straight way to the nearest goal."""

SEARCHING = 0.6
"""Share of the time in which a planner that never ends by itself searches; the rest is for shortening."""


class Site(Protocol):
    """Site of a job (`collision/site.py`): the world with the robot at the start, and a scene of it."""

    snapshot: Snapshot
    scene: CollisionScene

    def told(self, value: object) -> None:
        """Report how far it is: (configurations in the tree, checks)."""
        ...

    def given_up(self) -> bool:
        """Return whether nobody waits any more."""
        ...

    def go_on(self) -> None:
        """Raise when nobody waits any more."""
        ...


def find_path(site: Site, query: PathQuery) -> dict[str, Any]:
    """Return a free path: the entries of `FoundPath` by name, as plain data.

    The straight way to the first goal is the path when it is free. Otherwise one is searched to any goal, by the
    default planner first where balls leave no doubt, with checks at steps, proven or searched again with smaller ones,
    and shortened by proven shortcuts. Then zones are found with which the planned motion is proven free as a whole.

    Raises KernelError: COLLISION when the start or all goals touch something, UNREACHABLE when no path was found in
    time, WRONG_STATE where ompl is missing.
    """
    started = time.monotonic()
    space = PathSpace(site.scene, site.snapshot, query, site.given_up)
    library()
    found, states = _free_way(site, space, query, query.planner, started + query.time_limit)
    motion = free_program(space, site.snapshot, query, found, site.go_on)
    return {
        "waypoints": found,
        "straight": states is None,
        "length": length_of(found),
        "straight_length": float(np.linalg.norm(query.goals[0] - space.start)),
        "zones": motion.zones,
        "duration": motion.duration,
        "seconds": time.monotonic() - started,
        "checks": space.checks,
        "states": states or 0,
        "planner": query.planner,
    }


def _free_way(site: Site, space: PathSpace, query: PathQuery, planner: str, end: float) -> tuple[Floats, int | None]:
    """Return free waypoints (n, k), and how many configurations the search had; None: the straight way is free."""
    start = space.start
    if (pair := space.contact(start)) is not None:
        raise _collision(site.snapshot, query, "at the start of the path", pair)
    if not space.within(start):
        raise KernelError(f"an actuator of {query.robot!r} is beyond its limits at the start", robot=query.robot)
    free: list[int] = []
    touching: list[Pair] = []
    for place, goal in enumerate(query.goals):
        site.go_on()
        pair = space.contact(goal)
        if pair is not None:
            touching.append(pair)
        elif space.within(goal):
            free.append(place)
    if not free and not touching:
        raise KernelError(f"an actuator of {query.robot!r} would be beyond its limits at the goal", robot=query.robot)
    if not free:
        raise _collision(site.snapshot, query, "at the goal of the path", touching[0])
    first = query.goals[0]
    if free[0] == 0 and space.is_free(start, first, STEPS[0][0]):
        return np.stack([start, first]), None
    return _searched(site, space, query, planner, query.goals[free], end)


def _searched(
    site: Site, space: PathSpace, query: PathQuery, planner: str, goals: Floats, end: float
) -> tuple[Floats, int]:
    """Return free waypoints (n, k) that a search found, and how many configurations all searches had."""
    nearest = float(np.linalg.norm(goals - space.start, axis=1).min())
    task = _Task(site, space, query, goals, end)
    best = task.connected(GOOD * nearest) if planner == DEFAULT else None
    for _ in range(0 if best is not None else SEARCHES if planner in FIRST else 1):
        path = task.path(planner)
        if path is not None and (best is None or length_of(path) < length_of(best)):
            best = path
        if path is None or length_of(path) <= GOOD * nearest:
            break
    if best is not None:
        return best, task.states
    raise KernelError(
        f"no path of {query.robot!r} to the goal was found in {query.time_limit:g} s, which does not say that there is "
        f"none; {planner} has tried {task.states} configurations; give more time, another seed or another planner",
        reason=Reason.UNREACHABLE,
        robot=query.robot,
        time_limit_seconds=query.time_limit,
        states=task.states,
    )


class _Task:
    """Search task with all that it needs; `end` is when its time is over, `states` how many configurations it had."""

    def __init__(self, site: Site, space: PathSpace, query: PathQuery, goals: Floats, end: float) -> None:
        self.site, self.space, self.query, self.goals, self.end = site, space, query, goals, end
        self.rng, self.states, self._before = np.random.default_rng(query.seed), 0, 0

    def connected(self, good: float) -> Floats | None:
        """Return a proven path (n, k) through what is certainly free at steps, the shortest of some; None without one.

        good: the length that is short enough.
        """
        for step, margin in CERTAIN_STEPS:
            certain = partial(self.space.is_certain, step=LOOKS, margin=margin)
            paths: list[Floats] = []
            for _ in range(CERTAIN_SEARCHES):
                found = self.space.connected(self.goals, step, margin, self.rng, self._in_time_with)
                self._before = self.states
                self.site.go_on()
                if found is None:
                    break
                path = straightened(distinct(found), certain, self._in_time)
                if length_of(path) < HOPELESS * min(map(length_of, paths), default=inf):
                    path = shortened(path, certain, self.rng, self._in_time)
                paths.append(path)
                if length_of(path) <= good:
                    break
            for path in sorted(paths, key=length_of):
                if self._is_proven(path):
                    return path
            if not paths:
                break
        return None

    def path(self, planner: str) -> Floats | None:
        """Return a proven path (n, k) that is shortened; None when the time was over before."""
        space, seed = self.space, int(self.rng.integers(1, 2**32))
        for step, proven in STEPS:
            line_is_free = partial(space.is_free if proven else space.looks_free, step=step)
            found = self._found(line_is_free, planner, seed, SEARCHING if planner in BETTER else 1.0)
            if found is None and planner in BETTER:
                # It had but a part of the time: the planner that is soonest there has the rest.
                found = self._found(line_is_free, DEFAULT, seed, 1.0)
            if found is None:
                return None
            path = distinct(found)
            if proven or self._is_proven(path):
                return self._shortened(path)
        return None

    def _found(
        self, line_is_free: Callable[[Floats, Floats], bool], planner: str, seed: int, share: float
    ) -> Floats | None:
        bounds, seconds = (self.query.lower, self.query.upper), share * (self.end - time.monotonic())
        found = search(
            *(self.space, bounds, self.goals, line_is_free),
            planner=planner,
            seed=seed,
            seconds=seconds,
            go_on=self._go_on,
        )
        self._before = self.states
        self.site.go_on()
        return found

    def _shortened(self, path: Floats) -> Floats:
        """Return a path shortened by lines that look free, if these can be proven, or by proven ones."""
        state = self.rng.bit_generator.state
        shorter = shortened(path, partial(self.space.looks_free, step=LOOKS), self.rng, self._in_time)
        if self._is_proven(shorter):
            return shorter
        self.rng.bit_generator.state = state
        return shortened(path, partial(self.space.is_free, step=LOOKS), self.rng, self._in_time)

    def _is_proven(self, path: Floats) -> bool:
        return all(self.space.meets(*ends) is None for ends in pairwise(path))

    def _go_on(self, count: int) -> bool:
        """Tell how far it is, with so many configurations in a search's trees; return whether somebody waits."""
        self.states = self._before + count
        self.site.told((self.states, self.space.checks))
        return not self.site.given_up()

    def _in_time_with(self, count: int) -> bool:
        return self._go_on(count) and self._in_time()

    def _in_time(self) -> bool:
        return time.monotonic() < self.end and not self.site.given_up()


def _collision(snapshot: Snapshot, query: PathQuery, where: str, pair: Pair) -> KernelError:
    first, second = names_of(pair, snapshot.structure)
    touches = f"is nearer to {second!r} than {query.clearance:g} m" if query.clearance else f"touches {second!r}"
    return KernelError(
        f"{where} {query.robot!r} is in collision: {first!r} {touches}",
        reason=Reason.COLLISION,
        robot=query.robot,
        first=first,
        second=second,
    )
