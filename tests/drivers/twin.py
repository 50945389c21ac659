"""Twin by formula: joints that swing between two places, and brake with a constant deceleration from anywhere."""

from __future__ import annotations

import numpy as np
from virtualrobot_sdk.drivers.shared import CellBlock, TickRing

TICK_NS = 4_000_000
SECONDS = TICK_NS * 1e-9
PERIOD = 2.0
"""Time (s) of a swing to and fro."""

DECELERATION = 8.0
"""Deceleration (rad/s²) by which all joints brake."""


class Twin:
    """Twin whose joints swing as `amplitude · (1 - cos(2πt / PERIOD)) / 2` about where they begin, from a tick on."""

    def __init__(self, rings: dict[TickRing, np.ndarray], cell: CellBlock, begin_ns: int, lead_ns: int) -> None:
        """Write to rings, each with the amplitudes (k,) of its joints; tick 0 is due at `begin_ns`, played later."""
        self.rings, self.cell, self.begin_ns, self.lead_ns = rings, cell, begin_ns, lead_ns
        self.tick = -1
        self.starts = {ring: np.zeros(ring.joints) for ring in rings}
        self.swings = True
        self.from_tick = 0

    def state(self, ring: TickRing, tick: float) -> tuple[np.ndarray, np.ndarray]:
        """Return q and v (k,) at a tick."""
        angle = 2.0 * np.pi * max(tick - self.from_tick, 0) * SECONDS / PERIOD if self.swings else 0.0
        q = self.rings[ring] * (1.0 - np.cos(angle)) / 2.0
        return self.starts[ring] + q, self.rings[ring] * np.sin(angle) * np.pi / PERIOD

    def brake(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the way to rest (m, k), all joints together, the fastest one by DECELERATION."""
        fastest = float(np.abs(v).max())
        ticks = np.arange(np.ceil(fastest / DECELERATION / SECONDS) + 1) * SECONDS
        ticks[-1] = fastest / DECELERATION
        share = 1.0 - DECELERATION * ticks / (2.0 * fastest) if fastest else np.zeros(1)
        return q + (ticks * share)[:, None] * v

    def write(self, until: int, braked: bool = True) -> None:
        """Write the ticks up to one."""
        for tick in range(self.tick + 1, until + 1):
            for ring in self.rings:
                q, v = self.state(ring, tick)
                play_ns = self.begin_ns + tick * TICK_NS + self.lead_ns
                ring.put(tick, play_ns, q, v, tick % 8, self.brake(q, v) if braked else None)
            self.cell.complete(tick, braked)
        self.tick = max(self.tick, until)
