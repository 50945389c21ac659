"""A world in STEPPED mode with sensors whose readers are made for the test."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from virtualrobot_kernel.sensing.reading import Moment, Reading, SensorState
from virtualrobot_kernel.sensing.sensor_status import statuses
from virtualrobot_kernel.sensing.sensors import Sensors
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.sensing import RangeSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Kind, NodeSpec

GUARD = 30.0


@dataclass
class Fake:
    """A reader that says the number of the reading, and what it is told to do."""

    history_seconds: float = 0.0
    deadline_seconds: float = GUARD
    takes_turns: bool = True
    act: Callable[[Moment], object] = lambda moment: None
    moments: list[Moment] = field(default_factory=list)
    closed: threading.Event = field(default_factory=threading.Event)

    def read(self, moment: Moment, kinds: object | None = None) -> int:
        """Do it."""
        self.moments.append(moment)
        self.act(moment)
        return moment.number

    def close(self) -> None:
        """Note it."""
        self.closed.set()


@dataclass
class Bench:
    """A world in STEPPED mode, its sensors, the readers made, and the readings told."""

    world: World
    sensors: Sensors
    made: list[tuple[str, Fake]]
    next: dict[str, Callable[[], Fake]]
    told: list[Reading]

    def do(self, *commands: object) -> Snapshot:
        """Apply commands."""
        return self.world.submit(commands).result(GUARD).snapshot  # pyright: ignore[reportArgumentType]

    def add(self, name: str, parent: str = "world", *, running: bool = False, **fields: object) -> None:
        """Add a sensor."""
        data = RangeSensor(**fields)  # pyright: ignore[reportArgumentType]
        self.do(CreateNodes((NodeSpec(name, Kind.RANGE_SENSOR, parent, data=data, running=running),)))

    def step(self, ticks: int) -> Snapshot:
        """Let time go on."""
        return self.world.step(ticks).result(GUARD)

    def numbers(self, name: str) -> list[tuple[int, int]]:
        """Return number and tick of each reading told of a sensor that ran."""
        return [
            (one.number, one.snapshot.state.tick)
            for one in self.told
            if one.name == name and one.state is SensorState.RUNNING
        ]

    def state(self, name: str) -> tuple[SensorState, str]:
        """Return how a sensor is, and its fault."""
        return next(
            (one.state, one.fault) for one in statuses(self.sensors, self.world.snapshot) if one.node.name == name
        )
