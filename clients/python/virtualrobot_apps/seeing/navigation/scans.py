"""Scans of a lidar as a vehicle sees them: points about its base, each moved to where the base is at the end."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from virtualrobot.sensors.range_sensors import RangeReading

from virtualrobot_apps.seeing.navigation.matching import normals_of
from virtualrobot_apps.seeing.navigation.poses import Floats, between, moved, wrapped

QUIET = 0.8
"""Part of its reach up to which a lidar that says 0 without echo is taken to have met nothing."""
BESIDE = 0.5
"""Distance (m) beyond which what is beside such a ray must be: else something too near to be told may stand there."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Scan of a lidar.

    time: of its last ray (s of simulation time). points: (n, 2) echoes in the frame of the base at that time (m).
    normals: (n, 2) of what they come from, towards the lidar. empty: (m, 2) ends of rays that came to nothing, as far
    as the lidar sees. origin: (2,) the lidar's place there. odometry: (3,) pose of the base at that time by odometry.
    quiet: (k, 2) ends of rays that told nothing, not even that nothing is there, as some lidars do where nothing is.
    """

    time: float
    points: Floats
    normals: Floats
    empty: Floats
    origin: Floats
    odometry: Floats
    quiet: Floats = field(default_factory=lambda: np.zeros((0, 2)))


class OdometryTrack:
    """Poses by odometry over the last seconds, to be asked for in between."""

    def __init__(self, seconds: float = 2.0) -> None:
        """Keep so many seconds."""
        self._seconds = seconds
        self._times: list[float] = []
        self._poses: list[Floats] = []

    def add(self, time: float, pose: Floats) -> None:
        """Add the pose (3,) of a time; raise ValueError for one that goes back."""
        if self._times and time < self._times[-1]:
            raise ValueError(f"odometry goes back in time, from {self._times[-1]:g} to {time:g} s")
        self._times.append(time)
        self._poses.append(np.asarray(pose, np.float64))
        while self._times[0] < time - self._seconds:
            del self._times[0], self._poses[0]

    def at(self, times: Floats) -> Floats:
        """Return poses (n, 3) at times (n,), straight between those that are known, and held beyond them."""
        poses = np.array(self._poses)
        poses[:, 2] = np.unwrap(poses[:, 2])
        columns = [np.interp(times, self._times, poses[:, column]) for column in range(3)]
        columns[2] = wrapped(columns[2])
        return np.stack(columns, axis=-1)


class ScanMaker:
    """Makes scans of a lidar's readings; learns the directions of its rays, so that those without echo count too."""

    def __init__(self, base_t_lidar: Floats, reach: float) -> None:
        """Take the pose (3,) of the lidar on the base, and how far it sees (m)."""
        self._mount, self._reach = np.asarray(base_t_lidar, np.float64), reach
        self._directions: Floats | None = None

    def scan(self, time: float, reading: RangeReading, track: OdometryTrack) -> Scan:
        """Return the scan of a reading with points in the sensor's frame, made at a time (s).

        A lidar that turns measures one ray after the other while the base moves: each point is taken from where the
        base was then to where it is at the end, by odometry.
        """
        points = np.asarray(reading.points, np.float64)[0, :, :2]
        valid = reading.valid[0] & np.isfinite(points).all(axis=1)
        if self._directions is None or len(self._directions) != len(points):
            self._directions = np.zeros((len(points), 2))
        lengths = np.linalg.norm(points[valid], axis=1, keepdims=True)
        self._directions[valid] = points[valid] / np.maximum(lengths, 1e-9)
        self._fill()
        silent = ~valid & self._directions.any(axis=1)
        nothing = silent & np.isinf(reading.distances[0])
        quiet = silent & ~nothing & (_beside(valid, lengths[:, 0]) > BESIDE)
        reach = np.where(nothing, self._reach, QUIET * self._reach)[:, None]
        ends = np.where(valid[:, None], points, self._directions * reach)
        seen = moved(self._mount, ends)
        if reading.ages is not None:
            then = track.at(time - np.asarray(reading.ages, np.float64))
            now = track.at(np.array([time]))[0]
            seen = moved(between(now, then), seen[:, None, :])[:, 0]
        return Scan(
            time,
            seen[valid],
            normals_of(seen[valid], self._mount[:2]),
            seen[nothing],
            self._mount[:2].copy(),
            track.at(np.array([time]))[0],
            seen[quiet],
        )

    def _fill(self) -> None:
        """Give rays that have had no echo yet their directions, where those of the others go on evenly."""
        assert self._directions is not None
        directed = np.asarray(self._directions.any(axis=1), bool)
        known = np.flatnonzero(directed)
        if len(known) in (0, 1, len(self._directions)):
            return
        told = np.arctan2(self._directions[known, 1], self._directions[known, 0])
        step = float(np.median(np.asarray(wrapped(np.diff(told)), np.float64) / np.diff(known)))
        angles = told[0] + step * (np.arange(len(self._directions)) - known[0])
        fan = np.column_stack([np.cos(angles), np.sin(angles)])
        if np.abs(fan[known] - self._directions[known]).max() < 0.01:
            self._directions = np.where(directed[:, None], self._directions, fan)


def _beside(valid: NDArray[np.bool_], lengths: Floats) -> Floats:
    """Return the lesser length (n,) of the next rays to either side of each that are valid, whose lengths are given."""
    if not len(lengths):
        return np.full(len(valid), np.inf)
    after = np.searchsorted(np.flatnonzero(valid), np.arange(len(valid))) % len(lengths)
    return np.minimum(lengths[after - 1], lengths[after])
