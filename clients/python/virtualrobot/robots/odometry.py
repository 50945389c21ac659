"""Odometry of crafts: where they should be by the angles of their wheels, and how far that is from where they are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message, array_of, settings_message
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.description import joints_now
from virtualrobot.sensors.motion_sensors import EncoderReading
from virtualrobot.v1 import robot_pb2

Floats = NDArray[np.float64]

SURE = 1e-7
"""Part of a count by which a wheel may be short of it and has it: rounding decides nothing."""


@shown
@dataclass(frozen=True, slots=True, eq=False)
class OdometryReading:
    """Reckoned place of a craft's base in the frame of its robot.

    Attributes:
        pose: (3,) x, y (m) and heading (rad), which goes on beyond a turn.
        covariance: (3, 3), how sure that is.
    """

    pose: Floats
    covariance: Floats


@checked
class Odometry:
    """Way of a craft, reckoned from the angles of its drives by its component, or one that is thought to be otherwise.

    It begins where the craft is. Each `update` goes on from the one before, on an arc: it may be as seldom as the
    drives go evenly.

    Example:
        >>> odometry = robot.odometry(counts_per_turn=64)
        >>> odometry.update().pose
        array([...])
        >>> odometry.drift()
        array([...])
    """

    def __init__(
        self,
        services: Services,
        robot: str,
        *,
        counts_per_turn: int | None = None,
        settings: Mapping[str, object] | None = None,
        variance_per_radian: float = 0.0,
        encoders: EncoderReading | None = None,
    ) -> None:
        """Begin where the craft is; `Robot.odometry` makes one."""
        if counts_per_turn is not None and counts_per_turn < 1:
            raise InvalidArgumentError(f"counts_per_turn is 1 or above, not {counts_per_turn}")
        if not 0.0 <= variance_per_radian < math.inf:
            raise InvalidArgumentError(f"variance_per_radian is 0 or above, not {variance_per_radian:g}")
        self._services, self._robot = services, robot
        self._step = None if counts_per_turn is None else math.tau / counts_per_turn
        self._settings = None if settings is None else settings_message(settings)
        self._variance = variance_per_radian
        solved = self._solved()
        self._joints = tuple(solved.joint_names)
        self._last = self._counted(encoders)
        place = np.array([solved.x_meters, solved.y_meters, solved.heading_radians])
        self._reading = OdometryReading(place, np.zeros((3, 3)))
        if settings is not None:
            self._went([])  # what the component refuses of them is told at once

    @property
    def reading(self) -> OdometryReading:
        """Return the place as of the last update."""
        return self._reading

    def update(self, encoders: EncoderReading | None = None) -> OdometryReading:
        """Return where the craft should be by now.

        Args:
            encoders: what its encoders say, with all its drives among their joints; None: where the joints are.

        Raises:
            InvalidArgumentError: when the encoders don't tell a drive, and for settings that the component refuses.
            WrongStateError: when the robot is no craft any more.
            PluginFailedError: when its component has failed.
        """
        self._went([self._counted(encoders)])
        return self._reading

    def reckon(self, encoders: Sequence[EncoderReading]) -> Floats:
        """Return where the craft should have been, (n, 3) x, y (m) and heading (rad), at readings of its encoders.

        As `update` with each of them, the oldest first, in one call; `reading` is of the last one then.

        Raises:
            InvalidArgumentError: for more readings than the kernel takes in one call, and as `update` does.
        """
        return self._went([self._counted(one) for one in encoders])

    def _went(self, angles: Sequence[Floats]) -> Floats:
        """Go on by where the drives were, one after the other; return the poses (n, 3) there."""
        x, y, heading = self._reading.pose.tolist()
        request = robot_pb2.ReckonDrivesRequest(
            robot=self._robot,
            joint_names=self._joints,
            positions=array_message(np.array([self._last, *angles])),
            settings=self._settings,
            x_meters=x,
            y_meters=y,
            heading_radians=heading,
            covariance=array_message(self._reading.covariance),
            variance_per_radian=self._variance,
        )
        found = self._services.robot.ReckonDrives(request)
        self._last = angles[-1] if angles else self._last
        poses = array_of(found.poses)
        self._reading = OdometryReading(poses[-1], array_of(found.covariances)[-1])
        return poses[1:]

    def drift(self, true_pose: ArrayLike | None = None) -> Floats:
        """Return by how much the last update is off: x, y (m) and heading (rad, within half a turn), shape (3,).

        Args:
            true_pose: (3,) x, y and heading where the craft really was then, in the frame of its robot; None: where it
                is now.
        """
        if true_pose is None:
            solved = self._solved()
            true_pose = (solved.x_meters, solved.y_meters, solved.heading_radians)
        off = self._reading.pose - np.asarray(true_pose, dtype=float)
        return np.array([off[0], off[1], math.remainder(off[2], math.tau)])

    def _solved(self) -> robot_pb2.SolveDrivesResponse:
        request = robot_pb2.SolveDrivesRequest(robot=self._robot, parts=array_message(np.zeros((0, 3))))
        return self._services.robot.SolveDrives(request)

    def _counted(self, encoders: EncoderReading | None) -> Floats:
        """Return where the drives are, in whole counts where they are counted."""
        if encoders is None:
            told: Mapping[str, float] = joints_now(self._services, self._robot)
        else:
            told = dict(zip(encoders.joint_names, encoders.positions.tolist(), strict=True))
        if missing := next((name for name in self._joints if name not in told), None):
            raise InvalidArgumentError(
                f"the encoders don't tell the drive {missing!r} of {self._robot!r}; they tell {', '.join(told)}"
            )
        angles = np.array([told[name] for name in self._joints])
        return angles if self._step is None else np.floor(angles / self._step + SURE) * self._step
