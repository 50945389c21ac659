"""Locations: cartesian ones, in mm and degrees of yaw, pitch and roll, and precision points, in pulses; and their file.

A line of the file is one location as it is typed at the controller: `POINT A 300, 0, 200, 0, 90, 0` or, for a precision
point, `POINT #A 0, -18000, 0, 0, 0`; a comment begins with `;`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from virtualrobot.geometry import Matrix

from virtualrobot_apps.languages.core.diagnostics import Diagnostics
from virtualrobot_apps.languages.core.source import Source

CARTESIAN = ("x", "y", "z", "yaw", "pitch", "roll")
_FORMS = "POINT A 300, 0, 200, 0, 90, 0 (mm, degrees) or POINT #A 0, 18000, 0, 0, 0 (pulses)"
_POINT = re.compile(r"POINT\s+(?P<name>#?[A-Z_][A-Z0-9_$.]*)\s+(?P<values>.*)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Location:
    """A location: `values` are pulses of each joint, or x, y, z (mm) and yaw, pitch, roll (degrees)."""

    name: str
    values: tuple[float, ...]

    @property
    def is_precision(self) -> bool:
        """True of a precision point, whose name begins with #."""
        return self.name.startswith("#")

    def __str__(self) -> str:
        """Return it as it is typed."""
        told = "{:z.0f}" if self.is_precision else "{:z.3f}"
        return f"POINT {self.name} {', '.join(told.format(value) for value in self.values)}"


def read_locations(source: Source, diagnostics: Diagnostics) -> dict[str, Location]:
    """Return the locations of a file by name; what is wrong in it is added to `diagnostics`."""
    locations: dict[str, Location] = {}
    at = 0
    for text in source.text.split("\n"):
        line = text.partition(";")[0].strip()
        if line:
            _read_line(source, line, at + len(text) - len(text.lstrip()), locations, diagnostics)
        at += len(text) + 1
    return locations


def _read_line(source: Source, line: str, at: int, locations: dict[str, Location], diagnostics: Diagnostics) -> None:
    found = _POINT.fullmatch(line)
    if found is None:
        diagnostics.add(source, at, f"a location is told as {_FORMS}")
        return
    name = found["name"].upper()
    try:
        values = tuple(float(one) for one in re.split(r"[\s,]+", found["values"].strip().strip(",")))
    except ValueError:
        values = ()
    if not values or not np.all(np.isfinite(values)):
        diagnostics.add(source, at, f"the values of {name} must be numbers")
    elif not name.startswith("#") and len(values) != len(CARTESIAN):
        diagnostics.add(source, at, f"{name} takes {', '.join(CARTESIAN)}, six numbers, and has {len(values)}")
    elif name in locations:
        diagnostics.add(source, at, f"{name} is there twice")
    else:
        locations[name] = Location(name, values)


def listed(locations: Mapping[str, Location]) -> str:
    """Return locations as a file that `read_locations` reads."""
    return "".join(f"{location}\n" for location in locations.values())


def pose_of(values: tuple[float, ...]) -> Matrix:
    """Return a cartesian location as a 4x4 pose (m), turned by yaw about z, then pitch about y, then roll about x."""
    yaw, pitch, roll = np.radians(values[3:])
    (cz, cy, cx), (sz, sy, sx) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    pose = np.eye(4)
    pose[:3, :3] = about_z @ about_y @ about_x
    pose[:3, 3] = np.array(values[:3]) / 1000.0
    return pose


def values_of(pose: Matrix) -> tuple[float, ...]:
    """Return a pose as `pose_of` takes it; where the tool points straight up or down all its turn is told as yaw."""
    turn = np.asarray(pose)[:3, :3]
    if abs(turn[2, 0]) > 1.0 - 1e-9:
        sign = -np.sign(turn[2, 0])
        angles = (np.arctan2(-turn[0, 1], turn[1, 1]), sign * np.pi / 2.0, 0.0)
    else:
        angles = (
            np.arctan2(turn[1, 0], turn[0, 0]),
            np.arcsin(-turn[2, 0]),
            np.arctan2(turn[2, 1], turn[2, 2]),
        )
    return (*(1000.0 * np.asarray(pose)[:3, 3]).tolist(), *np.degrees(angles).tolist())
