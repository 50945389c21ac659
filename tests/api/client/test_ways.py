"""Planned ways of crafts by the client over TCP: the shortest words, checks and plans that see the base, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import CollisionError, InvalidArgumentError, WrongStateError
from virtualrobot.motions.plans import ViolationKind
from virtualrobot.motions.state import Phase

from tests.api.client.conftest import Run
from tests.api.client.test_crafts import place

LEAST = 0.325 / math.tan(0.6) + 0.1
"""Radius (m) of the narrowest circle of the racecar: its wheelbase, its steering limit, and half its track."""


@pytest.fixture
def yard(client: Client) -> Client:
    """Return a client whose time goes on by steps."""
    client.clock.set_stepped()
    return client


def test_a_car_goes_to_a_pose_by_the_shortest_word_and_ends_there(yard: Client) -> None:
    """Beside where it stands: a long way round forward, a short one forth and back."""
    car = yard.load_robot("model://racecar", base="planar")
    forward = car.way_to(0.0, 0.3, heading=0.0)
    assert forward.turning_radius == pytest.approx(LEAST, rel=1e-6)
    assert forward.length > 2.0 * math.pi * LEAST - 1.0
    way = car.way_to(0.0, 0.3, heading=0.0, reverse=True)
    assert way.length < forward.length / 2.0
    assert "-" in way.word
    assert "-" not in forward.word
    # Of Reeds and Shepp's words for a shift to the side by h: L+R-L+, with an arc whose half is asin(h / 4).
    np.testing.assert_allclose(np.abs(way.parts[:, 0]).sum(), way.length)
    motion = way.start(wait=False)
    yard.clock.step(10_000)
    assert motion.state.phase is Phase.SUCCEEDED
    np.testing.assert_allclose(place(yard, "racecar.base_link"), [0.0, 0.3, 0.0], atol=1e-5)


@pytest.mark.long
def test_a_check_sees_the_base_and_a_plan_shows_it_before_anything_moves(yard: Client) -> None:
    husky = yard.load_robot("model://husky", base="planar")
    way = husky.way([[1.5, 0.0, 0.6]])
    assert way.check().ok
    plan = way.plan(sample_time=0.1)
    trajectory = plan.robots["husky"]
    base = [trajectory.joint_names.index(f"base/{name}") for name in ("x", "y", "theta")]
    radius = 1.5 / 0.6
    ends = [radius * math.sin(0.6), radius * (1.0 - math.cos(0.6)), 0.6]
    np.testing.assert_allclose(trajectory.positions[-1, base], ends, atol=1e-9)
    speed = np.hypot(*trajectory.velocities[:, base[:2]].T)
    assert speed.max() > 0.2
    np.testing.assert_allclose(trajectory.velocities[:, base[2]], speed / radius, atol=1e-9)
    yard.scene.add_object("post", virtualrobot.box(0.1, 0.1, 1.0), pose=virtualrobot.pose(x=1.3, y=0.25, z=0.5))
    found = way.check().first_violation
    assert found is not None
    assert found.kind is ViolationKind.COLLISION
    assert "post" in found.message
    assert 0.0 < (found.time or 0.0) < plan.duration
    np.testing.assert_array_equal(place(yard, "husky.base_footprint"), np.zeros(3))
    # Guarded, it stops about there.
    yard.collisions.set(robots={"husky": "guard"})
    motion = way.start(wait=False)
    yard.clock.step(4000)
    assert motion.state.phase is Phase.ABORTED
    seen = np.interp(found.time or 0.0, plan.times, trajectory.positions[:, base[0]])
    assert place(yard, "husky.base_footprint")[0] == pytest.approx(seen, abs=0.05)
    assert not yard.collisions.check()


def test_an_impossible_goal_is_refused_with_the_reason(yard: Client) -> None:
    husky = yard.load_robot("model://husky", base="planar")
    yard.scene.add_object("wall", virtualrobot.box(0.2, 4.0, 1.0), pose=virtualrobot.pose(x=2.0, z=0.5))
    with pytest.raises(
        CollisionError, match=r"'husky' cannot stand at 2, 0 turned by 0\.0 degrees: .*'wall'"
    ) as caught:
        husky.way_to(2.0, 0.0, heading=0.0)
    assert {caught.value.metadata["first"], caught.value.metadata["second"]} >= {"wall"}
    with pytest.raises(InvalidArgumentError, match=r"goal\.x_meters must be a finite number, not nan"):
        husky.way_to(math.nan, 0.0)
    with pytest.raises(InvalidArgumentError, match=r"goal\.y_meters must be within 1e\+06 m"):
        husky.way_to(0.0, 1e7)
    with pytest.raises(InvalidArgumentError, match=r"goal\.turning_radius_meters must be 1e\+06 m at most, not 1e\+09"):
        husky.way_to(1.0, 13.0, turning_radius=1e9)
    car = yard.load_robot("model://racecar", base="planar", pose=virtualrobot.pose(y=5.0))
    with pytest.raises(InvalidArgumentError, match=r"'racecar' turns on circles of .* m or more, not of 0\.1 m"):
        car.way_to(1.0, 1.0, turning_radius=0.1)
    arm = yard.load_robot("model://puma560", pose=virtualrobot.pose(y=-3.0))
    with pytest.raises(WrongStateError, match="is no craft"):
        arm.way_to(1.0, 0.0)


@pytest.mark.long
def test_the_command_drives_to_a_place_and_tells_what_is_in_the_way(client: Client, run: Run) -> None:
    client.load_robot("model://husky", base="planar")
    said = run("drive", "husky", "--to", "0.2", "0", "--heading", "0")
    assert said.splitlines() == ["the way: 1 parts, 0.200 m", "husky rests at 0.200, 0.000 m, heading 0.000 rad"]
    client.scene.add_object("wall", virtualrobot.box(0.2, 4.0, 1.0), pose=virtualrobot.pose(x=1.2, z=0.5))
    said = run("drive", "husky", "--to", "2.5", "0", "--check")
    assert "wall" in said
    np.testing.assert_allclose(place(client, "husky.base_footprint"), [0.2, 0.0, 0.0], atol=1e-6)
