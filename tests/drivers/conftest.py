"""Cables between drivers and what stands in for their controllers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.drivers.cables import Cable


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    """Yield a cable whose other end nobody has."""
    cable = Cable(tmp_path)
    yield cable
    cable.unplug()
