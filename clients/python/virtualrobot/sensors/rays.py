"""Rays through the world: what one's own rays hit, and how the installed ray casters agree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import (
    Stamp,
    array_message,
    array_of,
    count_or_default,
    seed_of,
    several,
    stamp_of,
    value_or_default,
)
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError, LimitError
from virtualrobot.v1 import ray_pb2

MOST_RAYS = 300_000
"""Largest number of rays of a call."""


@shown
@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """First hits of n rays.

    Attributes:
        distances: (n,), meters; inf where a ray hits nothing.
        elements: (n,), places in `element_names`; -1 where a ray hits nothing.
        element_names: the nodes that are hit.
        normals: (n, 3), unit normals in the frame of the rays, turned to the ray's origin; 0 where it hits nothing.
        cast_time: the time that the component took.
        stamp: the instant of the world that the rays met.
    """

    distances: NDArray[np.float64]
    elements: NDArray[np.int32]
    element_names: tuple[str, ...]
    normals: NDArray[np.float32]
    cast_time: float
    stamp: Stamp

    @property
    def nodes(self) -> list[str]:
        """The node that each ray hits; empty where it hits nothing."""
        return [self.element_names[place] if place >= 0 else "" for place in self.elements.tolist()]


@shown
@dataclass(frozen=True, slots=True)
class RayCasterComparison:
    """Comparison of a ray caster with the first one that answered.

    Attributes:
        ray_caster: the component.
        fault: the reason for which it could not answer; empty where it did.
        agreement: the part of the rays whose distance is the same to 1 mm, 0 to 1.
        other_element: the part of the rays that hit another element, 0 to 1.
        median_difference: of the distances, in meters, among rays that hit something by both.
        largest_difference: the largest one, in meters.
        first_cast_time: of the first cast of all rays, with what the component prepares for the scene.
        cast_time: of a later cast of all rays.
    """

    ray_caster: str
    fault: str
    agreement: float
    other_element: float
    median_difference: float
    largest_difference: float
    first_cast_time: float
    cast_time: float

    @staticmethod
    def of(message: ray_pb2.RayCasterComparison) -> RayCasterComparison:
        """Return what a message tells."""
        return RayCasterComparison(
            message.ray_caster,
            message.fault,
            message.agreement,
            message.other_element,
            message.median_difference_meters,
            message.largest_difference_meters,
            message.first_cast_seconds,
            message.cast_seconds,
        )


@checked
class Rays:
    """Rays through the world of one kernel.

    Example:
        >>> hits = client.rays.cast([0, 0, 2], [[0, 0, -1], [1, 0, -1]])
        >>> hits.distances, hits.nodes
        (array([1.2, inf]), ['table', ''])
    """

    def __init__(self, services: Services) -> None:
        """Handle the rays of one kernel."""
        self._services = services

    def cast(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        frame: str = "world",
        max_range: float | None = None,
        ray_caster: str = "embree",
        ignored: str | Iterable[str] = (),
    ) -> RayHits:
        """Return what n rays hit in the world as it is now.

        Args:
            origins: (n, 3) or, where all begin at one place, (3,), in meters.
            directions: (n, 3), of any length but zero.
            frame: the node whose frame both are in.
            max_range: greatest distance of a hit (m); by default there is no limit.
            ray_caster: the component.
            ignored: nodes that the rays pass through, with all below them.

        Raises:
            LimitError: for more than 300,000 rays.
            InvalidArgumentError: for other shapes, numbers that are not finite, directions of length zero and a range
                below 0; the message names the row.
            UnknownNameError: when there is no such node or component.
            PluginFailedError: when the component raises, hangs, crashes or gives nonsense.
        """
        rays = np.shape(directions)
        if len(rays) != 2 or rays[1] != 3:
            raise InvalidArgumentError(f"directions have the shape (n, 3), not {rays}")
        if rays[0] > MOST_RAYS:
            raise LimitError(f"{rays[0]} rays are too many for a call; cast at most {MOST_RAYS} at once")
        starts = np.atleast_2d(np.asarray(origins, dtype=np.float64))
        if starts.shape not in ((1, 3), (rays[0], 3)):
            raise InvalidArgumentError(f"origins have the shape ({rays[0]}, 3) or (3,), not {np.shape(origins)}")
        request = ray_pb2.CastRaysRequest(
            origins=array_message(starts),
            directions=array_message(directions),
            max_range_meters=value_or_default(max_range, "max_range"),
            frame=frame,
            ray_caster=ray_caster,
            ignored=several(ignored),
        )
        response = self._services.ray.CastRays(request, timeout=LONG_TIMEOUT_SECONDS)
        return RayHits(
            array_of(response.distances),
            array_of(response.elements),
            tuple(response.element_names),
            array_of(response.normals),
            response.cast_seconds,
            stamp_of(response.stamp),
        )

    def compare(
        self,
        ray_casters: Sequence[str] = (),
        *,
        count: int | None = None,
        seed: int = 0,
        progress: Callable[[float], None] | None = None,
    ) -> list[RayCasterComparison]:
        """Return how ray casters agree on random rays through the world as it is now, and what they cost.

        Args:
            ray_casters: the components; the first one that answers is what the others are compared with. None means all
                that are installed, `embree` first.
            count: number of rays, 10,000 by default.
            seed: the seed that the rays are drawn with.
            progress: is called with the part that is done, 0 to 1; what it raises ends the comparison.

        Raises:
            UnknownNameError: when there is no component of a name.
            LimitError: for more than 1,000,000 rays.
        """
        request = ray_pb2.CompareRayCastersRequest(
            ray_casters=ray_casters, rays=count_or_default(count, "the count of rays"), seed=seed_of(seed)
        )
        found: list[RayCasterComparison] = []
        with self._services.ray.CompareRayCasters(request) as stream:
            for response in stream:
                found = [RayCasterComparison.of(message) for message in response.comparisons]
                if progress is not None:
                    progress(response.progress)
        return found

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Rays of the kernel at {self._services.address}: cast(origins, directions), compare()>"
