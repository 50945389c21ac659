"""Parameters of a vehicle as a file says them: each value with its unit and its source.

Bundled files lie in `vehicles/`, of vehicles under water, and in `bodies/`, of crafts in air and space. The meaning of
the parameters is that of T. I. Fossen, Guidance and Control of Ocean Vehicles (Wiley, 1994), chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import msgspec
import yaml
from msgspec import Meta
from virtualrobot_sdk.errors import ArgumentError

FOLDER = Path(__file__).parent / "vehicles"
BODIES = FOLDER.with_name("bodies")
Unit = Annotated[str, Meta(description="Unit of the value, such as kg, m, rpm or N.")]
Source = Annotated[str, Meta(description="Key of `sources` that the value is from.")]
Triple = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its unit and source."""

    value: float
    unit: Unit
    source: Source


@dataclass(frozen=True, slots=True)
class Point:
    """Three numbers along the axes of the file."""

    value: Triple
    unit: Unit
    source: Source


@dataclass(frozen=True, slots=True)
class Inertia:
    """Moments of inertia, or the whole tensor of rows."""

    value: Annotated[tuple[float | Triple, ...], Meta(min_length=3, max_length=3)]
    unit: Unit
    source: Source


@dataclass(frozen=True, slots=True)
class Matrix:
    """Matrix over surge, sway, heave, roll, pitch and yaw: its diagonal, or all its rows."""

    value: Annotated[tuple[float | Six, ...], Meta(min_length=6, max_length=6)]
    unit: Unit
    source: Source


@dataclass(frozen=True, slots=True)
class Table:
    """Look-up table: values at rising arguments, straight between them and level beyond."""

    of: tuple[float, ...]
    of_unit: Unit
    value: tuple[float, ...]
    unit: Unit
    source: Source


@dataclass(frozen=True, slots=True)
class Propeller:
    """Loss of thrust as water comes to the propeller by itself."""

    diameter: Quantity
    advance: Annotated[Table, Meta(description="Factor of the thrust by the advance ratio Va / (n D); falls from 1.")]
    wake: Annotated[Quantity, Meta(description="Wake fraction: the part of the speed that the hull takes along.")]


@dataclass(frozen=True, slots=True)
class Thruster:
    """A propeller that pushes along an axis of the hull."""

    name: str
    position: Point
    direction: Annotated[Triple, Meta(description="Direction of positive thrust, along the axes of the file.")]
    thrust: Annotated[Table, Meta(description="Thrust by the propeller's speed, where the water stands.")]
    time_constant: Annotated[Quantity, Meta(description="The speed follows its command by a first-order lag.")]
    torque: Annotated[
        Quantity | None,
        Meta(description="Moment about the direction for a thrust of 1; signed by the sense of turning."),
    ] = None
    propeller: Propeller | None = None


@dataclass(frozen=True, slots=True)
class Fin:
    """A fin, rudder or stern plane that turns about its own axis."""

    name: str
    position: Point
    direction: Annotated[Triple, Meta(description="Direction of the lift at a positive angle, at right angles to x.")]
    area: Quantity
    lift: Annotated[Table, Meta(description="Lift coefficient by the fin's angle.")]
    time_constant: Quantity


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle under water; the origin is that of its base, x forward."""

    name: str
    axes: Annotated[
        Literal["forward_left_up", "forward_right_down"], Meta(description="Axes of all vectors and matrices.")
    ]
    sources: Annotated[dict[str, str], Meta(description="Documents by key.")]
    mass: Quantity
    volume: Annotated[Quantity, Meta(description="Volume of the water that it displaces.")]
    height: Annotated[Quantity, Meta(description="Height of the hull, over which it comes out of the water.")]
    inertia: Annotated[Inertia, Meta(description="About the centre of gravity.")]
    center_of_gravity: Point
    center_of_buoyancy: Point
    added_mass: Annotated[Matrix, Meta(description="Positive: mass of water that is moved along.")]
    linear_damping: Annotated[Matrix, Meta(description="Positive: force against a velocity of 1.")]
    quadratic_damping: Annotated[Matrix, Meta(description="Positive: force against |v| v of each velocity.")]
    lift: Annotated[
        Matrix | None, Meta(description="Force against |surge| v: lift of hull and fixed fins; none without.")
    ] = None
    thrusters: tuple[Thruster, ...] = ()
    fins: tuple[Fin, ...] = ()


@dataclass(frozen=True, slots=True)
class FreeBody:
    """A craft in air or space; the origin is that of its base, x forward."""

    name: str
    axes: Annotated[
        Literal["forward_left_up", "forward_right_down"], Meta(description="Axes of all vectors and matrices.")
    ]
    sources: Annotated[dict[str, str], Meta(description="Documents by key.")]
    mass: Quantity
    inertia: Annotated[Inertia, Meta(description="About the centre of gravity.")]
    center_of_gravity: Point
    density: Annotated[Quantity, Meta(description="Density of the air that both dampings are of; they go by it.")]
    linear_damping: Annotated[Matrix, Meta(description="Positive: force against a velocity of 1.")]
    quadratic_damping: Annotated[Matrix, Meta(description="Positive: force against |v| v of each velocity.")]
    thrusters: tuple[Thruster, ...] = ()
    fins: tuple[Fin, ...] = ()


Kept = TypeVar("Kept", Vehicle, FreeBody)


def bundled() -> tuple[str, ...]:
    """Return the names of the bundled vehicles under water."""
    return _names(FOLDER)


def read_bundled(name: str) -> Vehicle:
    """Return a bundled vehicle under water.

    Raises ArgumentError when there is none of this name.
    """
    return _read(name, FOLDER, Vehicle)


def read_bundled_body(name: str) -> FreeBody:
    """Return a bundled craft for air or space; raise ArgumentError when there is none of this name."""
    return _read(name, BODIES, FreeBody)


def read_document(document: Any) -> Vehicle:  # noqa: ANN401  whatever a file may hold
    """Return the vehicle of a document of plain values.

    Raises ArgumentError with the place of what is missing or wrong.
    """
    return _converted(document, Vehicle)


def _names(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in folder.glob("*.yaml")))


def _read(name: str, folder: Path, kind: type[Kept]) -> Kept:
    names = _names(folder)
    if name not in names:
        raise ArgumentError(f"there is no vehicle {name!r}; the bundled ones are {', '.join(names)}", vehicle=name)
    return _converted(yaml.safe_load((folder / f"{name}.yaml").read_text("utf-8")), kind)


def _converted(document: Any, kind: type[Kept]) -> Kept:  # noqa: ANN401  whatever a file may hold
    try:
        return msgspec.convert(document, kind)
    except msgspec.ValidationError as error:
        raise ArgumentError(f"the vehicle's file is not right: {error}") from error
