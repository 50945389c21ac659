"""One tick of the world: motions go on by one step of fixed length. Pure."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.motion.moving import Given, Phase
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.change import frozen
from virtualrobot_kernel.world.state import CancelCause, Cancellation, Motion, Signal, State

REMEMBERED = 256
"""How many motions that have ended the state remembers."""


def advance(state: State, tick_seconds: float) -> State:
    """Return the state one tick later."""
    if not state.motions:
        return replace(state, tick=state.tick + 1)
    q, v = state.q.copy(), state.v.copy()
    given = Given(q, {name: signal.value for name, signal in state.signals.items()})
    signals: dict[str, Signal] = {}
    going: list[Motion] = []
    ended: list[Motion] = []
    tool_states = dict(state.tool_states)
    for motion in state.motions:
        now = motion.running.advance(tick_seconds, override(state, motion), given)
        motion = replace(motion, running=now)
        for name, value in now.signals.items():
            if signal := state.signals.get(name):  # else it was removed meanwhile
                signals[name] = replace(signal, value=value)
        if now.fault and not motion.cancellation:
            motion = replace(motion, cancellation=Cancellation(CancelCause[now.fault[0]], now.fault[1]))
        position, velocity, _ = now.sample()
        q[motion.q_index] = position
        v[motion.v_index] = velocity
        if now.ended:
            v[motion.v_index] = 0.0
            cancellation = motion.cancellation
            if now.phase is Phase.SUCCEEDED:  # even when a cancel came too late
                tool_states.update(motion.tool_states)
                cancellation = None
            ended.append(replace(motion, end_tick=state.tick + 1, cancellation=cancellation))
        else:
            going.append(motion)
    return replace(
        state,
        tick=state.tick + 1,
        q=frozen(q),
        v=frozen(v),
        signals={**state.signals, **signals} if signals else state.signals,
        motions=tuple(going),
        ended=(*state.ended, *ended)[-REMEMBERED:],
        tool_states=tool_states,
    )
