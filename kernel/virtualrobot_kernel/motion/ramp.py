"""Quintic ramps of the rate of a running motion."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RateRamp:
    """Rate dtau/dt as a quintic of x = t / length on [0, length] s, then constantly `goal`.

    coefficients: of x^0 ... x^5, in the unit of the rate (1). A ramp of length 0 is the constant rate `goal`.
    """

    goal: float
    length: float = 0.0
    coefficients: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def state(self, t: float) -> tuple[float, float, float, float]:
        """Return rate, its first and second derivative (1/s, 1/s²), and the nominal time gone by since t = 0 (s)."""
        if not self.length:
            return self.goal, 0.0, 0.0, self.goal * t
        if t >= self.length:
            c0, c1, c2, c3, c4, c5 = self.coefficients
            gone = self.length * (c0 + c1 / 2.0 + c2 / 3.0 + c3 / 4.0 + c4 / 5.0 + c5 / 6.0)
            return self.goal, 0.0, 0.0, gone + self.goal * (t - self.length)
        x = t / self.length
        c0, c1, c2, c3, c4, c5 = self.coefficients
        rate = c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
        slope = (c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))) / self.length
        curvature = (2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5))) / self.length**2
        gone = t * (c0 + x * (c1 / 2.0 + x * (c2 / 3.0 + x * (c3 / 4.0 + x * (c4 / 5.0 + x * c5 / 6.0)))))
        return rate, slope, curvature, gone

    def time_when(self, gone: float) -> float:
        """Return the time (s) at which the nominal time `gone` (s) has gone by; inf when the rate falls to 0 before."""
        at_end = self.state(self.length)[3]
        if at_end < gone:
            return self.length + (gone - at_end) / self.goal if self.goal > 0.0 else math.inf
        low, high = 0.0, self.length
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.state(middle)[3] < gone else (low, middle)
        return high
