"""Grammar of `.solid` files: bodies, profiles of which bodies are made, and bodies of other bodies.

Each is a mapping of one word to what that word takes, the fields of the class below it. Meters and radians.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi
from typing import Annotated, Any, TypeAlias

from msgspec import Meta

Positive: TypeAlias = Annotated[float, Meta(gt=0.0, le=1000.0)]
Length: TypeAlias = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
Angle: TypeAlias = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
Turn: TypeAlias = Annotated[float, Meta(gt=0.0, le=2.0 * pi + 1e-9)]
Count: TypeAlias = Annotated[int, Meta(ge=1, le=10_000)]
Point: TypeAlias = tuple[Length, Length]
Vector: TypeAlias = tuple[Length, Length, Length]
Direction: TypeAlias = tuple[float, float, float]
Solid: TypeAlias = Any
"""A mapping that is a body in its turn."""
Profile: TypeAlias = Any
"""A mapping, or a list of points, that is a profile."""
Solids: TypeAlias = Annotated[list[Any], Meta(min_length=1)]


@dataclass(frozen=True, slots=True)
class Box:
    """Block around the origin, with edges along the axes."""

    size: tuple[Positive, Positive, Positive]


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Cylinder around z, half of it below the origin."""

    radius: Positive
    length: Positive


@dataclass(frozen=True, slots=True)
class Cone:
    """Cone around z, half of it below the origin; with a `top` cut off there."""

    radius: Positive
    length: Positive
    top: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0


@dataclass(frozen=True, slots=True)
class Sphere:
    """Ball around the origin."""

    radius: Positive


@dataclass(frozen=True, slots=True)
class Extrude:
    """Profile of the x-y plane drawn upwards along z, turned by `twist` and scaled to `top` on its way."""

    profile: Profile
    height: Positive
    twist: Angle = 0.0
    top: Annotated[float, Meta(ge=0.0, le=100.0)] = 1.0


@dataclass(frozen=True, slots=True)
class Lathe:
    """Profile turned about z: its x is the distance from z, its y goes along z; what has x below 0 is left out."""

    profile: Profile
    angle: Turn = 2.0 * pi


@dataclass(frozen=True, slots=True)
class Move:
    """Body that is turned about the origin, by roll, pitch, yaw about the fixed axes x, y, z, and then shifted."""

    solid: Solid
    by: Vector = (0.0, 0.0, 0.0)
    turn: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Scale:
    """Body that is scaled about the origin along the axes."""

    solid: Solid
    factors: tuple[Positive, Positive, Positive]


@dataclass(frozen=True, slots=True)
class Mirror:
    """Body mirrored at the plane through `point`; with `copy` both are there."""

    solid: Solid
    normal: Direction
    point: Vector = (0.0, 0.0, 0.0)
    copy: bool = False


@dataclass(frozen=True, slots=True)
class Row:
    """Body `count` times, each a step from the one before."""

    solid: Solid
    count: Count
    step: Vector


@dataclass(frozen=True, slots=True)
class Ring:
    """Body `count` times around an axis through `center`, evenly over `angle`; a whole turn begins again."""

    solid: Solid
    count: Count
    axis: Direction = (0.0, 0.0, 1.0)
    center: Vector = (0.0, 0.0, 0.0)
    angle: Turn = 2.0 * pi


@dataclass(frozen=True, slots=True)
class Circle:
    """Disc around `center`."""

    radius: Positive
    center: Point = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Rectangle:
    """Rectangle around `center`, with edges along the axes, its corners rounded by `corner`."""

    size: tuple[Positive, Positive]
    center: Point = (0.0, 0.0)
    corner: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0


@dataclass(frozen=True, slots=True)
class Polygon:
    """Area within `points`, without the `holes`; either way round."""

    points: Annotated[list[Point], Meta(min_length=3)]
    holes: list[Annotated[list[Point], Meta(min_length=3)]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Offset:
    """Profile grown by a distance, or shrunk by one below 0; its corners become round, or stay `sharp`."""

    profile: Profile
    by: Length
    sharp: bool = False


SOLIDS: dict[str, type] = {
    **{"box": Box, "cylinder": Cylinder, "cone": Cone, "sphere": Sphere, "extrude": Extrude, "lathe": Lathe},
    **{"move": Move, "scale": Scale, "mirror": Mirror, "row": Row, "ring": Ring},
    **{"union": Solids, "difference": Solids, "intersection": Solids, "hull": Solids, "use": str},  # pyright: ignore[reportAssignmentType] types of msgspec
}
"""Bodies by their words: `difference` is the first without all others, `use` a body of `solids` by its name."""

PROFILES: dict[str, type] = {
    **{"circle": Circle, "rectangle": Rectangle, "polygon": Polygon, "offset": Offset},
    **{"union": Solids, "difference": Solids, "intersection": Solids},  # pyright: ignore[reportAssignmentType]
}
"""Profiles by their words; a bare list of points is a polygon."""


@dataclass(frozen=True, slots=True)
class Part:
    """Body with a colour: a name, `#rrggbb`, or red, green, blue and opacity from 0 to 1."""

    solid: Solid
    color: str | Annotated[list[float], Meta(min_length=3, max_length=4)] | None = None


@dataclass(frozen=True, slots=True)
class File:
    """A `.solid` file: one body, or several with colours; bodies with a name; how fine round things are.

    Attributes:
        solid: the body, where it is one of no colour.
        parts: bodies with colours.
        solids: bodies by name, for `use`.
        tolerance: largest distance of a round surface from its edges (m).
    """

    solid: Solid = None
    parts: list[Part] = field(default_factory=list)
    solids: dict[str, Solid] = field(default_factory=dict)
    tolerance: Annotated[float, Meta(ge=1e-6, le=0.1)] = 1e-4
