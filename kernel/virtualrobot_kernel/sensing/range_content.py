"""Readings of range sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.numeric import scan
from virtualrobot_kernel.sensing.patterns import Beams


@dataclass(frozen=True, slots=True, eq=False)
class RangeContent:
    """Reading of a range sensor; (r, c) is its pattern's shape.

    Attributes:
        distances: (r, c) meters; where `valid` is 0, what the sensor says then.
        valid: (r, c) 1 or 0.
        intensities: (r, c) strength of the echoes, 0 to 1.
        elements: (r, c) places in `element_names`; -1 where the beam's first ray hits nothing.
        element_names: the nodes that can be seen.
        beams: where the beams went, in the sensor's frame.
        ages: (c,) how long before the reading each column was measured, in seconds; None: all at its instant.
    """

    distances: NDArray[np.float32]
    valid: NDArray[np.uint8]
    intensities: NDArray[np.float32]
    elements: NDArray[np.int32]
    element_names: tuple[str, ...]
    beams: Beams
    ages: NDArray[np.float32] | None

    def points(self, frame_t_sensor: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return where the echoes come from, (r, c, 3), in the frame that the sensor is at `frame_t_sensor` (4, 4) in.

        NaN where a distance is not valid. Columns of a turning head are put where the sensor is at the reading's
        instant, as a driver does that knows no motion: `ages` says how long before each was measured.
        """
        points = np.empty((self.distances.size, 3), np.float32)
        pose, beams = np.ascontiguousarray(frame_t_sensor), self.beams
        scan.points_of(pose, beams.origins, beams.directions, self.distances.ravel(), self.valid.ravel(), points)
        return points.reshape(*self.distances.shape, 3)
