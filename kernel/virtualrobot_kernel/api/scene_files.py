"""Models and scene files: between files and commands. Everything here may take long and runs in worker threads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from virtualrobot.resolver import Resolver
from virtualrobot.v1 import nodes_pb2, robot_pb2, scene_pb2

from virtualrobot_kernel.api.convert.dh import denavit_hartenberg, refuse_file_fields
from virtualrobot_kernel.api.convert.nodes import JOINT_TYPES, node_message, node_spec
from virtualrobot_kernel.api.convert.states import robot_states, robots_named, signal_message
from virtualrobot_kernel.api.convert.values import finite, masked, pose, vector
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.bundle import bundle
from virtualrobot_kernel.formats.dh import read_table
from virtualrobot_kernel.formats.files import Files, located
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.world.commands import (
    ClearWorld,
    Command,
    CreateNodes,
    CreateSignal,
    SelectTool,
    SetJointPositions,
    SetSpeedFactor,
    SetToolState,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Figure, Mesh
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.structure import WORLD_NAME, WORLD_UID, JointType, Kind, Node, NodeSpec, Structure

SAVED_STATE = frozenset({"name", "positions", "tool", "tool_center_point", "tool_states", "speed_factor"})
"""What a scene file keeps of a robot's state."""


def files_of(meshes: MeshLibrary, files: Iterable[nodes_pb2.AssetFile], packages: Mapping[str, str]) -> Files:
    """Return where a request's files come from: what was uploaded, then the kernel's disk."""
    folders = {name: Path(folder) for name, folder in packages.items()}
    return Files(meshes.store, {file.uri: file.sha256 for file in files}, Resolver(folders))


def read_model(meshes: MeshLibrary, request: scene_pb2.ImportModelRequest, structure: Structure) -> ImportedModel:
    """Return the nodes of a model file."""
    return _model(meshes, request, files_of(meshes, request.files, request.packages), structure.uid_by_name, "")


def read_scene(
    meshes: MeshLibrary, request: scene_pb2.LoadSceneRequest, structure: Structure
) -> tuple[list[Command], list[str]]:
    """Return the commands that make the world of a scene file, and what was odd about its models."""
    uri = request.uri or "scene.yaml"
    scene = scene_file.parse(request.text, uri)
    files = files_of(meshes, request.files, request.packages)
    taken = dict(structure.uid_by_name) if request.add else {WORLD_NAME: 1}
    specs = [_spec(node, f"{uri}: nodes[{place}]") for place, node in enumerate(scene.nodes)]
    # Tools and sensors of a scene file hang on links that come with its models: they wait for them.
    first, mounted = _split(specs, taken) if scene.models else (specs, [])
    commands: list[Command] = [] if request.add else [ClearWorld()]
    commands.extend(with_assets(meshes, [CreateNodes(tuple(first))], files, request.uri) if first else [])
    names = {*taken, *(spec.name for spec in specs)}
    warnings: list[str] = []
    for wanted in scene.models:
        model = _model(meshes, wanted, files, names, request.uri)
        names.update(node.name for node in model.nodes)
        warnings.extend(model.warnings)
        commands.append(CreateNodes(model.nodes))
    for place, spec in enumerate(specs):
        if spec.parent not in names:
            raise located(UnknownNameError(f"parent for {spec.name!r}", spec.parent, names), f"{uri}: nodes[{place}]")
    commands.extend(with_assets(meshes, [CreateNodes(tuple(mounted))], files, request.uri) if mounted else [])
    for signal in scene.signals:
        commands.append(CreateSignal(Signal(signal.name, signal.value, signal.description)))
    for robot in scene.robot_states:
        commands.extend(_state_commands(robot))
    if scene.HasField("speed_factor"):
        commands.append(SetSpeedFactor("", finite(scene.speed_factor, "speed_factor")))
    return commands, warnings


def _spec(message: nodes_pb2.Node, place: str) -> NodeSpec:
    try:
        return node_spec(message)
    except KernelError as error:
        raise located(error, place) from error


def _split(specs: Iterable[NodeSpec], taken: Iterable[str]) -> tuple[list[NodeSpec], list[NodeSpec]]:
    """Return the nodes that hang on nodes named before them, and those that hang on something else."""
    known = set(taken)
    first: list[NodeSpec] = []
    rest: list[NodeSpec] = []
    for spec in specs:
        if spec.parent in known:
            known.add(spec.name)
            first.append(spec)
        else:
            rest.append(spec)
    return first, rest


def write_scene(snapshot: Snapshot, bundled: bool) -> tuple[str, list[tuple[str, str]]]:
    """Return the world as a scene file's text, and for a bundle the files beside it as (relative path, SHA-256)."""
    structure = snapshot.structure
    uris, files = bundle(_meshes(structure)) if bundled else ({}, [])
    scene = scene_pb2.SceneFile(schema_version=scene_file.SCHEMA_VERSION)
    for node in _in_order(structure):
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
    scene.signals.extend(signal_message(signal) for signal in snapshot.state.signals.values())
    for state in robot_states(snapshot, robots_named(snapshot, ())):
        if not state.tool_states:  # no tool to choose
            state.ClearField("tool")
        scene.robot_states.append(masked(state, SAVED_STATE))
    if snapshot.state.speed_factor != 1.0:
        scene.speed_factor = snapshot.state.speed_factor
    return scene_file.format(scene), files


