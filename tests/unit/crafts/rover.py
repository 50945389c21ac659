"""A rover of two driven wheels on a planar or floating base, in a world of its own with real components."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.crafts.crafts import Crafts
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Clock, Mode
from virtualrobot_kernel.world.commands import (
    Command,
    CreateNodes,
    SetCraft,
    SetSetpoint,
    StartSetpointMotion,
)
from virtualrobot_kernel.world.craft_data import Craft, CraftDrive
from virtualrobot_kernel.world.figures import Box, Figure
from virtualrobot_kernel.world.journal import MemoryJournal
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, LinkData, NodeSpec, RobotData

from tests.unit.world.builders import link, shifted
from tests.unit.world.test_store import GUARD
from tests.unit.world.test_store import TICK as NANOSECONDS

TRACK, RADIUS = 0.5, 0.1
WHEEL = JointLimits(velocity=20.0, acceleration=40.0, jerk=400.0)
Y = (0.0, 1.0, 0.0)

DRIVES = (CraftDrive("left_wheel", "left"), CraftDrive("right_wheel", "right"))
TWO_WHEELS = Craft("differential", {"track_meters": TRACK, "wheel_radius_meters": RADIUS}, DRIVES)


def rover(craft: Craft | None = TWO_WHEELS, base: JointType = JointType.PLANAR) -> CreateNodes:
    """Return a rover, a box of 0.6 x 0.4 x 0.2 m on its wheels."""
    hull = NodeSpec(
        "rover.hull",
        Kind.LINK,
        "rover",
        shifted(z=0.1),
        figures=(Figure(Box((0.6, 0.4, 0.2))),),
        data=LinkData(Joint("base", base, (0.0, 0.0, 1.0))),
    )
    wheels = (
        link(f"rover.{side}", "rover.hull", Joint(side, JointType.CONTINUOUS, Y, WHEEL), shifted(y=sign * TRACK / 2.0))
        for side, sign in (("left", 1.0), ("right", -1.0))
    )
    return CreateNodes((NodeSpec("rover", Kind.ROBOT, data=RobotData(craft=craft)), hull, *wheels))


@dataclass(frozen=True)
class Yard:
    """A world whose time goes on by steps, and its crafts."""

    world: World
    crafts: Crafts

    def do(self, *commands: Command) -> tuple[int | str, ...]:
        """Apply commands and return what they created."""
        return self.world.submit(commands).result(GUARD).created

    def step(self, ticks: int = 1) -> Snapshot:
        """Let time go on."""
        return self.world.step(ticks).result(GUARD)

    def drive(self, *speeds: float, joints: tuple[str, ...] = ("left", "right"), timeout: float = 60.0) -> str:
        """Give the joints of the rover speeds (rad/s) that they shall have; return the motion."""
        (id,) = self.do(StartSetpointMotion("rover", joints, SetpointMode.VELOCITY, timeout))
        self.do(SetSetpoint(str(id), speeds))
        return str(id)

    def choose(self, craft: Craft | None) -> None:
        """Make the rover another craft."""
        self.do(SetCraft("rover", craft))

    @property
    def base(self) -> np.ndarray:
        """Return x, y and heading of the rover (m, rad)."""
        snapshot = self.world.snapshot
        pose = snapshot.world_t(snapshot.structure.node("rover.hull").uid)
        return np.array([pose[0, 3], pose[1, 3], np.arctan2(pose[1, 0], pose[0, 0])])


@contextmanager
def yard(*commands: Command) -> Iterator[Yard]:
    """Begin a world with some commands; it ends with the context."""
    world = World(world_poses, MemoryJournal(), Clock(Mode.STEPPED, 1.0, NANOSECONDS))
    crafts = Crafts(world, Catalog())
    world.start()
    try:
        made = Yard(world, crafts)
        if commands:
            made.do(*commands)
        yield made
    finally:
        world.close()
        crafts.close()
