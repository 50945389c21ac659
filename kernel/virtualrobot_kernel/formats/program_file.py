"""Program files: YAML 1.2 text to the message `MotionSpec`, read against its schema as scene files are."""

from __future__ import annotations

from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.formats.scene_file import composed
from virtualrobot_kernel.formats.scene_reader import SceneReader
from virtualrobot_kernel.formats.yaml_text import Check, MappingNode

SCHEMA_VERSION = 1
"""Version of the format that is read."""


def parse(text: str, uri: str = "program.yaml", check: Check = lambda: None) -> motion_pb2.MotionSpec:
    """Return the motion that `text` tells; `uri` names the file in errors, and `check` may end the reading.

    Raises:
        MalformedFileError: `program.yaml:12: steps[3].move.moves[0].robot: ...`, as for scene files.
    """
    root = composed(text, uri, "program", SCHEMA_VERSION, check)
    rest = [(key, value) for key, value in root.value if key.value != "schema_version"]
    fields = MappingNode(rest, root.line, root.tag)
    spec = motion_pb2.MotionSpec()
    SceneReader(uri, "program", check).fill(spec, fields, "")
    return spec
