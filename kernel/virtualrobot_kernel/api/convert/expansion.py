"""Steps made of steps: what a program's text says once, to the steps that are planned. Pure, messages to messages.

Each step keeps its place in the text as a path: `4[2].0` is the first step within step 4, in the third round of it.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from google.protobuf.message import Message
from numpy.typing import NDArray
from virtualrobot.v1 import motion_pb2, scene_pb2

from virtualrobot_kernel.api.convert.patterns import place_count, places
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.messages.values import not_negative, pose, pose_message, vector, vector_message
from virtualrobot_kernel.planning.program import MAX_STEPS

Steps = Iterable[motion_pb2.ProgramStep]
Programs = Mapping[str, motion_pb2.SubProgram]
Frames = Mapping[str, tuple[str, NDArray[np.float64]]]
"""Node, and pose (4, 4) in its frame, that a name in goals stands for."""

DEEPEST = 30
"""Greatest number of steps within each other."""

NESTED = ("repeat", "call", "pattern", "pick_at", "place_at", "if_signal", "while_signal")
"""Kinds of steps that stand for others."""
_BRANCHES = {"if_signal": {"then": ".then.", "otherwise": ".otherwise."}, "while_signal": {"steps": "[0]."}}
"""Fields of the steps that decide, and what their paths go on with there."""


@dataclass(frozen=True, slots=True)
class Place:
    """Place of steps in a program's text: their path up to their own numbers, and that of the fields.

    calls: the programs that led here. once: whether each step is told once, whatever decides about it. kept: whether
    steps that decide are told as such, with the flat steps of what they decide about within them.
    """

    path: str = ""
    what: str = "steps"
    first: int = 0
    frames: Frames = field(default_factory=dict)
    calls: tuple[str, ...] = ()
    depth: int = 0
    once: bool = False
    kept: bool = False

    def name(self, number: int) -> str:
        """Return the path of a step here."""
        return f"{self.path}{number + self.first}"


@dataclass(frozen=True, slots=True, eq=False)
class FlatStep:
    """Step that stands for nothing but itself: its path, what its fields are called in errors, and its message.

    within: the steps of one that decides, where these are kept.
    """

    path: str
    what: str
    message: motion_pb2.ProgramStep
    within: tuple[FlatStep, ...] = ()

    def paths(self) -> list[str]:
        """Return its path and those of the steps within it."""
        return [self.path, *(path for one in self.within for path in one.paths())]


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """Place in a program's text at which it is known only when it is reached what comes next.

    condition: what decides; None where a round of a loop without end comes to its end.
    """

    path: str
    what: str
    condition: motion_pb2.SignalCondition | None


Text = Generator[FlatStep | Decision, bool | None, None]
"""Steps that a program's text stands for, one by one; what is sent after a decision is whether its condition holds."""


def text_of(steps: Sequence[motion_pb2.ProgramStep], programs: Programs, first: int = 0) -> Text:
    """Return the steps that a program's text stands for, whose outermost steps are numbered from `first`.

    Raises KernelError that names step and field: for programs that are unknown, empty or call themselves, counts of
    zero, numbers that are not finite, and more steps than a program may have.
    """
    return _text(steps, programs, Place(first=first))


def _text(steps: Sequence[motion_pb2.ProgramStep], programs: Programs, at: Place) -> Text:
    sizes: dict[str, int] = {}
    count = _size(steps, programs, at, sizes)
    if count > MAX_STEPS:
        raise KernelError(
            f"a program has at most {MAX_STEPS} steps, and these stand for {count}",
            reason=Reason.TOO_LARGE,
            steps=count,
        )
    return _flat(steps, programs, at)


def next_part(text: Text, holds: bool | None = None) -> tuple[list[FlatStep], Decision | None]:
    """Return the next steps of a text up to a decision, None at its end; `holds` answers the decision before."""
    found: list[FlatStep] = []
    try:
        step = text.send(holds)
        while isinstance(step, FlatStep):
            found.append(step)
            step = next(text)
    except StopIteration:
        return found, None
    return found, step


def flat_program(spec: motion_pb2.MotionSpec) -> tuple[motion_pb2.MotionSpec, list[str]]:
    """Return a program with the steps that its text stands for, and their paths; moves become its only step.

    Steps that decide stay, with flat steps within them, whose paths come after their own; those of a loop are the paths
    of its first round. Raises KernelError as `text_of`.
    """
    steps = spec.steps or [motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=spec.moves))]
    found = [step for step in _text(steps, spec.programs, Place(kept=True)) if isinstance(step, FlatStep)]
    tracking = spec.tracking if spec.HasField("tracking") else None
    flat = motion_pb2.MotionSpec(steps=[step.message for step in found], tracking=tracking)
    return flat, [path for step in found for path in step.paths()]


