"""Ways of feet through the air: smooth at both ends, so that a foot leaves the ground and is set down at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def blend(part: Floats) -> Floats:
    """Return the way along a minimum-jerk motion at parts (...) of its time, from 0 to 1.

    10 u^3 - 15 u^4 + 6 u^5: speed and acceleration are 0 at both ends (Flash and Hogan 1985).
    """
    u = np.clip(part, 0.0, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def lift(part: Floats) -> Floats:
    """Return the height of a foot at parts (...) of its swing: (4 u (1 - u))^3, 1 in the middle."""
    u = np.clip(part, 0.0, 1.0)
    return (4.0 * u * (1.0 - u)) ** 3


def swing_height(start: float, end: float, clearance: float, ground: Floats) -> float:
    """Return the factor of `lift` (m) by which a foot clears both ends, and what lies between, by `clearance` (m).

    `start` and `end` are the heights of the places that it leaves and gets to, `ground` (m,) heights at even parts of
    the way between, both ends included.
    """
    # Near its ends a foot is about as high as the ground there; in between it goes over what there is.
    part = np.linspace(0.0, 1.0, len(ground))
    # Places are spread evenly along the way, which the foot goes along as `blend` says.
    time = np.interp(part, blend(_FINE), _FINE)
    inner = (time > 0.25) & (time < 0.75)
    needed = (ground - (start + (end - start) * part))[inner] / lift(time[inner])
    return clearance + float(needed.max(initial=abs(end - start) / 2.0))


def swing(part: Floats, start: Floats, end: Floats, height: float) -> Floats:
    """Return places (n, 3) of a foot at parts (n,) of its swing from `start` (3,) to `end` (3,), lifted by `height`."""
    way = start + (end - start) * blend(part)[:, None]
    way[:, 2] += height * lift(part)
    return way


_FINE = np.linspace(0.0, 1.0, 401)
