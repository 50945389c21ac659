"""Following a black line by a camera, and stopping for what a laser sees ahead.

Reference: "Boe-Bot simulation in Gazebo", sections 5.2 and 5.3: a crop of the picture, hue, saturation and value, a
mask of what is black, the contours and their centre of mass, towards which it turns; the laser says whether it may go.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import WrongStateError

SPEED = 0.1
"""Speed along the line (m/s)."""
GAIN = 2.5
"""Turning rate (rad/s) for a line whose bearing in the picture has the tangent 1."""
QUICKEST = 1.0
"""Greatest turning rate (rad/s)."""
STOP_DISTANCE = 0.1
"""Distance (m) from the laser at which it stands: that of the program which the document's appendix names."""
BLACK = 70
"""Greatest value, of 255, of what counts as black."""
LEAST_AREA = 200.0
"""Pixels that a contour has at least; less is noise."""
LOST = 20
"""Pictures without a line after which it is lost."""


@dataclass(frozen=True)
class Sight:
    """Line as a picture shows it: its centre of mass (pixels from the upper left), the picture's width, its lens."""

    x: float
    y: float
    width: int
    focal: float

    @property
    def bearing(self) -> float:
        """Return the tangent of the angle from straight ahead to the line, to the right positive."""
        return (self.x - 0.5 * (self.width - 1)) / self.focal


def find_line(color: NDArray[np.uint8], focal: float) -> Sight | None:
    """Return where a picture (h, w, 3) of red, green and blue shows a black line; None where it shows none.

    `focal` is the lens's focal length in pixels. Of several black things the largest counts. Raises WrongStateError
    where OpenCV is not installed.
    """
    cv2 = library()
    height, width = color.shape[:2]
    # The upper three quarters: below, the robot's own tyres and shadow may be seen.
    cropped = np.ascontiguousarray(color[: 3 * height // 4])
    hsv = cv2.cvtColor(cropped, cv2.COLOR_RGB2HSV)
    mask = cv2.inRange(hsv, np.array([0, 0, 0]), np.array([180, 255, BLACK]))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest: Any = max(contours, key=cv2.contourArea, default=None)
    if largest is None or cv2.contourArea(largest) < LEAST_AREA:
        return None
    moments = cv2.moments(largest)
    return Sight(moments["m10"] / moments["m00"], moments["m01"] / moments["m00"], width, focal)


class LineFollower:
    """Says how to drive, picture by picture; it keeps how long it has seen no line."""

    def __init__(self, speed: float = SPEED) -> None:
        """Follow at a speed (m/s)."""
        self._speed = speed
        self._turning = 0.0
        self._unseen = 0

    @property
    def is_lost(self) -> bool:
        """Return whether it has seen no line for so long that it stands."""
        return self._unseen >= LOST

    def twist(self, line: Sight | None, obstacle: float) -> tuple[float, float]:
        """Return speed (m/s) and turning rate (rad/s, to the left) for what camera and laser say.

        `obstacle` is the least distance that the laser measures (m); inf for none. Where no line is seen it turns on
        the spot to the side where the line was last, until it is lost.
        """
        if obstacle < STOP_DISTANCE:
            return 0.0, 0.0
        if line is None:
            self._unseen += 1
            return 0.0, 0.0 if self.is_lost else math.copysign(0.5 * QUICKEST, self._turning)
        self._unseen = 0
        self._turning = min(QUICKEST, max(-QUICKEST, -GAIN * line.bearing))
        return self._speed, self._turning


def library() -> ModuleType:
    """Return OpenCV; raise WrongStateError, which says how to install it, where it is missing."""
    try:
        import cv2
    except ImportError:
        raise WrongStateError("pictures are looked at by OpenCV: pip install 'virtualrobot[vision]'") from None
    return cv2
