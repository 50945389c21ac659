"""Zones between a program's moves: those of the kernel, and those of a controller."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias


class Corner(NamedTuple):
    """Zone of a controller, in which the tool centre point goes along a parabola.

    Attributes:
        radius: of the zone in m.
        extended: that of orientations and external axes, in m.
        seconds: how long the robot is in it where it brakes to rest.
    """

    radius: float
    extended: float = 0.0
    seconds: float = 0.0


Zone: TypeAlias = float | Corner
"""A zone of the kernel by its distance (m), 0 where there is none, or one of a controller."""


def size_of(zone: Zone) -> float:
    """Return the radius of a zone in m, 0 where there is none."""
    return zone.radius if isinstance(zone, Corner) else zone


def zone_of(zone: Zone) -> dict[str, float]:
    """Return the options of a program's move for a zone."""
    if isinstance(zone, Corner):
        return {"zone_radius": zone.radius, "zone_extended": zone.extended} if zone.radius > 0.0 else {}
    return {"zone": zone} if zone > 0.0 else {}
