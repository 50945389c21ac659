"""Bench of a link: a kernel in this process, a guarded arm, and a far side that the test plays."""

from __future__ import annotations

from typing import Any

import grpc
from virtualrobot.v1 import (
    collision_pb2,
    driver_pb2,
    geometry_pb2,
    kernel_pb2,
    motion_pb2,
    scene_pb2,
)
from virtualrobot_kernel.kernel import Kernel

from tests.api.asking import IIWA, Refusal, apply, joints, load
from tests.api.leasing import Holder
from tests.drivers.sham_site import ShamProcess, ShamSite
from tests.kernels import Stubs
from tests.waiting import until

GUARD = collision_pb2.COLLISION_MODE_GUARD
EXECUTE, MONITOR = driver_pb2.DRIVER_MODE_EXECUTE, driver_pb2.DRIVER_MODE_MONITOR
SIMULATED = driver_pb2.DRIVER_MODE_SIMULATED
ACTIVE, INACTIVE = driver_pb2.DRIVER_STATE_ACTIVE, driver_pb2.DRIVER_STATE_INACTIVE
ERROR = driver_pb2.DRIVER_STATE_ERROR
FIRST = "lbr_iiwa_joint_1"


class Bench:
    """A kernel whose time follows the wall clock, with a guarded arm, and a client that has leased it."""

    def __init__(self, kernel: Kernel, address: str, site: ShamSite) -> None:
        """Set it up."""
        self.kernel, self.address, self.site = kernel, address, site
        self.alone = self.stubs()
        load(self.alone, IIWA, "arm")
        self.guard(GUARD)
        self.clock(kernel_pb2.CLOCK_MODE_REALTIME)
        self.holder = Holder(self, "arm")  # pyright: ignore[reportArgumentType] what it needs of a kernel is here

    def stubs(self) -> Stubs:
        """Return stubs on a channel of their own."""
        return Stubs(grpc.insecure_channel(self.address))

    def guard(self, mode: collision_pb2.CollisionMode) -> None:
        """Set the collision mode."""
        apply(self.alone, scene_pb2.Command(set_collision_settings=collision_pb2.SetCollisionSettings(mode=mode)))

    def clock(self, mode: kernel_pb2.ClockMode, factor: float = 0.0) -> None:
        """Set the clock."""
        self.alone.kernel.SetClock(kernel_pb2.SetClockRequest(mode=mode, speed_factor=factor))

    def call(self, name: str, **fields: Any) -> Any:  # noqa: ANN401 any answer
        """Make a call of the driver's service with the lease."""
        request = getattr(driver_pb2, f"{name}Request")(**fields)
        return getattr(self.holder.stubs.driver, name)(request, metadata=self.holder.metadata)

    def connect(self, **fields: Any) -> driver_pb2.DriverStatus:  # noqa: ANN401 any field
        """Connect a sham."""
        return self.call("ConnectDriver", **{"robot": "arm", "component": "sham", **fields}).driver

    def mode(self, mode: driver_pb2.DriverMode) -> Any:  # noqa: ANN401 the answer
        """Choose the mode."""
        return self.call("SetDriverMode", robot="arm", mode=mode)

    def move(self, speed: float = 1.0, **positions: float) -> str:
        """Start a move with the lease."""
        return self.holder.start(joints("arm", speed, **positions))

    @property
    def process(self) -> ShamProcess:
        """The newest sham."""
        return self.site.processes[-1]

    @property
    def status(self) -> driver_pb2.DriverStatus:
        """The driver as it is told."""
        return self.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).drivers[0]

    @property
    def cell(self) -> driver_pb2.CellStatus:
        """The cell as it is told."""
        return self.alone.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell

    def motion(self, id: str) -> motion_pb2.Motion:
        """Return a motion as it is."""
        return self.alone.motion.GetMotion(motion_pb2.GetMotionRequest(id=id)).motion

    def await_end(self, id: str) -> motion_pb2.Motion:
        """Return a motion once it has ended."""
        until(lambda: bool(self.motion(id).end_cause) or self.motion(id).phase == motion_pb2.MOTION_PHASE_SUCCEEDED)
        until(lambda: not self.kernel.world.snapshot.state.motions)
        return self.motion(id)

    def joint(self, name: str = FIRST) -> float:
        """Return where a joint of the twin is."""
        now = self.kernel.world.snapshot
        return float(now.state.q[now.structure.robot("arm")[1].coordinates[name].q])


def pose(x: float) -> geometry_pb2.Pose:
    """Return a pose that only shifts."""
    return geometry_pb2.Pose(position=geometry_pb2.Vector3(x=x))


def aspect(refused: Refusal) -> str:
    assert refused.reason == "WRONG_STATE", refused
    return refused.metadata["aspect"]
