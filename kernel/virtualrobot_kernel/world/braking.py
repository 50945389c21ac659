"""Prediction of the world if all that moves braked now."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.plan_execution import PlanExecution
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import ENDED, Phase, RunningMotion
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance

LONGEST_BRAKE_TICKS = 15_000
"""Greatest number of ticks of a brake (a minute, at ticks of 4 ms); a longer one counts as none."""

HARMLESS: frozenset[type] = frozenset(
    {
        *(commands.StartMotion, commands.StartSetpointMotion, commands.SetSetpoint, commands.EndSetpoints),
        *(commands.SetMeasuredJoints, commands.SetDynamics, commands.SetParts, commands.SetContacts),
        *(commands.SetPhysics, commands.GoOn),
        *(commands.CancelMotion, commands.StopMotions, commands.StopRobots, commands.PlayedTicks),
        *(commands.StopCell, commands.ReleaseCell),
        *(commands.CreateSignal, commands.RemoveSignal, commands.SetSignal),
        *(commands.RunSensors, commands.SetRangeComponents, commands.SetKinematics, commands.SelectTool),
        *(commands.SetGroups, commands.SetPostures, commands.SetJointEfforts),
    }
)
"""Commands that put nothing elsewhere and change no way of braking: a motion starts at rest, unless it
`takes_over`, and goes by ticks."""

RATES: frozenset[type] = frozenset(
    {commands.PauseMotion, commands.ResumeMotion, commands.StepMotion, commands.SetSpeedFactor, commands.AppendMotion}
)
"""Commands that change nothing but how motions go on, and with it how they would brake."""


def takes_over(command: commands.Command) -> bool:
    """Return whether a command starts a motion that may take over from others, at their speed."""
    return isinstance(command, commands.StartMotion) and bool(command.from_here and command.from_here.replaces)


@dataclass(frozen=True, slots=True, eq=False)
class BrakePath:
    """Predicted coordinates of the world while all that moves brakes, tick by tick.

    Of joints that motions move it has where they are commanded to be, wherever they are measured or motors have them.

    Attributes:
        tick: the first one.
        positions: (m, nq) the coordinates of the world at that tick and those after it.
        tools: the states of tools, and from which row on they hold; in order, the first from row 0 on.
        ends: whether all stands in the end.
        reached: of motions (ids) that brake by themselves on a path, where on it each track of their stage comes to.
    """

    tick: int
    positions: NDArray[np.float64]
    tools: tuple[tuple[int, Mapping[int, str]], ...]
    ends: bool
    reached: Mapping[str, tuple[float, ...]]

    def after(self, structure: Structure, state: State, motions: Sequence[Motion]) -> BrakePath:
        """Return the way, on which motions brake, that begins one tick earlier, in a state."""
        tools = tuple((row + 1, held) for row, held in self.tools)
        first = () if tools[0][1] is state.tool_states else ((0, state.tool_states),)
        if not first:
            tools = ((0, tools[0][1]), *tools[1:])
        positions = np.concatenate([_moved(structure, state, motions)[None], self.positions])
        return BrakePath(state.tick, positions, (*first, *tools), self.ends, self.reached)


def braking(structure: Structure, state: State, tick_seconds: float, forward: Forward) -> BrakePath:
    """Return the way of the world when all that moves begins to brake now, from the present tick on.

    Motions on plans and by setpoints are asked for their brakes, which is quicker, and to rounding the same, as making
    the ticks; the ticks are made where a motion goes along with a joint, or tools change their states on the way. It
    ends where all stands, or after `LONGEST_BRAKE_TICKS`.
    """
    if state.motions and all(map(brakes_alone, state.motions)):
        ways = [way_of(motion, override(state, motion), tick_seconds) for motion in state.motions]
        count = max(len(way.positions) for way in ways)
        positions = np.empty((count, len(state.q)))
        positions[:] = state.q
        changes: list[tuple[int, dict[int, str]]] = []
        for motion, way in zip(state.motions, ways, strict=True):
            length = len(way.positions)
            positions[:length, motion.q_index] = way.positions
            if length < count:
                positions[length:, motion.q_index] = way.positions[-1]
            if motion.tool_states:
                done = range(motion.running.steps_done if state.tick > motion.start_tick else 0, way.end().steps_done)
                changes.append((length - 1, {tool: name for step, tool, name in motion.tool_states if step in done}))
        tools = [(0, state.tool_states)]
        for row, changed in sorted(changes, key=lambda change: change[0]):
            if changed:
                tools.append((row, {**tools[-1][1], **changed}))
        reached = {motion.id: way.reached for motion, way in zip(state.motions, ways, strict=True) if way.reached}
        return BrakePath(state.tick, positions, tuple(tools), count <= LONGEST_BRAKE_TICKS, reached)
    robots = tuple({uid for motion in state.motions for uid in motion.robots})
    stop = commands.StopRobots(robots, Cancellation(EndCause.COLLISION, ""))
    now = apply(structure, state, [stop], forward).state
    motions = now.motions
    rows, tools = [_moved(structure, now, motions)], [(0, now.tool_states)]
    while now.motions and len(rows) <= LONGEST_BRAKE_TICKS:
        now = advance(structure, now, tick_seconds, forward)
        if now.tool_states is not tools[-1][1]:
            tools.append((len(rows), now.tool_states))
        rows.append(_moved(structure, now, motions))
    return BrakePath(state.tick, np.array(rows), tuple(tools), not now.motions, {})


def _moved(structure: Structure, state: State, motions: Sequence[Motion]) -> NDArray[np.float64]:
    """Return the world's coordinates (nq,), with those that motions move where they are commanded to be."""
    if not (state.commanded or state.motored):
        return state.q
    q, there = state.q.copy(), commanded(structure, state)[0]
    for motion in motions:
        q[motion.q_index] = there[motion.q_index]
    return q


