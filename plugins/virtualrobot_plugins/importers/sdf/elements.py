"""The small elements of SDFormat: texts, numbers, poses; every error names file, line and element.

Format: http://sdformat.org/spec. Angles are roll, pitch, yaw about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.poses import from_quaternion, from_roll_pitch_yaw, quaternion
from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_plugins.importers.refusal import refusal, short_name
from virtualrobot_plugins.importers.xml import children

Matrix = NDArray[np.float64]
"""A pose as 4x4 matrix."""

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_INFINITE = re.compile(r"[-+]?inf(inity)?", re.IGNORECASE)


@dataclass(slots=True)
class Notes:
    """Warnings of one translation, and the elements that it left out."""

    texts: dict[str, None] = field(default_factory=dict)
    _left_out: dict[str, list[str]] = field(default_factory=dict)

    def warn(self, place: Place, element: Element, message: str) -> None:
        """Keep a warning about an element; the same one is kept once."""
        self.texts[str(place.error(element, message))] = None

    def leave_out(self, place: Place, element: Element) -> None:
        """Count an element that is passed over."""
        where = f"{short_name(place.uri)}:{line_of(element)}"
        self._left_out.setdefault(local_name(element), []).append(where)

    def all(self) -> tuple[str, ...]:
        """Return all warnings, one for each kind of element that was passed over."""
        kinds = (
            f"{places[0]}: <{kind}> is left out" + (f", {len(places)} times" if places[1:] else "")
            for kind, places in self._left_out.items()
        )
        return (*self.texts, *kinds)


@dataclass(frozen=True, slots=True)
class Place:
    """Place in a file that is being read: URI, version of the format, and path of the element in words."""

    uri: str
    version: tuple[int, int]
    path: str = ""

    def inside(self, what: str) -> Place:
        """Return the place of something inside."""
        return Place(self.uri, self.version, what)

    def error(self, element: Element, message: str, **metadata: object) -> ArgumentError:
        """Return the error `world.sdf:41: joint 'a': message`."""
        text = f"{self.path}: {message}" if self.path else message
        return refusal(self.uri, text, line_of(element), **metadata)

    def name(self, element: Element) -> str:
        """Return the name of an element, which it must have; names between double underscores are reserved."""
        name = element.get("name", "").strip()
        if not name or (name.startswith("__") and name.endswith("__")):
            raise self.error(element, f"<{local_name(element)}> needs a name, and not {name!r}")
        return name


def child(element: Element, tag: str) -> Element | None:
    """Return the first child element with this tag."""
    return next(children(element, tag), None)


def text(element: Element, tag: str, default: str = "") -> str:
    """Return the text of the first child element with this tag."""
    found = child(element, tag)
    return default if found is None else (found.text or "").strip()


def flag(place: Place, element: Element, tag: str, default: bool = False) -> bool:
    """Return a child element that is true or false."""
    found = child(element, tag)
    if found is None:
        return default
    word = (found.text or "").strip().lower()
    if word not in ("true", "1", "false", "0"):
        raise place.error(found, f"<{tag}> is {word!r}; expected true or false")
    return word in ("true", "1")


def numbers(
    place: Place, element: Element, tag: str, count: int, default: tuple[float, ...] | None = None
) -> NDArray[np.float64]:
    """Return the finite numbers (count,) of a child element; without it the default, or an error when there is none."""
    found = child(element, tag)
    if found is None:
        if default is None:
            raise place.error(element, f"<{local_name(element)}> needs <{tag}>")
        return np.array(default)
    return words(place, found, count)


def number(place: Place, element: Element, tag: str, default: float | None = None) -> float:
    """Return the number of a child element, `inf` included; without it the default, or an error."""
    found = child(element, tag)
    if found is None:
        if default is None:
            raise place.error(element, f"<{local_name(element)}> needs <{tag}>")
        return default
    word = (found.text or "").strip()
    return float(word) if _INFINITE.fullmatch(word) else float(words(place, found, 1)[0])


def words(place: Place, element: Element, count: int) -> NDArray[np.float64]:
    """Return the finite numbers (count,) that are the text of an element."""
    given = (element.text or "").split()
    for word in given:
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            raise place.error(element, f"<{local_name(element)}>: {word!r} is no finite number")
    if len(given) != count:
        raise place.error(element, f"<{local_name(element)}> has {len(given)} numbers, expected {count}")
    return np.array([float(word) for word in given])


def pose_matrix(place: Place, element: Element | None) -> Matrix:
    """Return what a <pose> element says; absent or empty means none."""
    if element is None or not (element.text or "").strip():
        return np.eye(4)
    if element.get("rotation_format", "euler_rpy") == "quat_xyzw":
        values = words(place, element, 7)
        length = float(np.linalg.norm(values[3:]))
        if length == 0.0:
            raise place.error(element, "<pose>: a quaternion of four zeros is no rotation")
        rotation = from_quaternion(values[3:] / length)
    else:
        values = words(place, element, 6)
        angles = np.radians(values[3:]) if element.get("degrees", "").lower() in ("true", "1") else values[3:]
        rotation = from_roll_pitch_yaw(*angles)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, values[:3]
    return matrix


def pose_message(matrix: Matrix) -> dict[str, Any]:
    """Return a pose as scene files have it; what is not said there is no shift and no turn."""
    message: dict[str, Any] = {}
    if matrix[:3, 3].any():
        message["position"] = vector_message(matrix[:3, 3])
    if not np.array_equal(matrix[:3, :3], np.eye(3)):
        message["orientation"] = dict(zip("xyzw", quaternion(matrix[:3, :3]), strict=True))
    return message


def vector_message(values: NDArray[np.float64]) -> dict[str, float]:
    """Return a vector as scene files have it; what is not said there is 0."""
    return {axis: value for axis, value in zip("xyz", np.asarray(values).tolist(), strict=True) if value != 0.0}
