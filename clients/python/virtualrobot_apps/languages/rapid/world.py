"""World of a program in RAPID: one robot of the kernel, its moves, and the signals, in millimetres and degrees."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from virtualrobot import Client
from virtualrobot.errors import LimitError, SingularityError, UnreachableError
from virtualrobot.geometry import Matrix, turn_between
from virtualrobot.motions.moves import Move

from virtualrobot_apps.emulators.body import Twin
from virtualrobot_apps.languages.core.joint_speed import full_speed
from virtualrobot_apps.languages.core.motion import Step
from virtualrobot_apps.languages.core.task import here
from virtualrobot_apps.languages.core.together import GroupQueue
from virtualrobot_apps.languages.core.zones import Corner, Zone, size_of, zone_of
from virtualrobot_apps.languages.rapid.apart import Apart
from virtualrobot_apps.languages.rapid.arcs import Arc
from virtualrobot_apps.languages.rapid.faults import RapidFault, RapidStopped
from virtualrobot_apps.languages.rapid.frames import matrix_of
from virtualrobot_apps.languages.rapid.placed import Placed
from virtualrobot_apps.languages.rapid.predefined import CONSTANTS

ACCELERATION = 5.0
"""Greatest acceleration (m/s²) of the tool centre point on lines and arcs; the joints' limits count besides."""
WIDER, LONGEST_LEAD = 1.2, 5.0
"""Factor by which a zone may begin sooner than its radius says; time (s) before which nothing goes on for it."""
FASTEST = 5.0
"""Speed (m/s) that is asked for where a move has its time, `vmax` of most robots."""
TURNING, SLOWEST_TURN = math.radians(500.0), math.radians(1e-3)
"""Angular velocity (rad/s) of v_ori in all speed data of ABB, and the least one that is given to the kernel."""
SHORTEST_ARC = 1e-3
"""Distance (m) to its end below which what is left of an arc after a search is made as a line."""
_CAN_NOT = (UnreachableError, LimitError, SingularityError)


@dataclass(frozen=True, slots=True)
class On:
    """Frame in which the kernel gets a line or an arc.

    Attributes:
        reference: the node whose frame it is.
        reference_t_rapid: RAPID's world frame in it, 4x4.
        turned: how what stands on the node moves in RAPID's world frame on the way; None: the node stands still.
        apart: the stationary tool whose way it is, on the work object that is the node; None: the tool is held.
    """

    reference: str
    reference_t_rapid: Matrix
    turned: Matrix | None = None
    apart: Apart | None = None

    def goal(self, place: Matrix) -> Matrix:
        """Return a place in RAPID's world frame in that of the node."""
        return self.reference_t_rapid @ place

    def start(self, place: Matrix) -> Matrix:
        """Return where a place on the node is at the end of the way, in RAPID's world frame.

        Of a stationary tool it is that of the tool on the work object, which is at the place.
        """
        if self.apart is not None:
            return self.apart.seen(place)
        return place if self.turned is None else self.turned @ place


