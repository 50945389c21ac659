"""DriverService: real robots, how they go together with their twins, and the stop of the cell."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from dataclasses import replace

from virtualrobot.v1 import driver_pb2, driver_pb2_grpc, geometry_pb2
from virtualrobot_sdk.drivers import About, Mode, Pace, Safety
from virtualrobot_sdk.drivers.shared import State

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.lease_table import CARRIED
from virtualrobot_kernel.drivers.conditions import refused
from virtualrobot_kernel.drivers.link import LinkMode, Status
from virtualrobot_kernel.drivers.twin import Asked, ControllerJoint
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import EnumTable
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.values import finite, stamp
from virtualrobot_kernel.world.commands import ReleaseCell, StopCell
from virtualrobot_kernel.world.state import CellStop
from virtualrobot_kernel.world.structure import Kind

MODES = EnumTable(LinkMode, driver_pb2.DriverMode)
STATES = EnumTable(State, driver_pb2.DriverState)
CONTROLLER_MODES = EnumTable(Mode, driver_pb2.ControllerMode)
SAFETIES = EnumTable(Safety, driver_pb2.ControllerSafety)
PACES = EnumTable(Pace, driver_pb2.ControllerPace)

LONGEST_REASON = 200
"""Greatest number of characters of a stop's reason."""


