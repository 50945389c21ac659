"""SRDF files: MoveIt's description of a robot besides its URDF; groups, postures, and links that may touch.

Format: https://wiki.ros.org/srdf and MoveIt's tutorial "URDF and SRDF"; names are looked up as MoveIt does
(srdfdom `Model::initXml`, moveit_core `RobotModel::addJointModelGroup`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from virtualrobot_kernel.errors import MalformedFileError, UnknownNameError
from virtualrobot_kernel.formats.files import File
from virtualrobot_kernel.formats.urdf_elements import Place, numbers, text_attribute
from virtualrobot_kernel.formats.xml import (
    Element,
    FileWarning,
    children,
    line_of,
    local_name,
    malformed,
    parse_xml,
)
from virtualrobot_kernel.world.structure import (
    Joint,
    JointGroup,
    JointType,
    LinkData,
    LinkPair,
    NodeSpec,
    RobotData,
)

_READ = ("group", "group_state", "end_effector", "virtual_joint", "passive_joint", "disable_collisions")


@dataclass(frozen=True, slots=True)
class Semantics:
    """Content of an SRDF file about one robot; names of links are without the robot's."""

    groups: tuple[JointGroup, ...] = ()
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    allowed_collisions: tuple[LinkPair, ...] = ()
    flange: str = ""
    warnings: tuple[FileWarning, ...] = ()


def with_semantics(robot: NodeSpec, semantics: Semantics) -> NodeSpec:
    """Return the robot's node with what the SRDF file says."""
    data = robot.data if isinstance(robot.data, RobotData) else RobotData()
    return replace(
        robot,
        data=replace(
            data,
            flange=semantics.flange or data.flange,
            postures={**data.postures, **semantics.postures},
            groups=semantics.groups,
            allowed_collisions=semantics.allowed_collisions,
        ),
    )


def with_allowed(robot: NodeSpec, pairs: Iterable[LinkPair]) -> NodeSpec:
    """Return the robot's node with more pairs of links that may touch."""
    data = robot.data if isinstance(robot.data, RobotData) else RobotData()
    return replace(robot, data=replace(data, allowed_collisions=(*data.allowed_collisions, *pairs)))


def read_srdf(file: File, nodes: tuple[NodeSpec, ...]) -> Semantics:
    """Return the content of an SRDF file about the robot whose nodes (the robot first, its links below) are given.

    Groups name the joints that can be moved, in the robot's order: those of chains, joints, links and subgroups. A
    `group_state` becomes a posture under its own name, or under `group/state` when another group's state has that
    name. The parent link of the only `end_effector` becomes the flange, and that of each one the end of its parent
    group, where that is given by joints.

    Raises:
        MalformedFileError: naming file and line, for what is no SRDF, and for names that the robot lacks, with the
            nearest that it has.
    """
    root = parse_xml(file.data, file.key)
    if local_name(root) != "robot":
        raise malformed(file.key, line_of(root), f"the root element is <{local_name(root)}>, expected <robot>")
    return _Reader(file.key, nodes).read(root)


