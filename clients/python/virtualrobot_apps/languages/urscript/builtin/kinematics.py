"""State of the robot: where it is, its kinematics, its tool and its load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.kinematics import Floats, NoPosture
from virtualrobot_apps.emulators.ur.moves import JointMove, LineMove, TangentArc
from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, numbers, whole
from virtualrobot_apps.languages.urscript.builtin.poses import matrix, pose
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Pose, Value, text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_STEP = 1e-4
"""Time (s) over which the Jacobian's change is taken."""
_TURN = 2.0 * np.pi
"""Range (rad) of each joint to either side, as the data sheets have it."""


def _target(task: RobotTask) -> Floats:
    controller = task.controller
    return controller.target if controller.moving else controller.body.read()[0]


def _forward(task: RobotTask, positions: Floats, tcp: Floats | None) -> Pose:
    return pose(kinematics.forward(task.controller.model, positions, tcp))


def _twist(task: RobotTask, positions: Floats, velocities: Floats) -> list[float]:
    controller = task.controller
    return (kinematics.jacobian(controller.model, positions, controller.tcp) @ velocities).tolist()


@function("get_actual_joint_positions")
def _get_actual_joint_positions(task: RobotTask) -> list[float]:
    """Positions of the joints (rad)."""
    return task.controller.body.read()[0].tolist()


@function("get_joint_positions")
def _get_joint_positions(task: RobotTask) -> list[float]:
    """Positions of the joints (rad), as get_actual_joint_positions says them."""
    return task.controller.body.read()[0].tolist()


@function("get_actual_joint_positions_history", "steps=0")
def _get_actual_joint_positions_history(task: RobotTask, steps: Value) -> list[float]:
    """Positions of the joints (rad) so many cycles ago."""
    past = task.controller.past
    return past[-1 - whole(steps, "steps", 0, len(past) - 1)].tolist()


@function("tool_contact", "direction=none")
def _tool_contact(task: RobotTask, direction: Value) -> int:
    """Cycles since a robot of a kernel touches something that is in a direction, or, by 0, anywhere; else 0."""
    way = np.zeros(3) if direction is None else np.array(numbers(direction, "direction", 6)[:3], dtype=np.float64)
    controller = task.controller
    if controller.touches is None or not controller.touches.watched():
        said = "needs a robot of a kernel that is watched: 'virtualrobot collision mode monitor', before it is emulated"
        raise ScriptFault(f"'tool_contact' {said}")
    return controller.touches.cycles(way)


@function("get_target_joint_positions")
def _get_target_joint_positions(task: RobotTask) -> list[float]:
    """Positions (rad) where the joints shall be."""
    return _target(task).tolist()


@function("get_actual_joint_speeds")
def _get_actual_joint_speeds(task: RobotTask) -> list[float]:
    """Velocities of the joints (rad/s)."""
    return task.controller.body.read()[1].tolist()


@function("get_target_joint_speeds")
def _get_target_joint_speeds(task: RobotTask) -> list[float]:
    """Velocities (rad/s) that the joints shall have."""
    return task.controller.velocity.tolist()


@function("get_target_joint_accelerations")
def _get_target_joint_accelerations(task: RobotTask) -> list[float]:
    """Accelerations (rad/s^2) that the joints shall have."""
    return task.controller.acceleration.tolist()


@function("get_actual_tcp_pose")
def _get_actual_tcp_pose(task: RobotTask) -> Pose:
    """Pose of the tool."""
    return _forward(task, task.controller.body.read()[0], task.controller.tcp)


@function("get_target_tcp_pose")
def _get_target_tcp_pose(task: RobotTask) -> Pose:
    """Pose where the tool shall be."""
    return _forward(task, _target(task), task.controller.tcp)


@function("get_target_waypoint")
def _get_target_waypoint(task: RobotTask) -> Pose:
    """Pose of the tool at the end of the move that runs; as get_target_tcp_pose where none does."""
    move = task.controller.move
    if isinstance(move, JointMove):
        return _forward(task, move.goal, task.controller.tcp)
    return pose(move.goal) if isinstance(move, (LineMove, TangentArc)) else _get_target_tcp_pose(task)


@function("get_actual_tool_flange_pose")
def _get_actual_tool_flange_pose(task: RobotTask) -> Pose:
    """Pose of the flange."""
    return _forward(task, task.controller.body.read()[0], None)


@function("get_actual_tcp_speed")
def _get_actual_tcp_speed(task: RobotTask) -> list[float]:
    """Velocity of the tool (m/s, rad/s), in the base's frame."""
    return _twist(task, *task.controller.body.read())


@function("get_target_tcp_speed")
def _get_target_tcp_speed(task: RobotTask) -> list[float]:
    """Velocity that the tool shall have (m/s, rad/s), in the base's frame."""
    return _twist(task, task.controller.target, task.controller.velocity)


@function("is_steady")
def _is_steady(task: RobotTask) -> bool:
    """True where the robot stands at its target."""
    return not task.controller.moving


def _tcp(task: RobotTask, value: Value) -> Floats:
    return task.controller.tcp if value is None else matrix(value, "tcp")


@function("get_forward_kin", "q=none, tcp=none")
def _get_forward_kin(task: RobotTask, positions: Value, tcp: Value) -> Pose:
    """Pose of the tool at joint positions, those of now unless others are given; so of the tool."""
    here = task.controller.body.read()[0] if positions is None else np.array(numbers(positions, "q", 6))
    return _forward(task, here, _tcp(task, tcp))


