"""From the question for a path to its answer; runs in a process of its own, as a job of `collision/processes.py`."""

from __future__ import annotations

import time
from functools import partial
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.scene import CollisionScene
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.paths.program import free_program
from virtualrobot_kernel.paths.query import PathQuery
from virtualrobot_kernel.paths.search import BETTER, DEFAULT, check_planner, library, search
from virtualrobot_kernel.paths.shorter import distinct, length_of, shortened
from virtualrobot_kernel.paths.space import PathSpace
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]

STEPS = (0.1, 0.025, 0.00625)
"""How far apart configurations are checked while a path is looked for, in rad or m: where the path that was found turns
out not to be free in between, it is looked for again with the next one."""


SEARCHING = 0.6
"""The part of the time in which a planner that never ends by itself searches; the rest is for shortening."""


class Site(Protocol):
    """What a job is given (`collision/site.py`): the world with the robot at the start, and a scene of it."""

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

    The straight way to the first goal is the path when it is free. Otherwise one is searched to any of the goals with
    checks at steps, proven or searched again with smaller ones, and shortened by proven shortcuts. Then zones are found
    with which the planned motion is proven free as a whole.

    Raises KernelError: COLLISION when the start or all goals touch something, UNREACHABLE when no path was found in
    time, WRONG_STATE where ompl is missing.
    """
    started = time.monotonic()
    space = PathSpace(site.scene, site.snapshot, query, site.given_up)
    planner = check_planner(query.planner)
    library()
    found, states = _free_way(site, space, query, planner, started + query.time_limit)
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
        "planner": planner,
    }


def _free_way(site: Site, space: PathSpace, query: PathQuery, planner: str, end: float) -> tuple[Floats, int | None]:
    """Return free waypoints (n, k), and how many configurations the search had; None: the straight way is free."""
    start = space.start
    if (pair := space.contact(start)) is not None:
        raise _collision(site.snapshot, query, "at the start of the path", pair)
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
    if free[0] == 0 and space.is_free(start, first, STEPS[0]):
        return np.stack([start, first]), None
    return _searched(site, space, query, planner, query.goals[free], end)


def _searched(
    site: Site, space: PathSpace, query: PathQuery, planner: str, goals: Floats, end: float
) -> tuple[Floats, int]:
    """Return free waypoints (n, k) that a search found, and how many configurations it had."""
    states = [0]

    def go_on(count: int) -> bool:
        states[0] = count
        site.told((count, space.checks))
        return not site.given_up()

    for step in STEPS:
        seconds = (end - time.monotonic()) * (SEARCHING if planner in BETTER else 1.0)
        if seconds <= 0.0:
            break
        # OMPL takes 0 for no seed.
        found = search(space, (query.lower, query.upper), goals, planner, query.seed + 1, seconds, step, go_on)
        site.go_on()
        if found.waypoints is None and planner in BETTER:
            # It had but a part of the time: the planner that is soonest there has the rest.
            seconds = end - time.monotonic()
            found = search(space, (query.lower, query.upper), goals, DEFAULT, query.seed + 1, seconds, step, go_on)
            site.go_on()
        if found.waypoints is None:
            break
        path = distinct(found.waypoints)
        if all(space.meets(*ends) is None for ends in pairwise(path)):
            rng = np.random.default_rng(query.seed)
            in_time = partial(_before, end)
            return shortened(path, partial(space.is_free, step=step), rng, in_time), found.states
    raise KernelError(
        f"no path of {query.robot!r} to the goal was found in {query.time_limit:g} s, which does not say that there is "
        f"none; {planner} has tried {states[0]} configurations; give more time, another seed or another planner",
        reason=Reason.UNREACHABLE,
        robot=query.robot,
        time_limit_seconds=query.time_limit,
        states=states[0],
    )


def _before(end: float) -> bool:
    return time.monotonic() < end


def _collision(snapshot: Snapshot, query: PathQuery, where: str, pair: Pair) -> KernelError:
    first, second = (snapshot.structure.nodes[uid].name for uid in pair)
    return KernelError(
        f"{where} {query.robot!r} is in collision: {first!r} touches {second!r}",
        reason=Reason.COLLISION,
        robot=query.robot,
        first=first,
        second=second,
    )
