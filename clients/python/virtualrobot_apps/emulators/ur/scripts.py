"""Scripts that clients upload: run by their language, but for two whose effects are known.

These two are known by the name of their function: `rtde_control`, that of the library ur-rtde, which takes commands by
input registers (as its own script, version 1.6, reads them), and `virtualrobot_driver`, that of the driver `ur_rtde`.
"""

from __future__ import annotations

import re

import numpy as np

from virtualrobot_apps.emulators.ur import kinematics
from virtualrobot_apps.emulators.ur.controller import END_DECELERATION, Controller, Program
from virtualrobot_apps.emulators.ur.kinematics import Floats
from virtualrobot_apps.emulators.ur.moves import JointMove, LineMove, Move, Servo, Speed
from virtualrobot_apps.languages.core.diagnostics import ProgramError
from virtualrobot_apps.languages.urscript.robot import ScriptProgram
from virtualrobot_apps.languages.urscript.task import load

_NAME = re.compile(r"\s*def\s+(\w+)\s*\(")
_OPERATION, _ASYNC_RUNS = 1 << 24, 1 << 15
"""Bits of asynchronous moves in ur-rtde's register: the first of their number, and that of one that runs."""
REALTIME = frozenset({6, 9, 10, 11, 24, 25, 26, 27, 38, 58, 66, 67, 68, 69, 70, 71})
"""Commands that ur-rtde's script takes anew in each cycle, and stays ready."""


def run_script(controller: Controller, text: str) -> None:
    """Do what a script asks for; what is wrong with it is told as the controller tells it, with its line."""
    found = _NAME.match(text)
    name = found[1] if found else ""
    if name == "rtde_control":
        offset = re.search(r"reg_offset_int = .*?\n?\s*(\d+)", text)
        _play(controller, ControlScript(int(offset[1]) if offset else 0))
    elif name == "virtualrobot_driver":
        watchdog = re.search(r'rtde_set_watchdog\("(\w+)", *([\d.]+)', text)
        session = re.search(r"write_output_integer_register\(24, (\d+)\)", text)
        if watchdog is None or session is None:
            controller.say(210, 0, "virtualrobot_driver: this emulator doesn't know that version of the script")
        elif _play(controller, FollowScript(int(session[1]))):
            controller.watch(watchdog[1], max(1, round(controller.rate / float(watchdog[2]))))
    else:
        _interpret(controller, text)


def _interpret(controller: Controller, text: str) -> None:
    """Run a script by its language: in place of the one that runs, or, if it is secondary, at once and beside it."""
    try:
        loaded = load(text)
    except ProgramError as error:
        first = error.diagnostics[0]
        controller.say(210, 0, f"syntax_error_on_line:{first.line}: {first.message}")
        return
    program = ScriptProgram(loaded, controller)
    if not loaded.secondary:
        _play(controller, program)
        return
    if program.cycle(controller):
        controller.say(210, 0, f"the secondary program {loaded.name!r} takes time, and was ended where it waited")
    program.close()


def _play(controller: Controller, program: Program) -> bool:
    refused = controller.play(program)
    if refused:
        controller.say(0, 0, refused)
    return not refused


class Known:
    """A script whose effects are known, and which has nothing to give back."""

    def close(self) -> None:
        """Have nothing to give back."""


class FollowScript(Known):
    """The driver's script: it follows six registers by servoj as long as its command says so."""

    name = "virtualrobot_driver"

    def __init__(self, session: int) -> None:
        """Take the number by which the driver knows that it is its own."""
        self._session, self._waits = session, 250

    def cycle(self, controller: Controller) -> bool:
        """Wait for the command, follow, or end with stopj."""
        commanded = controller.inputs.get("input_int_register_25") == self._session
        if self._waits and not commanded:
            self._waits -= 1
            return True
        self._waits = 0
        if not commanded:
            return False
        controller.registers["output_int_register_24"] = self._session
        goal = _numbers(controller, 24, 6)
        if isinstance(controller.move, Servo):
            controller.move.goal = goal
        else:
            controller.go(lambda here: Servo(goal))
        return True


