"""Motion: moves that the controller plans, and setpoints and velocities that a script gives in each cycle.

A move with a radius r lets the script go on once the tool is that near to its end. The next move joins it there, along
a parabola, where both are lines or both go by joints; otherwise, and where there is none, the robot goes to the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import wraps
from typing import TYPE_CHECKING

import numpy as np

from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.kinematics import Floats, NoPosture
from virtualrobot_apps.emulators.ur.moves import (
    ArcMove,
    BlendedLine,
    JointMove,
    LineMove,
    Move,
    Servo,
    Speed,
    Stop,
    TangentArc,
)
from virtualrobot_apps.languages.urscript.builtin.arithmetic import number, numbers, whole
from virtualrobot_apps.languages.urscript.builtin.poses import matrix
from virtualrobot_apps.languages.urscript.faults import ScriptFault
from virtualrobot_apps.languages.urscript.table import function
from virtualrobot_apps.languages.urscript.values import Pose, Value, text

if TYPE_CHECKING:
    from virtualrobot_apps.languages.urscript.robot import RobotTask

_FASTEST = 2.0 * np.pi
"""Highest speed (rad/s) of a joint that the functions take, well above what any arm does."""


def _motion(name: str, signature: str) -> Callable[[Callable[..., Iterator[None]]], Callable[..., Iterator[None]]]:
    """Enter a function of motion: as long as it lasts no other thread may call one."""

    def enter(run: Callable[..., Iterator[None]]) -> Callable[..., Iterator[None]]:
        @wraps(run)
        def controlling(task: RobotTask, *given: Value) -> Iterator[None]:
            with task.controls():
                yield from run(task, *given)

        return function(name, signature, waits=True)(controlling)

    return enter


def _positive(value: Value, name: str) -> float:
    if number(value, name) <= 0.0:
        raise ScriptFault(f"{name} is above 0, not {text(value)}")
    return float(value)


def _joints(value: Value, name: str) -> Floats:
    return np.array(numbers(value, name, 6), dtype=np.float64)


def _rates(length: float, acceleration: Value, speed: Value, seconds: Value) -> tuple[float, float]:
    """Return speed and acceleration of a way: as they are given, or those by which it takes so many seconds.

    Then a third of the time each is for speeding up, for constant speed and for braking.
    """
    if number(seconds, "t") > 0.0:
        return max(1.5 * length / seconds, 1e-9), max(4.5 * length / seconds**2, 1e-9)
    return _positive(speed, "v"), _positive(acceleration, "a")


def _move(
    task: RobotTask,
    make: Callable[[Floats, Move | None], JointMove | LineMove | TangentArc],
    kind: type[JointMove | LineMove | TangentArc],
    radius: Value,
) -> Iterator[None]:
    """Make a move once what was stopped stands, and wait for its end, or until it is within its radius (m).

    `make` is given where it begins, and the move that it joins, which is of the same kind.
    """
    if number(radius, "r") < 0.0:
        raise ScriptFault(f"r is 0 or more, not {text(radius)}")
    controller = task.controller
    while isinstance(controller.move, Stop):
        yield
    before = task.blending
    while before is not None and controller.move is before and not isinstance(before, kind):
        yield
    try:
        move = make(controller.begin(), task.blending)
    except NoPosture as error:
        raise ScriptFault(str(error)) from error
    task.moves(move)
    goal = _forward(task, move.goal) if isinstance(move, JointMove) else move.goal
    blends = radius > 0.0 and move.blends
    while controller.move is move or (controller.move is None and controller.moving):
        if blends and np.linalg.norm(goal[:3, 3] - _forward(task, controller.target)[:3, 3]) <= radius:
            task.blend(move)
            return
        yield


def _forward(task: RobotTask, positions: Floats) -> Floats:
    return kinematics.forward(task.controller.model, positions, task.controller.tcp)


def _pose(task: RobotTask, value: Value, name: str) -> Floats:
    """Return the pose (4, 4) that is given, or that of joint positions."""
    return matrix(value, name) if isinstance(value, Pose) else _forward(task, _joints(value, name))


@_motion("movej", "q, a=1.4, v=1.05, t=0, r=0")
def _movej(
    task: RobotTask, goal: Value, acceleration: Value, speed: Value, seconds: Value, radius: Value
) -> Iterator[None]:
    """Moves joints to positions (rad) or a pose (m, rad); of the longest way a (rad/s^2), v (rad/s); t (s), r (m)."""
    controller = task.controller

    def make(here: Floats, before: Move | None) -> JointMove:
        if isinstance(goal, Pose):
            end = kinematics.inverse(controller.model, matrix(goal, "q"), here, controller.tcp)
        else:
            end = _joints(goal, "q")
        length = float(np.abs(end - here).max())
        rates = _rates(length, acceleration, speed, seconds)
        if not isinstance(before, JointMove) or np.abs(end - before.goal).max() < 1e-6:
            return JointMove(here, end, *rates)
        # The bend is as long on both ways, as the tool has it, but at most half of the second one.
        corner = _forward(task, before.goal)[:3, 3]
        reach = np.linalg.norm(_forward(task, here)[:3, 3] - corner)
        least, most = 0.0, 0.5
        for _ in range(20):
            share = (least + most) / 2.0
            near = np.linalg.norm(_forward(task, before.goal + (end - before.goal) * share)[:3, 3] - corner) < reach
            least, most = (share, most) if near else (least, share)
        return JointMove.after(before, here, end, least, *rates)

    yield from _move(task, make, JointMove, radius)


def _linear(
    task: RobotTask, goal: Value, acceleration: Value, speed: Value, seconds: Value, radius: Value
) -> Iterator[None]:
    def make(here: Floats, before: Move | None) -> LineMove:
        end = _pose(task, goal, "pose")
        rates = _rates(float(np.linalg.norm(end[:3, 3] - _forward(task, here)[:3, 3])), acceleration, speed, seconds)
        if isinstance(before, LineMove) and np.linalg.norm(end[:3, 3] - before.goal[:3, 3]) > 1e-6:
            return BlendedLine(before, here, end, *rates)
        return LineMove(task.controller.model, here, end, task.controller.tcp, *rates)

    yield from _move(task, make, LineMove, radius)


@_motion("movel", "pose, a=1.2, v=0.25, t=0, r=0")
def _movel(
    task: RobotTask, goal: Value, acceleration: Value, speed: Value, seconds: Value, radius: Value
) -> Iterator[None]:
    """Moves the tool along a line to a pose (m, rad) or joint positions (rad); a (m/s^2), v (m/s), t (s), r (m)."""
    yield from _linear(task, goal, acceleration, speed, seconds, radius)


@_motion("movep", "pose, a=1.2, v=0.25, r=0")
def _movep(task: RobotTask, goal: Value, acceleration: Value, speed: Value, radius: Value) -> Iterator[None]:
    """Moves the tool along a line at constant speed, as movel does; a (m/s^2), v (m/s), r (m)."""
    yield from _linear(task, goal, acceleration, speed, 0, radius)


@_motion("movec", "pose_via, pose_to, a=1.2, v=0.25, r=0, mode=0")
def _movec(
    task: RobotTask, via: Value, goal: Value, acceleration: Value, speed: Value, radius: Value, mode: Value
) -> Iterator[None]:
    """Moves the tool along an arc past a place to a pose; a (m/s^2), v (m/s), r (m); with mode 1 it doesn't turn."""
    fixed = whole(mode, "mode", 0, 1) == 1

    def make(here: Floats, before: Move | None) -> LineMove:
        end, place = _pose(task, goal, "pose_to"), _pose(task, via, "pose_via")[:3, 3]
        if fixed:
            end[:3, :3] = _forward(task, here)[:3, :3]
        rates = _rates(0.0, acceleration, speed, 0)
        return ArcMove(task.controller.model, here, place, end, task.controller.tcp, *rates)

    yield from _move(task, make, ArcMove, radius)


