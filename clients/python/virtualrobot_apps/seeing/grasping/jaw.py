"""Jaws: two parallel fingers, as grasps are sought for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from virtualrobot.errors import InvalidArgumentError


@dataclass(frozen=True, slots=True)
class Jaw:
    """Two parallel fingers about a tool centre point between them: z leads out of the hand, y from one to the other.

    opening: greatest distance between fingers. wide, thick: of a finger, along x and y. long: of a finger from its tip
    back. tip: by how much tips are beyond the tool centre point (all m).
    """

    opening: float
    wide: float = 0.02
    thick: float = 0.01
    long: float = 0.05
    tip: float = 0.01

    def __post_init__(self) -> None:
        """Raise InvalidArgumentError for sizes that no jaw has."""
        if not all(size > 0.0 and np.isfinite(size) for size in (self.opening, self.wide, self.thick, self.long)):
            raise InvalidArgumentError(f"sizes of a jaw are above 0, not {self}")
