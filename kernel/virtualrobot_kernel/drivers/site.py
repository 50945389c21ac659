"""Site of a kernel's drivers: their folder in shared memory, and the processes that work in it."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import TypeVar

from virtualrobot_sdk.drivers import About, DriverFault, Words
from virtualrobot_sdk.drivers.process import DriverProcess
from virtualrobot_sdk.drivers.robot_side import JointSide, RobotSide
from virtualrobot_sdk.drivers.shared import CELL, RING, CellBlock, TickRing, make_folder
from virtualrobot_sdk.drivers.stopper import Stopper
from virtualrobot_sdk.errors import ArgumentError, ComponentFault, FaultKind, PluginError
from virtualrobot_sdk.registration import ComponentKind

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.components.running import refusal_of
from virtualrobot_kernel.drivers.twin import AT_REST, Asked, Twin
from virtualrobot_kernel.errors import KernelError, Reason

Result = TypeVar("Result")

ROUNDING = 1e-6
"""Distance (rad, m) beyond its limits at which a joint may be by rounding, as motions leave it."""


class DriverSite:
    """Maker of driver processes; see `far_side.Site`. It owns their folder, which goes with it."""

    def __init__(self, catalog: Catalog) -> None:
        """Take drivers from this catalogue; nothing is made before it is asked for."""
        self._catalog = catalog
        self._folder: Path | None = None
        self._cell: CellBlock | None = None
        self._stopper: Stopper | None = None
        self._numbers = count(1)
        self._lock = threading.Lock()

    def cell(self) -> CellBlock:
        """Return the one block of this kernel."""
        return self._opened()[1]

    @property
    def stopper(self) -> tuple[str, str]:
        """Address and key of the process that stops the cell for whoever has the key; empty before there is a cell."""
        stopper = self._stopper
        return ("", "") if stopper is None else (stopper.address, stopper.key)

    def connection(self, twin: Twin, asked: Asked, tick_ns: int) -> tuple[Connection, TickRing]:
        """Start the process of a driver, with a new ring; see `far_side.Site`."""
        offer = self._catalog.find(ComponentKind.ROBOT_DRIVER, asked.component)
        folder, _ = self._opened()
        path = folder / RING.format(next(self._numbers))
        ring = TickRing.create(path, len(twin.joints))
        process = DriverProcess(f"driver {asked.component}")
        connection = Connection(process, asked.component, path)
        try:
            connection.ask(
                lambda: process.make(
                    offer.entry_point,
                    asked.component,
                    asked.settings,
                    side_of(twin, asked, tick_ns),
                    path,
                    folder / CELL,
                )
            )
        except BaseException:
            connection.kill()
            ring.close()
            raise
        return connection, ring

    def close(self) -> None:
        """Take the folder away."""
        with self._lock:
            if self._stopper is not None:
                self._stopper.close()
            if self._cell is not None:
                self._cell.close()
            if self._folder is not None:
                shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = self._cell = self._stopper = None

    def _opened(self) -> tuple[Path, CellBlock]:
        with self._lock:
            if self._folder is None or self._cell is None:
                self._folder = make_folder()
                self._cell = CellBlock.create(self._folder / CELL)
                self._stopper = Stopper(self._folder / CELL)
            return self._folder, self._cell


class Connection:
    """Process of one driver; see `far_side.Process`. Those who ask it wait for each other, but `kill` for nobody."""

    def __init__(self, process: DriverProcess, component: str, ring: Path) -> None:
        """Own the process, and the file of its ring."""
        self._process, self._component, self._ring = process, component, ring
        self._asking = threading.Lock()
        self._asked = ""

    @property
    def pid(self) -> int:
        """Number of the process; 0 once it has ended."""
        return self._process.pid or 0

    @property
    def fault(self) -> DriverFault | None:
        """Fault that ended the process."""
        fault = self._process.fault
        if fault is None:
            return None
        ended = fault.kind is FaultKind.DIED and fault.reason.startswith("its process")
        return DriverFault(fault.reason if ended else f"its process has ended: {fault.reason}")

    def ask(self, call: Callable[[], Result], method: str = "") -> Result:
        """Return what a call of the process returns, which calls a method of the driver, if it does.

        Raises DriverFault for what it has done wrong, KernelError for settings, joints or a plugin that it refuses.
        """
        with self._asking:
            self._asked = method
            try:
                return call()
            except ComponentFault as error:
                raise DriverFault(error.reason) from error
            except ArgumentError as error:
                raise refusal_of(f"driver {self._component!r}: {error}", error) from error
            except PluginError as error:
                raise KernelError(
                    f"driver {self._component!r}: {error}",
                    reason=Reason.PLUGIN_FAILED,
                    component=self._component,
                ) from error

    def connect(self) -> About:
        """Connect to the controller."""
        return self.ask(self._process.connect, "connect")

    def begin(self) -> None:
        """Have the robot follow, which reports tell soon after."""
        self.ask(self._process.begin, "begin")

    def end(self) -> None:
        """Have it follow no more."""
        self.ask(self._process.end, "end")

    def reset(self) -> None:
        """Clear a fault at the controller."""
        self.ask(self._process.reset, "reset")

    def words(self) -> Words:
        """Return the newest words."""
        return self.ask(self._process.words)

    def where(self) -> Words:
        """Return where the driver is just now: in what somebody waits for, or what its process says."""
        if self._asking.locked() and self._asked:
            return Words(f"it hangs in {self._asked}")
        return self.ask(self._process.where)

    def close(self) -> None:
        """Have the driver let go and end the process."""
        with self._asking:
            self._process.close()
            self._ring.unlink(missing_ok=True)

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._ring.unlink(missing_ok=True)


def side_of(twin: Twin, asked: Asked, tick_ns: int) -> RobotSide:
    """Return what a host must know of a twin."""
    joints = tuple(
        JointSide(
            one.joint,
            index,
            float(twin.lower[index]) - ROUNDING,
            float(twin.upper[index]) + ROUNDING,
            float(twin.velocity[index]),
            -1.0 if one.reversed else 1.0,
            one.offset,
        )
        for index, one in enumerate(twin.joints)
    )
    return RobotSide(joints, tick_ns, AT_REST, asked.without_watchdog, round(asked.lead * 1e9))
