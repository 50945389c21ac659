"""World written as a scene file. Writing takes from milliseconds to seconds and runs in a worker thread."""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot.v1 import robot_pb2, scene_pb2

from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.bundle import bundle
from virtualrobot_kernel.messages.collision_settings import settings_message
from virtualrobot_kernel.messages.nodes import node_message
from virtualrobot_kernel.messages.physics import PHYSICS
from virtualrobot_kernel.messages.signals import signal_message
from virtualrobot_kernel.world.collisions import NOTHING_SET
from virtualrobot_kernel.world.figures import Mesh, meshes_of
from virtualrobot_kernel.world.state import NO_PHYSICS, Selection, Snapshot
from virtualrobot_kernel.world.structure import WORLD_NAME, WORLD_UID, Kind, Node, Structure


def write_scene(snapshot: Snapshot, bundled: bool) -> tuple[str, list[tuple[str, str]]]:
    """Return the world as a scene file's text, and for a bundle the files beside it as (relative path, SHA-256).

    All that names nodes is in the order of the nodes, so that a world that was loaded gives the same file again.
    """
    structure = snapshot.structure
    nodes = list(_in_order(structure))
    places = {node.uid: place for place, node in enumerate(nodes)}
    by_name = {node.name: places[node.uid] for node in nodes}
    uris, files = bundle(meshes_of(structure.figures)) if bundled else ({}, [])
    scene = scene_pb2.SceneFile(schema_version=scene_file.SCHEMA_VERSION)
    for node in nodes:
        if node.kind is Kind.WORLD:
            continue
        message = scene.nodes.add()
        message.CopyFrom(node_message(snapshot, node))
        message.ClearField("uid")
        for figure, written in zip(node.figures, message.figures, strict=True):
            if isinstance(figure.geometry, Mesh) and figure.geometry in uris:
                written.mesh.uri = uris[figure.geometry]
                written.mesh.ClearField("sha256")
                written.mesh.ClearField("files")
        if node.kind is Kind.ROBOT:
            message.robot.ClearField("joint_names")
        if message.parent == WORLD_NAME:
            message.ClearField("parent")
    scene.signals.extend(signal_message(snapshot.structure, signal) for signal in snapshot.state.signals.values())
    scene.robot_states.extend(
        _robot_state(snapshot, structure.nodes[uid]) for uid in sorted(structure.robots, key=places.__getitem__)
    )
    if snapshot.state.speed_factor != 1.0:
        scene.speed_factor = snapshot.state.speed_factor
    allowed = snapshot.state.allowed_pairs
    pairs = [(one.built, *sorted(map(places.__getitem__, pair)), one.reason) for pair, one in allowed.items()]
    for built, first, second, reason in sorted(pairs):
        scene.allowed_pairs.add(first=nodes[first].name, second=nodes[second].name, reason=reason, built=built)
    if snapshot.state.collisions != NOTHING_SET:
        scene.collision_settings.CopyFrom(settings_message(snapshot))
        scene.collision_settings.robots.sort(key=lambda one: by_name[one.robot])
        scene.collision_settings.paddings.sort(key=lambda one: by_name[one.node])
    if snapshot.state.physics_settings != NO_PHYSICS:
        scene.physics.CopyFrom(PHYSICS.write(snapshot.state.physics_settings))
    return scene_file.format(scene), files


def _in_order(structure: Structure) -> Iterator[Node]:
    """Yield all nodes, parents first; a robot's links in the order of creation, which is that of its positions.

    At a link other links come first, even where something else that hangs there was made before them: whoever reads the
    file makes a robot's links at once, before that.
    """
    stack = [WORLD_UID]
    while stack:
        node = structure.nodes[stack.pop()]
        if node.kind is not Kind.LINK:
            yield node
        if node.kind is Kind.ROBOT:
            yield from (structure.nodes[uid] for uid in structure.robots[node.uid].links)
        children = structure.children.get(node.uid, ())
        stack += sorted(reversed(children), key=lambda uid: structure.nodes[uid].kind is Kind.LINK)


def _robot_state(snapshot: Snapshot, robot: Node) -> robot_pb2.RobotState:
    """Return the part of a robot's state that a scene file keeps; without tools there is none to choose."""
    structure, state = snapshot.structure, snapshot.state
    selection = state.selections.get(robot.uid, Selection())
    tools = structure.tools_of(robot.uid)
    chosen = structure.nodes[selection.tool].name if selection.tool else ""
    return robot_pb2.RobotState(
        name=robot.name,
        positions=state.q[structure.robots[robot.uid].q_slice].tolist(),
        tool=chosen if tools else None,
        tool_center_point=selection.tool_center_point,
        tool_states={tool.name: state.tool_states.get(tool.uid, "") for tool in structure.own_tools_of(robot.uid)},
        speed_factor=state.speed_factors.get(robot.uid, 1.0),
        tcp_speed_limit=state.tcp_speed_limits.get(robot.uid, 0.0),
    )
