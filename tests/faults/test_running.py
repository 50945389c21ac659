"""A failure that comes once only is told as what it was, however hypothesis takes it."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule

from tests.faults.running import run

ONCE = "this was wrong once"


class Once(RuleBasedStateMachine):
    """Machine whose rule, or whose end, fails a single time."""

    at_the_end = False
    failed = False

    @rule(number=st.integers(0, 9))
    def count(self, number: int) -> None:
        """Fail the first time."""
        self._fail(at_the_end=False)

    def teardown(self) -> None:
        """Fail the first time."""
        self._fail(at_the_end=True)

    def _fail(self, at_the_end: bool) -> None:
        if self.at_the_end is at_the_end and not type(self).failed:
            Once.failed = True
            raise AssertionError(ONCE)


@pytest.mark.long
@pytest.mark.parametrize("at_the_end", [False, True])
@pytest.mark.parametrize("shrink", [False, True])
def test_a_failure_that_does_not_come_again_is_told(at_the_end: bool, shrink: bool, seed: int) -> None:
    Once.failed, Once.at_the_end = False, at_the_end
    with pytest.raises(AssertionError, match=ONCE):
        run(Once, seed, worlds=3, steps=5, shrink=shrink)
