"""Free paths through the client."""

from __future__ import annotations

import re

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.motions.paths import PathProgress

from tests.api.client.conftest import Run
from tests.unit.paths.cells import LEFT, RIGHT


@pytest.fixture
def cell(client: Client, iiwa: Robot) -> Client:
    """Return a client of a world with an arm left of a wall."""
    client.scene.add_object("wall", virtualrobot.box(0.6, 0.05, 0.8), pose=virtualrobot.pose(x=0.8, z=0.4))
    client.scene.set_joint_positions("iiwa", LEFT)
    return client


def test_a_clearance_is_kept_by_the_rounded_motion(cell: Client) -> None:
    def nearest(clearance: float) -> float:
        path = cell.paths.find("iiwa", RIGHT, time_limit=60.0, clearance=clearance)
        way = path.program.plan(sample_time=0.02).robots["iiwa"].positions
        at = [{"iiwa": dict(zip(path.joint_names, q.tolist(), strict=True))} for q in way]
        return min(cell.collisions.distance("iiwa", to=["wall"], configurations=one).distance for one in at)

    assert 0.06 - 1e-6 < nearest(0.06) < 0.2
    assert nearest(0.0) < 0.06


def test_a_path_has_waypoints_and_can_be_started(cell: Client, iiwa: Robot) -> None:
    told: list[PathProgress] = []
    path = cell.paths.find("iiwa", RIGHT, seed=1, time_limit=60.0, speed_factor=0.9, progress=told.append)
    assert not path.straight and path.planner == "RRTConnect" and path.checks > 0 and path.states > 0
    assert told and told[-1].checks == path.checks
    assert path.waypoints.shape == (len(path.program._spec.steps) + 1, 7)
    assert path.joint_names == tuple(iiwa.chain_joint_names)
    np.testing.assert_allclose(path.waypoints[0], iiwa.positions[:7])
    assert path.length == pytest.approx(np.linalg.norm(np.diff(path.waypoints, axis=0), axis=1).sum())
    assert path.program.plan().duration == pytest.approx(path.duration)
    cell.clock.set_stepped()
    motion = path.start(wait=False)
    cell.clock.step(int(path.duration / 0.004) + 2)
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED
    np.testing.assert_allclose(iiwa.positions[:7], path.waypoints[-1], atol=1e-9)


def test_a_path_is_gone_along_from_its_start_only(cell: Client, iiwa: Robot) -> None:
    """From elsewhere the first move would go straight to the first corner, and nobody has looked at that way."""
    path = cell.paths.find("iiwa", RIGHT, start={"lbr_iiwa_joint_7": 0.5}, time_limit=60.0)
    with pytest.raises(virtualrobot.WrongStateError, match=r"'lbr_iiwa_joint_7' is at 0 and not at 0\.5"):
        path.start(wait=False)
    assert not iiwa.state.motion_ids
    cell.scene.set_joint_positions("iiwa", {"lbr_iiwa_joint_7": 0.5})
    path.start(wait=False).cancel()


def test_zones_are_for_who_wants_them(cell: Client) -> None:
    path = cell.paths.find("iiwa", RIGHT, time_limit=60.0, zone_percent=0.0)
    assert not any(step.move.HasField("zone") for step in path.program._spec.steps)


def test_robots_may_stand_for_their_names(cell: Client, iiwa: Robot) -> None:
    path = cell.paths.find(iiwa, {**LEFT, "lbr_iiwa_joint_7": 0.5})
    assert path.straight
    assert not cell.collisions.check(robots=[iiwa])
    assert cell.collisions.check_configurations(iiwa, path.waypoints, robots=[iiwa]).free.all()
    assert cell.collisions.distance(iiwa).distance == cell.collisions.distance("iiwa").distance
    assert cell.stop(iiwa) == []
    with cell.lease(iiwa) as lease:
        assert lease.robots == ("iiwa",)


def test_refusals_are_exceptions(cell: Client) -> None:
    with pytest.raises(virtualrobot.CollisionError, match="touches 'wall'"):
        cell.paths.find("iiwa", {**LEFT, "lbr_iiwa_joint_1": 0.0})
    with pytest.raises(virtualrobot.UnknownNameError, match="RRTConnect"):
        cell.paths.find("iiwa", RIGHT, planner="PRM")


def test_what_progress_raises_ends_the_search(cell: Client) -> None:
    def stop(progress: PathProgress) -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        cell.paths.find("iiwa", RIGHT, planner="RRTstar", time_limit=600.0, progress=stop)
    assert cell.paths.find("iiwa", RIGHT, time_limit=60.0).length > 1.8


def test_the_command_finds_a_path_and_goes_along(cell: Client, iiwa: Robot, run: Run) -> None:
    words = [f"{name}={value}" for name, value in RIGHT.items()]
    found = run("path", "iiwa", *words, "--time-limit", "60")
    assert re.match(r"\d+ waypoints, .* rad instead of 1.800 straight: .* s of motion", found)
    np.testing.assert_allclose(iiwa.positions[0], LEFT["lbr_iiwa_joint_1"])
    said = run("path", "iiwa", *words, "--go", "--seed", "3", "--time-limit", "60")
    assert "reached its goal" in said
    np.testing.assert_allclose(iiwa.positions[0], RIGHT["lbr_iiwa_joint_1"])
    degrees = run("path", "iiwa", "lbr_iiwa_joint_7=20", "--degrees")
    assert degrees.startswith(f"the straight way is free: {np.radians(20):.3f} rad")
    assert "PRM" in run("path", "iiwa", "--joints", "0,0,0,0,0,0,0", "--planner", "PRM", code=1)
