"""Fixtures of worlds of faults."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz.readers import bare_arm


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of an arm without meshes."""
    path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_bytes(bare_arm())
    return path
