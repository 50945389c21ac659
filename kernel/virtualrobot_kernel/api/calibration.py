"""CalibrationService: what postures and measured points say of tools, bases and joints, computed in worker threads."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.v1 import calibration_pb2, calibration_pb2_grpc, geometry_pb2

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.robots import group_selection
from virtualrobot_kernel.messages.values import array, array_message, pose_message, stamp, vector_message
from virtualrobot_kernel.planning.calibration import calibrate_base, calibrate_joints, calibrate_tool
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

MOST_POSTURES = 10_000
"""Greatest number of postures in one call."""


class CalibrationServicer(calibration_pb2_grpc.CalibrationServiceServicer):
    """Servicer of CalibrationService."""

    def __init__(self, kernel: KernelServices) -> None:
        """Serve from the kernel."""
        self._kernel = kernel

    async def CalibrateTool(
        self, request: calibration_pb2.CalibrateToolRequest, context: object
    ) -> calibration_pb2.CalibrateToolResponse:
        """Tell where a tool's tip is."""
        snapshot = self._kernel.world.snapshot
        found = await self._kernel.in_worker(partial(calibrate_tool, **_asked(snapshot, request.postures)))
        return calibration_pb2.CalibrateToolResponse(
            stamp=stamp(snapshot),
            tip=vector_message(found.tip),
            tip_error=vector_message(found.tip_errors),
            point=vector_message(found.point),
            residuals=array_message(found.residuals),
        )

    async def CalibrateBase(
        self, request: calibration_pb2.CalibrateBaseRequest, context: object
    ) -> calibration_pb2.CalibrateBaseResponse:
        """Tell where a robot stands."""
        snapshot = self._kernel.world.snapshot
        asked = _asked(snapshot, request.postures)
        points = _points(request.points, len(asked["postures"]))
        found = await self._kernel.in_worker(partial(calibrate_base, points=points, **asked))
        return calibration_pb2.CalibrateBaseResponse(
            stamp=stamp(snapshot),
            world_t_base=pose_message(found.world_t_base),
            residuals=array_message(found.residuals),
        )

    async def CalibrateJoints(
        self, request: calibration_pb2.CalibrateJointsRequest, context: object
    ) -> calibration_pb2.CalibrateJointsResponse:
        """Tell how far joints are from what their controller says."""
        snapshot = self._kernel.world.snapshot
        asked = _asked(snapshot, request.postures)
        calibrate = partial(
            calibrate_joints,
            points=_points(request.points, len(asked["postures"])),
            fixed=tuple(request.fixed_joints),
            with_base=request.with_base,
            with_tip=request.with_tip,
            **asked,
        )
        found = await self._kernel.in_worker(calibrate)
        return calibration_pb2.CalibrateJointsResponse(
            stamp=stamp(snapshot),
            joint_names=found.joint_names,
            offsets=array_message(found.offsets),
            offset_errors=array_message(found.errors),
            world_t_base=pose_message(found.world_t_base),
            tip=vector_message(found.tip),
            residuals_before=array_message(found.before),
            residuals=array_message(found.residuals),
        )


def _asked(snapshot: Snapshot, message: calibration_pb2.Postures) -> dict[str, Any]:
    """Return the arguments that say which robot was in which postures."""
    postures = array(message.positions, (None, None), "postures.positions").astype(np.float64)
    if len(postures) > MOST_POSTURES:
        raise KernelError(
            f"{len(postures)} postures are too many; give at most {MOST_POSTURES} at a time",
            reason=Reason.TOO_LARGE,
            field="postures.positions",
        )
    return {
        "snapshot": snapshot,
        "robot": snapshot.structure.node(message.robot, Kind.ROBOT),
        "joint_names": tuple(message.joint_names),
        "postures": postures,
        "group": group_selection(message.group, "postures.group"),
    }


def _points(message: geometry_pb2.NumericArray, count: int) -> NDArray[np.float64]:
    """Return points (n, 3), as many as there are postures."""
    return array(message, (count, 3), "points").astype(np.float64)
