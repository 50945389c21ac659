"""Small elements of URDF: numbers, origins, inertia, geometry, materials; each error names file, line and element.

Format: http://wiki.ros.org/urdf/XML; angles are roll, pitch, yaw about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np
from virtualrobot_sdk.poses import from_roll_pitch_yaw
from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.xml import FileWarning, malformed
from virtualrobot_kernel.world.figures import Box, Capsule, Cylinder, Geometry, Pose, Sphere
from virtualrobot_kernel.world.structure import Inertial

Color = tuple[float, float, float, float]

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")


@dataclass(frozen=True, slots=True)
class Place:
    """Place in a file: its name, and the element that is being read, for people; `warnings` takes what is odd there."""

    uri: str
    path: str
    warnings: list[FileWarning] = field(default_factory=list)

    def error(self, element: Element, message: str) -> MalformedFileError:
        """Return the error `model.urdf:41: joint 'a': message`."""
        return malformed(self.uri, line_of(element), message, self.path)

    def warn(self, element: Element, message: str) -> None:
        """Note that something is odd, in the words of an error."""
        self.warnings.append(FileWarning.of(self.error(element, message)))


def text_attribute(place: Place, element: Element, name: str) -> str:
    """Return an attribute that must be there and not be empty."""
    text = element.get(name, "").strip()
    if not text:
        raise place.error(element, f"<{local_name(element)}> needs the attribute {name!r}")
    return text


def numbers(place: Place, element: Element, name: str, count: int, default: tuple[float, ...] = ()) -> list[float]:
    """Return `count` finite numbers from an attribute; `default` when it is absent, an error when that is empty.

    Numbers after the last of three or four are passed over with a warning: some models have them.
    """
    text = element.get(name, "")
    if element.get(name) is None or not text.strip():
        if not default:
            raise place.error(element, f"<{local_name(element)}> needs {_plural(count)} in {name!r}")
        return list(default)
    words = text.split()
    values = []
    for word in words:
        # Python's float() takes words such as nan, inf and 1_0 too.
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            raise place.error(element, f"{name}={text!r}: {word!r} is no finite number")
        values.append(float(word))
    if len(values) > count >= 3:
        place.warn(element, f"{name}={text!r} has {_plural(len(values))}; the first {count} are taken")
        return values[:count]
    if len(values) != count:
        raise place.error(element, f"{name}={text!r} has {_plural(len(values))}, expected {count}")
    return values


def number(place: Place, element: Element, name: str, default: float | None = None) -> float:
    """Return one finite number from an attribute; `default` when it is absent, an error when that is None."""
    return numbers(place, element, name, 1, () if default is None else (default,))[0]


def extent(place: Place, element: Element, name: str, count: int = 1) -> tuple[float, ...]:
    """Return lengths in meters that are not below 0."""
    values = numbers(place, element, name, count)
    if min(values) < 0.0:
        raise place.error(element, f"{name}={element.get(name)!r} must not be below 0")
    return tuple(values)


def origin(place: Place, element: Element) -> Pose:
    """Return the pose that the child <origin> tells; identity when there is none."""
    child = element.find("origin")
    if child is None:
        return read_only(np.eye(4))
    zero = (0.0, 0.0, 0.0)
    roll, pitch, yaw = numbers(place, child, "rpy", 3, zero)
    pose = np.eye(4)
    pose[:3, :3] = from_roll_pitch_yaw(roll, pitch, yaw)
    pose[:3, 3] = numbers(place, child, "xyz", 3, zero)
    return read_only(pose)


def read_only(pose: np.ndarray) -> Pose:
    """Return the array itself, made read-only."""
    pose.setflags(write=False)
    return pose


def inertial(place: Place, link: Element) -> Inertial | None:
    """Return mass and inertia of a link, or None when it has no <inertial>."""
    element = link.find("inertial")
    if element is None:
        return None
    mass_element, inertia = element.find("mass"), element.find("inertia")
    if mass_element is None:
        raise place.error(element, "<inertial> needs a <mass>")
    mass = number(place, mass_element, "value")
    if mass < 0.0:
        raise place.error(mass_element, f"mass {mass:g} kg must not be below 0")
    moments = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), 0.0)
    if inertia is not None:
        moments = {name: number(place, inertia, name, 0.0) for name in moments}
    return Inertial(
        mass,
        origin(place, element),
        (moments["ixx"], moments["iyy"], moments["izz"]),
        (moments["ixy"], moments["ixz"], moments["iyz"]),
    )


def primitive(place: Place, shape: Element) -> Geometry | None:
    """Return the geometry of a <box>, <sphere>, <cylinder> or <capsule> (the last is a common extension).

    None for one without extent: there are robots with spheres of radius 0 in them.
    """
    kind = local_name(shape)
    if kind == "box":
        x, y, z = extent(place, shape, "size", 3)
        return Box((x, y, z)) if x and y and z else None
    if kind not in ("sphere", "cylinder", "capsule"):
        raise place.error(shape, f"unknown geometry <{kind}>; known: box, sphere, cylinder, capsule, mesh")
    (radius,) = extent(place, shape, "radius")
    if kind == "sphere":
        return Sphere(radius) if radius else None
    (length,) = extent(place, shape, "length")
    if not (radius and length):
        return None
    return Cylinder(radius, length) if kind == "cylinder" else Capsule(radius, length)


@dataclass(slots=True)
class Palette:
    """Colours of a file by material name; `warnings` takes what is odd about its materials."""

    uri: str
    warnings: list[FileWarning]
    colors: dict[str, Color] = field(default_factory=dict)
    textured: set[str] = field(default_factory=set)
    _told: set[str] = field(default_factory=set)
    _read: set[Element] = field(default_factory=set)

    def learn(self, element: Element) -> None:
        """Remember the colour of a <material> that has name and colour; the first of a name counts."""
        color = self._color(element)
        name = element.get("name", "")
        if name and color is not None:
            self.colors.setdefault(name, color)
        if name and _has_texture(element):
            self.textured.add(name)

    def color_of(self, place: Place, visual: Element) -> Color | None:
        """Return the colour that a <visual> asks for: its own first, then that of its material's name.

        None keeps the mesh's own look.
        """
        element = visual.find("material")
        if element is None:
            return None
        color = self._color(element)
        name = element.get("name", "")
        if color is None:
            color = self.colors.get(name)
        if _has_texture(element) or (color is None and name in self.textured):
            self._warn(place, element, "the texture of a URDF material is not drawn; the mesh keeps its own look")
        elif color is None and name and element.find("color") is None:
            self._warn(place, element, f"material {name!r} is defined nowhere; the mesh keeps its own look")
        return color

    def _color(self, element: Element) -> Color | None:
        child = element.find("color")
        if child is None:
            return None
        # A material with a name is asked for again and again, and told of once.
        told = self.warnings if child not in self._read else []
        self._read.add(child)
        place = Place(self.uri, f"material {element.get('name', '')!r}", told)
        try:
            parts = numbers(place, child, "rgba", 4)
        except MalformedFileError as error:
            told.append(FileWarning.of(error, "; it is no colour"))
            return None
        red, green, blue, alpha = (min(max(part, 0.0), 1.0) for part in parts)
        if [red, green, blue, alpha] != parts:
            place.warn(child, f"rgba={child.get('rgba')!r}: each part is from 0 to 1, and the nearest is taken")
        return red, green, blue, alpha

    def _warn(self, place: Place, element: Element, message: str) -> None:
        """Note what is odd about a material; once for each name."""
        name = element.get("name", "")
        if name not in self._told:
            self._told |= {name} if name else set()
            place.warn(element, message)


def _has_texture(element: Element) -> bool:
    texture = element.find("texture")
    return texture is not None and bool(texture.get("filename"))


def _plural(count: int) -> str:
    return "1 number" if count == 1 else f"{count} numbers"