class DriverServicer(driver_pb2_grpc.DriverServiceServicer):
    """Servicer of DriverService. What waits for a controller does so in worker threads; a stop waits for nothing."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def ConnectDriver(
        self, request: driver_pb2.ConnectDriverRequest, context: object
    ) -> driver_pb2.ConnectDriverResponse:
        """Start a driver and connect it, in a worker thread."""
        asked = _asked(request)
        self._check_lease(request.robot)
        status = await self._kernel.in_worker(self._kernel.links.connect, request.robot, asked)
        return driver_pb2.ConnectDriverResponse(stamp=self._stamp(), driver=message(status))

    async def DisconnectDriver(
        self, request: driver_pb2.DisconnectDriverRequest, context: object
    ) -> driver_pb2.DisconnectDriverResponse:
        """Bring the robot to rest and end its driver, in a worker thread."""
        self._check_lease(request.robot)
        status = await self._kernel.in_worker(self._kernel.links.disconnect, request.robot)
        return driver_pb2.DisconnectDriverResponse(stamp=self._stamp(), driver=message(status))

    async def SetDriverMode(
        self, request: driver_pb2.SetDriverModeRequest, context: object
    ) -> driver_pb2.SetDriverModeResponse:
        """Choose how robot and twin go together, in a worker thread."""
        mode = MODES.read(request.mode, "mode")
        uid = self._check_lease(request.robot)
        self._kernel.links.status(request.robot)  # one without a driver needs no lease first
        if mode is LinkMode.EXECUTE and not any(
            uid in lease.robots for lease in self._kernel.leases.held if lease.token in CARRIED.get()
        ):
            raise refused(request.robot, "lease", "the call carries no lease of it; lease it first")
        status, moved = await self._kernel.in_worker(self._kernel.links.set_mode, request.robot, mode)
        return driver_pb2.SetDriverModeResponse(
            stamp=self._stamp(), driver=message(status), twin_moved=() if moved is None else moved.tolist()
        )

    async def ResetDriver(
        self, request: driver_pb2.ResetDriverRequest, context: object
    ) -> driver_pb2.ResetDriverResponse:
        """Clear a fault at the controller, in a worker thread."""
        self._check_lease(request.robot)
        status = await self._kernel.in_worker(self._kernel.links.reset, request.robot)
        return driver_pb2.ResetDriverResponse(stamp=self._stamp(), driver=message(status))

    async def GetDrivers(self, request: driver_pb2.GetDriversRequest, context: object) -> driver_pb2.GetDriversResponse:
        """Tell all drivers as they are."""
        snapshot = self._kernel.world.snapshot
        drivers = map(message, self._kernel.links.statuses(snapshot))
        return driver_pb2.GetDriversResponse(stamp=stamp(snapshot), drivers=drivers, cell=self._cell())

    async def WatchDrivers(
        self, request: driver_pb2.WatchDriversRequest, context: object
    ) -> AsyncIterator[driver_pb2.WatchDriversResponse]:
        """Tell all drivers as they are, again and again."""
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz):
            drivers = map(message, self._kernel.links.statuses(snapshot))
            yield driver_pb2.WatchDriversResponse(stamp=stamp(snapshot), drivers=drivers, cell=self._cell())

    async def StopCell(self, request: driver_pb2.StopCellRequest, context: object) -> driver_pb2.StopCellResponse:
        """Stop all robots: real ones at once and from this thread, all with the world."""
        stop = CellStop(person(context), request.reason[:LONGEST_REASON] or "stopped", time.time())
        self._kernel.links.stop_real(stop)
        await asyncio.wrap_future(self._kernel.submit([StopCell(stop)], context))
        return driver_pb2.StopCellResponse(stamp=self._stamp(), cell=self._cell())

    async def ReleaseCell(
        self, request: driver_pb2.ReleaseCellRequest, context: object
    ) -> driver_pb2.ReleaseCellResponse:
        """End a stop."""
        release = self._kernel.submitting(context, self._kernel.links.release)
        await asyncio.wrap_future(release([ReleaseCell()]))
        return driver_pb2.ReleaseCellResponse(stamp=self._stamp(), cell=self._cell())

    def _check_lease(self, robot: str) -> int:
        """Return the uid of a robot that the call may move; raise KernelError where others have leased it."""
        snapshot = self._kernel.world.snapshot
        node = snapshot.structure.node(robot, Kind.ROBOT)
        self._kernel.leases.check(snapshot, [node.uid], CARRIED.get())
        return node.uid

    def _stamp(self) -> geometry_pb2.Stamp:
        return stamp(self._kernel.world.snapshot)

    def _cell(self) -> driver_pb2.CellStatus:
        stop, (address, key) = self._kernel.links.stop, self._kernel.links.stopper
        told = driver_pb2.CellStatus(stopper_address=address, stopper_key=key)
        if stop is not None:
            told.stopped, told.reason, told.stopped_by = True, stop.reason, stop.by
            told.stop_time.FromNanoseconds(round(stop.wall_time * 1e9))
        return told


def _asked(request: driver_pb2.ConnectDriverRequest) -> Asked:
    """Return what a request asks for; raise KernelError, which names the field, for what makes no sense."""
    if not request.component:
        raise KernelError("component is empty; name the driver's component", field="component")
    asked = Asked(
        request.component,
        settings(request.settings, "settings"),
        tuple(ControllerJoint(one.joint, one.reversed, one.offset) for one in request.joints),
        without_watchdog=request.without_watchdog,
    )
    given = {
        field: finite(getattr(request, name), name)
        for field, name in (
            ("lead", "lead_seconds"),
            ("following_warning", "following_warning"),
            ("following_limit", "following_limit"),
        )
        if request.HasField(name)
    }
    return replace(asked, **given)


def message(status: Status) -> driver_pb2.DriverStatus:
    """Return the message of a driver as it is."""
    link, report = status.link, status.report
    told = driver_pb2.DriverStatus(
        robot=status.robot,
        component=link.asked.component,
        mode=MODES.write(link.mode),
        state=STATES.write(link.state),
        text=link.words.text,
        code=link.words.code,
        clears=link.words.clears,
        controller=_controller(link.about),
        joint_names=link.twin.names,
        following_warning=link.asked.following_warning,
        following_limit=link.asked.following_limit,
        follows_badly=link.follows_badly,
        outputs=link.outputs,
        lead_seconds=link.asked.lead,
        process_id=link.process.pid,
        halted=link.halted,
    )
    if report is not None:
        told.controller_mode = CONTROLLER_MODES.write(report.mode)
        told.controller_safety = SAFETIES.write(report.safety)
        told.positions.extend(report.q)
        told.velocities.extend(report.v)
        told.outside_limits.extend(link.twin.outside(report.q))
        if link.is_played:
            told.following_error.extend(report.error)
        told.speed_scaling = report.speed_scaling
        told.inputs = report.inputs
        told.play_rate = report.rate if link.is_played else 0.0
        told.played_tick = max(report.tick, 0)
        told.cycles, told.skipped_cycles = report.cycles, report.skipped
        told.lateness_seconds = report.lateness_ns * 1e-9
    return told


def _controller(about: About) -> driver_pb2.ControllerDescription:
    return driver_pb2.ControllerDescription(
        joint_count=about.joints,
        rate_hertz=about.rate,
        pace=PACES.write(about.pace),
        watchdog_seconds=about.watchdog,
        model=about.model,
        version=about.version,
        serial=about.serial,
        has_speed_scaling=about.speed_scaling,
        input_count=about.inputs,
        output_count=about.outputs,
    )
