"""World of a program in RAPID: one robot of the kernel and the signals, in millimetres, degrees and RAPID's frames.

RAPID's world frame is the frame of the robot's base. A tool becomes a tool centre point of the kernel, on the flange.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from copy import deepcopy
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
from virtualrobot.geometry import Matrix, turn_between
from virtualrobot.motions.moves import Move

from virtualrobot_apps.emulators.body import Twin
from virtualrobot_apps.languages.core.joint_speed import full_speed
from virtualrobot_apps.languages.core.motion import Step
from virtualrobot_apps.languages.core.task import here
from virtualrobot_apps.languages.core.together import GroupQueue
from virtualrobot_apps.languages.rapid.arcs import Arc
from virtualrobot_apps.languages.rapid.configuration import confdata
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.frames import matrix_of, pose_of
from virtualrobot_apps.languages.rapid.predefined import NO_AXIS, VARIABLES
from virtualrobot_apps.languages.rapid.signals import Signals

ACCELERATION = 5.0
"""Greatest acceleration (m/s²) of the tool centre point on lines and arcs; the joints' limits count besides."""
SHORTEST_ARC = 1e-3
"""Distance (m) to its end below which what is left of an arc after a search is made as a line."""
TOOL, WOBJ = VARIABLES["tool0"][2], VARIABLES["wobj0"][2]
_CAN_NOT = (UnreachableError, LimitError, SingularityError)


