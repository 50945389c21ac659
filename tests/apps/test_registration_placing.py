"""Files of touched points, and what is made of them and of markers, without a kernel."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot.errors import InvalidArgumentError, MalformedFileError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.registration.command import marker, register
from virtualrobot_apps.registration.marker_pose import SeenMarker, posed
from virtualrobot_apps.registration.placing import mean_corners, named, registered, settled
from virtualrobot_apps.registration.touched_file import TouchedFile, touched_of

POINTS = """schema_version: 1
relative_to: arm
up: y
noise: 0.003
tilt: 0.002
points:
- {model: [0.2, 0, 0.1], touched: [1, 2, 3]}
- {model: fixture, touched: [0, 2.5, 3]}
- {model: [0.2, 0.9, 0.1], touched: [-1, 2, 3]}
"""


def read(text: str) -> TouchedFile:
    return touched_of(parse(text, "touched.yaml"))


def seen(corners: object, number: int = 3) -> SeenMarker:
    camera = np.array([[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]])
    return posed(np.asarray(corners, dtype=float), number, camera)


def test_a_file_says_points_and_nodes() -> None:
    file = read(POINTS)
    assert (file.relative_to, file.up, file.noise, file.tilt) == ("arm", "y", 0.003, 0.002)
    assert file.model == ((0.2, 0.0, 0.1), "fixture", (0.2, 0.9, 0.1))
    assert file.touched[1] == (0.0, 2.5, 3.0)
    assert named(file) == ["arm", "fixture"]
    short = read("schema_version: 1\npoints: []\n")
    assert (short.relative_to, short.up, short.noise, short.tilt) == ("world", "z", 0.002, 0.0)


def test_points_are_where_the_model_has_them_on_a_robot_that_hangs_on_a_wall() -> None:
    """Gravity is the world's, and not that of the tilted frame in which the points are given."""
    poses = {"arm": virtualrobot.pose(0.3, 0.1, 1.5, pitch=np.pi / 2), "fixture": virtualrobot.pose(1.0, 0.4, 0.2)}
    device = virtualrobot.pose(2.0, 1.0, 0.3, yaw=0.8)
    model = ((0.1, 0.0, 0.0), (0.4, 0.7, 0.2), "fixture")
    placed = [poses["arm"][:3, :3] @ one + poses["arm"][:3, 3] for one in model[:2]] + [poses["fixture"][:3, 3]]
    inverse = np.linalg.inv(device)
    touched = tuple(tuple((inverse @ [*one, 1.0])[:3].tolist()) for one in placed)
    found = registered(TouchedFile("arm", "z", 0.002, 0.0, model, touched), poses)
    assert np.abs(found.model_t_device - device).max() < 1e-9


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("up: y", "up: x", "touched.yaml:3: up: 'x' is not known"),
        ("noise: 0.003", "noise: 3", "touched.yaml:4: noise: a number from 1e-06 to 0.1 belongs here, not 3"),
        ("[1, 2, 3]", "[1, 2]", r"touched.yaml:7: points\[0\].touched: three numbers \(m\) belong here, not 2"),
        ("[1, 2, 3]", "[1, 2, .nan]", "a finite number belongs here"),
        ("touched: [0", "measured: [0", "there is no field 'measured'"),
        (", touched: [-1, 2, 3]", "", "the field 'touched' is missing"),
        ("relative_to", "relativ_to", "did you mean 'relative_to'"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_with_its_line(old: str, new: str, said: str) -> None:
    with pytest.raises(MalformedFileError, match=said):
        read(POINTS.replace(old, new))


def test_pictures_from_one_place_are_averaged() -> None:
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    number, mean = mean_corners({"a.png": [seen(square)], "b.png": [seen(square + 1.0), seen(square, 9)]}, 3)
    assert number == 3
    assert np.array_equal(mean, square + 0.5)
    with pytest.raises(
        InvalidArgumentError, match=r"the camera has moved: in b.png a corner of the marker is 7.0 pixels"
    ):
        mean_corners({"a.png": [seen(square)], "b.png": [seen(square - np.array([7.0, 0.0]))]}, None)
    with pytest.raises(InvalidArgumentError, match=r"a.png doesn't show marker 4 once: it shows 3"):
        mean_corners({"a.png": [seen(square)]}, 4)
    with pytest.raises(InvalidArgumentError, match="it shows 3, 5; say which one is meant"):
        mean_corners({"a.png": [seen(square), seen(square, 5)]}, None)
    with pytest.raises(InvalidArgumentError, match=r"a.png doesn't show a marker once: it shows none"):
        mean_corners({"a.png": []}, None)
    with pytest.raises(InvalidArgumentError, match="no picture was given"):
        mean_corners({}, None)


def test_what_is_up_settles_a_marker_or_is_refused() -> None:
    sheet = virtualrobot.pose(1.0, 0.5, 0.8, roll=np.pi / 2)
    square = np.array([[-0.075, 0.075], [0.075, 0.075], [0.075, -0.075], [-0.075, -0.075]])
    camera = np.array([[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]])
    near, far = (
        posed([640.0, 360.0] + 900.0 * square @ np.diag([1.0, -1.0]) / distance + lean, 3, camera)
        for distance, lean in ((0.5, np.array([[0, 0], [0, 8], [0, -8], [0, 0.0]])), (2.5, 0.0))
    )
    assert settled(near, sheet, None) is near
    rivals = dataclasses.replace(far, second=far.camera_t_marker @ virtualrobot.pose(roll=0.5))
    with pytest.raises(InvalidArgumentError, match=r"two ways, 29 degrees apart.*tell what is up for the camera"):
        settled(rivals, sheet, None)
    # The sheet hangs upright, and so does the camera: its y is down.
    assert np.allclose(settled(rivals, sheet, [0.0, -9.8, 0.0]).camera_t_marker, far.camera_t_marker, atol=1e-6)
    with pytest.raises(InvalidArgumentError, match="90 degrees off what it is by the marker: look whether the sheet"):
        settled(far, sheet, [1.0, 0.0, 0.0])
    with pytest.raises(InvalidArgumentError, match="is a direction, such as 0, -1, 0, and no zero"):
        settled(far, sheet, [0.0, 0.0, 0.0])


def test_wrong_usage_is_told_before_a_kernel_is_asked(tmp_path: Path) -> None:
    file = tmp_path / "touched.yaml"
    file.write_text(POINTS)
    sheet_file = tmp_path / "sheet.png"
    written = CliRunner().invoke(marker, [str(sheet_file), "--number", "8", "--paper", "letter"])
    assert written.exit_code == 0
    assert "marker 8, edge 150 mm" in written.output
    for command, words, said in (
        (marker, [str(tmp_path / "sheet.gif")], "doesn't end with .pdf, .png, .svg"),
        (marker, [str(tmp_path / "none" / "sheet.pdf")], "cannot be written: No such file or directory"),
        (marker, [str(sheet_file), "--number", "50"], "50 is not in the range 0<=x<=49"),
        (register, ["touched", str(file), "--frame", "f", "--robot", "arm"], "give one of them"),
        (register, ["picture", str(sheet_file), "--marker", "m"], "--field or its --matrix is needed, one of them"),
        (register, ["picture", str(file), "--marker", "m", "--field", "60"], "is no PNG and no JPEG"),
        (register, ["picture", str(sheet_file), "--marker", "m", "--field", "60", "--number", "2"], "it shows 8"),
    ):
        refused = CliRunner().invoke(command, words)
        assert refused.exit_code != 0
        assert said in refused.output + str(refused.exception)
    other = tmp_path / "other.png"
    assert CliRunner().invoke(marker, [str(other), "--paper", "a4"]).exit_code == 0
    refused = CliRunner().invoke(register, ["picture", str(sheet_file), str(other), "--marker", "m", "--field", "60"])
    assert "the pictures are of one camera, 2550 x 3300 pixels as the first" in str(refused.exception)
