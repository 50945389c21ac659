"""Prediction of the world if all that moves braked now."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion import online
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import ENDED, Phase, RunningMotion
from virtualrobot_kernel.motion.setpoint_motion import SetpointMotion
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance

LONGEST_BRAKE_TICKS = 15_000
"""Greatest number of ticks of a brake (a minute, at ticks of 4 ms); a longer one counts as none."""

HARMLESS: frozenset[type] = frozenset(
    {
        *(commands.StartMotion, commands.StartSetpointMotion, commands.SetSetpoint, commands.EndSetpoints),
        *(commands.SetMeasuredJoints, commands.GoOn),
        *(commands.CancelMotion, commands.StopMotions, commands.StopRobots),
        *(commands.CreateSignal, commands.RemoveSignal, commands.SetSignal),
        *(commands.RunSensors, commands.SetRangeComponents, commands.SetKinematics, commands.SelectTool),
        *(commands.SetGroups, commands.SetPostures),
    }
)
"""Commands that put nothing elsewhere and change no way of braking: a motion starts at rest, and goes by ticks."""

RATES: frozenset[type] = frozenset(
    {commands.PauseMotion, commands.ResumeMotion, commands.StepMotion, commands.SetSpeedFactor, commands.AppendMotion}
)
"""Commands that change nothing but how motions go on, and with it how they would brake."""


@dataclass(frozen=True, slots=True, eq=False)
class BrakePath:
    """Predicted coordinates of the world while all that moves brakes, tick by tick.

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

    def after(self, state: State) -> BrakePath:
        """Return the way that begins one tick earlier, in a state."""
        tools = tuple((row + 1, held) for row, held in self.tools)
        first = () if tools[0][1] is state.tool_states else ((0, state.tool_states),)
        if not first:
            tools = ((0, tools[0][1]), *tools[1:])
        positions = np.concatenate([state.q[None], self.positions])
        return BrakePath(state.tick, positions, (*first, *tools), self.ends, self.reached)


def braking(structure: Structure, state: State, tick_seconds: float, forward: Forward) -> BrakePath:
    """Return the way of the world when all that moves begins to brake now, from the present tick on.

    Motions on plans and by setpoints are asked for their brakes, which is quicker, and to rounding the same, as making
    the ticks; the ticks are made where a motion goes along with a joint, or tools change their states on the way. It
    ends where all stands, or after `LONGEST_BRAKE_TICKS`.
    """
    if state.motions and all(map(_alone, state.motions)):
        ways = [_way(motion, override(state, motion), tick_seconds) for motion in state.motions]
        count = max(len(way) for way, _ in ways)
        positions = np.repeat(state.q[None], count, axis=0)
        tools = [(0, state.tool_states)]
        for motion, (way, end) in sorted(zip(state.motions, ways, strict=True), key=lambda one: len(one[1][0])):
            positions[: len(way), motion.q_index] = way
            positions[len(way) :, motion.q_index] = way[-1]
            done = range(motion.running.steps_done if state.tick > motion.start_tick else 0, end.steps_done)
            if reached := {tool: name for step, tool, name in motion.tool_states if step in done}:
                tools.append((len(way) - 1, {**tools[-1][1], **reached}))
        ends = ((motion.id, _reached(end)) for motion, (_, end) in zip(state.motions, ways, strict=True))
        reached = {id: places for id, places in ends if places is not None}
        return BrakePath(state.tick, positions, tuple(tools), count <= LONGEST_BRAKE_TICKS, reached)
    robots = tuple({uid for motion in state.motions for uid in motion.robots})
    stop = commands.StopRobots(robots, Cancellation(EndCause.COLLISION, ""))
    now = apply(structure, state, [stop], forward).state
    rows, tools = [now.q], [(0, now.tool_states)]
    while now.motions and len(rows) <= LONGEST_BRAKE_TICKS:
        now = advance(structure, now, tick_seconds, forward)
        if now.tool_states is not tools[-1][1]:
            tools.append((len(rows), now.tool_states))
        rows.append(now.q)
    return BrakePath(state.tick, np.array(rows), tuple(tools), not now.motions, {})


