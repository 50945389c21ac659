"""From consecutive move steps to plans: those that are joined by zones become one path with one time law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.blend import Corner, rounded
from virtualrobot_kernel.motion.bounds import JointBound, TcpBound, TimeLaw
from virtualrobot_kernel.motion.brake import nominal_time
from virtualrobot_kernel.motion.limits import CartesianLimits, JointLimits
from virtualrobot_kernel.motion.path_law import path_law
from virtualrobot_kernel.motion.planned import Plan, planned
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial, stacked
from virtualrobot_kernel.planning.moves import (
    JointTrajectory,
    PlannedMove,
    ToolStateMove,
    joint_limits,
    plan_moves,
    together,
)
from virtualrobot_kernel.planning.notes import Note, NoteKind
from virtualrobot_kernel.planning.program import MoveStepWish, Zone
from virtualrobot_kernel.planning.robots import SolverOf, arm_of, flange_t_tcp, tip_of, world_poses
from virtualrobot_kernel.planning.zones import Fitted, Position, fitted
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind

Floats = NDArray[np.float64]
Column = tuple[str, str]
"""Robot and joint."""

_LOOKS = 17
"""In how many places of a move its speed is looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class PlannedRun:
    """Move steps that became one plan, at rest at both ends.

    joints: (robot, joint) of each column. steps: nominal times (s) at which steps begin, with their numbers; a step
    after a zone begins in the zone's middle. tool_states: (tool, state) that are true at its end.
    """

    joints: tuple[Column, ...]
    plan: Plan
    steps: tuple[tuple[float, int], ...]
    tool_states: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """A step that is planned for itself, the world where it begins, and how long the plan takes to its middle."""

    number: int
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

    @property
    def halves(self) -> tuple[float, float]:
        """How long the plan takes to the middle of its path, and from there, in s; of several paths of the first."""
        track = next(track for track in self.plan.tracks if track.path.dimension)
        middle = nominal_time(track.time_law, 0.5 * (track.path.start + track.path.end), 0.0)
        return middle, self.plan.duration - middle


