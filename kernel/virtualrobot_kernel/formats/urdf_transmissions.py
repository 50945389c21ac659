"""Transmissions of a URDF file: combinations of joints that its actuators move.

Format and formulas: ros2_control, transmission_interface. A simple transmission with the reductions m of its actuator
and n of its joint has a = m n (j - o), with o the joint's offset. Of the two that couple two joints,

    differential          a1 = m1 (n1 (j1 - o1) + n2 (j2 - o2))     a2 = m2 (n1 (j1 - o1) - n2 (j2 - o2))
    four-bar linkage      a1 = m1 n1 (j1 - o1)                       a2 = m2 ((j1 - o1) + n2 (j2 - o2))
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from virtualrobot_sdk.xml import Element

from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.urdf_elements import Place, text_attribute
from virtualrobot_kernel.formats.xml import FileWarning, children
from virtualrobot_kernel.world.structure import Actuator, Joint, JointType

_SCALAR = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)
_Ratios = Callable[[Sequence[float], Sequence[float]], Sequence[Sequence[float]]]
#: For each type: ratios [actuator][joint] from the reductions of its actuators and of its joints.
_TYPES: dict[str, tuple[int, _Ratios]] = {
    "SimpleTransmission": (1, lambda m, n: [[m[0] * n[0]]]),
    "DifferentialTransmission": (2, lambda m, n: [[m[0] * n[0], m[0] * n[1]], [m[1] * n[0], -m[1] * n[1]]]),
    "FourBarLinkageTransmission": (2, lambda m, n: [[m[0] * n[0], 0.0], [m[1], m[1] * n[1]]]),
}


def read_transmissions(
    uri: str, robot: Element, joints: Sequence[Joint], warnings: list[FileWarning]
) -> tuple[Actuator, ...]:
    """Return the actuators of a file's transmissions; none where these only say that each motor is its joint.

    Transmissions are hints for controllers: when one of them can't be read, that is told in `warnings`, and the robot
    has no actuators.
    """
    movable = {joint.name for joint in joints if joint.type in _SCALAR and joint.mimic is None}
    found: dict[str, Actuator] = {}
    try:
        for element in children(robot, "transmission"):
            place = Place(uri, f"transmission {element.get('name', '')!r}")
            for actuator in _read(place, element):
                if actuator.name in found:
                    raise place.error(element, f"there is another actuator {actuator.name!r}")
                for joint, _ in actuator.terms:
                    if joint not in movable:
                        raise place.error(element, f"{joint!r} is no joint that is moved by itself")
                found[actuator.name] = actuator
    except MalformedFileError as error:
        warnings.append(FileWarning.of(error, "; the robot's transmissions are left out"))
        return ()
    own = all(not one.offset and [ratio for _, ratio in one.terms] == [1.0] for one in found.values())
    return () if own else tuple(found.values())


def _read(place: Place, transmission: Element) -> list[Actuator]:
    """Return the actuators of one transmission; raise MalformedFileError for one that can't be read."""
    kind = (transmission.findtext("type") or transmission.get("type", "")).strip().rpartition("/")[2]
    if kind not in _TYPES:
        raise place.error(transmission, f"unknown type {kind!r}; known: {', '.join(_TYPES)}")
    count, ratios_of = _TYPES[kind]
    actuators, joints = _ordered(transmission, "actuator"), _ordered(transmission, "joint")
    if len(actuators) != count or len(joints) != count:
        counts = f"{len(actuators)} actuators and {len(joints)} joints"
        raise place.error(transmission, f"it has {counts}, expected {count} each")
    names = [text_attribute(place, joint, "name") for joint in joints]
    offsets = [_inner(place, joint, "offset", 0.0) for joint in joints]
    reductions = [_inner(place, one, "mechanicalReduction", 1.0) for one in (*actuators, *joints)]
    if 0.0 in reductions:
        raise place.error(transmission, "a mechanicalReduction is 0")
    ratios = ratios_of(reductions[:count], reductions[count:])
    return [
        Actuator(
            text_attribute(place, actuator, "name"),
            tuple((name, ratio) for name, ratio in zip(names, row, strict=True) if ratio),
            0.0 - sum(ratio * offset for ratio, offset in zip(row, offsets, strict=True)),
        )
        for actuator, row in zip(actuators, ratios, strict=True)
    ]


def _ordered(transmission: Element, kind: str) -> list[Element]:
    """Return the joints or actuators in the order of their roles (`joint1`, `joint2`), else of the file."""
    return sorted(transmission.iterchildren(kind), key=lambda one: (one.findtext("role") or "").strip())


def _inner(place: Place, element: Element, name: str, default: float) -> float:
    """Return the number in a child element; `default` where there is none."""
    text = (element.findtext(name) or "").strip()
    try:
        value = float(text) if text else default
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise place.error(element, f"<{name}> is {text!r}, which is no finite number")
    return value