def each_once(steps: Sequence[motion_pb2.ProgramStep], programs: Programs, first: int = 0) -> list[FlatStep]:
    """Return each step of a text once, whatever decides whether it is done, in its first round or place."""
    every = _flat(steps, programs, Place(first=first, once=True))
    return [step for step in every if isinstance(step, FlatStep)]


def named_robots(steps: Steps, programs: Programs | None = None) -> set[str]:
    """Return the robots that steps and the steps within them name, once each."""
    found: set[str] = set()
    left = [*steps, *(step for one in (programs or {}).values() for step in one.steps)]
    while left:
        kind = (step := left.pop()).WhichOneof("step")
        content: Any = getattr(step, kind) if kind else step
        for name in ("steps", "then", "otherwise"):
            left += getattr(content, name, ())
        found |= {move.robot for move in getattr(content, "moves", ())}
        if robot := getattr(content, "robot", ""):
            found.add(robot)
    return found


def _size(steps: Steps, programs: Programs, at: Place, sizes: dict[str, int]) -> int:
    """Return how many steps these stand for; `sizes` are those of the programs that have been counted."""
    total, number = 0, -1
    for number, step in enumerate(steps):
        try:
            total += _size_of(step, programs, at, number, sizes)
        except KernelError as error:
            error.metadata.setdefault("step", at.name(number))
            error.metadata.setdefault("step_path", at.name(number))
            raise
    if number < 0 and at.depth:
        raise KernelError(f"{at.what} is empty: what shall be done?", field=at.what)
    return total


def _size_of(step: motion_pb2.ProgramStep, programs: Programs, at: Place, number: int, sizes: dict[str, int]) -> int:
    kind = step.WhichOneof("step")
    what = f"{at.what}[{number + at.first}].{kind}"
    if at.depth > DEEPEST:
        raise KernelError(f"{what} lies in more than {DEEPEST} other steps", field=what)
    inner = replace(at, path=f"{at.name(number)}.", what=f"{what}.steps", first=0, depth=at.depth + 1)
    if kind == "repeat":
        if not step.repeat.count:
            raise KernelError(f"{what}.count must be at least 1", field=f"{what}.count")
        return step.repeat.count * _size(step.repeat.steps, programs, inner, sizes)
    if kind == "pattern":
        if not step.pattern.name:
            raise KernelError(f"{what}.name is empty: how shall goals call the place?", field=f"{what}.name")
        return place_count(step.pattern.pattern, f"{what}.pattern") * _size(step.pattern.steps, programs, inner, sizes)
    if kind == "call":
        name = step.call.program
        if name in at.calls:
            way = " calls ".join(map(repr, (*at.calls[at.calls.index(name) :], name)))
            raise KernelError(f"{what}: a program may not lead back to itself, and {way}", field=what, program=name)
        if name not in programs:
            raise UnknownNameError("program", name, programs)
        if name not in sizes:
            called = replace(inner, what=f"programs[{name!r}].steps", calls=(*at.calls, name))
            sizes[name] = _size(programs[name].steps, programs, called, sizes)
        return sizes[name]
    if kind in ("pick_at", "place_at"):
        return len(_at_steps(step, what))
    if kind == "while_signal":
        return 1 + _size(step.while_signal.steps, programs, inner, sizes)
    if kind == "if_signal":
        wish, other = step.if_signal, replace(inner, what=f"{what}.otherwise")
        then = _size(wish.then, programs, replace(inner, what=f"{what}.then"), sizes)
        return 1 + then + (_size(wish.otherwise, programs, other, sizes) if wish.otherwise else 0)
    return 1


