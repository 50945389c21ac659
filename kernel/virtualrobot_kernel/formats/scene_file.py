"""Scene files: YAML 1.2 text to the message `SceneFile` and back.

The text is the protobuf JSON mapping of the message with the names of the contract, so that one schema serves the API
and the file. It is read against that schema: a text field takes what is written as text (`on`, `5` and `1.0` are
names), and every error names line, path and the nearest right word.

Laws: parse(format(x)) == x, and format(parse(format(x))) == format(x).
"""

from __future__ import annotations

from collections.abc import Iterator

from virtualrobot.v1 import nodes_pb2, scene_pb2

from virtualrobot_kernel.formats.scene_reader import SceneReader
from virtualrobot_kernel.formats.scene_writer import to_plain, write_yaml
from virtualrobot_kernel.formats.xml import malformed
from virtualrobot_kernel.formats.yaml_text import Check, MappingNode, Node, SequenceNode, compose
from virtualrobot_kernel.world.consistency import check_count

SCHEMA_VERSION = 1
"""Version of the format that is written and read."""

HEADER = "# A VirtualRobot scene: meters, radians, kilograms; parents before children.\n"


def parse(text: str, uri: str = "scene.yaml", check: Check = lambda: None) -> scene_pb2.SceneFile:
    """Return the scene that `text` tells; `uri` names the file in errors.

    `check` is called again and again; what it raises ends the reading.

    Raises:
        MalformedFileError: `scene.yaml:12: nodes[3].figures[0].box: ...` for broken YAML, duplicate, unknown and
            misplaced keys, values of a wrong type, and a schema version that is missing or unknown.
        KernelError: TOO_LARGE, see `formats/yaml_text.py`.
    """
    scene = scene_pb2.SceneFile()
    root = composed(text, uri, "scene", SCHEMA_VERSION, check)
    for key, value in root.value:
        if isinstance(value, SequenceNode) and key.value == "nodes":
            check_count(len(value.value))  # before the long work
    SceneReader(uri, check=check).fill(scene, root, "")
    return scene


def composed(text: str, uri: str, kind: str, version: int, check: Check = lambda: None) -> MappingNode:
    """Return the YAML of a file of some kind that begins with this schema version; raise as `parse` does."""
    return _of_version(compose(text, uri, check), uri, kind, version)


def format(scene: scene_pb2.SceneFile) -> str:
    """Return the scene as YAML text: one key a line, keys in the order of the contract, defaults left out.

    Up to four numbers that belong together (vectors, quaternions, colours) are on one line. Numbers read back exactly.
    """
    return HEADER + write_yaml(to_plain(scene))


def references(scene: scene_pb2.SceneFile) -> Iterator[tuple[str, str]]:
    """Yield the files that a scene names (meshes, models, what belongs to models), each with the SHA-256 it states."""
    for node in scene.nodes:
        for mesh in meshes(node):
            yield mesh.uri, mesh.sha256
    for model in scene.models:
        yield from ((uri, "") for uri in (model.uri, model.srdf_uri) if uri)


def meshes(node: nodes_pb2.Node) -> Iterator[nodes_pb2.Mesh]:
    """Yield the meshes of a node's figures; they may be changed in place."""
    for figure in node.figures:
        if figure.HasField("mesh"):
            yield figure.mesh


def _of_version(root: Node | None, uri: str, kind: str, version: int) -> MappingNode:
    """Ask for the version before anything else: the rest of a newer file may mean something else."""
    example = f"a {kind} file begins with `schema_version: {version}`"
    if root is None:
        raise malformed(uri, 1, f"the file is empty; {example}")
    if not isinstance(root, MappingNode):
        raise malformed(uri, root.line, f"expected keys and values; {example}")
    for key, value in root.value:
        if key.value == "schema_version":
            if value.value != str(version):
                line = value.line
                known = f"unknown version {value.value!r}; this kernel reads version {version}"
                raise malformed(uri, line, known, "schema_version")
            return root
    raise malformed(uri, 1, f"the version is missing; {example}", "schema_version")
