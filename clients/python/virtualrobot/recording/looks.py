"""Looks of the nodes of a scene that is watched: which have changed, and what the kernel exports of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot.errors import InvalidArgumentError, UnknownNameError
from virtualrobot.v1 import nodes_pb2, scene_pb2


def look_of(node: nodes_pb2.Node) -> bytes:
    """Return all by which a node looks different, to be compared."""
    return nodes_pb2.Node(hidden=node.hidden, figures=node.figures).SerializeToString()


def above(name: str, parents: Mapping[str, str]) -> Iterable[str]:
    """Yield the nodes that a node hangs on, its parent first."""
    while name := parents.get(name, ""):
        yield name


def topmost(names: Collection[str], parents: Mapping[str, str]) -> list[str]:
    """Return those of some nodes that hang on none of the others; what is asked of them holds for all below."""
    wanted = set(names)
    return [name for name in wanted if wanted.isdisjoint(above(name, parents))]


def exported(services: Services, root: str) -> str | None:
    """Return the SHA-256 of what a node and all below it look like, as GLB.

    None where it is gone, or nothing is to be seen there.
    """
    request = scene_pb2.ExportModelRequest(node=root, format=".glb")
    try:
        response = services.scene.ExportModel(request, timeout=LONG_TIMEOUT_SECONDS)
    except (UnknownNameError, InvalidArgumentError):
        return None
    return response.files[0].sha256
