"""Walls without a kernel: frusta against their definition, edges that walls share, settings files, heads by UDP."""

from __future__ import annotations

import json
import math
import signal
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from click.testing import CliRunner
from numpy.typing import NDArray
from virtualrobot.errors import InvalidArgumentError, MalformedFileError, WrongStateError
from virtualrobot_apps.cell_io.yaml_file import parse
from virtualrobot_apps.walls.command import walls
from virtualrobot_apps.walls.display import STEREO, Display, flown, gaps, views
from virtualrobot_apps.walls.display_file import display_of
from virtualrobot_apps.walls.frustum import Frustum, Wall, frustum
from virtualrobot_apps.walls.head import SILENT, Listener, Observer, told

from tests.waiting import until

Floats = NDArray[np.float64]

CAVE = """schema_version: 1
display:
  near: 0.1
  far: 50
  walls:
  - {name: front, lower_left: [1.5, 1.5, 0], lower_right: [1.5, -1.5, 0], upper_left: [1.5, 1.5, 2.5],
     pixels: [1920, 1600], stereo: side_by_side}
  - {name: right, lower_left: [1.5, -1.5, 0], lower_right: [-1.5, -1.5, 0], upper_left: [1.5, -1.5, 2.5],
     pixels: [1920, 1600], stereo: side_by_side}
  - {name: floor, lower_left: [-1.5, 1.5, 0], lower_right: [-1.5, -1.5, 0], upper_left: [1.5, 1.5, 0],
     pixels: [1600, 1600], stereo: top_bottom}
observer: {pose: [10, 0, 0, 0, 0, 1.5707963267948966], height: 1.6, speed: 2, eyes: 0.06}
tracker: {pose: [0, 0, 0.5, 0, 0, 0], up: y, body_t_head: [0, 0, -0.1, 0, 0, 0]}
"""


def display(text: str = CAVE) -> Display:
    return display_of(parse(text, "cave.yaml"))


def drawn_wall(rng: np.random.Generator) -> Wall:
    """Return a wall of any size and place."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[:, 2] = np.cross(turn[:, 0], turn[:, 1])
    corner, (width, height) = rng.normal(size=3), rng.uniform(0.5, 4.0, 2)
    return Wall("any", corner, corner + width * turn[:, 0], corner + height * turn[:, 1])


def kooima(wall: Wall, eye: Floats, near: float, far: float) -> Floats:
    """Return the matrix of Kooima's paper, line by line as its code has it: P M^T T."""
    pa, pb, pc = wall.lower_left, wall.lower_right, wall.upper_left
    vr, vu = (pb - pa) / np.linalg.norm(pb - pa), (pc - pa) / np.linalg.norm(pc - pa)
    vn = np.cross(vr, vu)
    vn /= np.linalg.norm(vn)
    va, vb, vc = pa - eye, pb - eye, pc - eye
    d = -(vn @ va)
    left, right, bottom, top = (vr @ va) * near / d, (vr @ vb) * near / d, (vu @ va) * near / d, (vu @ vc) * near / d
    p = np.zeros((4, 4))
    p[0, 0], p[0, 2] = 2 * near / (right - left), (right + left) / (right - left)
    p[1, 1], p[1, 2] = 2 * near / (top - bottom), (top + bottom) / (top - bottom)
    p[2, 2], p[2, 3], p[3, 2] = -(far + near) / (far - near), -2 * far * near / (far - near), -1
    m, t = np.eye(4), np.eye(4)
    m[:3, :3], t[:3, 3] = np.stack([vr, vu, vn]), -eye
    return p @ m @ t


def clip(seen: Frustum, points: Floats) -> Floats:
    """Return points (n, 3) of the room as clip coordinates (n, 3) after the division."""
    at = np.concatenate([points, np.ones((len(points), 1))], axis=1) @ (seen.projection @ seen.view).T
    return at[:, :3] / at[:, 3:]


