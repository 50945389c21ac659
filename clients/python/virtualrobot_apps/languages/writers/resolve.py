"""Programs of the kernel as one robot's statements: each goal with its joints, as the kernel plans them.

What follows a decision is planned from each place to which the decisions before it lead, and must come to the same
statements from all of them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from google.protobuf import json_format
from virtualrobot.connection import Client
from virtualrobot.errors import InvalidArgumentError, TooLargeError, VirtualRobotError
from virtualrobot.geometry import Matrix, pose_from_quaternion
from virtualrobot.motions.plans import MotionPlan
from virtualrobot.motions.program import Program
from virtualrobot.robots.robot import Robot
from virtualrobot.v1 import geometry_pb2, motion_pb2, signal_pb2

from virtualrobot_apps.languages.core.joint_speed import full_speed
from virtualrobot_apps.languages.writers.polyline import BESIDE, TURNED, polyline
from virtualrobot_apps.languages.writers.statements import (
    Arc,
    Comment,
    Condition,
    Dwell,
    Floats,
    Goal,
    If,
    Line,
    Move,
    Placed,
    PointToPoint,
    RobotProgram,
    SetSignal,
    UseTool,
    Value,
    WaitSignal,
    While,
    Zone,
    every,
)
from virtualrobot_apps.languages.writers.ways import MOST_WAYS, Step, Way, all_steps, distinct, merged, tree_of

REST_SECONDS = 0.05
"""Time (s) that the planned program stands after each move, so that a sample is where the move ends."""
SAMPLES, APART_SECONDS = 14_000, 0.01
"""Samples of a plan that one answer holds, and how far apart (s) they may be: at 0.3 m/s a tool is 3 mm farther."""
VELOCITY, ACCELERATION = 0.25, 1.0
"""Speed (m/s) and acceleration (m/s^2) of lines and arcs that give none; see `Linear` in the contract."""
SAME = 1e-6
"""Difference (m, and in rotation matrices) below which a pose is where it was said to be."""
MOST_TURN = 0.98
"""Part of a whole turn up to which an arc is told by three points."""

_TURNS = re.compile(r" \S+[+-]\d+")
"""Full turns of a joint in a branch's name, such as ` joint6+1`."""

_COMPARISONS = {
    motion_pb2.COMPARISON_UNSPECIFIED: "==",
    motion_pb2.COMPARISON_EQUAL: "==",
    motion_pb2.COMPARISON_NOT_EQUAL: "!=",
    motion_pb2.COMPARISON_LESS: "<",
    motion_pb2.COMPARISON_AT_MOST: "<=",
    motion_pb2.COMPARISON_GREATER: ">",
    motion_pb2.COMPARISON_AT_LEAST: ">=",
}
_REFUSED = {
    "spline": "a spline can't be told to a controller",
    "joint_jog": "a jog is for a person's hand",
    "cartesian_jog": "a jog is for a person's hand",
    "wait_part": "a robot does not know where parts are; wait for a sensor's signal",
}
_OF_THE_WORLD = {
    "pick": "here the simulator fixes the part to the tool",
    "place": "here the simulator lets the part go",
    "attach": "here the simulator gives a node another parent",
    "set_allowed_pairs": "here the simulator lets nodes touch",
}
ToolSignals = Mapping[str, tuple[str, Value]]


def robot_program(
    client: Client, program: Program, robot: Robot, name: str, tool_signals: ToolSignals | None = None
) -> RobotProgram:
    """Return what a program has one robot do from where it stands; nothing moves.

    `tool_signals` tells which signal, and which value of it, brings the robot's tool into a state, by the state's name.

    Raises:
        InvalidArgumentError: for a step that no controller's program can make, by its place in the text.
        VirtualRobotError: as `Program.plan`.
    """
    return _Resolver(client, robot, program, dict(tool_signals or {})).resolved(name)


