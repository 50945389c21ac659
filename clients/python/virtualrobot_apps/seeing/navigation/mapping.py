"""Mapping: scans are matched with those before, places that are passed again close loops, and a pose graph bends it."""

from __future__ import annotations

import numpy as np

from virtualrobot_apps.seeing.navigation.grid import Grid
from virtualrobot_apps.seeing.navigation.matching import CONTRADICTED, FEWEST, Cloud
from virtualrobot_apps.seeing.navigation.pose_graph import Relation, optimised
from virtualrobot_apps.seeing.navigation.poses import Floats, between, compose, moved
from virtualrobot_apps.seeing.navigation.scans import Scan

KEY_METERS, KEY_RADIANS = 0.4, 0.35
"""Way and turn after which a scan is kept."""
NEARBY, NEARBY_METERS = 12, 2.0
"""Number of kept scans which a new one is matched with, and how near they are."""
LOOP_AFTER, LOOP_METERS, LOOP_SHARE = 20, 2.5, 0.75
"""Kept scans after which a place counts as passed again, how near it is, and which part of a scan must fit there."""
RELATED_METERS, RELATED_RADIANS = 0.01, 0.004
"""Deviations (m, rad) of what matches tell about kept scans."""
DRIFT_METERS, DRIFT_RADIANS = 0.03, 0.01
"""Deviations (m, rad) by which the way from one kept scan to the next is off at worst, for what may be a loop."""
REPLACED = 5.0
"""Deviation of a scan for which odometry stands, in those."""
LOOP_OFF_METERS, LOOP_OFF_RADIANS = 0.01, 0.005
"""Offset (m, rad) of a loop from which on the way is bent."""
TRUSTED_SHARE, TRUSTED_METERS = 0.5, 0.3
"""Part of a scan that must fit, and the greatest way off odometry, for a match to count for more than odometry."""


class Mapper:
    """Maps a floor while a vehicle drives, and tells where it is in it; the map's frame is that of its first pose."""

    def __init__(self, start: Floats, resolution: float = 0.05) -> None:
        """Begin at a pose (3,) in the frame that the map is to have."""
        self.grid = Grid(resolution)
        self.poses: list[Floats] = []
        """Poses (3,) of the kept scans."""
        self.loops = 0
        """Number of loops closed so far."""
        self.replaced = 0
        """Number of scans that could not be matched, for which odometry stands."""
        self.keep_next = False
        """True: the next scan is kept wherever it is made."""
        self._pose = np.asarray(start, np.float64)
        self._odometry: Floats | None = None
        self._kept: list[Scan] = []
        self._relations: list[Relation] = []
        self._drift: list[float] = []
        self._near: Cloud | None = None

    lost, doubt = False, ""

    def at(self, odometry: Floats) -> Floats:
        """Return the pose (3,) in the map when odometry says this (3,)."""
        return self._pose if self._odometry is None else compose(self._pose, between(self._odometry, odometry))

    def update(self, scan: Scan) -> Floats:
        """Take in a scan; return the pose (3,) of the base when it was made."""
        guess = self.at(scan.odometry)
        if not self._kept:
            self._keep(scan, guess)
            return guess
        pose = self._matched(scan, guess)
        self._pose, self._odometry = pose, scan.odometry
        way = between(self.poses[-1], pose)
        if self.keep_next or np.hypot(way[0], way[1]) > KEY_METERS or abs(way[2]) > KEY_RADIANS:
            self._keep(scan, pose)
        return self._pose

    def _matched(self, scan: Scan, guess: Floats) -> Floats:
        """Return the pose of a scan: by the match where that can be trusted, else as odometry has it."""
        base = self.poses[-1]
        assert self._odometry is not None
        if self._near is not None and len(scan.points) >= FEWEST:
            step = between(self._odometry, scan.odometry)
            found = self._near.match_after(scan.points, scan.normals, between(base, guess), step)
            off = between(between(base, guess), found.pose)
            if found.share > TRUSTED_SHARE and np.hypot(off[0], off[1]) < TRUSTED_METERS:
                return compose(base, found.pose)
        self.replaced += 1
        return guess

    def _keep(self, scan: Scan, pose: Floats) -> None:
        number, self.keep_next = len(self._kept), False
        if number:
            self._relations.append(
                Relation(number - 1, number, between(self.poses[-1], pose), RELATED_METERS, RELATED_RADIANS)
            )
        self._kept.append(scan)
        self.poses.append(pose)
        # Variance of the way up to here, in that from one kept scan to the next.
        self._drift.append(number + REPLACED**2 * self.replaced)
        self._pose, self._odometry = pose, scan.odometry
        bent = self._close_loops(number) and self._bend()
        if not bent:
            self.grid.insert(scan, pose)
        self._near = self._around(number)

    def _around(self, number: int, until: int | None = None) -> Cloud | None:
        """Return the cloud of the scans kept before `until` nearest to one, in its frame; None of too few points."""
        base = self.poses[number]
        off = between(base, np.array(self.poses[:until]))
        apart = np.hypot(off[:, 0], off[:, 1])
        numbers = [int(one) for one in np.argsort(apart, kind="stable")[:NEARBY] if apart[one] < NEARBY_METERS]
        points = np.vstack([moved(off[one], self._kept[one].points) for one in numbers])
        if len(points) < FEWEST:
            return None
        turns = np.column_stack([np.zeros((len(off), 2)), off[:, 2]])
        return Cloud(points, np.vstack([moved(turns[one], self._kept[one].normals) for one in numbers]))

    def _bend(self) -> bool:
        """Bend the way so that all relations fit best; return whether the grid was made anew for it."""
        before = np.array(self.poses)
        after = optimised(before, self._relations)
        self.poses = list(after)
        self._pose = self.poses[-1]
        if np.abs(after - before)[:, :2].max() < 0.5 * self.grid.resolution:
            return False
        self.grid = Grid(self.grid.resolution)
        for one, place in zip(self._kept, self.poses, strict=True):
            self.grid.insert(one, place)
        return True

    def _close_loops(self, number: int) -> bool:
        """Match the newest scan with older ones at this place; return whether one fits and contradicts the way."""
        scan, here = self._kept[number], self.poses[number]
        if number <= LOOP_AFTER or len(scan.points) < FEWEST:
            return False
        older = np.array(self.poses[: number - LOOP_AFTER])
        apart = np.hypot(*(older[:, :2] - here[:2]).T)
        at = int(np.argmin(apart))
        cloud = self._around(at, number - LOOP_AFTER) if apart[at] < LOOP_METERS else None
        if cloud is None:
            return False
        guess = between(older[at], here)
        drift = float(np.sqrt(self._drift[number] - self._drift[at]))
        meters, radians = DRIFT_METERS * drift, DRIFT_RADIANS * drift
        found = cloud.match(scan.points, scan.normals, guess, (meters, radians), reach=1.0)
        off = between(guess, found.pose)
        # Half of a room may look like the other one: a loop is off by no more than the way can be.
        far = np.hypot(off[0], off[1]) > CONTRADICTED * meters or abs(off[2]) > CONTRADICTED * radians
        if found.share < LOOP_SHARE or found.weak or far:
            return False
        self._relations.append(Relation(at, number, found.pose, RELATED_METERS, RELATED_RADIANS))
        self.loops += 1
        return bool(np.hypot(off[0], off[1]) > LOOP_OFF_METERS or abs(off[2]) > LOOP_OFF_RADIANS)
