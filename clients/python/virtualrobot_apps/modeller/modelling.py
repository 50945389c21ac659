"""Nodes whose shape is a `.solid` file: given one, given another one, and asked for it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from virtualrobot import Client, VirtualRobotError, WrongStateError
from virtualrobot.scene.node import Node
from virtualrobot.v1 import scene_pb2

ENDING = ".solid"
LOOK_SECONDS = 0.2
"""Time (s) from one look at a file that is watched to the next."""


def shaped(client: Client, name: str, file: Path, *, part: bool = False, **where: Any) -> Node:  # noqa: ANN401
    """Return the node of a name with the shape that a file describes: one that is there gets it, else one is added.

    Each is one step of the history. `where` is `pose` and `parent` of a new node, which is a part or environment.

    Raises:
        MalformedFileError: when no body comes of the file; it names the place in it. Nothing is changed.
    """
    figure = client.assets.mesh(file)
    if name in client.scene:
        node = client.scene[name]
        node.set_figures([figure])
        return node
    add = client.scene.add_part if part else client.scene.add_object
    return add(name, [figure], **where)


def described(client: Client, name: str) -> bytes:
    """Return the `.solid` file that the shape of a node is made by.

    Raises:
        UnknownNameError: when there is no such node.
        WrongStateError: when its shape comes of something else.
    """
    (node,) = client.services.scene.GetScene(scene_pb2.GetSceneRequest(names=[name])).nodes
    meshes = [figure.mesh for figure in node.figures if figure.HasField("mesh")]
    found = [mesh.sha256 for mesh in meshes if mesh.uri.endswith(ENDING)]
    if not found:
        others = ", ".join(mesh.uri for mesh in meshes) or "no file"
        raise WrongStateError(f"the shape of {name!r} comes of {others}; only {ENDING} files tell how it was made")
    return client.assets.download(found[0])


def follow(file: Path, change: Callable[[], object], told: Callable[[str], object]) -> None:
    """Call `change` now and whenever a file was saved, until Ctrl-C; `told` takes what is wrong with it later.

    Contents are compared, for a file may be written twice within the time that the system's times tell apart; and only
    contents that two looks find are taken, so that nothing half written is.
    """
    taken = seen = file.read_bytes()
    change()
    while True:
        time.sleep(LOOK_SECONDS)
        try:
            now = file.read_bytes()
        except OSError:
            continue  # editors write another file and rename it
        settled, seen = now == seen, now
        if not settled or now == taken:
            continue
        taken = now
        try:
            change()
        except VirtualRobotError as error:
            told(str(error))
