"""Jogs of joints that turn or slide without end, planned."""

from __future__ import annotations

from dataclasses import replace
from math import tau

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.planning.moves import JointJog
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.structure import Joint, JointLimits, JointType, Kind, NodeSpec, RobotData

from tests.unit.planning.test_moves import nobody, pictured
from tests.unit.world.builders import Z, after, empty, link


def test_joints_without_limits_go_a_whole_turn_or_need_a_distance() -> None:
    endless = JointLimits(-np.inf, np.inf, 1.0, 4.0, 40.0)
    world = after(
        empty(),
        CreateNodes(
            (
                NodeSpec("table", Kind.ROBOT, "world", data=RobotData()),
                link("table.plate", "table", Joint("turn", JointType.CONTINUOUS, Z, endless)),
                link("table.slide", "table.plate", Joint("slide", JointType.PRISMATIC, Z, replace(endless))),
            )
        ),
    )
    snapshot = pictured(world)
    turn = JointJog("table", "turn", -0.5).plan(snapshot, nobody)
    assert turn.plan.goal[0] == pytest.approx(-tau)
    assert turn.speed_factor == pytest.approx(0.5)
    assert not turn.notes
    assert JointJog("table", "slide", 0.5, 3.0).plan(snapshot, nobody).plan.goal[0] == pytest.approx(3.0)
    with pytest.raises(KernelError, match="needs a distance"):
        JointJog("table", "slide", 0.5).plan(snapshot, nobody)