@_motion("servoc", "pose, a=1.2, v=0.25, r=0")
def _servoc(task: RobotTask, goal: Value, acceleration: Value, speed: Value, radius: Value) -> Iterator[None]:
    """Moves the tool to a pose along an arc that goes on as it moves, from rest along a line; a (m/s^2), v (m/s)."""
    controller, end, rates = task.controller, _pose(task, goal, "pose"), _rates(0.0, acceleration, speed, 0)
    if not controller.moving and np.abs(_forward(task, controller.begin()) - end).max() < 1e-6:
        yield
        return

    def make(here: Floats, before: Move | None) -> TangentArc:
        velocity = np.zeros(6) if before is None else controller.velocity
        return TangentArc(controller.model, here, velocity, end, controller.tcp, *rates)

    yield from _move(task, make, TangentArc, radius)


@_motion("servoj", "q, a=0, v=0, t=0.002, lookahead_time=0.1, gain=300")
def _servoj(
    task: RobotTask, goal: Value, acceleration: Value, speed: Value, seconds: Value, ahead: Value, gain: Value
) -> Iterator[None]:
    """Has the joints follow positions (rad) for a time t (s); a and v count for nothing, as on a controller."""
    positions, controller = _joints(goal, "q"), task.controller
    for value, name in ((acceleration, "a"), (speed, "v")):
        number(value, name)
    for value, name in ((ahead, "lookahead_time"), (gain, "gain")):
        _positive(value, name)
    cycles = max(1, round(_positive(seconds, "t") / task.dt))
    controller.begin()
    if isinstance(controller.move, Servo):
        controller.move.goal = positions
        task.moves(controller.move)
    else:
        task.moves(Servo(positions))
    for _ in range(cycles):
        yield


