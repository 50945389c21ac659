"""Variables of RTDE: names, types, and their bytes (Universal Robots, "Real-Time Data Exchange (RTDE) Guide")."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping, Sequence

import numpy as np

CODES = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}
"""Letters of `struct` for each type."""

_OUTPUTS = {
    "DOUBLE": "timestamp speed_scaling target_speed_fraction actual_momentum actual_main_voltage actual_robot_voltage "
    "actual_robot_current tool_output_voltage tool_output_current tool_temperature tcp_force_scalar payload "
    "standard_analog_input0 standard_analog_input1 standard_analog_output0 standard_analog_output1 io_current "
    "euromap67_24V_voltage euromap67_24V_current tool_analog_input0 tool_analog_input1 actual_execution_time",
    "VECTOR6D": "target_q target_qd target_qdd target_current target_moment actual_q actual_qd actual_current "
    "joint_control_output actual_TCP_pose actual_TCP_speed actual_TCP_force target_TCP_pose target_TCP_speed "
    "joint_temperatures actual_joint_voltage payload_inertia ft_raw_wrench actual_current_as_torque "
    "external_force_torque tcp_offset",
    "VECTOR3D": "actual_tool_accelerometer payload_cog elbow_position elbow_velocity tool_accelerometer",
    "VECTOR6INT32": "joint_mode",
    "INT32": "robot_mode safety_mode safety_status tool_mode tool_output_mode",
    "UINT32": "robot_status_bits safety_status_bits runtime_state output_bit_registers0_to_31 "
    "output_bit_registers32_to_63 input_bit_registers0_to_31 input_bit_registers32_to_63 tool_analog_input_types "
    "analog_io_types",
    "UINT64": "actual_digital_input_bits actual_digital_output_bits",
    "UINT8": "tool_digital_output0_mode tool_digital_output1_mode",
}
_INPUTS = {
    "UINT32": "speed_slider_mask input_bit_registers0_to_31 input_bit_registers32_to_63",
    "DOUBLE": "speed_slider_fraction standard_analog_output_0 standard_analog_output_1",
    "UINT8": "standard_digital_output_mask standard_digital_output configurable_digital_output_mask "
    "configurable_digital_output tool_digital_output_mask tool_digital_output standard_analog_output_mask "
    "standard_analog_output_type",
    "VECTOR6D": "external_force_torque",
}
OUTPUTS = {name: kind for kind, names in _OUTPUTS.items() for name in names.split()}
"""Type of each variable that the controller tells."""
INPUTS = {name: kind for kind, names in _INPUTS.items() for name in names.split()}
"""Type of each variable that clients set."""
REGISTER = re.compile(r"(input|output)_(bit|int|double)_register_(\d+)\Z")
_REGISTERS = {"bit": ("BOOL", range(64, 128)), "int": ("INT32", range(48)), "double": ("DOUBLE", range(48))}


def type_of(name: str, inputs: bool) -> str:
    """Return the type of a variable, `NOT_FOUND` where clients can't set it (`inputs`) or it isn't told."""
    if match := REGISTER.match(name):
        kind, numbers = _REGISTERS[match[2]]
        there = int(match[3]) in numbers and not (inputs and match[1] == "output")
        return kind if there else "NOT_FOUND"
    return (INPUTS if inputs else OUTPUTS).get(name, "NOT_FOUND")


def layout(kinds: Sequence[str]) -> struct.Struct:
    """Return the layout of values of these types, in the network's byte order."""
    return struct.Struct(">" + "".join(CODES[kind] for kind in kinds))


def pack(names: Sequence[str], kinds: Sequence[str], form: struct.Struct, values: Mapping[str, object]) -> bytes:
    """Return the bytes of these variables; what `values` lacks is 0."""
    flat: list[object] = []
    for name, kind in zip(names, kinds, strict=True):
        value = values.get(name, 0)
        if kind.startswith("VECTOR"):
            count = int(kind[6])
            flat += np.broadcast_to(np.asarray(value), (count,)).tolist()
        else:
            flat.append(value)
    return form.pack(*flat)


def unpack(names: Sequence[str], kinds: Sequence[str], form: struct.Struct, data: bytes) -> dict[str, object]:
    """Return values by name, vectors as tuples."""
    flat, values, at = form.unpack(data), {}, 0
    for name, kind in zip(names, kinds, strict=True):
        count = int(kind[6]) if kind.startswith("VECTOR") else 1
        values[name] = flat[at : at + count] if kind.startswith("VECTOR") else flat[at]
        at += count
    return values