class _Resolver:
    """Steps of a program on their way to statements."""

    def __init__(self, client: Client, robot: Robot, program: Program, tool_signals: ToolSignals) -> None:
        self._client, self._robot, self._tool_signals = client, robot, tool_signals
        flat, paths = program.flat()
        self._whole, self._steps = program, list(tree_of(_spec_of(flat).steps, iter(paths)))
        self._tools: dict[str, Matrix] = {}
        self._frames: dict[str, Matrix] = {}
        self._found: list[Placed] = []
        self._notes: dict[str, None] = {}
        self._share = 1.0
        self._joints = tuple(robot.chain_joint_names)
        limits = robot.limits
        self._velocities = np.array([limits[one].velocity for one in self._joints])
        self._accelerations = np.array([limits[one].acceleration for one in self._joints])
        self._world_t_base = client.scene.pose(robot.name)
        self._world_t_flange = client.scene.pose(robot.flange)

    def resolved(self, name: str) -> RobotProgram:
        """Return the robot's program."""
        if not self._steps:
            raise InvalidArgumentError("the program has no steps to write")
        for step in all_steps(self._steps):
            self._check(step.at, step.message)
        # As it is: its errors name its own steps, and its notes tell of zones.
        for note in self._whole.plan(sample_time=1.0).notes:
            if note.kind != "DEFERRED":
                self._note(note.message)
        state = self._robot.state
        here = dict(zip(self._robot.coordinates, state.positions.tolist(), strict=True))
        joints, place = np.array([here[one] for one in self._joints]), self._in_base(state.world_t_tcp)
        begin = Way((), joints, place, (state.tool, state.tool_center_point), 1.0)
        self._take(begin)
        self._use("0")
        found = [*self._found, *self._block(self._steps, [begin])[0]]
        self._take(begin)
        found = self._settled(self._begun(found, joints, place))
        types = self._robot.joint_types
        return RobotProgram(
            name,
            self._robot.name,
            self._joints,
            tuple(types[one] == "prismatic" for one in self._joints),
            self._tools,
            self._frames,
            tuple(found),
            tuple(self._notes),
        )

    def _note(self, words: str) -> None:
        self._notes[words] = None

    # Ways that decisions lead.

    def _block(self, steps: Sequence[Step], ways: list[Way]) -> tuple[list[Placed], list[Way]]:
        """Return the statements of steps that are come to by some ways, and the ways that lead on from there."""
        found = list[Placed]()
        run = list[Step]()
        for step in steps:
            if not ways:
                self._note(f"step {step.at} and what follows it are never reached: the loop before it has no end")
                return found, ways
            if not step.branches:
                run.append(step)
                continue
            ways = self._run(run, ways, found)
            run = []
            decision, ways = self._decision(step, ways)
            found.append((step.at, decision))
        return found, self._run(run, ways, found)

    def _decision(self, step: Step, ways: list[Way]) -> tuple[If | While, list[Way]]:
        if step.message.WhichOneof("step") == "if_signal":
            asked = self._condition(step.at, step.message.if_signal.condition)
            (then, after), (otherwise, beside) = (self._block(one, ways) for one in step.branches)
            return If(asked, tuple(then), tuple(otherwise)), distinct([*after, *beside])
        (steps,), loop = step.branches, step.message.while_signal
        asked = self._condition(step.at, loop.condition) if loop.HasField("condition") else None
        while len(ways) <= MOST_WAYS:
            body, after = self._block(steps, ways)
            known = distinct([*ways, *after])
            if len(known) == len(ways):
                return While(asked, tuple(body)), ways if asked is not None else []
            ways = known
        raise _refused(step.at, "each round begins elsewhere; give its moves goals that say where all joints go")

    def _run(self, run: Sequence[Step], ways: list[Way], found: list[Placed]) -> list[Way]:
        """Add the statements of steps that decide nothing, the same by all ways, and return the ways after them."""
        if not run or not ways:
            return ways
        told: list[list[Placed]] = []
        ends = list[Way]()
        for way in ways:
            self._found = []
            ends.append(self._led_on(way, run))
            told.append(self._found)
        for by_each in zip(*told, strict=True):
            at, statement = by_each[0]
            for _, other in by_each[1:]:
                statement, words = merged(statement, other)
                if statement is None:
                    raise _refused(at, words)
                if words:
                    self._note(f"step {at}: {words}")
            found.append((at, statement))
        return distinct(ends)

    def _led_on(self, way: Way, run: Sequence[Step]) -> Way:
        """Write the statements of steps at the end of a way, and return the way that goes on after them."""
        self._take(way)
        steps = (*way.steps, *((one.at, one.message) for one in run))
        plan, numbers = self._plan(steps)
        joints, place = way.joints, way.base_t_tcp
        for step, number in zip(run, numbers[len(way.steps) :], strict=True):
            if not _moves(step.message):
                self._other(step.at, step.message)
                continue
            inside, rest = np.flatnonzero(plan.steps == number), np.flatnonzero(plan.steps == number + 1)[-1]
            moved = plan.robots[self._robot.name]
            columns = [moved.joint_names.index(one) if one in moved.joint_names else -1 for one in self._joints]
            goes = [column >= 0 for column in columns]
            ways = np.where(goes, moved.positions[[*inside, rest]][:, columns], joints)
            poses = np.stack([place, *map(self._in_base, moved.world_t_tcp[[*inside, rest]])])
            rows, speeds = np.vstack([joints, ways]), np.array([0.0, *moved.tcp_speeds[[*inside, rest]]])
            self._found += [(step.at, one) for one in self._moved(step.at, step.message.move, rows, poses, speeds)]
            joints, place = ways[-1], poses[-1]
        return Way(steps, joints, place, self._tool, self._share)

    def _take(self, way: Way) -> None:
        """Be where a way ends, with the tool and the speed that are chosen there."""
        self._found, self._tool, self._share = [], way.tool, way.share

    def _in_base(self, world_t_node: Matrix) -> Matrix:
        return np.linalg.inv(self._world_t_base) @ world_t_node

    # What is asked.

    def _check(self, at: str, step: motion_pb2.ProgramStep) -> None:
        """Raise InvalidArgumentError for a step that no robot's program has."""
        kind = step.WhichOneof("step") or ""
        if kind in _REFUSED:
            raise _refused(at, _REFUSED[kind])
        for move in step.move.moves:
            how = move.WhichOneof("move") or ""
            if move.robot != self._robot.name:
                raise _refused(at, f"it moves {move.robot!r}, and the program is for {self._robot.name!r}")
            if how in _REFUSED:
                raise _refused(at, _REFUSED[how])
            if move.HasField("group"):
                raise _refused(at, "a group of the robot's joints has no program of its own")
            if move.linear.HasField("until") or move.circular.HasField("until"):
                raise _refused(at, "a move that searches can't be written yet")
            if how == "circular" and move.circular.orientation == motion_pb2.ARC_ORIENTATION_WITH_ARC:
                raise _refused(at, "a tool that turns with its arc can't be written; let it turn to its goal")
        if len(step.move.moves) > 1:
            raise _refused(at, "a tool that moves together with its arm can't be written; move one after the other")

    def _plan(self, steps: Sequence[tuple[str, motion_pb2.ProgramStep]]) -> tuple[MotionPlan, list[int]]:
        """Return the plan without zones, at rest after each move, and the number of each step in it."""
        spec, numbers, places = motion_pb2.MotionSpec(), list[int](), list[str]()
        for at, step in steps:
            numbers.append(len(spec.steps))
            places.append(at)
            spec.steps.add().CopyFrom(step)
            if _moves(step):
                for zone in ("blend_distance_meters", "blend_percent", "blend_radius"):
                    spec.steps[-1].move.ClearField(zone)
                spec.steps.add().dwell.seconds = REST_SECONDS
                places.append(at)
        said = {"schema_version": 1, **json_format.MessageToDict(spec, preserving_proto_field_name=True)}
        try:
            return _sampled(self._client.program(json.dumps(said))), numbers
        except VirtualRobotError as error:
            number = error.metadata.get("step", "")
            if not number.isdigit():
                raise
            words = str(error).removeprefix(f"step {number}: ")
            raise InvalidArgumentError(f"step {places[int(number)]}: {words}", metadata=error.metadata) from error

    # Statements.

    def _other(self, at: str, step: motion_pb2.ProgramStep) -> None:
        """Write a step that moves no arm."""
        kind = step.WhichOneof("step") or ""
        if kind == "set_signal":
            put = step.set_signal
            if put.lead_seconds:
                raise InvalidArgumentError(f"step {at} sets {put.signal!r} ahead of its place, which can't be written")
            self._found.append((at, SetSignal(put.signal, _value(at, put.value))))
        elif kind == "wait_signal":
            asked, most = self._condition(at, step.wait_signal.condition), step.wait_signal.timeout_seconds or None
            self._found.append((at, WaitSignal(asked.signal, asked.comparison, asked.value, most)))
        elif kind == "dwell":
            self._found.append((at, Dwell(step.dwell.seconds)))
        elif kind == "set_speed":
            if step.set_speed.robot in ("", self._robot.name):
                self._share = step.set_speed.factor
        elif kind == "select_tool":
            if step.select_tool.robot == self._robot.name:
                self._tool = (step.select_tool.tool, step.select_tool.tool_center_point)
                self._use(at)
        elif kind == "move":
            self._move_tool(at, step.move.moves[0].tool_state)
        else:
            self._found.append((at, Comment(_OF_THE_WORLD[kind])))
            self._note(f"step {at}: {_OF_THE_WORLD[kind]}; on a robot the tool's signal has to do it")

    def _condition(self, at: str, asked: motion_pb2.SignalCondition) -> Condition:
        return Condition(asked.signal, _COMPARISONS[asked.comparison], _value(at, asked.value))

    def _move_tool(self, at: str, goal: motion_pb2.ToolStateMove) -> None:
        if not goal.state:
            raise _refused(at, "a width of the tool is no signal; bring it into a state, and give --tool-state")
        if goal.state not in self._tool_signals:
            raise _refused(
                at, f"which signal brings the tool into the state {goal.state!r}? Give --tool-state {goal.state}=SIGNAL"
            )
        signal, value = self._tool_signals[goal.state]
        self._found.append((at, SetSignal(signal, value)))

    def _use(self, at: str) -> None:
        """Work with the chosen tool from here on."""
        name, flange_t_tcp = self._tcp(self._tool)
        self._tools[name] = flange_t_tcp
        self._found.append((at, UseTool(name)))

    def _tcp(self, chosen: tuple[str, str]) -> tuple[str, Matrix]:
        """Return name and `flange_t_tcp` (4x4) of a tool and its tool centre point."""
        tool, point = chosen
        if not tool:
            return "", np.eye(4)
        points = self._robot.tool(tool).tool_center_points
        point = point or next(iter(points), "")
        tool_t_tcp = points[point] if point else np.eye(4)
        flange_t_tool = np.linalg.inv(self._world_t_flange) @ self._client.scene.pose(tool)
        return f"{tool}.{point}" if len(points) > 1 else tool, flange_t_tool @ tool_t_tcp

    def _moved(self, at: str, step: motion_pb2.MoveStep, ways: Floats, poses: Matrix, speeds: Floats) -> list[Move]:
        """Return the moves of a step: one, or lines for a joint trajectory, whose tool has speeds (k,) in m/s."""
        if step.moves[0].WhichOneof("move") != "joint_trajectory":
            return [self._move(at, step, ways, poses)]
        lines = polyline(poses, speeds)
        if lines is None:
            raise _refused(at, "it turns its tool on the spot, which no line tells; go there by joint moves")
        self._frames.setdefault("", np.eye(4))
        passed = [(ways[row], poses[row], self._branch(ways[row])) for row in lines.rows]
        goals = [Goal(joints, pose, "", pose, branch) for joints, pose, branch in passed]
        for before, goal in pairwise(goals):
            if _bent(before.branch) != _bent(goal.branch):
                raise _refused(at, f"no line leads from the posture {before.branch!r} to {goal.branch!r}")
        self._note(
            f"step {at}: its joint trajectory is told as {len(lines.lengths)} lines, within {1e3 * BESIDE:g} mm and "
            f"{np.degrees(TURNED):.2g} degrees; when it is where is the controller's"
        )
        return [
            Line(goal, float(speed), ACCELERATION, lines.zone(row))
            for row, (goal, speed) in enumerate(zip(goals[1:], lines.speeds, strict=True))
        ]

    def _move(self, at: str, step: motion_pb2.MoveStep, ways: Floats, poses: Matrix) -> Move:
        """Return a move that passes joints (k, n), and the tool centre point poses (k, 4, 4) in the base's frame."""
        (move,) = step.moves
        if move.fixed_tool:
            raise _refused(at, f"the tool {move.fixed_tool!r} stands apart from the robot, which can't be written yet")
        if move.time_law == motion_pb2.TIME_LAW_TIME_OPTIMAL:
            self._note(f"step {at}: a controller has a time law of its own, and not one without a jerk limit")
        if step.min_duration_seconds:
            self._note(f"step {at}: how long it takes at least is not written yet; its speed is")
        kind = move.WhichOneof("move")
        share, gentle = (move.speed_factor or 1.0) * self._share, move.acceleration_factor or 1.0
        if move.jerk_factor:
            self._note(f"step {at}: a controller has a jerk of its own, and no part of it")
        zone = self._zone(at, step, poses)
        if kind == "point_to_point":
            to = move.point_to_point
            goal = self._goal(at, to.pose if to.WhichOneof("goal") == "pose" else None, ways[-1], poses[-1])
            found = self._point_to_point(goal, share, ways[0], zone, to)
            return replace(found, acceleration=gentle * found.acceleration)
        wish: Any = move.linear if kind == "linear" else move.circular
        speed = share * (wish.max_velocity_meters_per_second or VELOCITY)
        acceleration = gentle * (wish.max_acceleration_meters_per_second_squared or ACCELERATION)
        if wish.max_angular_velocity_radians_per_second:
            self._note(f"step {at}: how fast the tool may turn on its way is not written yet")
        goal = self._goal(at, wish.goal, ways[-1], poses[-1])
        if kind == "linear":
            return Line(goal, speed, acceleration, zone)
        return Arc(goal, self._via(at, goal, poses, ways), speed, acceleration, zone)

    def _point_to_point(
        self, goal: Goal, share: float, start: Floats, zone: Zone | None, wish: motion_pb2.PointToPoint | None = None
    ) -> PointToPoint:
        full = full_speed(self._robot, self._joints, start, goal.joints, self._velocities)
        if wish is not None:
            asked = (wish.max_velocity_meters_per_second, wish.max_angular_velocity_radians_per_second)
            reached = zip(asked, (full.speed, full.turning), strict=True)
            share *= min([1.0, *(most / speed for most, speed in reached if most and speed > 1e-9)])
        leading = int(np.argmax(np.abs(goal.joints - start) / self._velocities))
        velocity, acceleration = float(self._velocities[leading]), float(self._accelerations[leading])
        return PointToPoint(goal, share, share * full.speed, share * full.turning, share * velocity, acceleration, zone)

    def _goal(self, at: str, asked: motion_pb2.PoseGoal | None, joints: Floats, base_t_tcp: Matrix) -> Goal:
        """Return where a move ends: joints alone where nothing else was asked."""
        self._frames.setdefault("", np.eye(4))
        if asked is None:
            return Goal(joints, base_t_tcp)
        frame = "" if asked.reference in ("", "world", self._robot.name) else asked.reference
        if asked.moving:
            raise _refused(at, "a goal that goes along with what another move moves can't be written")
        if frame and frame not in self._frames:
            self._frames[frame] = self._in_base(self._client.scene.pose(frame))
        frame_t_tcp = np.linalg.inv(self._frames[frame]) @ base_t_tcp
        wished = _matrix(asked.reference_t_tcp)
        if asked.reference in ("", "world"):
            wished = self._in_base(wished)
        if np.abs(frame_t_tcp - wished).max() <= SAME:
            frame_t_tcp = wished
        elif frame:
            raise _refused(at, f"its frame {frame!r} moves while the program runs, which a robot does not know")
        return Goal(joints, base_t_tcp, frame, frame_t_tcp, self._branch(joints))

    def _branch(self, joints: Floats) -> str:
        """Return the name of the posture's branch, whatever tool is chosen by then."""
        seed = dict(zip(self._joints, joints.tolist(), strict=True))
        found = self._robot.solve_inverse(self._robot.solve_forward(seed).world_t_tcp, seed)
        return found.configurations[0] if found.configurations else ""

    def _via(self, at: str, goal: Goal, poses: Matrix, ways: Floats) -> Goal:
        """Return the place in the middle of an arc, of those that it passes."""
        points = poses[:, :3, 3]
        passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        middle = int(np.argmin(np.abs(passed - 0.5 * passed[-1])))
        chords = points[middle] - points[0], points[-1] - points[middle], points[-1] - points[0]
        area = float(np.linalg.norm(np.cross(chords[0], chords[1])))
        sides = float(np.prod([np.linalg.norm(one) for one in chords]))
        if area < 1e-12 or passed[-1] > MOST_TURN * np.pi * sides / area:
            raise _refused(at, "an arc of a whole turn has no three points; write it as two arcs")
        frame_t_via = np.linalg.inv(self._frames[goal.frame]) @ poses[middle]
        return Goal(ways[middle], poses[middle], goal.frame, frame_t_via, goal.branch)

    # Zones.

    def _zone(self, at: str, step: motion_pb2.MoveStep, poses: Matrix) -> Zone | None:
        """Return a zone as radius and share of the move's own way, until the next move's is known."""
        length = float(np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).sum())
        given = step.WhichOneof("zone")
        if given in ("blend_distance_meters", "blend_radius"):
            meters = step.blend_radius.radius_meters or step.blend_distance_meters
            return Zone(meters, min(0.5, meters / length) if length > 0.0 else 0.5)
        if given == "blend_percent":
            radius = length * step.blend_percent / 100.0
            self._note(
                f"step {at}: its zone of {step.blend_percent:g}% is one of {1000.0 * radius:.4g} mm in a language that "
                "tells its radius"
            )
            return Zone(radius, step.blend_percent / 100.0)
        return None

    def _settled(self, statements: Sequence[Placed]) -> list[Placed]:
        """Return statements without the zones that lead to no move, as the kernel drops them."""
        found = list[Placed]()
        for place, (at, statement) in enumerate(statements):
            match statement:
                case If(condition, then, otherwise):
                    statement = If(condition, tuple(self._settled(then)), tuple(self._settled(otherwise)))
                case While(condition, body):
                    statement = While(condition, tuple(self._settled(body)))
                case PointToPoint() | Line() | Arc() if statement.zone is not None:
                    after = [one for _, one in statements[place + 1 :] if not isinstance(one, SetSignal | Comment)]
                    if not after or not isinstance(after[0], PointToPoint | Line | Arc):
                        statement = replace(statement, zone=None)
            found.append((at, statement))
        return found

    def _begun(self, statements: list[Placed], joints: Floats, pose: Matrix) -> list[Placed]:
        """Return statements that go first where the program begins, where its own first move is no joint move."""
        for place, (at, statement) in enumerate(statements):
            moves = [one for _, one in every([(at, statement)]) if isinstance(one, PointToPoint | Line | Arc)]
            if not moves:
                continue
            if isinstance(statement, PointToPoint):
                return statements
            self._note(f"step {at}: it begins where the robot stands now, so the program goes there first")
            first = self._point_to_point(Goal(joints, pose), 0.1, joints, None)
            return [*statements[:place], (at, first), *statements[place:]]
        return statements


