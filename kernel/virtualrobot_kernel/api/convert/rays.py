"""Rays that clients cast: messages to arrays and back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2, ray_pb2
from virtualrobot_sdk.rays import NO_ELEMENT

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import GREATEST, array, array_message, not_negative, stamp
from virtualrobot_kernel.sensing.casting import Cast
from virtualrobot_kernel.sensing.compare import Comparison
from virtualrobot_kernel.sensing.elements import Elements
from virtualrobot_kernel.world.state import Snapshot

MOST_RAYS = 300_000
"""Greatest number of rays in a call: with origins and directions in double precision they just fit in a message."""

COMPARISON = Table(Comparison, ray_pb2.RayCasterComparison)

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """Rays in the world's frame: origins (n, 3) or (1, 3) in meters, unit directions (n, 3), how far they go (m)."""

    origins: Floats
    directions: Floats
    max_range: float


def check_count(request: ray_pb2.CastRaysRequest) -> None:
    """Raise LimitError for more rays than a call may cast; nothing else is looked at."""
    count = max((message.shape[0] for message in (request.origins, request.directions) if message.shape), default=0)
    if count > MOST_RAYS:
        raise LimitError(
            f"{count} rays are too many for a call; cast at most {MOST_RAYS} at once", rays=count, limit=MOST_RAYS
        )


def rays(request: ray_pb2.CastRaysRequest, world_t_frame: Floats) -> Rays:
    """Return the rays of a request in the world's frame; raise KernelError, naming the row, where they are none."""
    directions = np.asarray(array(request.directions, (None, 3), "directions"), np.float64)
    origins = np.asarray(array(request.origins, (None, 3), "origins"), np.float64)
    if len(origins) not in (1, len(directions)):
        raise KernelError(
            f"origins are {len(origins)} and directions {len(directions)}; give as many, or one origin for all",
            field="origins",
        )
    if (far := np.abs(origins).max(axis=1, initial=0.0) > GREATEST).any():
        row = int(far.argmax())
        raise KernelError(
            f"origins has {origins[row].tolist()} in row {row}; it must be within {GREATEST:g} m",
            field="origins",
            row=row,
        )
    # By the largest part first: no square of a tiny or huge number is lost.
    largest = np.abs(directions).max(axis=1, initial=0.0)
    if (zero := largest == 0.0).any():
        row = int(zero.argmax())
        raise KernelError(
            f"directions has {directions[row].tolist()} in row {row}; a direction has any length but zero",
            field="directions",
            row=row,
        )
    directions /= largest[:, None]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rotation = world_t_frame[:3, :3]
    max_range = not_negative(request.max_range_meters, "max_range_meters") or math.inf
    return Rays(origins @ rotation.T + world_t_frame[:3, 3], directions @ rotation.T, max_range)


def cast_message(cast: Cast, elements: Elements, snapshot: Snapshot, world_t_frame: Floats) -> ray_pb2.CastRaysResponse:
    """Return the hits of rays as a message, normals in the frame; each node that is hit is named once."""
    hits = cast.hits
    is_hit = hits.element != NO_ELEMENT
    nodes, places = np.unique(elements.uids[hits.element[is_hit]], return_inverse=True)
    told = np.full(len(hits.element), NO_ELEMENT, np.int32)
    told[is_hit] = places
    return ray_pb2.CastRaysResponse(
        stamp=stamp(snapshot),
        distances=array_message(hits.distance),
        elements=array_message(told, geometry_pb2.NUMERIC_TYPE_INT32),
        element_names=[snapshot.structure.nodes[uid].name for uid in nodes.tolist()],
        normals=array_message(hits.normal @ world_t_frame[:3, :3], geometry_pb2.NUMERIC_TYPE_FLOAT32),
        cast_seconds=cast.seconds,
    )
