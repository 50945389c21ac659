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
from virtualrobot_kernel.motion.free_path import FreePath, within_hull
from virtualrobot_kernel.motion.path import smooth_path
from virtualrobot_kernel.motion.planned import Track
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, stacked, with_columns
from virtualrobot_kernel.motion.profile import jerk_limited_profile
from virtualrobot_kernel.paths.find import Site
from virtualrobot_kernel.paths.led_path import LedPath
from virtualrobot_kernel.paths.together import block_steep, members_of, steep, too_steep, unreached
from virtualrobot_kernel.paths.tool_grid import Ladder
from virtualrobot_kernel.paths.tool_query import ToolPathQuery
from virtualrobot_kernel.paths.tool_reasons import Places, no_way
from virtualrobot_kernel.planning.planned_move import JERK_RATIO

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

ROUNDING = 1e-9
"""Slope (rad) beyond the greatest one that is rounding."""

TRIES = 8
"""Number of searches of a partner for what those before it do, before that is looked for anew."""

OWN, HELD = slice(6), slice(6, None)
"""Free values that are the tool's, and those that are joints'."""

_RETRIED = Reason.LIMIT_EXCEEDED, Reason.SINGULARITY, Reason.UNREACHABLE, Reason.COLLISION


def find_tool_path(site: Site, query: ToolPathQuery) -> dict[str, Any]:
    """Return a way along a tool path: the entries of `FoundToolPath` by name, as plain data, and `trajectory`.

    Raises KernelError with the place, the frame and the joint where there is none: UNREACHABLE, LIMIT_EXCEEDED, also
    where the tool's speed can't be kept, SINGULARITY or COLLISION.
    """
    started = time.monotonic()
    search = _Whole(site, query)
    found = search.found(started + query.time_limit)
    return {**found, "searches": search.searches, "checks": search.checks, "seconds": time.monotonic() - started}


class _Whole:
    """Search of all arms together: what one is led by is what all others are."""

    def __init__(self, site: Site, query: ToolPathQuery) -> None:
        self.site, self.query, self.searches = site, query, 0
        self.members = members_of(site, query)
        leader = self.members[0]
        self.rate = query.velocity / leader.frames.length
        self.acceleration = min(
            one.query.acceleration * leader.frames.length / one.frames.length for one in self.members
        )
        self.ramp(self.acceleration)
        self.end = np.inf

    @property
    def checks(self) -> int:
        """Number of configurations and ways that were checked."""
        return sum(one.space.checks for one in self.members)

    def found(self, end: float) -> dict[str, Any]:
        """Return what is found until a time of the clock."""
        self.end = end
        return _Search(self, 0).found()

    def tell(self) -> None:
        """Tell how far it is; raises when nobody waits any more."""
        self.site.go_on()
        self.site.told((self.searches, self.checks))

    def ramp(self, acceleration: float) -> PiecewisePolynomial:
        """Return the law with an acceleration in m/s²; raise LimitError where it never has the speed."""
        length, velocity = self.members[0].frames.length, self.query.velocity
        law = jerk_limited_profile(1.0, self.rate, acceleration / length, JERK_RATIO * acceleration / length)
        reached = float(law.evaluate(law.breaks, 1).max()) * length
        if reached < (1.0 - 1e-6) * velocity:
            raise LimitError(
                f"the tool path of {1e3 * length:.4g} mm is too short for {velocity:g} m/s: with {acceleration:.4g} "
                f"m/s^2 the tool reaches {reached:.3g} m/s; go slower or accelerate more",
                robot=self.query.robot,
                value=velocity,
                limit=reached,
            )
        return law


