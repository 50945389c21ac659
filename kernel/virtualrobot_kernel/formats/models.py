"""Model files read into nodes, whatever their format: the ending tells which."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, replace

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary, Scale, find_mesh
from virtualrobot_kernel.formats.meshes import MESH_FORMATS
from virtualrobot_kernel.formats.references import ending
from virtualrobot_kernel.formats.urdf import BASE_JOINTS, read_urdf
from virtualrobot_kernel.formats.xml import malformed
from virtualrobot_kernel.world.figures import Figure, Mesh, Pose, identity
from virtualrobot_kernel.world.structure import WORLD_NAME, JointType, Kind, NodeSpec, PartData

MODEL_FORMATS = (".urdf", *MESH_FORMATS)
"""Endings of the files that `import_model` reads."""


@dataclass(frozen=True, slots=True, eq=False)
class ImportedModel:
    """The nodes of a model file, the robot, object or part first, parents before children."""

    nodes: tuple[NodeSpec, ...]
    mesh_count: int
    warnings: tuple[str, ...] = ()


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
    scale: Scale = (1.0, 1.0, 1.0),
    taken: Container[str] = (),
    referrer: str = "",
) -> ImportedModel:
    """Return the nodes of a model file; every mesh is parsed once, so that a broken one is refused here.

    Takes from milliseconds to seconds: keep it off the world thread.

    Args:
        uri: the main file: a path on the kernel's disk, `package://`, or a name among the uploaded files.
        files: where the model's files come from.
        library: keeps the parsed meshes.
        name: of the robot, object or part; empty means the file's own, with a number behind it when that is `taken`.
        parent: the node that it is fixed to.
        parent_t_node: where it goes, in the parent's frame.
        base_joint: for URDF: how the root link hangs below the robot: FIXED, FLOATING or PLANAR.
        as_part: for mesh files: a part instead of an object.
        scale: for mesh files: factors for x, y, z; negative ones mirror.
        taken: names that nodes of the world have.
        referrer: the file that names this one, such as a scene file.

    Raises:
        MalformedFileError: for an unknown format or a broken file, with file, line and element where known.
        MissingFileError: for a file that is nowhere, with each place that was tried.
        KernelError: INVALID_ARGUMENT for another base joint or an impossible scale; TOO_LARGE, UNKNOWN_ASSET.
    """
    kind = ending(uri)
    if kind not in MODEL_FORMATS:
        raise malformed(uri, None, f"no model format has the ending {kind!r}; known: {', '.join(MODEL_FORMATS)}")
    if base_joint not in BASE_JOINTS:
        valid = ", ".join(joint_type.value[0] for joint_type in BASE_JOINTS)
        raise KernelError(
            f"the base joint cannot be {base_joint.value[0]}; valid: {valid}",
            reason=Reason.INVALID_ARGUMENT,
            valid=valid,
        )

    def choose_name(own: str) -> str:
        if name:
            return name
        stem = own or uri.replace("\\", "/").rpartition("/")[2].rpartition(".")[0] or "model"
        number, chosen = 2, stem
        while chosen in taken:
            chosen, number = f"{stem}_{number}", number + 1
        return chosen

    warnings: list[str] = []

    def load(mesh_uri: str, named_by: str, mesh_scale: Scale, drawn: bool = True) -> Mesh:
        mesh, odd = find_mesh(files, mesh_uri, named_by, mesh_scale)
        library.load(mesh)
        # What is missing costs the look only, and nobody looks at a collision mesh.
        warnings.extend(text for text in odd if drawn and text not in warnings)
        return mesh

    pose = identity() if parent_t_node is None else parent_t_node
    if kind == ".urdf":
        model = read_urdf(files.read(uri, referrer), load, choose_name, base_joint)
        first = replace(model.nodes[0], parent=parent, parent_t_node=pose)
        return ImportedModel((first, *model.nodes[1:]), model.mesh_count, (*warnings, *model.warnings))
    if 0.0 in scale:
        raise KernelError(f"the scale {scale} has a factor of 0", reason=Reason.INVALID_ARGUMENT, scale=scale)
    figure = Figure(load(uri, referrer, scale))
    node = NodeSpec(
        choose_name(""),
        Kind.PART if as_part else Kind.OBJECT,
        parent,
        pose,
        figures=(figure,),
        data=PartData() if as_part else None,
    )
    return ImportedModel((node,), 1, tuple(warnings))
