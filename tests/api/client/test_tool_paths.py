"""Tool paths with freedom through the client: what the tool does along them, tick by tick, and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client, Robot
from virtualrobot.motions.tool_paths import ToolPathProgress

Floats = NDArray[np.float64]

CENTRE, RADIUS, SPEED = np.array([0.45, -0.15, 0.75]), 0.06, 0.05
TICK = 0.004


def seam(count: int = 121, turn: float = np.pi) -> Floats:
    """Return frames on an arc about the vertical through CENTRE, tools pointing down."""
    angles = np.linspace(0.0, turn, count)
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)
    return virtualrobot.path_frames(CENTRE + RADIUS * around, (0.0, 0.0, -1.0))


def gone_along(client: Client, arm: Robot, path: virtualrobot.ToolPath, ticks: int = 1) -> Floats:
    """Go along a path; return the tool's pose (n, 4, 4) after each tick, or after each few."""
    client.scene.set_joint_positions(arm.name, path.start_joints)
    motion = path.start(wait=False)
    poses = []
    for _ in range(int(path.duration / TICK / ticks) + 2):
        client.clock.step(ticks)
        poses.append(arm.tcp)
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED
    return np.array(poses)


def off_arc(poses: Floats) -> Floats:
    """Return the radial and vertical distance (m) from the arc, and the tilt (rad) of the tool: (n, 3)."""
    aside = poses[:, :3, 3] - CENTRE
    tilt = np.arctan2(np.hypot(poses[:, 0, 2], poses[:, 1, 2]), -poses[:, 2, 2])
    return np.stack([np.abs(np.hypot(aside[:, 0], aside[:, 1]) - RADIUS), np.abs(aside[:, 2]), tilt], axis=1)


@pytest.mark.long
@pytest.mark.parametrize(("model", "height"), [("puma560", 0.0), ("ur5e", 0.5)])
def test_a_tool_keeps_its_path_and_its_speed(steps: Client, model: str, height: float) -> None:
    """The arc is a formula of its own: every 4 ticks within 0.01 mm and 0.01 degrees of it, the speed within 0.5%."""
    arm = steps.load_robot(f"model://{model}", name="arm", pose=virtualrobot.pose(z=height))
    told: list[ToolPathProgress] = []
    path = steps.paths.find_tool_path(arm, seam(), SPEED, tolerance={"rotation_z": "free"}, progress=told.append)
    assert path.length == pytest.approx(np.pi * RADIUS, rel=1e-5)
    assert told[-1].searches == path.searches >= 1 and told[-1].checks == path.checks > 0
    assert path.times[0] == 0.0 and path.times[-1] == pytest.approx(path.duration)
    assert path.freedoms[:, :5] == pytest.approx(0.0)
    poses = gone_along(steps, arm, path, 4)
    assert (off_arc(poses).max(axis=0) < (1e-5, 1e-5, np.radians(0.01))).all()
    way = np.arctan2(poses[:, 1, 3] - CENTRE[1], poses[:, 0, 3] - CENTRE[0])
    speeds = RADIUS * np.diff(np.unwrap(way)) / (4 * TICK)
    times = 4 * TICK * (np.arange(len(speeds)) + 1.0)
    held = (times > path.held[0]) & (times + 4 * TICK < path.held[1])
    np.testing.assert_allclose(speeds[held], SPEED, rtol=5e-3)
    assert held.sum() > 0.8 * len(speeds)
    np.testing.assert_allclose(np.unwrap(way)[-1], np.pi, atol=1e-6)


@pytest.mark.long
def test_tolerances_are_kept_and_used(steps: Client) -> None:
    """A frame that turns with the arc, three quarters of a turn, is followed by a tool that may be 0.3 rad off it."""
    arm = steps.load_robot("model://puma560", name="arm")
    tolerance = {"rotation_z": "free", "rotation_y": (-0.3, 0.1), "z": 0.002}
    path = steps.paths.find_tool_path(arm, seam(turn=1.5 * np.pi), SPEED, tolerance=tolerance)
    poses = gone_along(steps, arm, path, 4)
    off = off_arc(poses)
    assert off[:, 1].max() <= 0.002 + 1e-5 and off[:, 2].max() <= 0.3 + np.radians(0.01)
    assert path.freedoms[:, [0, 1, 3]] == pytest.approx(0.0)
    assert -0.3 - 1e-9 <= path.freedoms[:, 4].min() and path.freedoms[:, 4].max() <= 0.1 + 1e-9


