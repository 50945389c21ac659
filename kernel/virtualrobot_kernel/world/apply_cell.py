"""Commands that stop the cell and release it, and what a stopped cell refuses."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.apply_motions import all_cancelled
from virtualrobot_kernel.world.change import Change, Forward
from virtualrobot_kernel.world.state import Cancellation, EndCause, State

MOVING: frozenset[type] = frozenset(
    {
        *(commands.StartMotion, commands.AppendMotion, commands.ResumeMotion, commands.StepMotion),
        *(commands.StartSetpointMotion, commands.SetSetpoint, commands.SetJointEfforts),
    }
)
"""Commands by which something begins to move, or goes on: a stopped cell refuses them."""


def stop_cell(change: Change, command: commands.StopCell, forward: Forward) -> Change:
    """Cancel all motions, and keep the first of the stops that have come since the cell was released."""
    cancelled = all_cancelled(change, None, Cancellation(EndCause.CELL_STOPPED, command.stop.reason))
    return replace(cancelled, state=replace(cancelled.state, stop=change.state.stop or command.stop))


def release_cell(change: Change, command: commands.ReleaseCell, forward: Forward) -> Change:
    """End a stop; of a cell that is not stopped nothing changes."""
    if change.state.stop is not None:
        refuse_braking(change.state)
    return replace(change, state=replace(change.state, stop=None))


def refuse_braking(state: State) -> None:
    """Raise KernelError (WRONG_STATE) while a motion of a stopped cell has not come to rest."""
    if state.motions:
        raise KernelError(
            f"the cell can't be released yet: {state.motions[0].id!r} is not at rest; wait until it has ended",
            reason=Reason.WRONG_STATE,
            aspect="rest",
            motion=state.motions[0].id,
        )


def refuse_stopped(state: State) -> None:
    """Raise KernelError (WRONG_STATE) where the cell is stopped."""
    if (stop := state.stop) is None:
        return
    when = datetime.fromtimestamp(stop.wall_time, UTC)
    raise KernelError(
        f"the cell is stopped: {stop.by} stopped it at {when:%H:%M:%S} UTC on {when:%Y-%m-%d} ({stop.reason}); "
        "nothing moves until it is released, by ReleaseCell, or `virtualrobot estop --release`",
        reason=Reason.WRONG_STATE,
        aspect="cell",
        stopped_by=stop.by,
        stop_reason=stop.reason,
        stop_time=when.isoformat(timespec="milliseconds"),
    )
