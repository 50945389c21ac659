"""Commands about sensors: start, stop, and the components of a range sensor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.commands import RunSensors, SetRangeComponents
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import SensorStart
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
    """Start or stop sensors; each start has a number of its own, so that one that has a fault is started anew."""
    structure = change.structure
    named = [sensor_node(structure, name) for name in dict.fromkeys(command.sensors)] or sensor_nodes(structure)
    return with_sensors_running(change, (node.uid for node in named), command.running)


def with_sensors_running(change: Change, uids: Iterable[int], running: bool) -> Change:
    """Return the world with sensors started, or stopped. The structure stays as it is."""
    state = change.state
    now, starts = dict(state.running_sensors), state.sensor_starts
    for uid in uids:
        if running:
            starts += 1
            now[uid] = SensorStart(starts, now[uid].tick if uid in now else state.tick)
        else:
            now.pop(uid, None)
    if now == state.running_sensors:
        return change
    return replace(change, state=replace(state, running_sensors=now, sensor_starts=starts))


def set_range_components(change: Change, command: SetRangeComponents, forward: Forward) -> Change:
    """Give a range sensor other components; it goes on running."""
    node = change.structure.node(command.sensor, Kind.RANGE_SENSOR)
    assert isinstance(node.data, RangeSensor)
    changed = replace(node, data=with_components(node.data, command))
    return replace(change, structure=index.replaced(change.structure, changed))


def with_components(data: RangeSensor, command: SetRangeComponents) -> RangeSensor:
    """Return a range sensor's settings with the components of a command."""
    if command.ray_caster is not None:
        data = replace(data, ray_caster=command.ray_caster[0], ray_caster_settings=command.ray_caster[1])
    if command.sensor_model is not None:
        data = replace(data, sensor_model=command.sensor_model[0], sensor_model_settings=command.sensor_model[1])
    return data