@pytest.mark.long
def test_what_is_in_the_way_is_gone_round(steps: Client) -> None:
    """A post where the elbow would be without it: another branch is found, and nothing touches from tick to tick."""
    arm = steps.load_robot("model://puma560", name="arm")
    before = steps.paths.find_tool_path(arm, seam(), SPEED, tolerance={"rotation_z": "free"})
    steps.scene.add_object("post", virtualrobot.box(0.05, 0.05, 0.3), pose=virtualrobot.pose(x=0.2, y=-0.15, z=1.3))
    steps.scene.set_joint_positions("arm", dict(zip(before.joint_names, before.positions[60].tolist(), strict=True)))
    assert any("post" in (pair.first, pair.second) for pair in steps.collisions.check().pairs)
    path = steps.paths.find_tool_path(arm, seam(), SPEED, tolerance={"rotation_z": "free"})
    assert path.searches > 1
    steps.scene.set_joint_positions("arm", path.start_joints)
    checked = path.program.check()
    assert checked.first_violation is None
    motion = path.start(wait=False)
    for _ in range(int(path.duration / TICK / 20) + 2):
        steps.clock.step(20)
        assert not steps.collisions.check()
    assert motion.wait().phase is virtualrobot.Phase.SUCCEEDED


@pytest.mark.long
def test_pairs_may_touch_on_a_path_that_may_not_else(steps: Client) -> None:
    """A needle in a plate: refused, led along with the pair, and gone along where a program lets them touch."""
    arm = steps.load_robot("model://puma560", name="arm")
    needle = virtualrobot.cylinder(0.002, 0.06, pose=virtualrobot.pose(z=0.09))
    steps.scene.add_tool("needle", arm.flange, [needle], tool_center_points={"tip": virtualrobot.pose(z=0.12)})
    plate = virtualrobot.box(0.3, 0.3, 0.02)
    steps.scene.add_part("plate", plate, pose=virtualrobot.pose(*CENTRE))
    free = {"rotation_z": "free"}
    with pytest.raises(virtualrobot.CollisionError, match="plate"):
        steps.paths.find_tool_path(arm, seam(), SPEED, tolerance=free)
    path = steps.paths.find_tool_path(arm, seam(), SPEED, tolerance=free, may_touch=[("plate", "needle")])
    postures = path.positions[::20]
    names = path.joint_names
    assert not steps.collisions.check_configurations(arm, postures, joint_names=names).free.any()
    let = steps.collisions.check_configurations(arm, postures, joint_names=names, may_touch=[("needle", "plate")])
    assert let.free.all()
    pair = ("needle", "plate")
    there = steps.program().allow([(*pair, "it sews")]).move(arm.ptp(path.start_joints)).call(path.program, "seam")
    assert there.allow(forbid=[pair]).check().ok
    allowed = steps.collisions.allowed.list("needle")
    assert not [one for one in allowed if "plate" in (one.first, one.second)]
    for wrong, error, words in (
        (("needle", "plat"), virtualrobot.UnknownNameError, "plat"),
        (("needle", "needle"), virtualrobot.VirtualRobotError, "is one node"),
        (("", "plate"), virtualrobot.VirtualRobotError, r"may_touch\[0\].first names no node"),
    ):
        with pytest.raises(error, match=words):
            steps.paths.find_tool_path(arm, seam(), SPEED, tolerance=free, may_touch=[wrong])
        with pytest.raises(error, match=words):
            steps.collisions.check_configurations(arm, postures, joint_names=names, may_touch=[wrong])


