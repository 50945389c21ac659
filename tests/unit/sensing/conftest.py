"""The loop of all sensors, with readers made for the test."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.sensing.readers import READERS
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.sensing.sensors import Sensors
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, Node

from tests.unit.sensing.bench import Bench, Fake


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    made: list[tuple[str, Fake]] = []
    wanted: dict[str, Callable[[], Fake]] = {}

    def make(snapshot: Snapshot, node: Node, room: object) -> Fake:
        reader = wanted.get(node.name, Fake)()
        made.append((node.name, reader))
        return reader

    monkeypatch.setitem(READERS, Kind.RANGE_SENSOR, make)
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, 4_000_000))
    sensors = Sensors(world, _Room())  # pyright: ignore[reportArgumentType]
    told: list[Reading] = []
    sensors.subscribe(lambda reading: told.append(reading) if reading is not None else None)
    world.start()
    yield Bench(world, sensors, made, wanted, told)
    sensors.close()
    world.close()


class _Room:
    presets: dict[str, object] = {}  # noqa: RUF012 never changed

    def __init__(self) -> None:
        self.shapes = ShapeLibrary(lambda mesh: ())
        self.solids = CollisionShapes(lambda mesh: ())
