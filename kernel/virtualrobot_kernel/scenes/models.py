"""Models read as nodes. Reading takes from milliseconds to seconds and runs in a worker thread."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from virtualrobot.v1 import nodes_pb2, scene_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.dh import read_table
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.model_craft import with_craft
from virtualrobot_kernel.formats.models import ImportedModel, TranslatedScene, import_model
from virtualrobot_kernel.formats.xml import place_in, refuse_warnings
from virtualrobot_kernel.messages.dh import denavit_hartenberg, refuse_file_fields, row_inertials
from virtualrobot_kernel.messages.nodes import JOINT_TYPES, node_spec
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.values import pose, vector
from virtualrobot_kernel.scenes.assets import found_figures
from virtualrobot_kernel.world.commands import Command, MountTool
from virtualrobot_kernel.world.figures import Mesh
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    JointType,
    Kind,
    LinkData,
    NodeSpec,
    PartData,
    RobotData,
)


def read_model(
    meshes: MeshLibrary, request: scene_pb2.ModelSource, files: Files, taken: Iterable[str], referrer: str = ""
) -> ImportedModel:
    """Return the nodes of a model; names in `taken` are not used, and `referrer` is the file that asks for it."""
    if request.mount_on:
        free = scene_pb2.ModelSource()
        free.CopyFrom(request)
        for field in ("mount_on", "tool_center_point", "parent", "parent_t_node"):
            free.ClearField(field)
        model = read_model(meshes, free, files, taken, referrer)
        roots = [spec.name for spec in model.nodes if spec.parent == WORLD_NAME]
        if len(roots) > 1:
            raise KernelError(
                f"{request.uri} is several things ({', '.join(map(repr, roots))}), and one can be mounted on "
                f"{request.mount_on!r}; load it, and mount the one that is meant",
                field="mount_on",
            )
        return model
    if request.tool_center_point:
        raise KernelError("tool_center_point goes with mount_on: name the robot, too", field="tool_center_point")
    base_joint = JOINT_TYPES.read(request.base_joint, "base_joint")
    names = frozenset(taken)
    parent = request.parent or WORLD_NAME
    parent_t_node = pose(request.parent_t_node, "parent_t_node")
    if request.HasField("denavit_hartenberg"):
        refuse_file_fields(request)
        table, joints = denavit_hartenberg(request.denavit_hartenberg)
        name = request.name or _free("robot", names)
        nodes = read_table(
            table,
            joints,
            row_inertials(request.denavit_hartenberg),
            name=name,
            parent=parent,
            parent_t_node=parent_t_node,
            base_joint=base_joint,
        )
        return ImportedModel(nodes, 0)
    if not request.uri:
        raise KernelError("uri must name the model's main file, or denavit_hartenberg hold a table", field="uri")
    model = import_model(
        request.uri,
        files,
        meshes,
        name=request.name,
        parent=parent,
        parent_t_node=parent_t_node,
        base_joint=base_joint,
        as_part=request.as_part,
        scale=vector(request.scale, "scale") if request.HasField("scale") else (1.0, 1.0, 1.0),
        settings=settings(request.settings, "settings"),
        srdf_uri=request.srdf_uri,
        taken=names,
        referrer=referrer,
    )
    if not isinstance(model, ImportedModel):
        model = _scene_as_model(meshes, model, request, files, names)
    if request.strict:
        refuse_warnings(model.warnings)
    return model


def mounting(request: scene_pb2.ModelSource, model: ImportedModel) -> list[Command]:
    """Return the command that mounts a model on the robot that its request names; none where it names none."""
    if not request.mount_on:
        return []
    place = pose(request.parent_t_node, "parent_t_node") if request.HasField("parent_t_node") else None
    return [MountTool(request.mount_on, model.nodes[0].name, request.parent, place, request.tool_center_point)]


def spec_of(message: nodes_pb2.Node, place: str) -> NodeSpec:
    """Return the node that a message at `place` in a file describes; errors name the place."""
    try:
        return node_spec(message)
    except KernelError as error:
        raise error.at(place) from error


def _scene_as_model(
    meshes: MeshLibrary,
    model: TranslatedScene,
    request: scene_pb2.ModelSource,
    files: Files,
    taken: frozenset[str],
) -> ImportedModel:
    """Return the nodes of a scene that stands for a model file, below the request's parent, under free names.

    Of its `models` only Denavit-Hartenberg tables are read. A base joint that is asked for is that of each robot which
    stands in the scene's world.
    """
    scene = scene_file.parse(model.text, model.uri)
    specs = [spec_of(node, f"{model.uri}: nodes[{place}]") for place, node in enumerate(scene.nodes)]
    for table in scene.models:
        if table.HasField("denavit_hartenberg"):
            table.base_joint = request.base_joint or table.base_joint
            specs.extend(read_model(meshes, table, files, (), model.uri).nodes)
    if not specs:
        raise KernelError(f"{model.uri} holds no model", file=model.uri)
    base_joint = JOINT_TYPES.read(request.base_joint, "base_joint")
    if base_joint is not JointType.FIXED:
        specs = _on_base(specs, base_joint, model.uri)
    renamed = _free_names(specs, request.name, taken)
    nodes: list[NodeSpec] = []
    warnings = [*model.warnings]
    for spec in specs:
        if spec.parent == WORLD_NAME:
            place = pose(request.parent_t_node, "parent_t_node") @ spec.parent_t_node
            spec = replace(spec, parent=request.parent or WORLD_NAME, parent_t_node=place)
            if request.as_part and spec.kind is Kind.OBJECT:
                spec = replace(spec, kind=Kind.PART, data=PartData())
        else:
            spec = replace(spec, parent=renamed.get(spec.parent, spec.parent))
        data = spec.data
        if isinstance(data, RobotData):
            flange, payload = renamed.get(data.flange, data.flange), data.payload_kilograms or model.payload
            data = replace(data, source=model.uri, flange=flange, payload_kilograms=payload)
        figures = found_figures(meshes, spec.figures, files, model.uri, warnings)
        spec = replace(spec, name=renamed[spec.name], data=data, figures=figures)
        nodes.append(with_craft(spec, model.craft) if model.craft and spec.kind is Kind.ROBOT else spec)
    count = sum(isinstance(figure.geometry, Mesh) for node in nodes for figure in node.figures)
    return ImportedModel(tuple(nodes), count, tuple(warnings))


def _on_base(specs: Sequence[NodeSpec], base_joint: JointType, uri: str) -> list[NodeSpec]:
    """Return the nodes with the first link of each robot that stands in the world on a base joint of this type."""
    robots = {spec.name for spec in specs if spec.kind is Kind.ROBOT and spec.parent == WORLD_NAME}
    first = [spec.name for spec in specs if spec.parent in robots and spec.kind is Kind.LINK]
    if not robots or len(first) != len(robots):
        told = "it has no robot that stands by itself" if not robots else "a robot of it begins with several links"
        what = f"{place_in(uri, None)} takes no base joint ({base_joint.value[0]}): {told}"
        raise KernelError(what, file=uri, field="base_joint")
    result: list[NodeSpec] = []
    for spec in specs:
        if spec.name in first and isinstance(spec.data, LinkData):
            joint = spec.data.joint
            if joint.type not in (JointType.FIXED, base_joint):
                raise KernelError(
                    f"{place_in(uri, None)} takes no base joint ({base_joint.value[0]}): its first link {spec.name!r} "
                    f"moves by the joint {joint.name!r}",
                    file=uri,
                    field="base_joint",
                )
            spec = replace(spec, data=replace(spec.data, joint=replace(joint, type=base_joint, axis=(0.0, 0.0, 1.0))))
        result.append(spec)
    return result


def _free_names(specs: Iterable[NodeSpec], wanted: str, taken: frozenset[str]) -> dict[str, str]:
    """Return a free name for each node, by its own; what carries a parent's name before a dot keeps doing so.

    `wanted` is the name for the one node that hangs below the world; empty when there are several, or none was asked
    for. A name that was asked for is not changed, so that it is refused where it is taken.
    """
    parents = {spec.name: spec.parent for spec in specs}
    single = list(parents.values()).count(WORLD_NAME) == 1
    renamed: dict[str, str] = {}
    used = set(taken)
    for name, parent in parents.items():
        if wanted and single and parent == WORLD_NAME:
            renamed[name] = wanted
            used.add(wanted)
            continue
        while parent in renamed and not name.startswith(f"{parent}."):
            parent = parents[parent]
        own = f"{renamed[parent]}{name.removeprefix(parent)}" if parent in renamed else name
        renamed[name] = _free(own, used)
        used.add(renamed[name])
    return renamed


def _free(name: str, taken: Iterable[str]) -> str:
    """Return `name`, with a number behind it while it is taken."""
    number, chosen = 2, name
    while chosen in taken:
        chosen, number = f"{name}_{number}", number + 1
    return chosen
