"""Joints of a URDF file: read one by one, then checked together as a tree."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from virtualrobot_sdk.xml import Element, line_of

from virtualrobot_kernel.formats.limits import joint_limits
from virtualrobot_kernel.formats.urdf_elements import Place, number, numbers, origin, text_attribute
from virtualrobot_kernel.formats.xml import FileWarning, children, malformed
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Mimic

_TYPES = {joint_type.value[0]: joint_type for joint_type in JointType}
_ONE_COORDINATE = (JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC)


@dataclass(frozen=True, slots=True, eq=False)
class UrdfJoint:
    """Joint between two links of the file; `parent_t_joint` is its frame at zero."""

    joint: Joint
    parent: str
    child: str
    parent_t_joint: Pose
    line: int


def read_joints(uri: str, robot: Element, warnings: list[FileWarning]) -> list[UrdfJoint]:
    """Return the joints in the order of the file; mimic joints follow a joint that follows none.

    Raises:
        MalformedFileError: naming file, line and joint, for whatever makes no joint.
    """
    joints: dict[str, UrdfJoint] = {}
    for element in children(robot, "joint"):
        joint = _read_joint(uri, element, warnings)
        name = joint.joint.name
        if name in joints:
            raise malformed(uri, joint.line, f"the name is taken by the joint on line {joints[name].line}", _path(name))
        joints[name] = joint
    for name, joint in joints.items():
        mimic = joint.joint.mimic
        if mimic is not None and mimic.joint not in joints:
            told = f"it mimics {mimic.joint!r}, which is no joint; it moves by itself"
            warnings.append(FileWarning.of(malformed(uri, joint.line, told, _path(name))))
            joints[name] = replace(joint, joint=replace(joint.joint, mimic=None))
    return [
        replace(joint, joint=replace(joint.joint, mimic=_followed(uri, name, joints))) for name, joint in joints.items()
    ]


def _read_joint(uri: str, element: Element, warnings: list[FileWarning]) -> UrdfJoint:
    name = text_attribute(Place(uri, "joint"), element, "name")
    place = Place(uri, _path(name), warnings)
    kind = text_attribute(place, element, "type")
    if kind not in _TYPES:
        raise place.error(element, f"unknown joint type {kind!r}; known: {', '.join(_TYPES)}")
    ends = {}
    for end in ("parent", "child"):
        found = element.find(end)
        if found is None:
            raise place.error(element, f"the joint has no <{end}>")
        ends[end] = text_attribute(place, found, "link")
    joint_type = _TYPES[kind]
    joint = Joint(
        name,
        joint_type,
        _axis(place, element, joint_type),
        _limits(place, element, joint_type),
        _mimic(place, element, joint_type),
    )
    return UrdfJoint(joint, ends["parent"], ends["child"], origin(place, element), line_of(element))


def _axis(place: Place, element: Element, joint_type: JointType) -> tuple[float, float, float]:
    """Return the unit axis; x when there is none, as URDF says."""
    child = element.find("axis")
    if child is None or joint_type in (JointType.FIXED, JointType.FLOATING):
        return 1.0, 0.0, 0.0
    x, y, z = numbers(place, child, "xyz", 3)
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise place.error(child, f"axis {x:g} {y:g} {z:g} has no direction: at least one number must not be 0")
    return x / length, y / length, z / length


def _limits(place: Place, element: Element, joint_type: JointType) -> JointLimits:
    child = element.find("limit")
    if joint_type is JointType.FIXED:
        return JointLimits()
    bounded = joint_type in (JointType.REVOLUTE, JointType.PRISMATIC)
    if child is None:
        if bounded:
            kind = joint_type.value[0]
            raise place.error(element, f"a {kind} joint needs a <limit>; one without limits has the type continuous")
        return joint_limits()
    # How fast and how strong have a direction of their own: some files write them with a sign.
    velocity, effort = abs(number(place, child, "velocity", 0.0)), abs(number(place, child, "effort", 0.0))
    if velocity == 0.0:
        speed = JointLimits().velocity
        place.warn(child, f"the limit tells no velocity; {speed:g} rad/s (m/s) is taken")
    if not bounded:
        return joint_limits(velocity=velocity, effort=effort)
    lower, upper = number(place, child, "lower", 0.0), number(place, child, "upper", 0.0)
    if lower > upper:
        raise place.error(child, f"the lower limit {lower:g} is above the upper limit {upper:g}")
    return joint_limits(lower, upper, velocity, effort)


def _mimic(place: Place, element: Element, joint_type: JointType) -> Mimic | None:
    child = element.find("mimic")
    if child is None:
        return None
    if joint_type is JointType.FIXED:
        place.warn(child, "a fixed joint cannot follow another one; it stays fixed")
        return None
    if joint_type not in _ONE_COORDINATE:
        raise place.error(child, f"a {joint_type.value[0]} joint cannot follow another one")
    name = child.get("joint", "").strip()
    if not name:
        raise place.error(child, "<mimic> needs the attribute 'joint'")
    return Mimic(name, number(place, child, "multiplier", 1.0), number(place, child, "offset", 0.0))


def _followed(uri: str, name: str, joints: Mapping[str, UrdfJoint]) -> Mimic | None:
    """Return whom the joint follows in the end, where the one it follows may follow another one."""
    first, mimic = joints[name], joints[name].joint.mimic
    if mimic is None:
        return None
    passed = [name]
    while True:
        passed.append(mimic.joint)
        target = joints[mimic.joint].joint
        if passed.count(mimic.joint) > 1:
            raise malformed(uri, first.line, f"the mimic joints follow each other: {' -> '.join(passed)}", _path(name))
        if target.type not in _ONE_COORDINATE:
            kind = target.type.value[0]
            raise malformed(
                uri, first.line, f"it mimics {target.name!r}, a {kind} joint without one value", _path(name)
            )
        onward = target.mimic
        if onward is None:
            return mimic
        # m (m' x + o') + o
        mimic = Mimic(
            onward.joint, mimic.multiplier * onward.multiplier, mimic.multiplier * onward.offset + mimic.offset
        )


def tree_order(uri: str, links: Mapping[str, int], joints: Sequence[UrdfJoint]) -> list[tuple[str, UrdfJoint | None]]:
    """Return the links, each with the joint before it: the root first (with None), then depth first.

    Branches keep the order of the joints in the file.

    `links` holds the line of each link by name.

    Raises:
        MalformedFileError: for links that no link is, links with two parents, two roots and loops.
    """
    before: dict[str, UrdfJoint] = {}
    after: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        path = _path(joint.joint.name)
        for end, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                known = ", ".join(list(links)[:20])
                raise malformed(uri, joint.line, f"its {end} {link!r} is no link; known: {known}", path)
        if joint.child in before:
            other = before[joint.child].joint.name
            raise malformed(
                uri, joint.line, f"link {joint.child!r} has two parents: joint {other!r} leads to it too", path
            )
        before[joint.child] = joint
        after.setdefault(joint.parent, []).append(joint)
    roots = [link for link in links if link not in before]
    if len(roots) > 1:
        named = ", ".join(f"{link!r} (line {links[link]})" for link in roots[:10])
        raise malformed(uri, links[roots[1]], f"the file has {len(roots)} roots, links that no joint leads to: {named}")
    order: list[tuple[str, UrdfJoint | None]] = []
    stack: list[tuple[str, UrdfJoint | None]] = [(roots[0], None)] if roots else []
    while stack:
        link, joint = stack.pop()
        order.append((link, joint))
        stack.extend((onward.child, onward) for onward in reversed(after.get(link, ())))
    if len(order) < len(links):
        reached = {link for link, _ in order}
        _raise_loop(uri, next(link for link in links if link not in reached), before)
    return order


def _raise_loop(uri: str, start: str, before: Mapping[str, UrdfJoint]) -> None:
    """Raise the error that names the loop above the link `start`."""
    passed = [start]
    while passed.count(passed[-1]) == 1:
        passed.append(before[passed[-1]].parent)
    loop = passed[passed.index(passed[-1]) :][::-1]
    joint = before[loop[-1]]
    raise malformed(uri, joint.line, f"the links form a loop: {' -> '.join(loop)}", _path(joint.joint.name))


def _path(name: str) -> str:
    return f"joint {name!r}"
