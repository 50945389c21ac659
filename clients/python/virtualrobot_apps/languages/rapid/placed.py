"""Robot of a program in RAPID: its tools, frames and external axes, where it was sent, and what reaches a place.

RAPID's world frame is the frame of the robot's base; on a rail it is that where the external axes are at 0. A tool
becomes a tool centre point of the kernel, on the flange.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from copy import deepcopy
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError, WrongStateError
from virtualrobot.geometry import Matrix

from virtualrobot_apps.languages.rapid.apart import Apart, on_flange, stands
from virtualrobot_apps.languages.rapid.configuration import confdata, configuration_at
from virtualrobot_apps.languages.rapid.external import External
from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.frames import matrix_of, pose_of
from virtualrobot_apps.languages.rapid.predefined import NO_AXIS, VARIABLES
from virtualrobot_apps.languages.rapid.signals import Signals
from virtualrobot_apps.languages.rapid.symbols import Datum
from virtualrobot_apps.languages.rapid.tree import Aggregate, Text, Truth

TOOL, WOBJ = VARIABLES["tool0"][2], VARIABLES["wobj0"][2]


class Placed(Signals):
    """One robot, with its external axes, and the signals of a kernel, for one program."""

    def __init__(
        self,
        client: Client,
        robot: str,
        say: Callable[[str], None] = lambda _: None,
        external: Mapping[str, str] | None = None,
    ) -> None:
        """Take a robot; `say` gets notes, each once for a line of the program.

        `external` names the robots that are its external axes, by their mechanical units, in the order of `eax_a` on.
        Raises WrongStateError for a robot that has not six turning joints, and what `External` does.
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
        self.acceleration_share, self.jerk_share, self.acceleration_limit = 1.0, 1.0, math.inf
        self.tool, self.wobj = deepcopy(TOOL), deepcopy(WOBJ)
        self.displacement = np.eye(4)
        self.concurrent = False
        self.seconds: float | None = None
        self._tools: dict[str, str] = {}
        self.apart: Apart | None = None
        state = self.robot.state
        self._before = (state.tool or None, state.tool_center_point or None)
        self._tool: list[Any] | None = None
        self._flange_t_tcp = np.eye(4)
        self._target: np.ndarray | None = None
        self._place: Matrix | None = None
        self.external = External(client, robot, external) if external else None
        self._axes = np.zeros(0)

    def note(self, message: str) -> None:
        """Tell something that a controller would have done otherwise, once for a line of the program."""
        if message not in self._said:
            self._said.add(message)
            self._say(message)

    def find_units(self, data: Iterable[Datum]) -> None:
        """Look up the mechanical units on which work objects of a program are by their first values.

        Raises WrongStateError, with its place, for one that is not there.
        """
        for datum in data:
            first = datum.node.value if datum.node is not None and datum.referenced else None
            if datum.type.name != "wobjdata" or not isinstance(first, Aggregate) or len(first.items) < 3:
                continue
            by_program, unit = first.items[1:3]
            if not isinstance(by_program, Truth) or by_program.value or not isinstance(unit, Text):
                continue
            if self.external is None or unit.value.lower() not in self.external.units:
                place = f"{datum.source.file}:{datum.source.line(first.at)}" if datum.source is not None else ""
                raise WrongStateError(f"{place}: {_no_unit(unit.value)}")

    def frame(self, wobj: list[Any] | None, axes: np.ndarray | None = None) -> Matrix:
        """Return where places of a work object are in RAPID's world frame, with the displacement, 4x4.

        One on a mechanical unit is where that is with the external axes at positions (rad or m), as planned without.
        """
        if wobj is None:
            return self.displacement
        if wobj[0]:
            raise RapidFault(
                "ERR_ARGVALERR", "a work object that the robot holds (robhold TRUE) can't be used for this"
            )
        if not wobj[1]:
            if self.external is None:
                raise RapidFault("ERR_ARGVALERR", _no_unit(wobj[2]))
            plate = self.external.plate(wobj[2], self.axes_planned() if axes is None else axes)
            return np.linalg.inv(self.base) @ plate @ matrix_of(wobj[4]) @ self.displacement
        return matrix_of(wobj[3]) @ matrix_of(wobj[4]) @ self.displacement

    def use_tool(self, tool: list[Any], wobj: list[Any] | None = None) -> None:
        """Work with a tool from now on; the robot stands when it changes to another one.

        Of a stationary one the kernel's tool is the work object, which the robot holds.
        """
        apart = stands(tool, wobj)
        key = [*tool[1], *wobj[3:]] if apart and wobj else tool[1]
        self.tool = deepcopy(tool)
        if key == self._tool:
            return
        if apart and self.external is not None and self.external.carried:
            raise RapidFault("ERR_ARGVALERR", "a stationary tool can't be used on a rail yet")
        self.queue.close()
        pose = on_flange(wobj) if apart and wobj else matrix_of(tool[1])
        name, self.apart = None, None
        if apart or not np.allclose(pose, np.eye(4), atol=1e-12):
            name = self._node(repr(key), lambda name: self._mount(name, pose, apart))
        if apart and name is not None:
            there = matrix_of(tool[1])
            stand = self._node(
                f"{key} stands",
                lambda name: self.client.scene.add_frame(name, pose=there, parent=self.robot.name, size=0.05),
            )
            self.apart = Apart(stand, name, there)
        if (self._tool, name, self._before) != (None, None, (None, None)):  # else it is selected as the program begins
            self.client.scene.select_tool(self.robot.name, name)
        self._tool = deepcopy(key)
        self._flange_t_tcp = pose
        self._place = None

    def _mount(self, name: str, pose: Matrix, apart: bool) -> None:
        """Mount a tool with its tool centre point at a pose on the flange, and its frame where it is a workpiece."""
        at, tcp = (pose, np.eye(4)) if apart else (np.eye(4), pose)
        self.client.scene.add_tool(name, self.robot.flange, pose=at, tool_center_points={"tcp": tcp})

    def _node(self, key: str, add: Callable[[str], object]) -> str:
        """Return the name of a node that goes with the program, which is added the first time."""
        name = self._tools.get(key)
        if name is None:
            number = len(self._tools) + 1
            while f"{self.robot.name}.rapid-tool-{number}" in self.client.scene:
                number += 1
            name = self._tools[key] = f"{self.robot.name}.rapid-tool-{number}"
            add(name)
        return name

    def place_of(self, target: list[Any], wobj: list[Any] | None, axes: np.ndarray | None = None) -> Matrix:
        """Return where the kernel's tool centre point is at a place, in RAPID's world frame."""
        if self.apart is not None:
            return self.apart.placed(self.displacement @ matrix_of(target))
        return self.frame(wobj, axes) @ matrix_of(target)

    @property
    def base(self) -> Matrix:
        """Pose of RAPID's world frame in the world, 4x4: of the robot's base, on a rail with that at 0."""
        if self.external is not None and self.external.carried:
            return self.external.base()
        return self.client.scene.pose(self.robot.name)

    def joints_planned(self) -> np.ndarray:
        """Return the joints (rad) where the program has sent the robot."""
        if self._target is None:
            self.queue.finish()
            state = self.robot.state
            self._target = np.array(state.positions)
            self._axes = self.axes_now()
            if self._tool is not None:
                self._place = np.linalg.inv(self.base) @ state.world_t_tcp
        return self._target

    def axes_planned(self) -> np.ndarray:
        """Return the external axes (rad or m) where the program has sent them."""
        self.joints_planned()
        return self._axes

    def axes_of(self, values: list[float]) -> np.ndarray:
        """Return the external axes (rad or m) of a place; what it says of axes that are not there doesn't count."""
        return np.zeros(0) if self.external is None else self.external.asked(values)

    def axes_told(self, axes: np.ndarray) -> list[float]:
        """Return external axes (rad or m) as a place has them."""
        return [NO_AXIS] * 6 if self.external is None else self.external.told(axes)

    def axes_now(self) -> np.ndarray:
        """Return the external axes (rad or m) where they are."""
        return self._axes if self.external is None else self.external.now()

    def _seat(self, axes: np.ndarray) -> Matrix:
        """Return where the robot's base is in RAPID's world frame, with the external axes at positions, 4x4."""
        if self.external is None or not self.external.carried:
            return np.eye(4)
        return np.linalg.inv(self.base) @ self.external.base(axes)

    def place_now(self) -> Matrix:
        """Return where the program has sent the tool centre point, in the frame of the base."""
        joints = self.joints_planned()
        if self._place is None:
            self._place = self._place_of(joints, self._axes)
        return self._place

    def _place_of(self, joints: np.ndarray, axes: np.ndarray) -> Matrix:
        """Return where joints (rad) bring the tool centre point, with the external axes at positions."""
        found = self.robot.solve_forward(dict(zip(self.joints, joints.tolist(), strict=True)))
        if self.external is None or not self.external.carried:
            return np.linalg.inv(self.base) @ found.world_t_tcp
        seated = found.world_t_link[self.robot.links[0]]  # of the same instant, the rail may be on its way
        return self._seat(axes) @ np.linalg.inv(seated) @ found.world_t_tcp

    def solved(
        self, place: Matrix, conf: list[float] | None, axes: np.ndarray | None = None
    ) -> tuple[np.ndarray, list[float], bool]:
        """Return joints that reach a pose of the tool centre point, their configuration, and whether it is `conf`.

        The external axes are at positions (rad or m), as planned without.

        Of several it is the one with that configuration, else the nearest. Raises the fault ERR_ROBLIMIT where there is
        none.
        """
        base_t_tcp = np.linalg.inv(self._seat(self.axes_planned() if axes is None else axes)) @ place
        solution = self.robot.solve_inverse(base_t_tcp, list(self.joints_planned()), self.robot.name)
        if not len(solution.solutions):
            raise RapidFault("ERR_ROBLIMIT", solution.explanation)
        names = solution.configurations or ("",) * len(solution.solutions)
        each = [confdata(joints.tolist(), name) for joints, name in zip(solution.solutions, names, strict=True)]
        wanted = [float(one) for one in conf] if conf is not None else None
        number = each.index(wanted) if wanted in each else 0
        return np.array(solution.solutions[number]), each[number], wanted is None or each[number] == wanted

    def place_at(self, joints: np.ndarray) -> np.ndarray:
        """Return where joints (rad) bring the tool centre point, (3,) in m in the world."""
        return self.robot.solve_forward(dict(zip(self.joints, joints.tolist(), strict=True))).world_t_tcp[:3, 3]

    def target_now(self, tool: list[Any] | None, wobj: list[Any] | None, wait: bool = True) -> list[Any]:
        """Return the robtarget where the robot is, when its program has come so far, or at once, from another one."""
        if not wait:
            return self._target_seen(tool or self.tool, wobj)
        self._selected()
        self.settle()
        state = self.robot.state
        joints, place = np.array(state.positions), np.linalg.inv(self.base) @ state.world_t_tcp
        axes = self.axes_now()
        if self._target is None and self.queue.rests:
            self._target, self._place, self._axes = joints, place, axes
        return self._described(joints, place, tool, wobj, axes)

    def _target_seen(self, tool: list[Any], wobj: list[Any] | None) -> list[Any]:
        """Return the robtarget where the robot is, and leave the kernel's tool centre point alone."""
        state, flange = self.robot.state, self.client.scene.pose(self.robot.flange)
        conf = configuration_at(self.robot, list(state.positions))
        axes = self.axes_now()
        pose = self._seen(np.linalg.inv(self.base) @ flange, tool, wobj, axes)
        return [*pose_of(pose), conf, self.axes_told(axes)]

    def _seen(self, flange: Matrix, tool: list[Any], wobj: list[Any] | None, axes: np.ndarray) -> Matrix:
        """Return where a tool is in a work object, with the flange at a pose in RAPID's world frame."""
        if stands(tool, wobj) and wobj:
            return np.linalg.inv(flange @ on_flange(wobj) @ self.displacement) @ matrix_of(tool[1])
        return np.linalg.inv(self.frame(wobj, axes)) @ flange @ matrix_of(tool[1])

    def target_at(
        self, joints: np.ndarray, tool: list[Any] | None, wobj: list[Any] | None, axes: np.ndarray | None = None
    ) -> list[Any]:
        """Return the robtarget where joints (rad) bring a tool, with external axes at positions, as planned without."""
        self._selected()
        axes = self.axes_planned() if axes is None else axes
        return self._described(joints, self._place_of(joints, axes), tool, wobj, axes)

    def _described(
        self,
        joints: np.ndarray,
        place: Matrix,
        tool: list[Any] | None,
        wobj: list[Any] | None,
        axes: np.ndarray,
    ) -> list[Any]:
        """Return the robtarget of a tool, where joints (rad) bring the tool centre point of now to a pose."""
        conf = configuration_at(self.robot, joints.tolist())
        flange = place @ np.linalg.inv(self._selected())
        pose = self._seen(flange, self.tool if tool is None else tool, wobj, axes)
        return [*pose_of(pose), conf, self.axes_told(axes)]

    def joints_for(self, target: list[Any], tool: list[Any], wobj: list[Any] | None) -> np.ndarray:
        """Return the joints (rad) that bring a tool to a place, with its configuration where one has it."""
        axes = self.axes_of(target[3])
        if stands(tool, wobj) and wobj:
            held = matrix_of(tool[1]) @ np.linalg.inv(self.displacement @ matrix_of(target))
            flange = held @ np.linalg.inv(on_flange(wobj))
        else:
            flange = self.frame(wobj, axes) @ matrix_of(target) @ np.linalg.inv(matrix_of(tool[1]))
        return self.solved(flange @ self._selected(), target[2], axes)[0]

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
            self._tool, self._tools, self.apart = None, {}, None


def _no_unit(unit: str) -> str:
    return f"a work object is on the mechanical unit {unit!r}; say by --external {unit or 'UNIT'}=ROBOT which that is"
