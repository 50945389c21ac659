"""Widths of tools: from widths to joints and back, and tables that make no sense."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.structure import Kind, NodeSpec, ToolData, ToolWidth
from virtualrobot_kernel.world.widths import check_widths, leading_joint, positions_at, width_of

from tests.unit.world.builders import after, arm, empty


def table(*rows: tuple[float, float, float]) -> tuple[ToolWidth, ...]:
    return tuple(ToolWidth(width, {"a": a, "f": f}) for width, a, f in rows)


def with_tool(widths: tuple[ToolWidth, ...], parent: str = "arm.hand") -> Change:
    tool = NodeSpec("claw", Kind.TOOL, parent, data=ToolData(widths=widths))
    return after(empty(), arm(), CreateNodes((tool,)))


def test_a_width_is_where_the_joints_are_and_back(rng: np.random.Generator) -> None:
    """The joint that leads falls; the other one goes forth and back."""
    world = with_tool(table((0.01, 0.1, 0.04), (0.03, 0.5, 0.01), (0.08, 0.2, 0.0)))
    claw = world.structure.node("claw")
    assert isinstance(claw.data, ToolData)
    assert leading_joint(claw.data.widths) == "f"
    assert positions_at(claw, 0.02) == pytest.approx({"a": 0.3, "f": 0.025})
    places = world.structure.robots[world.structure.node("arm").uid].coordinates
    for width in rng.uniform(0.01, 0.08, 10).tolist():
        q = world.state.q.copy()
        for joint, value in positions_at(claw, width).items():
            q[places[joint].q] = value
        assert width_of(world.structure, claw, q) == pytest.approx(width, abs=1e-12)
    assert width_of(world.structure, world.structure.node("arm_gripper"), world.state.q) is None


@pytest.mark.parametrize(
    ("widths", "words"),
    [
        (table((0.01, 0.0, 0.0)), "two widths or more"),
        (table((0.01, 0.0, 0.0), (0.01, 0.1, 0.1)), "rising"),
        (table((0.02, 0.0, 0.0), (0.01, 0.1, 0.1)), "rising"),
        (table((-0.01, 0.0, 0.0), (0.01, 0.1, 0.1)), "from 0 m on"),
        (table((0.0, 0.0, 0.0), (0.01, 0.1, 0.1), (0.02, 0.0, 0.0)), "one way all along"),
        ((ToolWidth(0.0, {}), ToolWidth(0.1, {})), "the same joints, at least one"),
        ((ToolWidth(0.0, {"a": 0.0}), ToolWidth(0.1, {"f": 0.0})), "the same joints"),
    ],
)
def test_a_table_that_tells_no_width_is_refused(widths: tuple[ToolWidth, ...], words: str) -> None:
    with pytest.raises(KernelError, match=words):
        check_widths(widths, "claw.tool")


def test_a_table_names_joints_that_are_there_within_their_limits() -> None:
    with pytest.raises(KernelError, match=r"the width 0\.1 m of the tool 'claw': .*cannot be at"):
        with_tool(table((0.0, 0.0, 0.0), (0.1, 0.1, 0.05)))
    with pytest.raises(KernelError, match="no joint"):
        with_tool((ToolWidth(0.0, {"z": 0.0}), ToolWidth(0.1, {"z": 0.1})))
    with pytest.raises(KernelError, match="the tool is on no robot"):
        with_tool(table((0.0, 0.0, 0.0), (0.1, 0.1, 0.04)), "world")
