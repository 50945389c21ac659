"""Descartes of ROS-Industrial on an IRB 2400, from the package tesseract-robotics of PyPI (Apache; not in the extra).

It has an interpreter of its own, since its modules were built for numpy below 2: TESSERACT_PYTHON names the Python
(3.8 to 3.11) of an environment with `pip install 'numpy<2' tesseract-robotics`; where it is not there the rows say so.
Its example robot is in the folder that TESSERACT_SUPPORT_DIR names:
https://github.com/tesseract-robotics/tesseract, `tesseract_support`.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PROFILE, NAMESPACE = "seam", "DescartesMotionPlannerTask"
NEEDED = "TESSERACT_PYTHON", "TESSERACT_SUPPORT_DIR"


def is_there() -> bool:
    """Return whether the package and its robot are there."""
    return all(name in os.environ for name in NEEDED)


def searched(seams: list[NDArray[np.float64]], rotations: int) -> list[tuple[float, float | None]]:
    """Return how long the search took (s) along each seam (n, 4, 4), and a joint's greatest step (rad), or None."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "seams.npy"
        np.save(file, np.array(seams))
        command = [os.environ["TESSERACT_PYTHON"], __file__, str(file), str(rotations)]
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return [tuple(one) for one in json.loads(told.splitlines()[-1])]


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
    from tesseract_robotics.tesseract_common import Isometry3d

    return Isometry3d(np.ascontiguousarray(frame))


def _joints(language: Any, instruction: Any) -> NDArray[np.float64]:  # noqa: ANN401  tesseract's own types
    move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
    state = language.WaypointPoly_as_StateWaypointPoly(move.getWaypoint())
    return np.asarray(state.getPosition()).ravel()


if __name__ == "__main__":
    peer = Descartes(int(sys.argv[2]))
    print(json.dumps([peer.seconds(frames) for frames in np.load(sys.argv[1])]))
