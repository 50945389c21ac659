"""Probes: points that are touched, and how a part stands by them, against displacements that it was given."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
import virtualrobot
from scipy.spatial.transform import Rotation
from virtualrobot import Client
from virtualrobot.errors import MalformedFileError, UnreachableError
from virtualrobot_apps.cell_io.yaml_file import read_file
from virtualrobot_apps.demos.processes import CELLS, run
from virtualrobot_apps.processes.measure import fitted, read_measure, report
from virtualrobot_apps.processes.process import plan_file

from tests.tiers import Draws

WORDS = """schema_version: 1
process: measure
robot: arm
points:
- {part: model, spots: {points: [[0, 0, 0]], normal: [0, 0, 1]}}
probe: {heading: [1, 0, 0]}
node: part
radius: 0.002
speed: 0.02
"""


def test_displacements_of_a_body_are_found(draws: Draws, rng: np.random.Generator) -> None:
    """Points of an ellipsoid that was shifted by up to 1 mm and turned by up to 0.1 degrees: to the square of these."""
    axes = np.array([0.3, 0.2, 0.1])
    for _ in range(draws(20)):
        points = rng.normal(size=(30, 3))
        points *= (1.0 / np.linalg.norm(points / axes, axis=1))[:, None]
        normals = points / axes**2
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        shift, turn = rng.uniform(-1e-3, 1e-3, 3), np.radians(rng.uniform(-0.1, 0.1, 3))
        matrix = Rotation.from_rotvec(turn).as_matrix()
        # Where lines along the normals meet the displaced ellipsoid: (p + b n - t) is R times one of its points.
        a = (normals @ matrix) / axes
        b = ((points - shift) @ matrix) / axes
        square, mixed, rest = (a**2).sum(axis=1), (a * b).sum(axis=1), (b**2).sum(axis=1) - 1.0
        beyond = (-mixed + np.sqrt(mixed**2 - square * rest)) / square
        found_shift, found_turn, told = fitted(points, normals, beyond)
        assert told == 6
        np.testing.assert_allclose(found_shift, shift, atol=3e-5)
        np.testing.assert_allclose(found_turn, turn, atol=1.5e-4)


def test_what_points_do_not_tell_is_left_at_nothing() -> None:
    """A plane tells its height and two turns: three of six."""
    points = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]])
    beyond = 1e-3 + 0.01 * points[:, 0]
    shift, turn, told = fitted(points, np.tile([0.0, 0, 1], (4, 1)), beyond)
    assert told == 3
    np.testing.assert_allclose(shift, [0, 0, 1e-3], atol=1e-12)
    np.testing.assert_allclose(turn, [0, -0.01, 0], atol=1e-12)
    lines = report(points, np.tile([0.0, 0, 1], (4, 1)), beyond, "plate")
    assert lines[0] == "4 points of plate are 1.000 to 2.000 mm beyond the model, 1.500 mm in the mean"
    assert "leaves 0.000 mm" in lines[1] and lines[1].endswith("the points tell 3 of 6 of these")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("{heading: [1, 0, 0]}", "{standoff: 0.1}", "a probe goes along itself: give the direction of its x"),
        ("normal: [0, 0, 1]}", "normal: [0, 0, 1], depth: 0.01}", "a probe stops where it touches: leave `depth` out"),
        ("spots: {points: [[0, 0, 0]], normal: [0, 0, 1]}", "edge: convex", "points to measure are spots"),
        ("radius: 0.002\n", "", "radius"),
        ("radius: 0.002", "radius: -1", "radius"),
    ],
)
def test_what_a_file_says_wrong_is_told_with_its_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    file = tmp_path / "work.yaml"
    file.write_text(WORDS.replace(old, new))
    with pytest.raises(MalformedFileError, match=rf"work\.yaml:\d+: .*{words}"):
        read_measure(read_file(file))


@pytest.mark.long
def test_a_hood_that_stands_off_its_model_is_found(steps: Client) -> None:
    """It is shifted by [2, -1.5, 1] mm and turned by [0.2, -0.3, 0.5] degrees; its triangles are within 0.06 mm of it.

    Where the probe gives its signal the ball's middle is its radius off the nearest triangle.
    """
    touched = []

    def look() -> None:
        if steps.signals["touch"]:
            touched.append((np.linalg.inv(steps.scene.pose("hood")) @ steps.robot("arm").state.world_t_tcp)[:3, 3])

    told = run.main(steps, CELLS / "probing.yaml", CELLS / "measure.yaml", each=look)
    found = np.array(re.findall(r"-?\d+\.\d+", told[-1].split(" degrees")[0]), float)
    np.testing.assert_allclose(found[:3], [2.0, -1.5, 1.0], atol=0.1)
    np.testing.assert_allclose(found[3:], [0.2, -0.3, 0.5], atol=0.02)
    places = np.array(touched)
    places = places[np.concatenate([[True], np.linalg.norm(np.diff(places, axis=0), axis=1) > 1e-3])]
    hood = trimesh.load_mesh(CELLS / "hood.stl")
    distances = trimesh.proximity.closest_point_naive(hood, places)[1]
    # A ball that comes along the model's normal touches a little aside of where its middle goes.
    assert len(places) == 10 and np.abs(distances - 0.002).max() < 5e-5


@pytest.mark.long
def test_what_is_not_there_or_in_the_way_is_told(steps: Client, tmp_path: Path) -> None:
    steps.load_robot("model://puma560", name="arm")
    steps.scene.add_frame("model", pose=virtualrobot.pose(0.5, 0.0, 0.5))
    steps.scene.add_part("part", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(0.5, 0.0, 0.4))
    file = tmp_path / "work.yaml"
    file.write_text(WORDS)
    with pytest.raises(UnreachableError, match=r"nothing of 'part' is between 10 mm before the point and 10 mm behind"):
        plan_file(steps, file)
    steps.scene.add_part("lid", virtualrobot.box(0.1, 0.1, 0.01), pose=virtualrobot.pose(0.5, 0.0, 0.495))
    with pytest.raises(UnreachableError, match="the probe would touch 'lid' there, before 'part'"):
        plan_file(steps, file)
