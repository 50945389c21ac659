"""Motion: joint moves, lines and arcs, and where the robot is."""

from __future__ import annotations

import math
from copy import deepcopy
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from virtualrobot_apps.languages.core.task import here
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.placed import WOBJ
from virtualrobot_apps.languages.rapid.table import function, instruction
from virtualrobot_apps.languages.rapid.world import World

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

_ENDS = r"speeddata Speed \num V | num T, zonedata Zone \num Z, pers tooldata Tool \pers wobjdata WObj"
_Argument: TypeAlias = Any
"""One of `_ENDS`, as `move_ends` takes them."""

_LACKING = "Inpos Corr TLoad"


def move_ends(
    task: RapidTask,
    speed: list[float],
    v: float | None,
    seconds: float | None,
    zone: list[Any],
    z: float | None,
    tool: list[Any],
    tool_index: int,
    wobj: list[Any] | None,
    wobj_index: int,
) -> tuple[list[float], list[Any], list[Any] | None]:
    r"""Use the tool that a move names; return its speed and zone, with the numbers of \V and \Z, and work object."""
    if seconds is not None and not seconds > 0.0:
        raise RapidFault("ERR_ARGVALERR", f"a move takes more than 0 s (T), not {seconds:g}")
    task.world.seconds = seconds
    task.world.use_tool(tool[tool_index], wobj and wobj[wobj_index])
    task.world.wobj = WOBJ if wobj is None else deepcopy(wobj[wobj_index])
    speed = speed if v is None else [v, *speed[1:]]
    zone = zone if z is None else [False, z, 1.5 * z, 1.5 * z, 0.15 * z, 1.5 * z, 0.15 * z]
    return speed, zone, wobj and wobj[wobj_index]


def _degrees(joints: np.ndarray, external: list[float]) -> list[Any]:
    return [np.degrees(joints).tolist(), external]


@instruction("MoveJ", rf"\switch Conc, robtarget ToPoint \identno ID, {_ENDS}", lacking=_LACKING)
def _move_j(
    task: RapidTask, concurrent: bool | None, target: list[Any], number: float | None, *ends: _Argument
) -> None:
    """Moves all joints evenly to a place; with Conc the program goes on at once, with ID others move together."""
    with task.world.move_with(concurrent, number):
        task.world.move_joints_to(target, *move_ends(task, *ends))


@instruction("MoveL", rf"\switch Conc, robtarget ToPoint \identno ID, {_ENDS}", lacking=_LACKING)
def _move_l(
    task: RapidTask, concurrent: bool | None, target: list[Any], number: float | None, *ends: _Argument
) -> None:
    """Moves the tool centre point along a line to a place."""
    with task.world.move_with(concurrent, number):
        task.world.move_line(target, *move_ends(task, *ends))


@instruction("MoveC", rf"\switch Conc, robtarget CirPoint, robtarget ToPoint \identno ID, {_ENDS}", lacking=_LACKING)
def _move_c(
    task: RapidTask,
    concurrent: bool | None,
    via: list[Any],
    target: list[Any],
    number: float | None,
    *ends: _Argument,
) -> None:
    """Moves the tool centre point along an arc through one place to another one."""
    with task.world.move_with(concurrent, number):
        task.world.move_arc(via, target, *move_ends(task, *ends))


@instruction(
    "MoveAbsJ", rf"\switch Conc, jointtarget ToJointPos \identno ID \switch NoEOffs, {_ENDS}", lacking=_LACKING
)
def _move_abs_j(
    task: RapidTask,
    concurrent: bool | None,
    target: list[Any],
    number: float | None,
    no_offsets: bool | None,
    *ends: _Argument,
) -> None:
    """Moves all joints evenly to their positions; the tool counts for the speed alone."""
    with task.world.move_with(concurrent, number):
        speed, zone, _ = move_ends(task, *ends)
        task.world.move_joints(np.radians(target[0]), speed, zone, task.world.axes_of(target[1]))


_SIGNAL = "signaldo Signal, num Value"


@instruction("MoveJDO", rf"robtarget ToPoint \identno ID, {_ENDS}, {_SIGNAL}", lacking=_LACKING)
def _move_j_do(task: RapidTask, target: list[Any], number: float | None, *ends: _Argument) -> None:
    """Moves as MoveJ does, and sets a digital output in the zone, or when the robot is there."""
    *rest, signal, value = ends
    _move_j(task, None, target, number, *rest)
    task.world.set_signal(signal, value)


@instruction("MoveLDO", rf"robtarget ToPoint \identno ID, {_ENDS}, {_SIGNAL}", lacking=_LACKING)
def _move_l_do(task: RapidTask, target: list[Any], number: float | None, *ends: _Argument) -> None:
    """Moves as MoveL does, and sets a digital output as MoveJDO does."""
    *rest, signal, value = ends
    _move_l(task, None, target, number, *rest)
    task.world.set_signal(signal, value)


@instruction("MoveCDO", rf"robtarget CirPoint, robtarget ToPoint \identno ID, {_ENDS}, {_SIGNAL}", lacking=_LACKING)
def _move_c_do(task: RapidTask, via: list[Any], target: list[Any], number: float | None, *ends: _Argument) -> None:
    """Moves as MoveC does, and sets a digital output as MoveJDO does."""
    *rest, signal, value = ends
    _move_c(task, None, via, target, number, *rest)
    task.world.set_signal(signal, value)


@instruction("ConfJ", r"\switch On | switch Off")
def _conf_j(task: RapidTask, on: bool | None, off: bool | None) -> None:
    """Says whether joint moves end in the configuration of their place (on, the default) or in the nearest one."""
    task.world.configurations = not off


