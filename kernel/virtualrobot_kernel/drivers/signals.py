"""Digital inputs and outputs of controllers as signals of the world: "ROBOT.di0" and on, "ROBOT.do0" and on. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.commands import Command, CreateSignal, RemoveSignal, SetSignal
from virtualrobot_kernel.world.state import Signal, SignalDirection, Snapshot

MOST = 64
"""Greatest number of each."""


def commands_for(snapshot: Snapshot, robot: str, inputs: int, outputs: int) -> list[CreateSignal]:
    """Return what makes the signals of a controller that are not there yet.

    Raises KernelError (NAME_TAKEN) for a signal of another kind that has such a name.
    """
    node, _ = snapshot.structure.robot(robot)
    wanted = [
        Signal(f"{robot}.{kind}{place}", False, f"{what} {place} of the controller of {robot}", "", direction)
        for kind, what, direction, count in (
            ("di", "digital input", SignalDirection.INPUT, inputs),
            ("do", "digital output", SignalDirection.OUTPUT, outputs),
        )
        for place in range(count)
    ]
    missing: list[CreateSignal] = []
    for signal in wanted:
        there = snapshot.state.signals.get(signal.name)
        if there is None:
            missing.append(CreateSignal(signal, robot))
        elif not isinstance(there.value, bool) or there.owner != node.uid or there.direction is not signal.direction:
            raise KernelError(
                f"there is a signal {signal.name!r} already, and it is no {signal.description}; rename it",
                reason=Reason.NAME_TAKEN,
                name=signal.name,
            )
    return missing


def removals(snapshot: Snapshot, uid: int, names: Sequence[str]) -> list[Command]:
    """Return what takes away signals that are still a robot's (a uid; 0: nobody's), but what running programs name."""
    state = snapshot.state
    named = {name for motion in state.motions for name in motion.signals}
    found = ((name, state.signals.get(name)) for name in names if name not in named)
    return [RemoveSignal(name) for name, signal in found if signal is not None and signal.owner == uid]


def bits_of(snapshot: Snapshot, uid: int, outputs: int) -> int:
    """Return the outputs of a controller as the world has them, the first in the lowest bit."""
    signals, name = snapshot.state.signals, snapshot.structure.nodes[uid].name
    found = (signals.get(f"{name}.do{place}") for place in range(outputs))
    return sum(1 << place for place, one in enumerate(found) if one is not None and one.value is True)


def inputs_changed(snapshot: Snapshot, uid: int, inputs: int, bits: int) -> Sequence[Command]:
    """Return what makes the signals of a controller's inputs those that were read."""
    signals, name = snapshot.state.signals, snapshot.structure.nodes[uid].name
    changed: list[Command] = []
    for place in range(inputs):
        signal, value = signals.get(f"{name}.di{place}"), bool(bits >> place & 1)
        if signal is not None and signal.value is not value:
            changed.append(SetSignal(signal.name, value))
    return changed
