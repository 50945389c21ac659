"""Cables between drivers and what stands in for their controllers, and benches of links."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

import pytest

from tests.drivers.cables import Cable

if TYPE_CHECKING:
    from tests.drivers.bench import Bench


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    """Yield a cable whose other end nobody has."""
    cable = Cable(tmp_path)
    yield cable
    cable.unplug()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """Give a bench of its own."""
    # Only here: tests of drivers alone need no kernel.
    from virtualrobot_kernel.drivers import link

    from tests.drivers.bench import Bench
    from tests.drivers.sham_site import ShamSite
    from tests.inside import kernel_inside
    from tests.waiting import PATIENCE_SECONDS

    site = ShamSite(tmp_path)
    with (
        mock.patch("virtualrobot_kernel.kernel.DriverSite", lambda *_: site),
        mock.patch.object(link, "SILENT_SECONDS", PATIENCE_SECONDS),  # shams wait for the interpreter's lock
        kernel_inside() as (kernel, address),
    ):
        yield Bench(kernel, address, site)
