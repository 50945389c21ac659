"""Kinds of moves, a file each: a new one is a class here and an entry in `api/convert/moves.py`."""

from virtualrobot_kernel.planning.moves.cartesian_jog import CartesianJog, JogFrame
from virtualrobot_kernel.planning.moves.circular import Circular
from virtualrobot_kernel.planning.moves.joint_jog import JointJog
from virtualrobot_kernel.planning.moves.joint_trajectory import JointTrajectory, Tolerances
from virtualrobot_kernel.planning.moves.linear import Linear
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.moves.path_move import PathMove
from virtualrobot_kernel.planning.moves.point_to_point import ActuatorGoal, PointToPoint, goal_positions
from virtualrobot_kernel.planning.moves.spline import Spline
from virtualrobot_kernel.planning.moves.tool_state import ToolStateMove

__all__ = [
    "ActuatorGoal",
    "CartesianJog",
    "Circular",
    "JogFrame",
    "JointJog",
    "JointTrajectory",
    "Linear",
    "Move",
    "PathMove",
    "PointToPoint",
    "Spline",
    "Tolerances",
    "ToolStateMove",
    "goal_positions",
]