def _inverse(task: RobotTask, goal: Value, near: Value, tcp: Value) -> list[float]:
    start = task.controller.body.read()[0] if near is None else np.array(numbers(near, "qnear", 6))
    return kinematics.inverse(task.controller.model, matrix(goal, "x"), start, _tcp(task, tcp)).tolist()


_INVERSE = "x, qnear=none, maxPositionError=1e-10, maxOrientationError=1e-10, tcp=none"


@function("get_inverse_kin", _INVERSE)
def _get_inverse_kin(
    task: RobotTask, goal: Value, near: Value, position: Value, orientation: Value, tcp: Value
) -> list[float]:
    """Joint positions at which the tool has a pose, near to others; those of now unless others are given."""
    number(position, "maxPositionError")
    number(orientation, "maxOrientationError")
    try:
        return _inverse(task, goal, near, tcp)
    except NoPosture as error:
        raise ScriptFault(str(error)) from error


@function("get_inverse_kin_has_solution", _INVERSE)
def _get_inverse_kin_has_solution(
    task: RobotTask, goal: Value, near: Value, position: Value, orientation: Value, tcp: Value
) -> bool:
    """True where get_inverse_kin has joint positions."""
    try:
        return bool(_inverse(task, goal, near, tcp))
    except NoPosture:
        return False


@function("is_within_safety_limits", "pose")
def _is_within_safety_limits(task: RobotTask, goal: Value) -> bool:
    """True where a pose can be reached, or joint positions are within a turn to either side; there are no planes."""
    try:
        positions = _inverse(task, goal, None, None) if isinstance(goal, Pose) else numbers(goal, "pose", 6)
    except NoPosture:
        return False
    return bool(np.abs(positions).max() <= _TURN)


@function("set_tcp", "pose")
def _set_tcp(task: RobotTask, value: Value) -> None:
    """Sets the pose of the tool in the flange's frame."""
    task.controller.tcp = matrix(value, "pose")


@function("get_tcp_offset")
def _get_tcp_offset(task: RobotTask) -> Pose:
    """Pose of the tool in the flange's frame."""
    return pose(task.controller.tcp)


def _load(task: RobotTask, mass: Value, center: Value) -> None:
    if number(mass, "m") < 0.0:
        raise ScriptFault(f"m is 0 or more kg, not {text(mass)}")
    if center is not None:
        x, y, z = numbers(center, "cog", 3)
        task.controller.center = (x, y, z)
    task.controller.mass = float(mass)


@function("set_payload", "m, cog=none")
def _set_payload(task: RobotTask, mass: Value, center: Value) -> None:
    """Sets the mass (kg) that the robot carries, and where its centre is (m)."""
    _load(task, mass, center)


@function("set_payload_mass", "m")
def _set_payload_mass(task: RobotTask, mass: Value) -> None:
    """Sets the mass (kg) that the robot carries; its centre is where it was."""
    _load(task, mass, list(task.controller.center))


@function("set_payload_cog", "cog")
def _set_payload_cog(task: RobotTask, center: Value) -> None:
    """Sets the centre of what the robot carries (m)."""
    _load(task, task.controller.mass, center)


@function("set_target_payload", "m, cog=none, inertia=none, transition_time=0")
def _set_target_payload(task: RobotTask, mass: Value, center: Value, inertia: Value, seconds: Value) -> None:
    """Sets the load as set_payload does, and its inertia (kg m^2: xx, yy, zz, xy, xz, yz), at once."""
    values = None if inertia is None else tuple(numbers(inertia, "inertia", 6))
    number(seconds, "transition_time")
    _load(task, mass, center)
    task.controller.inertia = values or task.controller.inertia


@function("get_target_payload")
def _get_target_payload(task: RobotTask) -> float:
    """Mass (kg) that the robot carries."""
    return task.controller.mass


@function("get_target_payload_cog")
def _get_target_payload_cog(task: RobotTask) -> list[float]:
    """Centre of what the robot carries (m), in the flange's frame."""
    return list(task.controller.center)


@function("get_target_payload_inertia")
def _get_target_payload_inertia(task: RobotTask) -> list[float]:
    """Inertia of what the robot carries (kg m^2): xx, yy, zz, xy, xz, yz."""
    return list(task.controller.inertia)


@function("get_joint_torques")
def _get_joint_torques(task: RobotTask) -> list[float]:
    """Torques of the joints (Nm): 0, since an emulated arm knows none."""
    return [0.0] * 6


@function("get_jacobian", "q=none, tcp=none")
def _get_jacobian(task: RobotTask, positions: Value, tcp: Value) -> list[list[float]]:
    """Jacobian of the tool at joint positions, as a matrix: rows are of m/s and rad/s, columns of the joints."""
    here = task.controller.body.read()[0] if positions is None else np.array(numbers(positions, "q", 6))
    return kinematics.jacobian(task.controller.model, here, _tcp(task, tcp)).tolist()


@function("get_jacobian_time_derivative", "q=none, qd=none, tcp=none")
def _get_jacobian_time_derivative(task: RobotTask, positions: Value, speeds: Value, tcp: Value) -> list[list[float]]:
    """Change of the Jacobian in time at joint positions and velocities, those of now unless others are given."""
    here, velocity = task.controller.body.read()
    here = here if positions is None else np.array(numbers(positions, "q", 6))
    velocity = velocity if speeds is None else np.array(numbers(speeds, "qd", 6))
    model, tool = task.controller.model, _tcp(task, tcp)
    after, before = (kinematics.jacobian(model, here + way * velocity, tool) for way in (_STEP, -_STEP))
    return ((after - before) / (2.0 * _STEP)).tolist()
