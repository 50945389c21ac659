"""Navigator: from what a vehicle sees to how it drives, one period after the other; each decision is told in words."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.navigation.following import (
    Choice,
    Limits,
    Surroundings,
    ahead_of,
    backwards,
    can_turn,
    choose,
    turning,
)
from virtualrobot_apps.seeing.navigation.footprint import Footprint
from virtualrobot_apps.seeing.navigation.planning import Costmap, GoalTakenError, NoWayError, Planner, length, spaced
from virtualrobot_apps.seeing.navigation.poses import Floats, between, distance, moved, wrapped
from virtualrobot_apps.seeing.navigation.regions import Distances
from virtualrobot_apps.seeing.navigation.scans import Scan
from virtualrobot_apps.seeing.navigation.sight import ALONE_METERS, SILENT_SECONDS, Sight, Where
from virtualrobot_apps.seeing.navigation.sonars import Heard, Sonar
from virtualrobot_apps.seeing.navigation.unforeseen import Unforeseen

REACHED_METERS, REACHED_RADIANS = 0.08, 0.06
"""Distances from its goal, and from the heading there, at which the vehicle has arrived."""
GIVE_UP_SECONDS = 10.0
"""Time without a scan, with a blind lidar, or without a way after which it gives up."""
PLAN_SECONDS = 1.0
"""Time from one plan to the next."""
PATIENCE_SECONDS = 6.0
"""Time without progress towards the goal after which it recovers."""
NEAR_METERS = 1.0
"""Distance from a goal on which something stands, up to which it goes on towards it."""
LOST_SECONDS, SEARCHES = 60.0, 3
"""Time for which a vehicle that is lost looks for its place, and how often it does on the way to one goal."""
RECOVERIES = 4
"""Number of recoveries, and of longer ways that are taken instead, on the way to one goal; then it gives up."""
OTHER_METERS, CHEAPER = 0.4, 0.8
"""Distance from the way that it is on, from which on a plan is another one, and its cost, in that way's, up to which
it is taken instead."""
OUTS, OUT_SECONDS, OUT_SPEED = 3, 25.0, 0.2
"""Number of times that it drives out to where it can turn on the way to one goal, for how long, and how fast (m/s)."""
SHARE_OF_ODOMETRY = 0.3
"""Part of the way by odometry that scans must confirm; with less the wheels slip."""


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Sight of a vehicle at a time (s): its pose (3,) by odometry, and a scan where a new one has come.

    sonars: ultrasonic sensors, each with the distance that it hears now (m), inf: none.
    """

    time: float
    odometry: Floats
    scan: Scan | None
    sonars: tuple[tuple[Sonar, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Goal:
    """Place (m) in the map, and the heading there (rad); None: any."""

    x: float
    y: float
    heading: float | None = None

    def __post_init__(self) -> None:
        """Raise InvalidArgumentError for what is no finite number."""
        given = (self.x, self.y, 0.0 if self.heading is None else self.heading)
        if not all(isinstance(one, int | float | np.number) and math.isfinite(one) for one in given):
            raise InvalidArgumentError(f"a goal has finite numbers, not {self}")


class Navigator:
    """Leads one vehicle to goals. `step` is told what is seen once a period, and returns the twist to drive."""

    def __init__(
        self,
        where: Where,
        footprint: Footprint,
        limits: Limits | None = None,
        say: Callable[[str], object] = lambda _: None,
        reach: float = 0.0,
        lidar: str = "lidar",
    ) -> None:
        """Lead a vehicle of a footprint; `say` is told each decision once. Its lidar sees so far (m); 0: unknown."""
        self.where, self.footprint, self.limits = where, footprint, limits or Limits()
        self.goal: Goal | None = None
        self.end: str | None = None
        """End of the way to the last goal, in words; None while it goes on."""
        self.reached = False
        self.pose = np.zeros(3)
        """Pose (3,) in the map."""
        self.way: Floats | None = None
        """Way (n, 2) that it follows."""
        self._say = say
        self._said = ""
        self._sight = Sight(lidar, reach)
        self._unforeseen = Unforeseen()
        self._heard = Heard()
        self._distances = Distances(~where.grid.free)
        self._scan: Scan | None = None
        self._surroundings = Surroundings(np.zeros((0, 2)))
        self._last: Observation | None = None
        self._twist = (0.0, 0.0)
        self._told = (0.0, 0.0)
        self._searches = 0
        self._begin(0.0)

    @property
    def last_time(self) -> float:
        """Return the time (s) of what was seen last; 0 before."""
        return self._last.time if self._last else 0.0

    def go(self, goal: Goal) -> None:
        """Head for another goal."""
        self.goal, self.end, self.reached, self.way, self._said = goal, None, False, None, ""
        self._searches = 0
        self._begin(self.last_time)

    def _begin(self, now: float) -> None:
        self._planned = -math.inf
        self._without_way: float | None = None
        self._best, self._best_at = math.inf, now
        self._begun, self._stood = now, False
        self._recoveries, self._others = 0, 0
        self._manoeuvre: tuple[float, tuple[float, float]] | None = None
        self._outs = 0
        self._out: tuple[float, Floats, Callable[..., Choice | None]] | None = None
        self._lost_since: float | None = None
        self._checked: tuple[float, Floats, Floats] | None = None
        self._doubted = (False, False)
        self._blind = False

    def step(self, seen: Observation) -> tuple[float, float]:
        """Return the twist to drive now, v (m/s) and omega (rad/s)."""
        if self._last is None:
            self._begin(seen.time)  # the world's clock has gone before
        self._see(seen)
        if self.goal is None or self.end is not None:
            twist = (0.0, 0.0)
        else:
            twist = self._decide(seen.time)
        self._told = twist
        return twist

    def _see(self, seen: Observation) -> None:
        if self._last is not None and seen.time > self._last.time:
            step = between(self._last.odometry, seen.odometry)
            self._sight.goes(float(np.hypot(*step[:2])))
            elapsed = seen.time - self._last.time
            self._twist = (float(step[0]) / elapsed, float(step[2]) / elapsed)
        self._last = seen
        if seen.scan is not None and self._sight.takes(seen.scan, self.where):
            pose = self.where.update(seen.scan)
            self._scan = seen.scan
            if not self.where.lost:
                self._unforeseen.update(seen.scan, pose, self.where.grid)
        self.pose = self.where.at(seen.odometry)
        if self._scan is not None:
            now_t_scan = between(seen.odometry, self._scan.odometry)
            near = moved(now_t_scan, self._scan.points)
            if seen.sonars:
                heard = [sonar.unseen(distance, near) for sonar, distance in seen.sonars]
                self._heard.update(moved(self.pose, np.vstack(heard)), seen.time)
            old = self._not_on_the_map()
            if len(old):
                near = np.vstack([near, moved(between(self.pose, np.zeros(3)), old)])
            self._surroundings = Surroundings(near)

    def _not_on_the_map(self) -> Floats:
        """Return points (n, 2) of what stands where the map has nothing, seen or heard, in its frame."""
        return np.vstack([self._unforeseen.points(), self._heard.points()])

    def _decide(self, now: float) -> tuple[float, float]:
        if (fault := self._sight.fault(now)) is not None:
            return self._waits_for_sight(now, fault)
        if self._stood:
            self._stood = False
            self._tell(f"goes on: {self._sight.lidar!r} sees again")
        if self._sight.alone > ALONE_METERS:
            return self._ends(
                f"gives up: it has gone {self._sight.alone:.1f} m by odometry alone, with nothing in the reach of "
                f"{self._sight.lidar!r}"
            )
        if self.where.lost:
            return self._search(now)
        if self._lost_since is not None:
            self._tell(f"knows its place again: ({self.pose[0]:.2f}, {self.pose[1]:.2f})")
            self.way = None
            self._begin(now)
        if (words := self._doubts(now)) is not None:
            self._tell(words)
        blind, self._blind = self._blind, self._sight.nothing
        if self._blind and not blind:
            self._tell("sees nothing in the lidar's reach: goes on by odometry alone")
        assert self.goal is not None
        left = distance(self.pose, (self.goal.x, self.goal.y))
        if left < REACHED_METERS:
            return self._arrive()
        if self._out is not None:
            return self._back_out(now)
        if self._manoeuvre is not None:
            return self._go_on(now)
        if self.way is None or now - self._planned >= PLAN_SECONDS:
            self._plan(now)
        if self.end is not None:
            return 0.0, 0.0
        if self.way is None:
            return 0.0, 0.0
        if self._is_shut_in() and (out := self._begin_out(now, "has no room to turn to its way")) is not None:
            return out
        remaining = self._remaining()
        if remaining < self._best - 0.1:
            self._best, self._best_at = remaining, now
        if now - self._best_at > PATIENCE_SECONDS:
            return self._recover(now, "comes no nearer to its goal")
        choice = choose(
            self.pose, self._twist, ahead_of(self.pose, self.way, 3.0), self._surroundings, self.footprint, self.limits
        )
        if choice is None:
            return self._recover(now, "is blocked")
        return self._slowed(choice, left)

    def _waits_for_sight(self, now: float, fault: str) -> tuple[float, float]:
        """Stand while the lidar tells nothing, and give up when that goes on."""
        silent = now - (self._begun if self._sight.since is None else self._sight.since)
        self._best_at = now
        if silent > GIVE_UP_SECONDS:
            return self._ends(f"gives up: {fault}, for {silent:.0f} s")
        if silent > SILENT_SECONDS:
            self._stood = True
            self._tell(f"stands: {fault}")
        return 0.0, 0.0

    def _slowed(self, choice: Choice, left: float) -> tuple[float, float]:
        """Return a choice, slow enough to stop at the goal."""
        fastest = math.sqrt(2.0 * 0.5 * self.limits.acceleration * left) + 0.02
        scale = min(1.0, fastest / max(choice.twist[0], 1e-9))
        return choice.twist[0] * scale, choice.twist[1] * max(scale, 0.5)

    def _arrive(self) -> tuple[float, float]:
        assert self.goal is not None
        if self.goal.heading is not None:
            angle = float(wrapped(self.goal.heading - self.pose[2]))
            if abs(angle) > REACHED_RADIANS:
                turn = turning(angle, self._twist, self._surroundings, self.footprint, self.limits)
                if turn is None:
                    return self._ends("has come to its goal, and cannot turn there: something stands too near")
                return turn.twist
        self.reached = True
        return self._ends(f"has come to ({self.goal.x:.2f}, {self.goal.y:.2f})")

    def _plan(self, now: float) -> None:
        assert self.goal is not None
        self._planned = now
        try:
            self._take(self._planner(self._not_on_the_map()), now)
            self._without_way = None
        except NoWayError as error:
            if (on_the_map := self._no_way_on_the_map()) is not None:
                self.way = None
                self._ends(f"gives up: {on_the_map}")
                return
            left = distance(self.pose, (self.goal.x, self.goal.y))
            if isinstance(error, GoalTakenError) and left > NEAR_METERS and (way := self._way_near()) is not None:
                self.way, self._without_way = way, None
                self._tell("something stands on its goal now: goes on towards it")
                return
            if self._without_way is None:
                self._without_way = now
            if now - self._without_way > GIVE_UP_SECONDS:
                self.way = None
                self._ends(f"gives up: {error}, with what stands there now")
                return
            self.way = None
            self._stands(f"waits: {error}, with what stands there now")

    def _take(self, planner: Planner, now: float) -> None:
        """Take the way that a planner has, unless it is another one that is hardly better than that so far."""
        assert self.goal is not None
        before, self.way = self.way, planner.way(self.pose, np.array([self.goal.x, self.goal.y]))
        if before is None:
            return
        rest = spaced(np.vstack([self.pose[:2], ahead_of(self.pose, before, math.inf)]))
        away = np.hypot(*(self.way[:, None] - rest).transpose(2, 0, 1)).min(axis=1).max()
        if away < OTHER_METERS:
            return
        if planner.cost(self.way) > CHEAPER * planner.cost(rest):
            self.way = before
        elif (left := self._remaining()) > self._best and self._others < RECOVERIES:
            # It comes nearer to its goal by this one, however far the one before would have been.
            self._others += 1
            self._best, self._best_at = left, now
            self._tell(f"takes another way, of {left:.1f} m")

    def _way(self, seen: Floats) -> Floats:
        """Return the way (n, 2) to the goal, with points (n, 2) besides that were seen; raises NoWayError."""
        assert self.goal is not None
        return self._planner(seen).way(self.pose, np.array([self.goal.x, self.goal.y]))

    def _planner(self, seen: Floats) -> Planner:
        return Planner(Costmap.of(self.where.grid, self.footprint, seen, self._distances))

    def _no_way_on_the_map(self) -> NoWayError | None:
        """Return why the map alone has no way to the goal; None where it has one."""
        try:
            self._way(np.zeros((0, 2)))
        except NoWayError as error:
            return error
        return None

    def _way_near(self) -> Floats | None:
        """Return the way to the goal without what was seen near it, which may be gone; None where there is none."""
        assert self.goal is not None
        seen = self._not_on_the_map()
        away = np.hypot(seen[:, 0] - self.goal.x, seen[:, 1] - self.goal.y)
        try:
            return self._way(seen[away > NEAR_METERS])
        except NoWayError:
            return None

    def _remaining(self) -> float:
        assert self.way is not None
        rest = ahead_of(self.pose, self.way, math.inf)
        return float(np.hypot(*np.diff(rest, axis=0).T).sum()) + distance(self.pose, rest[0])

    def _recover(self, now: float, why: str) -> tuple[float, float]:
        """Wait, back up and turn, one after the other, and end when nothing helps."""
        number = self._recoveries
        self._recoveries += 1
        self._best_at, self._planned = now, -math.inf
        if number >= RECOVERIES:
            assert self.goal is not None
            left = distance(self.pose, (self.goal.x, self.goal.y))
            return self._ends(
                f"gives up {left:.2f} m from its goal: it {why}, and neither waiting, backing up nor turning helps"
            )
        if number % 2 == 0:
            self._manoeuvre = (now + 2.0, (0.0, 0.0))
            self._tell(f"{why}: waits for 2 s")
        elif not self._turns(math.pi) and (out := self._begin_out(now, why)) is not None:
            return out
        elif self._free_behind():
            self._manoeuvre = (now + 2.0, (-0.15, 0.0))
            self._tell(f"{why}: backs up by 0.3 m")
        else:
            self._manoeuvre = (now + 1.6, (0.0, 0.8))
            self._tell(f"{why}: turns")
        return self._go_on(now)

    def _go_on(self, now: float) -> tuple[float, float]:
        assert self._manoeuvre is not None
        until, twist = self._manoeuvre
        if now >= until or (twist[0] < 0.0 and not self._free_behind()) or (twist[1] and not self._free_turn(twist[1])):
            self._manoeuvre = None
            return 0.0, 0.0
        return twist

    def _turns(self, angle: float) -> bool:
        return can_turn(angle, self._surroundings, self.footprint)

    def _is_shut_in(self) -> bool:
        """Return whether the way begins behind the vehicle, which can't turn where it stands."""
        assert self.way is not None
        bearing = self._bearing(self.way)
        return abs(bearing) > 0.5 * math.pi and not self._turns(bearing)

    def _bearing(self, way: Floats) -> float:
        """Return the angle (rad) to a way a bit ahead."""
        x, y = ahead_of(self.pose, way, 0.3)[-1] - self.pose[:2]
        return float(wrapped(math.atan2(y, x) - self.pose[2]))

    def _begin_out(self, now: float, why: str) -> tuple[float, float] | None:
        """Begin to drive to where it can turn, if there is such a place and it hasn't been tried too often."""
        if self._outs == OUTS or (way := self._planner(self._not_on_the_map()).out(self.pose)) is None:
            return None
        self._outs += 1
        back = abs(self._bearing(way)) > 0.5 * math.pi
        self._out = now + OUT_SECONDS, way, backwards if back else choose
        self._tell(f"{why}: {'backs' if back else 'drives'} out by {length(way):.1f} m, to where it can turn")
        return self._back_out(now)

    def _back_out(self, now: float) -> tuple[float, float]:
        assert self._out is not None
        until, way, drive = self._out
        near = ahead_of(self.pose, way, 3.0)
        limits = replace(self.limits, speed=OUT_SPEED)
        choice = drive(self.pose, self._twist, near, self._surroundings, self.footprint, limits)
        if choice is None or now >= until or distance(self.pose, way[-1]) < REACHED_METERS:
            self._out, self._planned, self._best, self._best_at = None, -math.inf, math.inf, now
            return 0.0, 0.0
        return choice.twist

    def _free_behind(self) -> bool:
        outline = self.footprint.outline()
        here = float(self._surroundings.clearance(outline).min())
        behind = self._surroundings.clearance(outline - np.array([0.15, 0.0])).min()
        return bool(behind > min(0.03, 0.5 * here))

    def _free_turn(self, rate: float) -> bool:
        return (
            turning(math.copysign(0.4, rate), self._twist, self._surroundings, self.footprint, self.limits) is not None
        )

    def _search(self, now: float) -> tuple[float, float]:
        """Drive about to where it is open until the place is known."""
        if self._lost_since is None:
            assert self.goal is not None
            try:  # what the map alone refuses is not worth a search
                self._planner(np.zeros((0, 2))).check_goal(np.array([self.goal.x, self.goal.y]))
            except NoWayError as error:
                return self._ends(f"gives up: {error}")
            if self._searches == SEARCHES:
                return self._ends(
                    f"gives up: it has found its place {SEARCHES} times, and none of them fits any more: is it the map "
                    "of this building?"
                )
            self._searches += 1
            self._lost_since = now
            self._unforeseen.clear()
            self._heard.clear()
            self._tell("is lost: looks for its place in the map")
        if now - self._lost_since > LOST_SECONDS:
            return self._ends(f"gives up: {self.where.doubt}")
        assert self._scan is not None
        bins = np.linspace(-np.pi, np.pi, 25)
        angles = np.arctan2(self._scan.points[:, 1], self._scan.points[:, 0])
        lengths = np.hypot(*self._scan.points.T)
        room = [lengths[np.abs(wrapped(angles - b)) < 0.3].min(initial=3.0) for b in bins[:-1]]
        # What lies ahead counts for more, so that it drives on rather than to and fro.
        best = int(np.argmax(np.array(room) + 0.8 * np.cos(bins[:-1])))
        goal = np.array([np.cos(bins[best]), np.sin(bins[best])]) * max(room[best] - self.footprint.outer, 0.1)
        way = np.linspace(np.zeros(2), goal, 20)
        choice = choose(np.zeros(3), self._twist, way, self._surroundings, self.footprint, self.limits)
        return (0.0, 0.5) if choice is None else choice.twist

    def _doubts(self, now: float) -> str | None:
        """Return in words where odometry and scans contradict each other over the last two seconds."""
        assert self._last is not None
        if self._checked is None:
            self._checked = now, self._last.odometry, self.pose
            return None
        since, odometry, pose = self._checked
        if now - since < 2.0:
            return None
        self._checked = now, self._last.odometry, self.pose
        by_wheels, by_scans = distance(odometry, self._last.odometry), distance(pose, self.pose)
        slips = by_wheels > 0.25 and by_scans < SHARE_OF_ODOMETRY * by_wheels
        stands = by_wheels < 0.01 and by_scans > 0.15
        before, self._doubted = self._doubted, (slips, stands)
        if slips and not before[0]:
            return f"its wheels slip: odometry says {by_wheels:.2f} m in 2 s, the lidar {by_scans:.2f} m"
        if stands and not before[1]:
            return f"its odometry stands: the lidar says {by_scans:.2f} m in 2 s; it goes on by the lidar"
        return None

    def _stands(self, words: str) -> tuple[float, float]:
        self._tell(words)
        return 0.0, 0.0

    def _ends(self, words: str) -> tuple[float, float]:
        self.end = words
        self._tell(words)
        return 0.0, 0.0

    def _tell(self, words: str) -> None:
        if words != self._said:
            self._said = words
            self._say(words)
