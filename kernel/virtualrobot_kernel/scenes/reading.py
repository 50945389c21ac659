"""Scene files read as commands. Reading takes from milliseconds to seconds and runs in a worker thread."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

import numpy as np
from virtualrobot.v1 import robot_pb2

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.xml import FileWarning
from virtualrobot_kernel.formats.yaml_text import Check
from virtualrobot_kernel.messages.collision_settings import allowing, settings_command
from virtualrobot_kernel.messages.physics import restored_physics
from virtualrobot_kernel.messages.signals import created_signal
from virtualrobot_kernel.messages.values import finite
from virtualrobot_kernel.scenes.assets import with_assets
from virtualrobot_kernel.scenes.models import mounting, read_model, spec_of
from virtualrobot_kernel.world.commands import (
    ClearWorld,
    Command,
    CreateNodes,
    SelectTool,
    SetJointPositions,
    SetSpeedFactor,
    SetTcpSpeedLimit,
    SetToolState,
)
from virtualrobot_kernel.world.structure import WORLD_NAME, NodeSpec, TargetData


class ReadScene(NamedTuple):
    """Scene file as commands, with what is odd about it, and the names of the nodes that come of its `models`."""

    commands: list[Command]
    warnings: list[FileWarning]
    of_models: Collection[str]


def read_scene(
    text: str,
    uri: str,
    files: Files,
    meshes: MeshLibrary,
    known: Iterable[str] | None = None,
    check: Check = lambda: None,
) -> ReadScene:
    """Return the commands that make the world of a scene file, and what is odd about it and what it names.

    Args:
        text: of the file.
        uri: its name, from which relative names in it count; empty for a text that lies nowhere.
        files: where the files come from that it names.
        meshes: keeps the parsed meshes and has the importers.
        known: the names of the world that it is added to; None where it replaces the world.
        check: called again and again while the text is read; what it raises ends that.

    Raises:
        KernelError: for what is wrong in the file, with file and line or place; MISSING_FILE for what it names.
    """
    referrer, uri = uri, uri or "scene.yaml"
    scene = scene_file.parse(text, uri, check)
    taken = {WORLD_NAME} if known is None else set(known)
    specs = [spec_of(node, f"{uri}: nodes[{place}]") for place, node in enumerate(scene.nodes)]
    # Tools and sensors of a scene file hang on links that come with its models: they wait for them.
    first, mounted = _split(specs, taken) if scene.models else (specs, [])
    commands: list[Command] = [ClearWorld()] if known is None else []
    warnings: list[FileWarning] = []
    commands.extend(with_assets(meshes, [CreateNodes(tuple(first))], files, referrer, warnings) if first else [])
    names = {*taken, *(spec.name for spec in specs)}
    of_models: set[str] = set()
    mounts: list[Command] = []
    for place, wanted in enumerate(scene.models):
        try:
            model = read_model(meshes, wanted, files, names, referrer)
        except KernelError as error:
            # What comes from a file names that itself.
            if wanted.HasField("denavit_hartenberg"):
                error.at(f"{uri}: models[{place}]")
            raise
        of_models.update(node.name for node in model.nodes)
        names |= of_models
        warnings.extend(model.warnings)
        commands.append(CreateNodes(model.nodes))
        mounts.extend(mounting(wanted, model))
    for place, spec in enumerate(specs):
        if spec.parent not in names:
            raise UnknownNameError(f"parent for {spec.name!r}", spec.parent, names).at(f"{uri}: nodes[{place}]")
    commands.extend(with_assets(meshes, [CreateNodes(tuple(mounted))], files, referrer, warnings) if mounted else [])
    commands.extend(mounts)
    commands.extend(created_signal(signal) for signal in scene.signals)
    for robot in scene.robot_states:
        commands.extend(_state_commands(robot))
    if scene.allowed_pairs:
        commands.append(allowing(scene.allowed_pairs))
    if scene.HasField("collision_settings"):
        commands.append(settings_command(scene.collision_settings))
    if scene.HasField("physics"):
        commands.append(restored_physics(scene.physics))
    if scene.HasField("speed_factor"):
        commands.append(SetSpeedFactor("", finite(scene.speed_factor, "speed_factor")))
    return ReadScene(commands, warnings, of_models)


def _split(specs: Iterable[NodeSpec], taken: Iterable[str]) -> tuple[list[NodeSpec], list[NodeSpec]]:
    """Return the nodes that hang on nodes named before them, and those that hang on something else, or name it."""
    known = set(taken)
    first: list[NodeSpec] = []
    rest: list[NodeSpec] = []
    for spec in specs:
        needed = {spec.parent}
        if isinstance(spec.data, TargetData):
            needed.update(name for name in (spec.data.robot, spec.data.tool) if name)
        if needed <= known:
            known.add(spec.name)
            first.append(spec)
        else:
            rest.append(spec)
    return first, rest


def _state_commands(robot: robot_pb2.RobotState) -> list[Command]:
    commands: list[Command] = [SetToolState(tool, state) for tool, state in robot.tool_states.items() if state]
    if robot.HasField("tool"):
        commands.append(SelectTool(robot.name, robot.tool, robot.tool_center_point))
    if robot.positions:
        commands.append(SetJointPositions(robot.name, coordinates=np.array(robot.positions)))
    if robot.speed_factor:
        commands.append(SetSpeedFactor(robot.name, finite(robot.speed_factor, "speed_factor")))
    if robot.tcp_speed_limit:
        commands.append(SetTcpSpeedLimit(robot.name, finite(robot.tcp_speed_limit, "tcp_speed_limit")))
    return commands
