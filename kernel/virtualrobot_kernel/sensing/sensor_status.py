"""Status of the sensors of a world, and the components that work for them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from virtualrobot_kernel.components.running import ComponentHandle
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.sensing.range_reader import RangeReader
from virtualrobot_kernel.sensing.reading import SensorState
from virtualrobot_kernel.sensing.sensors import Sensors, data_of
from virtualrobot_kernel.sensing.settings import rate_hertz
from virtualrobot_kernel.world.apply_sensors import sensor_nodes
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, Structure


@dataclass(frozen=True, slots=True)
class Status:
    """Status of a sensor; fields as in the contract's `SensorStatus`."""

    node: Node
    state: SensorState
    fault: str = ""
    rate_hertz: float = 0.0
    readings: int = 0
    missed: int = 0
    mean_reading_seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class AtWork:
    """A component that works for a sensor (by name), or has failed to."""

    sensor: str
    running: ComponentHandle


def statuses(sensors: Sensors, snapshot: Snapshot) -> Iterator[Status]:
    """Yield how the sensors of a snapshot are, in the order of the nodes."""
    workers = sensors.workers
    for node in sensor_nodes(snapshot.structure):
        data = data_of(node)
        try:
            rate = rate_hertz(data, sensors.room.presets)
        except KernelError:
            rate = 0.0  # it cannot read; its fault says why
        worker = workers.get(node.uid)
        if node.uid not in sensors.starts or worker is None or worker.schedule is None:
            yield Status(node, SensorState.STOPPED, rate_hertz=rate)
            continue
        state = SensorState.FAULT if worker.fault else SensorState.RUNNING
        yield Status(node, state, worker.fault, rate, worker.number, worker.missed, worker.mean_seconds)


def at_work(sensors: Sensors, structure: Structure) -> Iterator[AtWork]:
    """Yield the components of sensors."""
    for uid, worker in sensors.workers.items():
        reader = worker.reader
        if uid in structure.nodes and isinstance(reader, RangeReader) and (worker.fault or not worker.ended):
            yield AtWork(structure.nodes[uid].name, reader.caster)
            yield AtWork(structure.nodes[uid].name, reader.model)
