"""Bases that drives move: where they are on the way of a program, as whoever knows the crafts tells it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.planning.steps import Column
from virtualrobot_kernel.world.state import Snapshot

Floats = NDArray[np.float64]


class CarriedBases(Protocol):
    """All coordinates of a world on the way of a program, by nominal time; `places` (k,) in q are those of bases."""

    places: NDArray[np.int64]

    def at(self, time: float) -> Floats:
        """Return all coordinates (nq,) at a time (s)."""
        ...

    def rates(self, q: Floats, rates: Floats) -> Floats:
        """Return the rates (k,) of the bases' coordinates at coordinates q (nq,) whose drives have `rates` (nq,)."""
        ...


Follow = Callable[[Snapshot, Program, Sequence[Column]], CarriedBases | None]
"""Function that tells where a program takes bases, by a world and robot and joint of its columns; None: nowhere."""
