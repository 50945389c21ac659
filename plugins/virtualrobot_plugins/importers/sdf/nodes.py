"""Models as nodes of a scene file: robots, parts and objects, with their sensors."""

from __future__ import annotations

from typing import Any

import numpy as np
from virtualrobot_sdk.poses import inverse

from virtualrobot_plugins.importers.sdf.elements import Matrix, Notes, pose_message
from virtualrobot_plugins.importers.sdf.figures import inertial_of, link_figures
from virtualrobot_plugins.importers.sdf.joints import WORLD, JointSpec, read_joint
from virtualrobot_plugins.importers.sdf.scopes import LinkElement, Scope
from virtualrobot_plugins.importers.sdf.sensors import sensor_nodes

Links = dict[str, tuple[LinkElement, Matrix]]
"""Element and pose in the model of each link, by full name, in the order of the file."""


def model_nodes(model: Scope, name: str, world_t_model: Matrix, main: str, notes: Notes) -> list[dict[str, Any]]:
    """Return the nodes of a model that is called `name`, parents before children.

    A model that is static or fixed to the world without moving joints is one object. One with moving joints is a robot
    with its links. Else each group of links that fixed joints hold together is a part with their mass.
    """
    links: Links = {full: (link, pose) for full, link, pose in model.all_links()}
    if not links:
        notes.warn(model.place, model.element, "the model has no link and is left out")
        return []
    if model.static:
        return _object(name, links, world_t_model, main, notes)
    joints = [
        read_joint(scope, prefix, pose, joint, notes)
        for prefix, scope, pose in model.all_joints()
        for joint in scope.joints
    ]
    if any(joint.axes for joint in joints):
        return _robot(model, name, links, joints, world_t_model, main, notes)
    groups = _groups(links, joints)
    nodes = []
    for anchored, members in groups:
        own = {full: links[full] for full in members}
        called = name if len(groups) == 1 else f"{name}_{members[0].replace('::', '_')}"
        if anchored:
            nodes += _object(called, own, world_t_model, main, notes)
        else:
            nodes += _part(called, own, world_t_model, len(groups) == 1, main, notes)
    return nodes


def _object(name: str, links: Links, world_t_model: Matrix, main: str, notes: Notes) -> list[dict[str, Any]]:
    figures = [figure for link, pose in links.values() for figure in link_figures(link, pose, main, notes)]
    node = {"name": name, "parent_t_node": pose_message(world_t_model), "figures": figures, "object": {}}
    return [node, *_sensors(name, links, np.eye(4), notes)]


def _part(name: str, links: Links, world_t_model: Matrix, alone: bool, main: str, notes: Notes) -> list[dict[str, Any]]:
    """Return one body: in the model's frame, or, where the model has others, in the frame of its first link."""
    model_t_node = np.eye(4) if alone else next(iter(links.values()))[1]
    figures: list[dict[str, Any]] = []
    mass = 0.0
    for link, pose in links.values():
        node_t_link = inverse(model_t_node) @ pose
        figures += link_figures(link, node_t_link, main, notes)
        inertial = inertial_of(link, node_t_link)
        mass += 0.0 if inertial is None else inertial["mass_kilograms"]
    pose = pose_message(world_t_model @ model_t_node)
    node = {"name": name, "parent_t_node": pose, "figures": figures, "part": {"mass_kilograms": mass}}
    return [node, *_sensors(name, links, inverse(model_t_node), notes)]


def _sensors(name: str, links: Links, node_t_model: Matrix, notes: Notes) -> list[dict[str, Any]]:
    """Return the sensors of links that are one node."""
    taken: set[str] = set()
    nodes = []
    for link, pose in links.values():
        place = link.place.inside(f"link {link.name!r}")
        nodes += sensor_nodes(link.element, place, name, name, node_t_model @ pose, taken, notes)
    return nodes


def _groups(links: Links, joints: list[JointSpec]) -> list[tuple[bool, list[str]]]:
    """Return links that fixed joints hold together, and whether the world is among them."""
    leader = {name: name for name in (*links, WORLD)}

    def find(name: str) -> str:
        while leader[name] != name:
            leader[name] = name = leader[leader[name]]
        return name

    for joint in joints:
        leader[find(joint.parent)] = find(joint.child)
    members: dict[str, list[str]] = {}
    for name in links:
        members.setdefault(find(name), []).append(name)
    return [(root == find(WORLD), names) for root, names in members.items()]


