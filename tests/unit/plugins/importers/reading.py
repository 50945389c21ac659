"""What the tests of importers share: reading a translation as the kernel does, measuring it, and breaking files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from virtualrobot.v1 import scene_pb2
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.importers import Importer, Translation

FILES = Path(__file__).parent / "files"

_ODD_NUMBERS = (b"0", b"-1", b"2.5", b"1e308", b"-1e308", b"1e-300", b"nan", b"99999999999", b"4294967295", b"")


def meshes(importer: Importer, data: bytes | str, name: str, files: Mapping[str, bytes] | None = None) -> list[Submesh]:
    """Return the triangles of a file as the kernel reads the GLB that an importer makes of it."""
    return parts(importer.translate(encoded(data), name, files or {}))


def parts(translation: Translation) -> list[Submesh]:
    assert translation.format == ".glb"
    return list(parse_mesh(translation.data, "translated.glb"))


def scene(importer: Importer, data: bytes | str, name: str, files: Mapping[str, bytes] | None = None) -> SceneFile:
    """Return the scene that an importer makes of a file."""
    translation = importer.translate(encoded(data), name, files or {})
    assert translation.format == ".yaml"
    return scene_file.parse(translation.data.decode(), name)


SceneFile = scene_pb2.SceneFile


def refusal(importer: Importer, data: bytes | str, name: str, files: Mapping[str, bytes | None] | None = None) -> str:
    """Return the words with which an importer refuses a file."""
    with pytest.raises(ArgumentError) as caught:
        importer.translate(encoded(data), name, files or {})
    return str(caught.value)


def encoded(data: bytes | str) -> bytes:
    return data.encode() if isinstance(data, str) else data


def triangles(pieces: list[Submesh]) -> np.ndarray:
    """Return the corners (m, 3, 3) of all triangles."""
    return np.concatenate([piece.vertices.astype(np.float64)[piece.faces] for piece in pieces])


def bounds(pieces: list[Submesh]) -> np.ndarray:
    """Return the least and the greatest corner (2, 3)."""
    corners = triangles(pieces).reshape(-1, 3)
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def volume(pieces: list[Submesh]) -> float:
    """Return the volume: the sum of a . (b x c) / 6; positive when faces look outward."""
    a, b, c = np.moveaxis(triangles(pieces), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def area(pieces: list[Submesh]) -> float:
    """Return the area of all triangles."""
    a, b, c = np.moveaxis(triangles(pieces), 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def broken(data: bytes, rng: np.random.Generator) -> bytes:
    """Return a file with one kind of damage: cut off, bytes changed, a piece gone or twice, numbers of another size."""
    kind = rng.integers(5)
    start = int(rng.integers(len(data)))
    end = start + int(rng.integers(1, 300))
    if kind == 0:
        return data[:start]
    if kind == 1:
        changed = bytearray(data)
        for place in rng.integers(len(data), size=int(rng.integers(1, 20))):
            changed[place] = int(rng.integers(256))
        return bytes(changed)
    if kind == 2:
        return data[:start] + data[end:]
    if kind == 3:
        place = int(rng.integers(len(data)))
        return data[:place] + data[start:end] + data[place:]
    numbers = list(re.finditer(rb"\d+(\.\d+)?", data))
    number = numbers[rng.integers(len(numbers))]
    return data[: number.start()] + _ODD_NUMBERS[rng.integers(len(_ODD_NUMBERS))] + data[number.end() :]
