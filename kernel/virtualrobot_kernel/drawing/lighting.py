"""The light that a scene without lights is seen in, as near to the browser's as rays have it."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_kernel.numeric.illumination import DIRECTIONAL, SKY
from virtualrobot_kernel.numeric.shading import AMBIENT
from virtualrobot_kernel.sensing.lights import Lights


def _row(kind: int, source: tuple[float, float, float], strength: float, color: tuple[int, int, int]) -> list[float]:
    """Return a row of the table for a light from far away in the direction `source`."""
    along = -np.array(source) / np.linalg.norm(source)
    return [kind, 0.0, 0.0, 0.0, *along, *(strength * to_linear(np.array(color) / 255.0)), 0.0, 0.0]


WHITE = (255, 255, 255)

VIEW = Lights(
    np.array(
        [
            _row(DIRECTIONAL, (1.5, -2.5, 5.0), 0.62, (255, 250, 242)),
            _row(DIRECTIONAL, (4.0, 3.0, 1.5), 0.16, (225, 235, 255)),
            _row(SKY, (0.0, 0.0, 1.0), 0.26, WHITE),
            _row(SKY, (0.0, 0.0, -1.0), 0.06, WHITE),
        ],
        np.float32,
    ),
    np.zeros(4, np.bool_),
)
"""A key light from the front, a cool fill light from the right, light from the sky; no shadows, as in the browser."""

FLAT = Lights(
    np.array([_row(SKY, (0.0, 0.0, side), 1.0 - AMBIENT, WHITE) for side in (1.0, -1.0)], np.float32),
    np.zeros(2, np.bool_),
)
"""Light from everywhere: surfaces show their own colour."""