class ControlScript(Known):
    """The script of ur-rtde: a command's number in the first register of whole numbers, its values in others."""

    name = "rtde_control"

    def __init__(self, offset: int) -> None:
        """Take the number of the first register."""
        self._offset = offset
        self._executing = False
        self._waits = False
        self._operation: Move | None = None
        self._operations = 0

    def cycle(self, controller: Controller) -> bool:
        """Take a command, or go on with one."""
        out, number = controller.registers, f"output_int_register_{self._offset}"
        if self._operation is not None and controller.move is not self._operation:
            self._operation = None
            self._tell_operation(controller)
        if self._waits:
            if controller.moving:
                return True
            self._waits = False
            out[number] = 2
            return True
        command = _whole(controller, self._offset)
        if command in REALTIME:
            self._follow(controller, command)
            out[number] = 1
        elif command == 0:
            self._executing = False
            out[number] = 1
        elif command == 255:
            return False
        elif not self._executing:
            self._executing = True
            out[number] = 2
            self._do(controller, command)
        return True

    def _tell_operation(self, controller: Controller) -> None:
        runs = _ASYNC_RUNS if self._operation is not None else 0
        controller.registers[f"output_int_register_{self._offset + 2}"] = self._operations % 128 * _OPERATION | runs

    def _wait(self, controller: Controller) -> None:
        """Be done once the move is, unless the client doesn't want to wait."""
        if _whole(controller, self._offset + 1) == 1:
            self._operations += 1
            self._operation = controller.move
            self._tell_operation(controller)
        elif controller.program is self:
            self._waits = True
            controller.registers[f"output_int_register_{self._offset}"] = 1

    def _follow(self, controller: Controller, command: int) -> None:
        values = _numbers(controller, self._offset, 6)
        if command in (11, 24):
            if command == 24:
                near, tcp = controller.target, controller.tcp
                try:
                    values = kinematics.inverse(controller.model, kinematics.matrix_of(values), near, tcp)
                except kinematics.NoPosture as error:
                    controller.protective_stop(str(error))
                    return
            if isinstance(controller.move, Servo):
                controller.move.goal = values
            else:
                controller.go(lambda here: Servo(values))
        elif command in (9, 10):
            if not isinstance(controller.move, Speed):
                controller.go(lambda here: Speed(controller.model, controller.tcp))
            acceleration, seconds = _numbers(controller, self._offset + 6, 2)
            if isinstance(controller.move, Speed):
                controller.move.set(values, command == 10, float(acceleration), float(seconds))
        elif command == 26:
            controller.registers[f"output_double_register_{self._offset}"] = controller.dt
        elif command == 38:
            self._answer(controller, np.zeros(6))

    def _do(self, controller: Controller, command: int) -> None:
        values = _numbers(controller, self._offset, 6)
        speed, acceleration = (max(1e-3, float(one)) for one in _numbers(controller, self._offset + 6, 2))
        if command in (1, 2, 3, 4):
            _start(controller, values, line=command > 2, pose=command in (2, 3), speed=speed, acceleration=acceleration)
            self._wait(controller)
        elif command in (15, 16, 33, 34):
            controller.halt(END_DECELERATION if command in (16, 33) else float(values[0]))
            if command in (15, 16) or _whole(controller, self._offset + 1) != 1:
                self._waits = True
                controller.registers[f"output_int_register_{self._offset}"] = 1
        elif command == 17:
            controller.mass = float(values[0])
            if values[1:4].any():
                controller.center = tuple(values[1:4].tolist())
        elif command == 29:
            controller.tcp = kinematics.matrix_of(values)
        elif command == 31:
            controller.protective_stop("Protective stop by the program")
        elif command == 35:
            controller.watch(f"input_int_register_{self._offset}", max(1, round(controller.rate / max(values[0], 0.1))))
        elif command in (36, 37, 47, 60, 61):
            controller.registers[f"output_int_register_{self._offset + 1}"] = int(
                command != 47 or not controller.moving
            )
        elif command == 39:
            other = kinematics.matrix_of(_numbers(controller, self._offset + 6, 6))
            self._answer(controller, kinematics.pose_of(kinematics.matrix_of(values) @ other))
        elif command == 40:
            self._answer(controller, kinematics.pose_of(controller.tcp))
        elif command == 43:
            here = controller.body.read()[0]
            self._answer(controller, kinematics.pose_of(kinematics.forward(controller.model, here, controller.tcp)))
        elif command == 44:
            tcp = kinematics.matrix_of(_numbers(controller, self._offset + 6, 6))
            self._answer(controller, kinematics.pose_of(kinematics.forward(controller.model, values, tcp)))
        elif command in (30, 46):
            near = _numbers(controller, self._offset + 6, 6) if command == 30 else controller.body.read()[0]
            try:
                pose = kinematics.matrix_of(values)
                self._answer(controller, kinematics.inverse(controller.model, pose, near, controller.tcp))
            except kinematics.NoPosture as error:
                controller.end_program()
                controller.say(255, 0, str(error))
        else:
            controller.say(0, 0, f"this emulator has no command {command} of rtde_control; nothing is done")

    def _answer(self, controller: Controller, values: Floats) -> None:
        for i, value in enumerate(values):
            controller.registers[f"output_double_register_{self._offset + i}"] = float(value)


def _whole(controller: Controller, register: int) -> int:
    value = controller.inputs.get(f"input_int_register_{register}", 0)
    return value if isinstance(value, int) else 0


def _numbers(controller: Controller, first: int, count: int) -> Floats:
    names = (f"input_double_register_{i}" for i in range(first, first + count))
    return np.array([controller.inputs.get(name, 0.0) for name in names], dtype=np.float64)


def _start(
    controller: Controller, values: Floats, *, line: bool, pose: bool, speed: float, acceleration: float
) -> None:
    """Begin movej or movel to joints or to a pose."""
    model, tcp = controller.model, controller.tcp

    def move(here: Floats) -> Move:
        if line:
            goal = kinematics.matrix_of(values) if pose else kinematics.forward(model, values, tcp)
            return LineMove(model, here, goal, tcp, speed, acceleration)
        goal = kinematics.inverse(model, kinematics.matrix_of(values), here, tcp) if pose else values
        return JointMove(here, goal, speed, acceleration)

    controller.go(move)