def _speed(task: RobotTask, wanted: Floats, linear: bool, acceleration: Value, seconds: Value) -> Iterator[None]:
    controller = task.controller
    until = _positive(seconds, "t") if seconds is not None else 0.0
    controller.begin()
    move = controller.move
    if not isinstance(move, Speed):
        move = Speed(controller.model, controller.tcp)
    move.set(wanted, linear, _positive(acceleration, "a"), until)
    task.moves(move)
    if until:
        for _ in range(max(1, round(until / task.dt))):
            yield
        return
    yield
    while controller.move is move:
        now = controller.velocity if controller.compliance is None else controller.compliance.planned_velocity
        if linear:
            now = kinematics.jacobian(controller.model, controller.target, controller.tcp) @ now
        if np.abs(now - wanted).max() < 1e-3:
            return
        yield


@_motion("speedj", "qd, a=1.4, t=none")
def _speedj(task: RobotTask, wanted: Value, acceleration: Value, seconds: Value) -> Iterator[None]:
    """Moves the joints at velocities (rad/s), a (rad/s^2), for t (s) or until told otherwise."""
    values = _joints(wanted, "qd")
    if np.abs(values).max() > _FASTEST:
        raise ScriptFault(f"qd has speeds of at most {_FASTEST:.4g} rad/s, not {text(wanted)}")
    yield from _speed(task, values, False, acceleration, seconds)


@_motion("speedl", "xd, a=1.2, t=none, aRot=none")
def _speedl(task: RobotTask, wanted: Value, acceleration: Value, seconds: Value, turning: Value) -> Iterator[None]:
    """Moves the tool at velocities (m/s, rad/s, in the base's frame), a (m/s^2), for t (s) or until told otherwise."""
    if turning is not None:
        _positive(turning, "aRot")
    yield from _speed(task, _joints(wanted, "xd"), True, acceleration, seconds)


def _stop(task: RobotTask, deceleration: float) -> Iterator[None]:
    task.controller.halt(deceleration)
    while task.controller.moving:
        yield


@_motion("stopj", "a=2")
def _stopj(task: RobotTask, deceleration: Value) -> Iterator[None]:
    """Slows the joints down to rest; a (rad/s^2) is of the fastest one."""
    yield from _stop(task, _positive(deceleration, "a"))


@_motion("stopl", "a=20, aRot=none")
def _stopl(task: RobotTask, deceleration: Value, turning: Value) -> Iterator[None]:
    """Slows the tool down to rest, at a (m/s^2)."""
    if turning is not None:
        _positive(turning, "aRot")
    controller, rate = task.controller, _positive(deceleration, "a")
    here, velocity = controller.target, controller.velocity
    speed = float(np.linalg.norm((kinematics.jacobian(controller.model, here, controller.tcp) @ velocity)[:3]))
    fastest = float(np.abs(velocity).max())
    # All joints stop in the time in which the tool does.
    yield from _stop(task, fastest * rate / speed if speed > 1e-6 else rate)


@function("protective_stop")
def _protective_stop(task: RobotTask) -> None:
    """Stops the robot as after a collision, and the script with it."""
    task.controller.protective_stop("Protective stop by the program")
