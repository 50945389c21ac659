"""The importer of `.step` and `.stp`, on cascadio, which is Open CASCADE's reader."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Annotated, Any

from msgspec import Meta
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.glb import pack_glb, unpack_glb
from virtualrobot_sdk.importers import Translation

from virtualrobot_plugins.importers.glb import MAX_TRIANGLES
from virtualrobot_plugins.importers.refusal import listed, missing_library, refusal, short_name

MAX_SECONDS = 280
"""Deadline of Open CASCADE for one file (s)."""

# The alarm ends the process where nobody is left to wait for it; crashes of broken files leave no core files. Bytes go
# through pipes, so that nothing stays on the disk when it is killed; what Open CASCADE prints goes with the errors.
_CONVERT = """
import os, signal, sys
linear, angular, seconds = map(float, sys.argv[1:])
if hasattr(signal, "alarm"):
    import resource
    signal.alarm(int(seconds) + 10)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
output = os.fdopen(os.dup(1), "wb")
os.dup2(2, 1)
import cascadio
output.write(cascadio.load(sys.stdin.buffer.read(), "step", linear, angular, use_parallel=False))
output.close()
"""
_COLORING = re.compile("\x1b\\[[0-9;]*m")

_MAGIC = b"ISO-10303-21"
_DOCUMENT = re.compile(rb"DOCUMENT_FILE\s*\(\s*'((?:[^']|'')*)'")
_TRIANGLES = 4  # glTF 2.0, 3.7.2.1: the mode of a primitive, and what it is without one


@dataclass(frozen=True, slots=True)
class StepSettings:
    """Settings of the STEP importer.

    Attributes:
        linear_tolerance_meters: largest distance of a triangle from its surface (m).
        angular_tolerance_radians: largest turn of the surface from one triangle to the next (rad).
    """

    linear_tolerance_meters: Annotated[float, Meta(description="How far a triangle may be off its surface.")] = 2e-4
    angular_tolerance_radians: Annotated[
        float, Meta(description="How much the surface may turn from one triangle to the next.")
    ] = 0.35


class StepImporter:
    """Reads STEP files (AP203, AP214, AP242): solids and surfaces as triangles, in any unit, with colours."""

    def __init__(self, settings: StepSettings | None = None) -> None:
        """Take the tolerances of the triangles.

        Raises:
            ArgumentError: when one is not above 0.
        """
        self._settings = settings or StepSettings()
        for name in ("linear_tolerance_meters", "angular_tolerance_radians"):
            value = getattr(self._settings, name)
            if not math.isfinite(value) or value <= 0.0:
                raise ArgumentError(f"the setting {name} is {value:g}; it must be above 0", setting=name)

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return the parts of a STEP file as GLB, in meters and with the axes of the file.

        Raises:
            ArgumentError: for a broken file, and for an assembly whose parts are in files of their own.
        """
        if _MAGIC not in data[:1024]:
            raise refusal(uri, f"not a STEP file: it does not begin with {_MAGIC.decode()}")
        if b"END-ISO-10303-21" not in data[-4096:]:
            # Open CASCADE reads what there is and says nothing.
            raise refusal(uri, "the file is cut off: it does not end with END-ISO-10303-21")
        if find_spec("cascadio") is None:
            raise missing_library("cascadio", ".step", "step")
        others = [name.decode("latin-1") for name in dict.fromkeys(_DOCUMENT.findall(data))]
        glb = self._converted(data, uri)
        tree, binary = unpack_glb(glb)
        count = _keep_triangles(tree)
        if count == 0:
            elsewhere = f"; its parts are in other files, load those: {listed(others)}" if others else ""
            raise refusal(uri, f"the file holds no solid and no surface{elsewhere}")
        if count > MAX_TRIANGLES:
            raise refusal(
                uri, f"the file makes {count} triangles; at most {MAX_TRIANGLES} are read: raise the tolerances"
            )
        warnings = [f"{short_name(uri)}: left out, since they are in other files: {listed(others)}"] if others else []
        return Translation(".glb", pack_glb(tree, binary), tuple(warnings))

    def _converted(self, data: bytes, uri: str) -> bytes:
        """Return Open CASCADE's GLB; in a process of its own, which broken files can crash and which prints at will."""
        linear = self._settings.linear_tolerance_meters * 1000.0  # Open CASCADE's own unit is mm
        angular = self._settings.angular_tolerance_radians
        command = [sys.executable, "-c", _CONVERT, repr(linear), repr(angular), str(MAX_SECONDS)]
        try:
            done = subprocess.run(command, input=data, capture_output=True, timeout=MAX_SECONDS, check=False)
        except subprocess.TimeoutExpired as error:
            raise refusal(uri, f"Open CASCADE has not read it in {MAX_SECONDS} seconds") from error
        if done.returncode < 0:
            raise refusal(uri, f"broken STEP file: Open CASCADE crashed on it (signal {-done.returncode})")
        if done.returncode or not done.stdout:
            lines = _COLORING.sub("", done.stderr.decode("utf-8", "replace")).split("\n")
            said = next((line.strip(" *") for line in reversed(lines) if line.strip(" *")), "")
            raise refusal(uri, "broken STEP file: Open CASCADE cannot read it" + (f" ({said})" if said else ""))
        return done.stdout


def _keep_triangles(tree: dict[str, Any]) -> int:
    """Leave edges and points out of a glTF tree; return how many triangles it has."""
    count = 0
    for mesh in tree.get("meshes", []):
        kept = [part for part in mesh["primitives"] if part.get("mode", _TRIANGLES) == _TRIANGLES]
        for part in kept:
            numbers = part.get("indices", part["attributes"]["POSITION"])
            count += tree["accessors"][numbers]["count"] // 3
        mesh["primitives"] = kept
    empty = {index for index, mesh in enumerate(tree.get("meshes", [])) if not mesh["primitives"]}
    for node in tree.get("nodes", []):
        if node.get("mesh") in empty:
            del node["mesh"]
    return count
