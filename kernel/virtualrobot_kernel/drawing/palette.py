"""Colours, widths and words of what people see beside the world, the same in the browser and in pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.clearances import Clearance
from virtualrobot_kernel.collision.scene import Nearest
from virtualrobot_kernel.sensing.measuring import Measurement, length
from virtualrobot_kernel.world.figures import Figure

Rgb = tuple[int, int, int]

INK: Rgb = (32, 74, 150)
"""The colour of points and lines that have none of their own."""

BOX_COLOR: Rgb = (222, 120, 20)
BOX_WIDTH = 2.0
"""Of the edges of bounding boxes, in pixels."""

MEASURE_COLOR: Rgb = (205, 35, 60)
MEASURE_WIDTH = 2.5
"""Of the line of a measured distance, in pixels."""

CLEARANCE_COLOR: Rgb = (0, 96, 130)
"""Of the line of a least distance."""
NEAR_METERS = 0.1
"""Least distances below are told in millimeters."""

CONTACT_COLOR: Rgb = (255, 214, 10)
CONTACT_SIZE = 0.02
"""Of the dots where things touch that may not, in meters."""

CELL_COLOR, SECTION_COLOR = (196, 202, 208), (150, 158, 166)
CELL_WIDTH, SECTION_WIDTH = 0.7, 1.1
"""Of the lines on the floor in pixels: around cells of 0.25 m, and around sections of 1 m."""
FADE_METERS, FADE_STRENGTH = 22.0, 1.5
"""Distance from the eye (m) at which the floor's lines have faded, and the exponent of their fading."""

SCAN_POINT_SIZE = 0.012
"""Of the echoes of a scan, in meters."""
RAY_WIDTH = 1.0
"""Of its rays, in pixels."""
FRUSTUM_COLOR: Rgb = (40, 60, 90)
FRUSTUM_WIDTH = 2.0
"""Of the edges of what a camera sees, in pixels."""

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
EDGES = np.array([(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1])
"""(12, 2) rows of CORNERS: corners that differ along one axis only."""


def ink(figure: Figure) -> Rgb:
    """Return the colour of a figure of points or lines in 8-bit parts."""
    if figure.material is None or figure.material.color is None:
        return INK
    red, green, blue, _ = figure.material.color
    return round(255 * red), round(255 * green), round(255 * blue)


def box_edges(box: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the edges (12, 2, 3) of a box given as lowest and highest corner (2, 3)."""
    return (box[0] + CORNERS * (box[1] - box[0]))[EDGES]


def measured_words(measurement: Measurement, points: NDArray[np.float64]) -> str:
    """Return what is written beside a measured distance between two points (2, 3)."""
    return f"{measurement.name}: {length(points):.3f} m"


def clearance_words(clearance: Clearance, nearest: Nearest) -> str:
    """Return what is written beside a least distance."""
    meters = nearest.distance
    return f"{clearance.name}: " + (f"{1000.0 * meters:.1f} mm" if meters < NEAR_METERS else f"{meters:.3f} m")
