"""Torques through the client; numbers against pinocchio are in tests/api/test_dynamics.py."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

FIRST, SECOND = "lbr_iiwa_joint_1", "lbr_iiwa_joint_2"


def test_values_by_name_and_in_order_are_the_same(iiwa: Robot, rng: np.random.Generator) -> None:
    q, v, a = rng.uniform(-1.5, 1.5, (3, 10, 7))
    found = iiwa.solve_inverse_dynamics(q, v, a)
    assert found.efforts.shape == found.gravity_efforts.shape == (10, 7)
    assert found.base_wrenches.shape == (10, 6)
    by_name = [dict(zip(iiwa.joint_names, values.T, strict=True)) for values in (q, v, a)]
    again = iiwa.solve_inverse_dynamics(by_name[0], by_name[1], by_name[2])
    np.testing.assert_array_equal(again.efforts, found.efforts)
    one = iiwa.solve_inverse_dynamics(q[0], v[0], a[0])
    np.testing.assert_array_equal(one.efforts, found.efforts[:1])
    np.testing.assert_array_equal(iiwa.solve_inverse_dynamics(q).efforts, found.gravity_efforts)
    iiwa.set_positions(q[0])
    two = iiwa.solve_inverse_dynamics(accelerations={SECOND: [0.0, a[0, 1]], FIRST: a[0, 0]})
    assert two.joint_names == (SECOND, FIRST)
    expected = iiwa.solve_inverse_dynamics(q[0], np.zeros(7), [a[0, 0], a[0, 1], 0, 0, 0, 0, 0]).efforts[0]
    np.testing.assert_allclose(two.efforts[1], expected[[1, 0]], rtol=1e-12)


def test_gravity_torques_with_a_held_part(client: Client, iiwa: Robot) -> None:
    """A part of 2 kg, 0.3 m in front of the flange of a robot that stands upright: 2 * 9.81 * 0.3 N m more."""
    before = iiwa.gravity_torques()
    weight = virtualrobot.inertial(2.0, (0.3, 0.0, 0.0))
    client.scene.add_part("part", virtualrobot.box(0.1, 0.1, 0.1), parent=iiwa.flange, inertial=weight)
    found = iiwa.solve_inverse_dynamics()
    assert (found.payload, found.warnings) == (2.0, ())
    after = iiwa.gravity_torques()
    assert abs(after[SECOND] - before[SECOND]) == pytest.approx(2.0 * 9.81 * 0.3, rel=1e-9)
    assert iiwa.gravity_torques({SECOND: 0.5})[SECOND] != pytest.approx(after[SECOND], abs=1.0)
    # The arm's own mass and the part's stand on the base.
    assert found.base_wrenches[0, 2] > 2.0 * 9.81
    client.scene.add_tool("tool", iiwa.flange, inertial=virtualrobot.inertial(0.5))
    assert iiwa.solve_inverse_dynamics().payload == 2.5


def test_values_that_fit_nothing_are_refused(iiwa: Robot) -> None:
    wrong = virtualrobot.InvalidArgumentError
    with pytest.raises(wrong, match="all values by joint name, or all in order"):
        iiwa.solve_inverse_dynamics({FIRST: 0.0}, np.zeros(7))
    with pytest.raises(wrong, match=f"velocities lacks the joint '{SECOND}'"):
        iiwa.solve_inverse_dynamics({FIRST: 0.0, SECOND: 0.0}, {FIRST: 0.0})
    with pytest.raises(wrong, match=r"have the shape \(n, k\)"):
        iiwa.solve_inverse_dynamics(np.zeros((2, 2, 7)))
    with pytest.raises(wrong, match="as many for each joint"):
        iiwa.solve_inverse_dynamics({FIRST: [0.0, 1.0], SECOND: [0.0, 1.0, 2.0]})
    with pytest.raises(wrong, match="velocities has 3 samples and positions 2"):
        iiwa.solve_inverse_dynamics(np.zeros((2, 7)), np.zeros((3, 7)))
    with pytest.raises(wrong, match="not finite"):
        iiwa.solve_inverse_dynamics(velocities=[np.nan, 0, 0, 0, 0, 0, 0])
    with pytest.raises(wrong, match="a mass is above 0 kg"):
        virtualrobot.inertial(0.0)


def test_gravity_torques_tell_of_bodies_without_a_mass(
    client: Client, iiwa: Robot, caplog: pytest.LogCaptureFixture
) -> None:
    iiwa.gravity_torques()
    assert not caplog.records
    light = client.load_denavit_hartenberg([(0.5, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0)], convention="standard")
    assert set(light.gravity_torques().values()) == {0.0}
    warnings = light.solve_inverse_dynamics().warnings
    assert warnings and tuple(caplog.messages) == warnings
