"""World of a program in RAPL-II: one robot of the kernel, in millimetres, degrees and the controller's frames.

RAPL's world frame is that of the robot's base. The x axis of its tool frame points out of the flange, where the kernel
has z.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

import numpy as np
from virtualrobot import Client
from virtualrobot.drivers import DriverStatus
from virtualrobot.errors import LimitError, WrongStateError
from virtualrobot.geometry import Matrix
from virtualrobot.motions.moves import Move

from virtualrobot_apps.languages.core.motion import POLL_SECONDS, MotionQueue
from virtualrobot_apps.languages.core.task import Task
from virtualrobot_apps.languages.rapl.faults import RaplFault
from virtualrobot_apps.languages.rapl.locations import Location, pose_of, values_of

LINEAR_SPEED = 0.508
"""Greatest speed (m/s) of the tool on lines (CRS, A255 Robot Arm User Guide, page 8); taken for the A465 as well."""
ACCELERATION = 2.5
"""Greatest acceleration (m/s²) of the tool on lines, which is assumed; the joints' limits count besides."""
PULSES = {
    5: (200.0, 200.0, 200.0, 16000.0 / 360.0, 8000.0 / 360.0),
    6: (*(100000.0 / 360.0,) * 3, 50500.0 / 360.0, 50000.0 / 360.0, 50500.0 / 360.0),
}
"""Pulses per degree of each joint, by the number of joints: gears of the A255 (the same page) and of the A465, with
1,000 and, of its wrist, 500 pulses a turn of the motor."""
SOFTER = 1.25
"""Factor by which a curve takes longer when a joint would be too fast."""
TRIES = 8
"""Number of times that a curve is made slower before it is refused."""
GRIPPER = "gripper"
"""Signal that stands for the gripper of an arm without one: true where it is closed."""
ARRIVED = math.radians(0.5)
"""Distance (rad) of each joint of a real arm from its twin at which it has arrived."""
NEAR = 0.1
"""Distance (m) from the tool centre point within which a part is gripped."""