def plan_run(
    snapshot: Snapshot, steps: Sequence[MoveStepWish], solver_of: SolverOf, numbers: Sequence[int] | None = None
) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of consecutive move steps, one after the other, and what became of their zones.

    Steps that are joined by zones become one plan; where two can't be joined, or would be slower so than with a stop in
    between, the corner is reached exactly and at rest, which a note tells. numbers: what the steps are called in plans,
    notes and errors; from 0 without it. Raises KernelError that names the step which can't be planned.
    """
    planned_steps = _each(snapshot, steps, solver_of, range(len(steps)) if numbers is None else numbers)
    notes = [replace(note, step=step.number) for step in planned_steps for one in step.moves for note in one.notes]
    runs: list[PlannedRun] = []
    group: list[_Step] = []
    for place, step in enumerate(planned_steps):
        group.append(step)
        if step.zone is not None and not (why := _obstacle(planned_steps[place : place + 2])):
            continue
        if step.zone is not None:
            notes.append(_dropped(step, why))
        found, told = _group(group)
        runs, notes, group = [*runs, *found], [*notes, *told], []
    return runs, sorted(notes, key=lambda note: note.step)


def run_together(snapshot: Snapshot, wish: MoveStepWish, moves: list[PlannedMove]) -> PlannedRun:
    """Return planned moves that start and end together as one run of one step."""
    return _alone(_Step(0, None, moves, together(moves), snapshot, "", _law(wish)))


def arrived(snapshot: Snapshot, joints: Sequence[Column], q: Floats) -> Snapshot:
    """Return the world with joints, (robot, joint), at q (k,), and nothing else different."""
    structure, state = snapshot.structure, snapshot.state
    everything = state.q.copy()
    for (robot, joint), value in zip(joints, q, strict=True):
        everything[single_joint(structure, structure.node(robot, Kind.ROBOT), joint)[1]] = value
    state = replace(state, q=everything)
    return replace(snapshot, state=state, world_t_node=world_poses(structure, state))


def _each(
    snapshot: Snapshot, steps: Sequence[MoveStepWish], solver_of: SolverOf, numbers: Sequence[int]
) -> list[_Step]:
    """Return each step planned from where the one before it ends."""
    result = []
    for number, wish in zip(numbers, steps, strict=True):
        try:
            moves = plan_moves(snapshot, wish.moves, solver_of)
        except KernelError as error:
            error.metadata["step"] = str(number)
            error.args = (f"step {number}: {error}",)
            raise
        step = _Step(number, wish.zone, moves, together(moves), snapshot, _unjoined(wish, moves), _law(wish))
        snapshot = arrived(snapshot, step.columns, step.plan.goal)
        result.append(step)
    return result


def _law(wish: MoveStepWish) -> TimeLaw:
    """Return the law of a step: time-optimal when all its moves are."""
    laws = {getattr(move, "time_law", TimeLaw.JERK_LIMITED) for move in wish.moves}
    return TimeLaw.TIME_OPTIMAL if laws == {TimeLaw.TIME_OPTIMAL} else TimeLaw.JERK_LIMITED


def _unjoined(wish: MoveStepWish, moves: Sequence[PlannedMove]) -> str:
    """Return why a step can be joined with no other; nothing where it can."""
    for move in wish.moves:
        if isinstance(move, JointTrajectory):
            return "a joint trajectory has times of its own"
        if isinstance(move, ToolStateMove):
            return "a tool changes its state while it stands still"
    if any(one.seen for one in moves):
        return "one robot goes along with another"
    if not any(one.plan.duration > 0.0 for one in moves):
        return "it moves nothing"
    return ""


def _obstacle(pair: Sequence[_Step]) -> str:
    """Return why a step is not joined with the one after it; nothing where it is."""
    if len(pair) < 2:
        return "no moves follow"
    for step in pair:
        if step.obstacle:
            return f"step {step.number} can't be joined: {step.obstacle}"
    if pair[0].law is not pair[1].law:
        return f"steps {pair[0].number} and {pair[1].number} have different time laws"
    return ""


def _dropped(step: _Step, why: str) -> Note:
    message = f"the corner after step {step.number} is reached exactly and at rest: {why}"
    return Note(NoteKind.ZONE_DROPPED, step.number, step.moves[0].robot.name, _size(step), 0.0, message)


def _shrunk(step: _Step, found: Fitted) -> Note:
    assert step.zone is not None
    wanted, unit = _size(step), "%" if step.zone.percent else " m"
    message = f"the zone after step {step.number} is {found.kept:.6g}{unit} instead of {wanted:g}{unit}: {found.why}"
    return Note(NoteKind.ZONE_SHRUNK, step.number, step.moves[0].robot.name, wanted, found.kept, message)


def _size(step: _Step) -> float:
    assert step.zone is not None
    return step.zone.percent or step.zone.meters


def _group(steps: Sequence[_Step]) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of steps that shall be joined, all of them, and of what became of their zones."""
    if len(steps) == 1:
        return [_alone(steps[0])], []
    frame = _Frame(steps)
    corners: list[Corner] = []
    notes: list[Note] = []
    for place, step in enumerate(steps[:-1]):
        assert step.zone is not None
        positions = frame.positions(steps[place : place + 2])
        found = fitted(frame.paths[place], frame.paths[place + 1], step.zone, positions, frame.limits)
        if found.corner is None:
            return _split(steps, place, found.why)
        corners.append(found.corner)
        if found.kept < _size(step):
            notes.append(_shrunk(step, found))
    try:
        run, losses = frame.joined(corners)
    except KernelError as error:
        return _split(steps, len(corners) // 2, f"no time law was found ({error})")
    worst = int(np.argmax(losses))
    if losses[worst] > 0.0:
        why = f"with it the robot would be slower by {losses[worst]:.3g} s"
        runs, told = _split(steps, worst, why)
        if sum(one.plan.duration for one in runs) < run.plan.duration:
            return runs, told
    return [run], notes


def _alone(step: _Step) -> PlannedRun:
    """Return a step that is joined with no other; where robots go along with others, all moves have one time law."""
    if any(one.seen for one in step.moves):
        return _Frame([step]).joined([])[0]
    tool_states = tuple(pair for one in step.moves for pair in one.tool_states)
    return PlannedRun(tuple(step.columns), step.plan, ((0.0, step.number),), tool_states)


def _split(steps: Sequence[_Step], place: int, why: str) -> tuple[list[PlannedRun], list[Note]]:
    """Return the plans of steps without the zone of the step at `place`, for this reason."""
    first, told = _group(steps[: place + 1])
    second, more = _group(steps[place + 1 :])
    return [*first, *second], [*told, _dropped(steps[place], why), *more]


class _Frame:
    """What steps that are joined have in common: the columns, the paths of all of them, limits."""

    def __init__(self, steps: Sequence[_Step]) -> None:
        self.steps = steps
        # Arms that are led along a course first, so that their joints are next to each other and in order.
        moves = sorted((one for step in steps for one in step.moves), key=lambda one: one.tcp is None)
        self.columns = list(dict.fromkeys((one.robot.name, name) for one in moves for name in one.joint_names))
        self.places = {column: place for place, column in enumerate(self.columns)}
        structure = steps[0].snapshot.structure
        self.q_index = np.array(
            [single_joint(structure, structure.node(robot), joint)[1] for robot, joint in self.columns]
        )
        self.limits = self._limits()
        self.paths = [self._path(step) for step in steps]

    def joined(self, corners: Sequence[Corner]) -> tuple[PlannedRun, list[float]]:
        """Return the steps as one plan, and for each corner by how many seconds it is slower than stopping there."""
        whole = rounded(self.paths, corners)
        shares = [self._shares(step) for step in self.steps]
        tcps = [{one.robot.uid: one.tcp for one in step.moves if one.tcp} for step in self.steps]
        joints = [JointBound(*part, share) for part, share in zip(whole.moves, map(_known, shares), strict=True)]
        bounds = [
            self._placed(tcp, uid, part)
            for part, led in zip(whole.moves, tcps, strict=True)
            for uid, tcp in led.items()
        ]
        for place, part in enumerate(whole.corners):
            joints.append(JointBound(*part, _known(np.fmax(shares[place], shares[place + 1]))))
            for uid, tcp in self._led_through(place, tcps).items():
                bounds.append(self._placed(tcp, uid, part))
        for part, step in zip(whole.moves, self.steps, strict=True):
            seen = [one.seen for one in step.moves if one.seen]
            bounds += [TcpBound(*part, slice(0, len(self.columns)), one.by(self.q_index), one.limits) for one in seen]
        joints = [bound for bound in joints if bound.end > bound.begin]
        bounds = [bound for bound in bounds if bound.end > bound.begin]
        law = path_law(whole.path, self.limits, joints, bounds, self.steps[0].law)
        goal = arrived(self.steps[-1].snapshot, self.steps[-1].columns, self.steps[-1].plan.goal).state.q[self.q_index]
        plan = planned("blend", whole.path, law, self.limits, goal)
        middles = [nominal_time(law, 0.5 * (begin + end), 0.0) for begin, end in whole.corners]
        times = [0.0, *middles]
        steps = tuple((time, step.number) for time, step in zip(times, self.steps, strict=True))
        tool_states = tuple(pair for step in self.steps for one in step.moves for pair in one.tool_states)
        passed = [nominal_time(law, 0.5 * (begin + end), 0.0) for begin, end in whole.moves]
        passed[0], passed[-1] = 0.0, plan.duration
        halves = [step.halves for step in self.steps]
        halves[0] = (0.0, self.steps[0].plan.duration)
        halves[-1] = (self.steps[-1].plan.duration, 0.0)
        losses = [
            passed[place + 1] - passed[place] - halves[place][1] - halves[place + 1][0] for place in range(len(corners))
        ]
        return PlannedRun(tuple(self.columns), plan, steps, tool_states), losses

    def positions(self, steps: Sequence[_Step]) -> list[Position]:
        """Return where the tool centre points of the robots of steps are, by the joints of all columns."""
        snapshot = steps[0].snapshot
        robots = {one.robot.uid: one.robot for step in steps for one in step.moves}
        found: list[Position] = []
        for robot in robots.values():
            arm = arm_of(snapshot, robot)
            if arm.chain is None:
                continue
            tip, point = tip_of(snapshot, arm), flange_t_tcp(snapshot, robot)[:, 3]
            own = [int(np.flatnonzero(arm.q_index == index)[0]) for index in self.q_index if index in arm.q_index]
            columns = np.flatnonzero(np.isin(self.q_index, arm.q_index))
            base = snapshot.state.q[arm.q_index]

            def position(
                q: Floats, tip=tip, point=point, own=own, columns=columns, base=base  # noqa: ANN001 each as above
            ) -> Floats:
                mine = base.copy()
                mine[own] = q[columns]
                return (tip(mine) @ point)[:3]

            found.append(position)
        return found

    def _limits(self) -> JointLimits:
        parts = [
            joint_limits(self.steps[0].snapshot, self.steps[0].snapshot.structure.node(robot), [joint])[0]
            for robot, joint in self.columns
        ]
        fields = ("lower", "upper", "velocity", "acceleration", "jerk")
        return JointLimits(
            tuple(joint for _, joint in self.columns),
            **{field: np.concatenate([getattr(part, field) for part in parts]) for field in fields},
        )

    def _path(self, step: _Step) -> PiecewisePolynomial:
        """Return the path of a step for all columns; its parameter is the time in s that it takes at cruise speed."""
        seconds = max(self._seconds(one) for one in step.moves)
        moved = [one for one in step.moves if one.joint_names]
        still = [column for column in self.columns if column not in step.columns]
        parts = [one.plan.tracks[0].path.onto(0.0, seconds) for one in moved]
        if still:
            there = step.snapshot.state.q[self.q_index[[self.places[column] for column in still]]]
            parts.append(PiecewisePolynomial(np.array([0.0, seconds]), there[None, None, :]))
        path = stacked(parts)
        order = np.argsort([self.places[column] for column in [*step.columns, *still]])
        return PiecewisePolynomial(path.breaks, path.coefficients[:, :, order])

    def _seconds(self, one: PlannedMove) -> float:
        """Return how long a move takes at the greatest speed that its joints and its tool centre point may have."""
        if not one.joint_names:
            return 0.0
        path = one.plan.tracks[0].path
        q, rates = path.states(np.linspace(path.start, path.end, _LOOKS), 1)
        columns = [self.places[one.robot.name, name] for name in one.joint_names]
        seconds = float((np.abs(rates) / (self.limits.velocity[columns] * one.speed_factor)).max())
        if one.tcp is not None:
            limits = one.tcp.limits
            twists = [one.tcp.tcp.jacobian(here) @ rate for here, rate in zip(q, rates, strict=True)]
            moving = max(float(np.linalg.norm(twist[:3])) for twist in twists) / limits.velocity
            turning = max(float(np.linalg.norm(twist[3:])) for twist in twists) / limits.rotation_velocity
            seconds = max(seconds, moving, turning)
        return seconds * (path.end - path.start)

    def _shares(self, step: _Step) -> Floats:
        """Return for each column the speed factor of the move that moves it; not a number where none does."""
        shares = np.full(len(self.columns), np.nan)
        for one in step.moves:
            shares[[self.places[one.robot.name, name] for name in one.joint_names]] = one.speed_factor
        return shares

    def _placed(self, tcp: TcpBound, uid: int, part: tuple[float, float]) -> TcpBound:
        """Return what an arm keeps of its tool centre point, on a part of the run's parameter and in its columns."""
        robot = self.steps[0].snapshot.structure.nodes[uid].name
        first = next(place for place, (name, _) in enumerate(self.columns) if name == robot)
        return replace(tcp, begin=part[0], end=part[1], columns=slice(first, first + tcp.columns.stop))

    def _led_through(self, place: int, tcps: Sequence[dict[int, TcpBound]]) -> dict[int, TcpBound]:
        """Return what the tool centre points keep in a corner: the larger limits of those that are led on both sides.

        One that is led on one side and stands still on the other keeps that side's.
        """
        before, after = tcps[place], tcps[place + 1]
        robots = [{one.robot.uid for one in step.moves} for step in self.steps[place : place + 2]]
        result = {}
        for uid in before.keys() | after.keys():
            if uid in before and uid in after:
                result[uid] = replace(before[uid], limits=_larger(before[uid].limits, after[uid].limits))
            elif uid not in robots[1] or uid not in robots[0]:
                result[uid] = before.get(uid) or after[uid]
        return result


def _known(shares: Floats) -> Floats:
    return np.where(np.isnan(shares), 1.0, shares)


def _larger(one: CartesianLimits, other: CartesianLimits) -> CartesianLimits:
    return CartesianLimits(*(max(pair) for pair in zip(vars(one).values(), vars(other).values(), strict=True)))
