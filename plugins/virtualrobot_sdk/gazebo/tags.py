"""The small elements of Gazebo's sensor tags: numbers, texts, poses, noise.

Format: http://sdformat.org/spec, element <sensor>. Elements are of any library with the interface of
xml.etree.ElementTree, such as lxml. Angles are roll, pitch, yaw about fixed axes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from virtualrobot_sdk.kinematics import Floats
from virtualrobot_sdk.poses import from_quaternion, from_roll_pitch_yaw
from virtualrobot_sdk.xml import Element

Warn = Callable[[Element, str], None]
"""Takes an element and what is odd about it."""
Values = dict[str, Any]
"""Fields of a message as scene files have them; a field that is not there is not said."""

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_INFINITE = re.compile(r"[-+]?inf(inity)?", re.IGNORECASE)


class BadTagError(Exception):
    """A tag that cannot be read: `element` and why."""

    def __init__(self, element: Element, why: str) -> None:
        """Take the element and the sentence."""
        super().__init__(why)
        self.element = element


@dataclass(frozen=True, slots=True)
class Noise:
    """Parameters of a <noise>, in the unit of the quantity that it is added to."""

    mean: float = 0.0
    deviation: float = 0.0
    bias_mean: float = 0.0
    bias_deviation: float = 0.0
    bias_walk: float = 0.0
    precision: float = 0.0


def local(element: Element) -> str:
    """Return an element's name without namespace and prefix; empty for comments."""
    tag = element.tag
    return tag.rpartition("}")[2].rpartition(":")[2] if isinstance(tag, str) else ""


def children(element: Element, *names: str) -> Iterator[Element]:
    """Yield the child elements of these names, in the order of the file."""
    return (child for child in element if local(child) in names)


def child(element: Element | None, *path: str) -> Element | None:
    """Return the first child element of a name, or that down a path of names; None where there is none."""
    for name in path:
        element = None if element is None else next(children(element, name), None)
    return element


def text(element: Element | None, *path: str) -> str:
    """Return the text at a path of child elements; empty where there is none."""
    found = child(element, *path)
    return "" if found is None else (found.text or "").strip()


def number(element: Element | None, *path: str, default: float = 0.0) -> float:
    """Return the number at a path of child elements; `inf` is one, as in SDFormat."""
    found = child(element, *path)
    word = "" if found is None else (found.text or "").strip()
    if not word:
        return default
    if _INFINITE.fullmatch(word):
        return float(word)
    if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
        raise BadTagError(found, f"<{path[-1]}> is {word!r}, which is no number")
    return float(word)


def not_negative(element: Element | None, *path: str, default: float = 0.0) -> float:
    """Return the number at a path of child elements, which must be finite and not below 0."""
    value = number(element, *path, default=default)
    if not (math.isfinite(value) and value >= 0.0):
        raise BadTagError(child(element, *path), f"<{path[-1]}> is {value:g}; it must be a number not below 0")
    return value


def count(element: Element | None, *path: str, default: int = 1) -> int:
    """Return the whole number from 1 at a path of child elements."""
    value = number(element, *path, default=default)
    if not (1.0 <= value <= 1e7 and value == int(value)):
        raise BadTagError(child(element, *path), f"<{path[-1]}> is {value:g}; it must be a whole number from 1")
    return int(value)


def vector(element: Element | None, *path: str) -> tuple[float, ...]:
    """Return all numbers at a path of child elements."""
    found = child(element, *path)
    words = (found.text or "").split() if found is not None else []
    for word in words:
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            raise BadTagError(found, f"<{local(found)}>: {word!r} is no finite number")
    return tuple(map(float, words))


def pose(element: Element | None) -> Floats:
    """Return what the <pose> of an element says (old files: <origin>), (4, 4); identity where there is none."""
    matrix = np.eye(4)
    found = child(element, "pose")
    found = child(element, "origin") if found is None else found
    values = vector(found) if found is not None else ()
    if found is None or not values:
        return matrix
    matrix[:3, 3] = values[:3] if len(values) in (3, 6, 7) else np.nan
    if found.get("rotation_format") == "quat_xyzw" and len(values) == 7:
        length = math.sqrt(sum(value * value for value in values[3:]))
        if length == 0.0:
            raise BadTagError(found, "<pose>: a quaternion of four zeros is no rotation")
        matrix[:3, :3] = from_quaternion(np.array(values[3:]) / length)
    elif len(values) == 6:
        degrees = found.get("degrees", "").lower() in ("true", "1")
        matrix[:3, :3] = from_roll_pitch_yaw(*np.radians(values[3:]) if degrees else values[3:])
    elif len(values) != 3:
        raise BadTagError(found, f"<{local(found)}> has {len(values)} numbers, expected 6")
    return matrix


def noise(element: Element | None, warn: Warn) -> Noise:
    """Return what a <noise> (or the old <rate> and <accel> of an <imu>) says; nothing where there is none."""
    if element is None:
        return Noise()
    kind = element.get("type", "") or text(element, "type")
    if kind == "none":
        return Noise()
    if kind not in ("", "gaussian", "gaussian_quantized"):
        warn(element, f"noise of the type {kind!r} is left out; known: gaussian, gaussian_quantized")
        return Noise()
    return Noise(
        number(element, "mean"),
        not_negative(element, "stddev"),
        number(element, "bias_mean"),
        not_negative(element, "bias_stddev"),
        not_negative(element, "dynamic_bias_stddev"),
        not_negative(element, "precision") if kind == "gaussian_quantized" else 0.0,
    )


def said(**values: object) -> Values:
    """Return the values that are neither None nor zero nor empty."""
    return {name: value for name, value in values.items() if value or isinstance(value, dict)}
