"""Binary glTF (GLB): files taken apart, parts of them put together, and motions of their nodes.

Source: Khronos Group, glTF 2.0 Specification, sections 3 (properties and animations) and 4 (GLB file format).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

_FLOAT = 5126
_OF_VIEW = ("buffer", "byteOffset", "byteLength")
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


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


class Parts:
    """Lists of a glTF tree that is put together, such as its meshes, and its buffer."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.lists: dict[str, list[Any]] = {}
        self.kept: dict[str, Any] = {}
        self._bytes = bytearray()

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """Add an entry to a list of the tree, and return its place."""
        entries = self.lists.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def add_bytes(self, data: bytes | memoryview, **about: object) -> int:
        """Add a part of the buffer, and return the place of its view."""
        self._bytes += b"\0" * (-len(self._bytes) % 4)
        begin = len(self._bytes)
        self._bytes += data
        return self.add("bufferViews", {**about, "buffer": 0, "byteOffset": begin, "byteLength": len(data)})

    def add_values(self, values: NDArray[np.float64]) -> int:
        """Add rows of 1, 3 or 4 numbers (n, k), in single precision, and return the place of their accessor."""
        single = np.ascontiguousarray(values, np.float32)
        view = self.add_bytes(single.tobytes())
        about = {"bufferView": view, "componentType": _FLOAT, "count": len(single), "type": _TYPES[single.shape[1]]}
        ends = {"min": single.min(axis=0).tolist(), "max": single.max(axis=0).tolist()}
        return self.add("accessors", {**about, **ends})

    def file(self, **about: object) -> bytes:
        """Return the GLB file: `about` is what it has beside these lists."""
        return pack({**self.kept, **about, **self.lists}, bytes(self._bytes))


class Export:
    """A scene as the kernel exports it: a glTF node for each node, and below it one with a mesh for each figure."""

    def __init__(self, data: bytes) -> None:
        """Take a GLB file apart."""
        self._tree, self._buffer = unpack(data)

    @property
    def upright(self) -> list[float]:
        """Quaternion (x, y, z, w) of the root, whose frame has y upwards, as glTF wants it."""
        root = self._tree["nodes"][self._tree["scenes"][0]["nodes"][0]]
        return root.get("rotation", [0.0, 0.0, 0.0, 1.0])

    def figures(self) -> Iterator[tuple[str, list[dict[str, Any]]]]:
        """Yield the name of each node that has figures, and these in its frame, as `take` takes them."""
        nodes = self._tree["nodes"]
        for node in nodes:
            if figures := [nodes[child] for child in node.get("children", ()) if "mesh" in nodes[child]]:
                yield node["name"], figures

    def taking(self, parts: Parts) -> Taking:
        """Return what takes figures of this file into another one."""
        parts.kept |= {name: self._tree[name] for name in ("asset", "extensionsUsed") if name in self._tree}
        return Taking(self._tree, self._buffer, parts)


class Taking:
    """Copier of figures of a glTF file into another one, with all that they name, each once."""

    def __init__(self, tree: dict[str, Any], buffer: memoryview, parts: Parts) -> None:
        """Take from a tree and its buffer into `parts`."""
        self._from, self._buffer, self._parts = tree, buffer, parts
        self._taken: dict[tuple[str, int], int] = {}

    def figure(self, figure: dict[str, Any]) -> int:
        """Take a figure, and return its place among the nodes."""
        return self._parts.add("nodes", {**figure, "mesh": self._take("meshes", figure["mesh"])})

    def _take(self, kind: str, place: int) -> int:
        """Take an entry of a list of the tree with all that it names; return its new place."""
        if (kind, place) not in self._taken:
            self._taken[kind, place] = self._moved(kind, self._from[kind][place])
        return self._taken[kind, place]

    def _moved(self, kind: str, entry: dict[str, Any]) -> int:
        """Add an entry whose names of others are those of the other file."""
        if kind == "bufferViews":
            begin = entry["byteOffset"]
            about = {name: value for name, value in entry.items() if name not in _OF_VIEW}
            return self._parts.add_bytes(self._buffer[begin : begin + entry["byteLength"]], **about)
        if kind == "meshes":
            entry = {**entry, "primitives": [self._primitive(one) for one in entry["primitives"]]}
        elif kind == "materials":
            surface = dict(entry["pbrMetallicRoughness"])
            if texture := surface.get("baseColorTexture"):
                surface["baseColorTexture"] = {**texture, "index": self._take("textures", texture["index"])}
            entry = {**entry, "pbrMetallicRoughness": surface}
        elif kind == "textures":
            entry = {**entry, "source": self._take("images", entry["source"])}
        else:  # an accessor or an image
            entry = {**entry, "bufferView": self._take("bufferViews", entry["bufferView"])}
        return self._parts.add(kind, entry)

    def _primitive(self, entry: dict[str, Any]) -> dict[str, Any]:
        taken = {**entry, "material": self._take("materials", entry["material"])}
        taken["attributes"] = {name: self._take("accessors", place) for name, place in entry["attributes"].items()}
        if "indices" in entry:
            taken["indices"] = self._take("accessors", entry["indices"])
        return taken