def _in_order(structure: Structure) -> Iterator[Node]:
    """Yield all nodes, parents first; a robot's links in the order of creation, which is that of its positions."""
    stack = [WORLD_UID]
    while stack:
        node = structure.nodes[stack.pop()]
        if node.kind is not Kind.LINK:
            yield node
        if node.kind is Kind.ROBOT:
            yield from (structure.nodes[uid] for uid in structure.robots[node.uid].links)
        stack.extend(reversed(structure.children.get(node.uid, ())))


def _meshes(structure: Structure) -> list[Mesh]:
    figures = (figure for node in structure.nodes.values() for figure in node.figures)
    return [figure.geometry for figure in figures if isinstance(figure.geometry, Mesh)]


def with_assets(
    meshes: MeshLibrary, commands: Sequence[Command], files: Files | None = None, referrer: str = ""
) -> list[Command]:
    """Return the commands with every mesh found, parsed once and named by its content."""
    sources = files or files_of(meshes, (), {})

    def found(figures: tuple[Figure, ...]) -> tuple[Figure, ...]:
        return tuple(_found(meshes, figure, sources, referrer) for figure in figures)

    result: list[Command] = []
    for command in commands:
        if isinstance(command, CreateNodes):
            result.append(CreateNodes(tuple(replace(spec, figures=found(spec.figures)) for spec in command.specs)))
        elif isinstance(command, UpdateNode) and command.figures is not None:
            result.append(replace(command, figures=found(command.figures)))
        else:
            result.append(command)
    return result


def _found(meshes: MeshLibrary, figure: Figure, files: Files, referrer: str) -> Figure:
    mesh = figure.geometry
    if not isinstance(mesh, Mesh):
        return figure
    held = mesh.sha256 and meshes.store.has(mesh.sha256) and all(meshes.store.has(sha) for _, sha in mesh.files)
    if not held:
        mesh, _ = meshes.find(files, mesh.uri, referrer, mesh.scale, mesh.sha256)
    meshes.load(mesh)
    return replace(figure, geometry=mesh)


def _model(
    meshes: MeshLibrary, request: scene_pb2.ImportModelRequest, files: Files, taken: Iterable[str], referrer: str
) -> ImportedModel:
    base_joint = JOINT_TYPES.get(request.base_joint)
    if base_joint is None:
        raise KernelError(f"base_joint {request.base_joint} is not a JointType", field="base_joint")
    if request.HasField("denavit_hartenberg"):
        return _arm(request, base_joint, taken, referrer)
    if not request.uri:
        raise KernelError("uri must name the model's main file, or denavit_hartenberg hold a table", field="uri")
    return import_model(
        request.uri,
        files,
        meshes,
        name=request.name,
        parent=request.parent or WORLD_NAME,
        parent_t_node=pose(request.parent_t_node, "parent_t_node"),
        base_joint=base_joint,
        as_part=request.as_part,
        scale=vector(request.scale, "scale") if request.HasField("scale") else (1.0, 1.0, 1.0),
        taken=frozenset(taken),
        referrer=referrer,
    )


def _arm(
    request: scene_pb2.ImportModelRequest, base_joint: JointType, taken: Iterable[str], referrer: str
) -> ImportedModel:
    """Return the nodes of a Denavit-Hartenberg table."""
    names, name, number = set(taken), request.name or "arm", 2
    while not request.name and name in names:
        name, number = f"arm_{number}", number + 1
    try:
        refuse_file_fields(request)
        table, joints = denavit_hartenberg(request.denavit_hartenberg)
        parent_t_node = pose(request.parent_t_node, "parent_t_node")
    except KernelError as error:
        if referrer:
            located(error, f"{referrer}: the model {name!r}")
        raise
    parent = request.parent or WORLD_NAME
    nodes = read_table(table, joints, name=name, parent=parent, parent_t_node=parent_t_node, base_joint=base_joint)
    return ImportedModel(nodes, 0)


def _state_commands(robot: robot_pb2.RobotState) -> list[Command]:
    commands: list[Command] = [SetToolState(tool, state) for tool, state in robot.tool_states.items() if state]
    if robot.HasField("tool"):
        commands.append(SelectTool(robot.name, robot.tool, robot.tool_center_point))
    if robot.positions:
        commands.append(SetJointPositions(robot.name, coordinates=np.array(robot.positions)))
    if robot.speed_factor:
        commands.append(SetSpeedFactor(robot.name, finite(robot.speed_factor, "speed_factor")))
    return commands
