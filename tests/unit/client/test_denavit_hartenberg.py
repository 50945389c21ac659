"""Denavit-Hartenberg tables as messages, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import virtualrobot
from virtualrobot._wire.messages import pose_of
from virtualrobot.robots.denavit_hartenberg import table_message
from virtualrobot.robots.values import JointLimits
from virtualrobot.v1 import nodes_pb2, scene_pb2


def row(given: Any) -> scene_pb2.DenavitHartenbergRow:  # noqa: ANN401 what it must not be, too
    return table_message([given], "standard", None, None).rows[0]


def test_rows_may_be_numbers_or_dictionaries() -> None:
    plain = row((0.1, 0.2, 0.3, 0.4))
    assert (plain.a_meters, plain.alpha_radians, plain.d_meters, plain.theta_radians) == (0.1, 0.2, 0.3, 0.4)
    assert (plain.name, plain.type, plain.HasField("limits")) == ("", nodes_pb2.JOINT_TYPE_UNSPECIFIED, False)
    assert row(np.array([0.1, 0.2, 0.3, 0.4])) == plain
    assert row({"a": 0.1, "alpha": 0.2, "d": 0.3, "theta": 0.4}) == plain
    sliding = row({"d": 1, "name": "lift", "type": "prismatic", "limits": (0, 0.5)})
    assert (sliding.a_meters, sliding.d_meters, sliding.name) == (0.0, 1.0, "lift")
    assert sliding.type == nodes_pb2.JOINT_TYPE_PRISMATIC
    assert (sliding.limits.lower, sliding.limits.upper, sliding.limits.velocity) == (0.0, 0.5, 0.0)


def test_limits_may_be_a_pair_a_dictionary_or_those_of_another_robot() -> None:
    by_name = row({"limits": {"upper": 2.0, "velocity": 3.0}}).limits
    assert (by_name.HasField("lower"), by_name.upper, by_name.velocity) == (False, 2.0, 3.0)
    other = row({"limits": JointLimits(-math.inf, math.inf, 1.0, 2.0, 3.0, 4.0)}).limits
    assert (other.HasField("lower"), other.HasField("upper")) == (False, False)
    assert (other.velocity, other.acceleration, other.jerk, other.effort) == (1.0, 2.0, 3.0, 4.0)


def test_poses_and_convention() -> None:
    base, flange = virtualrobot.pose(z=0.4), virtualrobot.pose(0.1, roll=1.0)
    table = table_message([(0, 0, 0, 0)], "modified", base, flange)
    assert table.convention == scene_pb2.DENAVIT_HARTENBERG_CONVENTION_MODIFIED
    np.testing.assert_allclose(pose_of(table.base_t_first), base, atol=1e-15)
    np.testing.assert_allclose(pose_of(table.last_t_flange), flange, atol=1e-15)
    assert not table_message([], "standard", None, None).HasField("base_t_first")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="a convention is standard or modified, not 'craig'"):
        table_message([], "craig", None, None)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((1, 2, 3), r"row 1 of the table is \(1, 2, 3\); it must be the four numbers a, alpha, d, theta"),
        ("abcd", "row 1 of the table is 'abcd'"),
        ({"alfa": 1.0}, "row 1 of the table has 'alfa'; there is a, alpha, d, theta, name, type, limits"),
        ({"a": "x"}, "a in row 1 of the table is 'x'; it must be a number"),
        ((0, math.nan, 0, 0), "alpha in row 1 of the table is nan; it must be finite"),
        ({"type": "hinge"}, "the type in row 1 of the table is revolute, continuous, prismatic, not 'hinge'"),
        ({"limits": (1, 2, 3)}, r"the limits in row 1 of the table are \(lower, upper\) or a dictionary"),
        ({"limits": {"speed": 1}}, "the limits in row 1 of the table have 'speed'; there is lower, upper, velocity"),
        ({"limits": (math.inf, 1)}, "lower of the limits in row 1 of the table is inf"),
    ],
)
def test_rows_that_are_none_are_refused(given: object, message: str) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=message):
        row(given)
