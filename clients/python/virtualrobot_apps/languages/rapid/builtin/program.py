"""Program and pendant: what is told, optional arguments and clocks."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.values import Clock, value_text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask


@function("Present", "any OptPar", "bool")
def _present(task: object, value: Any) -> bool:  # noqa: ANN401 any value of RAPID
    """TRUE where an optional argument was given."""
    return value is not None


@instruction("TPWrite", r"string String \num Num | bool Bool | pos Pos | orient Orient | dnum Dnum")
def _tp_write(task: RapidTask, text: str, *more: Any) -> None:  # noqa: ANN401 values of several types
    """Writes a line on the pendant, with a value behind it."""
    task.settle()
    task.write(text + "".join(value_text(one) for one in more if one is not None))


@instruction("TPErase")
def _tp_erase(task: RapidTask) -> None:
    """Clears the pendant; here what was written stays."""
    task.settle()


@instruction("ErrWrite", r"\switch W | switch I, string Header, string Reason \string RL2 \string RL3 \string RL4")
def _err_write(task: RapidTask, warning: bool | None, information: bool | None, *lines: str | None) -> None:
    """Writes a message of several lines into the log and on the pendant."""
    task.settle()
    kind = "warning" if warning else "information" if information else "error"
    task.write(f"{kind}: {'; '.join(line for line in lines if line)}")


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


@instruction("ClkReset", "var clock Clock")
def _clk_reset(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Sets a clock to 0."""
    task.settle()
    holder[index].reset()


@instruction("ClkStart", "var clock Clock")
def _clk_start(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Starts a clock."""
    task.settle()
    holder[index].start()


@instruction("ClkStop", "var clock Clock")
def _clk_stop(task: RapidTask, holder: list[Clock], index: int) -> None:
    """Stops a clock."""
    task.settle()
    holder[index].stop()


@function("ClkRead", r"var clock Clock", "num", lacking="HighRes")
def _clk_read(task: RapidTask, holder: list[Clock], index: int) -> float:
    """Time of a clock in seconds of the simulation."""
    task.settle()
    return holder[index].read()
