"""An occupancy map as an octree, by OctoMap.

A. Hornung, K. M. Wurm, M. Bennewitz, C. Stachniss, W. Burgard, OctoMap: An Efficient Probabilistic 3D Mapping Framework
Based on Octrees, Autonomous Robots 34, 2013: each echo makes its voxel more likely occupied (by the log-odds of 0.7),
each voxel that a beam passes through more likely free (0.4); within one scan an echo outdoes the beams that pass.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from virtualrobot.errors import WrongStateError

Floats = NDArray[np.float64]
Keys = NDArray[np.int64]
"""(n, 3): voxel k reaches from k to k + 1 times the resolution along each axis."""


def keys_of(points: ArrayLike, resolution: float) -> Keys:
    """Return the voxels (n, 3) that hold points (n, 3)."""
    return np.floor(np.asarray(points, np.float64) / resolution).astype(np.int64)


def centers_of(keys: Keys, resolution: float) -> Floats:
    """Return the middles (n, 3) of voxels (n, 3)."""
    return (keys.astype(np.float64) + 0.5) * resolution


class OctreeMap:
    """Octree of occupied and free voxels, as far as scans have told."""

    def __init__(self, resolution: float) -> None:
        """Begin with nothing known; voxels have edges of `resolution` meters.

        Raises WrongStateError when the package pyoctomap is not installed.
        """
        self.resolution = resolution
        self._tree = library().OcTree(resolution)

    def insert(self, points: ArrayLike, origin: ArrayLike) -> None:
        """Take in the echoes (n, 3) of a scan from `origin` (3,), meters in the world's frame."""
        points = np.ascontiguousarray(points, np.float64)
        if len(points):
            self._tree.insertPointCloud(points, np.asarray(origin, np.float64))

    def voxels(self, low: ArrayLike, high: ArrayLike) -> tuple[Keys, Floats]:
        """Return the known voxels (n, 3) between two corners, and their log-odds (n,): above 0 is occupied.

        Voxels that the octree keeps as one are told one by one.
        """
        low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
        first, last = keys_of(low + 1e-9, self.resolution), keys_of(high - 1e-9, self.resolution)
        keys: list[Keys] = []
        odds: list[Floats] = []
        for leaf in self._tree.begin_leafs_bbx(low, high):
            center = np.array(leaf.getCoordinate())
            edge = round(leaf.getSize() / self.resolution)
            node = self._tree.search(center, leaf.getDepth())
            corner = np.rint(center / self.resolution - 0.5 * edge).astype(np.int64)
            start, stop = np.maximum(corner, first), np.minimum(corner + edge, last + 1)
            if (start < stop).all():
                axes = [np.arange(a, b) for a, b in zip(start, stop, strict=True)]
                block = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
                keys.append(block)
                odds.append(np.full(len(block), float(node.getLogOdds())))
        if not keys:
            return np.empty((0, 3), np.int64), np.empty(0)
        return np.concatenate(keys), np.concatenate(odds)

    def save(self, path: Path) -> None:
        """Write the octree as OctoMap does: `.bt` keeps what is occupied and what is free, `.ot` the odds too."""
        written = self._tree.writeBinary(str(path)) if path.suffix == ".bt" else self._tree.write(str(path))
        if not written:
            raise OSError(f"the map cannot be written to {path}")


def library() -> Any:  # noqa: ANN401 a module that may be missing
    """Return the package pyoctomap; raise WrongStateError, which says how to install it, where it is missing."""
    try:
        import pyoctomap
    except ImportError:
        raise WrongStateError("octrees need the package pyoctomap: pip install 'virtualrobot[mapping]'") from None
    return pyoctomap
