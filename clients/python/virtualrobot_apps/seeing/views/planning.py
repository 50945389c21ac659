"""Planning of views: of those that a sensor can have, the one that tells most comes next.

J. I. Vasquez-Gomez et al., Volumetric Next-Best-View Planning for 3D Object Reconstruction with Positioning Error,
International Journal of Advanced Robotic Systems 11, 2014; S. Isler et al., An Information Gain Formulation for Active
Volumetric 3D Reconstruction, IEEE ICRA 2016: rays count the voxels at the edge of the known surface that they would
meet first. Surface with few echoes counts in part: gain by the frontier alone leaves it sparse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.seeing.given import finite, mask
from virtualrobot_apps.seeing.views.voxels import OCCUPIED, UNKNOWN, Floats, Voxels, _ndimage

OTHER_UNKNOWN = 0.1
"""Gain of an unknown voxel that no known surface is beside, in those of the frontier."""
SPARSE, DENSE = 0.1, 2
"""Gain of surface with one echo, falling to 0 with so many."""
ENOUGH = 0.005
"""Gain, as part of the surface that is known, below which no view is worth it."""
SMALLEST = 4
"""Fewest voxels of a hole."""


class NoViewError(InvalidArgumentError):
    """Raised where the sensor can have no view, or sees nothing from where it looked."""


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """Hole in the known surface: its middle (3,), the size (3,) of the box about it (m), and voxels at its edge."""

    place: Floats
    size: Floats
    voxels: int


class ViewPlanner:
    """Chooses views of a body, one after the other; `world_t_views` (n, 4, 4) look along z.

    `rays` (m, 3) of length 1 are some of the sensor's, in its frame, and `reach` is how far it sees (m). Where they are
    further apart on the body than voxels are long, views along its faces count for too little. `possible` tells which
    of views (n, 4, 4) can be had, such as those that an arm reaches without touching anything.
    """

    def __init__(
        self,
        voxels: Voxels,
        world_t_views: Floats,
        rays: Floats,
        reach: float,
        possible: Callable[[Floats], NDArray[np.bool_]] | None = None,
    ) -> None:
        """Plan views for voxels of a box.

        Raises:
            NoViewError: where none can be had.
            InvalidArgumentError: for rays, a range or views that no sensor has.
        """
        self.voxels, self._rays, self._reach = voxels, finite(rays, 3, "rays"), reach
        if not len(self._rays) or (np.abs(np.linalg.norm(self._rays, axis=1) - 1.0) > 1e-3).any():
            raise InvalidArgumentError(f"rays are one or more directions of length 1, not {len(self._rays)} others")
        if not (np.isfinite(reach) and reach > 0.0):
            raise InvalidArgumentError(f"a sensor sees farther than 0 m, not {reach} m")
        views = np.asarray(world_t_views, np.float64)
        if views.ndim != 3 or views.shape[1:] != (4, 4) or not np.isfinite(views).all():
            raise InvalidArgumentError(f"views are finite poses (n, 4, 4), not {views.shape}")
        kept = np.ones(len(views), bool) if possible is None else mask(possible(views), len(views), "possible(views)")
        if not kept.any():
            raise NoViewError(f"none of {len(views)} views is in reach: bring the body nearer, or add views")
        self.views = views[kept]
        self._had = np.zeros(len(self.views), bool)

    def next(self) -> Floats | None:
        """Return the view (4, 4) that tells most; None where no other one is worth it."""
        gains = np.where(self._had, -np.inf, self.gains())
        best = int(np.argmax(gains))
        surface = int((self.voxels.states == OCCUPIED).sum())
        if gains[best] <= ENOUGH * surface:
            return None
        self._had[best] = True
        return self.views[best]

    def take(self, origin: Floats, ends: Floats, met: NDArray[np.bool_]) -> int:
        """Take in a scan: rays from a place (3,) to their ends (n, 3) in the world, where an echo is or not.

        Raises:
            NoViewError: where nothing of the box was met, and nothing had been before.
        """
        echoes = self.voxels.take(origin, ends, met)
        if not echoes and not (self.voxels.states == OCCUPIED).any():
            away = np.linalg.norm(self.voxels.middles(np.ones(self.voxels.states.shape, bool)).mean(axis=0) - origin)
            raise NoViewError(
                f"the scan has no echo in the box, whose middle is {away:.2f} m away: is a body in it, within "
                f"the {self._reach:g} m that the sensor sees?"
            )
        return echoes

    def gains(self) -> Floats:
        """Return what each view would tell (n,), in voxels of the frontier."""
        voxels = self.voxels
        worth = np.where(voxels.states == UNKNOWN, OTHER_UNKNOWN, 0.0)
        worth[voxels.frontier()] = 1.0
        surface = voxels.states == OCCUPIED
        worth[surface] = SPARSE * np.maximum(0.0, 1.0 - voxels.counts[surface] / DENSE)
        flat, found = worth.ravel(), np.zeros(len(self.views))
        for number, view in enumerate(self.views):
            met = np.unique(voxels.first_met(view[:3, 3], self._rays @ view[:3, :3].T, self._reach))
            found[number] = flat[met[met >= 0]].sum()
        return found

    def holes(self) -> list[Hole]:
        """Return what was seen from no view: the edges of the surface that is known, the longest first."""
        labels, _ = _ndimage.label(self.voxels.frontier(), np.ones((3, 3, 3)))
        found = []
        for number, box in enumerate(_ndimage.find_objects(labels), start=1):
            cells = np.argwhere(labels[box] == number) + [one.start for one in box]
            if len(cells) >= SMALLEST:
                low = self.voxels.low + cells.min(axis=0) * self.voxels.edge
                high = self.voxels.low + (cells.max(axis=0) + 1) * self.voxels.edge
                found.append(Hole(0.5 * (low + high), high - low, len(cells)))
        return sorted(found, key=lambda one: -one.voxels)


def views_around(middle: Floats, distances: Floats, count: int, lowest: float = -0.15) -> Floats:
    """Return views (n, 4, 4) from places on spheres about a place (3,), evenly spread, z to it.

    `count` are on each sphere, from its top down to a sine of the elevation, by Fibonacci's lattice (Á. González,
    Measurement of Areas on a Sphere Using Fibonacci and Latitude-Longitude Lattices, 2010).
    """
    number = np.arange(count) + 0.5
    z = 1.0 - (1.0 - lowest) * number / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * number
    out = np.column_stack([np.sqrt(1.0 - z**2) * np.cos(turn), np.sqrt(1.0 - z**2) * np.sin(turn), z])
    across = np.column_stack([-np.sin(turn), np.cos(turn), np.zeros(count)])
    views = np.tile(np.eye(4), (len(distances), count, 1, 1))
    views[..., :3, 2], views[..., :3, 0] = -out, across
    views[..., :3, 1] = np.cross(-out, across)
    views[..., :3, 3] = np.asarray(middle) + np.asarray(distances)[:, None, None] * out
    return views.reshape(-1, 4, 4)
