"""Digital inputs and outputs: standard ones (0 to 7), configurable ones (0 to 7), and those of the tool (0 and 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.languages.urscript.builtin.arithmetic import whole
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, truth

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_GROUPS = {
    "standard": ("standard one", 0, 7),
    "configurable": ("configurable one", 8, 7),
    "tool": ("one of the tool", 16, 1),
}
"""Words for each group, the bit of its first one, and the number of its last one."""


def _enter(group: str, words: str, shift: int, last: int) -> None:
    def get_input(task: RobotTask, place: Value) -> bool:
        return bool(task.controller.digital_inputs >> whole(place, "n", 0, last) + shift & 1)

    def get_output(task: RobotTask, place: Value) -> bool:
        return bool(task.controller.digital_outputs >> whole(place, "n", 0, last) + shift & 1)

    def set_output(task: RobotTask, place: Value, value: Value) -> None:
        bit = 1 << whole(place, "n", 0, last) + shift
        task.controller.set_outputs(bit, bit if truth(value) else 0)

    get_input.__doc__, get_output.__doc__ = f"Level of a digital input, {words}.", f"Level of an output, {words}."
    set_output.__doc__ = f"Sets a digital output, {words}."
    function(f"get_{group}_digital_in", "n")(get_input)
    function(f"get_{group}_digital_out", "n")(get_output)
    function(f"set_{group}_digital_out", "n, b")(set_output)


for _group, (_words, _shift, _last) in _GROUPS.items():
    _enter(_group, _words, _shift, _last)


def _old(place: Value) -> int:
    """Return the bit of an input or output of the old functions, where 8 and 9 are those of the tool."""
    number = whole(place, "n", 0, 9)
    return number if number < 8 else number + 8


@function("get_digital_in", "n")
def _get_digital_in(task: RobotTask, place: Value) -> bool:
    """Level of a digital input: a standard one (0 to 7), or one of the tool (8 and 9)."""
    return bool(task.controller.digital_inputs >> _old(place) & 1)


@function("get_digital_out", "n")
def _get_digital_out(task: RobotTask, place: Value) -> bool:
    """Level of an output: a standard one (0 to 7), or one of the tool (8 and 9)."""
    return bool(task.controller.digital_outputs >> _old(place) & 1)


@function("set_digital_out", "n, b")
def _set_digital_out(task: RobotTask, place: Value, value: Value) -> None:
    """Sets an output: a standard one (0 to 7), or one of the tool (8 and 9)."""
    bit = 1 << _old(place)
    task.controller.set_outputs(bit, bit if truth(value) else 0)
