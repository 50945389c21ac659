"""World of a program in RAPID: one robot of the kernel and the signals, in millimetres, degrees and RAPID's frames.

RAPID's world frame is the frame of the robot's base. A tool becomes a tool centre point of the kernel, on the flange.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import (
    LimitError,
    SingularityError,
    UnreachableError,
    VirtualRobotError,
    WrongStateError,
)
from virtualrobot.geometry import Matrix
from virtualrobot.motions.moves import Move

from virtualrobot_apps.languages.core.motion import MotionQueue, SignalTimeout
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.rapid.configuration import confdata
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.frames import matrix_of, pose_of
from virtualrobot_apps.languages.rapid.predefined import NO_AXIS
from virtualrobot_apps.languages.rapid.symbols import Use

ACCELERATION = 5.0
"""Greatest acceleration (m/s²) of the tool centre point on lines and arcs; the joints' limits count besides."""
PLACES = 8
"""Number of pieces in which the way of a joint move is looked at for its speed."""
_CAN_NOT = (UnreachableError, LimitError, SingularityError)


class World:
    """One robot and the signals of a kernel, for one program."""

    def __init__(self, client: Client, robot: str, say: Callable[[str], None] = lambda _: None) -> None:
        """Take a robot; `say` gets notes, each once for a line of the program.

        Raises WrongStateError for a robot that has not six turning joints.
        """
        self.client, self.robot = client, client.robot(robot)
        self.joints = self.robot.joint_names
        limits = self.robot.limits
        if len(self.joints) != 6:
            raise WrongStateError(f"{robot!r} has {len(self.joints)} joints; RAPID moves arms with six here")
        self._velocities = np.array([limits[name].velocity for name in self.joints], dtype=float)
        self._say, self._said = say, set[str]()
        self.configurations, self.linear_configurations = True, True
        self.speed_share, self.speed_limit, self.acceleration_share = 1.0, math.inf, 1.0
        self._types: dict[str, type] = {}
        self._names: dict[str, str] = {}
        self._tools: dict[str, str] = {}
        state = self.robot.state
        self._before = (state.tool or None, state.tool_center_point or None)
        self._tool: list[Any] | None = None
        self._flange_t_tcp = np.eye(4)
        self._target: np.ndarray | None = None
        self._place: Matrix | None = None
        self._queue: MotionQueue | None = None

    @property
    def queue(self) -> MotionQueue:
        """The motions of the program."""
        if self._queue is None:
            raise RapidStopped("no program works with this robot yet")
        return self._queue

    def begin(self, task: Task) -> None:
        """Belong to a task."""
        self._queue = MotionQueue(self.client, task)

    def find_signals(self, uses: Iterable[Use]) -> None:
        """Look up the signals of a program; raises WrongStateError, with first places, for those that are not there."""
        found = {one.name.lower(): one for one in self.client.signals.read()}
        lacking = []
        for use in uses:
            signal = found.get(use.name.lower())
            if signal is None:
                lacking.append(f"{use.name} ({use.source.file}:{use.source.line(use.at)})")
            elif isinstance(signal.value, str | tuple):
                raise WrongStateError(f"the signal {signal.name!r} is a text or a group, which RAPID has not here")
            else:
                self._names[use.name.lower()] = signal.name
                self._types[signal.name] = type(signal.value)
        if lacking:
            raise WrongStateError(
                f"the world has no signal {', '.join(lacking)}; create it by 'virtualrobot signal NAME --create', or "
                "all by --create-signals"
            )

    def note(self, message: str) -> None:
        """Tell something that a controller would have done otherwise, once for a line of the program."""
        if message not in self._said:
            self._said.add(message)
            self._say(message)

    # Time and signals.

    def settle(self) -> None:
        """Wait until the world may be looked at or told something."""
        self.queue.settle()

    def time(self) -> float:
        """Return the time of the simulation (s)."""
        return self.client.clock.simulation_time

    def signal_name(self, name: str) -> str:
        """Return a signal's name as the world has it."""
        return self._names.get(name.lower(), name)

    def signal_value(self, name: str) -> float:
        """Return the value of a signal as a number, when the program has come so far."""
        self.settle()
        return float(self.client.signals[self.signal_name(name)])  # pyright: ignore[reportArgumentType] looked up

    def typed(self, name: str, value: float) -> bool | int | float:
        """Return a number as a value of a signal's type."""
        kind = self._types.get(self.signal_name(name), bool)
        if kind is bool and value not in (0.0, 1.0):
            raise RapidFault("ERR_ARGVALERR", f"the signal {name!r} is 0 or 1, not {value:g}")
        return kind(value)

    def set_signal(self, name: str, value: float) -> None:
        """Set a signal, in the zone of the last move, or when that is done."""
        self.queue.set(self.signal_name(name), self.typed(name, value))

    def wait_signal(self, name: str, value: float, timeout: float | None) -> None:
        """Stand until a signal has a value; raises the fault ERR_WAIT_MAXTIME after `timeout` (s)."""
        try:
            self.queue.wait_signal(self.signal_name(name), self.typed(name, value), timeout)
        except SignalTimeout as error:
            raise RapidFault("ERR_WAIT_MAXTIME", str(error)) from error

    # Frames.

    def frame(self, wobj: list[Any] | None) -> Matrix:
        """Return where a work object's frame is in that of the robot's base, 4x4."""
        if wobj is None:
            return np.eye(4)
        if wobj[0]:
            raise RapidFault("ERR_ARGVALERR", "a work object that the robot holds (robhold) can't be used here yet")
        if not wobj[1]:
            raise RapidFault(
                "ERR_ARGVALERR", "a work object on a mechanical unit (ufprog FALSE) can't be used here yet"
            )
        return matrix_of(wobj[3]) @ matrix_of(wobj[4])

    def use_tool(self, tool: list[Any]) -> None:
        """Work with a tool from now on; the robot stands when it changes to another one."""
        if not tool[0]:
            raise RapidFault("ERR_ARGVALERR", "a stationary tool (robhold FALSE) can't be used here yet")
        if tool[1] == self._tool:
            return
        self.queue.close()
        pose = matrix_of(tool[1])
        name = None
        if not np.allclose(pose, np.eye(4), atol=1e-12):
            key = repr(tool[1])
            name = self._tools.get(key)
            if name is None:
                number = len(self._tools) + 1
                while f"{self.robot.name}.rapid-tool-{number}" in self.client.scene:
                    number += 1
                name = self._tools[key] = f"{self.robot.name}.rapid-tool-{number}"
                self.client.scene.add_tool(name, self.robot.flange, tool_center_points={"tcp": pose})
        self.client.scene.select_tool(self.robot.name, name)
        self._tool = [list(tool[1][0]), list(tool[1][1])]
        self._flange_t_tcp = pose
        self._place = None

    @property
    def base(self) -> Matrix:
        """Pose of the robot's base in the world, 4x4."""
        return self.client.scene.pose(self.robot.name)

    def _joints_now(self) -> np.ndarray:
        """Return the joints (rad) where the program has sent the robot."""
        if self._target is None:
            self.queue.finish()
            self._target = np.array(self.robot.state.positions)
        return self._target

    def _place_now(self) -> Matrix:
        """Return where the program has sent the tool centre point, in the frame of the base."""
        if self._place is None:
            tcp = self.robot.solve_forward(dict(zip(self.joints, self._joints_now(), strict=True))).world_t_tcp
            self._place = np.linalg.inv(self.base) @ tcp
        return self._place

    def solved(self, base_t_tcp: Matrix, conf: list[float] | None) -> tuple[np.ndarray, list[float], bool]:
        """Return joints that reach a pose of the tool centre point, their configuration, and whether it is `conf`.

        Of several it is the one with that configuration, else the nearest. Raises the fault ERR_ROBLIMIT where there is
        none.
        """
        solution = self.robot.solve_inverse(self.base @ base_t_tcp, seed=list(self._joints_now()))
        if not len(solution.solutions):
            raise RapidFault("ERR_ROBLIMIT", solution.explanation)
        names = solution.configurations or ("",) * len(solution.solutions)
        each = [confdata(joints.tolist(), name) for joints, name in zip(solution.solutions, names, strict=True)]
        wanted = [float(one) for one in conf] if conf is not None else None
        number = each.index(wanted) if wanted in each else 0
        return np.array(solution.solutions[number]), each[number], wanted is None or each[number] == wanted

    # Moves.

    def move_joints(self, goal: np.ndarray, speed: list[float], zone: list[Any]) -> None:
        """Move all joints to positions (rad), the tool centre point nowhere faster than the speed data say."""
        start = self._joints_now()
        factor = self._joint_factor(start, goal, speed)
        named = dict(zip(self.joints, goal.tolist(), strict=True))
        self._add(self.robot.ptp(named, speed_factor=factor), zone)
        self._target, self._place = goal, None

    def move_joints_to(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move all joints to a place, with its configuration where ConfJ is on."""
        pose = self.frame(wobj) @ matrix_of(target)
        goal, found, fits = self.solved(pose, target[2] if self.configurations else None)
        if not fits:
            self.note(
                f"{here()}: no posture within limits has the configuration {_told(target[2])}; the nearest one is "
                f"taken, {_told(found)}. A controller would stop here"
            )
        self.move_joints(goal, speed, zone)
        self._place = pose

    def move_line(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move the tool centre point along a line."""
        pose = self.frame(wobj) @ matrix_of(target)
        velocity = self._velocity(pose, speed, None)
        self._add(
            self.robot.linear(
                pose, reference=self.robot.name, velocity=velocity, acceleration=ACCELERATION * self.acceleration_share
            ),
            zone,
        )
        self._arrived(pose, target)

    def move_arc(
        self, via: list[Any], target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None
    ) -> None:
        """Move the tool centre point along an arc through a place."""
        pose, point = self.frame(wobj) @ matrix_of(target), (self.frame(wobj) @ matrix_of(via))[:3, 3]
        velocity = self._velocity(pose, speed, point)
        self._add(
            self.robot.circular(
                point,
                pose,
                reference=self.robot.name,
                velocity=velocity,
                acceleration=ACCELERATION * self.acceleration_share,
            ),
            zone,
        )
        self._arrived(pose, target)

    def _arrived(self, pose: Matrix, target: list[Any]) -> None:
        """Remember where a line or arc ends; it keeps the branch that it began in."""
        joints, found, _ = self.solved(pose, None)
        if self.linear_configurations and found != [float(one) for one in target[2]]:
            self.note(
                f"{here()}: the way ends in the configuration {_told(found)} and not {_told(target[2])}. A controller "
                "would stop, unless ConfL is off"
            )
        self._target, self._place = joints, pose

    def _add(self, move: Move, zone: list[Any]) -> None:
        try:
            self.queue.move(move, 0.0 if zone[0] else zone[1] / 1000.0)
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error

    def _speed(self, speed: list[float]) -> float:
        """Return the speed (m/s) of the tool centre point, with VelSet."""
        wanted = min(speed[0] * self.speed_share, self.speed_limit) / 1000.0
        if not wanted > 0.0:
            raise RapidFault("ERR_ARGVALERR", f"the speed {speed[0]:g} mm/s is not above 0")
        return wanted

    def _velocity(self, pose: Matrix, speed: list[float], via: np.ndarray | None) -> float:
        """Return the speed (m/s) along a way, so low that the tool turns no faster than v_ori."""
        start = self._place_now()
        if via is None:
            length = float(np.linalg.norm(pose[:3, 3] - start[:3, 3]))
        else:
            length = float(np.linalg.norm(via - start[:3, 3]) + np.linalg.norm(pose[:3, 3] - via))
        angle, velocity = _angle(start, pose), self._speed(speed)
        slowest = math.radians(max(speed[1], 1e-3))
        return velocity if angle * velocity <= slowest * length or length < 1e-6 else slowest * length / angle

    def _joint_factor(self, start: np.ndarray, goal: np.ndarray, speed: list[float]) -> float:
        """Return the share of the joints' speeds with which the tool centre point keeps its own and v_ori."""
        wanted, turning = self._speed(speed), math.radians(max(speed[1], 1e-3))
        seconds = float(np.max(np.abs(goal - start) / self._velocities))
        if seconds < 1e-9:
            return 1.0
        shares = np.linspace(0.0, 1.0, PLACES + 1)[:, None]
        ways = [
            self.robot.solve_forward(dict(zip(self.joints, row, strict=True))).world_t_tcp
            for row in (start + shares * (goal - start)).tolist()
        ]
        each = seconds / PLACES
        fastest = max(np.linalg.norm(b[:3, 3] - a[:3, 3]) for a, b in pairwise(ways)) / each
        turns = max(_angle(a, b) for a, b in pairwise(ways)) / each
        return float(min(1.0, max(1e-3, min(wanted / max(fastest, 1e-9), turning / max(turns, 1e-9)))))

    # The robot as it is.

    def target_now(self, tool: list[Any] | None, wobj: list[Any] | None) -> list[Any]:
        """Return the robtarget where the robot is."""
        self.settle()
        state = self.robot.state
        pose, conf = self._described(state.positions, state.world_t_tcp, tool, wobj)
        return [*pose, conf, [NO_AXIS] * 6]

    def target_at(self, joints: np.ndarray, tool: list[Any], wobj: list[Any] | None) -> list[Any]:
        """Return the robtarget where joints (rad) bring a tool."""
        world_t_tcp = self.robot.solve_forward(dict(zip(self.joints, joints.tolist(), strict=True))).world_t_tcp
        pose, conf = self._described(joints, world_t_tcp, tool, wobj)
        return [*pose, conf, [NO_AXIS] * 6]

    def _described(
        self, joints: np.ndarray, world_t_tcp: Matrix, tool: list[Any] | None, wobj: list[Any] | None
    ) -> tuple[list[Any], list[float]]:
        named = self.robot.solve_inverse(world_t_tcp, seed=list(joints)).configurations
        flange = world_t_tcp @ np.linalg.inv(self._selected())
        tcp = flange @ (matrix_of(tool[1]) if tool is not None else self._selected())
        pose = pose_of(np.linalg.inv(self.base @ self.frame(wobj)) @ tcp)
        return pose, confdata(joints.tolist(), named[0] if named else "")

    def joints_for(self, target: list[Any], tool: list[Any], wobj: list[Any] | None) -> np.ndarray:
        """Return the joints (rad) that bring a tool to a place, with its configuration where one has it."""
        pose = self.frame(wobj) @ matrix_of(target) @ np.linalg.inv(matrix_of(tool[1])) @ self._selected()
        return self.solved(pose, target[2])[0]

    def joints_now(self) -> np.ndarray:
        """Return the joints (rad) where the robot is."""
        self.settle()
        return np.array(self.robot.state.positions)

    def _selected(self) -> Matrix:
        """Return where the kernel's tool centre point is on the flange."""
        if self._tool is None:
            self.use_tool([True, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]])
        return self._flange_t_tcp

    # The end.

    def close(self) -> None:
        """Wait until all is done, and leave the robot with the tool that it had."""
        self.queue.close()
        self._restore()

    def cancel(self, why: str) -> None:
        """Stop the robot on its path, and leave it with the tool that it had."""
        try:
            self.queue.cancel(why)
            self._restore()
        except VirtualRobotError as error:
            self._say(f"the robot's tool could not be put back: {error}")

    def _restore(self) -> None:
        if self._tool is not None:
            self.client.scene.select_tool(self.robot.name, *self._before)
            for name in self._tools.values():
                self.client.scene.remove(name)
            self._tool, self._tools = None, {}


def here() -> str:
    """Return file and line of the statement that is being done: the innermost frame that is no file of Python's."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.endswith(".py"):
        frame = frame.f_back
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


def _angle(first: Matrix, second: Matrix) -> float:
    """Return by how much (rad) two poses are turned against each other."""
    turn = first[:3, :3].T @ second[:3, :3]
    sine = np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2.0
    return math.atan2(float(sine), (float(np.trace(turn)) - 1.0) / 2.0)


def _told(conf: list[float]) -> str:
    return f"[{', '.join(f'{one:g}' for one in conf)}]"