@pytest.mark.long
def test_where_there_is_no_way_it_is_told_where_and_why(steps: Client) -> None:
    arm = steps.load_robot("model://puma560", name="arm")
    free = {"rotation_z": "free"}
    line = virtualrobot.path_frames(np.linspace([0.5, -0.15, 0.75], [1.5, -0.15, 0.75], 101), (0.0, 0.0, -1.0))
    with pytest.raises(virtualrobot.UnreachableError, match="no posture reaches there within the tolerances") as far:
        steps.paths.find_tool_path(arm, line, SPEED, tolerance=free)
    # The wrist's centre is 56 mm above the flange; from the shoulder, at 0.672 m, it is 0.15 m aside.
    assert far.value.metadata["robot"] == "arm" and 20 < int(far.value.metadata["frame"]) < 60
    place = float(far.value.metadata["millimeters"])
    assert abs(place - 10.0 * int(far.value.metadata["frame"])) <= 5.0 and f"({place:.1f} of 1000.0 mm" in str(
        far.value
    )
    with pytest.raises(
        virtualrobot.LimitError, match=r"joint 'joint\d' .* the tool's speed of 1 m/s|times as fast"
    ) as fast:
        steps.paths.find_tool_path(arm, seam(), 1.0, acceleration=50.0, tolerance=free)
    assert fast.value.metadata["joint"].startswith("joint") and float(fast.value.metadata["limit"]) > 0.0
    steps.scene.add_object("block", virtualrobot.box(0.1, 0.1, 0.4), pose=virtualrobot.pose(0.45, -0.09, 0.6))
    with pytest.raises(virtualrobot.CollisionError, match="'block'") as touching:
        steps.paths.find_tool_path(arm, seam(), SPEED, tolerance=free)
    assert {touching.value.metadata["first"], touching.value.metadata["second"]} >= {"block"}


@pytest.mark.long
def test_who_goes_away_ends_the_search(steps: Client) -> None:
    arm = steps.load_robot("model://puma560", name="arm")
    told: list[ToolPathProgress] = []

    def gone(progress: ToolPathProgress) -> None:
        told.append(progress)
        raise InterruptedError

    with pytest.raises(InterruptedError):
        steps.paths.find_tool_path(arm, seam(), SPEED, tolerance={"rotation_z": "free"}, progress=gone)
    assert len(told) == 1
    assert steps.paths.find_tool_path(arm, seam(5), SPEED, tolerance={"rotation_z": "free"}).searches >= 1


@pytest.mark.long
def test_a_path_is_gone_along_from_its_start_only(client: Client) -> None:
    arm = client.load_robot("model://puma560", name="arm")
    path = client.paths.find_tool_path(arm, seam(9), SPEED, tolerance={"rotation_z": "free"})
    with pytest.raises(virtualrobot.WrongStateError, match="'arm' is not where the path starts"):
        path.start(wait=False)


def arc(change: Callable[[Floats], object]) -> Floats:
    frames = seam()
    change(frames)
    return frames


BAD: dict[str, tuple[dict, str]] = {
    "empty": ({"frames": np.zeros((0, 4, 4))}, "a tool path has 2 to 1,001 frames, not 0"),
    "one": ({"frames": seam()[:1]}, "a tool path has 2 to 1,001 frames, not 1"),
    "doubled": ({"frames": seam()[[0, 1, 1, 2]]}, r"frames\[2\] of the tool path is where frames\[1\] is: 0 mm away"),
    "not finite": (
        {"frames": arc(lambda f: f.__setitem__((3, 0, 3), np.nan))},
        r"frames\[3\] of the tool path is not fin",
    ),
    "shape": ({"frames": np.zeros((4, 3))}, r"frames of a tool path have the shape \(n, 4, 4\), not \(4, 3\)"),
    "still": ({"velocity": 0.0}, "path.velocity_meters_per_second"),
    "millimetres": ({"velocity": 60.0}, "the speed of a tool centre point is at most .* millimetres"),
    "too short": ({"velocity": 2.0}, "the tool path of 188.5 mm is too short for 2 m/s"),
    "inverted": ({"tolerance": {"rotation_y": (0.2, -0.2)}}, "from 0.2 to -0.2 rad: its lower end must not be above"),
    "negative": ({"tolerance": {"x": -0.001}}, "the tolerance x is from 0.001 to -0.001 m: its lower end"),
    "far": ({"tolerance": {"x": 2.0}}, "a tool may be 0.1 m off at the most"),
    "no axis": ({"tolerance": {"yaw": 0.2}}, "there is no axis 'yaw' of a tolerance; there are x, y, z, rotation_x"),
    "free place": ({"tolerance": {"x": "free"}}, "the tolerance x of a distance can't be free"),
    "no word": ({"tolerance": {"rotation_z": "any"}}, "the tolerance rotation_z is 'any'; it must be a number"),
    "no node": ({"reference": "table"}, "table"),
}