class _Search:
    """Search for one arm, with what it has learnt so far; those of its partners are searched within it, one by one."""

    def __init__(
        self,
        whole: _Whole,
        level: int,
        before: PiecewisePolynomial | None = None,
        carried: PiecewisePolynomial | None = None,
        paths: tuple[FreePath, ...] = (),
    ) -> None:
        """Take the place of the arm among all, and by u what those before it do: joints, external axes, tools."""
        self._whole, self._level, self._member = whole, level, whole.members[level]
        self._before, self._carried, self._paths = before, carried, paths
        self._query, self._arm, self._frames = self._member.query, self._member.arm, self._member.frames
        self._ladder = Ladder(
            self._query,
            self._frames,
            self._arm,
            self._member.limits.velocity,
            None if carried is None else carried.evaluate,
        )
        self._places = Places(self._query.robot, self._frames, self._ladder.rungs)
        self._looked_at = np.zeros_like(self._ladder.blocked)
        self._touching: dict[int, Pair] = {}
        self._failed: dict[int, KernelError] = {}
        self._failures: Counter[int] = Counter()
        if level == 0:
            self._failed |= block_steep(whole.site.snapshot, whole.members, self._ladder)
            for partner in whole.members[1:]:
                self._failed |= unreached(partner, self._ladder)

    def found(self) -> dict[str, Any]:
        """Return what is found; raises KernelError where there is nothing, or nothing in time."""
        tries = 0
        while True:
            self._whole.tell()
            self._whole.searches += 1
            tries += 1
            reached, way, joints = self._ladder.searched()
            if reached < len(way):
                structure = self._whole.site.snapshot.structure
                names = {rung: names_of(pair, structure) for rung, pair in self._touching.items()}
                raise no_way(self._places, self._ladder, self._member.limits, reached, names, self._failed)
            failed = None
            if not self._touches(way, joints):
                for places, freedoms in self._smoothed(way, joints):
                    self._whole.tell()
                    try:
                        return self._motion(within_hull(places, freedoms), way, joints)
                    except KernelError as error:
                        if error.reason not in _RETRIED:
                            raise
                        failed = error
                        if time.monotonic() > self._whole.end:
                            break
                assert failed is not None
                self._block(way, failed)
            if time.monotonic() > self._whole.end:
                why = f"; the last one ended so: {failed}" if failed else ""
                raise KernelError(
                    f"no way of {self._query.robot!r} along the tool path was found in "
                    f"{self._whole.query.time_limit:g} s and {self._whole.searches} searches, which does not say that "
                    f"there is none; give more time or a wider tolerance{why}",
                    reason=Reason.UNREACHABLE,
                    **{
                        **(failed.metadata if failed else {}),
                        "robot": self._query.robot,
                        "searches": self._whole.searches,
                    },
                )
            if failed is not None and self._level and tries >= TRIES:
                raise failed

    def _smoothed(self, way: Integers, joints: Floats) -> Iterator[tuple[Floats, Floats]]:
        """Yield places (m,) and free values (m + 2, f) of a way there, those that are likeliest to do first."""
        for stiffness in STIFFNESS[:2]:
            yield self._ladder.rungs, self._ladder.smoothed(way, stiffness)
        places, found, share = self._ladder.eased(way, joints, self._member.limits.acceleration / self._whole.rate**2)
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
            self._whole.site.go_on()
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
        if self._before is not None:
            q = np.concatenate([self._before.evaluate(self._ladder.rungs[rungs]), q[:, : self._member.own]], axis=1)
        pairs = self._member.space.contacts(q)
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
        carried = self._carried
        if carried is None:
            carried = PiecewisePolynomial(held.breaks, held.coefficients[:, :, self._arm.held is not None :])
        else:
            held = with_columns(held, range(held.dimension - carried.dimension, held.dimension), carried)
        if self._level == 0:
            self._check_slopes(carried)
        led = LedPath(self._arm, self._query.tip_t_tcp, path, held, int(way[0, 1]), self._places)
        followed = led.joints(joints[0], self._member.limits)
        if self._before is not None:
            mine = PiecewisePolynomial(followed.breaks, followed.coefficients[:, :, : self._member.own])
            followed = stacked([self._before, mine])
        law = self._law(followed)
        paths = (*self._paths, path)
        if self._level + 1 < len(self._whole.members):
            self._check_free(followed, None)
            return _Search(self._whole, self._level + 1, followed, carried, paths).found()
        times, positions, velocities = _rows(followed, law)
        timed = smooth_path(times, positions, velocities)
        self._check_free(timed, law)
        rate = self._whole.rate
        kept = law.breaks[np.flatnonzero(law.evaluate(law.breaks, 1)[:, 0] > (1.0 - 1e-6) * rate)[[0, -1]]]
        found = [
            {
                "times": passed,
                "positions": timed.evaluate(passed),
                "freedoms": one.freedoms.evaluate(one.frames.frames),
                "length": one.length,
                "velocity": rate * one.length,
            }
            for one in paths
            for passed in (_times_at(law, one.frames.frames),)
        ]
        return {
            **found[0],
            "held": tuple(kept.tolist()),
            "duration": law.end,
            "trajectory": (times, positions, velocities),
            "partners": found[1:],
        }

    def _check_slopes(self, carried: PiecewisePolynomial) -> None:
        """Raise KernelError with the fraction where external axes, by u, let frames slope more than they may."""
        rungs = self._ladder.rungs
        for member in self._whole.members:
            if member.query.slope:
                over = too_steep(self._whole.site.snapshot, member, rungs, carried.evaluate(rungs))
                at = int(over.argmax())
                if over[at] > ROUNDING:
                    told = Places(member.query.robot, member.frames, rungs)
                    raise steep(told, float(rungs[at]), float(over[at]), member.query.slope)

    def _law(self, followed: PiecewisePolynomial) -> PiecewisePolynomial:
        """Return the law along a joint path that keeps the tool's speed; raise LimitError where joints can't."""
        every = self._member.all_limits
        rates = followed.derivative()
        bends = rates.derivative()
        for function, power, limits, what, unit in (
            (rates, 1, every.velocity, "speed", "/s"),
            (bends, 2, every.acceleration, "acceleration", "/s^2"),
        ):
            bound = limits / self._whole.rate**power
            excursion = function.first_excursion(-bound, bound, 0.0)
            if excursion is not None:
                needed, limit = abs(excursion.value) * self._whole.rate**power, float(limits[excursion.component])
                kept = self._query.velocity * (limit / needed) ** (1.0 / power)
                turns = every.names[excursion.component] not in every.sliding
                raise self._places.error(
                    excursion.parameter,
                    f"joint {every.names[excursion.component]!r} can't keep the tool's speed of "
                    f"{self._query.velocity:g} m/s: it would need {what} {needed:.4g} "
                    f"{'rad' if turns else 'm'}{unit}, its limit is {limit:.4g}; it could keep {kept:.3g} m/s",
                    Reason.LIMIT_EXCEEDED,
                    joint=every.names[excursion.component],
                    value=needed,
                    limit=limit,
                )
        acceleration, most = self._whole.acceleration, every.acceleration
        for _ in range(RAMPS):
            law = self._whole.ramp(acceleration)
            track = Track(followed, law)
            times = track.grid(1000)
            over = np.abs(track.derivatives(times)[2]) / most
            if over.max() <= 1.0:
                return law
            acceleration *= 0.5
        row, joint = np.unravel_index(over.argmax(), over.shape)
        raise self._places.error(
            float(law.evaluate(times[row])[0]),
            f"joint {every.names[joint]!r} can't accelerate so that the tool has its speed there",
            Reason.LIMIT_EXCEEDED,
            joint=every.names[joint],
            value=float(over.max() * most[joint]),
            limit=float(most[joint]),
        )

    def _check_free(self, path: PiecewisePolynomial, law: PiecewisePolynomial | None) -> None:
        """Raise KernelError with the fraction where a path touches, or an actuator is beyond its limits.

        Its parameter is time by a law, or the fraction itself.
        """
        space, every = self._member.space, self._member.all_limits

        def fraction(at: float) -> float:
            return at if law is None else float(law.evaluate(at)[0])

        rows = np.clip(path.evaluate(path.breaks), every.lower, every.upper)
        if not space.within(rows):
            beyond = next(row for row, q in enumerate(rows) if not space.within(q))
            why = "an actuator would be beyond its limits"
            raise self._places.error(fraction(float(path.breaks[beyond])), why, Reason.LIMIT_EXCEEDED)
        contact = space.first_on(path)
        if contact is not None:
            first, second = names_of((contact.first, contact.second), self._whole.site.snapshot.structure)
            why = f"{first!r} would touch {second!r}"
            raise self._places.error(fraction(contact.time), why, Reason.COLLISION, first=first, second=second)


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