@instruction("ConfL", r"\switch On | switch Off")
def _conf_l(task: RapidTask, on: bool | None, off: bool | None) -> None:
    """Says whether a line or arc that ends in another configuration than its place has is told (on, the default)."""
    task.world.linear_configurations = not off


@instruction("SingArea", r"\switch Wrist | switch LockAxis4 | switch Off")
def _sing_area(task: RapidTask, wrist: bool | None, lock: bool | None, off: bool | None) -> None:
    """Says how lines pass singular postures; here they don't, as with Off, which a note tells."""
    if wrist or lock:
        task.world.note(f"{here()}: a line through a singular posture is refused, whatever SingArea says")


@instruction("AccSet", "num Acc, num Ramp", lacking="FinePointRamp")
def _acc_set(task: RapidTask, share: float, ramp: float) -> None:
    """Takes shares of all accelerations and jerks from now on, in percent, 20 and 10 at least."""
    task.world.acceleration_share = min(1.0, max(0.2, share / 100.0))
    task.world.jerk_share = min(1.0, max(0.1, ramp / 100.0))


@instruction("PathAccLim", r"bool AccLim \num AccMax, bool DecelLim \num DecelMax")
def _path_acc_lim(
    task: RapidTask, speeding_up: bool, most: float | None, braking: bool, most_braking: float | None
) -> None:
    """Limits the acceleration of the tool centre point on lines and arcs (m/s²), to the smaller of both numbers."""
    limits = [(speeding_up, most, "AccMax"), (braking, most_braking, "DecelMax")]
    for limited, value, name in limits:
        if limited and (value is None or value < 0.1):
            given = "none" if value is None else f"{value:g}"
            raise RapidFault("ERR_ARGVALERR", f"PathAccLim takes a {name} of 0.1 m/s2 or more, not {given}")
    task.world.acceleration_limit = min(
        (value for limited, value, _ in limits if limited and value is not None), default=math.inf
    )


@instruction("VelSet", "num Override, num Max")
def _vel_set(task: RapidTask, override: float, limit: float) -> None:
    """Takes a share of all speeds from now on, in percent, and limits that of the tool centre point (mm/s)."""
    if not 0.0 < override <= 100.0 or not limit > 0.0:
        raise RapidFault(
            "ERR_ARGVALERR",
            f"VelSet takes more than 0 to 100 percent, and a limit above 0, not {override:g}, {limit:g}",
        )
    task.world.speed_share, task.world.speed_limit = override / 100.0, limit


def _world_of(task: RapidTask, name: str | None) -> World:
    """Return the world of a task, this one's without a name; its robot is looked at as it is.

    A task without a robot looks at the only one that others move.
    """
    if name is None:
        others = [one for one in task.cell.tasks.values() if one.has_robot]
        if task.has_robot or not others:
            return task.world
        if len(others) > 1:
            known = ", ".join(one.name for one in others)
            raise RapidStopped(f"this task moves no robot; say by \\TaskName whose it is to look at: {known}")
        name = others[0].name
    found = task.cell.tasks.get(name.lower())
    if found is None:
        known = ", ".join(one.name for one in task.cell.tasks.values())
        raise RapidStopped(f"there is no task {name!r}; there are: {known}")
    if found is not task:
        task.settle()
    return found.world


@function("CRobT", r"\string TaskName \pers tooldata Tool \pers wobjdata WObj", "robtarget", lacking="TaskRef")
def _c_rob_t(
    task: RapidTask,
    name: str | None,
    tool: list[Any] | None,
    tool_index: int,
    wobj: list[Any] | None,
    index: int,
) -> list[Any]:
    """Place where the robot, or that of another task, is, of a tool (the last moved with) in a work object (wobj0)."""
    world = _world_of(task, name)
    return world.target_now(tool and tool[tool_index], wobj and wobj[index], wait=world is task.own_world)


@function("CJointT", r"\string TaskName", "jointtarget", lacking="TaskRef")
def _c_joint_t(task: RapidTask, name: str | None) -> list[Any]:
    """Positions of the joints, or of those of another task, as they are."""
    world = _world_of(task, name)
    return _degrees(world.joints_now(wait=world is task.own_world), world.axes_told(world.axes_now()))


@function("CPos", r"\pers tooldata Tool \pers wobjdata WObj", "pos")
def _c_pos(task: RapidTask, tool: list[Any] | None, tool_index: int, wobj: list[Any] | None, index: int) -> list[float]:
    """Position where the tool centre point is."""
    return task.world.target_now(tool and tool[tool_index], wobj and wobj[index])[0]


@function("CalcRobT", r"jointtarget Joint_target, pers tooldata Tool \pers wobjdata WObj", "robtarget")
def _calc_rob_t(
    task: RapidTask, joints: list[Any], tool: list[Any], tool_index: int, wobj: list[Any] | None, index: int
) -> list[Any]:
    """Place where joints bring a tool."""
    axes = task.world.axes_of(joints[1])
    return task.world.target_at(np.radians(joints[0]), tool[tool_index], wobj and wobj[index], axes)


@function(
    "CalcJointT", r"robtarget Rob_target, pers tooldata Tool \pers wobjdata WObj", "jointtarget", lacking="ErrorNumber"
)
def _calc_joint_t(
    task: RapidTask, target: list[Any], tool: list[Any], tool_index: int, wobj: list[Any] | None, index: int
) -> list[Any]:
    """Positions of the joints at a place; ERR_ROBLIMIT where none reaches it."""
    return _degrees(task.world.joints_for(target, tool[tool_index], wobj and wobj[index]), list(target[3]))
