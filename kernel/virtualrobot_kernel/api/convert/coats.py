"""Coats: messages to values and back."""

from __future__ import annotations

import numpy as np
from virtualrobot.v1 import geometry_pb2, view_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import GREATEST, array, array_message, check_enum
from virtualrobot_kernel.sensing.coats import Coat, Legend, Shown, Skin
from virtualrobot_kernel.sensing.color_maps import ColorMap, palette
from virtualrobot_kernel.world.structure import Structure


def coat_of(message: view_pb2.Coat, structure: Structure) -> Coat:
    """Return the coat of a message; raises KernelError for an unknown node, and for arrays that are none."""
    node = structure.node(message.node)
    check_enum(message, "color_map")
    vertices = array(message.vertices, (None, 3), "coat.vertices")
    if len(far := np.flatnonzero(np.abs(vertices).max(axis=1, initial=0.0) > GREATEST)):
        raise KernelError(f"coat.vertices must be within {GREATEST:g} m; row {far[0]} is not", field="coat.vertices")
    faces = array(message.faces, (None, 3), "coat.faces").astype(np.int64)
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise KernelError(
            f"coat.faces has the rows {faces.min()} to {faces.max()}, and there are {len(vertices)} vertices: rows are "
            f"0 to {len(vertices) - 1}",
            field="coat.faces",
        )
    given = np.frombuffer(message.values, np.uint8)
    values = given if len(given) else np.zeros(len(vertices), np.uint8)
    color_map = ColorMap(message.color_map or ColorMap.VIRIDIS.value)
    legend = Legend(color_map, message.low, message.high, message.unit, message.title or message.name)
    return Coat(message.name, node.uid, Skin(vertices.astype(np.float32), faces.astype(np.int32)), values, legend)


def changes(before: Shown, now: Shown, structure: Structure) -> view_pb2.WatchCoatsResponse:
    """Return what differs between the coats that were told before and those that there are now."""
    response = view_pb2.WatchCoatsResponse(removed_names=[name for name in before if name not in now])
    for name, coat in now.items():
        old = before.get(name)
        if old is None or not coat.is_repainted(old):
            response.coats.append(_message(coat, structure))
        elif coat is not old and len(rows := np.flatnonzero(coat.values != old.values)):
            first, end = int(rows[0]), int(rows[-1]) + 1
            response.values.append(view_pb2.CoatValues(name=name, first=first, values=coat.values[first:end].tobytes()))
    return response


def _message(coat: Coat, structure: Structure) -> view_pb2.Coat:
    legend, skin = coat.legend, coat.skin
    node = structure.nodes.get(coat.uid)
    return view_pb2.Coat(
        name=coat.name,
        node=node.name if node else "",
        node_uid=coat.uid,
        vertices=array_message(skin.vertices, geometry_pb2.NUMERIC_TYPE_FLOAT32),
        faces=array_message(skin.faces, geometry_pb2.NUMERIC_TYPE_INT32),
        values=coat.values.tobytes(),
        color_map=view_pb2.ColorMap.Name(legend.color_map.value),
        low=legend.low,
        high=legend.high,
        unit=legend.unit,
        title=legend.title,
        palette=palette(legend.color_map).tobytes(),
    )
