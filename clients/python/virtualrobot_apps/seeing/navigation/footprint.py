"""Footprint of a vehicle: the rectangle that it covers on the floor, about the point that it turns about."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from virtualrobot_apps.seeing.navigation.poses import Floats


@dataclass(frozen=True, slots=True)
class Footprint:
    """Rectangle in the frame of the base: how far it reaches back and ahead, to the right and to the left (m)."""

    back: float
    ahead: float
    right: float
    left: float

    def __post_init__(self) -> None:
        """Raise ValueError where the base is not inside."""
        if not (self.back < 0.0 < self.ahead and self.right < 0.0 < self.left):
            raise ValueError(f"the base lies within its footprint, not {self}")

    @property
    def inner(self) -> float:
        """Distance (m) that it needs to either side of its way, along which it drives lengthwise."""
        return max(-self.right, self.left)

    @property
    def outer(self) -> float:
        """Radius (m) of the circle that it sweeps where it turns."""
        return float(np.hypot(max(-self.back, self.ahead), max(-self.right, self.left)))

    @property
    def width(self) -> float:
        """Width (m) of the narrowest passage that it goes through."""
        return self.left - self.right

    @property
    def turned(self) -> Footprint:
        """The same one for a base that looks backwards."""
        return Footprint(-self.ahead, -self.back, -self.left, -self.right)

    def outline(self, spacing: float = 0.05) -> Floats:
        """Return points (n, 2) of its edge, at most so far apart (m)."""
        corners = np.array(
            [(self.ahead, self.left), (self.back, self.left), (self.back, self.right), (self.ahead, self.right)]
        )
        sides = []
        for first, second in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            count = max(1, int(np.ceil(np.linalg.norm(second - first) / spacing)))
            sides.append(first + (second - first) * (np.arange(count) / count)[:, None])
        return np.vstack(sides)
