"""GLB files taken apart by the specification (Khronos glTF 2.0), without our own code, and checked by its rules."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True)
class Glb:
    """The JSON part of a GLB file and its binary chunk."""

    json: dict[str, Any]
    binary: bytes

    def array(self, accessor: int) -> np.ndarray:
        """Return the numbers of an accessor, (n, width); normalized ones from 0 to 1."""
        told = self.json["accessors"][accessor]
        view = self.json["bufferViews"][told["bufferView"]]
        kind, width = np.dtype(TYPES[told["componentType"]]), WIDTHS[told["type"]]
        assert kind.itemsize * width * told["count"] == view["byteLength"]
        assert view["byteOffset"] % 4 == 0
        numbers = np.frombuffer(self.binary, kind, told["count"] * width, view["byteOffset"]).reshape(-1, width)
        return numbers / np.iinfo(kind).max if told.get("normalized") else numbers

    def poses(self) -> dict[str, np.ndarray]:
        """Return where each named node is in the file's frame, (4, 4); each node has one parent at most."""
        nodes = self.json["nodes"]
        children = [child for node in nodes for child in node.get("children", [])]
        assert len(children) == len(set(children)) == len(nodes) - 1 and 0 not in children
        found, stack = {}, [(0, np.eye(4))]
        while stack:
            place, above = stack.pop()
            node = nodes[place]
            pose = above @ local(node)
            assert node["name"] not in found
            found[node["name"]] = pose
            stack.extend((child, pose) for child in node.get("children", []))
        assert len(found) == len(nodes)
        return found

    def primitives(self, node: str) -> list[dict[str, Any]]:
        """Return what the node of that name shows."""
        (mesh,) = [one["mesh"] for one in self.json["nodes"] if one["name"] == node]
        return self.json["meshes"][mesh]["primitives"]

    def material(self, primitive: dict[str, Any]) -> dict[str, Any]:
        """Return the material of a primitive."""
        return self.json["materials"][primitive["material"]]

    def image(self, primitive: dict[str, Any]) -> bytes:
        """Return the texture's file of a primitive."""
        texture = self.material(primitive)["pbrMetallicRoughness"]["baseColorTexture"]["index"]
        view = self.json["bufferViews"][self.json["images"][self.json["textures"][texture]["source"]]["bufferView"]]
        return self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]


def local(node: dict[str, Any]) -> np.ndarray:
    """Return where a node is in its parent: T R (glTF 2.0, 3.5.3); quaternions x, y, z, w of length 1."""
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    assert abs(x * x + y * y + z * z + w * w - 1.0) < 1e-9
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return pose


def checked(data: bytes) -> Glb:
    """Return a GLB file taken apart, every rule checked that the writer could break."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    binary_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0" and binary_size % 4 == 0 and 28 + size + binary_size == len(data)
    glb = Glb(json.loads(data[20 : 20 + size]), data[28 + size :])
    tree = glb.json
    assert tree["asset"]["version"] == "2.0" and tree["scenes"][tree["scene"]]["nodes"] == [0]
    assert all(value for value in tree.values() if isinstance(value, list)), "lists may not be empty"
    assert 0 <= binary_size - tree["buffers"][0]["byteLength"] < 4
    glb.poses()
    for mesh in tree["meshes"]:
        for primitive in mesh["primitives"]:
            _check_primitive(glb, primitive)
    used = {node["mesh"] for node in tree["nodes"] if "mesh" in node}
    assert used == set(range(len(tree["meshes"])))
    return glb


def _check_primitive(glb: Glb, primitive: dict[str, Any]) -> None:
    attributes = {name: glb.array(accessor) for name, accessor in primitive["attributes"].items()}
    positions = attributes["POSITION"]
    assert {len(array) for array in attributes.values()} == {len(positions)} and len(positions)
    assert all(np.isfinite(array).all() for array in attributes.values())
    told = glb.json["accessors"][primitive["attributes"]["POSITION"]]
    assert np.array_equal(np.float32(told["min"]), positions.min(axis=0))
    assert np.array_equal(np.float32(told["max"]), positions.max(axis=0))
    if "NORMAL" in attributes:
        assert np.abs(np.linalg.norm(attributes["NORMAL"].astype(np.float64), axis=1) - 1.0).max() < 1e-5
    if "indices" in primitive:
        indices = glb.array(primitive["indices"])
        assert len(indices) % 3 == 0 and indices.max() < len(positions)
        assert indices.max() < np.iinfo(indices.dtype).max, "the greatest number means a restart"
    look = glb.material(primitive)["pbrMetallicRoughness"]
    assert all(0.0 <= part <= 1.0 for part in look["baseColorFactor"]) and len(look["baseColorFactor"]) == 4
    assert ("baseColorTexture" in look) == ("TEXCOORD_0" in attributes)
