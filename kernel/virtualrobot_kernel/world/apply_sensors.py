"""Commands about sensors: start, stop, and what a range sensor is made of."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import RunSensors, SetRangeComponents
from virtualrobot_kernel.world.sensing import CameraSensor, ContactSensor, MotionSensor, RangeSensor
from virtualrobot_kernel.world.structure import Kind, Node, Structure

SENSORS = frozenset({Kind.RANGE_SENSOR, Kind.CAMERA_SENSOR, Kind.CONTACT_SENSOR, Kind.MOTION_SENSOR})


def sensor_node(structure: Structure, name: str) -> Node:
    """Return the sensor called `name`; raise UnknownNameError when there is none."""
    uid = structure.uid_by_name.get(name)
    if uid is None or structure.nodes[uid].kind not in SENSORS:
        raise UnknownNameError("sensor", name, (node.name for node in sensor_nodes(structure)))
    return structure.nodes[uid]


def sensor_nodes(structure: Structure) -> tuple[Node, ...]:
    """Return all sensors in the order of their creation."""
    return tuple(node for node in structure.nodes.values() if node.kind in SENSORS)


def run_sensors(change: Change, command: RunSensors, forward: Forward) -> Change:
    """Start or stop sensors; one that is started gets data of its own, so that whoever watches nodes starts it anew."""
    structure = change.structure
    named = [sensor_node(structure, name) for name in dict.fromkeys(command.sensors)] or sensor_nodes(structure)
    for node in named:
        data = node.data
        assert isinstance(data, RangeSensor | CameraSensor | ContactSensor | MotionSensor)
        if command.running or data.running:
            structure = index.replaced(structure, replace(node, data=replace(data, running=command.running)))
    return replace(change, structure=structure)


def set_range_components(change: Change, command: SetRangeComponents, forward: Forward) -> Change:
    """Give a range sensor other components; it goes on running."""
    node = change.structure.node(command.sensor, Kind.RANGE_SENSOR)
    assert isinstance(node.data, RangeSensor)
    changed = replace(node, data=with_components(node.data, command))
    return replace(change, structure=index.replaced(change.structure, changed))


def with_components(data: RangeSensor, command: SetRangeComponents) -> RangeSensor:
    """Return how a range sensor is set once it has the components of a command."""
    if command.ray_caster is not None:
        data = replace(data, ray_caster=command.ray_caster[0], ray_caster_settings=command.ray_caster[1])
    if command.sensor_model is not None:
        data = replace(data, sensor_model=command.sensor_model[0], sensor_model_settings=command.sensor_model[1])
    return data
