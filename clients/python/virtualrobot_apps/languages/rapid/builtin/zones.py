"""World zones: volumes and ranges of joints, and what happens while the robot is in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.table import instruction
from virtualrobot_apps.languages.rapid.zones import Shape, box, cylinder, joints_between, outside, sphere

if TYPE_CHECKING:
    from virtualrobot_apps.languages.rapid.task import RapidTask

_SHAPE = r"\switch Inside | switch Outside, inout shapedata Shape"
_Argument: TypeAlias = Any
"""One of what an instruction is given, in the order of its table's row."""
_ZONE = r"\switch Temp | switch Stat, inout wztemporary WorldZone"


def _define(given: Sequence[Any], make: Callable[..., Shape]) -> None:
    """Define a shape by what an instruction is given: `_SHAPE`, and then what `make` takes."""
    _, out, holder, index, *values = given
    shape = make(*values)
    holder[index] = outside(shape) if out else shape


def _needed(shape: Shape | None) -> Shape:
    """Return a shape; raises a fault where it is not defined."""
    if shape is None:
        raise RapidFault("ERR_ARGVALERR", "the shape is not defined yet; define it by WZBoxDef or its like")
    return shape


@instruction("WZBoxDef", f"{_SHAPE}, pos LowPoint, pos HighPoint")
def _box(task: RapidTask, *given: _Argument) -> None:
    """Defines a box between two opposite corners, in RAPID's world."""
    _define(given, box)


@instruction("WZCylDef", f"{_SHAPE}, pos CentrePoint, num Radius, num Height")
def _cylinder(task: RapidTask, *given: _Argument) -> None:
    """Defines a cylinder that stands on a place, or hangs from it where its height is below 0."""
    _define(given, cylinder)


@instruction("WZSphDef", f"{_SHAPE}, pos CentrePoint, num Radius")
def _sphere(task: RapidTask, *given: _Argument) -> None:
    """Defines a sphere around a place."""
    _define(given, sphere)


@instruction("WZHomeJointDef", f"{_SHAPE}, jointtarget MiddleJointVal, jointtarget DeltaJointVal")
def _home(task: RapidTask, *given: _Argument) -> None:
    """Defines a range of joints around positions; a joint whose difference is 9E9 counts not."""

    def around(middle: list[Any], delta: list[Any]) -> Shape:
        at, by = np.array(middle[0]), np.array(delta[0])
        return joints_between((at - by).tolist(), (at + by).tolist())

    _define(given, around)


@instruction("WZLimJointDef", f"{_SHAPE}, jointtarget LowJointVal, jointtarget HighJointVal")
def _limits(task: RapidTask, *given: _Argument) -> None:
    """Defines a range of joints between positions; a joint with a bound of 9E9 counts not."""
    _define(given, lambda low, high: joints_between(low[0], high[0]))


@instruction("WZDOSet", rf"{_ZONE} \switch Inside | switch Before, shapedata Shape, signaldo Signal, num SetValue")
def _set(
    task: RapidTask,
    temporary: bool | None,
    stationary: bool | None,
    holder: list[Any],
    index: int,
    inside: bool | None,
    before: bool | None,
    shape: Shape | None,
    signal: str,
    value: float,
) -> None:
    """Sets an output while the robot is in a shape, and to its opposite elsewhere; Before counts as Inside here."""
    task.settle()
    world = task.world
    on = bool(world.typed(signal, value))
    holder[index] = [task.zones.add(_needed(shape), world.signal_name(signal), on)]


@instruction("WZLimSup", f"{_ZONE}, shapedata Shape")
def _supervise(
    task: RapidTask,
    temporary: bool | None,
    stationary: bool | None,
    holder: list[Any],
    index: int,
    shape: Shape | None,
) -> None:
    """Ends the program, the robot braking on its path, as soon as it is in a shape."""
    task.settle()
    holder[index] = [task.zones.add(_needed(shape))]


@instruction("WZEnable", "inout wztemporary WorldZone")
def _enable(task: RapidTask, holder: list[Any], index: int) -> None:
    """Lets a temporary zone count again."""
    task.settle()
    task.zones.enable(holder[index][0], True)


@instruction("WZDisable", "inout wztemporary WorldZone")
def _disable(task: RapidTask, holder: list[Any], index: int) -> None:
    """Lets a temporary zone count no more."""
    task.settle()
    task.zones.enable(holder[index][0], False)


@instruction("WZFree", "inout wztemporary WorldZone")
def _free(task: RapidTask, holder: list[Any], index: int) -> None:
    """Forgets a temporary zone, where it is one."""
    task.settle()
    task.zones.free(holder[index][0])
    holder[index] = [0.0]
