"""Move steps of a program, planned one by one, each from where the one before it ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.motion.planned import Plan, plan_together
from virtualrobot_kernel.planning.planned_move import PlannedMove
from virtualrobot_kernel.planning.program import MoveStep, Step, Zone, step_name
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf, standing_at
from virtualrobot_kernel.planning.together import plan_moves
from virtualrobot_kernel.world.change import joint_places
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Column = tuple[str, str]
"""Robot and joint of a column, by name."""

GoOn = Callable[[], None]
"""Callback before each step and each corner; raises KernelError when nobody waits for the plan any more."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedStep:
    """Step that is planned for itself, the world where it begins, and the obstacle to joining it with others."""

    number: int
    name: str
    zone: Zone | None
    moves: list[PlannedMove]
    plan: Plan
    snapshot: Snapshot
    obstacle: str
    law: TimeLaw

    @property
    def columns(self) -> list[Column]:
        """Robot and joint of each column of the plan."""
        return [(one.robot.name, name) for one in self.moves for name in one.joint_names]

    def arrived(self) -> Snapshot:
        """Return the world where it ends."""
        return arrived(self.snapshot, self.columns, self.plan.goal)


def plan_step(
    snapshot: Snapshot, number: int, step: MoveStep, solver_of: SolverOf, near_of: NearOf | None = None
) -> PlannedStep:
    """Return a step planned from where the joints are; raise KernelError with place and reason."""
    moves = plan_moves(snapshot, step.moves, solver_of, near_of)
    # Moves that start and end together are one plan, their joints one after the other.
    plan = moves[0].plan if len(moves) == 1 else plan_together([one.plan for one in moves])
    if step.min_duration > plan.duration > 0.0:
        moves = [_slower(one, step.min_duration) for one in moves]
        plan = moves[0].plan if len(moves) == 1 else plan_together([one.plan for one in moves])
    laws = {getattr(move, "time_law", TimeLaw.JERK_LIMITED) for move in step.moves}
    law = TimeLaw.TIME_OPTIMAL if laws == {TimeLaw.TIME_OPTIMAL} else TimeLaw.JERK_LIMITED
    return PlannedStep(number, step_name(step, number), step.zone, moves, plan, snapshot, _obstacle(step, moves), law)


def plan_steps(
    snapshot: Snapshot,
    steps: Sequence[MoveStep],
    solver_of: SolverOf,
    numbers: Sequence[int] | None = None,
    go_on: GoOn = lambda: None,
    near_of: NearOf | None = None,
) -> list[PlannedStep]:
    """Return each step planned from where the one before it ends; raise KernelError that names the step.

    numbers: what the steps are called in plans, notes and errors; from 0 without it.
    """
    result: list[PlannedStep] = []
    for number, step in zip(range(len(steps)) if numbers is None else numbers, steps, strict=True):
        go_on()
        try:
            planned = plan_step(snapshot, number, step, solver_of, near_of)
        except KernelError as error:
            named_error(error, number, step)
            raise
        snapshot = planned.arrived()
        result.append(planned)
    return result


def _slower(one: PlannedMove, seconds: float) -> PlannedMove:
    """Return a move of a step that takes some seconds in place of fewer."""
    if one.relative_tcp is not None or one.plan.kind == "trajectory":
        what = "a move that carries others, or is carried" if one.relative_tcp else "a joint trajectory"
        raise KernelError(f"{what} has a time of its own, and takes no min_duration", robot=one.robot.name)
    tracks = tuple(replace(track, time_law=track.time_law.stretched(seconds)) for track in one.plan.tracks)
    return replace(one, plan=replace(one.plan, tracks=tracks))


def named_error(error: KernelError, number: int, step: Step) -> KernelError:
    """Return an error that names the step, in words and in its metadata."""
    error.metadata["step"], error.metadata["step_path"] = str(number), step_name(step, number)
    error.args = (f"step {step_name(step, number)}: {error}",)
    return error


def arrived(snapshot: Snapshot, joints: Sequence[Column], q: NDArray[np.float64]) -> Snapshot:
    """Return the world with joints, (robot, joint), at q (k,), and nothing else different."""
    structure = snapshot.structure
    named = tuple((structure.node(robot, Kind.ROBOT).uid, joint) for robot, joint in joints)
    return standing_at(snapshot, joint_places(structure, named)[0], q)


def _obstacle(step: MoveStep, moves: Sequence[PlannedMove]) -> str:
    """Return why a step can be joined with no other; nothing where it can."""
    if why := next((move.not_joined for move in step.moves if move.not_joined), ""):
        return why
    if step.min_duration:
        return "it has a duration of its own"
    if any(one.relative_tcp for one in moves):
        return "one robot goes along with another"
    if any(one.plan.tracks[0].quasi for one in moves):
        return "it turns a floating joint"
    if not any(one.plan.duration > 0.0 for one in moves):
        return "it moves nothing"
    return ""
