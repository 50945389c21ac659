"""An importer of a format made up here, and wrong ones.

A `.tri` file is text: `x y z` (m) in a line for each corner, three lines a triangle; `include NAME` brings in another.
"""

from __future__ import annotations

import contextlib
import json
import socket
import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from virtualrobot_sdk.errors import ArgumentError, FilesNeeded
from virtualrobot_sdk.importers import Translation


class Tri:
    """Keeps all that an importer must."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the triangles as GLB."""
        corners = self.corners(data, uri, files, ())
        if len(corners) == 0 or len(corners) % 3:
            raise ArgumentError(f"{uri} has {len(corners)} corners; it needs three for each triangle, and one triangle")
        return Translation(".glb", self.glb(np.array(corners, np.float32)))

    def corners(
        self, data: bytes, uri: str, files: Mapping[str, bytes | None], within: tuple[str, ...]
    ) -> list[list[float]]:
        """Return the corners of a file and of those that it includes."""
        found = []
        for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
            words = line.split()
            if words[:1] == ["include"]:
                name = " ".join(words[1:])
                if name in within or not name:
                    raise ArgumentError(f"{uri}:{number}: it includes itself, or nothing")
                content = self.included(name, files)
                if content is None:
                    raise ArgumentError(f"{uri}:{number}: {name} is not there")
                found += self.corners(content, name, files, (*within, name))
            elif words:
                found.append(self.corner(words, f"{uri}:{number}"))
        return found

    def included(self, name: str, files: Mapping[str, bytes | None]) -> bytes | None:
        """Return the content of another file."""
        if name not in files:
            raise FilesNeeded([name])
        return files[name]

    def corner(self, words: list[str], where: str) -> list[float]:
        """Return the numbers of a line."""
        try:
            numbers = [float(word) for word in words]
        except ValueError as error:
            raise ArgumentError(f"{where}: {error}") from error
        if len(numbers) != 3 or not all(abs(value) < 1e6 for value in numbers):
            raise ArgumentError(f"{where}: {numbers}; three numbers below 1e6 are needed")
        return numbers

    def glb(self, corners: np.ndarray) -> bytes:
        """Return binary glTF."""
        tree = {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": corners.nbytes}],
            "bufferViews": [{"buffer": 0, "byteLength": corners.nbytes}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(corners), "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }
        text = json.dumps(tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", corners.nbytes, b"BIN\0") + corners.tobytes()
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class ShortHeader(Tri):
    """Wrong: the header's length leaves itself out."""

    def glb(self, corners: np.ndarray) -> bytes:
        """Return something that is almost glTF."""
        right = super().glb(corners)
        return right[:8] + struct.pack("<I", len(right) - 12) + right[12:]


class NumberErrors(Tri):
    """Wrong: a word that is no number raises what Python raises."""

    def corner(self, words: list[str], where: str) -> list[float]:
        """Return the numbers of a line."""
        x, y, z = map(float, words)
        return [x, y, z]


class InSetOrder(Tri):
    """Wrong: the order of its triangles is that of a set of texts."""

    def glb(self, corners: np.ndarray) -> bytes:
        """Return triangles in some order."""
        order = sorted(range(len(corners) // 3), key=lambda i: hash(str(corners[3 * i : 3 * i + 3])))
        return super().glb(np.concatenate([corners[3 * i : 3 * i + 3] for i in order]))


class AsksAgain(Tri):
    """Wrong: what is nowhere is asked for until it is there."""

    def included(self, name: str, files: Mapping[str, bytes | None]) -> bytes | None:
        """Return the content of another file."""
        if files.get(name) is None:
            raise FilesNeeded([name])
        return files[name]


class LooksItself(Tri):
    """Wrong: looks for files on the disk."""

    def included(self, name: str, files: Mapping[str, bytes | None]) -> bytes | None:
        """Return the content of another file."""
        if files.get(name) is None:
            with contextlib.suppress(OSError):
                return Path(name).read_bytes()
        return super().included(name, files)


class Downloads(Tri):
    """Wrong: looks for files elsewhere."""

    def included(self, name: str, files: Mapping[str, bytes | None]) -> bytes | None:
        """Return the content of another file."""
        if files.get(name, b"") is None:
            with socket.socket() as connection:
                connection.settimeout(0.1)
                connection.connect(("127.0.0.1", 9))
        return super().included(name, files)


class TakesAnything(Tri):
    """Wrong: lines that it does not understand are left out, and what is left of a file is a triangle."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return some triangle."""
        return Translation(".glb", self.glb(np.eye(3, dtype=np.float32)))


class HangsOnDamage(Tri):
    """Wrong: never ends where a line does not make sense."""

    def corner(self, words: list[str], where: str) -> list[float]:
        """Return the numbers of a line."""
        try:
            return super().corner(words, where)
        except ArgumentError:
            while True:
                pass
