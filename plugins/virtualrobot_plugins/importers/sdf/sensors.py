"""Sensors of links and joints as nodes of a scene file. None of them runs."""

from __future__ import annotations

from typing import Any

from virtualrobot_sdk.gazebo import read_sensor, sensor_tags
from virtualrobot_sdk.xml import Element

from virtualrobot_plugins.importers.sdf.elements import Matrix, Notes, Place, pose_message


def sensor_nodes(
    element: Element, place: Place, model: str, node: str, node_t_element: Matrix, taken: set[str], notes: Notes
) -> list[dict[str, Any]]:
    """Return the sensors in a link or joint, fixed to `node` and called `model.sensor`.

    `taken` holds the names that nodes of the model have, and gets the new ones.
    """
    nodes = []
    for tag in sensor_tags(element):
        inside = place.inside(f"sensor {tag.get('name', '')!r}")
        for sensor in read_sensor(tag, lambda at, why, p=inside: notes.warn(p, at, why)):
            if sensor.relative_to not in ("", element.get("name", "").strip()):
                notes.warn(inside, tag, f"its pose counts from {sensor.relative_to!r}; here it counts from its parent")
            stem = name = f"{model}.{sensor.name}"
            number = 2
            while name in taken:
                name, number = f"{stem}_{number}", number + 1
            taken.add(name)
            pose = pose_message(node_t_element @ sensor.link_t_sensor)
            nodes.append({"name": name, "parent": node, "parent_t_node": pose, sensor.kind: sensor.values})
    return nodes