def _robot(
    model: Scope,
    name: str,
    links: Links,
    joints: list[JointSpec],
    world_t_model: Matrix,
    main: str,
    notes: Notes,
) -> list[dict[str, Any]]:
    """Return the robot and its links: branches to their ends, in the order of the joints in the file."""
    nodes = [{"name": name, "parent_t_node": pose_message(world_t_model), "robot": {"source": main}}]
    at: dict[str, list[JointSpec]] = {full: [] for full in (*links, WORLD)}
    for joint in joints:
        at[joint.parent].append(joint)
        at[joint.child].append(joint)
    placed: dict[str, tuple[str, Matrix]] = {}
    used: set[int] = set()
    names = {joint.name for joint in joints}

    def free(wanted: str) -> str:
        while wanted in names:
            wanted += "_"
        names.add(wanted)
        return wanted

    def add_link(full: str, parent: str, model_t_parent: Matrix, model_t_node: Matrix, joint: dict[str, Any]) -> None:
        element, model_t_link = links[full]
        node_t_link = inverse(model_t_node) @ model_t_link
        link: dict[str, Any] = {"joint": joint}
        inertial = inertial_of(element, node_t_link)
        if inertial is not None:
            link["inertial"] = inertial
        nodes.append(
            {
                "name": f"{name}.{full}",
                "parent": parent,
                "parent_t_node": pose_message(inverse(model_t_parent) @ model_t_node),
                "figures": link_figures(element, node_t_link, main, notes),
                "link": link,
            }
        )
        placed[full] = f"{name}.{full}", model_t_node

    def connect(joint: JointSpec, here: str) -> str:
        """Add the link at the other end of a joint; a joint that is written the other way round turns the other way."""
        backwards = joint.child == here
        other = joint.parent if backwards else joint.child
        if other in placed:
            raise joint.place.error(
                joint.element,
                f"it closes a kinematic loop from {joint.parent!r} to {joint.child!r}; only trees are read",
            )
        parent, model_t_parent = placed[here]
        if not joint.axes:
            add_link(other, parent, model_t_parent, links[other][1], _fixed(joint.name))
            return other
        axes = list(reversed(joint.axes)) if backwards else list(joint.axes)
        for number, axis in enumerate(axes):
            moving = dict(axis, name=joint.name if number == 0 else free(f"{joint.name}_2"))
            if backwards:
                moving["axis"] = {key: -value for key, value in axis["axis"].items()}
            if number + 1 < len(axes):
                between = f"{name}.{free(f'{joint.name}_between')}"
                place = pose_message(inverse(model_t_parent) @ joint.model_t_joint)
                nodes.append({"name": between, "parent": parent, "parent_t_node": place, "link": {"joint": moving}})
                parent, model_t_parent = between, joint.model_t_joint
            else:
                add_link(other, parent, model_t_parent, joint.model_t_joint, moving)
        return other

    def grow(start: str) -> None:
        waiting = [(joint, start) for joint in reversed(at[start])]
        while waiting:
            joint, here = waiting.pop()
            if id(joint) in used:
                continue
            used.add(id(joint))
            reached = connect(joint, here)
            waiting += [(following, reached) for following in reversed(at[reached])]

    placed[WORLD] = name, np.eye(4)
    grow(WORLD)
    children = {joint.child for joint in joints}
    anchored = len(placed) > 1
    for full in [*(link for link in links if link not in children), *links]:
        if full in placed:
            continue
        if anchored:
            text = f"the link {full!r} hangs on no joint; here it is fixed to the robot"
            notes.warn(links[full][0].place, links[full][0].element, text)
        anchored = True
        add_link(full, name, np.eye(4), links[full][1], _fixed(free("base")))
        grow(full)
    return nodes + _robot_sensors(name, links, joints, placed, {node["name"] for node in nodes}, notes)


def _robot_sensors(
    name: str,
    links: Links,
    joints: list[JointSpec],
    placed: dict[str, tuple[str, Matrix]],
    taken: set[str],
    notes: Notes,
) -> list[dict[str, Any]]:
    """Return the sensors of a robot's links, then those of its joints, which are fixed to the child."""
    nodes = []
    for full, (link, model_t_link) in links.items():
        node, model_t_node = placed[full]
        place = link.place.inside(f"link {link.name!r}")
        nodes += sensor_nodes(link.element, place, name, node, inverse(model_t_node) @ model_t_link, taken, notes)
    for joint in joints:
        node, model_t_node = placed[joint.child]
        node_t_joint = inverse(model_t_node) @ joint.model_t_joint
        nodes += sensor_nodes(joint.element, joint.place, name, node, node_t_joint, taken, notes)
    return nodes


def _fixed(name: str) -> dict[str, Any]:
    return {"name": name, "type": "JOINT_TYPE_FIXED"}
