"""Far side of links without any process: a thread of the test plays the ring, and does what it is told to."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from virtualrobot_kernel.drivers.twin import Asked, Twin
from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_sdk.drivers import About, DriverFault, Mode, Safety, Words
from virtualrobot_sdk.drivers.shared import CELL, NEVER, CellBlock, Report, State, TickRing

CYCLE_SECONDS = 0.002


class ShamProcess:
    """Robot that is where its ring says, a lead later; a thread reports it until the process is closed."""

    pid = 4711

    def __init__(self, ring: TickRing, cell: CellBlock, k: int) -> None:
        """Stand at zero."""
        self.ring, self.cell = ring, cell
        self.about = About(k, 250.0, watchdog=0.1, model="sham", inputs=2, outputs=2)
        self.fault: DriverFault | None = None
        self.refusal: DriverFault | None = None
        self.said = DriverFault("")
        self.offset = np.zeros(k)
        self.stands = np.zeros(k)
        self.hangs = False
        self.outputs: list[int] = []
        ready = State.INACTIVE, 0, 0, 0, -1, False, Mode.READY, Safety.NORMAL, 0, 0, 1.0, 1.0
        self.report = Report(0, *ready, q=np.zeros(k), v=np.zeros(k), error=np.zeros(k))
        self.reported = threading.Event()
        self._changing = threading.Lock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def connect(self) -> About:
        """Report from now on."""
        self._refuse()
        if not self._thread.is_alive():
            self._thread.start()
        self.fault = None
        self.tell(state=State.INACTIVE, is_faulty=False)
        return self.about

    def begin(self) -> None:
        """Play, where the ring has the newest tick, as a host does."""
        self._refuse()
        if self.ring.get(self.cell.newest_braked) is None:
            raise DriverFault("the twin tells no ticks")
        self.tell(state=State.ACTIVE, mode=Mode.RUNNING)

    def end(self) -> None:
        """Play no more."""
        self.tell(state=State.INACTIVE, mode=Mode.READY)

    def reset(self) -> None:
        """Clear nothing."""
        self._refuse()

    def words(self) -> Words:
        """Return the words of the fault that the test gave it."""
        return self.said.words

    def where(self) -> Words:
        """Return nothing: it hangs nowhere."""
        return Words()

    def kill(self) -> None:
        """Do as `close` does."""
        self.close()

    @property
    def ended(self) -> bool:
        """True once it was closed."""
        return self._ended.is_set()

    def close(self) -> None:
        """End the thread."""
        self._ended.set()
        self.reported.set()
        if self._thread.is_alive():
            self._thread.join()

    def fail(self, said: DriverFault) -> None:
        """Meet a fault as a host does: where the robot is moved it is told, with its words, before the cell stops."""
        self.said = said
        if self.report.state in (State.BEGINNING, State.ACTIVE, State.STOPPING):
            self.tell(is_faulty=True)
            self.cell.stop()
        self.tell(state=State.ERROR, is_faulty=False)

    def tell(self, **changes: Any) -> None:  # noqa: ANN401 any field of a report
        """Report something else from now on, and return once that was reported."""
        with self._changing:
            self.report = replace(self.report, **changes)
            self.reported.clear()
        assert self._ended.is_set() or self.reported.wait(30.0)

    def _refuse(self) -> None:
        if self.refusal is not None:
            raise self.refusal

    def _run(self) -> None:
        while not self._ended.wait(CYCLE_SECONDS):
            if not self.hangs:
                with self._changing:
                    self._cycle()

    def _cycle(self) -> None:
        said, now = self.report, time.monotonic_ns()
        q, tick, error = self.stands, said.tick, np.zeros_like(self.stands)
        if said.state is State.ACTIVE:
            newest = self.cell.newest
            for number in range(newest, max(-1, newest - 100), -1):
                record = self.ring.get(number)
                if record is not None and record.play_ns <= now:
                    q, tick, error = record.q + self.offset, number, self.offset
                    self.outputs.append(record.outputs)
                    break
        rate = 1.0 if self.cell.stop_ns == NEVER else 0.0
        self.stands = q
        self.report = replace(
            said, ns=now, cycles=said.cycles + 1, tick=tick, q=q, v=np.zeros_like(q), error=error, rate=rate
        )
        self.ring.report(self.report)
        self.reported.set()


class ShamSite:
    """Site that starts shams; `processes` are those that it has started."""

    stopper = ("", "")

    def __init__(self, folder: Path) -> None:
        """Have the files in a folder."""
        self.folder = folder
        self.processes: list[ShamProcess] = []
        self.refusal: DriverFault | None = None
        self._cell: CellBlock | None = None

    def cell(self) -> CellBlock:
        """Return the block."""
        self._cell = self._cell or CellBlock.create(self.folder / CELL)
        return self._cell

    def connection(self, twin: Twin, asked: Asked, tick_ns: int) -> tuple[ShamProcess, TickRing]:
        """Make a sham; one of another name there is not."""
        if asked.component != "sham":
            raise UnknownNameError("robot_driver component", asked.component, ["sham"])
        ring = TickRing.create(self.folder / f"ring-{len(self.processes)}", len(twin.joints))
        process = ShamProcess(ring, self.cell(), len(twin.joints))
        process.refusal = self.refusal
        self.processes.append(process)
        return process, ring

    def close(self) -> None:
        """Leave the files to the test."""
