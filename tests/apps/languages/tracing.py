"""Ways of an arm's tool centre point while something runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import virtualrobot


def traced(client: virtualrobot.Client, run: Callable[[], object]) -> np.ndarray:
    """Run something and return time and place (s, m) of the arm's tool centre point at each tick meanwhile, (n, 4)."""
    rows = []
    with client.streams.watch("/robots/arm/tcp") as watch:
        run()
        end = client.clock.simulation_time
        while (sample := watch.next(1.0)) is not None and sample.time < end:
            assert sample.lost == 0
            rows.append([sample.time, *(sample.values[axis] for axis in "xyz")])
    return np.array(rows)