def _spec_of(program: Program) -> motion_pb2.MotionSpec:
    """Return what a program says as the contract's message."""
    said = json.loads(program.text)
    del said["schema_version"]
    return json_format.ParseDict(said, motion_pb2.MotionSpec())


def _sampled(program: Program) -> MotionPlan:
    """Return the plan of a program at each tick, or, of a long one, as densely as one answer holds.

    Raises TooLargeError where that would be coarser than APART_SECONDS, and what `Program.plan` raises.
    """
    try:
        return program.plan()
    except TooLargeError:
        seconds = program.plan(sample_time=1.0).duration
        if seconds > SAMPLES * APART_SECONDS:
            raise TooLargeError(
                f"the program takes {seconds:.4g} s where it stands after each move, and {SAMPLES * APART_SECONDS:g} s "
                "are written at once: write it in parts"
            ) from None
        return program.plan(sample_time=seconds / SAMPLES)


def _moves(step: motion_pb2.ProgramStep) -> bool:
    """Return whether a step moves the arm."""
    return step.WhichOneof("step") == "move" and step.move.moves[0].WhichOneof("move") != "tool_state"


def _value(at: str, value: signal_pb2.SignalValue) -> Value:
    """Return a signal's value; a step that gives none sets it to on."""
    kind = value.WhichOneof("kind")
    if kind is None:
        return True
    found = getattr(value, kind)
    if not isinstance(found, bool | int | float):
        raise _refused(at, "a signal of text or of many values has no place on a controller")
    return found


def _bent(branch: str) -> str:
    """Return a branch without the full turns of its joints: on a line joints pass half a turn, but no arm flips."""
    return _TURNS.sub("", branch)


def _matrix(pose: geometry_pb2.Pose) -> Matrix:
    p, q = pose.position, pose.orientation
    turn = [q.x, q.y, q.z, q.w] if pose.HasField("orientation") else [0.0, 0.0, 0.0, 1.0]
    return pose_from_quaternion([p.x, p.y, p.z], turn)


def _refused(at: str, why: str) -> InvalidArgumentError:
    return InvalidArgumentError(f"step {at} can't be written for a robot: {why}", metadata={"step": at})
