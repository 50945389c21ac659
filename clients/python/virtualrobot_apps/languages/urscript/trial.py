"""A script is played to its end by a controller and an arm of their own, and what it would meet in a world is told.

The arm is as fast as the robot's limits let it be. No time passes in the world meanwhile, and nothing moves there.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from virtualrobot.connection import Client
from virtualrobot.robots.robot import Robot

from virtualrobot_apps.emulators.body import ArmLimits, SimulatedArm
from virtualrobot_apps.emulators.ur.controller import Controller
from virtualrobot_apps.emulators.ur.forces import Forces, Unmeasured
from virtualrobot_apps.emulators.ur.kinematics import Floats
from virtualrobot_apps.emulators.ur.moves import Move
from virtualrobot_apps.emulators.ur.orders import obey
from virtualrobot_apps.languages.core.task import here
from virtualrobot_apps.languages.core.trial import Finding, column_of
from virtualrobot_apps.languages.urscript.connections import Connection, Connections
from virtualrobot_apps.languages.urscript.robot import RobotTask, ScriptProgram
from virtualrobot_apps.languages.urscript.task import Loaded

LAG = 0.02
"""Time (s) by which the arm is behind its setpoints, as one of an emulated controller."""
APART = 2
"""Number of cycles from one posture to the next that are looked at."""


class _Alone(Connections):
    """Connections of a script that is tried: nobody answers, wherever it calls."""

    def connect(self, name: str, address: str, port: int) -> Connection | None:
        """Connect to nobody."""
        return None


class _Told(RobotTask):
    """A script that tells which of its lines moves the arm; `at` is file and line, empty before the first one."""

    at = ""

    def __init__(self, loaded: Loaded, controller: Controller) -> None:
        """Begin before the first statement, and without anybody outside."""
        super().__init__(loaded, controller)
        self.connections = _Alone()

    def moves(self, move: Move) -> None:
        """Have the controller make a move."""
        self.at = here()
        super().moves(move)


@dataclass(slots=True)
class Played:
    """Result of a script that was played.

    Attributes:
        findings: the faults, in the order of the time.
        seconds: time (s) that lines took, by `file:line`.
        duration: time (s) that the script took, until the arm stood.
    """

    findings: list[Finding] = field(default_factory=list)
    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    duration: float = 0.0

    def found(self, place: str, message: str) -> None:
        """Keep a fault, of one line and kind the first alone."""
        file, _, line = place.rpartition(":")
        number = int(line or 0)
        one = Finding(file, number, column_of(file, number), message)
        if one not in self.findings:
            self.findings.append(one)


class _Unfelt:
    """Meter of a trial, which measures nothing."""

    def find(self) -> None:
        """Say so."""
        raise Unmeasured("a trial feels none; the emulator of a robot under physics does")

    def read(self) -> tuple[Floats, Floats]:
        """Say so."""
        raise Unmeasured("a trial feels none")


def play(
    client: Client, robot: Robot, loaded: Loaded, model: str, longest: float, orders: Iterable[str] = ()
) -> Played:
    """Play a script from where a robot stands, and tell what it would touch in the world as it is.

    orders: what the controller is told before, as `input 3 on`. It is given up after `longest` s.

    Raises:
        ValueError: the robot is no arm like those of Universal Robots, or an order is none.
    """
    limits, names = robot.limits, robot.joint_names
    each = ("lower", "upper", "velocity", "acceleration")
    arm = ArmLimits(*(np.array([getattr(limits[name], one) for name in names]) for one in each), lag=LAG)
    controller = Controller(SimulatedArm(robot.state.positions, arm), model)
    controller.forces = Forces(_Unfelt())
    for order in orders:
        if amiss := obey(controller, order):
            raise ValueError(amiss)
    played, program = Played(), ScriptProgram(loaded, controller, _Told)
    task, file = program.task, loaded.source.file
    assert isinstance(task, _Told)
    if refused := controller.play(program):
        played.found("", refused)
    postures, lines = [controller.body.read()[0]], [""]
    while controller.program is not None or controller.moving:
        if played.duration > longest:
            played.found(task.at, f"the script has not ended after {longest:g} s")
            controller.end_program()
            break
        controller.cycle()
        played.duration += controller.dt
        played.seconds[task.at or file] += controller.dt
        posture = controller.body.read()[0]
        if controller.cycles % APART == 0 and np.any(posture != postures[-1]):
            postures.append(posture)
            lines.append(task.at)
        for _, _, words in controller.words:
            place, _, message = words.rpartition(": ") if words.startswith(f"{file}:") else (task.at, "", words)
            played.found(place, message)
        controller.words.clear()
    _touched(client, robot, np.array(postures), lines, played)
    return played


def _touched(client: Client, robot: Robot, postures: np.ndarray, lines: list[str], played: Played) -> None:
    """Tell what postures (n, 6) touch, by their lines, but for what is touched at the begin."""
    check = client.collisions.check_configurations(robot, postures, joint_names=robot.joint_names, robots=[robot])
    first = check.pair(0)
    for row, line in enumerate(lines):
        pair = check.pair(row)
        if pair is not None and pair != first:
            one, other = sorted(pair)
            played.found(line, f"{one!r} touches {other!r}")
