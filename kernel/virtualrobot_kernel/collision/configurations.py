"""Check of many configurations: the job that a collision process does for a block of them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.collision.scene import Detail
from virtualrobot_kernel.collision.site import Site
from virtualrobot_kernel.planning.robots import standing_at

CHECK_BLOCK = f"{__name__}:check_block"
"""The path of `check_block`, for `Processes.submit`."""


def check_block(
    site: Site, q_index: NDArray[np.int32], rows: NDArray[np.float64], robots: Collection[int] | None
) -> NDArray[np.int64]:
    """Return a pair of nodes (uids) that touch and may not in each of n configurations, (n, 2); zeros where it is free.

    Args:
        site: where it works.
        q_index: (k,) which coordinates differ from the world's.
        rows: (n, k) the configurations, rad or m.
        robots: only pairs with these robots (uids) are checked; None means all.
    """
    found = np.zeros((len(rows), 2), np.int64)
    for at, row in enumerate(rows):
        site.go_on()
        site.scene.place(standing_at(site.snapshot, q_index, row))
        for pair in site.scene.collisions(Detail.FIRST, robots):
            found[at] = pair.first, pair.second
    return found
