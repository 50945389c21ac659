"""The transfer curve of sRGB (IEC 61966-2-1): colours as screens show them, and as linear light, which glTF stores."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def to_linear(color: ArrayLike) -> NDArray[np.float64]:
    """Return sRGB parts of 0 to 1, in any shape, as linear light of 0 to 1; what lies outside is cut off."""
    parts = np.clip(np.asarray(color, np.float64), 0.0, 1.0)
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def from_linear(light: ArrayLike) -> NDArray[np.float64]:
    """Return linear light of 0 to 1, in any shape, as sRGB parts of 0 to 1; what lies outside is cut off."""
    parts = np.clip(np.asarray(light, np.float64), 0.0, 1.0)
    return np.where(parts <= 0.0031308, 12.92 * parts, 1.055 * parts ** (1.0 / 2.4) - 0.055)
