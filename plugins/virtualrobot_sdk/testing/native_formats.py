"""Validity of an importer's translation: what all readers need of binary glTF 2.0, URDF and scene files."""

from __future__ import annotations

import json
import re
import struct
import xml.etree.ElementTree as ElementTree
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from virtualrobot_sdk.importers import NATIVE_FORMATS, Translation
from virtualrobot_sdk.testing.laws import LawBroken

_COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_VERSION = re.compile(r"""^\{?\s*["']?schema_version["']?\s*:\s*\d""", re.MULTILINE)


def check_native(translation: object, said: str, *, is_whole: bool = True) -> Translation:
    """Return a translation that opens; raise LawBroken, beginning with `said`, for one that does not.

    Of a damaged file (`is_whole` False) a robot may have joints that lead nowhere: the kernel's reader refuses those.
    """
    if not isinstance(translation, Translation):
        raise LawBroken(f"{said} gave {type(translation).__name__}; it must be a Translation")
    if translation.format not in NATIVE_FORMATS:
        raise LawBroken(f"{said} gave the format {translation.format!r}; it must be one of {', '.join(NATIVE_FORMATS)}")
    if not isinstance(translation.data, bytes) or not translation.data:
        raise LawBroken(f"{said} gave data of {type(translation.data).__name__}; it must be bytes, and some")
    warnings = translation.warnings
    if not isinstance(warnings, tuple) or not all(isinstance(one, str) and one.strip() for one in warnings):
        raise LawBroken(f"{said} gave the warnings {warnings!r}; they must be a tuple of sentences")
    opened = {".glb": _open_glb, ".urdf": _open_urdf, ".yaml": _open_scene}[translation.format]
    try:
        opened(translation.data)
        if is_whole and translation.format == ".urdf":
            _check_links(translation.data)
        if is_whole and translation.format == ".yaml":
            _check_by_kernel(translation.data)
    except (ValueError, LookupError, TypeError, AttributeError, struct.error, ElementTree.ParseError) as error:
        raise LawBroken(f"{said} gave a {translation.format} that cannot be opened: {error}") from error
    return translation


def _open_glb(data: bytes) -> None:
    """Look at header, chunks, and every array that a triangle is made of (glTF 2.0, chapters 3.6 and 4)."""
    tree, binary = _chunks(data)
    if not str(tree["asset"]["version"]).startswith("2."):
        raise ValueError(f"asset.version is {tree['asset']['version']!r}, not 2.0")
    triangles = 0
    for mesh in tree.get("meshes", []):
        for part in mesh["primitives"]:
            if part.get("mode", 4) != 4:
                continue
            positions = _array(tree, binary, part["attributes"]["POSITION"])
            if not np.isfinite(positions).all():
                raise ValueError("a position is not finite")
            for name, accessor in part["attributes"].items():
                if len(_array(tree, binary, accessor)) != len(positions):
                    raise ValueError(f"there are not as many {name} as positions")
            corners = len(positions)
            if "indices" in part:
                indices = _array(tree, binary, part["indices"])
                corners = len(indices)
                if corners and int(indices.max()) >= len(positions):
                    raise ValueError(f"a triangle names vertex {indices.max()} of {len(positions)}")
            triangles += corners // 3
    if triangles == 0:
        raise ValueError("it has no triangle")


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    magic, version, length = struct.unpack_from("<4sII", data)
    if magic != b"glTF" or version != 2:
        raise ValueError(f"it begins with {magic!r} and version {version}, not with b'glTF' and 2")
    if length != len(data):
        raise ValueError(f"its header says {length} bytes; it has {len(data)}")
    found: dict[bytes, bytes] = {}
    place = 12
    while place < length:
        size, kind = struct.unpack_from("<I4s", data, place)
        if size % 4 or place + 8 + size > length:
            raise ValueError(f"the chunk {kind!r} of {size} bytes at {place} is not aligned or passes the end")
        found.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    return json.loads(found[b"JSON"]), found.get(b"BIN\0", b"")


def _array(tree: dict[str, Any], binary: bytes, index: int) -> np.ndarray:
    """Return the values (n, width) of an accessor."""
    accessor = tree["accessors"][index]
    view = tree["bufferViews"][accessor["bufferView"]]
    dtype, width = np.dtype(_COMPONENTS[accessor["componentType"]]).newbyteorder("<"), _WIDTHS[accessor["type"]]
    stride = view.get("byteStride", dtype.itemsize * width)
    start, count = view.get("byteOffset", 0) + accessor.get("byteOffset", 0), accessor["count"]
    end = accessor.get("byteOffset", 0) + (count - 1) * stride + dtype.itemsize * width
    if count < 1 or end > view["byteLength"] or view.get("byteOffset", 0) + view["byteLength"] > len(binary):
        raise ValueError(f"accessor {index} of {count} values passes the end of its buffer")
    return np.ndarray((count, width), dtype, binary, start, (stride, dtype.itemsize))


def _open_urdf(data: bytes) -> None:
    robot = ElementTree.fromstring(data)
    if robot.tag != "robot":
        raise ValueError(f"its root is <{robot.tag}>, not <robot>")


def _check_links(data: bytes) -> None:
    robot = ElementTree.fromstring(data)
    links = {link.get("name") for link in robot.findall("link")}
    if not links:
        raise ValueError("it has no <link>")
    for joint in robot.findall("joint"):
        for end in ("parent", "child"):
            one = joint.find(end)
            if one is None or one.get("link") not in links:
                raise ValueError(f"joint {joint.get('name')!r} has no {end} among its links")


def _check_by_kernel(data: bytes) -> None:
    """Have the kernel look at a scene, where its packages are installed."""
    for point in entry_points(group="virtualrobot.kernel", name="check_scene"):
        try:
            check = point.load()
        except ImportError:
            return
        try:
            check(data)
        except Exception as error:
            raise ValueError(f"the kernel refuses it: {error}") from error


def _open_scene(data: bytes) -> None:
    text = data.decode("utf-8")
    if not _VERSION.search(text):
        raise ValueError("it has no schema_version")
    if "\0" in text or (not text.lstrip().startswith("{") and re.search(r"^ *\t", text, re.MULTILINE)):
        raise ValueError("it has characters that YAML does not allow")
