"""References of a file to others: meshes of a URDF, materials and textures of a mesh, meshes and models of a scene."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from posixpath import relpath
from urllib.parse import unquote

from virtualrobot.files.resolver import is_relative, join_uri

from virtualrobot_kernel.errors import KernelError, MalformedFileError
from virtualrobot_kernel.formats import scene_file
from virtualrobot_kernel.formats.collada import image_names, parse_collada
from virtualrobot_kernel.formats.translate import Importers, NoImporters, Settings, run
from virtualrobot_kernel.formats.xml import malformed, parse_xml, xacro_in

MOST_LETTERS = 10_000
"""Number of places up to which each is looked at by itself; to search the whole of a file of 3 MB takes as long."""

_GLB_MAGIC, _GLB_JSON = 0x46546C67, 0x4E4F534A  # Khronos glTF 2.0 specification, section 4.4


def ending(uri: str) -> str:
    """Return the ending of a name, in small letters and with its dot; empty when it has none."""
    name = uri.replace("\\", "/").rpartition("/")[2]
    stem, dot, last = name.rpartition(".")
    return f".{last.lower()}" if dot and stem else ""


def counted_from(main: str, name: str) -> str:
    """Return the path to the file `name` from the folder of the file `main`, both as joined names.

    `name` itself where there is none: it is relative already, or in another package or on another kind of place.
    """
    if is_relative(name) and not is_relative(main):
        return name
    scheme, _, path = main.rpartition("://")
    other_scheme, _, other = name.rpartition("://")
    if (scheme, path.startswith("/")) != (other_scheme, other.startswith("/")):
        return name
    if scheme and path.partition("/")[0] != other.partition("/")[0]:
        return name
    return relpath(other, path.rpartition("/")[0] or ("/" if path.startswith("/") else "."))


def list_references(
    data: bytes,
    uri: str,
    importers: Importers | None = None,
    known: Mapping[str, bytes] | None = None,
    settings: Settings | None = None,
) -> dict[str, str]:
    """Return the files that a file names, in its order: each name with the SHA-256 that it states, mostly an empty one.

    Names are as written, but for backslashes, which become slashes, and `%20` and the like in COLLADA and glTF, which
    are worked out. A format that names no files gives none.

    A file that is translated names what its importer asks for, and what the translation names. What it asks for may
    depend on what the files say that it asked for: give those in `known`, by name joined to `uri`, and ask again until
    nothing new comes.

    Raises MalformedFileError for broken files.
    """
    kind = ending(uri)
    reader = importers or NoImporters()
    if kind in reader.endings and (kind not in _READERS or needs_xacro(data, uri)):
        return _foreign(data, uri, reader, known or {}, settings or {})
    read = _READERS.get(kind)
    if read is None:
        return {}
    if read is _scene:
        return dict(_scene(data, uri))
    return dict.fromkeys((name for name in read(data, uri) if name), "")


def needs_xacro(data: bytes, uri: str) -> bool:
    """Return whether a file called URDF must be expanded first."""
    # Most files have none of these bytes, and need not be parsed for this.
    may = ending(uri) == ".urdf" and (b"<xacro:" in data or b"$(" in data or b"${" in data)
    return may and xacro_in(parse_xml(data, uri)) is not None


def _foreign(
    data: bytes, uri: str, importers: Importers, known: Mapping[str, bytes], settings: Settings
) -> dict[str, str]:
    asked: dict[str, bool] = {}

    def read(name: str) -> bytes | None:
        found = next((known[key] for key in (join_uri(uri, name), name) if key in known), None)
        asked[name] = found is not None
        return found

    try:
        translation = run(importers, data, uri, read, settings)
    except KernelError:
        if all(asked.values()):
            raise
        return dict.fromkeys(asked, "")  # what it lacks explains the error
    inner = list_references(translation.data, f"{uri}{translation.format}")
    return dict.fromkeys(asked, "") | inner


def _urdf(data: bytes, uri: str) -> Iterator[str]:
    for mesh in parse_xml(data, uri).iterfind(".//geometry/mesh"):
        yield mesh.get("filename", "").replace("\\", "/")


def _named_by(keyword: bytes, data: bytes) -> Iterator[str]:
    """Yield what follows a keyword, given in small letters, at the start of a line of an OBJ or MTL file."""
    for at in _places(keyword, data):
        begin, end = data.rfind(b"\n", 0, at) + 1, data.find(b"\n", at)
        before, after = data[begin:at], data[at + len(keyword) : end if end >= 0 else len(data)]
        name = after.partition(b"\r")[0]
        if not before.strip(b" \t") and name[:1] in (b" ", b"\t") and name.strip(b" \t"):
            yield name.decode("utf-8", "replace").strip().replace("\\", "/")


def _places(keyword: bytes, data: bytes) -> Iterator[int]:
    """Yield where a keyword, given in small letters, stands in any letters; none that begins in one before."""
    # Where its first letter is rare, as it is among numbers, a search for that takes a tenth of the time.
    first = keyword[:1], keyword[:1].upper()
    if sum(map(data.count, first)) > MOST_LETTERS:
        small, at = data.lower(), 0
        while (at := small.find(keyword, at)) >= 0:
            yield at
            at += len(keyword)
        return
    found: list[int] = []
    for letter in first:
        at = -1
        while (at := data.find(letter, at + 1)) >= 0:
            if data[at : at + len(keyword)].lower() == keyword:
                found.append(at)
    yield from sorted(found)


def _obj(data: bytes, uri: str) -> Iterator[str]:
    return _named_by(b"mtllib", data)


def _mtl(data: bytes, uri: str) -> Iterator[str]:
    return _named_by(b"map_kd", data)


def _dae(data: bytes, uri: str) -> Iterator[str]:
    return image_names(parse_collada(data, uri))


def _gltf(data: bytes, uri: str, kinds: tuple[str, ...] = ("buffers", "images")) -> Iterator[str]:
    tree = gltf_json(data, uri)
    for kind in kinds:
        for entry in tree.get(kind, []):
            name = entry.get("uri", "")
            if not name.startswith("data:"):
                yield unquote(name)


def buffer_names(data: bytes, uri: str) -> set[str]:
    """Return the names, as `list_references` has them, of files without which a mesh has no shape: buffers of glTF.

    All else that a mesh file names costs the look only, whatever it is called.
    """
    return set(_gltf(data, uri, ("buffers",))) if ending(uri) in (".gltf", ".glb") else set()


def gltf_json(data: bytes, uri: str) -> dict:
    """Return the JSON part of a glTF or GLB file; raise MalformedFileError when there is none."""
    text = data
    if ending(uri) == ".glb":
        if len(data) < 20 or struct.unpack_from("<I", data)[0] != _GLB_MAGIC:
            raise malformed(uri, None, "not a GLB file: it does not begin with glTF")
        length, kind = struct.unpack_from("<II", data, 12)
        if kind != _GLB_JSON or 20 + length > len(data):
            raise malformed(uri, None, "broken GLB file: its JSON part is missing or cut off")
        text = data[20 : 20 + length]
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise malformed(uri, None, f"not glTF: {error}") from error
    if not isinstance(tree, dict) or not all(
        isinstance(tree.get(kind, []), list) and all(map(_may_be_named, tree.get(kind, [])))
        for kind in ("buffers", "images")
    ):
        told = "expected an object with lists of buffers and images, and a text as the `uri` of each"
        raise malformed(uri, None, f"not glTF: {told}")
    return tree


def _may_be_named(entry: object) -> bool:
    """Return whether something in a list of buffers or images is an object whose name, if it has one, is a text."""
    return isinstance(entry, dict) and isinstance(entry.get("uri", ""), str)


def _scene(data: bytes, uri: str) -> Iterator[tuple[str, str]]:
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        raise MalformedFileError(f"{uri}: not text in utf-8: {error.reason}", file=uri) from error
    yield from scene_file.references(scene_file.parse(text, uri))


_READERS = {
    ".urdf": _urdf,
    ".obj": _obj,
    ".mtl": _mtl,
    ".dae": _dae,
    ".gltf": _gltf,
    ".glb": _gltf,
    ".yaml": _scene,
    ".yml": _scene,
}
