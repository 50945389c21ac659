"""Sensors of a URDF file: what `<gazebo reference="link">` says, as nodes below the links. None of them runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from google.protobuf.json_format import ParseDict, ParseError
from virtualrobot.v1 import nodes_pb2
from virtualrobot_sdk.gazebo import Element, SensorTag, read_sensor, sensor_tags

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.formats.export.names import unique
from virtualrobot_kernel.formats.urdf_elements import Place, read_only
from virtualrobot_kernel.formats.xml import FileWarning, children
from virtualrobot_kernel.messages.sensing import SENSORS
from virtualrobot_kernel.world.structure import Kind, NodeData, NodeSpec


def read_sensors(
    uri: str, root: Element, robot: str, links: Sequence[str], child_of: Mapping[str, str], warnings: list[FileWarning]
) -> tuple[NodeSpec, ...]:
    """Return the sensors of a robot, called `robot.sensor`, in the order of the file.

    What cannot be read is told in `warnings` and left out.

    Args:
        uri: of the file.
        root: its root element.
        robot: the name of the robot's node.
        links: the names of its links; their nodes are `robot.link`.
        child_of: the link behind each joint: where a force sensor of the joint is fixed.
        warnings: takes what is odd.
    """
    nodes: list[NodeSpec] = []
    taken = {f"{robot}.{link}" for link in links}
    for element in children(root, "gazebo"):
        tags = sensor_tags(element)
        if not tags:
            continue
        reference = element.get("reference", "").strip()
        link = reference if reference in links else child_of.get(reference, "")
        if not link:
            place = Place(uri, "gazebo", warnings)
            named = f"reference={reference!r} is no link" if reference else "there is no reference to a link"
            place.warn(element, f"{named}; its sensors are left out")
            continue
        for tag in tags:
            place = Place(uri, f"sensor {tag.get('name', '')!r}", warnings)
            for sensor in read_sensor(tag, place.warn):
                if sensor.relative_to not in ("", reference, link):
                    aside = f"its pose counts from {sensor.relative_to!r}; here it counts from {link!r}"
                    place.warn(tag, aside)
                try:
                    data = _data(sensor)
                except (KernelError, ParseError) as error:
                    place.warn(tag, f"it is left out: {error}")
                    continue
                name = unique(f"{robot}.{sensor.name}", taken)
                taken.add(name)
                pose = read_only(sensor.link_t_sensor)
                nodes.append(NodeSpec(name, Kind(sensor.kind), f"{robot}.{link}", pose, data=data))
    return tuple(nodes)


def _data(sensor: SensorTag) -> NodeData:
    """Return the settings, by the same way and the same checks as those of a scene file."""
    message = ParseDict({sensor.kind: sensor.values}, nodes_pb2.Node())
    return SENSORS[sensor.kind].read(getattr(message, sensor.kind), sensor.name)
