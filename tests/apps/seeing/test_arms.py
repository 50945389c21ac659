"""An arm in a real kernel that looks where it can, and is told which grasps it reaches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess
from virtualrobot_apps.seeing.arms import VIEW_T_SENSOR, Eye, postures
from virtualrobot_apps.seeing.views.planning import NoViewError, ViewPlanner, views_around
from virtualrobot_apps.seeing.views.voxels import Voxels

pytestmark = pytest.mark.long
HOME = [0.0, 0.3, 0.0, -1.5, 0.0, 1.3, 0.0]
BODY = np.array([0.6, 0.0, 0.25])


@pytest.fixture(scope="module")
def client() -> Iterator[virtualrobot.Client]:
    """Return a client of a cell: an iiwa with a scanner, and a block on a table."""
    with KernelProcess(headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        client.clock.speed_factor = 5.0
        table = virtualrobot.box(0.7, 0.9, 0.02)
        client.scene.add_object("table", table, pose=virtualrobot.pose(0.65, 0.0, 0.19))
        client.scene.add_part("body", virtualrobot.box(0.04, 0.12, 0.1), pose=virtualrobot.pose(*BODY))
        arm = client.load_robot("model://iiwa", name="arm")
        arm.set_positions(HOME)
        pattern = virtualrobot.raster(40, 40, 0.9, 0.9)
        mounted = virtualrobot.pose(x=0.1, z=0.03, pitch=-np.pi / 2)
        scanner = virtualrobot.range_sensor(pattern=pattern, max_range=1.5)
        client.scene.add_range_sensor("laser", scanner, parent=arm.flange, pose=mounted)
        yield client


def test_a_view_is_had_where_it_was_asked_for(client: virtualrobot.Client) -> None:
    """The scanner stands where the view is, looks along its z, and its echoes are on the block and the table."""
    eye = Eye(client, "arm", "laser")
    views = views_around(BODY, np.array([0.4]), 24, lowest=0.2)
    found = eye.postures(views)
    number = next(at for at, one in enumerate(found) if one is not None)
    place, echoes = eye.look(found[number])
    np.testing.assert_allclose(place, views[number, :3, 3], atol=1e-3)
    np.testing.assert_allclose(client.scene.pose("laser")[:3, 0], (views[number] @ VIEW_T_SENSOR)[:3, 0], atol=1e-3)
    on_table = np.abs(echoes[:, 2] - 0.2) < 1e-3
    on_block = (np.abs(echoes - BODY) < np.array([0.02, 0.06, 0.05]) + 1e-3).all(axis=1)
    assert on_block.sum() > 20 and (on_table | on_block).mean() > 0.95


def test_it_looks_where_time_goes_on_by_steps_too(client: virtualrobot.Client) -> None:
    eye = Eye(client, "arm", "laser")
    views = views_around(BODY, np.array([0.4]), 24, lowest=0.2)
    there = next(one for one in reversed(eye.postures(views)) if one is not None)
    with client.clock.hold_stepped():
        _, echoes = eye.look(there)
    np.testing.assert_allclose([client.robot("arm").positions], [list(there.values())], atol=1e-6)
    assert len(echoes) > 100


def test_what_no_arm_reaches_is_no_view_and_no_grasp(client: virtualrobot.Client) -> None:
    """Five meters away nothing is in reach, and within the table the arm would touch it."""
    eye = Eye(client, "arm", "laser")
    far = views_around(np.array([5.0, 0.0, 0.3]), np.array([0.4]), 4)
    voxels = Voxels((4.8, -0.2, 0.2), (5.2, 0.2, 0.4), 0.05)
    with pytest.raises(NoViewError, match="none of 4 views is in reach"):
        ViewPlanner(
            voxels,
            far,
            np.array([[0.0, 0.0, 1.0]]),
            1.5,
            lambda some: np.array([bool(one) for one in eye.postures(some)]),
        )
    down = virtualrobot.pose(0.6, 0.25, 0.45, roll=np.pi)
    below = virtualrobot.pose(0.6, 0.25, 0.12, roll=np.pi)
    above, within = postures(client, "arm", [down, below])
    assert above is not None and within is None
