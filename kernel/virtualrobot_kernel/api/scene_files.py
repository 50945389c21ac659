"""Scene files: between their text and commands. Everything here may take long and runs in worker threads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from virtualrobot.v1 import robot_pb2, scene_pb2

from virtualrobot_kernel.api.convert.states import robot_states, robots_named, signal_message
from virtualrobot_kernel.api.model_files import files_of, found_figures, read_model, spec_of
from virtualrobot_kernel.collision.node_pairs import names_of
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.bundle import bundle
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.messages.collision_settings import settings_command, settings_message
from virtualrobot_kernel.messages.nodes import node_message
from virtualrobot_kernel.messages.values import finite, masked
from virtualrobot_kernel.world.collisions import NOTHING_SET
from virtualrobot_kernel.world.commands import (
    ClearWorld,
    Command,
    CreateNodes,
    CreateSignal,
    SelectTool,
    SetAllowedPairs,
    SetJointPositions,
    SetSpeedFactor,
    SetToolState,
    UpdateNode,
)
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.state import Signal, Snapshot
from virtualrobot_kernel.world.structure import WORLD_NAME, WORLD_UID, Kind, Node, NodeSpec, Structure

SAVED_STATE = frozenset({"name", "positions", "tool", "tool_center_point", "tool_states", "speed_factor"})
"""What a scene file keeps of a robot's state."""


def read_scene(
    meshes: MeshLibrary, request: scene_pb2.LoadSceneRequest, structure: Structure
) -> tuple[list[Command], list[str]]:
    """Return the commands that make the world of a scene file, and what was odd about its models."""
    uri = request.uri or "scene.yaml"
    scene = scene_file.parse(request.text, uri)
    files = files_of(meshes, request.files, request.packages)
    taken = dict(structure.uid_by_name) if request.add else {WORLD_NAME: 1}
    specs = [spec_of(node, f"{uri}: nodes[{place}]") for place, node in enumerate(scene.nodes)]
    # Tools and sensors of a scene file hang on links that come with its models: they wait for them.
    first, mounted = _split(specs, taken) if scene.models else (specs, [])
    commands: list[Command] = [] if request.add else [ClearWorld()]
    commands.extend(with_assets(meshes, [CreateNodes(tuple(first))], files, request.uri) if first else [])
    names = {*taken, *(spec.name for spec in specs)}
    warnings: list[str] = []
    for place, wanted in enumerate(scene.models):
        try:
            model = read_model(meshes, wanted, files, names, request.uri)
        except KernelError as error:
            # What comes from a file names that itself.
            if wanted.HasField("denavit_hartenberg"):
                error.at(f"{uri}: models[{place}]")
            raise
        names.update(node.name for node in model.nodes)
        warnings.extend(model.warnings)
        commands.append(CreateNodes(model.nodes))
    for place, spec in enumerate(specs):
        if spec.parent not in names:
            raise UnknownNameError(f"parent for {spec.name!r}", spec.parent, names).at(f"{uri}: nodes[{place}]")
    commands.extend(with_assets(meshes, [CreateNodes(tuple(mounted))], files, request.uri) if mounted else [])
    for signal in scene.signals:
        commands.append(CreateSignal(Signal(signal.name, signal.value, signal.description)))
    for robot in scene.robot_states:
        commands.extend(_state_commands(robot))
    if scene.allowed_pairs:
        commands.append(SetAllowedPairs(tuple((pair.first, pair.second, pair.reason) for pair in scene.allowed_pairs)))
    if scene.HasField("collision_settings"):
        commands.append(settings_command(scene.collision_settings))
    if scene.HasField("speed_factor"):
        commands.append(SetSpeedFactor("", finite(scene.speed_factor, "speed_factor")))
    return commands, warnings


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
    for pair, why in snapshot.state.allowed_pairs.items():
        first, second = names_of(pair, structure)
        scene.allowed_pairs.add(first=first, second=second, reason=why)
    if snapshot.state.collisions != NOTHING_SET:
        scene.collision_settings.CopyFrom(settings_message(snapshot))
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
    found = partial(found_figures, meshes, files=files or files_of(meshes, (), {}), referrer=referrer)
    result: list[Command] = []
    for command in commands:
        if isinstance(command, CreateNodes):
            result.append(CreateNodes(tuple(replace(spec, figures=found(spec.figures)) for spec in command.specs)))
        elif isinstance(command, UpdateNode) and command.figures is not None:
            result.append(replace(command, figures=found(command.figures)))
        else:
            result.append(command)
    return result


def _state_commands(robot: robot_pb2.RobotState) -> list[Command]:
    commands: list[Command] = [SetToolState(tool, state) for tool, state in robot.tool_states.items() if state]
    if robot.HasField("tool"):
        commands.append(SelectTool(robot.name, robot.tool, robot.tool_center_point))
    if robot.positions:
        commands.append(SetJointPositions(robot.name, coordinates=np.array(robot.positions)))
    if robot.speed_factor:
        commands.append(SetSpeedFactor(robot.name, finite(robot.speed_factor, "speed_factor")))
    return commands
