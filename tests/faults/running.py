"""Ways to run a world of faults."""

from __future__ import annotations

import hypothesis
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.faults.machine import WorldOfFaults

STEPS = 30
APART = [("grpc.use_local_subchannel_pool", 1)]
"""Options of channels that have a connection of their own, as those of other processes have."""


def run(machine: type[WorldOfFaults], seed: int, worlds: int, steps: int = STEPS, shrink: bool = True) -> None:
    """Run a machine; hypothesis prints what fails as a program, and makes it smaller before (`shrink`)."""
    chosen = settings(
        max_examples=worlds,
        stateful_step_count=steps,
        deadline=None,
        database=None,
        phases=[Phase.generate, *([Phase.shrink] if shrink else [])],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )
    run_state_machine_as_test(hypothesis.seed(seed)(machine), settings=chosen)
