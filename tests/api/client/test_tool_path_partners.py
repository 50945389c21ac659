"""Arms that go along tool paths of their own by one law of time: what both do, tick by tick, and what is refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client, ToolPathPartner

Floats = NDArray[np.float64]

CENTRE, SPEED, TICK = np.array([0.45, -0.15, 0.75]), 0.05, 0.004
FREE = {"rotation_z": "free"}
ACROSS = virtualrobot.pose(0.9, -0.3, 0.0) @ np.diag([-1.0, -1.0, 1.0, 1.0])
"""Base of an arm across from one in the origin: CENTRE is where it is from both."""


def arc(radius: float, count: int = 61, at: Floats = CENTRE) -> Floats:
    """Return frames on half a circle about the vertical through a place, tools pointing down."""
    angles = np.linspace(0.0, np.pi, count)
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)
    return virtualrobot.path_frames(at + radius * around, (0.0, 0.0, -1.0))


def pumas(client: Client, apart: float = 0.8) -> None:
    """Load two arms, which face each other over a distance (m) more than both could use."""
    client.load_robot("model://puma560", name="left")
    client.load_robot("model://puma560", name="right", pose=virtualrobot.pose(x=apart) @ ACROSS)


@pytest.mark.long
def test_two_arms_of_different_ways_go_by_one_law(steps: Client) -> None:
    """Circles are formulas: both tools within 0.01 mm of theirs at each 4th tick, at the same part of both ways."""
    pumas(steps)
    left, right = steps.robot("left"), steps.robot("right")
    frames = arc(0.04, 31)
    partner = ToolPathPartner(right, frames, tolerance=FREE, reference="right")
    # In the frame of the right arm the circle is where that of the left arm is in its own.
    path = steps.paths.find_tool_path(left, arc(0.06), SPEED, tolerance=FREE, partners=[partner])
    other = path.partners["right"]
    assert path.length == pytest.approx(0.06 * np.pi, rel=1e-5) and other.length == pytest.approx(
        0.04 * np.pi, rel=1e-5
    )
    assert other.velocity == pytest.approx(SPEED * 4.0 / 6.0, rel=1e-5)
    assert len(other.times) == len(frames) == len(other.positions) == len(other.freedoms)
    assert other.times[-1] == pytest.approx(path.times[-1], abs=1e-9) and path.times[-1] == pytest.approx(path.duration)
    with pytest.raises(virtualrobot.WrongStateError, match="not where the path starts"):
        path.start()
    steps.scene.set_joint_positions("left", path.start_joints)
    with pytest.raises(virtualrobot.WrongStateError, match="'right' is not where the path starts"):
        path.start()
    steps.scene.set_joint_positions("right", other.start_joints)
    motion, turned = path.start(wait=False), []
    for _ in range(int(path.duration / TICK / 4) + 2):
        steps.clock.step(4)
        here = []
        for arm, radius in ((left, 0.06), (right, 0.04)):
            place = (np.linalg.inv(steps.scene.pose(arm.name)) @ arm.tcp)[:3, 3] - CENTRE
            assert abs(np.hypot(*place[:2]) - radius) < 1e-5 and abs(place[2]) < 1e-5
            here.append(np.arctan2(place[1], place[0]))
        turned.append(here)
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED
    both = np.unwrap(turned, axis=0)
    assert np.abs(both[:, 0] - both[:, 1]).max() < 1e-4
    np.testing.assert_allclose(both[-1], np.pi, atol=1e-5)
    rates = np.diff(both, axis=0) / (4 * TICK)
    times = 4 * TICK * (np.arange(len(rates)) + 1.0)
    held = (times > path.held[0]) & (times + 4 * TICK < path.held[1])
    np.testing.assert_allclose(rates[held], SPEED / 0.06, rtol=5e-3)


@pytest.mark.long
def test_arms_that_would_touch_are_refused_with_the_place_and_the_pair(steps: Client) -> None:
    """Both tools would be at one place."""
    pumas(steps, 0.0)
    partner = ToolPathPartner("right", arc(0.06), reference="right", tolerance=FREE)
    with pytest.raises(virtualrobot.CollisionError, match="would touch") as caught:
        steps.paths.find_tool_path("left", arc(0.06), SPEED, tolerance=FREE, partners=[partner], time_limit=20)
    told = caught.value.metadata
    assert {told["first"].split(".")[0], told["second"].split(".")[0]} == {"left", "right"}
    assert 0.0 <= float(told["fraction"]) <= 1.0 and "frame" in told


def test_what_can_not_go_together_is_refused(client: Client) -> None:
    pumas(client)
    rail = client.load_robot("model://rail", name="rail", pose=virtualrobot.pose(x=5.0))
    client.load_robot("model://puma560", name="carried", parent="left.link6")

    def refused(
        *partners: ToolPathPartner,
        external: Sequence[str | virtualrobot.Robot] = (),
        reference: str = "world",
        slope: float | None = None,
    ) -> str:
        with pytest.raises((virtualrobot.InvalidArgumentError, virtualrobot.UnknownNameError)) as caught:
            client.paths.find_tool_path(
                "left", arc(0.06), SPEED, partners=partners, external=external, reference=reference, slope=slope
            )
        return str(caught.value)

    right = ToolPathPartner("right", arc(0.04), reference="right", tolerance=FREE)
    assert "'left' is to lead two tools at once" in refused(ToolPathPartner("left", arc(0.04)))
    assert "'right' is to lead two tools at once" in refused(right, right)
    told = refused(ToolPathPartner("right", arc(0.04), 0.05))
    assert "would end 33.3% apart from 'left'" in told and "has to go by 0.03333 m/s" in told
    assert "neither 'left' nor the path's frame" in refused(right, external=[rail])
    assert "to lead a tool and to carry" in refused(right, external=["right"], reference="right.link2")
    assert "frames[3]" in refused(ToolPathPartner("right", np.insert(arc(0.04), 3, np.nan, axis=0)))
    assert "2 to 1,001 frames" in refused(ToolPathPartner("right", arc(0.04)[:1]))
    assert "'left' carries" in refused(ToolPathPartner("carried", arc(0.04), reference="carried"))
    assert "at most 3 partners" in refused(right, right, right, right)
    assert "nobody" in refused(ToolPathPartner("nobody", arc(0.04)))
    assert "half a turn" in refused(slope=4.0)
    with pytest.raises(virtualrobot.InvalidArgumentError, match="can't be gone in parts"):
        client.paths.find_tool_path_parts("left", arc(0.06), SPEED, partners=[right])


@pytest.mark.long
def test_a_path_that_slopes_too_much_is_refused(client: Client) -> None:
    """Tools that point 30 degrees beside straight down, and nothing that would turn the path."""
    client.load_robot("model://puma560", name="left")
    tilt = np.radians(30.0)
    points = CENTRE + np.linspace([0.0, -0.05, 0.0], [0.0, 0.05, 0.0], 21)
    frames = virtualrobot.path_frames(points, (np.sin(tilt), 0.0, -np.cos(tilt)))
    with pytest.raises(virtualrobot.LimitError, match="30 degrees from straight down, and may be 20"):
        client.paths.find_tool_path("left", frames, SPEED, tolerance=FREE, slope=np.radians(20.0))
    assert client.paths.find_tool_path("left", frames, SPEED, tolerance=FREE, slope=np.radians(31.0)).duration > 2.0
