"""Ways to run a world of faults."""

from __future__ import annotations

import sys

import hypothesis
from hypothesis import HealthCheck, Phase, settings
from hypothesis.errors import Flaky, HypothesisException
from hypothesis.stateful import RuleBasedStateMachine, run_state_machine_as_test

STEPS = 30
APART = [("grpc.use_local_subchannel_pool", 1)]
"""Options of channels that have a connection of their own, as those of other processes have."""


def run(machine: type[RuleBasedStateMachine], seed: int, worlds: int, steps: int = STEPS, shrink: bool = True) -> None:
    """Run a machine; hypothesis prints what fails as a program, and makes it smaller before (`shrink`).

    Hypothesis tries each failure again. One that doesn't come again it tells as `Flaky` alone, since then other
    values were drawn: what had failed is raised instead.
    """
    chosen = settings(
        max_examples=worlds,
        stateful_step_count=steps,
        deadline=None,
        database=None,
        phases=[Phase.generate, *([Phase.shrink] if shrink else [])],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )
    failures: list[Exception] = []

    def teardown(self: RuleBasedStateMachine) -> None:
        failed = sys.exception()  # what ends this world, unless that is hypothesis
        if isinstance(failed, Exception) and not isinstance(failed, HypothesisException):
            failures.append(failed)
        try:
            machine.teardown(self)
        except Exception as error:
            failures.append(error)
            raise

    noted = type(machine.__name__, (machine,), {"teardown": teardown})
    try:
        run_state_machine_as_test(hypothesis.seed(seed)(noted), settings=chosen)
    except Flaky as flaky:
        if failures:
            raise failures[0] from flaky
        raise
