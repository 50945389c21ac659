"""SRDF files: MoveIt's description of a robot besides its URDF; groups, postures, and links that may touch.

Format: https://wiki.ros.org/srdf and MoveIt's tutorial "URDF and SRDF"; names are looked up as MoveIt does
(srdfdom `Model::initXml`, moveit_core `RobotModel::addJointModelGroup`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_kernel.errors import MalformedFileError, UnknownNameError
from virtualrobot_kernel.formats.files import File
from virtualrobot_kernel.formats.urdf_elements import Place, numbers, text_attribute
from virtualrobot_kernel.formats.xml import FileWarning, children, malformed, parse_xml
from virtualrobot_kernel.world.structure import (
    Joint,
    JointGroup,
    JointLimits,
    JointType,
    LinkData,
    LinkPair,
    NodeSpec,
    RobotData,
)

NO_LIMITS = JointLimits()
"""Limits of the coordinates of a planar or floating joint."""

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


def read_srdf(file: File, nodes: tuple[NodeSpec, ...], own_name: str = "") -> Semantics:
    """Return the content of an SRDF file about the robot whose nodes (the robot first, its links below) are given.

    Groups name the joints that can be moved, in the robot's order: those of chains, joints, links and subgroups. A
    `group_state` becomes a posture under its own name, or under `group/state` when another group's state has that
    name. The parent link of the only `end_effector` becomes the flange, and that of each one the end of its parent
    group, where that is given by joints. An element that is wrong, such as one that names what the robot lacks, is
    left out with a warning, and so is a group of which nothing else is left: nothing in the file changes how the robot
    moves. A file about a robot of another name than `own_name`, the robot's in its own file, is read with a warning;
    warnings come in the order of the file.

    Raises:
        MalformedFileError: naming file and line, for what is no SRDF.
    """
    root = parse_xml(file.data, file.key)
    if local_name(root) != "robot":
        raise malformed(file.key, line_of(root), f"the root element is <{local_name(root)}>, expected <robot>")
    return _Reader(file.key, nodes).read(root, own_name)


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
        self.unknown: set[tuple[str, str]] = set()
        self.warnings: list[FileWarning] = []

    def read(self, root: Element, own_name: str) -> Semantics:
        if own_name and (name := root.get("name", "").strip()) != own_name:
            self._warn(root, f"the file is about a robot {name!r}, and the model's own name is {own_name!r}")
        # How a robot stands in the world is no joint of ours; groups and states may name it.
        self.virtual = {element.get("name", "") for element in children(root, "virtual_joint")} - self.joints.keys()
        elements: dict[str, Element] = {}
        for element in children(root, "group"):
            with self._or_left_out():
                name = text_attribute(Place(self.uri, "group"), element, "name")
                if name in elements:
                    taken = f"the name is taken by the group on line {line_of(elements[name])}"
                    raise self._error(element, taken, name)
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
            with self._or_left_out():
                joint = text_attribute(Place(self.uri, "passive_joint"), element, "name")
                if joint not in self.virtual:
                    self._known(element, "joint", joint)
                    self._warn(element, f"the joint {joint!r} is passive, which is not kept: it can be moved")
        for element in root.iterchildren("*"):
            if local_name(element) not in _READ:
                self._warn(element, f"<{local_name(element)}> is not read")
        pairs = self._pairs(root)
        groups = tuple(self.groups[name] for name in elements if name in self.groups)
        return Semantics(groups, postures, pairs, flange, tuple(sorted(self.warnings, key=lambda told: told.line)))

    def _group(self, name: str, elements: Mapping[str, Element], above: tuple[str, ...]) -> JointGroup | None:
        """Return a group, with those below it; `above` are the groups that ask for it.

        None for one of which nothing is left, since all its members are wrong: it is left out, and so is what names it.
        """
        if name in self.groups or ("group", name) in self.unknown:
            return self.groups.get(name)
        element = elements[name]
        if name in above:
            raise self._error(element, f"the groups contain each other: {' -> '.join((*above, name))}", name)
        found: set[str] = set()
        ends: list[tuple[str, str]] = []
        members = [*element.iterchildren("*")]
        wrong = len(members)
        for member in members:
            with self._or_left_out():
                joints = self._member(name, member, elements, above, ends)
                found |= joints or set()
                wrong -= joints is not None
        if members and wrong == len(members):
            self.unknown.add(("group", name))
            return None
        one_chain = len(ends) == 1 and len(members) == 1
        base, tip = ends[0] if one_chain else ("", "")
        joints = tuple(joint for joint in self.movable if joint in found)
        self.groups[name] = JointGroup(name, joints, base, tip)
        return self.groups[name]

    def _member(
        self,
        group: str,
        member: Element,
        elements: Mapping[str, Element],
        above: tuple[str, ...],
        ends: list[tuple[str, str]],
    ) -> set[str] | None:
        """Return the joints of a group's member, None of a group that is left out; `ends` gets those of a chain."""
        place = Place(self.uri, f"group {group!r}")
        match local_name(member):
            case "chain":
                base, tip = (text_attribute(place, member, end) for end in ("base_link", "tip_link"))
                joints = set(self._chain(member, base, tip))
                ends.append((base, tip))
                return joints
            case "joint":
                joint = text_attribute(place, member, "name")
                return set() if joint in self.virtual else {self._known(member, "joint", joint)}
            case "link":
                return {self.joint_of_link[self._known(member, "link", text_attribute(place, member, "name"))]}
            case "group":
                name = self._of(elements, member, text_attribute(place, member, "name"))
                below = self._group(name, elements, (*above, group))
                return None if below is None else set(below.joint_names)
            case kind:
                raise self._error(member, f"unknown member <{kind}>; known: chain, joint, link, group", group)

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
            with self._or_left_out():
                self._posture(element, postures)
        return postures

    def _posture(self, element: Element, postures: dict[str, dict[str, float]]) -> None:
        """Add the posture of a group's state to those before it."""
        place = Place(self.uri, "group_state")
        name, group = (text_attribute(place, element, key) for key in ("name", "group"))
        self._of(self.groups, element, group)
        label = name if name not in postures else f"{group}/{name}"
        if label in postures:
            raise malformed(self.uri, line_of(element), f"group {group!r} has two states named {name!r}")
        values: dict[str, float] = {}
        for member in children(element, "joint"):
            joint = text_attribute(place, member, "name")
            with self._or_left_out():
                if joint in self.virtual or self._known(member, "joint", joint) not in self.movable:
                    continue
            if joint in self.joints:
                names = self.joints[joint].coordinate_names
                state = Place(self.uri, f"group_state {name!r}")
                values.update(zip(names, numbers(state, member, "value", len(names)), strict=True))
        for joint, value in values.items():
            limits = self.joints[joint].limits if joint in self.joints else NO_LIMITS
            if not limits.lower <= value <= limits.upper:
                raise malformed(
                    self.uri,
                    line_of(element),
                    f"the state {name!r} of {group!r} has {joint!r} at {value:g}, its limits are {limits.lower:g} to "
                    f"{limits.upper:g}",
                )
        postures[label] = values

    def _flange(self, root: Element) -> str:
        """Return the link that the only end effector is mounted on; empty for none and for several."""
        parents: list[str] = []
        for element in children(root, "end_effector"):
            place = Place(self.uri, "end_effector")
            with self._or_left_out():
                self._of(self.groups, element, text_attribute(place, element, "group"))
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
            with self._or_left_out():
                first, second = (
                    self._known(element, "link", text_attribute(place, element, key)) for key in ("link1", "link2")
                )
                pairs.setdefault(frozenset((first, second)), LinkPair(first, second, element.get("reason", "")))
        return tuple(pairs.values())

    def _known(self, element: Element, kind: str, name: str) -> str:
        """Return the name of a link or joint; raise when the robot has none of that name."""
        return self._of(self.joint_of_link if kind == "link" else self.joints, element, name, kind)

    def _of(self, valid: Iterable[str], element: Element, name: str, kind: str = "group") -> str:
        """Return the name; raise when it is none of the valid ones."""
        if name not in valid:
            unknown = UnknownNameError(kind, name, valid)
            error = malformed(self.uri, line_of(element), str(unknown))
            error.metadata.update(unknown.metadata)
            raise error
        return name

    @contextmanager
    def _or_left_out(self) -> Iterator[None]:
        """Have a warning take the place of an error; of those about an unknown name only the first is told."""
        try:
            yield
        except MalformedFileError as error:
            unknown = (error.metadata.get("kind", ""), error.metadata.get("name", ""))
            if unknown not in self.unknown:
                self.warnings.append(FileWarning.of(error, " (left out)"))
            if unknown[0]:
                self.unknown.add(unknown)

    def _error(self, element: Element, message: str, group: str) -> MalformedFileError:
        return malformed(self.uri, line_of(element), message, f"group {group!r}")

    def _warn(self, element: Element, message: str) -> None:
        self.warnings.append(FileWarning.of(malformed(self.uri, line_of(element), message)))
