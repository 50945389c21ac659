"""Beginning to do what the twin does: the robot's conditions, its twin where it stands, its host at play."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from virtualrobot_sdk.drivers import DriverFault
from virtualrobot_sdk.drivers.shared import Report, State

from virtualrobot_kernel.drivers.cell import Cell
from virtualrobot_kernel.drivers.conditions import check_conditions
from virtualrobot_kernel.drivers.faults import told
from virtualrobot_kernel.drivers.link import Link, LinkMode
from virtualrobot_kernel.drivers.settling import Settling, author_of
from virtualrobot_kernel.drivers.twin import AT_REST, Floats
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.clock import Mode
from virtualrobot_kernel.world.commands import SetJointPositions
from virtualrobot_kernel.world.store import World

BEGIN_SECONDS = 12.0
"""Longest time (s) that a controller is given to let its robot follow; its host gives up before."""

TICKS_SECONDS = 10.0
"""Longest time (s) for two ticks."""


class Beginning:
    """Lets robots do what their twins do, in the thread of who asks."""

    def __init__(self, world: World, cell: Cell, settling: Settling, leased: Callable[[int], bool]) -> None:
        """Begin nothing yet; `leased` tells whether somebody has leased a robot (a uid)."""
        self._world, self._cell, self._settling, self._leased = world, cell, settling, leased

    def execute(self, robot: str, link: Link) -> Floats | None:
        """Let a robot do what its twin does; see SetDriverMode in the contract."""
        self._settling.hold_clock(link, True)
        halted = link.halted
        try:
            report = reported(robot, link)
            self._check_conditions(robot, link, report)
            moved = self._put_twin(robot, link, report)
            link.state = State.BEGINNING
            link.begin_anew(self._world.snapshot.state.tick)
            self._cell.again()
            self._await_tick()
            self._check_conditions(robot, link, reported(robot, link))
            link.mode = LinkMode.EXECUTE
            try:
                link.process.begin()
                self._await_active(link)
            except DriverFault as error:
                if link.state is State.BEGINNING:
                    report = link.newest()
                    if report is None or report.state is State.ERROR:
                        link.halt(error.words, State.ERROR)
                    else:
                        link.words, link.state = error.words, State.INACTIVE
                raise told(error, robot) from error
            return moved
        except BaseException:
            link.mode, link.halted = LinkMode.SIMULATED, link.halted or halted
            if link.state is State.BEGINNING:
                link.state = State.INACTIVE
            self._settling.hold_clock(link, False)
            raise

    def _await_active(self, link: Link) -> None:
        """Wait until a robot follows; raise DriverFault with the words where it does not."""
        until = time.monotonic() + BEGIN_SECONDS
        while link.state is State.BEGINNING:
            report = link.newest()
            if report is not None and report.state is State.ACTIVE:
                link.state = State.ACTIVE
                return
            if report is not None and report.state is State.INACTIVE and self._cell.stopped:
                link.state = State.INACTIVE
                raise DriverFault(f"the cell was stopped as it began: {self._cell.stopped}")
            if time.monotonic() > until or self._cell.closed:
                raise DriverFault(f"the controller does not let the robot follow after {BEGIN_SECONDS:g} s")
            time.sleep(0.002)
        raise DriverFault(link.words.text, link.words.code, link.words.clears)

    def _check_conditions(self, robot: str, link: Link, report: Report) -> None:
        """Raise KernelError (WRONG_STATE) that names the first condition of EXECUTE that does not hold."""
        played = [one for one in self._cell.links.values() if one is not link and one.is_played]
        leased = self._leased(link.twin.uid)
        known = self._world.snapshot.state.stop
        stopped = known.reason if known is not None else self._cell.stopped
        check_conditions(self._world.snapshot, self._world.clock, robot, link, report, played, stopped, leased)

    def _put_twin(self, robot: str, link: Link, report: Report) -> Floats | None:
        """Put a twin to where its robot stands; return how far that was, (k,), None where it stands there."""
        now = self._world.snapshot
        at_q, _ = link.places(now.structure)
        away = report.q - now.state.q[at_q]
        if np.abs(away).max() <= AT_REST / 10.0:
            return None
        goal = np.clip(report.q, link.twin.lower, link.twin.upper)
        positions = dict(zip(link.twin.names, goal.tolist(), strict=True))
        self._world.submit([SetJointPositions(robot, positions)], author_of(now, link)).result()
        return away

    def _await_tick(self) -> None:
        """Wait for two ticks: what was decided before them is in the rings then."""
        first = self._world.snapshot.state.tick
        until = time.monotonic() + TICKS_SECONDS
        while self._world.snapshot.state.tick < first + 2 and time.monotonic() < until and not self._cell.closed:
            if self._world.clock.mode is not Mode.REALTIME:
                return
            time.sleep(0.001)


def reported(robot: str, link: Link) -> Report:
    """Return the newest report; raise KernelError (DRIVER_FAULT) where there is none, or it is no number."""
    report = link.newest()
    if report is None or not np.isfinite(report.q).all():
        said = f"the controller of {robot!r} has not told where its joints are"
        raise KernelError(said, reason=Reason.DRIVER_FAULT, robot=robot)
    return report
