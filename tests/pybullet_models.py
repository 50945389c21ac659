"""PyBullet and the models that come with it: who imports this is skipped where it is not, as on Python from 3.12 on."""

from __future__ import annotations

from pathlib import Path

import pytest

_WHY = "PyBullet, whose models and engine this takes, has no wheel for this Python"
pybullet = pytest.importorskip("pybullet", reason=_WHY)
pybullet_data = pytest.importorskip("pybullet_data", reason=_WHY)

MODELS = Path(pybullet_data.getDataPath())
