"""Plans of moves that go together, for tests that need no program."""

from __future__ import annotations

from collections.abc import Sequence

from virtualrobot_kernel.planning.moves import Move
from virtualrobot_kernel.planning.plan_motion import plan_motion
from virtualrobot_kernel.planning.program import MotionSpec
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_kernel.world.state import Snapshot


def start_of(snapshot: Snapshot, moves: Sequence[Move], solver_of: SolverOf) -> StartMotion:
    """Return the command that starts these moves together."""
    return plan_motion(snapshot, MotionSpec(tuple(moves)), solver_of).command
