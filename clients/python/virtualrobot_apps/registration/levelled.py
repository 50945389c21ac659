"""Markers of a camera that knows what is up: two of the three turns of a small square are told by gravity, too."""

from __future__ import annotations

import dataclasses

import numpy as np
from virtualrobot._wire.arguments import ArrayLike
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.registration.marker_pose import CORNER, SeenMarker
from virtualrobot_apps.registration.square_fit import Gravity

TILT = 0.003
"""Standard deviation (rad) of what a resting accelerometer takes for up, about each level axis."""

MOST_LEANING = np.radians(15.0)
"""Angle (rad) between what is up by a marker and by a camera beyond which one of them is told wrongly."""


def levelled(seen: SeenMarker, marker_up: ArrayLike, camera_up: ArrayLike, tilt: float = TILT) -> SeenMarker:
    """Return a marker by its corners and by gravity, each as far as it is good: of its two poses the upright one.

    Weighted least squares of where the corners were seen and of what is up.

    Args:
        seen: the marker.
        marker_up: (3,) away from gravity in the marker's frame.
        camera_up: (3,) that in the camera's frame, as its accelerometer tells.
        tilt: the standard deviation of that about each level axis, rad.

    Raises:
        InvalidArgumentError: for a direction of no length, and where gravity fits neither pose.
    """
    up, told = (np.asarray(one, dtype=float) for one in (marker_up, camera_up))
    if not min(np.linalg.norm(up), np.linalg.norm(told)) > 1e-6:
        raise InvalidArgumentError("what is up for the camera is a direction, such as 0, -1, 0, and no zero")
    up, told = up / np.linalg.norm(up), told / np.linalg.norm(told)
    both = [seen.camera_t_marker, *([] if seen.second is None else [seen.second])]
    pose = max(both, key=lambda one: float(one[:3, :3] @ up @ told))
    leaning = float(np.arccos(np.clip(pose[:3, :3] @ up @ told, -1.0, 1.0)))
    if leaning > MOST_LEANING:
        raise InvalidArgumentError(
            f"what is up for the camera is {np.degrees(leaning):.0f} degrees off what it is by the marker: look "
            "whether the sheet hangs as the model has it, and which of the camera's axes are told"
        )
    good = max(CORNER, seen.deviation)
    pose, covariance = seen.straight.fit(pose, good, Gravity(up, told, tilt))
    deviation = seen.straight.deviation(pose)
    return dataclasses.replace(
        seen, camera_t_marker=pose, deviation=deviation, second=None, twist_covariance=covariance
    )
