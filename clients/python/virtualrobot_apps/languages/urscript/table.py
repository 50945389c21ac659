"""Table of URScript's functions: a row for each that works, and the names of those that don't yet.

A row is the Python function that does it, with its parameters in URScript's own words. Check, documentation and tests
read it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from virtualrobot_apps.languages.core.diagnostics import Diagnostics, ProgramError
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.urscript import tree
from virtualrobot_apps.languages.urscript.parser import Parser

Run = TypeVar("Run", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Builtin:
    """A function that comes with the language.

    Attributes:
        name: its name.
        signature: its parameters as a function would declare them; one with a value may be left out.
        parameters: the same, parsed.
        text: the sentence that tells people what it does.
        room: the module that has it.
        waits: it takes time, and is a generator: what it yields is the end of its thread's turn in a cycle.
        run: the Python function, called with the task and each argument, None where it is left out.
    """

    name: str
    signature: str
    parameters: list[tree.Parameter]
    text: str
    room: str
    waits: bool
    run: Callable[..., Any]


BUILTINS: dict[str, Builtin] = {}
"""All that works, by name."""


def function(name: str, signature: str = "", *, waits: bool = False) -> Callable[[Run], Run]:
    """Enter a function; the first line of its docstring tells what it does."""

    def enter(run: Run) -> Run:
        diagnostics = Diagnostics()
        parser = Parser(Source(signature, name), diagnostics)
        parameters = [] if not signature else parser.parameters("newline")
        if len(diagnostics):
            raise ProgramError(diagnostics.sorted())
        told, room = (run.__doc__ or "").partition("\n")[0], run.__module__.rpartition(".")[2]
        BUILTINS[name] = Builtin(name, signature, parameters, told, room, waits, run)
        return run

    return enter


_LACKING = """
analog_io_get_type clear_interpreter conveyor_pulse_decode direct_torque enable_external_ft_sensor
encoder_enable_pulse_decode encoder_enable_set_tick_count encoder_get_tick_count encoder_set_tick_count
encoder_unwind_delta_tick_count end_force_mode end_freedrive_mode end_interpreter end_screw_driving end_teach_mode
eoat_enable force_mode force_mode_example freedrive_mode freedrive_mode_no_incorrect_payload_check ft_rtde_input_enable
get_actual_joint_positions_history get_controller_temp get_conveyor_tick_count get_coriolis_and_centrifugal_torques
get_euromap_input get_euromap_output get_freedrive_status get_jacobian_time_derivative get_joint_temp get_mass_matrix
get_target_joint_accelerations get_target_payload_inertia get_target_tcp_speed_along_path get_target_waypoint
get_tool_accelerometer_reading get_tool_analog_in get_tool_current get_tool_temp high_holdtorque_disable
high_holdtorque_enable interpreter_mode inv modbus_add_signal modbus_delete_signal modbus_get_signal_status
modbus_send_custom_command modbus_set_digital_input_action modbus_set_output_register modbus_set_output_signal
modbus_set_runstate_dependent_choice modbus_set_signal_update_frequency move_to_fixture optimovej optimovel
path_offset_disable path_offset_enable path_offset_set pose_dist position_deviation_warning powerdown read_port_bit
read_port_register request_boolean_from_primary_client request_float_from_primary_client
request_integer_from_primary_client request_string_from_primary_client reset_revolution_counter rpc_factory
screw_driving servoc set_analog_inputrange set_conveyor_tick_count set_euromap_output set_gp_boolean_input_action
set_output_actions_to_default set_pos set_runstate_gp_boolean_output_to_value socket_get_var socket_set_var
stop_conveyor_tracking teach_mode tool_contact_examples tool_wrench_limit_disable tool_wrench_limit_set
track_conveyor_circular track_conveyor_linear transpose triggerGripper wrench_trans write_port_bit write_port_register
zero_ftsensor
"""


def lacking_names() -> frozenset[str]:
    """Return the names of the functions of the manual that are refused."""
    return frozenset(_LACKING.split()) - BUILTINS.keys()
