"""One tick of the world: motions go on by one step of fixed length. Pure."""

from __future__ import annotations

from dataclasses import replace

from virtualrobot_kernel.motion import running
from virtualrobot_kernel.motion.running import Phase
from virtualrobot_kernel.world.apply_motions import override
from virtualrobot_kernel.world.change import frozen
from virtualrobot_kernel.world.state import Motion, State

REMEMBERED = 256
"""How many motions that have ended the state remembers."""

ENDED = (Phase.SUCCEEDED, Phase.CANCELLED)


def advance(state: State, tick_seconds: float) -> State:
    """Return the state one tick later."""
    if not state.motions:
        return replace(state, tick=state.tick + 1)
    q, v = state.q.copy(), state.v.copy()
    going: list[Motion] = []
    ended: list[Motion] = []
    tool_states = dict(state.tool_states)
    for motion in state.motions:
        now = running.advance(motion.running, tick_seconds, override(state, motion))
        motion = replace(motion, running=now)
        position, velocity, _ = now.sample()
        q[motion.q_index] = position
        v[motion.v_index] = velocity
        if now.phase in ENDED:
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
        motions=tuple(going),
        ended=(*state.ended, *ended)[-REMEMBERED:],
        tool_states=tool_states,
    )
