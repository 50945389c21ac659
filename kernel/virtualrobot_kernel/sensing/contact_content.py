"""Readings of contact sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Two elements that are near, or a point where they touch; points (3,) in the world's frame.

    `element` and `other` are nodes by name, `distance` is in meters, 0 where they touch; `normal` (3,) is from the
    first to the second where they touch, else None. `force` (3,) is that on the first in N, where physics tell it.
    """

    element: str
    other: str
    distance: float
    point: NDArray[np.float64]
    other_point: NDArray[np.float64]
    normal: NDArray[np.float64] | None
    force: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ContactContent:
    """The contacts, the nearest first."""

    contacts: tuple[Contact, ...]
