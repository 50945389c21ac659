"""Parameters of a vehicle in SI units and in the axes of the base, checked, as the compiled core takes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass, replace

import numpy as np
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import Floats, Integers
from virtualrobot_sdk.poses import skew
from virtualrobot_sdk.vehicles import DriveQuantity, VehicleDrive

from virtualrobot_plugins.marine.units import factor
from virtualrobot_plugins.marine.vehicle import (
    Fin,
    FreeBody,
    Inertia,
    Matrix,
    Point,
    Quantity,
    Table,
    Thruster,
    Vehicle,
)

DRIVE_NUMBERS = 11
"""Columns of `Parameters.drive`: direction, place, time constant, torque, area, diameter, 1 - wake."""


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """A vehicle as the compiled core has it; axes are forward, left, up."""

    mass_matrix: Floats
    """(6, 6) of body and added mass, about the origin (kg, kg m, kg m^2)."""
    inverse_mass: Floats
    """(6, 6) its inverse."""
    damping: Floats
    """(3, 6, 6): against v, |v| v of each velocity, and |surge| v."""
    hull: Floats
    """(9,) mass (kg), volume (m^3), centre of gravity (3), centre of buoyancy (3), height (m)."""
    is_fin: Integers
    """(m,) 1 where the drive is a fin, 0 where it is a thruster."""
    drive: Floats
    """(m, 11) `DRIVE_NUMBERS`."""
    table_start: Integers
    """(2 m + 1,) first column of each table in `tables`: thrust or lift of each drive, then its factors by advance."""
    tables: Floats
    """(2, n) arguments and values of all tables."""
    drives: tuple[VehicleDrive, ...]
    """(m,) what each drive is called and can do."""


def parameters(vehicle: Vehicle) -> Parameters:
    """Return the parameters of a vehicle.

    Raises ArgumentError, naming the place, for a source that the file does not tell, a unit of another kind, a mass or
    inertia that no body has, damping that drives, a table that is not monotone and drives of one name.
    """
    _check_sources(vehicle)
    # The axes of the file differ from ours by a half turn about x, or not at all.
    turn = np.diag([1.0, -1.0, -1.0]) if vehicle.axes == "forward_right_down" else np.eye(3)
    both = np.kron(np.eye(2), turn)
    mass = _positive(vehicle.mass, "mass", "mass")
    gravity_center = turn @ _point(vehicle.center_of_gravity, "center_of_gravity")
    inertia = turn @ _inertia(vehicle.inertia) @ turn
    added = _matrix(vehicle.added_mass, "added_mass")
    _check_semidefinite(added, "added_mass")
    cross = skew(gravity_center)
    body = np.block([[mass * np.eye(3), -mass * cross], [mass * cross, inertia - mass * cross @ cross]])
    whole = body + both @ added @ both
    damping = np.zeros((3, 6, 6))
    for i, name in enumerate(("linear_damping", "quadratic_damping", "lift")):
        matrix = getattr(vehicle, name)
        if matrix is None:
            continue
        damping[i] = both @ _matrix(matrix, name) @ both
        if name != "lift" and (np.diag(damping[i]) < 0.0).any():
            raise _wrong(name, np.diag(damping[i]).tolist(), "0 or more on the diagonal, so that it takes energy")
    hull = np.concatenate(
        [
            (mass, _positive(vehicle.volume, "volume", "volume")),
            gravity_center,
            turn @ _point(vehicle.center_of_buoyancy, "center_of_buoyancy"),
            (_positive(vehicle.height, "length", "height"),),
        ]
    )
    made = [
        *(_thruster(one, f"thrusters[{i}] ({one.name})", turn) for i, one in enumerate(vehicle.thrusters)),
        *(_fin(one, f"fins[{i}] ({one.name})", turn) for i, one in enumerate(vehicle.fins)),
    ]
    if not made:
        raise ArgumentError("the vehicle has neither thrusters nor fins; it needs a drive at least")
    names = [drive.name for drive, _, _, _ in made]
    for name in names:
        if names.count(name) > 1 or not name:
            raise ArgumentError(
                f"{names.count(name)} drives are called {name!r}; each needs a name of its own", name=name
            )
    tables = [table for *_, own in made for table in own]
    return Parameters(
        mass_matrix=whole,
        inverse_mass=np.linalg.inv(whole).astype(np.float64),
        damping=damping,
        hull=hull,
        is_fin=np.array([fin for _, fin, _, _ in made], dtype=np.int32),
        drive=np.array([numbers for _, _, numbers, _ in made]),
        table_start=np.cumsum([0, *(table.shape[1] for table in tables)], dtype=np.int32),
        tables=np.ascontiguousarray(np.hstack(tables)),
        drives=tuple(drive for drive, *_ in made),
    )


def free_parameters(body: FreeBody, density: float) -> Parameters:
    """Return the parameters of a craft in air of a density (kg/m^3): neither added mass nor buoyancy.

    Its damping goes by the density. Raises ArgumentError as `parameters` does.
    """
    source = body.mass.source
    alike = Vehicle(
        name=body.name,
        axes=body.axes,
        sources=body.sources,
        mass=body.mass,
        volume=Quantity(1.0, "m3", source),
        height=Quantity(1.0, "m", source),
        inertia=body.inertia,
        center_of_gravity=body.center_of_gravity,
        center_of_buoyancy=body.center_of_gravity,
        added_mass=Matrix((0.0,) * 6, "SI", source),
        linear_damping=body.linear_damping,
        quadratic_damping=body.quadratic_damping,
        thrusters=body.thrusters,
        fins=body.fins,
    )
    made = parameters(alike)
    hull = made.hull.copy()
    hull[1] = 0.0  # no volume: the air that it displaces weighs nothing beside it
    return replace(made, hull=hull, damping=made.damping * (density / _positive(body.density, "density", "density")))


Made = tuple[VehicleDrive, bool, list[float], tuple[Floats, Floats]]
"""A drive: what it is called, whether it is a fin, its `DRIVE_NUMBERS`, and its two tables (2, n)."""


def _thruster(thruster: Thruster, place: str, turn: Floats) -> Made:
    thrust = _table(thruster.thrust, f"{place}.thrust", "turning speed", "force", rising=True)
    none = np.array([[0.0], [1.0]])
    diameter, unhindered, factors = 0.0, 1.0, none
    if thruster.propeller is not None:
        diameter = _positive(thruster.propeller.diameter, "length", f"{place}.propeller.diameter")
        wake = _number(thruster.propeller.wake, "ratio", f"{place}.propeller.wake")
        if not 0.0 <= wake < 1.0:
            raise _wrong(f"{place}.propeller.wake", wake, "from 0 to below 1")
        unhindered = 1.0 - wake
        factors = _table(thruster.propeller.advance, f"{place}.propeller.advance", "ratio", "ratio", rising=False)
        if factors[:, 0].tolist() != [0.0, 1.0]:
            raise _wrong(f"{place}.propeller.advance", f"begins with {factors[:, 0].tolist()}", "factor 1 at ratio 0")
    torque = 0.0 if thruster.torque is None else _number(thruster.torque, "length", f"{place}.torque")
    numbers = [
        *(turn @ _direction(thruster.direction, place)),
        *(turn @ _point(thruster.position, f"{place}.position")),
        *(_lag(thruster.time_constant, place), torque, 0.0, diameter, unhindered),
    ]
    return _drive(thruster.name, DriveQuantity.SPEED, thrust), False, numbers, (thrust, factors)


def _fin(fin: Fin, place: str, turn: Floats) -> Made:
    lift = _table(fin.lift, f"{place}.lift", "angle", "ratio", rising=True)
    direction = _direction(fin.direction, place)
    if abs(direction[0]) > 1e-9:
        raise _wrong(f"{place}.direction", list(fin.direction), "at right angles to x: lift is across the stream")
    numbers = [
        *(turn @ direction),
        *(turn @ _point(fin.position, f"{place}.position")),
        *(_lag(fin.time_constant, place), 0.0, _positive(fin.area, "area", f"{place}.area"), 0.0, 1.0),
    ]
    return _drive(fin.name, DriveQuantity.POSITION, lift), True, numbers, (lift, np.array([[0.0], [1.0]]))


def _drive(name: str, quantity: DriveQuantity, table: Floats) -> VehicleDrive:
    return VehicleDrive(name, quantity, float(table[0, 0]), float(table[0, -1]))


def _check_sources(vehicle: Vehicle) -> None:
    """Raise ArgumentError for a value whose source is not among those of the file."""
    open_values: list[tuple[str, object]] = [("", vehicle)]
    while open_values:
        place, value = open_values.pop()
        if isinstance(value, tuple):
            open_values += [(f"{place}[{i}]", one) for i, one in enumerate(value)]
        elif is_dataclass(value):
            open_values += [
                (f"{place}.{field.name}".lstrip("."), getattr(value, field.name)) for field in fields(value)
            ]
            source = getattr(value, "source", None)
            if source is not None and source not in vehicle.sources:
                told = ", ".join(vehicle.sources) or "none"
                raise _wrong(f"the source of {place}", repr(source), f"a key of `sources`, which are {told}")


def _number(quantity: Quantity, kind: str, place: str) -> float:
    value = quantity.value * factor(kind, quantity.unit, place)
    if not np.isfinite(value):
        raise _wrong(place, quantity.value, "a finite number")
    return value


def _positive(quantity: Quantity, kind: str, place: str) -> float:
    value = _number(quantity, kind, place)
    if value <= 0.0:
        raise _wrong(place, quantity.value, "above 0")
    return value


def _lag(quantity: Quantity, place: str) -> float:
    seconds = _number(quantity, "time", f"{place}.time_constant")
    if seconds < 0.0:
        raise _wrong(f"{place}.time_constant", seconds, "0 or more")
    return seconds


def _point(point: Point, place: str) -> Floats:
    return _finite(np.array(point.value) * factor("length", point.unit, place), place)


def _direction(direction: Sequence[float], place: str) -> Floats:
    vector = _finite(np.array(direction, dtype=np.float64), f"{place}.direction")
    length = float(np.linalg.norm(vector))
    if abs(length - 1.0) > 1e-3:
        raise _wrong(f"{place}.direction", list(direction), f"of length 1; it has {length:.6g}")
    return vector / length


def _matrix(matrix: Matrix, place: str) -> Floats:
    return _square(matrix.value, place) * factor("matrix", matrix.unit, place)


def _square(value: Sequence[float | Sequence[float]], place: str) -> Floats:
    """Return a matrix of its diagonal or its rows."""
    rows = [one for one in value if isinstance(one, Sequence)]
    if rows and len(rows) < len(value):
        raise _wrong(place, list(value), "either a diagonal or rows alone")
    return _finite(np.array(value, dtype=np.float64) if rows else np.diag(np.array(value, dtype=np.float64)), place)


def _inertia(inertia: Inertia) -> Floats:
    tensor = _square(inertia.value, "inertia") * factor("moment of inertia", inertia.unit, "inertia")
    if not np.allclose(tensor, tensor.T, rtol=1e-9, atol=0.0):
        raise _wrong("inertia", tensor.tolist(), "symmetric")
    a, b, c = np.linalg.eigvalsh(tensor).tolist()
    if a <= 0.0 or c > (a + b) * (1.0 + 1e-9):
        raise _wrong("inertia", [a, b, c], "of principal moments above 0, none greater than the other two together")
    return tensor


def _check_semidefinite(matrix: Floats, place: str) -> None:
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=1e-12):
        raise _wrong(place, matrix.tolist(), "symmetric, as of an ideal fluid (Fossen 1994, 2.4.1)")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -1e-9 * max(1.0, float(np.abs(matrix).max())):
        raise _wrong(
            place, f"of least eigenvalue {least:.6g}", "positive: with the sign of a mass, not of a derivative"
        )


def _table(table: Table, place: str, of: str, kind: str, rising: bool) -> Floats:
    """Return arguments and values (2, n) of a table that is monotone, in SI units."""
    if len(table.of) != len(table.value) or len(table.of) < 2:
        raise _wrong(
            place, f"{len(table.of)} arguments with {len(table.value)} values", "as many of both, two at least"
        )
    numbers = np.array([table.of, table.value], dtype=np.float64)
    _finite(numbers, place)
    numbers[0] *= factor(of, table.of_unit, place)
    numbers[1] *= factor(kind, table.unit, place)
    for i in range(1, numbers.shape[1]):
        if table.of[i] <= table.of[i - 1]:
            raise _wrong(place, f"{table.of[i - 1]:g} before {table.of[i]:g}", "of rising arguments")
        if (table.value[i] < table.value[i - 1]) if rising else (table.value[i] > table.value[i - 1]):
            way = "nowhere falling" if rising else "nowhere rising"
            raise _wrong(
                place,
                f"{table.value[i - 1]:g} at {table.of[i - 1]:g} and {table.value[i]:g} at {table.of[i]:g}",
                f"monotone, {way}",
            )
    return numbers


def _finite(values: Floats, place: str) -> Floats:
    if not np.isfinite(values).all():
        raise _wrong(place, values.tolist(), "finite")
    return values


def _wrong(place: str, value: object, right: str) -> ArgumentError:
    return ArgumentError(f"{place} is {value}; it must be {right}", place=place)
