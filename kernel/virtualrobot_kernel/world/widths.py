"""Widths of tools: how far fingers are apart as a function of the joints and back, straight between known places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.world.structure import Node, Structure, ToolData, ToolWidth

ROUNDING = 1e-9
"""Greatest distance of a width from the ends, in meters, that is taken for the end."""


def check_widths(widths: tuple[ToolWidth, ...], what: str) -> None:
    """Raise KernelError, which names the field, unless widths rise and tell one place of the joints each."""
    if not widths:
        return
    joints = widths[0].joint_positions.keys()
    if any(one.joint_positions.keys() != joints for one in widths) or not joints:
        raise KernelError(f"{what}.widths must all name the same joints, at least one", field=f"{what}.widths")
    rising = np.diff([one.width for one in widths]) > 0.0
    if len(widths) < 2 or not rising.all() or widths[0].width < 0.0:
        raise KernelError(f"{what}.widths needs two widths or more, from 0 m on and rising", field=f"{what}.widths")
    if leading_joint(widths) is None:
        raise KernelError(
            f"{what}.widths must tell apart: one of the joints has to go one way all along", field=f"{what}.widths"
        )


def leading_joint(widths: tuple[ToolWidth, ...]) -> str | None:
    """Return the first joint that goes one way from the least width to the greatest, None where none does."""
    for joint in widths[0].joint_positions:
        steps = np.diff([one.joint_positions[joint] for one in widths])
        if (steps > 0.0).all() or (steps < 0.0).all():
            return joint
    return None


def positions_at(tool: Node, width: float) -> dict[str, float]:
    """Return where joints are at a width (m); raise KernelError for a tool without widths, LimitError beyond them."""
    widths = tool.data.widths if isinstance(tool.data, ToolData) else ()
    if not widths:
        raise KernelError(f"the tool {tool.name!r} has no widths; set one of its states", tool=tool.name)
    least, most = widths[0].width, widths[-1].width
    if not least - ROUNDING <= width <= most + ROUNDING:
        raise LimitError(
            f"the tool {tool.name!r} cannot open to {width:g} m; its widths are {least:g} to {most:g} m",
            tool=tool.name,
            value=width,
            lower=least,
            upper=most,
        )
    known = [one.width for one in widths]
    return {
        joint: float(np.interp(width, known, [one.joint_positions[joint] for one in widths]))
        for joint in widths[0].joint_positions
    }


def state_at(tool: Node, positions: dict[str, float]) -> str:
    """Return the state of a tool that has its joints at these positions; empty for none."""
    assert isinstance(tool.data, ToolData)
    for name, own in tool.data.states.items():
        if own.keys() == positions.keys() and all(abs(own[joint] - positions[joint]) <= ROUNDING for joint in own):
            return name
    return ""


def width_of(structure: Structure, tool: Node, q: NDArray[np.float64]) -> float | None:
    """Return how wide a tool is open (m) with all coordinates at q (nq,), None for one without widths.

    It follows from the joint that leads; beyond the known widths it is the one at that end.
    """
    owner = structure.robot_of(tool.uid)
    widths = tool.data.widths if isinstance(tool.data, ToolData) else ()
    if not widths or owner is None:
        return None
    joint = leading_joint(widths)
    assert joint is not None, "checked when it was given"
    rows = sorted((one.joint_positions[joint], one.width) for one in widths)
    at = float(q[structure.robots[owner.uid].coordinates[joint].q])
    return float(np.interp(at, [position for position, _ in rows], [width for _, width in rows]))