def _flat(steps: Steps, programs: Programs, at: Place) -> Text:
    for number, step in enumerate(steps):
        kind = step.WhichOneof("step")
        what, path = f"{at.what}[{number + at.first}]", at.name(number)
        inner = replace(at, what=f"{what}.{kind}.steps", first=0, depth=at.depth + 1)
        if kind == "repeat":
            for place in range(1 if at.once else step.repeat.count):
                yield from _flat(step.repeat.steps, programs, replace(inner, path=f"{path}[{place}]."))
        elif kind == "pattern":
            pattern = step.pattern
            base, frame = at.frames.get(pattern.reference, (pattern.reference, np.eye(4)))
            for place, here in enumerate(places(pattern.pattern, f"{what}.{kind}.pattern")):
                if place and at.once:
                    break
                frames = {**at.frames, pattern.name: (base, frame @ here)}
                yield from _flat(pattern.steps, programs, replace(inner, path=f"{path}[{place}].", frames=frames))
        elif kind == "call":
            name = step.call.program
            called = replace(inner, path=f"{path}.", what=f"programs[{name!r}].steps", calls=(*at.calls, name))
            yield from _flat(programs[name].steps, programs, called)
        elif kind in ("pick_at", "place_at"):
            for place, part in enumerate(_at_steps(step, f"{what}.{kind}")):
                yield FlatStep(f"{path}.{place}", f"{what}.{kind}", _framed(part, at.frames, f"{what}.{kind}"))
        elif at.kept and kind in _BRANCHES:
            yield _decision(step, programs, replace(inner, path=path), what)
        elif kind == "if_signal":
            yield FlatStep(path, what, step)
            wish = step.if_signal
            holds = yield Decision(path, f"{what}.{kind}", wish.condition)
            for branch, name in ((wish.then, "then"), (wish.otherwise, "otherwise")):
                if at.once or bool(holds) == (name == "then"):
                    inner = replace(inner, path=f"{path}.{name}.", what=f"{what}.{kind}.{name}")
                    yield from _flat(branch, programs, inner)
        elif kind == "while_signal":
            yield from _loop(step, programs, replace(inner, path=path), what)
        else:
            yield FlatStep(path, what, _framed(step, at.frames, what))


def _decision(step: motion_pb2.ProgramStep, programs: Programs, at: Place, what: str) -> FlatStep:
    """Return a step that decides, with flat steps within it."""
    kind, found, within = step.WhichOneof("step") or "", motion_pb2.ProgramStep(), list[FlatStep]()
    found.CopyFrom(step)
    for name, path in _BRANCHES[kind].items():
        inner = replace(at, path=f"{at.path}{path}", what=f"{what}.{kind}.{name}")
        text = _flat(getattr(getattr(step, kind), name), programs, inner)
        branch = [one for one in text if isinstance(one, FlatStep)]
        kept = getattr(getattr(found, kind), name)
        del kept[:]
        kept.extend(one.message for one in branch)
        within += branch
    return FlatStep(at.path, what, found, tuple(within))


def _loop(step: motion_pb2.ProgramStep, programs: Programs, at: Place, what: str) -> Text:
    """Yield the rounds of a loop, before each of which it is decided whether it is done."""
    loop, place = step.while_signal, 0
    while True:
        if loop.HasField("condition"):
            yield FlatStep(at.path, what, step)
            if not (yield Decision(at.path, f"{what}.while_signal", loop.condition)) and not at.once:
                return
        elif place:
            yield Decision(at.path, f"{what}.while_signal", None)
        yield from _flat(loop.steps, programs, replace(at, path=f"{at.path}[{place}]."))
        place += 1
        if at.once:
            return


