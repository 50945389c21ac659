"""Cost of real robots to the tick: 1, 8 and 20 arms that are played by drivers, in the thread of the world.

Time follows the wall clock, and drivers report each cycle, so that the world thread reads as much as it does in use;
the far side is this process between two looks at the clock, and costs the measured time nothing. The world thread has
slept before each tick: beside other work its code and data are in no cache then, and cost several times what they do
in a loop without sleep.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
from virtualrobot_kernel.drivers.link import LinkMode
from virtualrobot_kernel.drivers.links import Links
from virtualrobot_kernel.drivers.supervision import Supervision
from virtualrobot_kernel.drivers.twin import Asked, Twin
from virtualrobot_kernel.inputs.mailbox import Mailbox
from virtualrobot_kernel.planning.robots import world_poses
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.collisions import CollisionMode
from virtualrobot_kernel.world.commands import Command, SetCollisionSettings
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.store import World
from virtualrobot_sdk.compiled.cache import compile_all
from virtualrobot_sdk.drivers import About, DriverFault, Safety, Words
from virtualrobot_sdk.drivers import Mode as ControllerMode
from virtualrobot_sdk.drivers.shared import CELL, CellBlock, Report, State, TickRing

from benchmarks.rows import Row, row
from benchmarks.tick import go, world_at_rest

COUNTS = ((1, 1), (8, 8), (20, 20), (1, 20))
"""Arms that are played, and arms that there are."""

TICKS = 250
"""Ticks of a turn at rest, and of one that moves: a way takes more at this speed."""

SPEED = 0.3
PLACES = (1.9, -1.9, 1.9)
"""Positions (rad) of each axis to which it goes, turn by turn."""

LEAD_TICKS = 25
JOINTS = 7
DEADLINE = 60.0
RING_BUDGET, BRAKED_BUDGET = 10.0, 60.0
"""Microseconds for each robot and tick: at rest, and where all move, with their brakes."""


class Playing:
    """Process of a driver that does all that is asked of it, and reports a cycle whenever it is told to."""

    pid = 1
    fault: DriverFault | None = None

    def __init__(self, ring: TickRing) -> None:
        """Stand at zero."""
        zero = np.zeros(JOINTS)
        self._ring = ring
        self._said = Report(
            *(0, State.INACTIVE, 0, 0, 0, -1, False, ControllerMode.READY, Safety.NORMAL, 0, 0, 1.0, 1.0),
            *(zero, zero, zero),
        )

    def report(self, tick: int) -> None:
        """Report one more cycle, at the place where the robot is at this tick."""
        said = self._said
        place = self._ring.get(tick) if said.state is State.ACTIVE else None
        q = said.q if place is None else place.q
        self._said = replace(said, ns=time.monotonic_ns(), cycles=said.cycles + 1, tick=tick, q=q)
        self._ring.report(self._said)

    def connect(self) -> About:
        """Report for the first time."""
        self.report(-1)
        return About(JOINTS, 250.0, watchdog=0.1, inputs=8, outputs=8)

    def begin(self) -> None:
        """Follow at once."""
        self._said = replace(self._said, state=State.ACTIVE, mode=ControllerMode.RUNNING)
        self.report(-1)

    def end(self) -> None:
        """Follow no more."""
        self._said = replace(self._said, state=State.INACTIVE, mode=ControllerMode.READY)

    def reset(self) -> None:
        """Clear nothing."""

    def words(self) -> Words:
        """Return no words."""
        return Words()

    def where(self) -> Words:
        """Return no words."""
        return Words()

    def close(self) -> None:
        """End nothing."""

    def kill(self) -> None:
        """End nothing."""


class Stand:
    """Site of such processes."""

    stopper = ("", "")

    def __init__(self, folder: Path) -> None:
        """Have the files in a folder."""
        self._folder = folder
        self._cell = CellBlock.create(folder / CELL)
        self.processes: list[Playing] = []

    def cell(self) -> CellBlock:
        """Return the block."""
        return self._cell

    def connection(self, twin: Twin, asked: Asked, tick_ns: int) -> tuple[Playing, TickRing]:
        """Make one more."""
        ring = TickRing.create(self._folder / f"ring-{len(self.processes)}", len(twin.joints))
        self.processes.append(Playing(ring))
        return self.processes[-1], ring

    def close(self) -> None:
        """Leave the files to the folder's owner."""


