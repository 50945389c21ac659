"""Units that files of vehicles may use, each with its factor to SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from virtualrobot_sdk.errors import ArgumentError

STANDARD_GRAVITY = 9.80665
"""Acceleration by which a kilogram-force is a force (m/s^2)."""

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "mass": {"kg": 1.0, "g": 1e-3, "lb": 0.45359237},
        "volume": {"m3": 1.0, "L": 1e-3, "cm3": 1e-6},
        "density": {"kg/m3": 1.0},
        "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254},
        "area": {"m2": 1.0, "cm2": 1e-4},
        "time": {"s": 1.0, "ms": 1e-3},
        "angle": {"rad": 1.0, "deg": math.pi / 180.0},
        "turning speed": {"rad/s": 1.0, "rpm": math.pi / 30.0, "1/s": 2.0 * math.pi},
        "force": {"N": 1.0, "kgf": STANDARD_GRAVITY, "lbf": 0.45359237 * STANDARD_GRAVITY},
        "moment of inertia": {"kg m2": 1.0},
        "ratio": {"1": 1.0},
        # Entries of a matrix over forces and moments have units of their own: those of SI.
        "matrix": {"SI": 1.0},
    }
)
"""Units by what is measured in them."""


def factor(kind: str, unit: str, place: str) -> float:
    """Return the factor from `unit` to SI.

    Raises ArgumentError, naming the `place`, when it is no unit of this kind.
    """
    known = UNITS[kind]
    if unit not in known:
        raise ArgumentError(f"{place} has the unit {unit!r}; a {kind} is in {' or '.join(known)}", place=place)
    return known[unit]
