"""Inputs of a tick: commands that writers give at the rate of ticks, applied together as a tick begins."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Forward
from virtualrobot_kernel.world.commands import EndSetpoints, SetMeasuredJoints, SetSetpoint
from virtualrobot_kernel.world.journal import Entry
from virtualrobot_kernel.world.state import Snapshot, State

log = logging.getLogger(__name__)

InputCommand = SetSetpoint | EndSetpoints | SetMeasuredJoints
"""Commands that move nothing at once: they give goals to motions, and what was measured."""


class TickInput(NamedTuple):
    """Input of a tick: a command, and its writer.

    Attributes:
        command: what it says.
        writer: who the journal says gave it.
        refused: called in the world thread with the error when it was refused; it must return at once.
        permit: raises KernelError when the writer may not give it; called in the world thread before it is applied.
    """

    command: InputCommand
    writer: str
    refused: Callable[[KernelError], None]
    permit: Callable[[Snapshot, Sequence[InputCommand]], None] | None = None


InputSource = Callable[[], Sequence[TickInput]]
"""Source of the inputs that have come since it was asked last; called in the world thread as a tick begins."""


def taken(
    snapshot: Snapshot,
    state: State,
    inputs: Sequence[TickInput],
    forward: Forward,
    admit: Callable[[Sequence[InputCommand]], None] = lambda _: None,
) -> tuple[State, Entry | None]:
    """Return the state with inputs, and the entry of the journal that says the same; each refused one is left out.

    Args:
        snapshot: what permits are asked about; no input changes its structure.
        state: the state in which the tick begins.
        inputs: what to apply, in this order.
        forward: the forward pass.
        admit: raises KernelError for commands that the journal could not keep.
    """
    accepted: list[TickInput] = []
    for item in inputs:
        try:
            admit([item.command])
            if item.permit is not None:
                item.permit(snapshot, [item.command])
            state = apply(snapshot.structure, state, [item.command], forward).state
        except KernelError as error:
            item.refused(error)
        except Exception as error:
            log.exception("an input of %s failed inside the kernel; it is left out", item.writer)
            item.refused(KernelError(f"it failed inside the kernel: {type(error).__name__}", reason=Reason.INTERNAL))
        else:
            accepted.append(item)
    if not accepted:
        return state, None
    writers = ", ".join(dict.fromkeys(item.writer for item in accepted))
    return state, Entry(state.tick, writers, tuple(item.command for item in accepted), time.time())
