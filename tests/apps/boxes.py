"""How deep boxes are in each other, by the separating axis theorem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def penetration(
    pose: NDArray[np.float64], size: NDArray[np.float64], poses: NDArray[np.float64], sizes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how deep a box is in each of n others, in meters, (n,); negative where they are apart.

    `pose` (4, 4) and `poses` (n, 4, 4) are of the middles, `size` (3,) and `sizes` (n, 3) the edge lengths.

    Source: S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996, section 5: two boxes are apart when their
    shadows are apart on one of 15 axes: the edges of both, and the products of each two of them.
    """
    mine = np.broadcast_to(pose[:3, :3], (len(poses), 3, 3))
    others = poses[:, :3, :3]
    products = np.cross(mine[:, :, :, None], others[:, :, None, :], axis=1).reshape(-1, 3, 9)
    axes = np.concatenate([mine, others, products], axis=2)  # (n, 3, 15), columns
    length = np.linalg.norm(axes, axis=1)
    parallel = length < 1e-6  # a product of parallel edges is no axis
    axes = axes / np.where(parallel, 1.0, length)[:, None, :]
    shadow = sum(
        np.abs(np.einsum("nij,nik->njk", edges, axes) * (half[:, :, None] / 2)).sum(axis=1)
        for edges, half in ((mine, np.broadcast_to(size, sizes.shape)), (others, sizes))
    )
    distance = np.abs(np.einsum("ni,nik->nk", poses[:, :3, 3] - pose[:3, 3], axes))
    return np.where(parallel, np.inf, shadow - distance).min(axis=1)
