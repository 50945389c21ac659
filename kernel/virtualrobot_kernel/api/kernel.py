"""KernelService: the kernel's description, its clock, and its end."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from pathlib import Path
from tempfile import TemporaryDirectory

from virtualrobot.v1 import kernel_pb2, kernel_pb2_grpc
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.api.author import person
from virtualrobot_kernel.api.clock_holds import ClockHolds
from virtualrobot_kernel.api.convert.states import CLOCK, MODES
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.limits import described
from virtualrobot_kernel.api.stepping import Stepping
from virtualrobot_kernel.api.token import ROLES
from virtualrobot_kernel.api.token_table import CALLER
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.formats.models import MODEL_FORMATS
from virtualrobot_kernel.messages.values import finite, stamp
from virtualrobot_kernel.version import VERSION
from virtualrobot_kernel.world.past_world import PastWorld

MOST_REPORT_BYTES = 100 * 1000 * 1000
"""Greatest size of the journal's entries in a report where nobody says another one."""

CHUNK_BYTES = 1024 * 1024

CAPABILITIES = (
    "assets",
    "clock.realtime",
    "clock.stepped",
    "history",
    "leases",
    "motion.circular",
    "motion.group",
    "motion.joint_trajectory",
    "motion.linear",
    "motion.point_to_point",
    "motion.setpoints",
    "motion.tool_state",
    "plugins",
    "report",
    "scene.bundle",
    "signals",
    "tokens",
    "viewer",
)


class KernelServicer(kernel_pb2_grpc.KernelServiceServicer):
    """Servicer of KernelService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel
        self._stepping = Stepping(kernel)
        self._holds = ClockHolds(kernel.world)

    async def GetInfo(self, request: kernel_pb2.GetInfoRequest, context: object) -> kernel_pb2.GetInfoResponse:
        """Tell versions, limits and capabilities."""
        url = self._kernel.viewer_url()
        return kernel_pb2.GetInfoResponse(
            version=VERSION,
            api_version="virtualrobot.v1",
            capabilities=[name for name in CAPABILITIES if name != "viewer" or url],
            model_formats=dict.fromkeys((*MODEL_FORMATS, *self._kernel.importers.endings)),
            kinematics=sorted(self._kernel.catalog.offers(ComponentKind.KINEMATICS)),
            max_message_bytes=self._kernel.limits.message_bytes,
            max_asset_bytes=self._kernel.assets.limit_bytes,
            viewer_url=url,
            process_id=os.getpid(),
            role=ROLES.write(CALLER.get().role),
            token_name=CALLER.get().name,
            limits=[
                kernel_pb2.Limit(name=name, value=getattr(self._kernel.limits, name), description=text)
                for name, _, text in described()
            ],
        )

    async def GetClock(self, request: kernel_pb2.GetClockRequest, context: object) -> kernel_pb2.GetClockResponse:
        """Tell how time runs."""
        world = self._kernel.world
        return kernel_pb2.GetClockResponse(stamp=stamp(world.snapshot), clock=CLOCK.write(world.clock))

    async def SetClock(self, request: kernel_pb2.SetClockRequest, context: object) -> kernel_pb2.SetClockResponse:
        """Change how time runs."""
        mode = MODES.read(request.mode, "mode")
        world = self._kernel.world
        factor = finite(request.speed_factor, "speed_factor") or world.clock.speed_factor
        snapshot = await asyncio.wrap_future(world.set_clock(mode, factor))
        self._holds.forget()
        return kernel_pb2.SetClockResponse(stamp=stamp(snapshot), clock=CLOCK.write(world.clock))

    async def HoldClock(
        self, request_iterator: AsyncIterator[kernel_pb2.HoldClockRequest], context: object
    ) -> AsyncIterator[kernel_pb2.HoldClockResponse]:
        """Let time be stepped until the client ends the call or is gone; then what its steps have moved stops."""
        async with self._holds.held(person(context)) as snapshot:
            try:
                yield kernel_pb2.HoldClockResponse(stamp=stamp(snapshot), clock=CLOCK.write(self._kernel.world.clock))
                async for _ in request_iterator:
                    pass
            finally:
                self._stepping.end_setpoints(context)

    async def WatchClock(
        self, request: kernel_pb2.WatchClockRequest, context: object
    ) -> AsyncIterator[kernel_pb2.WatchClockResponse]:
        """Tell how time runs, again and again."""
        world = self._kernel.world
        async for snapshot in self._kernel.publications.snapshots(request.max_rate_hertz, 1.0):
            yield kernel_pb2.WatchClockResponse(stamp=stamp(snapshot), clock=CLOCK.write(world.clock))

    async def SeekClock(self, request: kernel_pb2.SeekClockRequest, context: object) -> kernel_pb2.SeekClockResponse:
        """Go to another moment of a replay."""
        world = self._kernel.world
        if not isinstance(world, PastWorld):
            raise KernelError(
                "time of a world that runs goes forwards only; `virtualrobot replay` shows what was",
                reason=Reason.WRONG_STATE,
            )
        snapshot = await asyncio.wrap_future(world.seek(request.tick))
        return kernel_pb2.SeekClockResponse(stamp=stamp(snapshot), clock=CLOCK.write(world.clock))

    async def StepClock(self, request: kernel_pb2.StepClockRequest, context: object) -> kernel_pb2.StepClockResponse:
        """Set what is given, advance time by a number of ticks or until an event, and tell what is then."""
        return await self._stepping.step(request, context)

    async def GetReport(
        self, request: kernel_pb2.GetReportRequest, context: object
    ) -> AsyncIterator[kernel_pb2.GetReportResponse]:
        """Give the report of a fault, piece by piece."""
        most = request.max_journal_bytes or MOST_REPORT_BYTES
        with TemporaryDirectory(prefix="virtualrobot-report-") as place:
            archive = Path(place) / "report.zip"
            await self._kernel.in_worker(self._kernel.report, archive, most)
            with open(archive, "rb") as file:
                while data := file.read(CHUNK_BYTES):
                    yield kernel_pb2.GetReportResponse(data=data)

    async def Shutdown(self, request: kernel_pb2.ShutdownRequest, context: object) -> kernel_pb2.ShutdownResponse:
        """End the kernel once this call is answered."""
        asyncio.get_running_loop().call_later(0.05, self._kernel.shut_down)
        return kernel_pb2.ShutdownResponse()
