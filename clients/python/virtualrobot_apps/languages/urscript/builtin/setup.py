"""Settings with which programs of PolyScope begin: analog inputs and outputs, the tool, gravity, actions.

What a setting would change is told by RTDE, or the setting is taken where it is what an emulated arm is anyway; others
are refused by their value.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, numbers, whole
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, text, truth

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_UPRIGHT = (0.0, 0.0, 9.82)
_ACTIONS = {"standard": 7, "configurable": 7, "tool": 1}
"""Number of the last input of each group."""


def _only(name: str, value: Value, taken: object, why: str) -> None:
    if value != taken or isinstance(value, bool) is not isinstance(taken, bool):
        raise ScriptFault(f"{name} of {text(value)} can't be used here yet: {why}")


@function("get_standard_analog_in", "n")
def _get_analog_in(task: RobotTask, place: Value) -> float:
    """Level of an analog input, 0 or 1 (V)."""
    return task.controller.analog_inputs[whole(place, "n", 0, 1)]


@function("get_standard_analog_out", "n")
def _get_analog_out(task: RobotTask, place: Value) -> float:
    """Level of an analog output, 0 or 1, as a share from 0 to 1."""
    return task.controller.analog_shares[whole(place, "n", 0, 1)]


@function("set_standard_analog_out", "n, f")
def _set_analog_out(task: RobotTask, place: Value, share: Value) -> None:
    """Sets an analog output, 0 or 1, to a share from 0 to 1 of 10 V, or of 4 to 20 mA."""
    output = whole(place, "n", 0, 1)
    if not 0.0 <= number(share, "f") <= 1.0:
        raise ScriptFault(f"f is from 0 to 1, not {text(share)}")
    task.controller.analog_shares[output] = float(share)


for _old, _signature, _run in (
    ("get_analog_in", "n", _get_analog_in),
    ("get_analog_out", "n", _get_analog_out),
    ("set_analog_out", "n, f", _set_analog_out),
):
    function(_old, _signature)(_run)


@function("set_standard_analog_input_domain", "port, domain")
def _set_input_domain(task: RobotTask, port: Value, domain: Value) -> None:
    """Takes 1, volts, for an analog input, 0 or 1: that is what inputs are here."""
    whole(port, "port", 0, 1)
    _only("a domain", domain, 1, "an analog input is a voltage, and 1 is taken")


@function("set_analog_outputdomain", "port, domain")
def _set_output_domain(task: RobotTask, port: Value, domain: Value) -> None:
    """Makes an analog output, 0 or 1, a current (0, 4 to 20 mA) or a voltage (1, 0 to 10 V)."""
    task.controller.set_output_domain(whole(port, "port", 0, 1), whole(domain, "domain", 0, 1) == 1)


@function("set_tool_analog_input_domain", "port, domain")
def _set_tool_domain(task: RobotTask, port: Value, domain: Value) -> None:
    """Sets the kind of an analog input of the tool, 0 or 1, which RTDE tells: a current (0) or a voltage (1)."""
    bit, told = whole(port, "port", 0, 1), task.controller.tool
    types = int(told.get("tool_analog_input_types", 0)) & ~(1 << bit)
    told["tool_analog_input_types"] = types | whole(domain, "domain", 0, 1) << bit


@function("set_tool_voltage", "voltage")
def _set_tool_voltage(task: RobotTask, voltage: Value) -> None:
    """Sets the supply of the tool, which RTDE tells: 0, 12 or 24 V."""
    if number(voltage, "voltage") not in (0, 12, 24):
        raise ScriptFault(f"voltage is 0, 12 or 24, not {text(voltage)}")
    task.controller.tool["tool_output_voltage"] = float(voltage)


@function("set_tool_output_mode", "mode")
def _set_tool_output_mode(task: RobotTask, mode: Value) -> None:
    """Sets what the outputs of the tool are, which RTDE tells: signals (0), or a supply of two pins (1)."""
    task.controller.tool["tool_output_mode"] = whole(mode, "mode", 0, 1)


@function("set_tool_digital_output_mode", "n, mode")
def _set_tool_digital_output_mode(task: RobotTask, place: Value, mode: Value) -> None:
    """Sets the kind of an output of the tool, 0 or 1, which RTDE tells: sinking (1), sourcing (2) or both (3)."""
    task.controller.tool[f"tool_digital_output{whole(place, 'n', 0, 1)}_mode"] = whole(mode, "mode", 1, 3)


@function("set_tool_communication", "enabled, baud_rate, parity, stop_bits, rx_idle_chars, tx_idle_chars")
def _set_tool_communication(task: RobotTask, enabled: Value, *line: Value) -> None:
    """Takes False, by which the tool has no serial line; whatever it would be like."""
    for one, name in zip(line, ("baud_rate", "parity", "stop_bits", "rx_idle_chars", "tx_idle_chars"), strict=True):
        number(one, name)
    if truth(enabled):
        raise ScriptFault("a serial line of the tool can't be used here yet, and False is taken")


@function("set_gravity", "d")
def _set_gravity(task: RobotTask, direction: Value) -> None:
    """Takes [0, 0, 9.82], an arm that stands upright, however it is mounted: an emulated arm knows no weight."""
    if np.abs(np.subtract(numbers(direction, "d", 3), _UPRIGHT)).max() > 0.05:
        raise ScriptFault(f"gravity of {text(direction)} can't be used here yet: [0, 0, 9.82] is taken")


@function("set_safety_mode_transition_hardness", "type")
def _set_hardness(task: RobotTask, kind: Value) -> None:
    """Takes 1, by which the robot changes from one safety mode to another one softly, as it does here."""
    _only("a hardness", kind, 1, "the robot stops softly, and 1 is taken")


@function("set_input_actions_to_default")
def _set_actions(task: RobotTask) -> None:
    """Leaves inputs as they are: none has an action of its own."""


def _enter(group: str, last: int) -> None:
    def set_action(task: RobotTask, place: Value, action: Value) -> None:
        whole(place, "n", 0, last)
        _only("an action", action, "default", "inputs have none, and 'default' is taken")

    def set_state(task: RobotTask, place: Value, state: Value) -> None:
        whole(place, "outputId", 0, last)
        _only("a state", state, 0, "an output keeps its level when a program ends, and 0 is taken")

    set_action.__doc__ = "Takes 'default', by which an input has no action of its own."
    set_state.__doc__ = "Takes 0, by which an output keeps its level when a program begins or ends."
    function(f"set_{group}_digital_input_action", "n, action")(set_action)
    function(f"set_runstate_{group}_digital_output_to_value", "outputId, state")(set_state)


for _group, _last in _ACTIONS.items():
    _enter(_group, _last)
