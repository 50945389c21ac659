"""Site of a kernel's drivers: their folder in shared memory, and the processes that are started in it."""

from __future__ import annotations

import shutil
import threading
from itertools import count
from pathlib import Path

from virtualrobot_sdk.drivers.shared import CELL, RING, CellBlock, TickRing, make_folder
from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.registration import ComponentKind
from virtualrobot_sdk.settings import make_settings

from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.drivers.far_side import Process
from virtualrobot_kernel.drivers.twin import Asked, Twin
from virtualrobot_kernel.errors import KernelError


class DriverSite:
    """Maker of driver processes; see `far_side.Site`. It owns the folder, which goes with it."""

    def __init__(self, catalog: Catalog) -> None:
        """Take drivers from this catalogue."""
        self._catalog = catalog
        self._folder: Path | None = None
        self._cell: CellBlock | None = None
        self._numbers = count(1)
        self._lock = threading.Lock()