_KERNEL_T_RAPL = np.array([[0.0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
"""RAPL's tool frame in the kernel's: x of the one is z of the other, y is y."""


class World:
    """One robot of a kernel, for one program.

    Attributes:
        speed: that of moves, 0 to 1.
        stance: words for `reach`, `elbow` and `wrist` that a posture must have; empty ones count not.
    """

    def __init__(
        self,
        client: Client,
        robot: str,
        say: Callable[[str], None] = lambda _: None,
        pulses: Sequence[float] = (),
    ) -> None:
        """Take a robot; `say` gets notes, each once, `pulses` are those per degree of each joint.

        Raises WrongStateError for a robot that has not five or six turning joints, or other pulses than joints.
        """
        self.client, self.robot = client, client.robot(robot)
        self.names = self.robot.joint_names
        count = len(self.names)
        if count not in PULSES:
            raise WrongStateError(f"{robot!r} has {count} joints; RAPL-II moves arms with five or six here")
        if len(pulses) not in (0, count):
            raise WrongStateError(f"pulses are told for {len(pulses)} joints, and {robot!r} has {count}")
        self.pulses = np.array(pulses or PULSES[count])
        limits = self.robot.limits
        self._velocities = np.array([limits[name].velocity for name in self.names], dtype=float)
        self._say, self._said = say, set[str]()
        self.speed = 0.1
        self.stance = {"reach": "", "elbow": "", "wrist": ""}
        state = self.robot.state
        self._before = (state.tool or None, state.tool_center_point or None)
        self._tool = ""
        self._target: np.ndarray | None = None
        self._queue: MotionQueue | None = None
        self._pause: Callable[[float], None] = time.sleep
        self._find_tool()

    def _find_tool(self) -> None:
        """Learn where the tool centre point is on the flange, and where the robot stands."""
        state = self.robot.state
        flange = self.robot.solve_forward(list(state.positions)).world_t_link[self.robot.flange]
        self._flange_t_tcp = np.linalg.inv(flange) @ state.world_t_tcp
        self._world_t_base = self.client.scene.pose(self.robot.name)

    @property
    def queue(self) -> MotionQueue:
        """The motions of the program; raises a fault where none works with this robot."""
        if self._queue is None:
            raise RaplFault("no program works with this robot yet")
        return self._queue

    def begin(self, task: Task) -> None:
        """Belong to a task."""
        self._queue, self._pause = MotionQueue(self.client, task), task.pause

    def note(self, message: str) -> None:
        """Tell something that a controller might do otherwise, once."""
        if message not in self._said:
            self._said.add(message)
            self._say(message)

    # Where the arm is.

    def joints(self) -> np.ndarray:
        """Return the joints (rad) where the program has sent the arm."""
        if self._target is None:
            self.queue.finish()
            self._target = np.array(self.robot.state.positions)
        return self._target

    def actual(self) -> np.ndarray:
        """Return the joints (rad) where the arm is at this moment."""
        return np.array(self.robot.state.positions)

    def place_at(self, joints: np.ndarray) -> Matrix:
        """Return where joints (rad) bring the tool, 4x4 in the base frame, its x axis along the tool."""
        tcp = self.robot.solve_forward(dict(zip(self.names, joints.tolist(), strict=True))).world_t_tcp
        return np.linalg.inv(self._world_t_base) @ tcp @ _KERNEL_T_RAPL

    def located(self, name: str, joints: np.ndarray) -> Location:
        """Return joints (rad) as a location of this name: a precision point where it begins with #."""
        if name.startswith("#"):
            return Location(name, tuple(np.round(self.pulses * np.degrees(joints)).tolist()))
        return Location(name, values_of(self.place_at(joints)))

    # Where it can go.

    def checked(self, radians: Sequence[float]) -> np.ndarray:
        """Return positions of all joints; raises a fault where there are not as many."""
        if len(radians) != len(self.names):
            raise RaplFault(f"the arm has {len(self.names)} joints, and {len(radians)} values are given")
        return np.array(radians)

    def checked_speed(self, percent: float) -> float:
        """Return a speed from 0 to 1; raises a fault for one that is not 1 to 100 percent."""
        if not 1.0 <= percent <= 100.0:
            raise RaplFault(f"the speed is 1 to 100 percent, not {percent:g}")
        return percent / 100.0

    def goal(self, location: Location, back: float = 0.0, seed: np.ndarray | None = None) -> np.ndarray:
        """Return the joints (rad) at a location, or so far (mm) back along the tool there; raises a fault."""
        if location.is_precision:
            joints = np.radians(self.checked(location.values) / self.pulses)
            return joints if not back else self.solved(self._back(self.place_at(joints), back), joints)
        return self.solved(self._back(pose_of(location.values), back), seed)

    def _back(self, pose: Matrix, distance: float) -> Matrix:
        """Return a pose that is so far (mm) back along the tool's axis."""
        away = np.eye(4)
        away[0, 3] = -distance / 1000.0
        return pose @ away

    def solved(self, pose: Matrix, seed: np.ndarray | None = None) -> np.ndarray:
        """Return the joints (rad) that reach a pose (4x4, base frame) in the stance that is asked for."""
        near = self.joints() if seed is None else seed
        solution = self.robot.solve_inverse(self._kernel(self.fitted(pose)), seed=list(near))
        if not len(solution.solutions):
            raise RaplFault(solution.explanation)
        names = solution.configurations or ("",) * len(solution.solutions)
        wanted = [word for word in self.stance.values() if word]
        for joints, name in zip(solution.solutions, names, strict=True):
            if not set(wanted) - set(name.split()):
                return np.array(joints)
        raise RaplFault(f"no posture within limits is {' and '.join(wanted)} there; there is {', '.join(names)}")

    def _kernel(self, pose: Matrix) -> Matrix:
        """Return a pose of the tool in the base frame as one of the kernel's tool centre point in the world."""
        return self._world_t_base @ pose @ _KERNEL_T_RAPL.T

    def fitted(self, pose: Matrix) -> Matrix:
        """Return a pose as an arm of five joints can have it: its tool points straight up or down, or from axis 1.

        Pitch and roll stay. Tools whose tip is beside the axis of the flange are left as they are.
        """
        along = pose[:3, 0]
        aside = np.hypot(*self._flange_t_tcp[:2, 3]) > 1e-6
        if len(self.names) == 6 or aside or math.hypot(along[0], along[1]) < 1e-6 or np.hypot(*pose[:2, 3]) < 1e-6:
            return pose
        turn = math.atan2(pose[1, 3], pose[0, 3]) - math.atan2(along[1], along[0])
        turn = math.remainder(turn, math.pi)
        if abs(turn) < 1e-9:
            return pose
        if abs(turn) > 1e-3:
            self.note(
                f"the tool of an arm with five joints points from axis 1: turned by {math.degrees(turn):.2f} degrees"
            )
        cosine, sine = math.cos(turn), math.sin(turn)
        fitted = pose.copy()
        fitted[:3, :3] = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]) @ pose[:3, :3]
        return fitted

    # Moves: each begins when the one before is done, and the program goes on as it begins.

    def go(self, location: Location, straight: bool, back: float = 0.0) -> None:
        """Go to a location, or so far (mm) back along the tool there: all joints evenly, or the tool on a line."""
        if not straight:
            self.go_joints(self.goal(location, back))
            return
        joints = self.goal(location, back) if location.is_precision else None
        pose = self._back(pose_of(location.values), back) if joints is None else self.place_at(joints)
        self.go_straight(pose)

    def depart(self, distance: float, straight: bool) -> None:
        """Go so far (mm) back along the tool."""
        pose = self._back(self.place_at(self.joints()), distance)
        if straight:
            self.go_straight(pose)
        else:
            self.go_joints(self.solved(pose))

    def jog(self, offset: np.ndarray) -> None:
        """Go on a line by an offset (m) along the axes of the base."""
        pose = self.place_at(self.joints())
        pose[:3, 3] += offset
        self.go_straight(pose)

    def turn(self, joint: float, angle: float) -> None:
        """Turn one joint, counted from 1, by an angle (rad)."""
        if joint not in range(1, len(self.names) + 1):
            raise RaplFault(f"the arm has joints 1 to {len(self.names)}, and no joint {joint:g}")
        goal = self.joints().copy()
        goal[int(joint) - 1] += angle
        self.go_joints(goal)

    def turn_pulses(self, motor: float, pulses: float) -> None:
        """Turn one joint, counted from 1, by pulses."""
        if motor not in range(1, len(self.names) + 1):
            raise RaplFault(f"the arm has motors 1 to {len(self.names)}, and no motor {motor:g}")
        self.turn(motor, math.radians(pulses / self.pulses[int(motor) - 1]))

    def align(self) -> None:
        """Turn the tool to the nearest axis of the base, its tip where it is."""
        pose = self.place_at(self.joints())
        nearest = int(np.argmax(np.abs(pose[:3, 0])))
        along = np.zeros(3)
        along[nearest] = math.copysign(1.0, pose[nearest, 0])
        beside = pose[:3, 1] - along * (pose[:3, 1] @ along)
        beside /= np.linalg.norm(beside)
        pose[:3, :3] = np.column_stack([along, beside, np.cross(along, beside)])
        self.go_joints(self.solved(pose))

    def ready(self) -> None:
        """Go to the posture `home`."""
        postures = self.robot.postures
        if "home" not in postures:
            raise RaplFault("the robot has no posture 'home'; add it by robot.postures.add")
        self.go_joints(np.array([postures["home"][name] for name in self.names]))

    def go_joints(self, goal: np.ndarray) -> None:
        """Move all joints evenly to positions (rad)."""
        named = dict(zip(self.names, goal.tolist(), strict=True))
        self._begin(self.robot.ptp(named, speed_factor=self.speed), goal)

    def go_straight(self, pose: Matrix) -> None:
        """Move the tool on a line to a pose in the base frame."""
        fitted = self.fitted(pose)
        move = self.robot.linear(self._kernel(fitted), velocity=LINEAR_SPEED * self.speed, acceleration=ACCELERATION)
        near = self.joints()
        self._begin(move, None)
        solution = self.robot.solve_inverse(self._kernel(fitted), seed=list(near))
        self._target = np.array(solution.best) if len(solution.solutions) else None

    def through(self, locations: Sequence[Location], speed: float | None = None) -> None:
        """Move all joints on one smooth curve through locations, no joint faster than the speed allows."""
        rows = [self.joints()]
        for location in locations:
            rows.append(self.goal(location, seed=rows[-1]))
        part = self.speed if speed is None else speed
        ways = np.max(np.abs(np.diff(rows, axis=0)) / self._velocities, axis=1)
        if not np.all(ways > 1e-9):
            raise RaplFault("two places in a row are the same; a path goes through each once")
        seconds = 1.5 * ways / part
        for number in range(TRIES):
            times = np.concatenate([[0.0], np.cumsum(seconds * SOFTER**number)])
            try:
                self._begin(self.robot.trajectory(times, np.array(rows)), rows[-1])
            except LimitError:
                if number == TRIES - 1:
                    raise
            else:
                return

    def _begin(self, move: Move, goal: np.ndarray | None) -> None:
        """Append a move, and wait until it begins."""
        self.queue.move(move)
        self._target = goal
        self.queue.begun()

    def finish(self) -> None:
        """Wait until the arm stands, and the real one, where a driver has it follow, stands there too."""
        self.queue.finish()
        while (driver := self._following()) is not None:
            if np.all(np.abs(driver.positions - self._in_order_of(driver)) <= ARRIVED):
                return
            self._pause(POLL_SECONDS)

    def _following(self) -> DriverStatus | None:
        """Return the driver by which a real arm does what its twin does; raises a fault where that has failed."""
        driver = next((one for one in self.client.drivers.list() if one.robot == self.robot.name), None)
        if driver is None or driver.mode != "execute":
            if driver is not None and driver.halted:
                raise RaplFault(f"the driver of {self.robot.name!r} stopped following: {driver.text}")
            return None
        return driver

    def _in_order_of(self, driver: DriverStatus) -> np.ndarray:
        """Return the joints (rad) of the twin in the order of a driver's."""
        positions = dict(zip(self.names, self.actual().tolist(), strict=True))
        return np.array([positions[name] for name in driver.joint_names])

    def halt(self) -> None:
        """Stop the arm on its way."""
        self.queue.cancel("HALT")
        self._target = None

    # Tool and gripper.

    def use_tool(self, flange_t_tip: Matrix) -> None:
        """Work with a tip at this place on the flange (4x4, x axes along the tool) from now on."""
        self.queue.close()
        state = self.robot.state
        if self._tool:
            self.client.scene.select_tool(self.robot.name, *self._before)
            self.client.scene.remove(self._tool)
        number = 1
        while f"{self.robot.name}.rapl-tool-{number}" in self.client.scene:
            number += 1
        self._tool = f"{self.robot.name}.rapl-tool-{number}"
        pose = _KERNEL_T_RAPL @ flange_t_tip @ _KERNEL_T_RAPL.T
        self.client.scene.add_tool(self._tool, self.robot.flange, tool_center_points={"tip": pose})
        self.client.scene.select_tool(self.robot.name, self._tool)
        self._target = np.array(state.positions)
        self._find_tool()

    def has_gripper(self) -> bool:
        """Return whether there is something that opens and closes."""
        return bool(self._before[0]) or GRIPPER in self.client.signals

    def grip(self, closed: bool) -> None:
        """Close or open the gripper when the arm stands; hold the part that is there, or let go what is held."""
        self.finish()
        self.queue.close()
        name = self._before[0]
        if GRIPPER in self.client.signals:
            self.client.signals[GRIPPER] = closed
        if name is None:
            return
        states = self.robot.tool(name).states
        words = ("closed", "on") if closed else ("open", "off")
        state = next((word for word in words if word in states), None)
        if state is None:
            raise RaplFault(f"the tool {name!r} has no state {' or '.join(words)}; it has {', '.join(states)}")
        self.queue.add(lambda program: program.tool_state(self.robot.name, state, name))
        self.queue.close()
        try:
            if closed:
                self.robot.pick(max_distance=NEAR)
            else:
                self.robot.place()
        except WrongStateError as error:
            self.note(f"{'CLOSE' if closed else 'OPEN'}: {error.message}")

    def grip_to(self, width: float) -> None:
        """Open or close the gripper to a width (m) when the arm stands."""
        name = self._before[0]
        if name is None:
            raise RaplFault("the arm has no gripper with fingers; mount one")
        self.finish()
        self.queue.add(lambda program: program.tool_width(self.robot.name, width, name))
        self.queue.close()

    # The end.

    def close(self) -> None:
        """Wait until all is done, and leave the robot with the tool that it had."""
        self.finish()
        self.queue.close()
        self._restore()

    def cancel(self, why: str) -> None:
        """Stop the robot on its path, and leave it with the tool that it had."""
        self.queue.cancel(why)
        self._restore()

    def _restore(self) -> None:
        if self._tool:
            self.client.scene.select_tool(self.robot.name, *self._before)
            self.client.scene.remove(self._tool)
            self._tool = ""
