"""Colours of values from low to high, by polynomials that are published with their tables.

Turbo (A. Mikhailov, Turbo, An Improved Rainbow Colormap for Visualization, 2019) is that of R. Du, within 32 of 255 of
the table; viridis (N. Smith, S. van der Walt, 2015) that of M. Zucker.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]

_STEPS = np.linspace(0.0, 1.0, 256)
_TURBO = np.array(
    [
        [0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943],
        [0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604],
        [0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973],
    ]
)
"""(3, 6) coefficients of red, green and blue, from the constant on."""
_VIRIDIS = np.array(
    [
        [0.27772733, 0.10509304, -0.33086183, -4.63423050, 6.22826994, 4.77638500, -5.43545586],
        [0.00540734, 1.40461353, 0.21484756, -5.79910097, 14.17993337, -13.74514538, 4.64585260],
        [0.33409980, 1.38459016, 0.09509516, -19.33244096, 56.69055260, -65.35303263, 26.31243525],
    ]
)
"""(3, 7) coefficients likewise."""


class ColorMap(Enum):
    """Colours that values are shown in; the numbers are the contract's."""

    VIRIDIS = 1
    TURBO = 2
    HEAT = 3


def _table(colors: NDArray[np.float64]) -> Bytes:
    return np.rint(255.0 * np.clip(colors, 0.0, 1.0)).astype(np.uint8)


TABLES = {
    ColorMap.VIRIDIS: _table(_STEPS[:, None] ** np.arange(7) @ _VIRIDIS.T),
    ColorMap.TURBO: _table(_STEPS[:, None] ** np.arange(6) @ _TURBO.T),
    ColorMap.HEAT: _table(3.0 * _STEPS[:, None] - np.arange(3)),
}
"""(256, 3) the colours of each map (sRGB), at equal steps."""


def turbo(parts: NDArray[Any]) -> Bytes:
    """Return the colours (n, 3) of numbers (n,) from 0 (violet) to 1 (dark red); what lies outside counts as an end."""
    return TABLES[ColorMap.TURBO][np.rint(255.0 * np.clip(parts, 0.0, 1.0)).astype(np.intp)]


def palette(color_map: ColorMap) -> Bytes:
    """Return the colours (256, 3) of bytes whose 0 says that nothing is there: 1 is the lowest, 255 the highest."""
    return TABLES[color_map][np.rint(np.maximum(np.arange(256) - 1, 0) * (255.0 / 254.0)).astype(np.intp)]
