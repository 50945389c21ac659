"""An underwater vehicle with a manipulator: the law of its correction, and both in a real kernel."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles import uvms
from virtualrobot_apps.vehicles.tool_keeper import ToolKeeper, apart, carried_along
from virtualrobot_apps.vehicles.vehicle_file import read
from virtualrobot_sdk.poses import rotation_matrix

from tests.kernels import KernelProcess

FAST = np.full(6, 1e6)


def test_poses_apart_are_a_way_and_a_rotation_vector(rng: np.random.Generator) -> None:
    """The rotation by the vector (Rodrigues' formula) leads from one to the other."""
    for _ in range(20):
        first, vector = np.eye(4), rng.uniform(-1.7, 1.7, 3)
        first[:3, :3] = rotation_matrix(rng.uniform(-1.0, 1.0, 3))
        last = first.copy()
        last[:3, :3] = rotation_matrix(vector) @ first[:3, :3]
        last[:3, 3] = rng.uniform(-1.0, 1.0, 3)
        np.testing.assert_allclose(apart(first, last), [*last[:3, 3], *vector], atol=1e-9)
    assert not apart(np.eye(4), np.eye(4)).any()


def test_joints_move_the_tool_against_the_vehicle_and_towards_its_place(rng: np.random.Generator) -> None:
    """J q' + V = K e, but for the damping."""
    law = ToolKeeper(FAST, gain=4.0, damping=1e-9)
    for _ in range(20):
        jacobian, error, along = rng.normal(size=(6, 6)), rng.normal(size=6), rng.normal(size=6)
        rates = law.rates(jacobian, error, along)
        np.testing.assert_allclose(jacobian @ rates + along, 4.0 * error, atol=1e-6)


def test_joints_keep_their_limits_and_the_direction() -> None:
    slow = ToolKeeper(np.array([1.0, 1.0, 0.5, 9.0, 9.0, 9.0]), gain=1.0, damping=0.0)
    rates = slow.rates(np.eye(6), np.array([4.0, 2.0, 3.0, 0.0, 0.0, 0.0]), np.zeros(6))
    np.testing.assert_allclose(rates, np.array([4.0, 2.0, 3.0, 0.0, 0.0, 0.0]) / 6.0)


def test_a_singular_posture_gives_finite_speeds() -> None:
    """Damped least squares (Wampler 1986): at most error / (2 damping) of any direction."""
    law = ToolKeeper(FAST, gain=1.0, damping=0.1)
    for value in (0.0, 1e-6, 0.05, 0.1):
        rates = law.rates(np.diag([value, 1.0, 1.0, 1.0, 1.0, 1.0]), np.array([1.0, 0, 0, 0, 0, 0]), np.zeros(6))
        assert rates[0] == pytest.approx(value / (value**2 + 0.01))
        assert rates[0] <= 1.0 / 0.2 + 1e-12


@pytest.mark.parametrize("knows", [True, False])
def test_a_steady_drift_leaves_no_error_where_it_is_known(knows: bool) -> None:
    """Standstill error of a steady drift v: v / K where it is not fed forward, none where it is."""
    law, drift, period = ToolKeeper(FAST, gain=5.0, damping=0.0), np.array([0.05, -0.03, 0.02, 0, 0, 0]), 0.02
    tool = np.zeros(6)
    for _ in range(500):
        rates = law.rates(np.eye(6), -tool, drift if knows else np.zeros(6))
        tool = tool + period * (drift + rates)
    np.testing.assert_allclose(tool, np.zeros(6) if knows else drift / 5.0, atol=1e-12)


def test_a_point_of_a_turning_vehicle_goes_round_it() -> None:
    along = carried_along(np.array([1.0, 2.0, 0.0]), np.array([1.0, 1.0, 0.0]), np.zeros(3), np.array([0.0, 0.0, 0.5]))
    np.testing.assert_allclose(along, [-0.5, 0.0, 0.0, 0.0, 0.0, 0.5])


@pytest.mark.long
def test_an_arm_keeps_its_tool_while_its_vehicle_drifts(steps: virtualrobot.Client) -> None:
    """In a current the vehicle is some centimeters off its place; of these the tool of a stiff arm feels all."""
    vehicle = read(uvms.VEHICLE)
    runs = {}
    for corrects in (False, True):
        uvms.build(steps, vehicle, uvms.WORKING, uvms.CURRENT)
        runs[corrects] = uvms.hold(steps, vehicle, corrects, seconds=3.0)
    stiff, corrected = runs[False], runs[True]
    assert stiff.hull.max() > 0.01
    assert stiff.tool[:, 0].max() == pytest.approx(stiff.hull.max(), rel=0.5)
    assert corrected.hull.max() > 0.01
    assert corrected.rms < 0.1 * stiff.rms
    assert corrected.tool[-1, 0] < 1e-3


@pytest.mark.long
def test_an_arm_that_reaches_out_pushes_its_vehicle_away(steps: virtualrobot.Client) -> None:
    """Momentum: 2.2 kg that move by some decimeters move 13.5 kg and their water by a tenth of that, the other way."""
    uvms.build(steps, read(uvms.VEHICLE), uvms.FOLDED)
    before = steps.robot(uvms.ARM).tcp[:3, 3].copy()
    way, angle = uvms.reach_out(steps)
    assert np.linalg.norm(steps.robot(uvms.ARM).tcp[:3, 3] - before) > 0.1
    assert 1e-3 < way < 0.05
    assert angle < 0.5


@pytest.mark.long
def test_the_demo_tells_its_numbers(stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    plot = tmp_path / "uvms.svg"
    given = ["demo", "uvms", "--address", stepped_kernel.address, "--headless", "--plot", str(plot)]
    result = CliRunner().invoke(cli, given)
    assert result.exit_code == 0, result.output
    assert "arm reaches out" in result.output
    assert "tool held, arm corrects" in result.output
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")
