"""Runs of a small world: programs, setpoints, edits and ticks drawn at random, with the journal that they left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.history.world_image import WorldImage
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.apply import apply
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import (
    AttachNode,
    Command,
    CreateNodes,
    CreateSignal,
    RemoveNode,
    SetSetpoint,
    StartSetpointMotion,
    UpdateNode,
)
from virtualrobot_kernel.world.journal import Entry, replay
from virtualrobot_kernel.world.state import Signal, State
from virtualrobot_kernel.world.structure import Structure
from virtualrobot_kernel.world.tick import advance

from tests.unit.world.builders import TICK, arm, empty, part, shifted
from tests.unit.world.test_programs import NAMES, program, steered


@dataclass(frozen=True)
class Run:
    """Entries of a run, and the worlds before each; the last one is that after all. `ticks` are those of each tick."""

    entries: Sequence[Entry]
    worlds: Sequence[tuple[Structure, State]]
    ticks: Sequence[tuple[Structure, State]]

    @property
    def last(self) -> tuple[Structure, State]:
        """Return the world at its end."""
        return self.worlds[-1]

    def replayed(
        self, batches: Sequence[tuple[Command, ...]] | None, start: WorldImage | None = None
    ) -> tuple[Structure, State]:
        """Return the world at the end, replayed with batches in the place of the entries' own, or from an image."""
        first, entries = self.worlds[0], self.entries
        if batches is not None:
            entries = [Entry(one.tick, one.author, batch) for one, batch in zip(entries, batches, strict=True)]
        if start is not None:
            first = (start.structure, start.state)
            at = next(place for place, (_, state) in enumerate(self.worlds) if state.tick == start.state.tick)
            entries = entries[at:]
        change = replay(*first, entries, self.last[1].tick, TICK, world_poses)
        return change.structure, change.state


def random_run(rng: np.random.Generator, batches: int) -> Run:
    """Return a run of so many batches, some ticks between them."""
    change = empty()
    entries: list[Entry] = []
    ticks: list[tuple[Structure, State]] = []
    worlds: list[tuple[Structure, State]] = []
    first = [arm(), *(CreateSignal(Signal(name, False)) for name in NAMES), CreateNodes((part("cup", shifted(1.0)),))]
    for number in range(batches):
        commands = tuple(first) if not number else drawn(rng, change)
        try:
            later = apply(change.structure, change.state, commands, world_poses)
        except KernelError:
            continue
        worlds.append((change.structure, change.state))
        entries.append(Entry(change.state.tick, "tester", commands))
        state = later.state
        for _ in range(rng.integers(1, 40)):
            state = advance(later.structure, state, TICK, world_poses)
            ticks.append((later.structure, state))
        change = Change(later.structure, state)
    return Run(entries, [*worlds, (change.structure, change.state)], ticks)


def drawn(rng: np.random.Generator, change: Change) -> tuple[Command, ...]:
    """Return a batch that may be refused: a program, setpoints, an edit, or what anyone may do while programs run."""
    state, kind = change.state, rng.integers(6)
    moving = {name for motion in state.motions for _, name in motion.joints}
    free = [(name, column) for column, name in enumerate("ab") if name not in moving]
    if kind < 2 and free:
        return (program(rng, state, *free[0]),)
    if kind == 2:
        if free and rng.random() < 0.3:
            return (StartSetpointMotion("arm", (free[0][0],), SetpointMode.POSITION, 0.1),)
        return tuple(SetSetpoint(motion.id, (float(rng.normal()),)) for motion in state.motions)
    if kind == 3:
        name = f"box{rng.integers(4)}"
        choices = (
            CreateNodes((part(name, shifted(*rng.normal(size=3))),)),
            RemoveNode(name),
            AttachNode(name, str(rng.choice(["arm.two", "world", "cup", "arm_gripper"]))),
            UpdateNode(name, parent_t_node=shifted(*rng.normal(size=3))),
        )
        return (choices[rng.integers(len(choices))],)
    return (steered(rng, state),)
