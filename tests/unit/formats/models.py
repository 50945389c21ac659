"""Real models and small ones for the tests of formats; what they hold is counted here without our own readers."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from virtualrobot.files.resolver import Resolver
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.files import Files
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import ImportedModel, import_model
from virtualrobot_kernel.formats.translate import Importers
from virtualrobot_kernel.numeric.forest import forward_forest
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.structure import WORLD_NAME, WORLD_UID, JointType, Kind, Node, NodeSpec, Structure
from virtualrobot_plugins.importers.sdf.importer import SdfImporter
from virtualrobot_plugins.importers.xacro import Xacro, XacroSettings
from virtualrobot_plugins.models.tables import read_tables
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.models import Model

from tests.pybullet_models import pybullet_data

DATA = Path(pybullet_data.getDataPath())

ROBOTS = {
    "iiwa": DATA / "kuka_iiwa/model.urdf",
    "panda": DATA / "franka_panda/panda.urdf",
    "xarm6": DATA / "xarm/xarm6_robot.urdf",
    "xarm6_white": DATA / "xarm/xarm6_robot_white.urdf",
    "xarm6_gripper": DATA / "xarm/xarm6_with_gripper.urdf",
    "a1": DATA / "a1/a1.urdf",
    "husky": DATA / "husky/husky.urdf",
    "r2d2": DATA / "r2d2.urdf",
}


MODELS = {model.name: model for model in read_tables()}
"""The models that the bundled plugin makes known."""


class XacroOnly:
    """The bundled importer for xacro, called in this process, and models by name: the bundled ones unless told."""

    endings = (".xacro", ".urdf")

    def __init__(self, models: Mapping[str, Model] = MODELS) -> None:
        """Know these models."""
        self.models = models

    def translate(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Mapping[str, Any]
    ) -> Translation:
        return Xacro(XacroSettings(**settings)).translate(data, uri, files)


class XacroAndSdf(XacroOnly):
    """The bundled importers for models of robots, called in this process."""

    endings = (*XacroOnly.endings, ".sdf")

    def translate(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], settings: Mapping[str, Any]
    ) -> Translation:
        if uri.endswith(".sdf"):
            return SdfImporter().translate(data, uri, files)
        return super().translate(data, uri, files, settings)


def disk(store: AssetStore | None = None) -> Files:
    """Return files that come from the disk."""
    return Files(store or AssetStore(), {}, Resolver())


def uploaded(contents: Mapping[str, bytes]) -> Files:
    """Return files that come from an upload alone; the disk is forbidden."""
    store = AssetStore()
    return Files(store, {name: store.put(data) for name, data in contents.items()})


def load(
    path: Path, base_joint: JointType = JointType.FIXED, name: str = "", **options: object
) -> tuple[ImportedModel, MeshLibrary]:
    """Import a model from the disk."""
    files = disk()
    library = MeshLibrary(files.store, XacroOnly())
    return imported(str(path), files, library, base_joint=base_joint, name=name, **options), library


def imported(uri: str, files: Files, library: MeshLibrary | None = None, **options: Any) -> ImportedModel:  # noqa: ANN401  those of `import_model`
    """Import a model that is no scene."""
    model = import_model(uri, files, library or MeshLibrary(files.store), **options)
    assert isinstance(model, ImportedModel)
    return model


def read_text(
    text: str, meshes: Mapping[str, bytes] | None = None, importers: Importers | None = None, **options: object
) -> ImportedModel:
    """Import the text of a URDF file named model.urdf whose meshes are given by name."""
    files = uploaded({"model.urdf": text.encode(), **(meshes or {})})
    return imported("model.urdf", files, MeshLibrary(files.store, importers), **options)


def refusal(text: str | bytes, name: str = "model.urdf") -> MalformedFileError:
    """Return the error with which a model file is refused; fail when it is taken."""
    files = uploaded({name: text.encode() if isinstance(text, str) else text})
    try:
        import_model(name, files, MeshLibrary(files.store))
    except MalformedFileError as error:
        return error
    raise AssertionError("the file was taken")


def structure_of(nodes: tuple[NodeSpec, ...]) -> tuple[Structure, np.ndarray]:
    """Return the world that holds the nodes alone, and parent_t_node (N, 4, 4) by row."""
    uids = {WORLD_NAME: WORLD_UID} | {spec.name: WORLD_UID + 1 + i for i, spec in enumerate(nodes)}
    made = {WORLD_UID: Node(WORLD_UID, WORLD_NAME, Kind.WORLD, 0)}
    for spec in nodes:
        uid = uids[spec.name]
        made[uid] = Node(uid, spec.name, spec.kind, uids[spec.parent], figures=spec.figures, data=spec.data)
    poses = np.array([np.eye(4), *(spec.parent_t_node for spec in nodes)])
    return index.build(made, len(nodes) + 2, 1), poses


def forward(structure: Structure, parent_t_node: np.ndarray, q: np.ndarray) -> dict[str, np.ndarray]:
    """Return world_t_node by node name at the coordinates q (nq,)."""
    forest, world_t_node = structure.forest, np.zeros_like(parent_t_node)
    forward_forest(
        forest.order,
        forest.parent,
        forest.joint_type,
        forest.axis,
        forest.q_index,
        forest.multiplier,
        forest.offset,
        parent_t_node,
        q,
        world_t_node,
    )
    return {structure.nodes[uid].name: world_t_node[row] for uid, row in structure.rows.items()}


def without_comments(path: Path) -> str:
    """Return the text of an XML file without its comments."""
    return re.sub(r"<!--.*?-->", "", path.read_text(), flags=re.DOTALL)


def count_triangles(data: bytes, ending: str) -> int:
    """Return the count of triangles of a binary STL (its header) or an OBJ (a face of n corners makes n - 2)."""
    if ending == ".stl":
        (count,) = struct.unpack_from("<I", data, 80)
        return count
    return sum(len(line.split()) - 3 for line in data.decode().splitlines() if line.startswith("f "))


def corner_positions(data: bytes, ending: str) -> np.ndarray:
    """Return the positions (n, 3) of the corners of all faces of a binary STL or an OBJ file, by the format's rules."""
    if ending == ".stl":
        facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        return np.frombuffer(data, facet, offset=84)["corners"].reshape(-1, 3)
    lines = [line.split() for line in data.decode().splitlines() if line.startswith(("v ", "f "))]
    vertices = np.array([[float(word) for word in words[1:4]] for words in lines if words[0] == "v"])
    corners = [int(corner.split("/")[0]) - 1 for words in lines if words[0] == "f" for corner in words[1:]]
    return vertices[corners]


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the signed volume of a closed mesh: the sum of a . (b x c) / 6; positive when faces look outward."""
    a, b, c = np.moveaxis(vertices.astype(np.float64)[faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def binary_stl(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    """Return a binary STL file."""
    facets = np.zeros(len(faces), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    facets["corners"] = vertices[faces]
    return bytes(80) + struct.pack("<I", len(faces)) + facets.tobytes()


TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])
"""Corners of a tetrahedron of volume 0.3 * 0.2 * 0.1 / 6 = 0.001 m^3."""

TETRAHEDRON_FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
"""Its faces, counter-clockwise seen from outside."""
