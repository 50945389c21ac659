"""Contact sensors, and what they say is near or touches."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import Wrapped, several, value_or_default, vector_message, vector_of
from virtualrobot._wire.showing import shown
from virtualrobot.v1 import sensing_pb2, sensor_pb2


class ContactSensorSettings(Wrapped[sensing_pb2.ContactSensor]):
    """Settings of a contact sensor; `contact_sensor` makes them."""

    __slots__ = ()
    _called = "what virtualrobot.contact_sensor makes"


@checked
def contact_sensor(
    watched: str | None = None,
    *,
    max_range: float | None = None,
    region: ArrayLike | None = None,
    ignored: str | Iterable[str] = (),
    rate: float | None = None,
    running: bool = False,
) -> ContactSensorSettings:
    """Return a contact sensor for `scene.add_contact_sensor`.

    Args:
        watched: the node that feels, with all below it; by default the sensor's parent. What is not of its own robot
            is felt.
        max_range: largest distance (m) of a thing that is told; by default only what touches is.
        region: the edges (3,) of a box about the sensor in meters: only points inside it are told; None means all.
        ignored: nodes that are not felt, with all below them.
        rate: readings a second of simulation time while it runs, 10 by default.
        running: whether it reads from the start.

    Example:
        >>> scene.add_contact_sensor("skin", virtualrobot.contact_sensor(max_range=0.1), parent="panda.hand")
    """
    message = sensing_pb2.ContactSensor(
        watched=watched,
        range_meters=value_or_default(max_range, "max_range"),
        region_size=None if region is None else vector_message(region, "the region"),
        ignored=several(ignored),
        rate_hertz=value_or_default(rate, "rate"),
        running=running,
    )
    return ContactSensorSettings(message)


@shown
@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """Two elements that are near, or a point where they touch.

    Attributes:
        element: the node that feels, such as a link.
        other: the node that is felt.
        distance: in meters; 0 where they touch.
        point: (3,) the nearest point of `element` in the world, or where they touch.
        other_point: (3,) that of `other`.
        normal: (3,) from `element` to `other` where they touch, else None.
        force: (3,) on `element` in the world (N) where they touch under physics, else None.
    """

    element: str
    other: str
    distance: float
    point: NDArray[np.float64]
    other_point: NDArray[np.float64]
    normal: NDArray[np.float64] | None
    force: NDArray[np.float64] | None


def contacts_of(message: sensor_pb2.ContactReading) -> tuple[Contact, ...]:
    """Return what a contact sensor said from a message, the nearest first."""
    return tuple(
        Contact(
            one.element,
            one.other,
            one.distance_meters,
            vector_of(one.point),
            vector_of(one.other_point),
            vector_of(one.normal) if one.HasField("normal") else None,
            vector_of(one.force) if one.HasField("force") else None,
        )
        for one in message.contacts
    )