def _at_steps(step: motion_pb2.ProgramStep, what: str) -> list[motion_pb2.ProgramStep]:
    """Return the steps of going somewhere, handling a part there and going away."""
    picks = step.WhichOneof("step") == "pick_at"
    wish = step.pick_at if picks else step.place_at
    approach, retreat = (
        not_negative(getattr(wish, name), f"{what}.{name}") for name in ("approach_meters", "retreat_meters")
    )
    goal = _pose_of(wish.goal, f"{what}.goal")

    def move(**kind: Message) -> motion_pb2.ProgramStep:
        one = motion_pb2.Move(robot=wish.robot, speed_factor=wish.speed_factor, **kind)  # type: ignore[arg-type]
        return motion_pb2.ProgramStep(move=motion_pb2.MoveStep(moves=[one]))

    def at(distance: float) -> motion_pb2.PoseGoal:
        found = motion_pb2.PoseGoal()
        found.CopyFrom(wish.goal)
        back = np.eye(4)
        back[2, 3] = -distance
        found.reference_t_tcp.CopyFrom(pose_message(goal @ back))
        return found

    def line(distance: float) -> motion_pb2.ProgramStep:
        end = at(distance)
        end.configuration = ""
        velocity, acceleration = wish.max_velocity_meters_per_second, wish.max_acceleration_meters_per_second_squared
        linear = motion_pb2.Linear(
            goal=end,
            max_velocity_meters_per_second=velocity,
            max_acceleration_meters_per_second_squared=acceleration,
        )
        return move(linear=linear)

    def opened(when: str) -> list[motion_pb2.ProgramStep]:
        state, width = f"state{when}", f"width{when}_meters"
        if wish.HasField(width):
            if getattr(wish, state):
                raise KernelError(f"{what} has {state} and {width}; give one of them", field=f"{what}.{width}")
            opening = motion_pb2.ToolStateMove(width_meters=getattr(wish, width))
        elif getattr(wish, state):
            opening = motion_pb2.ToolStateMove(state=getattr(wish, state))
        else:
            return []
        return [move(tool_state=opening)]

    go = move(point_to_point=motion_pb2.PointToPoint(pose=at(approach)))
    if wish.HasField("redundancy"):
        go.move.moves[0].redundancy.CopyFrom(wish.redundancy)
    # Held while the fingers move, so that they may touch it.
    if picks:
        distance = step.pick_at.max_distance_meters
        pick = scene_pb2.PickPart(robot=wish.robot, part=wish.part, max_distance_meters=distance)
        there = [motion_pb2.ProgramStep(pick=pick), *opened("")]
    else:
        place = scene_pb2.PlacePart(robot=wish.robot, part=wish.part, parent=step.place_at.parent)
        there = [*opened(""), motion_pb2.ProgramStep(place=place)]
    lines = [line(0.0)] if approach else []
    away = [line(retreat)] if retreat else []
    return [*opened("_before"), go, *lines, *there, *away]


def _framed(step: motion_pb2.ProgramStep, frames: Frames, what: str) -> motion_pb2.ProgramStep:
    """Return a step whose goals are given in the frames of nodes, where they name places of patterns."""
    if not frames:
        return step
    found = motion_pb2.ProgramStep()
    found.CopyFrom(step)
    for place, move in enumerate(found.move.moves if found.WhichOneof("step") == "move" else ()):
        kind = move.WhichOneof("move")
        content: Any = getattr(move, kind) if kind else None
        name = f"{what}.move.moves[{place}].{kind}"
        if kind == "point_to_point" and content.WhichOneof("goal") == "pose":
            _frame_goal(content.pose, frames, name)
        elif kind == "linear":
            _frame_goal(content.goal, frames, name)
        elif kind == "spline":
            for goal in content.goals:
                _frame_goal(goal, frames, name)
        elif kind == "circular" and content.goal.reference in frames:
            node, frame = frames[content.goal.reference]
            shape = content.WhichOneof("shape")
            turns = shape == "center" and content.center.HasField("angle_radians")
            if turns and not content.goal.HasField("reference_t_tcp"):
                content.goal.reference = node  # the tool keeps its orientation
            else:
                _frame_goal(content.goal, frames, name)
            points = [content.via] if shape == "via" else [content.center.position] if shape else []
            for point in points:
                point.CopyFrom(vector_message(frame[:3, :3] @ vector(point, name) + frame[:3, 3]))
            if shape == "center" and content.center.HasField("axis"):
                content.center.axis.CopyFrom(vector_message(frame[:3, :3] @ vector(content.center.axis, name)))
    if found.WhichOneof("step") == "wait_part" and found.wait_part.reference in frames:
        wait = found.wait_part
        wait.reference, frame = frames[wait.reference]
        point = frame[:3, :3] @ vector(wait.position, f"{what}.wait_part.position") + frame[:3, 3]
        wait.position.CopyFrom(vector_message(point))
    return found


def _frame_goal(goal: motion_pb2.PoseGoal, frames: Frames, what: str) -> None:
    """Give a goal in the frame of a node where it names a place."""
    if goal.reference in frames:
        wanted = _pose_of(goal, what)
        goal.reference, frame = frames[goal.reference]
        goal.reference_t_tcp.CopyFrom(pose_message(frame @ wanted))


def _pose_of(goal: motion_pb2.PoseGoal, what: str) -> NDArray[np.float64]:
    """Return reference_t_tcp (4, 4) of a goal; the frame that it names where it says no more."""
    if goal.reference and not goal.HasField("reference_t_tcp"):
        return np.eye(4)
    return pose(goal.reference_t_tcp, f"{what}.reference_t_tcp")
