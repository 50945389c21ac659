"""Trajectories of ROS as values of the client library, and ends of motions as its error codes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from virtualrobot.motions.state import MotionState

from virtualrobot_apps.bridges.ros.mapping.basics import RosValue, nanoseconds_of

SUCCESSFUL, INVALID_GOAL, INVALID_JOINTS, OLD_HEADER_TIMESTAMP = 0, -1, -2, -3
PATH_TOLERANCE_VIOLATED, GOAL_TOLERANCE_VIOLATED = -4, -5
"""Error codes of control_msgs/FollowJointTrajectory."""

_CAUSES = {"path_tolerance": PATH_TOLERANCE_VIOLATED, "goal_tolerance": GOAL_TOLERANCE_VIOLATED}


class BadGoalError(ValueError):
    """A goal that can't be run; `code` is that of FollowJointTrajectory."""

    def __init__(self, code: int, words: str) -> None:
        """Name what is wrong."""
        super().__init__(words)
        self.code = code


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows of a trajectory.

    Attributes:
        joints: names of the joints, in the order of the columns.
        times: times from the start (s), shape (n,).
        positions: (n, k) in radians or meters.
        velocities: (n, k) or None where none are given.
        accelerations: (n, k) or None.
        start: simulation time of time 0 (s); None means now.
    """

    joints: tuple[str, ...]
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64] | None
    accelerations: NDArray[np.float64] | None
    start: float | None


def rows_of(trajectory: RosValue, known: Sequence[str], now: int) -> Rows:
    """Return the rows of a `trajectory_msgs/JointTrajectory`; `now` is the simulation time (ns).

    Raises:
        BadGoalError: for joints that the robot hasn't, rows that are no numbers of all joints, times that go back.
    """
    joints = tuple(trajectory.joint_names)
    if not joints or len(set(joints)) != len(joints):
        raise BadGoalError(INVALID_JOINTS, "'joint_names' names each joint that shall move once")
    if unknown := [one for one in joints if one not in known]:
        raise BadGoalError(INVALID_JOINTS, f"there is no joint {unknown[0]!r}; known: {', '.join(known)}")
    if not trajectory.points:
        raise BadGoalError(INVALID_GOAL, "a trajectory has at least one point")
    points = trajectory.points
    positions = _table(points, "positions", len(joints))
    velocities = _table(points, "velocities", len(joints))
    accelerations = _table(points, "accelerations", len(joints))
    if positions is None:
        raise BadGoalError(INVALID_GOAL, "each point has positions; velocities alone are not followed")
    if accelerations is not None and velocities is None:
        raise BadGoalError(INVALID_GOAL, "accelerations need velocities beside them")
    times = [nanoseconds_of(one.time_from_start) for one in points]
    if times[0] < 0 or any(later <= before for before, later in pairwise(times)):
        raise BadGoalError(INVALID_GOAL, "'time_from_start' grows from point to point, from 0 on")
    start = nanoseconds_of(trajectory.header.stamp)
    if start and start + times[-1] <= now:
        words = f"the trajectory ends at {(start + times[-1]) / 1e9:g} s, and it is {now / 1e9:g} s"
        raise BadGoalError(OLD_HEADER_TIMESTAMP, words)
    seconds = np.array(times) / 1e9
    return Rows(joints, seconds, positions, velocities, accelerations, start / 1e9 if start else None)


def _table(points: Sequence[RosValue], name: str, width: int) -> NDArray[np.float64] | None:
    """Return a value of all points (n, width), None where no point has it."""
    rows = [np.asarray(getattr(one, name), float) for one in points]
    if not any(len(one) for one in rows):
        return None
    for place, one in enumerate(rows):
        if len(one) != width:
            words = f"points[{place}] has {len(one)} {name} for {width} joints; all points have them, or none"
            raise BadGoalError(INVALID_GOAL, words)
        if not np.isfinite(one).all():
            raise BadGoalError(INVALID_GOAL, f"points[{place}].{name} has a number that is not finite")
    return np.array(rows)


def tolerances_of(found: Sequence[RosValue], joints: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return tolerances of joints by name: of position and velocity; 0, and below it, means any, as -1 does in ROS.

    Raises:
        BadGoalError: for a joint that the trajectory doesn't move, and what is not finite.
    """
    told: dict[str, tuple[float, float]] = {}
    for one in found:
        if one.name not in joints:
            raise BadGoalError(INVALID_GOAL, f"there is a tolerance of {one.name!r}, which the trajectory doesn't move")
        if not np.isfinite([one.position, one.velocity]).all():
            raise BadGoalError(INVALID_GOAL, f"the tolerance of {one.name!r} is not finite")
        position, velocity = max(0.0, one.position), max(0.0, one.velocity)
        if position or velocity:
            told[one.name] = position, velocity
    return told


def error_code(state: MotionState) -> int:
    """Return the error code of a motion that is over."""
    return SUCCESSFUL if not state.end_cause else _CAUSES.get(state.end_cause, INVALID_GOAL)


def words_of(state: MotionState) -> str:
    """Return why a motion has ended, with the joints that were beyond their tolerance."""
    off = [f"{one.joint}: {one.kind} off by {one.value:.3g}, tolerance {one.tolerance:g}" for one in state.deviations]
    return "; ".join([one for one in (state.end_reason, *off) if one])