def test_bad_input_is_told_by_what_would_be_right(client: Client) -> None:
    client.load_robot("model://puma560", name="arm")
    for changed, words in BAD.values():
        given = {"frames": seam(), "velocity": SPEED, "tolerance": {"rotation_z": "free"}} | changed
        with pytest.raises(virtualrobot.VirtualRobotError, match=words):
            client.paths.find_tool_path("arm", **given)


def test_an_arm_of_another_kind_is_told_what_it_lacks(client: Client) -> None:
    client.load_robot("model://palletizer", name="four")
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"'four' can't be led along a tool path .* 4 joints"):
        client.paths.find_tool_path("four", seam(), SPEED)


@pytest.mark.long
def test_a_rail_carries_an_arm_along_a_seam_that_is_longer_than_its_reach(steps: Client) -> None:
    """2.4 m along y, of which a UR5e reaches 1.7 m: every 20 ticks it is on the line and at its speed."""
    steps.load_robot("model://rail", name="rail")
    arm = steps.load_robot("model://ur5e", name="arm", parent="rail.carriage")
    begin = steps.scene.pose("rail.carriage")[:3, 3] + [0.45, 0.0, 0.3]
    points = begin + np.linspace(0.0, 2.4, 200)[:, None] * [0.0, 1.0, 0.0]
    frames = virtualrobot.path_frames(points, (0.0, 0.0, -1.0))
    free = {"rotation_z": "free"}
    with pytest.raises(virtualrobot.VirtualRobotError, match="can't lead its tool along the path"):
        steps.paths.find_tool_path(arm, frames, 0.1, tolerance=free)
    path = steps.paths.find_tool_path(arm, frames, 0.1, tolerance=free, external=["rail"])
    slide = path.external["rail"]
    assert slide.joint_names == ("slide",) and np.ptp(slide.positions) > 0.7
    with pytest.raises(virtualrobot.WrongStateError, match=r"'rail' is not where the path starts|'arm' is not where"):
        path.start()
    steps.scene.set_joint_positions("rail", slide.start_joints)
    poses = gone_along(steps, arm, path, 20)
    np.testing.assert_allclose(poses[:, [0, 2], 3], np.tile(begin[[0, 2]], (len(poses), 1)), atol=1e-5)
    speeds = np.diff(poses[:, 1, 3]) / (20 * TICK)
    times = 20 * TICK * (np.arange(len(speeds)) + 1.0)
    held = (times > path.held[0]) & (times + 20 * TICK < path.held[1])
    np.testing.assert_allclose(speeds[held], 0.1, rtol=5e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("external", "words"),
    [
        (["arm"], "'arm' leads the tool itself"),
        (["rail", "rail"], "'rail' stands among the external robots twice"),
        (["rail"], "'rail' carries neither 'arm' nor the path's frame"),
        (["none"], "none"),
    ],
)
def test_external_robots_that_carry_nothing_are_refused(steps: Client, external: list[str], words: str) -> None:
    arm = steps.load_robot("model://puma560", name="arm")
    if words.endswith("twice"):
        steps.load_robot("model://rail", name="rail")
        steps.scene.add_frame("on it", parent="rail.carriage")
        reference = "on it"
    else:
        steps.load_robot("model://rail", name="rail", pose=virtualrobot.pose(y=3.0))
        reference = "world"
    with pytest.raises(virtualrobot.VirtualRobotError, match=words):
        steps.paths.find_tool_path(arm, seam(), SPEED, reference=reference, external=external)
