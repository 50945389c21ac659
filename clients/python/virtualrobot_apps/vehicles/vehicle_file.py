"""A vehicle's file as a client needs it: what its thrusters do, its mass, and the document that the kernel gets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from virtualrobot.errors import MalformedFileError, MissingFileError
from virtualrobot.files.resolver import Resolver

Floats = NDArray[np.float64]

BUNDLED = "package://virtualrobot_plugins/marine/vehicles/{}.yaml"
FACTORS = {
    **{"kg": 1.0, "g": 1e-3, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "SI": 1.0},
    **{"rad/s": 1.0, "rpm": math.pi / 30.0, "1/s": 2.0 * math.pi, "N": 1.0, "kgf": 9.80665},
}
"""Units of what is read here; the kernel's component knows and checks all."""


@dataclass(frozen=True, eq=False)
class Thrusters:
    """The thrusters of a vehicle; axes are forward, left, up."""

    names: tuple[str, ...]
    allocation: Floats
    """(6, m) force and moment about the origin for a thrust of 1 N of each."""
    tables: tuple[tuple[Floats, Floats], ...]
    """Of each the speeds (rad/s) and their thrusts (N), rising."""
    limits: Floats
    """(2, m) least and greatest thrusts (N)."""

    def speeds(self, wrench: Floats) -> Floats:
        """Return the speeds (m,) by which they give a wrench (6,) (N, N m), by least squares.

        Where one cannot, all give less in proportion, so that the direction stays.
        """
        thrusts = np.linalg.pinv(self.allocation) @ wrench
        over = np.max(np.maximum(thrusts / self.limits[1], thrusts / self.limits[0]), initial=1.0)
        thrusts = thrusts / over
        return np.array([np.interp(t, value, of) for t, (of, value) in zip(thrusts, self.tables, strict=True)])


@dataclass(frozen=True, eq=False)
class VehicleFile:
    """A vehicle: the document of its file, and what a client needs of it in SI units."""

    document: Mapping[str, Any]
    masses: Floats
    """(6,) mass or inertia in each direction, with that of the water (kg, kg m^2)."""
    thrusters: Thrusters


def read(vehicle: str | Path) -> VehicleFile:
    """Return a vehicle by its file, or by the name of a bundled one.

    Raises MissingFileError where there is none, MalformedFileError for one that is not as it must be.
    """
    name = str(vehicle)
    try:
        path = Path(name) if name.endswith((".yaml", ".yml")) else Resolver().resolve(BUNDLED.format(name))
        document = yaml.safe_load(path.read_text("utf-8"))
    except OSError as error:
        raise MissingFileError(f"there is no vehicle {name!r}: {error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise MalformedFileError(f"{name} is not YAML: {error}", metadata={"file": name}) from error
    try:
        return _vehicle(document)
    except (KeyError, TypeError, ValueError) as error:
        raise MalformedFileError(
            f"{name} is no vehicle: {error!r} is missing or wrong", metadata={"file": name}
        ) from error


def _vehicle(document: Mapping[str, Any]) -> VehicleFile:
    # The axes of the file differ from ours by a half turn about x, or not at all.
    turn = np.array([1.0, -1.0, -1.0] if document["axes"] == "forward_right_down" else [1.0, 1.0, 1.0])
    columns, tables = [], []
    for thruster in document["thrusters"]:
        direction = turn * np.array(thruster["direction"], dtype=np.float64)
        place = turn * _si(thruster["position"])
        columns.append(np.append(direction, np.cross(place, direction)))
        table = thruster["thrust"]
        tables.append((_converted(table["of"], table["of_unit"]), _converted(table["value"], table["unit"])))
    mass = float(_si(document["mass"]))
    body = np.append(np.full(3, mass), _diagonal(_si(document["inertia"])))
    return VehicleFile(
        document=document,
        masses=body + _diagonal(_si(document["added_mass"])),
        thrusters=Thrusters(
            tuple(str(thruster["name"]) for thruster in document["thrusters"]),
            np.array(columns).T,
            tuple(tables),
            np.array([(thrust[0], thrust[-1]) for _, thrust in tables]).T,
        ),
    )


def _si(quantity: Mapping[str, Any]) -> Floats:
    # Moments of inertia are always in SI.
    unit = "SI" if quantity["unit"] == "kg m2" else quantity["unit"]
    return _converted(quantity["value"], unit)


def _converted(value: float | Sequence[float], unit: str) -> Floats:
    return np.asarray(value, dtype=np.float64) * FACTORS[unit]


def _diagonal(values: Floats) -> Floats:
    return values if values.ndim == 1 else np.diag(values)
