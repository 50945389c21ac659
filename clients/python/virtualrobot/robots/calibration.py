"""Calibration of a robot: tool, base and joints from what was measured at the real one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import array_message, array_of, pose_of, vector_of
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix
from virtualrobot.robots.mechanism import JointPositions, Mechanism
from virtualrobot.v1 import calibration_pb2


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ToolCalibration:
    """Tip of a tool that has touched one fixed point, in m.

    Attributes:
        tip: (3,) in the frame of the flange, or of the group's end.
        tip_error: (3,) standard error of each coordinate.
        point: (3,) the point that was touched, in the world's frame.
        residuals: (n,) how far the tip was from it in each posture.
    """

    tip: NDArray[np.float64]
    tip_error: NDArray[np.float64]
    point: NDArray[np.float64]
    residuals: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class BaseCalibration:
    """Place of a robot: `world_t_base` (4x4), and how far each point is off then, `residuals` (n,), in m."""

    world_t_base: Matrix
    residuals: NDArray[np.float64]


@shown
@dataclass(frozen=True, slots=True, eq=False)
class JointCalibration:
    """Offsets of joints: what to add to what the controller tells.

    Attributes:
        offsets: rad or m by joint name.
        errors: standard error of each, by name; NaN where there are no more measurements than unknowns.
        world_t_base: 4x4, where the robot stands with them; as it is where the base was not fitted.
        tip: (3,) the tool centre point in the flange's frame with them, likewise.
        residuals_before: (n,) how far each point was off, in m.
        residuals: (n,) how far each is off now.
    """

    offsets: dict[str, float]
    errors: dict[str, float]
    world_t_base: Matrix
    tip: NDArray[np.float64]
    residuals_before: NDArray[np.float64]
    residuals: NDArray[np.float64]


@checked
class Calibration:
    """Computations of what a robot differs in from its model, by postures and what was measured. Nothing changes.

    Postures are joint values as the controller told them, each by name or in order; joints that are not named stand as
    they are now.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Calibrate a robot, or a group of it."""
        self._mechanism = mechanism
        self._stub = mechanism._services.calibration

    def tool(self, postures: Iterable[JointPositions]) -> ToolCalibration:
        """Return the tip of the tool that touched one fixed point in at least four postures, turned differently.

        Raises:
            InvalidArgumentError: when there are fewer, and when they don't tell where along an axis the tip is.
            UnknownNameError: when the arm has no such joint.

        Example:
            >>> found = arm.calibration.tool([first, second, third, fourth])
            >>> client.scene.add_tool("pointer", arm.flange, tool_center_points={"tip": virtualrobot.pose(*found.tip)})
        """
        asked = calibration_pb2.CalibrateToolRequest(postures=self._postures(postures))
        found = self._stub.CalibrateTool(asked)
        return ToolCalibration(
            vector_of(found.tip), vector_of(found.tip_error), vector_of(found.point), array_of(found.residuals)
        )

    def base(self, postures: Iterable[JointPositions], points: ArrayLike) -> BaseCalibration:
        """Return where the robot stands whose tool centre point was at points (n, 3), m in the world, in n postures.

        Raises:
            InvalidArgumentError: when there are fewer than three, and when they lie on a line.
            UnknownNameError: when the arm has no such joint.

        Example:
            >>> found = arm.calibration.base(postures, points)
            >>> client.scene.set_pose("arm", found.world_t_base)
        """
        asked = calibration_pb2.CalibrateBaseRequest(postures=self._postures(postures), points=array_message(points))
        found = self._stub.CalibrateBase(asked)
        return BaseCalibration(pose_of(found.world_t_base), array_of(found.residuals))

    def joints(
        self,
        postures: Iterable[JointPositions],
        points: ArrayLike,
        *,
        fixed: Sequence[str] = (),
        with_base: bool = False,
        with_tip: bool = False,
    ) -> JointCalibration:
        """Return the offsets of joints with which the tool centre point is where it was measured.

        Args:
            postures: n of them.
            points: (n, 3), where the tool centre point was, m in the world's frame.
            fixed: joints whose offset is 0, as of the first one where the base is fitted, about whose axis both turn.
            with_base: whether the place of the robot is fitted, too.
            with_tip: whether the tool centre point is.

        Raises:
            InvalidArgumentError: when the measurements can't tell some of it apart; `undetermined` in its metadata
                names them.
            UnknownNameError: when the arm has no such joint.

        Example:
            >>> arm.calibration.joints(postures, points, fixed=["joint_1"], with_base=True).offsets
            {'joint_2': ...}
        """
        found = self._stub.CalibrateJoints(
            calibration_pb2.CalibrateJointsRequest(
                postures=self._postures(postures),
                points=array_message(points),
                fixed_joints=fixed,
                with_base=with_base,
                with_tip=with_tip,
            )
        )
        names = list(found.joint_names)
        return JointCalibration(
            dict(zip(names, array_of(found.offsets).tolist(), strict=True)),
            dict(zip(names, array_of(found.offset_errors).tolist(), strict=True)),
            pose_of(found.world_t_base),
            vector_of(found.tip),
            array_of(found.residuals_before),
            array_of(found.residuals),
        )

    def _postures(self, given: Iterable[JointPositions]) -> calibration_pb2.Postures:
        """Return postures as a message: the joints of the chain, those of others don't count."""
        mechanism = self._mechanism
        rows = [mechanism._named(posture) for posture in given]
        names = list(rows[0]) if rows else []
        for place, row in enumerate(rows):
            if row.keys() != rows[0].keys():
                raise InvalidArgumentError(
                    f"posture {place} names {', '.join(row)} and the first one {', '.join(names)}; name the same"
                )
        others = mechanism.coordinates.keys() - mechanism.chain_joint_names
        names = [name for name in names if name not in others]
        positions = np.array([[row[name] for name in names] for row in rows]).reshape(len(rows), len(names))
        return calibration_pb2.Postures(
            robot=mechanism.name, group=mechanism._group, joint_names=names, positions=array_message(positions)
        )
