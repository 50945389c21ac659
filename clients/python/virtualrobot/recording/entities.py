"""Looks of a scene as the kernel exports them (binary glTF), cut into one model for each node.

A model hangs on the frame of its node, so that it is written once, and again only when it changes.
"""

from __future__ import annotations

from collections.abc import Iterator

from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot.recording.gltf import Export, Parts

_MEDIA_TYPE = "model/gltf-binary"


def models(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield the name of each node of an exported scene that has figures, and a GLB file of these in its frame.

    As the root's frame of the export, that of each model has y upwards.
    """
    export = Export(data)
    for name, figures in export.figures():
        parts = Parts()
        parts.add("nodes", root := {"name": name, "rotation": export.upright})
        taking = export.taking(parts)
        root["children"] = [taking.figure(one) for one in figures]
        yield name, parts.file(scene=0, scenes=[{"nodes": [0]}])


def entity(name: str, model: bytes, time: Timestamp) -> SceneEntity:
    """Return a node's figures as an entity that goes where its frame goes."""
    made = SceneEntity(timestamp=time, frame_id=name, id=name, frame_locked=True)
    one = made.models.add(data=model, media_type=_MEDIA_TYPE)
    one.pose.orientation.w = 1.0
    one.scale.x = one.scale.y = one.scale.z = 1.0
    return made