class _Reader:
    """Reader of one file, with the robot's joints and links."""

    def __init__(self, uri: str, nodes: tuple[NodeSpec, ...]) -> None:
        prefix = f"{nodes[0].name}."
        self.uri = uri
        self.joints: dict[str, Joint] = {}
        self.link_before: dict[str, str] = {}
        self.joint_of_link: dict[str, str] = {}
        for node in nodes[1:]:
            if isinstance(node.data, LinkData):
                link = node.name.removeprefix(prefix)
                self.joints[node.data.joint.name] = node.data.joint
                self.joint_of_link[link] = node.data.joint.name
                self.link_before[link] = node.parent.removeprefix(prefix)
        self.movable = [
            name for name, joint in self.joints.items() if joint.type is not JointType.FIXED and not joint.mimic
        ]
        self.virtual: set[str] = set()
        self.groups: dict[str, JointGroup] = {}
        self.warnings: list[FileWarning] = []

    def read(self, root: Element) -> Semantics:
        # How a robot stands in the world is no joint of ours; groups and states may name it.
        self.virtual = {element.get("name", "") for element in children(root, "virtual_joint")} - self.joints.keys()
        elements: dict[str, Element] = {}
        for element in children(root, "group"):
            name = text_attribute(Place(self.uri, "group"), element, "name")
            if name in elements:
                raise self._error(element, f"the name is taken by the group on line {line_of(elements[name])}", name)
            elements[name] = element
        for name in elements:
            self._group(name, elements, ())
        postures = self._postures(root)
        flange = self._flange(root)
        for element in children(root, "virtual_joint"):
            if element.get("type") != "fixed":
                self._warn(
                    element,
                    f"the virtual joint {element.get('name', '')!r} is {element.get('type')}: say so when the model is "
                    "imported, by its base joint",
                )
        for element in children(root, "passive_joint"):
            joint = text_attribute(Place(self.uri, "passive_joint"), element, "name")
            if joint in self.virtual:
                continue
            self._known(element, "joint", joint)
            self._warn(element, f"the joint {element.get('name')!r} is passive, which is not kept: it can be moved")
        for element in root.iterchildren("*"):
            if local_name(element) not in _READ:
                self._warn(element, f"<{local_name(element)}> is not read")
        groups = tuple(self.groups[name] for name in elements)
        return Semantics(groups, postures, self._pairs(root), flange, tuple(self.warnings))

    def _group(self, name: str, elements: Mapping[str, Element], above: tuple[str, ...]) -> JointGroup:
        """Return a group, with those below it; `above` are the groups that ask for it."""
        if name in self.groups:
            return self.groups[name]
        element = elements[name]
        place = Place(self.uri, f"group {name!r}")
        if name in above:
            raise self._error(element, f"the groups contain each other: {' -> '.join((*above, name))}", name)
        found: set[str] = set()
        ends: list[tuple[str, str]] = []
        for member in element.iterchildren("*"):
            kind = local_name(member)
            if kind == "chain":
                base, tip = (text_attribute(place, member, end) for end in ("base_link", "tip_link"))
                found.update(self._chain(member, base, tip))
                ends.append((base, tip))
            elif kind == "joint":
                joint = text_attribute(place, member, "name")
                found |= set() if joint in self.virtual else {self._known(member, "joint", joint)}
            elif kind == "link":
                link = self._known(member, "link", text_attribute(place, member, "name"))
                found.add(self.joint_of_link[link])
            elif kind == "group":
                below = text_attribute(place, member, "name")
                if below not in elements:
                    raise self._unknown(member, "group", below, elements)
                found.update(self._group(below, elements, (*above, name)).joint_names)
            else:
                raise self._error(member, f"unknown member <{kind}>; known: chain, joint, link, group", name)
        one_chain = len(ends) == 1 and len([*element.iterchildren("*")]) == 1
        base, tip = ends[0] if one_chain else ("", "")
        joints = tuple(joint for joint in self.movable if joint in found)
        self.groups[name] = JointGroup(name, joints, base, tip)
        return self.groups[name]

    def _chain(self, element: Element, base: str, tip: str) -> list[str]:
        """Return the joints between two links, the second below the first."""
        self._known(element, "link", base)
        passed, link = [], self._known(element, "link", tip)
        while link != base:
            passed.append(self.joint_of_link[link])
            link = self.link_before[link]
            if link not in self.joint_of_link:
                raise malformed(self.uri, line_of(element), f"no chain leads from {base!r} to {tip!r}: not below it")
        return passed

    def _postures(self, root: Element) -> dict[str, dict[str, float]]:
        postures: dict[str, dict[str, float]] = {}
        for element in children(root, "group_state"):
            place = Place(self.uri, "group_state")
            name, group = (text_attribute(place, element, key) for key in ("name", "group"))
            if group not in self.groups:
                raise self._unknown(element, "group", group, self.groups)
            label = name if name not in postures else f"{group}/{name}"
            if label in postures:
                raise malformed(self.uri, line_of(element), f"group {group!r} has two states named {name!r}")
            values: dict[str, float] = {}
            for member in children(element, "joint"):
                joint = text_attribute(place, member, "name")
                if joint not in self.virtual and self._known(member, "joint", joint) in self.movable:
                    (values[joint],) = numbers(Place(self.uri, f"group_state {name!r}"), member, "value", 1)
            outside = [joint for joint, value in values.items() if not self._within(joint, value)]
            if outside:
                limits = self.joints[outside[0]].limits
                self._warn(
                    element,
                    f"the state {name!r} of {group!r} is left out: {outside[0]!r} is {values[outside[0]]:g}, its "
                    f"limits are {limits.lower:g} to {limits.upper:g}",
                )
            else:
                postures[label] = values
        return postures

    def _within(self, joint: str, value: float) -> bool:
        limits = self.joints[joint].limits
        return limits.lower <= value <= limits.upper

    def _flange(self, root: Element) -> str:
        """Return the link that the only end effector is mounted on; empty for none and for several."""
        parents: list[str] = []
        for element in children(root, "end_effector"):
            place = Place(self.uri, "end_effector")
            group = text_attribute(place, element, "group")
            if group not in self.groups:
                raise self._unknown(element, "group", group, self.groups)
            parents.append(self._known(element, "link", text_attribute(place, element, "parent_link")))
            above = self.groups.get(element.get("parent_group", ""))
            if above is not None and not above.tip_link:
                self.groups[above.name] = replace(above, tip_link=parents[-1])
        if len(parents) > 1:
            self._warn(root, f"there are {len(parents)} end effectors; none of their parent links becomes the flange")
        return parents[0] if len(parents) == 1 else ""

    def _pairs(self, root: Element) -> tuple[LinkPair, ...]:
        pairs: dict[frozenset[str], LinkPair] = {}
        for element in children(root, "disable_collisions"):
            place = Place(self.uri, "disable_collisions")
            first, second = (
                self._known(element, "link", text_attribute(place, element, key)) for key in ("link1", "link2")
            )
            pairs.setdefault(frozenset((first, second)), LinkPair(first, second, element.get("reason", "")))
        return tuple(pairs.values())

    def _known(self, element: Element, kind: str, name: str) -> str:
        """Return the name of a link or joint; raise when the robot has none of that name."""
        valid: Iterable[str] = self.joint_of_link if kind == "link" else self.joints
        if name not in valid:
            raise self._unknown(element, kind, name, valid)
        return name

    def _unknown(self, element: Element, kind: str, name: str, valid: Iterable[str]) -> MalformedFileError:
        unknown = UnknownNameError(kind, name, valid)
        error = malformed(self.uri, line_of(element), str(unknown))
        error.metadata.update(unknown.metadata)
        return error

    def _error(self, element: Element, message: str, group: str) -> MalformedFileError:
        return malformed(self.uri, line_of(element), message, f"group {group!r}")

    def _warn(self, element: Element, message: str) -> None:
        self.warnings.append(FileWarning.of(malformed(self.uri, line_of(element), message)))
