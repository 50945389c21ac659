"""The importer of `.wrl` and `.wrz`: VRML97 (ISO/IEC 14772-1:1997), whose unit is the meter (4.4.5)."""

from __future__ import annotations

import zlib
from collections.abc import Mapping

import numpy as np
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.glb import write_glb
from virtualrobot_plugins.importers.refusal import described, refusal
from virtualrobot_plugins.importers.vrml.syntax import Node, parse
from virtualrobot_plugins.importers.vrml.world import World

MAX_BYTES = 256 * 2**20
_GZIP = b"\x1f\x8b"


class VrmlImporter:
    """Reads VRML97 worlds, packed by gzip or not: shapes, transforms, prototypes, colours, textures, inlined files."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return what the world shows at its start as GLB, with the axes of the file (VRML's y is up).

        Raises:
            FilesNeeded: for files that it inlines, and for textures (without which it is drawn all the same).
            ArgumentError: `file:line: ...` for what is not VRML97, and for a world that shows no surface.
        """
        world = World(files, _read)
        with np.errstate(all="ignore"):  # numbers out of range are told by what they yield
            warnings = world.collect(_read(data, uri), uri)
        if not world.pieces:
            raise refusal(uri, f"the world shows no surface{world.holds()}")
        return Translation(".glb", write_glb(world.pieces, uri), warnings)


def _read(data: bytes, uri: str) -> list[Node]:
    if data.startswith(_GZIP):
        unpack = zlib.decompressobj(wbits=31)
        try:
            data = unpack.decompress(data, MAX_BYTES + 1)
        except zlib.error as error:
            raise refusal(uri, f"broken gzip file ({described(error)})") from error
        if len(data) > MAX_BYTES:
            raise refusal(uri, f"the file is larger than {MAX_BYTES >> 20} MiB when unpacked")
        if not unpack.eof:
            raise refusal(uri, "broken gzip file: it is cut off")
    # The standard says UTF-8; old exporters wrote names in other encodings, and no name matters here.
    text = data.decode("utf-8", "replace").removeprefix("\ufeff")
    header = text.split("\n", 1)[0].strip()
    if header.startswith("#VRML V1.0"):
        raise refusal(uri, "this is VRML 1.0; only VRML97 (#VRML V2.0 utf8) is read: convert it first", 1)
    if header.startswith("#X3D"):
        raise refusal(uri, "this is X3D; only VRML97 (#VRML V2.0 utf8) is read: export it as VRML97", 1)
    if not header.startswith("#VRML V2.0"):
        raise refusal(uri, "not a VRML97 file: its first line is not '#VRML V2.0 utf8'", 1)
    return parse(text, uri)
