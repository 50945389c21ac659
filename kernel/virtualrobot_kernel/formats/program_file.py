"""Program files: YAML 1.2 text to the message `StartMotionRequest`, read against its schema as scene files are."""

from __future__ import annotations

from ruamel.yaml.nodes import MappingNode
from virtualrobot.v1 import motion_pb2

from virtualrobot_kernel.formats.scene_file import composed, read
from virtualrobot_kernel.formats.scene_reader import SceneReader

SCHEMA_VERSION = 1
"""The version of the format that is read."""


def parse(text: str, uri: str = "program.yaml") -> motion_pb2.StartMotionRequest:
    """Return the motion that `text` tells; `uri` names the file in errors.

    Raises:
        MalformedFileError: `program.yaml:12: steps[3].move.moves[0].robot: ...`, as for scene files.
    """
    root = composed(text, uri, "program", SCHEMA_VERSION)
    rest = [(key, value) for key, value in root.value if key.value != "schema_version"]
    fields = MappingNode(root.tag, rest, root.start_mark, root.end_mark)
    motion = motion_pb2.StartMotionRequest()
    read(motion, fields, SceneReader(uri, "program"))
    return motion
