"""Which robots a command touches; the effect over the contract is in tests/api/test_lease_scope.py."""

from __future__ import annotations

from typing import get_args

from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.affected_robots import AFFECTED
from virtualrobot_kernel.world.apply import HANDLERS


def test_every_command_says_whom_it_touches() -> None:
    assert AFFECTED.keys() == HANDLERS.keys() == set(get_args(commands.Command))
