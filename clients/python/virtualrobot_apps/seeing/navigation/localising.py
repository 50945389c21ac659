"""Localisation in a known map: each scan is matched with its walls; a vehicle that is lost looks for itself everywhere.

The score of a place is that of a likelihood field: S. Thrun, W. Burgard, D. Fox, Probabilistic Robotics, 2005, 6.4.
"""

from __future__ import annotations

import numpy as np
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.navigation.grid import BEHIND, Grid
from virtualrobot_apps.seeing.navigation.matching import FEWEST, Cloud, Match
from virtualrobot_apps.seeing.navigation.poses import Floats, between, compose, distance, moved
from virtualrobot_apps.seeing.navigation.regions import apart
from virtualrobot_apps.seeing.navigation.scans import Scan

LOST_SHARE, LOST_AFTER = 0.5, 5
"""Part of a scan that must fit the map, and number of scans without that after which the vehicle is lost."""
FOUND_SHARE = 0.75
"""Part of a scan that must fit where a lost vehicle is found."""
CLEARER = 0.1
"""Lead of the best place over any other one, in shares, with which a lost vehicle is there."""
STEP_METERS, STEP_RADIANS = 0.25, np.radians(6.0)
"""Distance and turn between the places that are looked at."""
_RAYS = 60
_DEVIATION = 0.15
_MOST_PLACES = 40
_REFINED = 12


