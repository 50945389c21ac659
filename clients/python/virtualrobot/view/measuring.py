"""Distances between points that move with nodes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike
from virtualrobot._wire.messages import value_or_default, vector_message, vector_of
from virtualrobot._wire.newest import newest
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import view_pb2

Place = Annotated[tuple[str, ArrayLike], "a node's name and a point, such as ('box', [0, 0, 0.1])"]
"""A point that moves with a node: the node's name (empty: the world), and meters in its frame."""


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """Distance between two points, and their positions.

    Attributes:
        distance: in meters.
        first: (3,) the first point in the world's frame, in meters.
        second: (3,) the second one.
        simulation_time: simulation time of the measurement, in seconds.
    """

    distance: float
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    simulation_time: float


def measure(services: Services, first: Place, second: Place) -> Measure:
    """Return how far two points are apart now."""
    request = view_pb2.MeasurePointDistanceRequest(first=place_message(first), second=place_message(second))
    return _measure_of(services.view.MeasurePointDistance(request))


def watch_measure(services: Services, first: Place, second: Place, max_rate: float | None = None) -> Iterator[Measure]:
    """Yield how far two points are apart now, and again whenever the world changes."""
    request = view_pb2.WatchPointDistanceRequest(
        first=place_message(first), second=place_message(second), max_rate_hertz=value_or_default(max_rate, "max_rate")
    )
    stream = services.view.WatchPointDistance(request)
    with closing(newest(stream, lambda response: [("", response)])) as measures:
        yield from map(_measure_of, measures)


def place_message(place: Place) -> view_pb2.NodePoint:
    """Return a node and a point in its frame as a message."""
    try:
        node, point = place
    except (TypeError, ValueError):
        node, point = None, None
    if not isinstance(node, str) or point is None:
        raise InvalidArgumentError(
            f"{place!r} is no place; give a node's name and a point, such as ('box', [0, 0, 0.1])"
        )
    return view_pb2.NodePoint(node=node, point=vector_message(point, f"the point of {node or 'the world'}"))


def _measure_of(answer: view_pb2.MeasurePointDistanceResponse | view_pb2.WatchPointDistanceResponse) -> Measure:
    found = answer.distance
    return Measure(
        found.distance_meters,
        vector_of(found.first),
        vector_of(found.second),
        answer.stamp.simulation_time_seconds,
    )
