"""One tick of the world: motions go on by one step of fixed length. Pure."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.motion.plan_execution import PlanExecution, sample_all
from virtualrobot_kernel.motion.program_run import ProgramRun
from virtualrobot_kernel.motion.running_motion import Phase, TickContext
from virtualrobot_kernel.world import dynamics, measured, physics, tolerances
from virtualrobot_kernel.world.apply_motions import override_of
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.state import Cancellation, EndCause, Motion, Search, Signal, State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tcp import world_t_tcp

Floats = NDArray[np.float64]

REMEMBERED = 256
"""Number of ended motions that the state remembers."""

log = logging.getLogger(__name__)


def advance(structure: Structure, state: State, tick_seconds: float, forward: Forward) -> State:
    """Return the state one tick later."""
    if not state.motions:
        return _arrived(structure, state.but(tick=state.tick + 1))
    q, v = (array.copy() for array in measured.commanded(structure, state))
    context = TickContext({name: signal.value for name, signal in state.signals.items()})
    signals: dict[str, Signal] = {}
    advanced: dict[str, Motion] = {}
    tool_states: dict[int, str] = {}
    on_plans: list[tuple[Motion, PlanExecution]] = []
    still: list[Motion] = []
    factor = None if state.speed_factors else override_of(state, ())
    for motion in in_order(state.motions):
        # One without length has succeeded before its first tick.
        done = motion.running.steps_done if motion.tool_states and state.tick > motion.start_tick else 0
        told, at = context, motion.tracked_at
        if at:
            _put(on_plans, q, v)
            on_plans.clear()
            told = context._replace(tracked=(float(q[at[0]]), float(v[at[1]])))
        try:
            speed = override_of(state, motion.robots) if factor is None else factor
            now = motion.running.advance(tick_seconds, speed, told)
            on_plan = now.whole if isinstance(now, ProgramRun) else None
            if on_plan is None:
                position, velocity, _ = now.sample()
                q[motion.q_index], v[motion.v_index] = position, velocity[motion.rated]
            motion = motion.going(now)
        except Exception as error:  # one motion ends then, and not the world's thread with all others
            log.exception("the motion %r failed inside the kernel; it ends where it is", motion.id)
            motion = _failed(motion, type(error).__name__)
            now, on_plan = motion.running, None
        if on_plan is not None:
            on_plans.append((motion, on_plan))
        for name, value in now.signals.items() if now.signals else ():
            if (signal := signals.get(name) or state.signals[name]).value != value:
                signals[name] = replace(signal, value=value)
        if now.fault and not motion.cancellation:
            motion = replace(motion, cancellation=Cancellation(EndCause[now.fault[0]], now.fault[1]))
        for step, tool, name in motion.tool_states:
            if done <= step < now.steps_done:
                tool_states[tool] = name
        if now.ended:
            still.append(motion)
            if motion.cancellation and motion.cancellation.cause is EndCause.COLLISION:
                # Its goal may have been no farther than its brake took: it has not succeeded for that.
                now = now.abort()
                motion = replace(motion, running=now)
            # None where a cancel came too late.
            cancellation = None if now.phase is Phase.SUCCEEDED else motion.cancellation
            motion = replace(motion, end_tick=state.tick + 1, cancellation=cancellation)
        advanced[motion.id] = motion
    _put(on_plans, q, v)
    for motion in still:
        v[motion.v_index] = 0.0
    if not np.isfinite(q).all():
        for motion in advanced.values():
            if not np.isfinite(joints := q[motion.q_index]).all():
                log.error("the motion %r leads to %s; it ends where it is", motion.id, joints.tolist())
                advanced[motion.id] = replace(_failed(motion, "no finite numbers"), end_tick=state.tick + 1)
                still.append(motion)
                q[motion.q_index] = measured.commanded(structure, state)[0][motion.q_index]
                v[motion.v_index] = 0.0
    motions = [advanced[motion.id] for motion in state.motions]
    later = state.but(
        **measured.parted(structure, state, q, v),
        **(_going_and_ended(state, motions) if still else {"motions": tuple(motions)}),
        tick=state.tick + 1,
        signals={**state.signals, **signals} if signals else state.signals,
        # The same object as long as it is the same: whoever shows or sees tools goes by that.
        tool_states={**state.tool_states, **tool_states} if tool_states else state.tool_states,
    )
    later = _arrived(structure, later)
    if tolerances.concerned(motions):
        later = tolerances.kept(structure, later)
    over = [place for place, motion in enumerate(motions) if motion.searcher and _has_searched(motion)]
    if not over:
        return later
    for place in over:
        # What was found was found as the tick began; what was not, at its goal.
        at = state if motions[place].running.found else later
        motions[place] = replace(motions[place], search=_search(structure, at, motions[place], forward))
    return later.but(**_going_and_ended(state, motions))


def _going_and_ended(state: State, motions: Sequence[Motion]) -> dict[str, tuple[Motion, ...]]:
    """Return the motions of the state after this one, by its fields."""
    ended = [motion for motion in motions if motion.running.ended]
    if not ended:
        return {"motions": tuple(motions), "ended": state.ended}
    going = tuple(motion for motion in motions if not motion.running.ended)
    return {"motions": going, "ended": (*state.ended, *ended)[-REMEMBERED:]}


def _has_searched(motion: Motion) -> bool:
    """Return whether the search of a motion that has one is over, and it is not told yet what it came to."""
    return motion.running.found is not None and motion.search is None


def _put(motions: Sequence[tuple[Motion, PlanExecution]], q: Floats, v: Floats) -> None:
    """Put joints where motions on plans have them by now, all at once; q (nq,) and v (nv,) are written to."""
    if not motions:
        return
    positions, velocities, _ = sample_all([running for _, running in motions])
    q[np.concatenate([motion.q_index for motion, _ in motions])] = positions
    if not [motion for motion, _ in motions if motion.rated is not ...]:
        v[np.concatenate([motion.v_index for motion, _ in motions])] = velocities
        return
    ends = np.cumsum([len(motion.q_index) for motion, _ in motions])[:-1]
    for (motion, _), own in zip(motions, np.split(velocities, ends), strict=True):
        v[motion.v_index] = own[motion.rated]


def told_more(structure: Structure, before: State, now: State, later: State) -> State | None:
    """Return the state one tick after `now`, made of `later`, which is the one after `before`; None where it can't be.

    `now` is `before` with coordinates, parts and contacts that were told for this tick. No motion looks at these, so
    that it need not be advanced again; but where a search has just ended, whose result tells where the tool centre
    point is then, and where robots have come under physics, whose motions have moved joints until now and command
    motors from now on. Nor may a motion have tolerances, which look at where its joints are.
    """
    if (
        now.readings
        or before.moved_parts is not None
        or before.told_contacts is not None
        or now.motored is not before.motored
        or tolerances.concerned(later.motions)
    ):
        return None
    if any(motion.search is not None for motion in later.motions):
        return None
    just_ended = [motion for motion in later.ended if motion.end_tick == later.tick]
    if any(motion.search is not None for motion in just_ended) or tolerances.concerned(just_ended):
        return None
    told = later.but(dynamics=now.dynamics, moved_parts=now.moved_parts, told_contacts=now.told_contacts)
    return _arrived(structure, told)


def _arrived(structure: Structure, state: State) -> State:
    """Return the state with what was computed and measured since the tick before; what is measured counts."""
    return measured.arrived(structure, dynamics.arrived(structure, physics.arrived(structure, state)))


def _failed(motion: Motion, why: str) -> Motion:
    """Return a motion ended by a fault of the kernel."""
    cancellation = Cancellation(EndCause.FAILED, f"it failed inside the kernel: {why}")
    return replace(motion, running=motion.running.abort(), cancellation=motion.cancellation or cancellation)


def in_order(motions: Sequence[Motion]) -> Sequence[Motion]:
    """Return motions so that each comes after the one that moves the joint that it goes along with.

    Otherwise they keep their order; so do those that go along with each other.
    """
    if not [motion for motion in motions if motion.tracked_joint]:
        return motions
    mover = {joint: motion for motion in motions for joint in motion.joints}

    def depth(motion: Motion) -> int:
        count = 0
        at: Motion | None = motion
        while at and at.tracked_joint and count < len(motions):
            at, count = mover.get(at.tracked_joint), count + 1
        return count

    return sorted(motions, key=depth)


def _search(structure: Structure, state: State, motion: Motion, forward: Forward) -> Search:
    """Return the result of a motion's search in this state."""
    robot = structure.nodes[motion.searcher]
    positions = state.q[motion.q_index].tolist()
    named = zip(motion.joints, positions, strict=True)
    return Search(
        bool(motion.running.found),
        state.tick,
        {name: position for (uid, name), position in named if uid == robot.uid},
        world_t_tcp(structure, state, forward(structure, state), robot),
    )
