"""The joint_trajectory_controller of ros2_control, as a reference: its `Trajectory::sample`, line by line.

Source: github.com/ros-controls/ros2_controllers, joint_trajectory_controller/src/trajectory.cpp (`sample`,
`interpolate_between_points`, interpolation method SPLINE), Apache-2.0. A point is (time from start, positions,
velocities or none, accelerations or none).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

Values = Sequence[float]
Point = tuple[float, Values, Values, Values]


def sample(points: Sequence[Point], before: Point, start: float, time: float) -> tuple[list[float], list[float]]:
    """Return positions and velocities at a time; `before` is the state when the trajectory came, with that time."""
    first = points[0]
    if time < start + first[0]:
        return _between(before[0], before, start + first[0], first, time)
    for point, following in pairwise(points):
        t0, t1 = start + point[0], start + following[0]
        if t0 <= time < t1:
            return _between(t0, point, t1, following, time)
    last = points[-1]
    return list(last[1]), list(last[2]) or [0.0] * len(last[1])


def _between(time_a: float, a: Point, time_b: float, b: Point, time: float) -> tuple[list[float], list[float]]:
    so_far, between = time - time_a, time_b - time_a
    has_velocity, has_acceleration = bool(a[2] and b[2]), bool(a[3] and b[3])
    positions, velocities = [], []
    for i in range(len(a[1])):
        start, end = a[1][i], b[1][i]
        c = [start, 0.0, 0.0, 0.0, 0.0, 0.0]
        T = [between**power for power in range(6)]
        if not has_velocity and not has_acceleration:
            c[1] = (end - start) / T[1]
        elif has_velocity and not has_acceleration:
            v0, v1 = a[2][i], b[2][i]
            c[1] = v0
            c[2] = (-3.0 * start + 3.0 * end - 2.0 * v0 * T[1] - v1 * T[1]) / T[2]
            c[3] = (2.0 * start - 2.0 * end + v0 * T[1] + v1 * T[1]) / T[3]
        else:
            v0, v1, a0, a1 = a[2][i], b[2][i], a[3][i], b[3][i]
            c[1], c[2] = v0, 0.5 * a0
            c[3] = (-20.0 * start + 20.0 * end - 3.0 * a0 * T[2] + a1 * T[2] - 12.0 * v0 * T[1] - 8.0 * v1 * T[1]) / (
                2.0 * T[3]
            )
            c[4] = (
                30.0 * start - 30.0 * end + 3.0 * a0 * T[2] - 2.0 * a1 * T[2] + 16.0 * v0 * T[1] + 14.0 * v1 * T[1]
            ) / (2.0 * T[4])
            c[5] = (-12.0 * start + 12.0 * end - a0 * T[2] + a1 * T[2] - 6.0 * v0 * T[1] - 6.0 * v1 * T[1]) / (
                2.0 * T[5]
            )
        positions.append(sum(value * so_far**power for power, value in enumerate(c)))
        velocities.append(sum(power * value * so_far ** (power - 1) for power, value in enumerate(c) if power))
    return positions, velocities
