"""Model files read into nodes, whatever their format: the ending tells which."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, replace

import numpy as np
from virtualrobot_sdk.models import ModelCraft, ModelTool

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats import model_table
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import UNSCALED, MeshLibrary, Scale
from virtualrobot_kernel.formats.meshes import MESH_FORMATS
from virtualrobot_kernel.formats.model_craft import as_craft
from virtualrobot_kernel.formats.references import ending, needs_xacro
from virtualrobot_kernel.formats.srdf import read_srdf, with_allowed, with_semantics
from virtualrobot_kernel.formats.translate import Settings, Translated, translate
from virtualrobot_kernel.formats.urdf import BASE_JOINTS, read_urdf
from virtualrobot_kernel.formats.xml import FileWarning, malformed, place_in
from virtualrobot_kernel.world.figures import Figure, Mesh, Pose, identity
from virtualrobot_kernel.world.structure import (
    WORLD_NAME,
    JointType,
    Kind,
    LinkPair,
    NodeSpec,
    PartData,
    RobotData,
    ToolData,
    ToolWidth,
)

MODEL_FORMATS = (".urdf", *MESH_FORMATS)
"""Endings of the files that `import_model` reads without an importer."""


@dataclass(frozen=True, slots=True, eq=False)
class ImportedModel:
    """Nodes of a model file, the robot, object or part first, parents before children."""

    nodes: tuple[NodeSpec, ...]
    mesh_count: int
    warnings: tuple[FileWarning, ...] = ()


@dataclass(frozen=True, slots=True)
class TranslatedScene:
    """Model file that was translated to a scene, or is one: several robots and objects.

    Attributes:
        text: the scene, as a scene file has it.
        uri: the original file, from which names in the text count.
        warnings: what was odd.
        craft: what its robot is, as a table of models tells; None where it tells nothing.
        payload: the greatest load at its robot's flange (kg), as that tells; 0 where it tells nothing.
    """

    text: str
    uri: str
    warnings: tuple[FileWarning, ...] = ()
    craft: ModelCraft | None = None
    payload: float = 0.0


def import_model(
    uri: str,
    files: Files,
    library: MeshLibrary,
    *,
    name: str = "",
    parent: str = WORLD_NAME,
    parent_t_node: Pose | None = None,
    base_joint: JointType = JointType.FIXED,
    as_part: bool = False,
    scale: Scale = UNSCALED,
    taken: Container[str] = (),
    referrer: str = "",
    settings: Settings | None = None,
    srdf_uri: str = "",
) -> ImportedModel | TranslatedScene:
    """Return the nodes of a model file; every mesh is parsed once, so that a broken one is refused here.

    What the kernel does not read itself is translated by the importer for its ending; where that makes a scene of it,
    the scene is returned, as it is for a known model that is one. Takes from milliseconds to seconds: keep it off the
    world thread.

    Args:
        uri: the main file: a path on the kernel's disk, `package://`, a name among the uploaded files, or `model://NAME`
            for a model that a plugin knows.
        files: where the model's files come from.
        library: keeps the parsed meshes and has the importers.
        name: of the robot, object or part; empty means the file's own (or that of the known model), with a number
            behind it when that is `taken`.
        parent: the node that it is fixed to.
        parent_t_node: where it goes, in the parent's frame.
        base_joint: for robots: how the root link hangs below the robot: FIXED, FLOATING or PLANAR.
        as_part: for meshes: a part instead of an object.
        scale: for meshes: factors for x, y, z; negative ones mirror.
        taken: names that nodes of the world have.
        referrer: the file that names this one, such as a scene file.
        settings: the importer's, plain values.
        srdf_uri: for robots: an SRDF file with groups, postures and pairs of links that may touch.

    Raises:
        MalformedFileError: for an unknown format or a broken file, with file, line and element where known.
        MissingFileError: for a file that is nowhere, with each place that was tried.
        UnknownNameError: for a `model://NAME` that no plugin knows.
        KernelError: INVALID_ARGUMENT for another base joint, an impossible scale, settings or an SRDF file for what has
            none; TOO_LARGE, UNKNOWN_ASSET; PLUGIN_FAILED for an importer's fault.
    """
    if base_joint not in BASE_JOINTS:
        valid = ", ".join(joint_type.value[0] for joint_type in BASE_JOINTS)
        raise _bad_argument(f"the base joint cannot be {base_joint.value[0]}; valid: {valid}", valid=valid)
    if 0.0 in scale:
        raise _bad_argument(f"the scale {scale} has a factor of 0", scale=scale)
    known, touching, tool, craft, payload = model_table.named_by(uri), (), None, None, 0.0
    if known and uri not in files.uploaded:
        model = model_table.find(library.importers.models, known)
        if model.scene:
            _refuse_mesh_fields(uri, as_part, scale)
            _refuse_srdf(uri, srdf_uri)
            return TranslatedScene(model.scene, uri, payload=float(model.payload_kilograms))
        uri, srdf_uri, touching, tool = model.uri, srdf_uri or model.srdf, model.touching, model.tool
        settings = {**model.settings, **(settings or {})}
        craft = model.craft if base_joint is not JointType.FIXED else None
        payload = float(model.payload_kilograms)
    kind = ending(uri)
    if known and kind == ".yaml":
        _refuse_mesh_fields(uri, as_part, scale)
        _refuse_srdf(uri, srdf_uri)
        file = files.read(uri)
        return TranslatedScene(file.data.decode(), file.key, craft=craft, payload=payload)
    formats = tuple(dict.fromkeys((*MODEL_FORMATS, *library.importers.endings)))
    if kind not in formats:
        right = "" if kind else model_table.hint(library.importers.models, uri)
        raise malformed(uri, None, f"no model format has the ending {kind!r}; {right}known: {', '.join(formats)}")

    def choose_name(own: str) -> str:
        if name:
            return name
        stem = known or own or uri.replace("\\", "/").rpartition("/")[2].rpartition(".")[0] or "model"
        number, chosen = 2, stem
        while chosen in taken:
            chosen, number = f"{stem}_{number}", number + 1
        return chosen

    warnings: list[FileWarning] = []
    found: dict[tuple[str, str], tuple[Mesh, tuple[FileWarning, ...]]] = {}

    def load(mesh_uri: str, named_by: str, mesh_scale: Scale, look: bool = True) -> Mesh:
        if (mesh_uri, named_by) not in found:
            found[mesh_uri, named_by] = library.find(files, mesh_uri, named_by)
        unscaled, odd = found[mesh_uri, named_by]
        mesh = replace(unscaled, scale=mesh_scale)
        library.load(mesh)
        # What is missing costs the look only, and nobody sees that of a collision mesh, or of one in the URDF's colour.
        warnings.extend(text for text in odd if look and text not in warnings)
        return mesh

    translated = _translated(library, files, uri, referrer, settings or {})
    if settings and translated is None:
        raise _bad_argument(f"settings are an importer's, and {kind} is read without one", settings=settings)
    result = translated.format if translated else kind
    if translated and result == ".yaml":
        if srdf_uri or base_joint is not JointType.FIXED or scale != UNSCALED:
            what = f"the SRDF file {srdf_uri!r}" if srdf_uri else "a scale" if scale != UNSCALED else "a base joint"
            raise _bad_argument(f"{place_in(uri, None)} becomes a scene of its own, so {what} is not for it", file=uri)
        return TranslatedScene(translated.data.decode(), translated.file.key, translated.warnings)
    pose = identity() if parent_t_node is None else parent_t_node
    if result == ".urdf":
        _refuse_mesh_fields(uri, as_part, scale)
        file = translated.as_file() if translated else files.read(uri, referrer)
        try:
            model = read_urdf(file, load, choose_name, base_joint)
        except KernelError as error:
            if translated is not None:
                error.args = (f"{error} (the line is that of the URDF that {place_in(uri, None)} was translated to)",)
            raise
        robot = replace(model.nodes[0], parent=parent, parent_t_node=pose)
        if srdf_uri:
            semantics = read_srdf(files.read(srdf_uri, referrer), model.nodes, model.own_name)
            robot = with_semantics(robot, semantics)
            warnings.extend(semantics.warnings)
        warnings[:0] = translated.warnings if translated else ()
        robot = with_payload(with_allowed(robot, (LinkPair(*pair) for pair in touching)), payload)
        own = (robot, *model.nodes[1:])
        nodes = (*(as_craft(own, craft) if craft else own), *([tool_of(tool, robot.name)] if tool else []))
        return ImportedModel(nodes, model.mesh_count, (*warnings, *model.warnings))
    if srdf_uri:
        raise _bad_argument(f"{uri} is no robot: the SRDF file {srdf_uri!r} has nothing to describe", file=srdf_uri)
    if translated is None:
        mesh = load(uri, referrer, scale)
    else:
        mesh = library.adopt(translated, scale)
        library.load(mesh)
        warnings.extend(translated.warnings)
    node = NodeSpec(
        choose_name(""),
        Kind.PART if as_part else Kind.OBJECT,
        parent,
        pose,
        figures=(Figure(mesh),),
        data=PartData() if as_part else None,
    )
    return ImportedModel((node,), 1, tuple(warnings))


def with_payload(robot: NodeSpec, kilograms: float) -> NodeSpec:
    """Return a robot with the greatest load at its flange."""
    data = robot.data if isinstance(robot.data, RobotData) else RobotData()
    return replace(robot, data=replace(data, payload_kilograms=kilograms))


def tool_of(tool: ModelTool, robot: str) -> NodeSpec:
    """Return the node of a tool that a table of models tells of a robot."""
    place = np.eye(4)
    place[:3, 3] = tool.tool_center_point
    data = ToolData({"tcp": place}, tool.states, widths=tuple(ToolWidth(*one) for one in tool.widths))
    return NodeSpec(f"{robot}.tool", Kind.TOOL, f"{robot}.{tool.link}", data=data)


def _translated(library: MeshLibrary, files: Files, uri: str, referrer: str, settings: Settings) -> Translated | None:
    """Return the translation of a file, None where the kernel reads it as it is."""
    kind, importers = ending(uri), library.importers
    if kind in MESH_FORMATS:
        return None
    if kind == ".urdf":
        file = files.read(uri, referrer)
        if ".urdf" not in importers.endings or not needs_xacro(file.data, file.key):
            return None
        return translate(importers, file, files, settings)
    return translate(importers, files.read(uri, referrer), files, settings)


def _refuse_mesh_fields(uri: str, as_part: bool, scale: Scale) -> None:
    """Raise where a robot's file comes with what only meshes take: nothing that is asked for is passed over."""
    if as_part or scale != UNSCALED:
        what = f"the scale {', '.join(f'{factor:g}' for factor in scale)}" if scale != UNSCALED else "as_part"
        raise _bad_argument(f"{place_in(uri, None)} is a robot's, and {what} is for meshes", file=uri)


def _refuse_srdf(uri: str, srdf_uri: str) -> None:
    """Raise where an SRDF file comes with a robot that is a scene."""
    if srdf_uri:
        told = f"{place_in(uri, None)} is a scene with postures of its own: the SRDF file {srdf_uri!r} is not for it"
        raise _bad_argument(told, file=srdf_uri)


def _bad_argument(message: str, **metadata: object) -> KernelError:
    return KernelError(message, reason=Reason.INVALID_ARGUMENT, **metadata)