class World(Signals):
    """One robot and the signals of a kernel, for one program."""

    def __init__(self, client: Client, robot: str, say: Callable[[str], None] = lambda _: None) -> None:
        """Take a robot; `say` gets notes, each once for a line of the program.

        Raises WrongStateError for a robot that has not six turning joints.
        """
        super().__init__(client)
        self.robot = client.robot(robot)
        self.joints = self.robot.joint_names
        limits = self._limits = self.robot.limits
        if len(self.joints) != 6:
            raise WrongStateError(f"{robot!r} has {len(self.joints)} joints; RAPID moves arms with six here")
        self.velocities = np.array([limits[name].velocity for name in self.joints], dtype=float)
        self._say, self._said = say, set[str]()
        self.configurations, self.linear_configurations = True, True
        self.speed_share, self.speed_limit = 1.0, math.inf
        self.acceleration_share, self.acceleration_limit = 1.0, math.inf
        self.tool, self.wobj = deepcopy(TOOL), deepcopy(WOBJ)
        self.displacement = np.eye(4)
        self.concurrent = False
        self.seconds: float | None = None
        self._tools: dict[str, str] = {}
        state = self.robot.state
        self._before = (state.tool or None, state.tool_center_point or None)
        self._tool: list[Any] | None = None
        self._flange_t_tcp = np.eye(4)
        self._target: np.ndarray | None = None
        self._place: Matrix | None = None
        self._levels: list[tuple[np.ndarray | None, Matrix | None, list[Any]]] = []

    @contextmanager
    def move_with(self, concurrent: bool | None, number: float | None) -> Iterator[None]:
        r"""Let the program go on at once after the moves of a block, if it shall; `number` is their \ID.

        Moves have a number while they go together with those of other robots, and then alone.
        """
        queue = self.queue
        if isinstance(queue, GroupQueue):
            if number is None:
                raise RapidStopped(r"a move between SyncMoveOn and SyncMoveOff needs \ID")
            queue.number = round(number)
        elif number is not None:
            raise RapidStopped(r"\ID is for moves between SyncMoveOn and SyncMoveOff")
        self.concurrent = bool(concurrent)
        count = queue.count if isinstance(queue, GroupQueue) else 0
        try:
            yield
        except RapidFault as fault:
            if isinstance(queue, GroupQueue) and queue.count == count:
                queue.fail(fault)
            raise
        finally:
            self.concurrent = False

    def note(self, message: str) -> None:
        """Tell something that a controller would have done otherwise, once for a line of the program."""
        if message not in self._said:
            self._said.add(message)
            self._say(message)

    # Frames.

    def frame(self, wobj: list[Any] | None) -> Matrix:
        """Return where places of a work object are in the frame of the robot's base, with the displacement, 4x4."""
        if wobj is None:
            return self.displacement
        if wobj[0]:
            raise RapidFault("ERR_ARGVALERR", "a work object that the robot holds (robhold) can't be used here yet")
        if not wobj[1]:
            raise RapidFault(
                "ERR_ARGVALERR", "a work object on a mechanical unit (ufprog FALSE) can't be used here yet"
            )
        return matrix_of(wobj[3]) @ matrix_of(wobj[4]) @ self.displacement

    def use_tool(self, tool: list[Any]) -> None:
        """Work with a tool from now on; the robot stands when it changes to another one."""
        if not tool[0]:
            raise RapidFault("ERR_ARGVALERR", "a stationary tool (robhold FALSE) can't be used here yet")
        self.tool = deepcopy(tool)
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
        if (self._tool, name, self._before) != (None, None, (None, None)):  # else it is selected as the program begins
            self.client.scene.select_tool(self.robot.name, name)
        self._tool = [list(tool[1][0]), list(tool[1][1])]
        self._flange_t_tcp = pose
        self._place = None

    @property
    def base(self) -> Matrix:
        """Pose of the robot's base in the world, 4x4."""
        return self.client.scene.pose(self.robot.name)

    def joints_planned(self) -> np.ndarray:
        """Return the joints (rad) where the program has sent the robot."""
        if self._target is None:
            self.queue.finish()
            state = self.robot.state
            self._target = np.array(state.positions)
            if self._tool is not None:
                self._place = np.linalg.inv(self.base) @ state.world_t_tcp
        return self._target

    def place_now(self) -> Matrix:
        """Return where the program has sent the tool centre point, in the frame of the base."""
        joints = self.joints_planned()
        if self._place is None:
            self._place = self._place_of(joints)
        return self._place

    def _place_of(self, joints: np.ndarray) -> Matrix:
        """Return where joints (rad) bring the tool centre point, in the frame of the base."""
        found = self.robot.solve_forward(dict(zip(self.joints, joints.tolist(), strict=True)))
        return np.linalg.inv(self.base) @ found.world_t_tcp

    def solved(self, base_t_tcp: Matrix, conf: list[float] | None) -> tuple[np.ndarray, list[float], bool]:
        """Return joints that reach a pose of the tool centre point, their configuration, and whether it is `conf`.

        Of several it is the one with that configuration, else the nearest. Raises the fault ERR_ROBLIMIT where there is
        none.
        """
        solution = self.robot.solve_inverse(base_t_tcp, list(self.joints_planned()), self.robot.name)
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
        for number, (name, angle) in enumerate(zip(self.joints, goal.tolist(), strict=True), 1):
            limits = self._limits[name]
            if not limits.lower - 1e-6 <= angle <= limits.upper + 1e-6:
                least, most = math.degrees(limits.lower), math.degrees(limits.upper)
                raise RapidFault(
                    "ERR_ROBLIMIT",
                    f"axis {number} can't be at {math.degrees(angle):g} degrees; its limits are {least:g} to {most:g}",
                )
        try:
            factor = self.joint_factor(self.joints_planned(), goal, speed)
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error
        self.add_joints(goal, factor, zone[1] / 1000.0 * (not zone[0]))
        self.went(goal, None)

    def add_joints(self, goal: np.ndarray, factor: float, zone: float) -> None:
        """Append a joint move to positions (rad), with a share of the joints' speeds and a zone (m)."""
        named = dict(zip(self.joints, goal.tolist(), strict=True))
        self._add(self.robot.ptp(named, speed_factor=factor), zone)

    def went(self, joints: np.ndarray, place: Matrix | None) -> None:
        """Remember where a joint move ends: joints (rad), and the pose in the frame of the base where it is known."""
        self._target, self._place = joints, place

    def goal_of(self, target: list[Any], wobj: list[Any] | None) -> np.ndarray:
        """Return the joints (rad) of a place, with its configuration where ConfJ is on."""
        pose = self.frame(wobj) @ matrix_of(target)
        goal, found, fits = self.solved(pose, target[2] if self.configurations else None)
        if not fits:
            self.note(
                f"{here()}: no posture within limits has the configuration {_told(target[2])}; the nearest one is "
                f"taken, {_told(found)}. A controller would stop here"
            )
        return goal

    def move_joints_to(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move all joints to a place, with its configuration where ConfJ is on."""
        self.move_joints(self.goal_of(target, wobj), speed, zone)
        self._place = self.frame(wobj) @ matrix_of(target)

    def place_at(self, joints: np.ndarray) -> np.ndarray:
        """Return where joints (rad) bring the tool centre point, (3,) in m in the world."""
        return self.robot.solve_forward(dict(zip(self.joints, joints.tolist(), strict=True))).world_t_tcp[:3, 3]

    def move_line(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move the tool centre point along a line."""
        pose = self.frame(wobj) @ matrix_of(target)
        self.add_line(pose, self.velocity(pose, speed, None), zone[1] / 1000.0 * (not zone[0]))
        self.arrived(pose, target)

    def move_arc(
        self, via: list[Any], target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None
    ) -> None:
        """Move the tool centre point along an arc through a place."""
        pose, point = self.frame(wobj) @ matrix_of(target), (self.frame(wobj) @ matrix_of(via))[:3, 3]
        self.add_arc(self.place_now(), point, pose, self.velocity(pose, speed, point), zone[1] / 1000.0 * (not zone[0]))
        self.arrived(pose, target)

    def add_line(self, pose: Matrix, velocity: float, zone: float) -> None:
        """Append a line to a pose in the frame of the base, at a speed (m/s), with a zone (m)."""
        self._add(self.robot.linear(pose, **self._along(velocity)), zone)

    def add_arc(self, start: Matrix, via: np.ndarray, pose: Matrix, velocity: float, zone: float) -> None:
        """Append an arc from a pose through a point to another one, as `add_line` does."""

        def arc(through: np.ndarray) -> Move:
            return self.robot.circular(through, pose, **self._along(velocity))

        def rest() -> Step:
            through = Arc(start[:3, 3], via, pose[:3, 3]).rest(self._robot_now()[:3, 3])
            return Step(lambda program: program.move(arc(through), zone=zone or None), True, rest)

        self._add(arc(via), zone, rest)

    def _along(self, velocity: float) -> dict[str, Any]:
        """Return the options of a line or arc in the frame of the base, at a speed (m/s)."""
        acceleration = min(ACCELERATION * self.acceleration_share, self.acceleration_limit)
        return {"reference": self.robot.name, "velocity": velocity, "acceleration": acceleration}

    def _robot_now(self) -> Matrix:
        """Return where the tool centre point is, in the frame of the base."""
        return np.linalg.inv(self.base) @ self.robot.state.world_t_tcp

    def arrived(self, pose: Matrix, target: list[Any]) -> None:
        """Remember where a line or arc ends; it keeps the branch that it began in."""
        joints, found, _ = self.solved(pose, None)
        if self.linear_configurations and found != [float(one) for one in target[2]]:
            self.note(
                f"{here()}: the way ends in the configuration {_told(found)} and not {_told(target[2])}. A controller "
                "would stop, unless ConfL is off"
            )
        self._target, self._place = joints, pose

    def _add(self, move: Move, zone: float, again: Callable[[], Step] | None = None) -> None:
        try:
            self.queue.move(move, zone, concurrent=self.concurrent, again=again)
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error

    def _speed(self, speed: list[float]) -> float:
        """Return the speed (m/s) of the tool centre point, with VelSet."""
        wanted = min(speed[0] * self.speed_share, self.speed_limit) / 1000.0
        if not wanted > 0.0:
            raise RapidFault("ERR_ARGVALERR", f"the speed {speed[0]:g} mm/s is not above 0")
        return wanted

    def velocity(self, pose: Matrix, speed: list[float], via: np.ndarray | None) -> float:
        """Return the speed (m/s) along a way, so low that the tool turns no faster than v_ori, or as `seconds` says."""
        start = self.place_now()
        if via is None:
            length = float(np.linalg.norm(pose[:3, 3] - start[:3, 3]))
        else:
            length = float(np.linalg.norm(via - start[:3, 3]) + np.linalg.norm(pose[:3, 3] - via))
        if self.seconds is not None and length > 1e-6:
            if via is not None:
                with suppress(ValueError):  # three points on one line, which the kernel refuses
                    length = Arc(start[:3, 3], via, pose[:3, 3]).length
            return length / self.seconds
        angle, velocity = turn_between(start, pose), self._speed(speed)
        slowest = math.radians(max(speed[1], 1e-3))
        return velocity if angle * velocity <= slowest * length or length < 1e-6 else slowest * length / angle

    def joint_factor(self, start: np.ndarray, goal: np.ndarray, speed: list[float]) -> float:
        """Return the share of the joints' speeds with which the tool centre point keeps its own and v_ori.

        Where the move has its time (`seconds`), it is that with which the joints take so long at full speed.
        """
        wanted, turning = self._speed(speed), math.radians(max(speed[1], 1e-3))
        if self.seconds is not None:
            seconds = float(np.max(np.abs(goal - start) / self.velocities))
            return float(min(1.0, max(1e-3, seconds / self.seconds))) if seconds > 0.0 else 1.0
        full = full_speed(self.robot, self.joints, start, goal, self.velocities)
        if not full.seconds:
            return 1.0
        share = min(wanted / max(full.speed, 1e-9), turning / max(full.turning, 1e-9))
        return float(min(1.0, max(1e-3, share)))

    @contextmanager
    def together(self) -> Iterator[None]:
        """Append the moves of a block as one."""
        try:
            with self.queue.together():
                yield
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error

    # Paths that are put aside, and searches.

    def store_path(self) -> None:
        """Put the path aside."""
        self.queue.store()
        self._levels.append((self._target, self._place, self.tool))
        self._target = self._place = None

    def restore_path(self) -> None:
        """Go on with the path that was put aside last, with its tool."""
        if not self._levels:
            raise RapidStopped("RestoPath needs a StorePath before it")
        target, place, tool = self._levels.pop()
        self.queue.finish()
        self.use_tool(tool)
        try:
            self.queue.restore()
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error
        self._target, self._place = target, place

    def start(self) -> None:
        """Go on after a stop."""
        try:
            self.queue.start()
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error

    def leave_path(self, why: str) -> None:
        """Stop the robot on its path, and leave out all that it has not done, also of paths that are put aside."""
        self.queue.cancel(why)
        self._levels.clear()
        self._target = self._place = None

    def clear_path(self) -> None:
        """Leave the moves out that are not done."""
        self.queue.forget_path()
        self._target = self._place = None

    def search(
        self,
        via: list[Any] | None,
        target: list[Any],
        signal: tuple[str, float],
        speed: list[float],
        wobj: list[Any] | None,
        go_on: bool,
    ) -> list[Any] | None:
        """Move along a line, or an arc through `via`, until a signal has a value.

        Return the place where it had, None where it never did. The robot brakes there, and goes on along what is left
        then where it shall `go_on`.
        """
        pose = self.frame(wobj) @ matrix_of(target)
        point = None if via is None else (self.frame(wobj) @ matrix_of(via))[:3, 3]
        self.queue.close()
        start, velocity = self.place_now(), self.velocity(pose, speed, point)
        until = (self.signal_name(signal[0]), self.typed(*signal))
        options = {"until": until, **self._along(velocity)}
        try:
            if point is None:
                move = self.robot.linear(pose, **options)
            else:
                move = self.robot.circular(point, pose, **options)
            found = self.queue.search(self.client.program().move(move))
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error
        self._target = self._place = None
        if found is None or not found.found:
            self.arrived(pose, target)
            return None
        joints = np.array([found.joint_positions[name] for name in self.joints])
        place = self.target_at(joints, self.tool, wobj)
        if go_on:
            here = self._robot_now()
            if point is None or np.linalg.norm(pose[:3, 3] - here[:3, 3]) < SHORTEST_ARC:
                self.add_line(pose, velocity, 0.0)
            else:
                through = Arc(start[:3, 3], point, pose[:3, 3]).rest(here[:3, 3])
                self.add_arc(here, through, pose, velocity, 0.0)
            self.arrived(pose, target)
            self.queue.finish()
        return place

    # The robot as it is.

    def target_now(self, tool: list[Any] | None, wobj: list[Any] | None, wait: bool = True) -> list[Any]:
        """Return the robtarget where the robot is, when its program has come so far, or at once, from another one."""
        if not wait:
            return self._target_seen(tool or self.tool, wobj)
        self._selected()
        self.settle()
        state = self.robot.state
        joints, place = np.array(state.positions), np.linalg.inv(self.base) @ state.world_t_tcp
        if self._target is None and self.queue.rests:
            self._target, self._place = joints, place
        return self._described(joints, place, tool, wobj)

    def _target_seen(self, tool: list[Any], wobj: list[Any] | None) -> list[Any]:
        """Return the robtarget where the robot is, and leave the kernel's tool centre point alone."""
        state, flange = self.robot.state, self.client.scene.pose(self.robot.flange)
        named = self.robot.solve_inverse(state.world_t_tcp, seed=list(state.positions)).configurations
        pose = pose_of(np.linalg.inv(self.base @ self.frame(wobj)) @ flange @ matrix_of(tool[1]))
        return [*pose, confdata(list(state.positions), named[0] if named else ""), [NO_AXIS] * 6]

    def target_at(self, joints: np.ndarray, tool: list[Any], wobj: list[Any] | None) -> list[Any]:
        """Return the robtarget where joints (rad) bring a tool."""
        self._selected()
        return self._described(joints, self._place_of(joints), tool, wobj)

    def _described(
        self, joints: np.ndarray, base_t_tcp: Matrix, tool: list[Any] | None, wobj: list[Any] | None
    ) -> list[Any]:
        """Return the robtarget of a tool, where joints (rad) bring the tool centre point of now to a pose."""
        named = self.robot.solve_inverse(base_t_tcp, list(joints), self.robot.name).configurations
        flange = base_t_tcp @ np.linalg.inv(self._selected())
        tcp = flange @ (matrix_of(tool[1]) if tool is not None else self._selected())
        pose = pose_of(np.linalg.inv(self.frame(wobj)) @ tcp)
        return [*pose, confdata(joints.tolist(), named[0] if named else ""), [NO_AXIS] * 6]

    def joints_for(self, target: list[Any], tool: list[Any], wobj: list[Any] | None) -> np.ndarray:
        """Return the joints (rad) that bring a tool to a place, with its configuration where one has it."""
        pose = self.frame(wobj) @ matrix_of(target) @ np.linalg.inv(matrix_of(tool[1])) @ self._selected()
        return self.solved(pose, target[2])[0]

    def joints_now(self, wait: bool = True) -> np.ndarray:
        """Return the joints (rad) where the robot is, as `target_now`."""
        if wait:
            self.settle()
        return np.array(self.robot.state.positions)

    def _selected(self) -> Matrix:
        """Return where the kernel's tool centre point is on the flange."""
        if self._tool is None:
            self.use_tool([True, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]])
        return self._flange_t_tcp

    def follower(self) -> Twin:
        """Return the robot as one that follows setpoints, when all that was given before is done."""
        self.queue.close()
        self._target = self._place = None
        return Twin(self.robot, world_t_base=self.base)

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


def _told(conf: list[float]) -> str:
    return f"[{', '.join(f'{one:g}' for one in conf)}]"
