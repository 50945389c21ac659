"""Visibility of nodes: hidden ones hide what is below them, and tools show the figures of their state."""

from __future__ import annotations

from collections.abc import Mapping

from virtualrobot_kernel.world.structure import Kind, Structure, ToolData


def inherited_visibility(
    structure: Structure, tool_states: Mapping[int, str]
) -> tuple[dict[int, bool], dict[int, str]]:
    """Return for each uid whether it or a node above it is hidden, and the state of the tool that it belongs to."""
    uids = tuple(structure.nodes)
    hidden, states = {0: False}, {0: ""}
    for row in structure.forest.order.tolist():
        node = structure.nodes[uids[row]]
        hidden[node.uid] = hidden[node.parent] or node.hidden
        states[node.uid] = states[node.parent]
        if node.kind is Kind.TOOL and isinstance(node.data, ToolData):
            states[node.uid] = tool_states.get(node.uid) or next(iter(node.data.states), "")
    return hidden, states