class Timed(Supervision):
    """Supervision that notes what it costs the world thread, for as long as somebody wants to know."""

    stand: Stand
    costs: list[int]
    looked = 0

    def before_tick(self, now: Snapshot, later: Snapshot) -> Sequence[Command]:
        """Let the robots report first, which the far side does in use."""
        for process in self.stand.processes:
            process.report(now.state.tick - LEAD_TICKS)
        begin = time.perf_counter_ns()
        wanted = super().before_tick(now, later)
        self.looked = time.perf_counter_ns() - begin
        return wanted

    def ticked(self, now: Snapshot) -> None:
        """Note what this tick has cost, ns."""
        begin = time.perf_counter_ns()
        super().ticked(now)
        self.costs.append(self.looked + time.perf_counter_ns() - begin)

    def microseconds(self) -> np.ndarray:
        """Return what each of the next ticks costs for a robot."""
        self.costs = costs = []
        until = time.monotonic() + DEADLINE
        while len(costs) < TICKS:
            if time.monotonic() > until:
                raise RuntimeError("time does not go on")
            time.sleep(0.05)
        return np.array(costs) / len(self.stand.processes) / 1000.0


class TimedLinks(Links):
    """Links whose supervision is timed."""

    supervised_by = Timed


def costs_of(played: int, arms: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what ticks cost for each arm that is played (us), at rest and while all arms move."""
    world = world_at_rest(arms)
    world.submit([SetCollisionSettings(CollisionMode.GUARD)]).result()
    world.set_clock(Mode.REALTIME, 1.0).result()
    resting, moving = [], []
    with tempfile.TemporaryDirectory() as folder:
        Timed.stand = Stand(Path(folder))
        links = TimedLinks(world, Mailbox(), world_poses, Timed.stand, lambda uid: True)
        timed = cast(Timed, links.supervision)
        timed.costs = []
        for place in range(played):
            links.connect(f"arm{place}", Asked("playing", {}))
            links.set_mode(f"arm{place}", LinkMode.EXECUTE)
        go(world, arms, -PLACES[0], SPEED)
        _await_rest(world)
        for place in PLACES:
            resting.append(timed.microseconds())
            go(world, arms, place, SPEED)
            moving.append(timed.microseconds())
            if len(world.snapshot.state.motions) < arms:
                raise RuntimeError("the way is too short: the arms have come to its end")
            _await_rest(world)
        if failed := [one for one in links.statuses(world.snapshot) if one.link.state is not State.ACTIVE]:
            raise RuntimeError(f"{failed[0].robot} is {failed[0].link.state.name}: {failed[0].link.words.text}")
        links.close()
    world.close()
    return np.concatenate(resting), np.concatenate(moving)


def _await_rest(world: World) -> None:
    while world.snapshot.state.motions:
        time.sleep(0.05)


def run() -> list[Row]:
    """Return all rows."""
    compile_all(lambda done, total, name: None)
    rows = []
    for played, arms in COUNTS:
        for costs, what, budget in zip(
            costs_of(played, arms), ("at rest", "moving, with brakes"), (RING_BUDGET, BRAKED_BUDGET), strict=True
        ):
            name = f"drivers of {played} of {arms} arm{'s' if arms > 1 else ''} {what}, in a tick, each"
            note = f"99 of 100 ticks at most {np.percentile(costs, 99):.0f} us"
            rows.append(row(name, float(np.median(costs)), budget, "the budget", "us", 1.0, note))
    return rows


if __name__ == "__main__":
    for result in run():
        print(result)