def pixels(seen: Frustum, points: Floats, width: int, height: int) -> Floats:
    """Return points (n, 3) of the room as pixels (n, 2) of the camera that takes the same picture."""
    inverse = np.linalg.inv(seen.room_t_camera)
    at = (points @ inverse[:3, :3].T + inverse[:3, 3]) @ seen.camera_matrix(width, height).T
    return at[:, :2] / at[:, 2:]


def test_matrices_are_those_of_the_formula() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        wall = drawn_wall(rng)
        eye = wall.lower_left + wall.axes @ [*rng.uniform(-3.0, 3.0, 2), rng.uniform(0.2, 5.0)]
        seen = frustum(wall, eye, 0.1, 80.0)
        assert np.abs(seen.projection @ seen.view - kooima(wall, eye, 0.1, 80.0)).max() < 1e-9


def test_a_wall_is_a_window() -> None:
    """A point is drawn where the line from the eye to it meets the wall; near and far are the ends of the depth."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        wall = drawn_wall(rng)
        across, upwards = wall.lower_right - wall.lower_left, wall.upper_left - wall.lower_left
        eye = wall.lower_left + wall.axes @ [*rng.uniform(-3.0, 3.0, 2), rng.uniform(0.2, 5.0)]
        seen = frustum(wall, eye, 0.1, 80.0)
        share = rng.uniform(-0.2, 1.2, (20, 2))
        on = wall.lower_left + share @ np.stack([across, upwards])
        behind = eye + (on - eye) * rng.uniform(0.5, 4.0, (20, 1))
        assert np.abs(clip(seen, behind)[:, :2] - (2.0 * share - 1.0)).max() < 1e-9
        drawn = pixels(seen, behind, 1920, 1200)
        assert np.abs(drawn - (np.stack([share[:, 0], 1.0 - share[:, 1]], axis=1) * [1920, 1200] - 0.5)).max() < 1e-8
        ahead = -wall.axes[:, 2]
        assert clip(seen, np.stack([eye + 0.1 * ahead, eye + 80.0 * ahead]))[:, 2] == pytest.approx([-1.0, 1.0])


def test_an_eye_before_the_middle_sees_the_frustum_of_gluPerspective() -> None:
    wall = Wall("w", np.array([-2.0, -1.0, 0.0]), np.array([2.0, -1.0, 0.0]), np.array([-2.0, 1.0, 0.0]))
    seen = frustum(wall, [0.0, 0.0, 3.0], 0.5, 20.0)
    cotangent = 3.0 / 1.0
    assert seen.projection[:2, :3] == pytest.approx(np.array([[cotangent / 2.0, 0.0, 0.0], [0.0, cotangent, 0.0]]))


def test_walls_share_their_edge_to_a_pixel_for_both_eyes() -> None:
    """Points that are seen through the edge of two walls are at the same height on both, and at the end of each."""
    cave = display()
    edge = np.stack([np.full(60, 1.5), np.full(60, -1.5), np.linspace(0.05, 2.4, 60)], axis=1)
    for head in (cave.standing, virtualrobot.pose(0.7, -0.9, 1.2, 0.2, -0.3, 0.8)):
        seen = {(one.wall, one.eye): one for one in views(cave, head)}
        assert len(seen) == 6
        for eye in ("left", "right"):
            front, right = seen["front", eye], seen["right", eye]
            place = np.linalg.inv(front.frustum.view)[:3, 3]
            far = place + (edge - place) * 3.0
            on_front, on_right = (pixels(one.frustum, far, one.viewport[2], one.viewport[3]) for one in (front, right))
            assert np.abs(on_front[:, 1] - on_right[:, 1]).max() < 1e-6
            assert np.abs(on_front[:, 0] - 959.5).max() < 1e-6
            assert np.abs(on_right[:, 0] + 0.5).max() < 1e-6


def test_walls_that_almost_meet_are_told() -> None:
    assert gaps(display()) == []
    loose = display(
        CAVE.replace(
            "lower_left: [1.5, -1.5, 0], lower_right: [-1.5", "lower_left: [1.5, -1.512, 0], lower_right: [-1.5"
        )
    )
    told = gaps(loose)
    assert len(told) == 2
    assert told[0].startswith("the walls 'front' and 'right' have corners that are 12.0 mm apart: measure them again")


def test_stereo_gives_each_eye_its_part_and_its_place() -> None:
    cave = display()
    found = {(one.wall, one.eye): one for one in views(cave, cave.standing)}
    assert found["front", "left"].viewport == (0, 0, 960, 1600)
    assert found["front", "right"].viewport == (960, 0, 960, 1600)
    assert found["floor", "right"].viewport == (0, 800, 1600, 800)
    places = {key: np.linalg.inv(one.frustum.view)[:3, 3] for key, one in found.items()}
    assert places["front", "left"] == pytest.approx([0.0, 0.03, 1.6])
    assert places["floor", "right"] == pytest.approx([0.0, -0.03, 1.6])
    for kind, eyes in STEREO.items():
        other = display(CAVE.replace("top_bottom", kind))
        assert [one.eye for one in views(other, other.standing)][4:] == [eye for eye, _ in eyes]


@pytest.mark.parametrize(
    ("eye", "near", "far", "said"),
    [
        ([0.0, 0.0, -0.5], 0.1, 10.0, "the eye is 0.500 m behind the wall 'w'"),
        ([0.0, 0.0, 0.0], 0.1, 10.0, "the eye is 0.000 m behind"),
        ([0.0, 0.0, math.nan], 0.1, 10.0, "three finite numbers"),
        ([0.0, 0.0, 1.0], 1.0, 1.0, "near is 1 m and far 1 m"),
        ([0.0, 0.0, 1.0], 0.0, 1.0, "near is above 0"),
    ],
)
def test_what_has_no_frustum_is_refused(eye: list[float], near: float, far: float, said: str) -> None:
    wall = Wall("w", np.array([-1.0, -1.0, 0.0]), np.array([1.0, -1.0, 0.0]), np.array([-1.0, 1.0, 0.0]))
    with pytest.raises(InvalidArgumentError, match=said):
        frustum(wall, eye, near, far)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("far: 50", "far: 0.05", "cave.yaml:4: display.far: near is 0.1 m and far 0.05 m"),
        ("upper_left: [1.5, 1.5, 2.5]", "upper_left: [1.5, 1.4, 2.5]", "no rectangle: .* angle of 87.71 degrees"),
        ("upper_left: [1.5, 1.5, 2.5]", "upper_left: [1.5, 1.5, 0]", "'front' has no width or no height"),
        ("[1920, 1600]", "[1920]", "width and height belong here, not 1"),
        ("[1920, 1600]", "[1920, 0]", "a whole number from 2 to 16384"),
        ("stereo: side_by_side", "stereo: sidebyside", "did you mean 'side_by_side'"),
        ("name: right", "name: front", "'front' is that of several walls"),
        ("eyes: 0.06", "eyes: 60", "a number from 0 to 0.2 belongs here, not 60"),
        ("up: y", "up: x", "'x' is not known"),
        ("pose: [0, 0, 0.5, 0, 0, 0]", "pose: [0, 0, 0.5]", "6 numbers belong here, not 3"),
        ("pose: [0, 0, 0.5, 0, 0, 0]", "pose: [0, 0, 0.5, 0, 0, 90]", "14.3 turns: degrees"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_with_its_line(old: str, new: str, said: str) -> None:
    with pytest.raises(MalformedFileError, match=said):
        display(CAVE.replace(old, new))


def test_a_file_of_walls_alone_has_the_usual_observer() -> None:
    short = display(
        "schema_version: 1\ndisplay: {walls: [{name: w, lower_left: [0, 1, 0], lower_right: [0, -1, 0],"
        " upper_left: [0, 1, 2], pixels: [800, 600]}]}\n"
    )
    assert (short.near, short.far, short.height, short.speed, short.eyes) == (0.05, 100.0, 1.7, 1.0, 0.064)
    with pytest.raises(MalformedFileError, match="a wall at least"):
        display("schema_version: 1\ndisplay: {walls: []}\n")


def test_a_head_is_where_the_tracker_says() -> None:
    """The tracker has y up, stands half a metre over the floor, and its body is 0.1 m over the eyes."""
    observer = Observer(display())
    assert not observer.tracked(0.0)
    assert observer.hear(b"head 1 0.2 1.3 -0.4 0 0 0 1\n", 10.0)
    # x stays, y up is z, and z to the viewer is -y; then down by 0.1 m along the body's own z, which is the room's -y.
    assert observer.room_t_head[:3, 3] == pytest.approx([0.2, 0.4 + 0.1, 1.3 + 0.5])
    assert (observer.world_t_room @ observer.room_t_head)[:3, 3] == pytest.approx([10.0 - 0.5, 0.2, 1.8])
    assert observer.tracked(10.0 + SILENT) and not observer.tracked(10.01 + SILENT)


def test_a_datagram_that_was_overtaken_counts_no_more() -> None:
    observer = Observer(display())
    assert observer.hear(b"head 5 0 1 0 0 0 0 1", 1.0)
    assert not observer.hear(b"head 4 9 9 9 0 0 0 1", 1.1)
    assert not observer.hear(b"head 5 9 9 9 0 0 0 1", 1.1)
    assert observer.room_t_head[0, 3] == pytest.approx(0.0)
    # A sender that has begun anew counts once it was silent.
    assert observer.hear(b"head 0 0.5 1 0 0 0 0 1", 1.1 + 2.0 * SILENT)
    assert observer.room_t_head[0, 3] == pytest.approx(0.5)


def test_a_flystick_moves_the_room_and_is_let_go_when_silent() -> None:
    observer = Observer(display())
    observer.hear(b"fly 1 1 0 0 0", 5.0)
    observer.advance(5.25)
    # The room looks along the world's y, at 2 m/s.
    assert observer.world_t_room[:3, 3] == pytest.approx([10.0, 0.5, 0.0])
    observer.advance(60.0)
    assert observer.world_t_room[:3, 3] == pytest.approx([10.0, 2.0 * SILENT, 0.0])
    observer.hear(b"fly 2 0 0 1 0", 60.0)
    observer.hear(b"fly 3 0 0 0 0", 60.1)
    observer.advance(60.4)
    assert observer.world_t_room[2, 3] == pytest.approx(0.2)


def test_flying_is_the_same_in_one_step_and_in_a_thousand() -> None:
    axes, start = (0.7, -0.4, 0.1, 0.9), virtualrobot.pose(1.0, 2.0, 0.0, yaw=0.3)
    steps = start
    for _ in range(1000):
        steps = flown(steps, axes, 1.5, 0.003)
    assert np.abs(flown(start, axes, 1.5, 3.0) - steps).max() < 1e-9
    straight = flown(start, (1.0, 0.0, 0.0, 0.0), 1.5, 2.0)
    assert (np.linalg.inv(start) @ straight)[:3, 3] == pytest.approx([3.0, 0.0, 0.0])
    assert np.array_equal(flown(start, (9.0, 0, 0, 0), 1.0, 1.0), flown(start, (1.0, 0, 0, 0), 1.0, 1.0))


@pytest.mark.parametrize(
    ("datagram", "said"),
    [
        (b"", "not 'head', a counter and 7 numbers or 'fly', a counter and 4 numbers|no line such as"),
        (b"head 1 0 0 1.7 0 0 1", "not 'head', a counter and 7 numbers"),
        (b"hand 1 0 0 1.7 0 0 0 1", "not 'head'"),
        (b"head one 0 0 1.7 0 0 0 1", "no line such as"),
        (b"head 1 0 0 nan 0 0 0 1", "not finite"),
        (b"head -1 0 0 1 0 0 0 1", "a counter below 0"),
        (b"head 1 0 0 1.7 0 0 0 2", "a quaternion of length 2, not 1"),
        (b"\xff\x00" * 20, "no line such as"),
        (b"head 1 " + b"0 " * 300, "607 bytes"),
    ],
)
def test_nonsense_by_udp_is_refused(datagram: bytes, said: str) -> None:
    with pytest.raises(InvalidArgumentError, match=said):
        told(datagram)


def test_a_socket_hears_what_was_sent_and_tells_what_was_wrong() -> None:
    observer, shown, wrong = Observer(display()), list[float](), list[str]()
    with Listener("127.0.0.1", 0) as listener, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for line in (b"head 1 0.1 1 0 0 0 0 1", b"nonsense", b"head 2 0.2 1 0 0 0 0 1"):
            sender.sendto(line, ("127.0.0.1", listener.port))

        def heard() -> bool:
            listener.listen(observer, lambda: shown.append(float(observer.room_t_head[0, 3])), wrong.append)
            return bool(wrong and shown) and shown[-1] == pytest.approx(0.2)

        until(heard)
        with pytest.raises(WrongStateError, match=r"nothing can be heard at 127\.0\.0\.1"):
            Listener("127.0.0.1", listener.port)
    assert len(wrong) == 1
    assert "nonsense" in wrong[0]


def test_the_command_prints_the_matrices_from_the_world_on(tmp_path: Path) -> None:
    file = tmp_path / "cave.yaml"
    file.write_text(CAVE)
    said = CliRunner().invoke(walls, [str(file), "--head", "0.3,0.2,1.5"])
    assert said.exit_code == 0, said.output
    lines = [json.loads(line) for line in said.output.splitlines()]
    cave = display()
    expected = views(cave, virtualrobot.pose(0.3, 0.2, 1.5))
    assert [(one["wall"], one["eye"]) for one in lines] == [(one.wall, one.eye) for one in expected]
    room_t_world = np.linalg.inv(cave.world_t_room)
    for line, one in zip(lines, expected, strict=True):
        assert np.array_equal(np.reshape(line["projection"], (4, 4)), one.frustum.projection)
        assert np.allclose(np.reshape(line["view"], (4, 4)), one.frustum.view @ room_t_world, atol=1e-12)
    for options, told_of in (
        (["--head", "5,0,1.5"], "behind the wall 'front'"),
        (["--listen", "7700"], "no address such as"),
        (["--listen", "127.0.0.1:7700", "--head", "0,0,1"], "are for one that stands"),
    ):
        refused = CliRunner().invoke(walls, [str(file), *options])
        assert refused.exit_code != 0
        assert told_of in refused.output + str(refused.exception)


@pytest.mark.long
def test_the_command_prints_anew_for_each_head_that_is_heard(tmp_path: Path) -> None:
    file = tmp_path / "cave.yaml"
    file.write_text(CAVE)
    command = [sys.executable, "-m", "virtualrobot", "walls", str(file), "--listen", "127.0.0.1:0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stderr is not None
        first = [json.loads(process.stdout.readline()) for _ in range(6)]
        port = int(process.stderr.readline().rpartition(":")[2])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(b"head 1 0.5 1.2 0 0 0 0 1", ("127.0.0.1", port))
            moved = [json.loads(process.stdout.readline()) for _ in range(6)]
            sender.sendto(b"head 2 9 1.2 0 0 0 0 1", ("127.0.0.1", port))
            assert "behind the wall 'front'" in process.stderr.readline()
            sender.sendto(b"head 3", ("127.0.0.1", port))
            assert "not 'head', a counter and 7 numbers" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        assert process.wait(60.0) == 0
    finally:
        process.kill()
        process.communicate()
    assert [one["eye"] for one in first] == [one["eye"] for one in moved]
    observer = Observer(display())
    observer.hear(b"head 1 0.5 1.2 0 0 0 0 1", 0.0)
    expected = views(observer.display, observer.room_t_head)[0].frustum.projection
    assert np.array_equal(np.reshape(moved[0]["projection"], (4, 4)), expected)
