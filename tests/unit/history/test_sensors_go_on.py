"""Sensors of a world that another kernel goes on with read what they would have read, to the last bit of noise."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.collision.geometry import CollisionShapes
from virtualrobot_kernel.history.classes import world_codec
from virtualrobot_kernel.history.codec import same
from virtualrobot_kernel.history.world_image import image_of
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.sensing.reading import Reading
from virtualrobot_kernel.sensing.sensors import Sensors
from virtualrobot_kernel.shapes.shape_library import ShapeLibrary
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import Command, CreateNodes, RunSensors, UpdateNode
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.sensing import MotionSensor, NoiseModel, PoseSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.unit.world.builders import TICK, random_pose

GUARD = 30.0
NOISE = NoiseModel(0.02, 0.1, 0.01)


class Room:
    """As much of a sensing room as motion sensors need."""

    def __init__(self) -> None:
        """Have no shapes."""
        self.presets: dict[str, object] = {}
        self.shapes, self.solids = ShapeLibrary(lambda mesh: ()), CollisionShapes(lambda mesh: ())


def readings(start: Snapshot | None, batches: dict[int, list[Command]], last: int) -> tuple[list[Reading], Snapshot]:
    """Return what is read up to a tick, and the world then; `batches` are commands by tick."""
    clock = Clock(Mode.STEPPED, 1.0, round(TICK * 1e9))
    given = (start.structure, start.state) if start else (None, None)
    world = World(world_poses, MemoryJournal(), clock, *given)
    sensors = Sensors(world, Room())  # pyright: ignore[reportArgumentType]
    told: list[Reading] = []
    sensors.subscribe(lambda reading: told.append(reading) if reading and reading.content is not None else None)
    world.start()
    try:
        for tick in range(world.snapshot.state.tick, last):
            if tick in batches:
                world.submit(batches[tick]).result(GUARD)
            world.step(1).result(GUARD)
        return told, world.snapshot
    finally:
        sensors.close()
        world.close()


def test_noise_goes_on_where_another_kernel_has_ended(rng: np.random.Generator, seed: int) -> None:
    data = MotionSensor(PoseSensor(NOISE, NOISE), 250 / 3, seed)
    slower = MotionSensor(PoseSensor(NOISE, NOISE), 250 / 7, seed)
    batches: dict[int, list[Command]] = {
        4: [CreateNodes((NodeSpec("gps", Kind.MOTION_SENSOR, "world", random_pose(rng), data=data),))],
        9: [RunSensors((), True)],
        20: [UpdateNode("gps", data=slower)],
        60: [UpdateNode("gps", hidden=True)],
    }
    whole, _ = readings(None, batches, 100)
    first, then = readings(None, batches, 52)
    image = world_codec().decode(world_codec().encode(image_of(then.structure, then.state)))
    ended = Snapshot(image.structure, image.state, then.world_t_node, 0, 0.0, TICK)
    rest, _ = readings(ended, batches, 100)
    assert [one.snapshot.state.tick for one in whole] == [12, 15, 18, 23, 30, 37, 44, 51, 58, 65, 72, 79, 86, 93, 100]
    again = [*first, *rest]
    assert [one.snapshot.state.tick for one in again] == [one.snapshot.state.tick for one in whole]
    for one, other in zip(whole, again, strict=True):
        assert same(one.content, other.content) == ""
