"""Plans of moves that go together, for tests that need no program."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.planning.plan_program import plan_wish
from virtualrobot_kernel.planning.program import MotionWish
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.planning.wishes import Move
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.state import Snapshot


def plan_motion(snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf) -> StartMotion:
    """Return the command that starts these moves together."""
    return plan_wish(snapshot, MotionWish(tuple(moves)), solver_of).command
