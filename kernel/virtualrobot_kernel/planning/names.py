"""Names in the steps of a program: the nodes and the signals that must be there when a step is done."""

from __future__ import annotations

from collections.abc import Iterable

from virtualrobot_kernel.planning.moves import ToolStateMove
from virtualrobot_kernel.planning.program import (
    DecisionStep,
    MoveStep,
    OrderStep,
    SetSignalStep,
    SpeedStep,
    Step,
    WaitPartStep,
    WaitSignalStep,
)
from virtualrobot_kernel.world.commands import SetAllowedPairs

NODES_OF_ORDERS = ("robot", "part", "parent", "name", "tool")
"""Fields of orders that are names of nodes."""


def named_nodes(steps: Iterable[Step]) -> tuple[str, ...]:
    """Return the nodes that steps name, once each in their order; the world, an empty name, is none."""
    return tuple(dict.fromkeys(name for step in steps for name in _nodes(step) if name))


def named_signals(steps: Iterable[Step]) -> frozenset[str]:
    """Return the signals that steps set, wait for, search by or decide by."""
    return frozenset(name for step in steps for name in _signals(step))


def _nodes(step: Step) -> Iterable[str]:
    if isinstance(step, MoveStep):
        tools = [move.tool for move in step.moves if isinstance(move, ToolStateMove)]
        return [*(name for move in step.moves for name in (move.robot, *move.frames)), *tools]
    if isinstance(step, OrderStep):
        order = step.order
        if isinstance(order, SetAllowedPairs):
            return [name for pair in (*order.allow, *order.forbid) for name in pair[:2]]
        return [getattr(order, field, "") for field in NODES_OF_ORDERS]
    if isinstance(step, WaitPartStep):
        return [step.awaited.part, step.awaited.reference]
    return [step.robot] if isinstance(step, SpeedStep) else []


def _signals(step: Step) -> Iterable[str]:
    if isinstance(step, MoveStep):
        return [move.search.signal for move in step.moves if move.search]
    if isinstance(step, (WaitSignalStep, DecisionStep)):
        return [step.condition.signal]
    return [step.signal] if isinstance(step, SetSignalStep) else []