class Localiser:
    """Tells where a vehicle is in a map, by scans and odometry."""

    def __init__(self, grid: Grid, start: Floats | None = None) -> None:
        """Begin at a pose (3,) in the map; None: lost.

        Raises:
            InvalidArgumentError: where the map has too few walls to tell a place by.
        """
        self.grid = grid
        walls, normals = grid.faces()
        if len(walls) < FEWEST:
            raise InvalidArgumentError(
                f"the map has {len(walls)} cells of walls beside free ones, and {FEWEST} at least are needed to find a "
                "place on it"
            )
        self._walls = Cloud(walls, normals)
        self._likelihood = np.exp(-0.5 * (apart(grid.occupied) * grid.resolution / _DEVIATION) ** 2)
        self._pose = np.zeros(3) if start is None else np.asarray(start, np.float64)
        self._odometry: Floats | None = None
        self._unfit = LOST_AFTER if start is None else 0
        self._guesses: Floats | None = None
        self.share = 0.0
        """Part of the last scan that fits the map."""
        self.best = 0.0
        """Part of it that fits at the best place, while lost."""
        self.alike: list[Floats] = []
        """Poses (3,) that it fits as well, while lost."""

    @property
    def lost(self) -> bool:
        """Return whether it is not known where the vehicle is."""
        return self._unfit >= LOST_AFTER

    @property
    def doubt(self) -> str:
        """Return in words why it isn't known where the vehicle is."""
        if len(self.alike) > 1:
            places = ", ".join(f"({x:.2f}, {y:.2f}, {np.degrees(turn):.0f}°)" for x, y, turn in self.alike[:4])
            more = ", ..." if len(self.alike) > 4 else ""
            return (
                f"several places of this map look alike to the lidar: {places}{more}: say where it starts with --from"
            )
        return (
            f"no place of this map fits what the lidar sees (the best one to {100.0 * self.best:.0f}%): is it the map "
            "of this building?"
        )

    def at(self, odometry: Floats) -> Floats:
        """Return the pose (3,) in the map when odometry says this (3,)."""
        return self._pose if self._odometry is None else compose(self._pose, between(self._odometry, odometry))

    def update(self, scan: Scan) -> Floats:
        """Take in a scan; return the pose (3,) of the base when it was made, a guess while it is `lost`."""
        guess = self.at(scan.odometry)
        step = np.zeros(3) if self._odometry is None else between(self._odometry, scan.odometry)
        self._pose, self._odometry = guess, scan.odometry
        if len(scan.points) < FEWEST:
            return guess
        if self.lost:
            self._look(scan, step)
            return self._pose
        found = self._walls.match_after(scan.points, scan.normals, guess, step)
        self.share = self._share(scan, found)
        if self.share < LOST_SHARE:
            self._unfit += 1
            if self.lost:
                self._guesses = None
            return guess
        self._unfit = 0
        self._pose = found.pose
        return found.pose

    def _look(self, scan: Scan, step: Floats) -> None:
        """Look for the vehicle: everywhere at first, then where it would have driven to from the best places."""
        places = self._everywhere(scan.points) if self._guesses is None else compose(self._guesses, step)
        matches = [self._walls.match(scan.points, scan.normals, place, reach=1.0) for place in places[:_REFINED]]
        rated = sorted(((self._share(scan, match), match.pose) for match in matches), key=lambda one: -one[0])
        distinct: list[Floats] = []
        shares: list[float] = []
        for share, pose in rated:
            if all(distance(pose, one) > 0.3 or abs(between(one, pose)[2]) > 0.2 for one in distinct):
                distinct.append(pose)
                shares.append(share)
        self.best = shares[0] if shares else 0.0
        self.alike = [
            one for one, share in zip(distinct, shares, strict=True) if share > max(FOUND_SHARE, self.best - CLEARER)
        ]
        kept = [one for one, share in zip(distinct, shares, strict=True) if share > FOUND_SHARE - CLEARER]
        if kept and shares[0] > FOUND_SHARE and (len(shares) == 1 or shares[0] > shares[1] + CLEARER):
            self._pose, self._unfit, self._guesses, self.share = distinct[0], 0, None, shares[0]
        else:
            self._guesses = np.array(kept) if kept else None

    def _share(self, scan: Scan, match: Match) -> float:
        """Return which part of a scan fits the map: of its echoes, and of the rays that have passed walls of the map.

        By echoes alone a corner fits each corner, and what stands behind it on the map counts for nothing.
        """
        rays = np.vstack([scan.points, scan.empty])
        passed = self.grid.stops(moved(match.pose, scan.origin[None])[0], moved(match.pose, rays), BEHIND).sum()
        return match.share * len(scan.points) / (len(scan.points) + int(passed))

    def _everywhere(self, points: Floats) -> Floats:
        """Return the places (n, 3) where a scan fits best, of all free ones and turns, the best first."""
        rows, columns = np.nonzero(self.grid.free)
        stride = max(1, round(STEP_METERS / self.grid.resolution))
        coarse = (rows % stride == 0) & (columns % stride == 0)
        places = self.grid.middles(rows[coarse], columns[coarse])
        turns = np.arange(-np.pi, np.pi, STEP_RADIANS)
        seen = points[np.linspace(0, len(points) - 1, min(_RAYS, len(points))).astype(int)]
        scores = np.empty((len(turns), len(places)), np.float32)
        padded = np.pad(self._likelihood.astype(np.float32), 1)
        top = np.array(self._likelihood.shape)
        for number, turn in enumerate(turns):
            ends = moved(np.array([0.0, 0.0, turn]), seen)
            keys = np.floor((places[:, None] + ends - self.grid.origin) / self.grid.resolution).astype(np.int32)
            row = np.clip(keys[..., 1], -1, top[0]) + 1
            column = np.clip(keys[..., 0], -1, top[1]) + 1
            scores[number] = padded[row, column].mean(axis=1)
        best: list[Floats] = []
        for flat in np.argsort(scores, axis=None)[::-1][: 50 * _MOST_PLACES]:
            turn, place = np.unravel_index(flat, scores.shape)
            pose = np.array([*places[place], turns[turn]])
            if all(distance(pose, one) > 0.5 or abs(between(one, pose)[2]) > 0.3 for one in best):
                best.append(pose)
                if len(best) == _MOST_PLACES:
                    break
        return np.array(best)
