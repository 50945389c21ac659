"""Damping of a contact from which what hits it comes back with a given part of its speed."""

from __future__ import annotations

import math


def damping_ratio(restitution: float) -> float:
    """Return the damping ratio of a spring that only pushes, which sends a mass back with this part of its speed.

    It ends where its force does, before it is long again: T. Schwager and T. Poschel, Coefficient of restitution and
    linear-dashpot model revisited, Granular Matter 9, 2007. Between 0 and 1 it is found by halving.
    """
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if _restitution(middle) > restitution else (low, middle)
    return high


def _restitution(ratio: float) -> float:
    """Return the part of the speed after an impact, for a damping ratio below 1."""
    rate = math.sqrt(1.0 - ratio * ratio)
    # The force -2 ratio x' - x of x = exp(-ratio t) sin(rate t) is 0 first where rate t is this angle.
    angle = math.atan2(2.0 * ratio * rate, 2.0 * ratio * ratio - 1.0)
    if angle < 0.0:
        angle += math.pi
    t = angle / rate
    return math.exp(-ratio * t) * (ratio / rate * math.sin(angle) - math.cos(angle))