def _alone(motion: Motion) -> bool:
    """Return whether a motion brakes by itself, and puts no tool into another state before it stands."""
    if motion.tracked_joint is not None:
        return False
    run = motion.running
    if not motion.tool_states or not isinstance(run, ProgramRun) or run.at == len(run.program.stages):
        return not motion.tool_states
    return len(run.program.stages[run.at].steps) == 1


def _way(motion: Motion, override: float, dt: float) -> tuple[NDArray[np.float64], RunningMotion]:
    """Return the positions (m, n) of a motion's joints while it brakes from now on, a tick apart.

    With it comes the motion as it is in the end; where that is told by its brakes at once, as it is before.
    """
    now = motion.running.cancel()
    rows = [now.sample()[0]]
    while not now.ended and len(rows) <= LONGEST_BRAKE_TICKS:
        if (rest := _rest(now, dt)) is not None:
            return np.concatenate([np.array(rows), rest]), now
        if (stretch := _on_plan(now, dt, override)) is not None:
            now, more = stretch
            rows.extend(more)
            continue
        now = now.advance(dt, override)
        rows.append(now.sample()[0])
    return np.array(rows), now


def _reached(end: RunningMotion) -> tuple[float, ...] | None:
    """Return the path parameter at the end of each track of a stage (see `_way`); None where there is no path."""
    if not isinstance(end, ProgramRun) or end.running is None:
        return None
    if brakes := end.running.brakes:
        return tuple(brake.scalar_state(brake.end)[0] for brake in brakes)
    return tuple(u for u, _, _ in end.running.path_states)


def _on_plan(now: RunningMotion, dt: float, override: float) -> tuple[RunningMotion, NDArray[np.float64]] | None:
    """Return a motion that stops without brakes of its own as it is before its last tick, or when it has some.

    With it come the places of its joints (m, n) until then, m >= 1; None where this is so with the next tick.
    """
    if not isinstance(now, ProgramRun) or now.running is None or now.due:
        return None
    moving, taus, plan = now.running, [], now.running.plan
    while not moving.brakes and len(taus) < LONGEST_BRAKE_TICKS:
        later = moving.advance(dt, override)
        if later.ended or later.brakes:
            break
        moving = later
        taus.append(later.tau)
    if not taus:
        return None
    times = np.array(taus)
    laws = [track.time_law.states(times, 0)[0, :, 0] for track in plan.tracks]
    return replace(now, running=moving), _places(now, plan, laws)


def _rest(now: RunningMotion, dt: float) -> NDArray[np.float64] | None:
    """Return the positions (m, n) of a braking motion's joints from the next tick on, at once; or None."""
    if isinstance(now, SetpointMotion) and now.phase is Phase.STOPPING:
        way, _ = online.brake(now.now, now.bounds, dt)
        count = math.ceil(way.duration / dt)
        return now.positions(np.array([way.at((row + 1) * dt).q for row in range(count)])) if count else None
    if not isinstance(now, ProgramRun) or now.running is None or not now.running.brakes:
        return None
    moving = now.running
    times = np.arange(1, math.ceil((max(brake.end for brake in moving.brakes) - moving.elapsed) / dt) + 1) * dt
    if not len(times):
        return None
    laws = [brake.states(np.minimum(moving.elapsed + times, brake.end), 0)[0, :, 0] for brake in moving.brakes]
    return _places(now, moving.plan, laws)


def _places(now: ProgramRun, plan: Plan, laws: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the positions (m, n) of a program's joints where the tracks of its plan are at the places u (m,)."""
    rows = np.concatenate([track.path.states(u, 0)[0] for track, u in zip(plan.tracks, laws, strict=True)], axis=1)
    columns = now.program.places[now.at]
    if columns is None:
        return rows
    held = np.repeat(now.held[None], len(rows), axis=0)
    held[:, columns] = rows
    return held


def going(state: State) -> frozenset[int]:
    """Return the robots (uids) of motions that do not brake yet."""
    return frozenset(
        uid for motion in state.motions if motion.running.phase not in (Phase.STOPPING, *ENDED) for uid in motion.robots
    )
