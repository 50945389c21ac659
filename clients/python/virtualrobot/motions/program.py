"""Programs: many moves, signals, waits and dwells, one after the other, as one motion."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Unpack

from google.protobuf import json_format
from google.protobuf.internal.containers import RepeatedCompositeFieldContainer

from virtualrobot._wire.arguments import ArrayLike, Count, PoseLike, checked
from virtualrobot._wire.messages import pose_message, value_or_default, vector_message
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import LONG_TIMEOUT_SECONDS, Services
from virtualrobot._wire.signal_values import GivenValue, condition, value_message
from virtualrobot.collisions.allowed_pairs import pairs_command
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.motions import motion, plans
from virtualrobot.motions.moves import Move, messages_of
from virtualrobot.motions.steps import Named, Pattern, PickAtOptions, PlaceAtOptions, handled, name_of
from virtualrobot.scene.editor import pick_command
from virtualrobot.v1 import motion_pb2, scene_pb2

SCHEMA_VERSION = 1
"""Version of program files."""


@checked
class Program:
    """Steps that one motion makes one after the other, planned as a whole before anything moves.

    Each method adds a step and returns the program. Moves are those of `Robot.ptp`, `Robot.linear` and their like.

    Example:
        >>> program = client.program()
        >>> program.move(robot.linear(above), zone=0.02)
        >>> program.move(robot.linear(at))
        >>> program.set("gripper", True)
        >>> program.wait("part", True, timeout=5.0)
        >>> program.dwell(0.2)
        >>> program.move(robot.linear(above))
        >>> program.start()
    """

    def __init__(self, services: Services, spec: motion_pb2.MotionSpec | None = None) -> None:
        """Begin empty, or with what a spec says; `Client.program` makes one."""
        self._services = services
        self._spec = motion_pb2.MotionSpec() if spec is None else spec

    def move(
        self,
        *moves: Move,
        zone: float | None = None,
        zone_percent: float | None = None,
        zone_radius: float | None = None,
        zone_extended: float | None = None,
        min_duration: float | None = None,
    ) -> Program:
        """Add moves that start and end together.

        With `zone`, in meters of the tool centre point's way, or `zone_percent`, of these moves and of the next ones,
        up to 50, the corner is rounded off towards the next moves instead of stopping there; `Motion.notes` tells what
        became of it. With `zone_radius` (m) the way through it is the parabola of a controller's zone, with
        `zone_extended` (m) that of orientations and external axes. What the limits let be faster than `min_duration`
        (s) takes exactly so long, at full speed factors, and no zone joins it to others.
        """
        if sum(one is not None for one in (zone, zone_percent, zone_radius)) > 1:
            raise InvalidArgumentError(
                "a zone has a distance, a percentage or a radius: give one of zone, zone_percent and zone_radius"
            )
        if zone_extended is not None and zone_radius is None:
            raise InvalidArgumentError("zone_extended goes with zone_radius")
        given = messages_of(moves)
        step = self._steps.add().move
        step.moves.extend(given)
        step.min_duration_seconds = value_or_default(min_duration, "min_duration")
        if zone is not None:
            step.blend_distance_meters = zone
        if zone_percent is not None:
            step.blend_percent = zone_percent
        if zone_radius is not None:
            step.blend_radius.radius_meters = zone_radius
            step.blend_radius.extended_radius_meters = zone_extended or 0.0
        return self

    def set(self, signal: str, value: GivenValue = True, *, lead: float = 0.0) -> Program:
        """Add a step that sets a signal; between moves with a zone it is set in the zone's middle.

        With `lead` it is set so many seconds earlier at full speed, on the moves that lead there.

        Example:
            >>> program.move(robot.linear(at)).set("glue", False, lead=0.1)
        """
        message = motion_pb2.SetSignalStep(signal=signal, value=value_message(value), lead_seconds=lead)
        self._steps.add(set_signal=message)
        return self

    def wait(
        self, signal: str, value: GivenValue = True, timeout: float | None = None, comparison: str = "=="
    ) -> Program:
        """Add a step that stands still until a signal compares so with a value (`==`, `!=`, `<`, `<=`, `>`, `>=`).

        After `timeout` seconds of simulation time, if given, the motion is aborted as SIGNAL_TIMEOUT.
        """
        seconds = value_or_default(timeout, "timeout")
        wait = motion_pb2.WaitSignalStep(condition=condition(signal, value, comparison), timeout_seconds=seconds)
        self._steps.add(wait_signal=wait)
        return self

    def dwell(self, duration: float) -> Program:
        """Add a step that stands still for `duration` seconds of simulation time, at most 86,400 (a day)."""
        self._steps.add(dwell=motion_pb2.DwellStep(seconds=duration))
        return self

    def tool_state(self, robot: Named, state: str, tool: str | None = None, *, speed: float | None = None) -> Program:
        """Add a step that brings a tool, the robot's chosen one by default, into a state."""
        return self._tool(robot, motion_pb2.ToolStateMove(tool=tool, state=state), speed)

    def tool_width(self, robot: Named, width: float, tool: str | None = None, *, speed: float | None = None) -> Program:
        """Add a step that opens a tool, the robot's chosen one by default, to a width in meters."""
        return self._tool(robot, motion_pb2.ToolStateMove(tool=tool, width_meters=width), speed)

    def _tool(self, robot: Named, goal: motion_pb2.ToolStateMove, speed: float | None) -> Program:
        factor = value_or_default(speed, "speed")
        self._steps.add().move.moves.add(robot=name_of(robot), speed_factor=factor, tool_state=goal)
        return self

    def pick(self, robot: Named, part: str | None = None, max_distance: float | None = None) -> Program:
        """Add a step that fixes a part to the robot's chosen tool, as `Robot.pick` does; what follows carries it.

        Without a name it is the part nearest to the tool centre point. Where nothing can be picked as the step is
        reached the motion is aborted.
        """
        self._steps.add(pick=pick_command(name_of(robot), part, max_distance).pick_part)
        return self

    def place(self, robot: Named, part: str | None = None, parent: str = "world") -> Program:
        """Add a step that lets a part of the robot's chosen tool go, or all parts, as `Robot.place` does."""
        self._steps.add(place=scene_pb2.PlacePart(robot=name_of(robot), part=part, parent=parent))
        return self

    def attach(self, name: str, parent: str = "world", pose: PoseLike | None = None) -> Program:
        """Add a step that gives a node another parent; without `pose` (`parent_t_node`) it stays where it is."""
        where = None if pose is None else pose_message(pose)
        self._steps.add(attach=scene_pb2.AttachNode(name=name, parent=parent, parent_t_node=where))
        return self

    def select_tool(self, robot: Named, tool: str | None = None, tool_center_point: str | None = None) -> Program:
        """Add a step that chooses the tool and tool centre point that a robot works with from then on."""
        chosen = scene_pb2.SelectTool(robot=name_of(robot), tool=tool, tool_center_point=tool_center_point)
        self._steps.add(select_tool=chosen)
        return self

    def allow(self, allow: Iterable[tuple[str, str, str]] = (), forbid: Iterable[tuple[str, str]] = ()) -> Program:
        """Add a step that lets pairs touch no more, then lets others (name, name, why) touch."""
        self._steps.add(set_allowed_pairs=pairs_command(tuple(allow), tuple(forbid)).set_allowed_pairs)
        return self

    def speed(self, factor: float, robot: Named | None = None) -> Program:
        """Add a step that multiplies the speed factors of all moves after it, or of one robot's, in this program."""
        name = "" if robot is None else name_of(robot)
        self._steps.add(set_speed=motion_pb2.SetSpeedStep(robot=name, factor=factor))
        return self

    def wait_part(
        self,
        part: str | None = None,
        *,
        position: ArrayLike = (0.0, 0.0, 0.0),
        reference: str = "world",
        max_distance: float | None = None,
        timeout: float | None = None,
    ) -> Program:
        """Add a step that stands still until a part, or any, is within `max_distance` (m, 0.2) of a place.

        `position` (3,) is the place in the frame of `reference`, in meters. After `timeout` seconds of simulation time,
        if given, the motion is aborted as PART_TIMEOUT.
        """
        wait = motion_pb2.WaitPartStep(
            part=part,
            reference=reference,
            position=vector_message(position, "the position"),
            max_distance_meters=value_or_default(max_distance, "max_distance"),
            timeout_seconds=value_or_default(timeout, "timeout"),
        )
        self._steps.add(wait_part=wait)
        return self

    def pick_at(
        self, robot: Named, goal: PoseLike, part: str | None = None, **options: Unpack[PickAtOptions]
    ) -> Program:
        """Add a step that goes to before a part, along a line to it, picks it, closes the tool and goes back.

        `goal` is the 4x4 pose of the tool centre point when it picks.

        Example:
            >>> program.pick_at(robot, belt_t_tcp, reference="belt", approach=0.1, state="closed")
        """
        check_options(options, PickAtOptions, "besides its goal a pick")
        distance = value_or_default(options.pop("max_distance", None), "max_distance")
        step = motion_pb2.PickAtStep(part=part, max_distance_meters=distance)
        self._steps.add(pick_at=handled(step, robot, goal, options))
        return self

    def place_at(
        self, robot: Named, goal: PoseLike, part: str | None = None, **options: Unpack[PlaceAtOptions]
    ) -> Program:
        """Add a step that goes to before a place, along a line to it, opens the tool, lets go and goes back.

        Example:
            >>> program.place_at(robot, place_t_tcp, reference="place", approach=0.1, state="open", parent="pallet")
        """
        check_options(options, PlaceAtOptions, "besides its goal a place")
        step = motion_pb2.PlaceAtStep(part=part, parent=options.pop("parent", None))
        self._steps.add(place_at=handled(step, robot, goal, options))
        return self

    def repeat(self, count: Count, steps: Program) -> Program:
        """Add a step that makes the steps of a program `count` times.

        Example:
            >>> program.repeat(3, client.program().move(robot.linear(there)).move(robot.linear(back)))
        """
        repeat = motion_pb2.RepeatStep(count=count, steps=steps._steps)
        self._take_programs(steps)
        self._steps.add(repeat=repeat)
        return self

    def call(self, steps: Program, name: str | None = None) -> Program:
        """Add a step that makes the steps of another program, which is told once however often it is called."""
        if steps is self:
            raise InvalidArgumentError("the program calls itself; give call another one")
        known = self._spec.programs
        wanted = motion_pb2.SubProgram(steps=steps._steps)
        name = name or next((one for one, program in known.items() if program == wanted), f"program-{len(known)}")
        self._take_programs(steps, {name: wanted})
        self._steps.add(call=motion_pb2.CallStep(program=name))
        return self

    def pattern(self, name: str, pattern: Pattern, steps: Program, *, reference: str = "world") -> Program:
        """Add a step that makes the steps of a program at each place of a pattern, in the frame of `reference`.

        In goals of these steps the reference `name` means the place.

        Example:
            >>> one = client.program().place_at(robot, place_t_tcp, reference="place", approach=0.1, state="open")
            >>> pallet = virtualrobot.Pattern(columns=2, rows=3, column_pitch=0.2, row_pitch=0.15)
            >>> program.pattern("place", pallet, one, reference="pallet")
        """
        self._take_programs(steps)
        step = motion_pb2.PatternStep(name=name, reference=reference, pattern=pattern._message, steps=steps._steps)
        self._steps.add(pattern=step)
        return self

    def if_(
        self,
        signal: str,
        value: GivenValue = True,
        comparison: str = "==",
        *,
        then: Program,
        otherwise: Program | None = None,
    ) -> Program:
        """Add a step that makes the steps of one program or of another, as a signal compares with a value then.

        What comes after it is planned when it is reached; the program stands meanwhile.

        Example:
            >>> program.if_("full", then=client.program().move(robot.linear(away)))
        """
        wish = motion_pb2.IfStep(condition=condition(signal, value, comparison), then=then._steps)
        self._take_programs(then)
        if otherwise is not None:
            wish.otherwise.extend(otherwise._steps)
            self._take_programs(otherwise)
        self._steps.add(if_signal=wish)
        return self

    def while_(
        self, steps: Program, signal: str | None = None, value: GivenValue = True, comparison: str = "=="
    ) -> Program:
        """Add a step that makes the steps of a program again and again, as long as a signal compares so with a value.

        Without a signal it does so for ever, each round being planned while the one before is done.
        """
        loop = motion_pb2.WhileStep(steps=steps._steps)
        if signal is not None:
            loop.condition.CopyFrom(condition(signal, value, comparison))
        self._take_programs(steps)
        self._steps.add(while_signal=loop)
        return self

    def _take_programs(self, steps: Program, more: Mapping[str, motion_pb2.SubProgram] | None = None) -> None:
        """Know the programs that steps call, too; two of one name must be the same."""
        known = self._spec.programs
        for name, program in {**steps._spec.programs, **(more or {})}.items():
            if name in known and known[name] != program:
                raise InvalidArgumentError(
                    f"two programs are called {name!r}; give `call` another name for one of them"
                )
            known[name].CopyFrom(program)

    def start(
        self, *, open: bool = False, breakpoints: Iterable[str] = (), **options: Unpack[motion.StartOptions]
    ) -> motion.Motion:
        """Plan all steps and start; the options are those of `Robot`.

        It pauses before each of the `breakpoints`, steps as `Motion.step_path` tells them: `4[2].0` in the third round
        alone, `4.0` in every round; `Motion.resume` and `run_step` let it go on.
        An `open` program is not waited for: `Motion.append` gives it more steps while it runs. An error of
        the planner names the step, in its message and as `metadata["step"]`; then nothing moves.
        """
        return motion.start_spec(self._services, self._spec, open=open, breakpoints=breakpoints, **options)

    def plan(self, **options: Unpack[plans.PlanOptions]) -> plans.MotionPlan:
        """Return what it would do, in samples; see `Client.plan`. Nothing moves."""
        return plans.plan(self._services, self._spec, **options)

    def check(self, **options: Unpack[plans.CheckOptions]) -> plans.MotionCheck:
        """Return whether it keeps all limits and touches nothing, and else what it violates; see `Client.check`.

        Example:
            >>> found = program.check()
            >>> if not found.ok:
            ...     print(found.first_violation.step, found.first_violation)
        """
        return plans.check(self._services, self._spec, **options)

    def flat(self) -> tuple[Program, tuple[str, ...]]:
        """Return a program of the elementary steps that it makes, and the place of each in the text.

        Repeats, calls, patterns, picks and places are told by what they stand for: `4[2].0` is the first step within
        step 4 in its third round. Steps that decide as the program runs stay, with flat steps within them, whose places
        come after their own; those of a loop are told in its first round.
        """
        request = motion_pb2.ReadProgramRequest(spec=self._spec, flat=True)
        answer = self._services.motion.ReadProgram(request, timeout=LONG_TIMEOUT_SECONDS)
        return Program(self._services, answer.spec), tuple(answer.step_paths)

    @property
    def text(self) -> str:
        """The program as its file says it (JSON, which is YAML too); `Client.program` takes it."""
        said = json_format.MessageToDict(self._spec, preserving_proto_field_name=True)
        return json.dumps({"schema_version": SCHEMA_VERSION, **said})

    def __len__(self) -> int:
        """Return the number of steps."""
        return len(self._spec.steps) or int(bool(self._spec.moves))

    @property
    def _steps(self) -> RepeatedCompositeFieldContainer[motion_pb2.ProgramStep]:
        """Steps, to be appended or appended to; moves that a file gives without steps become the first one."""
        if self._spec.moves:
            self._spec.steps.add().move.moves.extend(self._spec.moves)
            del self._spec.moves[:]
        return self._spec.steps

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Program of {len(self)} step{'s' * (len(self) != 1)}>"


def read(services: Services, file: str | Path) -> Program:
    """Return what a program file says; see `Client.read_program`."""
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidArgumentError(f"{file} is no program file: {error}") from error
    return parsed(services, text, str(file))


def parsed(services: Services, text: str, uri: str) -> Program:
    """Return what a text says, which is called `uri` in errors."""
    request = motion_pb2.ReadProgramRequest(text=text, uri=uri)
    return Program(services, services.motion.ReadProgram(request, timeout=LONG_TIMEOUT_SECONDS).spec)
