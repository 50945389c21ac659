"""Random clients at a real kernel: they edit, move, lease and vanish, and the world stays whole."""

from __future__ import annotations

from pathlib import Path

import hypothesis
import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.faults.machine import WorldOfFaults
from tests.fuzz.readers import bare_arm
from tests.kernels import KernelProcess
from tests.tiers import Draws


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of an arm without meshes."""
    path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_bytes(bare_arm())
    return path


def test_whatever_clients_do_the_world_stays_whole(
    stepped_kernel: KernelProcess, arm: Path, seed: int, draws: Draws
) -> None:
    machine = type("World", (WorldOfFaults,), {"kernel": stepped_kernel, "arm": arm})
    chosen = settings(
        max_examples=draws(30),
        stateful_step_count=30,
        deadline=None,
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )
    run_state_machine_as_test(hypothesis.seed(seed)(machine), settings=chosen)
