"""Following a line: what OpenCV makes of a picture, how the robot drives by it, and that it stops for a can."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.cli import cli
from virtualrobot_apps.vehicles.boebot import line_run
from virtualrobot_apps.vehicles.boebot.line_follower import (
    GAIN,
    LOST,
    QUICKEST,
    SPEED,
    STOP_DISTANCE,
    LineFollower,
    Sight,
    find_line,
)
from virtualrobot_apps.vehicles.boebot.track import PIECES, Track
from virtualrobot_apps.vehicles.boebot.worlds import line_world

from tests.kernels import KernelProcess

FOCAL = 320.0 / math.tan(0.5 * 1.3962634)


def sight(bearing: float) -> Sight:
    return Sight(0.5 * 639 + FOCAL * bearing, 100.0, 640, FOCAL)


def test_a_track_comes_back_to_where_it_began() -> None:
    track = Track.of()
    assert track.length == pytest.approx(sum(length for length, _ in PIECES))
    assert np.abs(track.places[-1]).max() < 1e-9
    assert track.headings[-1] == pytest.approx(2.0 * math.pi)
    assert np.linalg.norm(np.diff(track.places, axis=0), axis=1).max() < 0.0101
    # The first bend is a half circle of 0.4 m about (1.0, 0.4).
    bend = (track.ways > 1.0) & (track.ways < 1.0 + 0.4 * math.pi)
    np.testing.assert_allclose(np.linalg.norm(track.places[bend] - [1.0, 0.4], axis=1), 0.4, atol=1e-9)
    way, off = track.nearest(np.array([0.504, 0.03]), 0.0, 1.0)
    assert (way, off) == pytest.approx((0.504, 0.03))


def test_a_black_line_is_found_where_it_is(rng: np.random.Generator) -> None:
    picture = rng.integers(190, 230, (480, 640, 3)).astype(np.uint8)
    assert find_line(picture, FOCAL) is None
    picture[:, 400:440] = rng.integers(0, 40, (480, 40, 3))
    seen = find_line(picture, FOCAL)
    assert seen is not None
    assert seen.x == pytest.approx(419.5, abs=1.0)
    assert seen.bearing == pytest.approx(100.0 / FOCAL, abs=0.005)
    # A red, a blue and a grey stripe are none, and something small and black is not the line.
    picture[:, 100:140], picture[:, 200:240], picture[:, 500:540] = (170, 20, 20), (20, 20, 160), (110, 110, 110)
    picture[10:18, 10:18] = 0
    again = find_line(picture, FOCAL)
    assert again is not None
    assert again.x == pytest.approx(419.5, abs=1.0)


def test_how_it_drives_by_what_it_sees() -> None:
    follower = LineFollower()
    assert follower.twist(sight(0.1), math.inf) == pytest.approx((SPEED, -GAIN * 0.1))
    assert follower.twist(sight(-2.0), math.inf) == (SPEED, QUICKEST)
    assert follower.twist(sight(0.1), STOP_DISTANCE - 0.01) == (0.0, 0.0)
    # Without a line it turns to where that was, and stands in the end.
    follower.twist(sight(-0.1), 1.0)
    assert follower.twist(None, math.inf) == (0.0, 0.5 * QUICKEST)
    for _ in range(LOST):
        twist = follower.twist(None, math.inf)
    assert follower.is_lost
    assert twist == (0.0, 0.0)


@pytest.mark.long
def test_it_follows_a_bend_and_stands_before_a_can(steps: virtualrobot.Client, tmp_path: Path) -> None:
    """It begins 0.1 m before the first bend; the can is 0.35 m into it, its face 33 mm nearer."""
    track = Track.of()
    file = tmp_path / "line.yaml"
    file.write_text(line_world(track, can_way=1.35, start_way=0.9), "utf-8")
    steps.scene.load_scene(file)
    record = line_run.follow(steps, track, longest=5.0)
    assert record.end == "time"
    assert np.abs(record.off).max() < 0.02
    assert "can" in steps.scene
    # It stands where the laser, 11 mm before the axle, is as near to the can as it may be, or a little nearer.
    ahead = np.linalg.norm(record.poses[-1, :2] - np.array(track.pose(1.35)[:2])) - 0.033 - 0.0114
    assert 0.05 < ahead < STOP_DISTANCE + 0.02
    assert record.poses[-1] == pytest.approx(record.poses[-3], abs=1e-9)
    assert record.stood[-1] - record.stood[0] > 0.5


@pytest.mark.long
def test_a_floor_without_a_line_is_told(steps: virtualrobot.Client, tmp_path: Path) -> None:
    track = Track.of()
    file = tmp_path / "line.yaml"
    file.write_text(line_world(track), "utf-8")
    steps.scene.load_scene(file)
    steps.scene.remove("line")
    record = line_run.follow(steps, track)
    assert record.end == "lost"
    assert len(record.times) == LOST


def test_the_bundled_scene_is_what_its_track_makes() -> None:
    assert line_run.WORLD.read_text("utf-8") == line_world(Track.of(), can_way=2.7)


@pytest.mark.long
def test_the_demo_goes_round_and_tells_its_numbers(stepped_kernel: KernelProcess, tmp_path: Path) -> None:
    plot = tmp_path / "boebot.svg"
    arguments = ["demo", "boebot", "--address", stepped_kernel.address, "--headless", "--plot", str(plot)]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert "done in 5" in result.output
    assert "before the can" in result.output
    assert "counts a turn, as told" in result.output
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")
