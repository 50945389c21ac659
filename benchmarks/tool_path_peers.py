"""Descartes of ROS-Industrial on an IRB 2400, from the package tesseract-robotics of PyPI (Apache; not in the extra).

`pip install tesseract-robotics` (Python 3.8 to 3.11; its modules were built for numpy below 2); where it is not there
the rows say so. Its example robot is in the folder that TESSERACT_SUPPORT_DIR names:
https://github.com/tesseract-robotics/tesseract, `tesseract_support`.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import os
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from virtualrobot.geometry import quaternion_of

PROFILE, NAMESPACE = "seam", "DescartesMotionPlannerTask"


def is_there() -> bool:
    """Return whether the package and its robot are there."""
    return find_spec("tesseract_robotics") is not None and "TESSERACT_SUPPORT_DIR" in os.environ


class Descartes:
    """Ladder search of Descartes, with all turns of the tool about its z, without collisions."""

    def __init__(self, rotations: int) -> None:
        """Load the robot; each frame has this many rotations."""
        from tesseract_robotics import tesseract_common as common
        from tesseract_robotics import tesseract_motion_planners_descartes as descartes
        from tesseract_robotics.tesseract_command_language import ProfileDictionary
        from tesseract_robotics.tesseract_environment import Environment

        folder = Path(os.environ["TESSERACT_SUPPORT_DIR"])
        self._env: Any = Environment()
        files = (common.FilesystemPath(str(folder / f"urdf/abb_irb2400.{end}")) for end in ("urdf", "srdf"))
        if not self._env.init(*files, common.GeneralResourceLocator()):
            raise RuntimeError(f"tesseract can't load the IRB 2400 of {folder}")
        self._manipulator: Any = common.ManipulatorInfo()
        self._manipulator.tcp_frame = "tool0"
        self._manipulator.manipulator = "manipulator"
        self._manipulator.manipulator_ik_solver = "OPWInvKin"
        self._manipulator.working_frame = "base_link"
        profile = descartes.DescartesDefaultPlanProfileD()
        profile.target_pose_fixed = False
        profile.target_pose_sample_axis = np.array([0.0, 0.0, 1.0])
        profile.target_pose_sample_resolution = 2.0 * np.pi / rotations
        profile.target_pose_sample_min, profile.target_pose_sample_max = -np.pi, np.pi - 2.0 * np.pi / rotations
        profile.enable_collision = profile.enable_edge_collision = False
        profile.allow_collision = True
        self._profiles: Any = ProfileDictionary()
        self._profiles.addProfile(NAMESPACE, PROFILE, descartes.cast_DescartesPlanProfileD(profile))
        self._planner: Any = descartes.DescartesMotionPlannerD(NAMESPACE)

    def seconds(self, frames: NDArray[np.float64]) -> tuple[float, float | None]:
        """Return how long a search along frames (n, 4, 4) took (s), and the greatest step of a joint (rad); or None."""
        from tesseract_robotics import tesseract_command_language as language
        from tesseract_robotics.tesseract_motion_planners import PlannerRequest

        program = language.CompositeInstruction()
        program.setManipulatorInfo(self._manipulator)
        for frame in frames:
            place = language.CartesianWaypoint(_isometry(frame))
            way = language.CartesianWaypointPoly_wrap_CartesianWaypoint(place)
            move = language.MoveInstruction(way, language.MoveInstructionType_LINEAR, PROFILE, self._manipulator)
            program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
        request = PlannerRequest()
        request.instructions, request.env, request.profiles = program, self._env, self._profiles
        began = time.perf_counter()
        response = self._planner.solve(request)
        seconds = time.perf_counter() - began
        if not response.successful:
            return seconds, None
        joints = np.array([_joints(language, one) for one in response.results.flatten()])
        return seconds, float(np.abs(np.diff(joints, axis=0)).max())


def _isometry(frame: NDArray[np.float64]) -> Any:  # noqa: ANN401  tesseract's own type
    from tesseract_robotics.tesseract_common import Isometry3d, Quaterniond, Translation3d

    x, y, z, w = quaternion_of(frame).tolist()
    return Isometry3d.Identity() * Translation3d(*frame[:3, 3].tolist()) * Quaterniond(w, x, y, z)


def _joints(language: Any, instruction: Any) -> NDArray[np.float64]:  # noqa: ANN401  tesseract's own types
    move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
    state = language.WaypointPoly_as_StateWaypointPoly(move.getWaypoint())
    return np.asarray(state.getPosition()).ravel()
