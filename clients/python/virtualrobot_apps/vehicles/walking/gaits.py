"""Gaits: when each foot of a walking machine is on the ground.

A cycle is the time from one step of a foot to its next. The duty factor is the part of it that a foot is on the ground,
and the phase of a leg is the part of a cycle after which its foot is set down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Gait:
    """Regular gait: all feet step once in a cycle.

    name: for people. duty_factor: above 0, below 1. phases: of each leg, 0 to 1. cycle: its length (s).
    """

    name: str
    duty_factor: float
    phases: tuple[float, ...]
    cycle: float

    def __post_init__(self) -> None:
        """Raise ValueError where a number is none of a gait."""
        if not 0.0 < self.duty_factor < 1.0:
            raise ValueError(f"a duty factor is above 0 and below 1, not {self.duty_factor:g}")
        if not all(0.0 <= phase < 1.0 for phase in self.phases):
            raise ValueError(f"phases are from 0 to below 1, not {self.phases}")
        if not 0.0 < self.cycle < math.inf:
            raise ValueError(f"a cycle is longer than 0 s, not {self.cycle:g}")

    @property
    def swing_time(self) -> float:
        """Time that a foot is in the air (s)."""
        return (1.0 - self.duty_factor) * self.cycle

    def speed(self, stroke: float) -> float:
        """Return the speed (m/s) at which a foot goes back by `stroke` (m) while it is on the ground.

        That is stroke / (duty factor * cycle).
        """
        return stroke / (self.duty_factor * self.cycle)

    def stroke(self, speed: float) -> float:
        """Return how far (m) a foot goes back, seen from the body, while it is on the ground."""
        return speed * self.duty_factor * self.cycle

    def swings(self, leg: int, until: float) -> list[tuple[float, float]]:
        """Return begin and end (s) of each swing of a leg that lies wholly between 0 and `until`."""
        first = self.phases[leg] + self.duty_factor - 1.0
        begins = [(first + number) * self.cycle for number in range(math.ceil(until / self.cycle) + 2)]
        small = 1e-9 * self.cycle
        return [
            (max(begin, 0.0), min(begin + self.swing_time, until))
            for begin in begins
            if begin >= -small and begin + self.swing_time <= until + small
        ]


def wave_gait(pairs: int, duty_factor: float, cycle: float, name: str = "wave") -> Gait:
    """Return the wave gait of so many pairs of legs: left and right from front to rear, in turn.

    Steps run from the rear to the front, half a cycle later on the right side. Of all periodic gaits it has the
    greatest stability margin along its way (Song and Waldron, Machines That Walk, 1989, chapter 3; of four legs McGhee
    and Frank 1968). It is statically stable from the duty factor 3 / (legs) on; with six legs 1/2 is the tripod gait.
    """
    if pairs < 2:
        raise ValueError(f"a wave gait takes two pairs of legs or more, not {pairs}")
    least = 3.0 / (2 * pairs)
    if not least - 1e-9 <= duty_factor < 1.0:
        raise ValueError(
            f"a wave gait of {2 * pairs} legs has a duty factor from {least:g} to below 1, not {duty_factor:g}"
        )
    lags = [pair * duty_factor + side for pair in range(pairs) for side in (0.0, 0.5)]
    return Gait(name, duty_factor, tuple(_part(lag) for lag in lags), cycle)


def trot(cycle: float, duty_factor: float = 0.5) -> Gait:
    """Return the trot of four legs (left front, right front, left rear, right rear): diagonal ones step together."""
    return Gait("trot", duty_factor, (0.0, 0.5, 0.5, 0.0), cycle)


def _part(lag: float) -> float:
    """Return what is beyond whole cycles, so that 1 to the last digits is 0."""
    part = lag % 1.0
    return 0.0 if part > 1.0 - 1e-12 else part


HEXAPOD_GAITS = {
    "tripod": wave_gait(3, 1 / 2, 0.8, "tripod"),
    "ripple": wave_gait(3, 2 / 3, 1.2, "ripple"),
    "wave": wave_gait(3, 5 / 6, 2.4, "wave"),
}
"""Gaits of six legs: left front, right front, left middle, right middle, left rear, right rear."""

QUADRUPED_GAITS = {"crawl": wave_gait(2, 0.85, 2.4, "crawl"), "trot": trot(0.5)}
"""Gaits of four legs: left front, right front, left rear, right rear."""


def longitudinal_margin_of_wave(pairs: int, duty_factor: float, pitch: float, stroke: float) -> float:
    """Return the longitudinal stability margin (m) of a wave gait by its closed form.

    S = (n/4 - 1) P + (1 - 3/(4 b)) R for n legs, the pitch P from foot to foot of a side and the stroke R <= P (Song
    and Waldron 1989, chapter 3); with four legs that is (b - 3/4) of the stride (McGhee and Frank 1968).
    """
    return (pairs / 2.0 - 1.0) * pitch + (1.0 - 0.75 / duty_factor) * stroke
