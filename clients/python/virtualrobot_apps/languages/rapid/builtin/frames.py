"""Frames: where places are counted from, and by what they are displaced. Lengths are mm."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.frames import matrix_of, pose_of
from virtualrobot_apps.languages.rapid.table import function, instruction

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@function("CTool", "", "tooldata", lacking="TaskRef TaskName")
def _c_tool(task: RapidTask) -> list[Any]:
    """Tool of the last move; tool0 before the first one."""
    return deepcopy(task.world.tool)


@function("CWObj", "", "wobjdata", lacking="TaskRef TaskName")
def _c_w_obj(task: RapidTask) -> list[Any]:
    """Work object of the last move; wobj0 before the first one."""
    return deepcopy(task.world.wobj)


@instruction("GripLoad", "pers loaddata Load")
def _grip_load(task: RapidTask, load: list[Any], index: int) -> None:
    """Tells the load that the tool holds; it doesn't count here."""
    task.settle()


@instruction("PDispSet", "pose DispFrame")
def _p_disp_set(task: RapidTask, pose: list[Any]) -> None:
    """Displaces all places by a pose from now on."""
    task.world.displacement = matrix_of(pose)


@instruction("PDispOff")
def _p_disp_off(task: RapidTask) -> None:
    """Displaces places no more."""
    task.world.displacement = np.eye(4)


@instruction("PDispOn", r"\switch Rot \robtarget ExeP, robtarget ProgPoint, pers tooldata Tool \pers wobjdata WObj")
def _p_disp_on(
    task: RapidTask,
    turned: bool | None,
    reached: list[Any] | None,
    programmed: list[Any],
    tool: list[Any],
    tool_index: int,
    wobj: list[Any] | None,
    index: int,
) -> None:
    """Displaces all places from now on so that a programmed one is where the robot is, or at ExeP; with Rot turned."""
    task.world.displacement = np.eye(4)
    there = reached or task.world.target_now(tool[tool_index], wobj and wobj[index])
    now, before = matrix_of(there), matrix_of(programmed)
    displacement = np.eye(4)
    if turned:
        displacement = now @ np.linalg.inv(before)
    else:
        displacement[:3, 3] = now[:3, 3] - before[:3, 3]
    task.world.displacement = displacement


@function("ORobT", r"robtarget OrgPoint \switch InPDisp | switch InEOffs", "robtarget")
def _o_rob_t(task: RapidTask, place: list[Any], displaced: bool | None, offset: bool | None) -> list[Any]:
    """Place in the frame of the work object, of one that is displaced; with InPDisp or InEOffs only by the other one.

    External axes have no offsets here.
    """
    if displaced:
        return deepcopy(place)
    return [*pose_of(task.world.displacement @ matrix_of(place)), *deepcopy(place[2:])]


@function("DefFrame", "robtarget NewP1, robtarget NewP2, robtarget NewP3", "pose", lacking="Origin")
def _def_frame(task: object, first: list[Any], second: list[Any], third: list[Any]) -> list[Any]:
    """Frame by three places: its origin is the first, its x goes to the second, the third is on the side of its y."""
    origin, along, side = (np.array(one[0], dtype=float) for one in (first, second, third))
    x = along - origin
    z = np.cross(x, side - origin)
    if np.linalg.norm(x) < 1e-6 or np.linalg.norm(z) < 1e-6 * np.linalg.norm(x):
        raise RapidFault("ERR_FRAME", "the three places are on one line")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2], frame[:3, 3] = x, np.cross(z, x), z, origin / 1000.0
    return pose_of(frame)


@instruction("EOffsOff")
def _e_offs_off(task: RapidTask) -> None:
    """Takes offsets of external axes away; the robot has none."""


@instruction("MotionSup", r"\switch On | switch Off \num TuneValue")
def _motion_sup(task: RapidTask, on: bool | None, off: bool | None, share: float | None) -> None:
    """Sets how a controller feels collisions by its motors; nothing of the kind is simulated."""
    if share is not None and not 0.0 < share <= 300.0:
        raise RapidFault("ERR_ARGVALERR", f"TuneValue is a percentage up to 300, not {share:g}")