def braking_of(
    robots: Set[int], structure: Structure, state: State, tick_seconds: float, forward: Forward
) -> BrakePath:
    """Return the way of some robots (uids) when all that moves begins to brake now; of others it tells nothing.

    Motions that move none of them are left out with what they cost, unless one goes along with a joint that they move.
    """
    motions = tuple(motion for motion in state.motions if not robots.isdisjoint(motion.robots))
    if not motions:
        return BrakePath(state.tick, state.q[None], ((0, state.tool_states),), True, {})
    if len(motions) < len(state.motions) and all(motion.tracked_joint is None for motion in motions):
        state = replace(state, motions=motions)
    return braking(structure, state, tick_seconds, forward)


def brakes_alone(motion: Motion) -> bool:
    """Return whether a motion brakes by itself, and puts no tool into another state before it stands."""
    if motion.tracked_joint is not None:
        return False
    run = motion.running
    if not motion.tool_states or not isinstance(run, ProgramRun) or run.at == len(run.program.stages):
        return not motion.tool_states
    return len(run.program.stages[run.at].steps) == 1


def on_plan(motion: Motion) -> PlanExecution | None:
    """Return the run of a motion that goes along a plan of one track, by which alone it would brake now; else None."""
    run = motion.running
    if not isinstance(run, ProgramRun) or run.phase is not Phase.RUNNING or run.due:
        return None
    if motion.tool_states or motion.tracked_joint is not None or run.program.places[run.at] is not None:
        return None
    running = run.running
    if running is None or running.phase is not Phase.RUNNING or len(running.plan.tracks) != 1:
        return None
    return running


class Way(NamedTuple):
    """Way of a motion that brakes.

    positions (m, n): where its joints are, a tick apart. end: what gives the motion as it is in the end. reached: where
    on its path each track comes to; None where there is no path.
    """

    positions: NDArray[np.float64]
    end: Callable[[], RunningMotion]
    reached: tuple[float, ...] | None


def way_of(motion: Motion, override: float, dt: float) -> Way:
    """Return the way of a motion that brakes from now on."""
    now = motion.running
    if (rest := _rest(now, override, dt)) is not None:
        return rest
    now = now.cancel()
    rows = [now.sample()[0]]
    while not now.ended and len(rows) <= LONGEST_BRAKE_TICKS:
        if (rest := _rest(now, override, dt)) is not None:
            return rest._replace(positions=np.concatenate([np.array(rows), rest.positions[1:]]))
        now = now.advance(dt, override)
        rows.append(now.sample()[0])
    moving = now.running if isinstance(now, ProgramRun) else None
    reached = tuple(u for u, _, _ in moving.path_states) if moving is not None else None
    return Way(np.array(rows), lambda: now, reached)


def _rest(now: RunningMotion, override: float, dt: float) -> Way | None:
    """Return the way of a motion that brakes from now on where it is told at once; else None."""
    if isinstance(now, ProgramRun):
        ahead = now.stop_ahead(dt, override, LONGEST_BRAKE_TICKS)
        if ahead is None:
            return None
        if ahead.at_goal:
            return Way(ahead.positions, now.arrived, None)
        return Way(ahead.positions, lambda: now, ahead.reached)
    if not isinstance(now, SetpointMotion):
        return None
    positions = now.stop_ahead(dt, LONGEST_BRAKE_TICKS)
    return None if positions is None else Way(positions, lambda: now, None)


def going(state: State) -> frozenset[int]:
    """Return the robots (uids) of motions that do not brake yet."""
    return frozenset(
        uid for motion in state.motions if motion.running.phase not in (Phase.STOPPING, *ENDED) for uid in motion.robots
    )
