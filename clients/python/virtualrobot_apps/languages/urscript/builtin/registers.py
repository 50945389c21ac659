"""Registers, by which a script and clients of RTDE tell each other values."""

from __future__ import annotations

from typing import TYPE_CHECKING

from virtualrobot_apps.emulators.ur.values import INPUTS, REGISTER
from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, whole
from virtualrobot_apps.languages.urscript.builtin.strings import string
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, truth

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_LAST = 47
"""Number of the last register of whole numbers, and of the last one of others."""


@function("read_input_integer_register", "address")
def _read_input_integer_register(task: RobotTask, address: Value) -> int:
    """Whole number that a client has set; 0 where none has."""
    value = task.controller.inputs.get(f"input_int_register_{whole(address, 'address', 0, _LAST)}", 0)
    return value if isinstance(value, int) else 0


@function("read_input_float_register", "address")
def _read_input_float_register(task: RobotTask, address: Value) -> float:
    """Number that a client has set; 0 where none has."""
    name = f"input_double_register_{whole(address, 'address', 0, _LAST)}"
    value = task.controller.inputs.get(name, 0.0)
    return number(value, name) if isinstance(value, float) else 0.0


@function("read_input_boolean_register", "address")
def _read_input_boolean_register(task: RobotTask, address: Value) -> bool:
    """Truth that a client has set; False where none has. Those below 64 are bits of two numbers."""
    place = whole(address, "address", 0, 127)
    if place >= 64:
        return bool(task.controller.inputs.get(f"input_bit_register_{place}", False))
    bits = task.controller.inputs.get("input_bit_registers0_to_31" if place < 32 else "input_bit_registers32_to_63", 0)
    return isinstance(bits, int) and bool(bits >> place % 32 & 1)


@function("write_output_integer_register", "address, value")
def _write_output_integer_register(task: RobotTask, address: Value, value: Value) -> None:
    """Sets a whole number for clients."""
    place = whole(address, "address", 0, _LAST)
    task.controller.registers[f"output_int_register_{place}"] = whole(value, "value")


@function("write_output_float_register", "address, value")
def _write_output_float_register(task: RobotTask, address: Value, value: Value) -> None:
    """Sets a number for clients."""
    place = whole(address, "address", 0, _LAST)
    task.controller.registers[f"output_double_register_{place}"] = float(number(value, "value"))


@function("write_output_boolean_register", "address, value")
def _write_output_boolean_register(task: RobotTask, address: Value, value: Value) -> None:
    """Sets a truth for clients. Those below 64 are bits of two numbers."""
    place, registers = whole(address, "address", 0, 127), task.controller.registers
    if place >= 64:
        registers[f"output_bit_register_{place}"] = truth(value)
        return
    name = "output_bit_registers0_to_31" if place < 32 else "output_bit_registers32_to_63"
    bit, bits = 1 << place % 32, registers.get(name, 0)
    assert isinstance(bits, int)
    registers[name] = bits | bit if truth(value) else bits & ~bit


@function("read_output_integer_register", "address")
def _read_output_integer_register(task: RobotTask, address: Value) -> Value:
    """Whole number that a script has set; 0 where none has."""
    return task.controller.registers.get(f"output_int_register_{whole(address, 'address', 0, _LAST)}", 0)


@function("read_output_float_register", "address")
def _read_output_float_register(task: RobotTask, address: Value) -> Value:
    """Number that a script has set; 0 where none has."""
    return task.controller.registers.get(f"output_double_register_{whole(address, 'address', 0, _LAST)}", 0.0)


@function("set_flag", "n, b")
def _set_flag(task: RobotTask, place: Value, value: Value) -> None:
    """Sets one of 32 flags, which stay from script to script."""
    bit = 1 << whole(place, "n", 0, 31)
    task.controller.flags = task.controller.flags & ~bit | (bit if truth(value) else 0)


@function("get_flag", "n")
def _get_flag(task: RobotTask, place: Value) -> bool:
    """Level of a flag."""
    return bool(task.controller.flags >> whole(place, "n", 0, 31) & 1)


@function("rtde_set_watchdog", 'variable_name, min_frequency, action="pause"')
def _rtde_set_watchdog(task: RobotTask, variable: Value, frequency: Value, action: Value) -> None:
    """Stops or pauses the script where clients set an input less often; a frequency (Hz) of 0 watches nothing."""
    name, often, what = string(variable, "variable_name"), number(frequency, "min_frequency"), string(action, "action")
    if not (name in INPUTS or (REGISTER.match(name) and name.startswith("input"))):
        raise ScriptFault(f"there is no input {name!r} of RTDE")
    if what not in ("ignore", "pause", "stop"):
        raise ScriptFault(f"action is 'ignore', 'pause' or 'stop', not {what!r}")
    watched = what != "ignore" and often > 0.0
    task.controller.watch(name, max(1, round(task.controller.rate / often)) if watched else 0, what == "pause")
