"""Search of a way along a tool path, from query to answer; runs in a process of its own, as a job.

A ladder gives the cheapest postures on rungs; its free values are smoothed, the arm follows what they make of the path,
a law keeps the tool's speed, and the trajectory is proven to touch nothing. Where one of that can't be, what has led
there is blocked, and the ladder is searched again (as lazy searches do: C. Dellin, S. Srinivasa, A unifying formalism
for shortest path problems with expensive edge evaluations, ICAPS 2016).
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.allowed import Pair
from virtualrobot_kernel.collision.node_pairs import names_of
from virtualrobot_kernel.errors import KernelError, LimitError, Reason
from virtualrobot_kernel.motion.free_path import FreePath, frame_path, within_hull
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.motion.spline import spline
from virtualrobot_kernel.paths.carriers import carriers_of, limits_with
from virtualrobot_kernel.paths.closed_forms import led_arm
from virtualrobot_kernel.paths.find import Site
from virtualrobot_kernel.paths.led_path import LedPath
from virtualrobot_kernel.paths.space import PathSpace
from virtualrobot_kernel.paths.tool_grid import Ladder
from virtualrobot_kernel.paths.tool_query import ToolPathQuery
from virtualrobot_kernel.paths.tool_reasons import Places, no_way
from virtualrobot_kernel.planning.planned_move import JERK_RATIO, joint_limits
from virtualrobot_kernel.planning.robots import arm_of
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

JOB = f"{__name__}:find_tool_path"
"""Name of the search as a job. The kernel gets it from here, so that it compiles the ladder at its start."""

STIFFNESS = 1e6, 1e3, 10.0, 0.0
"""Weights of the squared third differences of free values against the squares of how far they are off those found, one
after the other where what a stiffer one makes can't be done. The first one halves waves of 60 rungs: a value that goes
evenly, as round a circle, beats with the steps of the grid in waves that are too long for the second one."""

RAMPS = 6
"""Number of times that the acceleration to the tool's speed is halved where joints can't follow it."""

EXACT = 1e-7
"""Greatest difference of a joint between two rows of the trajectory from the path (rad)."""

WIDEST = 4
"""Greatest number of rungs and of steps of free values that are blocked around what failed often."""

OWN, HELD = slice(6), slice(6, None)
"""Free values that are the tool's, and those that are joints'."""

_RETRIED = Reason.LIMIT_EXCEEDED, Reason.SINGULARITY, Reason.UNREACHABLE, Reason.COLLISION


def find_tool_path(site: Site, query: ToolPathQuery) -> dict[str, Any]:
    """Return a way along a tool path: the entries of `FoundToolPath` by name, as plain data, and `trajectory`.

    Raises KernelError with the place, the frame and the joint where there is none: UNREACHABLE, LIMIT_EXCEEDED, also
    where the tool's speed can't be kept, SINGULARITY or COLLISION.
    """
    started = time.monotonic()
    search = _Search(site, query)
    found = search.found(started + query.time_limit)
    return {**found, "searches": search.searches, "checks": search.space.checks, "seconds": time.monotonic() - started}


class _Search:
    """One search, with what it has learnt so far."""

    def __init__(self, site: Site, query: ToolPathQuery) -> None:
        self._site, self._query, self.searches = site, query, 0
        snapshot = site.snapshot
        node = snapshot.structure.node(query.robot, Kind.ROBOT)
        chain = arm_of(snapshot, node, query.group).serial()
        self._limits = limits_with(joint_limits(snapshot, node, query.joint_names)[0], query.externals)
        self._arm = led_arm(chain, carriers_of(snapshot, query.base, query.reference, query.externals))
        self._frames = frame_path(spline(query.frames[0], list(query.frames[1:])))
        self._rate = query.velocity / self._frames.length
        self._ramp(query.acceleration)
        self._ladder = Ladder(query, self._frames, self._arm, self._limits.velocity)
        self._places = Places(query.robot, self._frames, self._ladder.rungs)
        self.space = PathSpace(site.scene, snapshot, query, site.given_up)
        self._looked_at = np.zeros_like(self._ladder.blocked)
        self._touching: dict[int, Pair] = {}
        self._failed: dict[int, KernelError] = {}
        self._failures: Counter[int] = Counter()

    def found(self, end: float) -> dict[str, Any]:
        """Return what is found until a time of the clock."""
        while True:
            self._site.go_on()
            self.searches += 1
            self._site.told((self.searches, self.space.checks))
            reached, way, joints = self._ladder.searched()
            if reached < len(way):
                names = {rung: names_of(pair, self._site.snapshot.structure) for rung, pair in self._touching.items()}
                raise no_way(self._places, self._ladder, self._limits, reached, names, self._failed)
            failed = None
            if not self._touches(way, joints):
                for places, freedoms in self._smoothed(way, joints):
                    self._site.go_on()
                    self._site.told((self.searches, self.space.checks))
                    try:
                        return self._motion(within_hull(places, freedoms), way, joints)
                    except KernelError as error:
                        if error.reason not in _RETRIED:
                            raise
                        failed = error
                assert failed is not None
                self._block(way, failed)
            if time.monotonic() > end:
                why = f"; the last one ended so: {failed}" if failed else ""
                raise KernelError(
                    f"no way of {self._query.robot!r} along the tool path was found in {self._query.time_limit:g} s "
                    f"and {self.searches} searches, which does not say that there is none; give more time or a wider "
                    f"tolerance{why}",
                    reason=Reason.UNREACHABLE,
                    robot=self._query.robot,
                    searches=self.searches,
                )

    def _smoothed(self, way: Integers, joints: Floats) -> Iterator[tuple[Floats, Floats]]:
        """Yield places (m,) and free values (m + 2, f) of a way there, those that are likeliest to do first."""
        for stiffness in STIFFNESS[:2]:
            yield self._ladder.rungs, self._ladder.smoothed(way, stiffness)
        places, found, share = self._ladder.eased(way, joints, self._limits.acceleration / self._rate**2)
        if share < 1.0:
            yield places, found
        for stiffness in STIFFNESS[2:]:
            yield self._ladder.rungs, self._ladder.smoothed(way, stiffness)

    def _touches(self, way: Integers, joints: Floats) -> bool:
        """Return whether postures of a way touch anything; those that do are blocked, and others like them."""
        combinations, branches = way.T
        asked = np.flatnonzero(self._looked_at[np.arange(len(way)), combinations, branches] == 0)
        pairs = self._contacts(asked, combinations[asked], branches[asked], joints[asked])
        touching = [pair is not None for pair in pairs]
        rungs = asked[touching]
        # A branch that is blocked on one rung is so as a whole: few rungs tell.
        for rung in np.unique(rungs[[0, len(rungs) // 2, -1]]).tolist() if len(rungs) else ():
            self._spread(rung, *way[rung].tolist())
        return any(touching)

    def _spread(self, rung: int, combination: int, branch: int) -> None:
        """Block what touches around a posture of a branch that does, farther and farther until something is free."""
        reach, count = 0, 1
        while True:
            self._site.go_on()
            reach = 2 * reach + 1
            around = self._ladder.around(combination, reach)
            postures = self._ladder.q[rung, around, branch]
            new = np.flatnonzero((self._looked_at[rung, around, branch] == 0) & np.isfinite(postures[:, 0]))
            rungs, branches = np.full(len(new), rung), np.full(len(new), branch)
            pairs = self._contacts(rungs, around[new], branches, postures[new])
            if None in pairs or len(around) == count:
                return
            count = len(around)

    def _contacts(self, rungs: Integers, combinations: Integers, branches: Integers, q: Floats) -> list[Pair | None]:
        """Return what touches at nodes (m,) whose postures are q (m, k), and block those where something does."""
        pairs = self.space.contacts(q)
        self._looked_at[rungs, combinations, branches] = 1
        touching = np.array([pair is not None for pair in pairs], np.bool_)
        self._ladder.blocked[rungs[touching], combinations[touching], branches[touching]] = 1
        self._touching |= {int(rung): pair for rung, pair in zip(rungs, pairs, strict=True) if pair is not None}
        return pairs

    def _block(self, way: Integers, error: KernelError) -> None:
        """Block what has led to a refusal, the more the oftener something near it was refused."""
        s = float(error.metadata.get("fraction", 0.0))
        rung = int(np.abs(self._ladder.rungs - s).argmin())
        reach = min(sum(self._failures[rung + aside] for aside in (-1, 0, 1)), WIDEST)
        self._failures[rung] += 1
        self._failed[rung] = error
        self._ladder.block(rung, int(way[rung, 0]), int(way[rung, 1]), reach)

    def _motion(self, freedoms: PiecewisePolynomial, way: Integers, joints: Floats) -> dict[str, Any]:
        """Return the motion along the path with free values (f,); raise KernelError with the fraction."""
        own, held = (PiecewisePolynomial(freedoms.breaks, freedoms.coefficients[:, :, one]) for one in (OWN, HELD))
        path = FreePath(self._frames.pose(0.0), self._frames, own)
        led = LedPath(self._arm, self._query.tip_t_tcp, path, held, int(way[0, 1]), self._places)
        followed = led.joints(joints[0], self._limits)
        law = self._law(followed)
        times, positions, velocities = _rows(followed, law)
        timed = smooth_path(times, positions, velocities)
        self._check_free(timed, law)
        held = law.breaks[np.flatnonzero(law.evaluate(law.breaks, 1)[:, 0] > (1.0 - 1e-6) * self._rate)[[0, -1]]]
        passed = _times_at(law, self._frames.frames)
        return {
            "times": passed,
            "positions": timed.evaluate(passed),
            "freedoms": path.freedoms.evaluate(self._frames.frames),
            "length": self._frames.length,
            "held": tuple(held.tolist()),
            "duration": law.end,
            "trajectory": (times, positions, velocities),
        }

    def _ramp(self, acceleration: float) -> PiecewisePolynomial:
        """Return the law with an acceleration in m/s²; raise LimitError where it never has the speed."""
        length, velocity = self._frames.length, self._query.velocity
        law = jerk_limited_profile(1.0, self._rate, acceleration / length, JERK_RATIO * acceleration / length)
        reached = float(law.evaluate(law.breaks, 1).max()) * length
        if reached < (1.0 - 1e-6) * velocity:
            raise LimitError(
                f"the tool path of {1e3 * length:.4g} mm is too short for {velocity:g} m/s: with {acceleration:.4g} "
                f"m/s^2 the tool reaches {reached:.3g} m/s; go slower or accelerate more",
                robot=self._query.robot,
                value=velocity,
                limit=reached,
            )
        return law

    def _law(self, followed: PiecewisePolynomial) -> PiecewisePolynomial:
        """Return the law along a joint path that keeps the tool's speed; raise LimitError where joints can't."""
        rates, bends = followed.derivative(), followed.derivative().derivative()
        for function, power, limits, what, unit in (
            (rates, 1, self._limits.velocity, "speed", "/s"),
            (bends, 2, self._limits.acceleration, "acceleration", "/s^2"),
        ):
            bound = limits / self._rate**power
            excursion = function.first_excursion(-bound, bound, 0.0)
            if excursion is not None:
                needed, limit = abs(excursion.value) * self._rate**power, float(limits[excursion.component])
                kept = self._query.velocity * (limit / needed) ** (1.0 / power)
                turns = self._arm.turns[excursion.component]
                raise self._places.error(
                    excursion.parameter,
                    f"joint {self._limits.names[excursion.component]!r} can't keep the tool's speed of "
                    f"{self._query.velocity:g} m/s: it would need {what} {needed:.4g} "
                    f"{'rad' if turns else 'm'}{unit}, its limit is {limit:.4g}; it could keep {kept:.3g} m/s",
                    Reason.LIMIT_EXCEEDED,
                    joint=self._limits.names[excursion.component],
                    value=needed,
                    limit=limit,
                )
        acceleration, most = self._query.acceleration, self._limits.acceleration
        for _ in range(RAMPS):
            law = self._ramp(acceleration)
            track = Track(followed, law)
            times = track.grid(1000)
            over = np.abs(track.derivatives(times)[2]) / most
            if over.max() <= 1.0:
                return law
            acceleration *= 0.5
        row, joint = np.unravel_index(over.argmax(), over.shape)
        raise self._places.error(
            float(law.evaluate(times[row])[0]),
            f"joint {self._limits.names[joint]!r} can't accelerate so that the tool has its speed there",
            Reason.LIMIT_EXCEEDED,
            joint=self._limits.names[joint],
            value=float(over.max() * most[joint]),
            limit=float(most[joint]),
        )

    def _check_free(self, timed: PiecewisePolynomial, law: PiecewisePolynomial) -> None:
        """Raise KernelError with the fraction where a trajectory touches, or an actuator is beyond its limits."""
        rows = np.clip(timed.evaluate(timed.breaks), self._query.lower, self._query.upper)
        if not self.space.within(rows):
            beyond = next(row for row, q in enumerate(rows) if not self.space.within(q))
            s = float(law.evaluate(timed.breaks[beyond])[0])
            raise self._places.error(s, "an actuator would be beyond its limits", Reason.LIMIT_EXCEEDED)
        contact = self.space.first_on(timed)
        if contact is not None:
            first, second = names_of((contact.first, contact.second), self._site.snapshot.structure)
            s = float(law.evaluate(contact.time)[0])
            raise self._places.error(
                s, f"{first!r} would touch {second!r}", Reason.COLLISION, first=first, second=second
            )


def _times_at(law: PiecewisePolynomial, places: Floats) -> Floats:
    """Return the times (n,) at which a law that never runs back is at places (n,)."""
    times = np.linspace(law.start, law.end, 4001)
    found = np.interp(places, law.evaluate(times)[:, 0], times)
    for _ in range(3):
        at, rate = law.states(found, 1)[:, :, 0]
        found = np.where(rate > 1e-6 * rate.max(), found - (at - places) / np.maximum(rate, 1e-300), found)
        found = np.clip(found, law.start, law.end)
    found[places <= 0.0], found[places >= 1.0] = law.start, law.end
    return found


def _rows(path: PiecewisePolynomial, law: PiecewisePolynomial) -> tuple[Floats, Floats, Floats]:
    """Return times (n,), positions and velocities (n, k) whose smooth trajectory is a path by its law, to `EXACT`."""
    track = Track(path, law)
    marks = np.unique(np.concatenate([law.breaks, _times_at(law, path.breaks)]))
    apart = np.diff(marks, prepend=-np.inf) > 1e-3 * law.end / len(marks)
    marks = np.append(marks[apart][:-1], law.end)
    while True:
        positions, velocities = track.derivatives(marks)[:2]
        velocities[[0, -1]] = 0.0
        timed = smooth_path(marks, positions, velocities)
        between = 0.5 * (marks[:-1] + marks[1:])
        off = np.abs(timed.evaluate(between) - track.derivatives(between)[0]).max(axis=1)
        if off.max() <= EXACT:
            return marks, positions, velocities
        marks = np.sort(np.concatenate([marks, between[off > EXACT]]))
