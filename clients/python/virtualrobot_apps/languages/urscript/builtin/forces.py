"""Forces: those on the tool, and the mode in which it gives way to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.emulators.ur.compliance import USUAL_DAMPING
from virtualrobot_apps.emulators.ur.forces import Payload, Unmeasured, moved
from virtualrobot_apps.emulators.ur.kinematics import Floats
from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, numbers
from virtualrobot_apps.languages.urscript.builtin.poses import matrix
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Value, text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_KINDS = (1, 2, 3)
"""Numbers of the ways in which the frame of force mode turns."""

_TOLD = "external_force_torque"
"""Input of RTDE by which forces are told."""
_LEAST_OFTEN = 10.0
"""Frequency (Hz) at which they must be told unless a script watches an input itself, as the manual has it."""


def _measured(what: str, ask: Callable[[], object]) -> None:
    """Do what needs forces; end the script with the reason where nothing measures them."""
    try:
        ask()
    except Unmeasured as error:
        raise ScriptFault(f"{what!r} needs forces, and {error}") from error


def _felt(task: RobotTask) -> list[float]:
    try:
        return task.controller.felt().tolist()
    except Unmeasured:
        return [0.0] * 6


@function("get_tcp_force")
def _get_tcp_force(task: RobotTask) -> list[float]:
    """Force and torque on the tool (N, Nm), in the base's frame; 0 where [nothing](urscript.md#forces) measures."""
    return _felt(task)


@function("force")
def _force(task: RobotTask) -> float:
    """Size of the force on the tool (N); 0 where nothing measures it."""
    return float(np.linalg.norm(_felt(task)[:3]))


@function("zero_ftsensor")
def _zero_ftsensor(task: RobotTask) -> None:
    """Takes the force and torque that the sensor feels now for none."""
    controller = task.controller
    _measured("zero_ftsensor", controller.forces.find)
    _measured("zero_ftsensor", lambda: controller.forces.set_zero(controller.base_t_flange, controller.payload))


def _hear(task: RobotTask, enable: Value, mass: Value, place: Value, center: Value) -> None:
    if not isinstance(enable, bool):
        raise ScriptFault(f"enable is True or False, not {text(enable)}")
    kilograms, where, middle = (
        0.0 if mass is None else number(mass, "sensor_mass"),
        *(
            np.zeros(3) if one is None else np.array(numbers(one, name, 3), dtype=np.float64)
            for one, name in ((place, "sensor_measuring_offset"), (center, "sensor_cog"))
        ),
    )
    if kilograms < 0.0:
        raise ScriptFault(f"sensor_mass is 0 or more, not {text(mass)}")
    controller = task.controller
    controller.forces.hear(Payload(kilograms, middle) if enable else None, where)
    if enable and controller.watchdog is None:
        controller.watch(_TOLD, round(controller.rate / _LEAST_OFTEN), pauses=True)
    elif not enable and controller.watchdog is not None and controller.watchdog.variable == _TOLD:
        controller.watchdog = None


_SENSOR = "enable, sensor_mass=none, sensor_measuring_offset=none, sensor_cog=none"


@function("ft_rtde_input_enable", _SENSOR)
def _ft_rtde_input_enable(task: RobotTask, enable: Value, mass: Value, place: Value, center: Value) -> None:
    """Takes the force on the flange from RTDE's `external_force_torque`, of a sensor with a mass (kg), or no more."""
    _hear(task, enable, mass, place, center)


@function("enable_external_ft_sensor", _SENSOR)
def _enable_external_ft_sensor(task: RobotTask, enable: Value, mass: Value, place: Value, center: Value) -> None:
    """Does what ft_rtde_input_enable does, as it was called before."""
    _hear(task, enable, mass, place, center)


@function("wrench_trans", "T_from_to, w_from")
def _wrench_trans(task: object, between: Value, wrench: Value) -> list[float]:
    """Force and torque, given in a frame, in the frame that `T_from_to` is the pose of there."""
    to_t_from: Floats = np.linalg.inv(matrix(between, "T_from_to")).astype(np.float64)
    return moved(np.array(numbers(wrench, "w_from", 6), dtype=np.float64), to_t_from).tolist()


@function("force_mode", "task_frame, selection_vector, wrench, type, limits")
def _force_mode(task: RobotTask, frame: Value, selection: Value, wrench: Value, kind: Value, limits: Value) -> None:
    """Has the tool [push](urscript.md#forces) by a wrench along the chosen axes of a frame, until end_force_mode."""
    axes = matrix(frame, "task_frame")
    chosen, wanted, fastest = (
        np.array(numbers(value, name, 6), dtype=np.float64)
        for value, name in ((selection, "selection_vector"), (wrench, "wrench"), (limits, "limits"))
    )
    if not np.isin(chosen, (0.0, 1.0)).all():
        raise ScriptFault(f"selection_vector has 0 and 1 alone, and this is {text(selection)}")
    if number(kind, "type") not in _KINDS:
        raise ScriptFault(f"type is 1, 2 or 3, not {text(kind)}")
    if (fastest < 0.0).any():
        raise ScriptFault(f"limits are 0 or more, and this is {text(limits)}")
    controller = task.controller
    if task.loaded.secondary:
        raise ScriptFault("a secondary program (sec) can't move the robot")
    if chosen.any():
        _measured("force_mode", controller.forces.find)
        _measured("force_mode", controller.felt)
    controller.give_way().set(axes, chosen, wanted, int(kind), fastest, task.damping / USUAL_DAMPING / task.gain)


@function("end_force_mode")
def _end_force_mode(task: RobotTask) -> None:
    """Ends the force mode; a move that runs goes on from where the tool is."""
    if task.controller.compliance is not None:
        task.controller.compliance.rest()


@function("force_mode_set_damping", "damping")
def _force_mode_set_damping(task: RobotTask, damping: Value) -> None:
    """Sets the damping of the force mode, 0.025 to begin with; 0 (none) to 1, taken for 0.005 where it is less."""
    if not 0.0 <= number(damping, "damping") <= 1.0:
        raise ScriptFault(f"damping is 0 to 1, not {text(damping)}")
    task.damping = max(damping, USUAL_DAMPING / 5.0)


@function("force_mode_set_gain_scaling", "scaling")
def _force_mode_set_gain_scaling(task: RobotTask, scaling: Value) -> None:
    """Sets the gain of the force mode, 1 to begin with; above 0 to 2."""
    if not 0.0 < number(scaling, "scaling") <= 2.0:
        raise ScriptFault(f"scaling is above 0 and at most 2, not {text(scaling)}")
    task.gain = scaling
