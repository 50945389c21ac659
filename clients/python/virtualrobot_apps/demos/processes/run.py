"""A process in its cell: it is planned, checked and done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.pace import Pace
from virtualrobot_apps.processes.command import planned

_TICKS = 10
"""Ticks from one look at the wall clock to the next one."""


def main(
    client: Client, cell: Path, file: Path, pace: float = 0.0, each: Callable[[], object] = lambda: None
) -> tuple[str, ...]:
    """Replace the world by the cell, do the process there, print what it comes to, and return that.

    Args:
        client: of the kernel.
        cell: a scene file.
        file: of a process.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.
        each: called after each ten ticks.

    Raises:
        VirtualRobotError: where the process can't be done in the cell.
    """
    client.clock.set_stepped()
    client.scene.load_scene(cell)
    print(f"cell {cell}\nprocess {file}", flush=True)
    process = planned(client, file)
    found = process.program.check()
    if found.first_violation is not None:
        raise WrongStateError(f"{file.name}: {found.first_violation.message}")
    print(f"it touches nothing and takes {found.duration:.1f} s", flush=True)
    showing = process.shown() if process.shown is not None else None
    motion, clock, now = process.program.start(wait=False), Pace(pace), 0.0
    seconds = _TICKS * client.clock.read().tick_length
    while not motion.phase.ended:
        client.clock.step(_TICKS)
        now += seconds
        if showing is not None:
            showing.look()
        each()
        clock.keep(now)
    motion.state.raise_early_end()
    if showing is not None:
        showing.finish()
    print(f"done in {now:.1f} s", flush=True)
    return process.measures
