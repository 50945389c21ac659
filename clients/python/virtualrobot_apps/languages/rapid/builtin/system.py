"""System: date and time of the day, operating mode, and what the controller calls itself."""

from __future__ import annotations

from datetime import datetime
from importlib.metadata import version
from typing import TYPE_CHECKING

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS
from virtualrobot_apps.languages.rapid.table import function

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@function("CDate", "", "string")
def _c_date(task: RapidTask) -> str:
    """Date of the day as year-month-day."""
    task.settle()
    return datetime.now().strftime("%Y-%m-%d")


@function("CTime", "", "string")
def _c_time(task: RapidTask) -> str:
    """Time of the day as hours:minutes:seconds."""
    task.settle()
    return datetime.now().strftime("%H:%M:%S")


@function(
    "GetTime", r"\switch WDay | switch Year | switch Month | switch Day | switch Hour | switch Min | switch Sec", "num"
)
def _get_time(task: RapidTask, *asked: bool | None) -> float:
    """Part of the date or the time of the day; of the week Monday is 1."""
    task.settle()
    now = datetime.now()
    parts = (now.isoweekday(), now.year, now.month, now.day, now.hour, now.minute, now.second)
    found = [float(part) for part, wanted in zip(parts, asked, strict=True) if wanted]
    if not found:
        raise RapidFault("ERR_ARGVALERR", r"GetTime needs one of \WDay, \Year, \Month, \Day, \Hour, \Min, \Sec")
    return found[0]


@function("OpMode", "", "symnum")
def _op_mode(task: RapidTask) -> float:
    """Operating mode: OP_AUTO."""
    return CONSTANTS["OP_AUTO"][1]


@function("RunMode", r"\switch Main", "symnum")
def _run_mode(task: RapidTask, main: bool | None) -> float:
    """Running mode: RUN_CONT_CYCLE."""
    return CONSTANTS["RUN_CONT_CYCLE"][1]


@function("MaxRobSpeed", "", "num")
def _max_rob_speed(task: RapidTask) -> float:
    """Speed of vmax, in mm/s."""
    return CONSTANTS["vmax"][1][0]


@function("RobOS", "", "bool")
def _rob_os(task: RapidTask) -> bool:
    """FALSE: this is no controller of a real robot."""
    return False


@function("RobName", "", "string")
def _rob_name(task: RapidTask) -> str:
    """Name of the robot."""
    return task.world.robot.name


@function(
    "GetSysInfo",
    r"\switch SerialNo | switch SWVersion | switch RobotType | switch CtrlId | switch LanIp | switch SystemName",
    "string",
    lacking="CtrlLang SWVersionName",
)
def _get_sys_info(task: RapidTask, *asked: bool | None) -> str:
    """Words about the system: the robot's name, the version of VirtualRobot, its address, or `virtualrobot`."""
    if asked[1]:
        return f"VirtualRobot {version('virtualrobot')}"
    if asked[2]:
        return task.world.robot.name
    return "127.0.0.1" if asked[4] else "virtualrobot"
