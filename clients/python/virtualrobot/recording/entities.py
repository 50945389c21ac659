"""Looks of a scene as the kernel exports them (binary glTF), cut into one model for each node.

A model hangs on the frame of its node, so that it is written once, and again only when it changes.
Source: Khronos Group, glTF 2.0 Specification, sections 3 (properties) and 4 (GLB file format).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Iterator
from typing import Any

from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from google.protobuf.timestamp_pb2 import Timestamp

_MEDIA_TYPE = "model/gltf-binary"


def unpack(data: bytes) -> tuple[dict[str, Any], memoryview]:
    """Return the tree and the buffer of a GLB file."""
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), memoryview(data)[28 + length :]


def pack(tree: dict[str, Any], buffer: bytes) -> bytes:
    """Return a GLB file: header, JSON chunk and binary chunk, each padded to 4 bytes."""
    text = json.dumps({**tree, "buffers": [{"byteLength": len(buffer)}]}, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    header = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(buffer))
    return b"".join(
        [header, struct.pack("<I4s", len(text), b"JSON"), text, struct.pack("<I4s", len(buffer), b"BIN\0"), buffer]
    )


def models(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield the name of each node of an exported scene that has figures, and a GLB file of these in its frame.

    The kernel's export has a glTF node for each node of the scene, and below it one with a mesh for each figure. The
    root's frame has y upwards, as glTF wants it; so has each model.
    """
    tree, buffer = unpack(data)
    nodes = tree["nodes"]
    upright = nodes[tree["scenes"][0]["nodes"][0]].get("rotation", [0.0, 0.0, 0.0, 1.0])
    for node in nodes:
        figures = [nodes[child] for child in node.get("children", ()) if "mesh" in nodes[child]]
        if figures:
            yield node["name"], _Cut(tree, buffer).model(node["name"], upright, figures)


def entity(name: str, model: bytes, time: Timestamp) -> SceneEntity:
    """Return a node's figures as an entity that goes where its frame goes."""
    made = SceneEntity(timestamp=time, frame_id=name, id=name, frame_locked=True)
    one = made.models.add(data=model, media_type=_MEDIA_TYPE)
    one.pose.orientation.w = 1.0
    one.scale.x = one.scale.y = one.scale.z = 1.0
    return made


class _Cut:
    """Part of a glTF tree: what is taken brings along what it names, each once."""

    def __init__(self, tree: dict[str, Any], buffer: memoryview) -> None:
        self._from, self._buffer = tree, buffer
        self._tree: dict[str, list[Any]] = {}
        self._taken: dict[tuple[str, int], int] = {}
        self._bytes = bytearray()

    def model(self, name: str, upright: list[float], figures: Iterable[dict[str, Any]]) -> bytes:
        """Return a GLB file of some nodes with meshes below one that turns them upright."""
        below = [{**figure, "mesh": self._take("meshes", figure["mesh"])} for figure in figures]
        root = {"name": name, "rotation": upright, "children": list(range(1, len(below) + 1))}
        kept = {name: self._from[name] for name in ("asset", "extensionsUsed") if name in self._from}
        tree = {**kept, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [root, *below], **self._tree}
        return pack(tree, bytes(self._bytes))

    def _take(self, kind: str, place: int) -> int:
        """Take an entry of a list of the tree with all that it names; return its new place."""
        if (kind, place) not in self._taken:
            entry = self._renamed(kind, self._from[kind][place])
            taken = self._tree.setdefault(kind, [])
            taken.append(entry)
            self._taken[kind, place] = len(taken) - 1
        return self._taken[kind, place]

    def _renamed(self, kind: str, entry: dict[str, Any]) -> dict[str, Any]:
        """Return an entry whose names of others are those of this part."""
        if kind == "meshes":
            return {**entry, "primitives": [self._primitive(one) for one in entry["primitives"]]}
        if kind == "materials":
            surface = dict(entry["pbrMetallicRoughness"])
            if texture := surface.get("baseColorTexture"):
                surface["baseColorTexture"] = {**texture, "index": self._take("textures", texture["index"])}
            return {**entry, "pbrMetallicRoughness": surface}
        if kind == "textures":
            return {**entry, "source": self._take("images", entry["source"])}
        if kind == "bufferViews":
            begin = entry["byteOffset"]
            self._bytes += b"\0" * (-len(self._bytes) % 4)
            moved = {**entry, "byteOffset": len(self._bytes)}
            self._bytes += self._buffer[begin : begin + entry["byteLength"]]
            return moved
        return {**entry, "bufferView": self._take("bufferViews", entry["bufferView"])}  # an accessor or an image

    def _primitive(self, entry: dict[str, Any]) -> dict[str, Any]:
        taken = {**entry, "material": self._take("materials", entry["material"])}
        taken["attributes"] = {name: self._take("accessors", place) for name, place in entry["attributes"].items()}
        if "indices" in entry:
            taken["indices"] = self._take("accessors", entry["indices"])
        return taken