class World(Placed):
    """One robot and the signals of a kernel, for one program."""

    def __init__(
        self,
        client: Client,
        robot: str,
        say: Callable[[str], None] = lambda _: None,
        external: Mapping[str, str] | None = None,
    ) -> None:
        """Take a robot as `Placed` does."""
        super().__init__(client, robot, say, external)
        self._turning = TURNING
        self._timed: float | None = None
        self._levels: list[tuple[np.ndarray | None, Matrix | None, np.ndarray, list[Any], list[Any]]] = []

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

    # Moves.

    def move_joints(
        self, goal: np.ndarray, speed: list[float], zone: list[Any], axes: np.ndarray | None = None
    ) -> None:
        """Move all joints to positions (rad), and external axes, none faster than the speed data say."""
        for number, (name, angle) in enumerate(zip(self.joints, goal.tolist(), strict=True), 1):
            limits = self._limits[name]
            if not limits.lower - 1e-6 <= angle <= limits.upper + 1e-6:
                least, most = math.degrees(limits.lower), math.degrees(limits.upper)
                raise RapidFault(
                    "ERR_ROBLIMIT",
                    f"axis {number} can't be at {math.degrees(angle):g} degrees; its limits are {least:g} to {most:g}",
                )
        named, rounding = dict(zip(self.joints, goal.tolist(), strict=True)), corner(zone, speed[0] / 1000.0)
        if self.seconds is None:
            turning = math.radians(max(speed[1], SLOWEST_TURN))
            move = self.robot.ptp(named, velocity=self._speed(speed), angular_velocity=turning, **self._gentle)
        else:
            self._timed = self._exactly(rounding)
            factor = 1.0 if self._timed else self.joint_factor(self.joints_planned(), goal, speed)
            move = self.robot.ptp(named, speed_factor=factor, **self._gentle)
        self._add(move, rounding, beside=self._beside(axes, speed))
        self.went(goal, None, axes)

    def _exactly(self, zone: Zone) -> float | None:
        """Return the time (s) that the next move takes: where it is told, and no zone joins it to others."""
        alone = size_of(zone) == 0.0 and not self.queue.in_zone and not isinstance(self.queue, GroupQueue)
        return self.seconds if alone else None

    def add_joints(self, goal: np.ndarray, factor: float, zone: Zone, beside: Sequence[Move] = ()) -> None:
        """Append a joint move to positions (rad), with a share of the joints' speeds and a zone."""
        named = dict(zip(self.joints, goal.tolist(), strict=True))
        self._add(self.robot.ptp(named, speed_factor=factor, **self._gentle), zone, beside=beside)

    def went(self, joints: np.ndarray, place: Matrix | None, axes: np.ndarray | None = None) -> None:
        """Remember where a move ends: joints (rad), external axes, and the place where it is known."""
        self._target, self._place = joints, place
        self._axes = self._axes if axes is None else axes

    def _beside(self, axes: np.ndarray | None, speed: list[float]) -> list[Move]:
        """Return the moves of external axes to positions, beside a move of the arm."""
        if self.external is None or axes is None:
            return []
        return self.external.moves(axes, self.axes_planned(), speed)

    def keep_axes(self, target: list[Any]) -> None:
        """Refuse a place that has external axes elsewhere than they are, for a move that leaves them there."""
        if self.apart is not None:
            raise RapidFault("ERR_ARGVALERR", "a stationary tool can't move with triggers or in a search yet")
        if self._beside(self.axes_of(target[3]), CONSTANTS["vmax"][1]):
            raise RapidFault("ERR_ARGVALERR", "external axes can't move with triggers or in a search yet")

    def goal_of(self, target: list[Any], wobj: list[Any] | None) -> np.ndarray:
        """Return the joints (rad) of a place, with its configuration where ConfJ is on."""
        axes = self.axes_of(target[3])
        pose = self.place_of(target, wobj, axes)
        goal, found, fits = self.solved(pose, target[2] if self.configurations else None, axes)
        if not fits:
            self.note(
                f"{here()}: no posture within limits has the configuration {_told(target[2])}; the nearest one is "
                f"taken, {_told(found)}. A controller would stop here"
            )
        return goal

    def move_joints_to(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move all joints to a place, with its configuration where ConfJ is on."""
        self.move_joints(self.goal_of(target, wobj), speed, zone, self.axes_of(target[3]))
        self._place = self.place_of(target, wobj)

    def move_line(self, target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None) -> None:
        """Move the tool centre point along a line."""
        axes = self.axes_of(target[3])
        place, beside = self.place_of(target, wobj, axes), self._beside(axes, speed)
        on = self._turned(wobj, axes, beside)
        start, pose = on.start(self.place_now()), place if on.apart is None else on.start(place)
        velocity = self.velocity(pose, speed, None, start)
        rounding = self._corner(zone, velocity, start, pose, axes)
        self.add_line(pose, self._freely(velocity, rounding), rounding, on, beside)
        self.arrived(place, target)

    def move_arc(
        self, via: list[Any], target: list[Any], speed: list[float], zone: list[Any], wobj: list[Any] | None
    ) -> None:
        """Move the tool centre point along an arc through a place."""
        axes = self.axes_of(target[3])
        place, through = (self.place_of(one, wobj, axes) for one in (target, via))
        beside = self._beside(axes, speed)
        on = self._turned(wobj, axes, beside)
        start = on.start(self.place_now())
        pose, point = (place, through[:3, 3]) if on.apart is None else (on.start(place), on.start(through)[:3, 3])
        velocity = self.velocity(pose, speed, point, start)
        rounding = self._corner(zone, velocity, start, pose, axes)
        self.add_arc(start, point, pose, self._freely(velocity, rounding), rounding, on, beside)
        self.arrived(place, target)

    def add_line(
        self, pose: Matrix, velocity: float, zone: Zone, on: On | None = None, beside: Sequence[Move] = ()
    ) -> None:
        """Append a line to a place, at a speed (m/s), with a zone, and moves of external axes beside it."""
        on = on or self._on()
        self._add(self.robot.linear(on.goal(pose), **self._along(velocity, on)), zone, beside=beside)

    def add_arc(
        self,
        start: Matrix,
        via: np.ndarray,
        pose: Matrix,
        velocity: float,
        zone: Zone,
        on: On | None = None,
        beside: Sequence[Move] = (),
    ) -> None:
        """Append an arc from a place through a point to another one, as `add_line` does."""
        found = on or self._on()

        def arc(through: np.ndarray) -> Move:
            middle = np.eye(4)
            middle[:3, 3] = through
            return self.robot.circular(found.goal(middle)[:3, 3], found.goal(pose), **self._along(velocity, found))

        def rest() -> Step:
            there = self._robot_now() if found.apart is None else found.start(self._robot_now())
            through = Arc(start[:3, 3], via, pose[:3, 3]).rest(there[:3, 3])
            return Step(lambda program: program.move(arc(through), **zone_of(zone)), True, rest)

        self._add(arc(via), zone, None if beside else rest, beside)

    def _corner(self, zone: list[Any], velocity: float, start: Matrix, pose: Matrix, axes: np.ndarray) -> Corner:
        """Return the zone at the end of a line or arc from a place to another one, with external axes at positions.

        That of the orientation and of external axes is the smallest share of the way that the zone data has.
        """
        length, angle = float(np.linalg.norm(pose[:3, 3] - start[:3, 3])), math.degrees(turn_between(start, pose))
        shares = [(zone[4], angle)]
        if self.external is not None and self.external.axes:
            ways = np.abs(axes - self.axes_planned())
            shares += [
                (zone[5 if axis.scale == 1000.0 else 6], way * axis.scale)
                for axis, way in zip(self.external.axes, ways.tolist(), strict=True)
            ]
        moving = any(way > 1e-9 for _, way in shares[1:])
        most = min(zone[2], zone[3]) if moving else zone[2]
        each = [float(size) / way * length for size, way in shares if way > 1e-9]
        return corner(zone, velocity, min([most / 1000.0, *each]))

    def _on(self) -> On:
        """Return the frame in which the kernel gets lines and arcs: of the base, or of the world where that moves.

        Of a stationary tool it is the work object.
        """
        if self.apart is not None:
            return On(self.apart.held, np.eye(4), apart=self.apart)
        if self.external is None or not self.external.carried:
            return On(self.robot.name, np.eye(4))
        return On("world", self.base)

    def _turned(self, wobj: list[Any] | None, axes: np.ndarray, beside: Sequence[Move]) -> On:
        """Return the same, which is the plate of a mechanical unit for a work object that moves on it."""
        if self.external is None or wobj is None or wobj[1]:
            return self._on()
        unit = self.external.unit(wobj[2])
        if unit.name not in [one.robot for one in beside]:
            return self._on()
        base, before = self.base, self.axes_planned()
        plate_t_rapid = np.linalg.inv(self.external.plate(wobj[2], axes)) @ base
        turned = np.linalg.inv(plate_t_rapid) @ np.linalg.inv(self.external.plate(wobj[2], before)) @ base
        return On(unit.flange, plate_t_rapid, turned)

    def _along(self, velocity: float, on: On) -> dict[str, Any]:
        """Return the options of a line or arc in a frame, at a speed (m/s)."""
        acceleration = min(ACCELERATION, self.acceleration_limit / self.acceleration_share)
        moving: dict[str, Any] = {"moving": True} if on.turned is not None else {}
        if on.apart is not None:
            moving["fixed_tool"] = on.apart.tool
        return {
            "reference": on.reference,
            "velocity": velocity,
            "acceleration": acceleration,
            "angular_velocity": self._turning,
            **self._gentle,
            **moving,
        }

    @property
    def _gentle(self) -> dict[str, Any]:
        """Options of all moves: the shares of accelerations and jerks that AccSet says."""
        return {"acceleration_factor": self.acceleration_share, "jerk_factor": self.jerk_share}

    def _robot_now(self) -> Matrix:
        """Return where the tool centre point is, in the frame of the base."""
        return np.linalg.inv(self.base) @ self.robot.state.world_t_tcp

    def arrived(self, pose: Matrix, target: list[Any]) -> None:
        """Remember where a line or arc ends; it keeps the branch that it began in."""
        axes = self.axes_of(target[3])
        joints, found, _ = self.solved(pose, None, axes)
        if self.linear_configurations and found != [float(one) for one in target[2]]:
            self.note(
                f"{here()}: the way ends in the configuration {_told(found)} and not {_told(target[2])}. A controller "
                "would stop, unless ConfL is off"
            )
        self.went(joints, pose, axes)

    def _add(
        self, move: Move, zone: Zone, again: Callable[[], Step] | None = None, beside: Sequence[Move] = ()
    ) -> None:
        timed = {} if self._timed is None else {"min_duration": self._timed}
        self._timed = None
        try:
            self.queue.move(move, zone, concurrent=self.concurrent, again=again, beside=beside, **timed)
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error

    def _speed(self, speed: list[float]) -> float:
        """Return the speed (m/s) of the tool centre point, with VelSet."""
        wanted = min(speed[0] * self.speed_share, self.speed_limit) / 1000.0
        if not wanted > 0.0:
            raise RapidFault("ERR_ARGVALERR", f"the speed {speed[0]:g} mm/s is not above 0")
        return wanted

    def _freely(self, velocity: float, zone: Zone) -> float:
        """Return the speed (m/s) of a line or an arc: the greatest one where its time says how fast it is."""
        self._timed = self._exactly(zone)
        if self._timed is None:
            return velocity
        self._turning = TURNING
        return FASTEST

    def velocity(self, pose: Matrix, speed: list[float], via: np.ndarray | None, start: Matrix | None = None) -> float:
        """Return the speed (m/s) along a way, so low that the tool turns no faster than v_ori, or as `seconds` says.

        How fast the tool turns on the spot is remembered.
        """
        start = self.place_now() if start is None else start
        angle, slowest = turn_between(start, pose), max(math.radians(speed[1] * self.speed_share), SLOWEST_TURN)
        self._turning = slowest
        if via is None:
            length = float(np.linalg.norm(pose[:3, 3] - start[:3, 3]))
        else:
            length = float(np.linalg.norm(via - start[:3, 3]) + np.linalg.norm(pose[:3, 3] - via))
        if self.seconds is not None:
            self._turning = max(angle / self.seconds, SLOWEST_TURN)
        if self.seconds is not None and length > 1e-6:
            if via is not None:
                with suppress(ValueError):  # three points on one line, which the kernel refuses
                    length = Arc(start[:3, 3], via, pose[:3, 3]).length
            return length / self.seconds
        velocity = self._speed(speed)
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
        self._levels.append((self._target, self._place, self._axes, self.tool, self.wobj))
        self._target = self._place = None

    def restore_path(self) -> None:
        """Go on with the path that was put aside last, with its tool."""
        if not self._levels:
            raise RapidStopped("RestoPath needs a StorePath before it")
        target, place, axes, tool, wobj = self._levels.pop()
        self.queue.finish()
        self.use_tool(tool, wobj)
        try:
            self.queue.restore()
        except _CAN_NOT as error:
            raise RapidFault("ERR_ROBLIMIT", error.message) from error
        self._target, self._place, self._axes = target, place, axes

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
        self.keep_axes(target)
        pose = self.frame(wobj) @ matrix_of(target)
        point = None if via is None else (self.frame(wobj) @ matrix_of(via))[:3, 3]
        self.queue.close()
        start, velocity = self.place_now(), self.velocity(pose, speed, point)
        until = (self.signal_name(signal[0]), self.typed(*signal))
        on = self._on()
        options = {"until": until, **self._along(velocity, on)}
        try:
            if point is None:
                move = self.robot.linear(on.goal(pose), **options)
            else:
                middle = np.eye(4)
                middle[:3, 3] = point
                move = self.robot.circular(on.goal(middle)[:3, 3], on.goal(pose), **options)
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

    def follower(self) -> Twin:
        """Return the robot as one that follows setpoints, when all that was given before is done."""
        self.queue.close()
        self._target = self._place = None
        return Twin(self.robot, world_t_base=self.base)


def corner(zone: list[Any], speed: float, extended: float = 0.0) -> Corner:
    """Return the zone that zone data says, at a speed (m/s); `extended` (m): of orientations, the radius at least."""
    if zone[0] or zone[1] <= 0.0:
        return Corner(0.0)
    radius = zone[1] / 1000.0
    extended = max(radius, extended)
    return Corner(radius, extended, min(2.0 * WIDER * extended / speed, LONGEST_LEAD))


def _told(conf: list[float]) -> str:
    return f"[{', '.join(f'{one:g}' for one in conf)}]"
