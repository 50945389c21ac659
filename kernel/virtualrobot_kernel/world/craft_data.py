"""Data of crafts: the drives by which a base is moved, and the water about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class CraftDrive:
    """Drive of a craft, or passive wheel, and its joint: joint = ratio * drive, in their radians or meters."""

    drive: str
    joint: str
    ratio: float = 1.0


@dataclass(frozen=True, slots=True)
class Water:
    """Water about a craft: velocity along the world's axes (m/s), density (kg/m^3), height of its surface (m)."""

    current: tuple[float, float, float] = (0.0, 0.0, 0.0)
    density: float = 1000.0
    surface_height: float = 0.0


@dataclass(frozen=True, slots=True)
class Craft:
    """Craft: the component `kinematics` moves the base of a robot by its drives.

    `base_joint` is the joint by which the base moves (empty: the first planar or floating one); `center_x`, `center_y`
    (m) and `heading` (rad) say where in the frame of what it moves the component has the base, whose x is forward.
    """

    kinematics: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    drives: tuple[CraftDrive, ...] = ()
    base_joint: str = ""
    center_x: float = 0.0
    center_y: float = 0.0
    heading: float = 0.0
    water: Water | None = None
