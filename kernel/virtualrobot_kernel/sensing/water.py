"""Water before a camera: light fades on its way by the law of Beer and Lambert, and the water's own takes its place.

I = J e^(-c d) + W (1 - e^(-c d)) in linear light, for each colour: the direct part and the veil of backscatter of B. L.
McGlamery (A computer model for underwater camera systems, SPIE 208, 1980) and J. S. Jaffe (IEEE Journal of Oceanic
Engineering 15, 1990), light that is scattered forward left out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.srgb import to_linear

from virtualrobot_kernel.sensing.lenses import Lens
from virtualrobot_kernel.sensing.textures import TO_LIGHT, TO_SCREEN

FARTHEST = 1e6
"""Distance (m) of what is nowhere."""


def stretches(lens: Lens) -> NDArray[np.float32]:
    """Return how far along its ray a pixel sees for each meter of depth (h, w); 0 where it looks nowhere."""
    stretch = np.zeros(lens.width * lens.height, np.float32)
    with np.errstate(divide="ignore"):
        stretch[lens.pixels] = np.nan_to_num(1.0 / lens.slants, nan=0.0, posinf=0.0)
    return stretch.reshape(lens.height, lens.width)


def through_water(
    color: NDArray[np.uint8],
    distance: NDArray[np.float32],
    attenuation: tuple[float, float, float],
    water: tuple[float, ...] | None,
) -> NDArray[np.uint8]:
    """Return a picture (h, w, 3) as sRGB through water.

    `distance` (h, w) is that of what is seen (m), finite, `attenuation` that of red, green and blue (1/m), and `water`
    the sRGB colour of water in which nothing is, None for black.
    """
    kept = np.exp(-distance[..., None] * np.asarray(attenuation, np.float32))
    veil = to_linear(water[:3] if water else (0.0, 0.0, 0.0)).astype(np.float32)
    light = TO_LIGHT[color] * kept + veil * (1.0 - kept)
    return TO_SCREEN[np.rint(light * (len(TO_SCREEN) - 1)).astype(np.intp)]
