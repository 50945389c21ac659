"""Pictures of a real kernel are good enough for OpenCV: it finds a yellow valve wheel, and a black line to follow.

Both as users did it: "A Robotics Framework for Planning the Offshore Robotizing" (OTC Brasil 2013) by hue, contours and
a fitted ellipse; "Boe-Bot simulation in Gazebo" (Tartu) by a crop, a mask of what is black, and its centre of mass.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import virtualrobot
from virtualrobot.kernel_process import KernelProcess

from tests.apps.vision import WHEEL_RADIUS, WHEEL_TUBE, build_line_floor, build_platform, line_at


@pytest.fixture(scope="module")
def client() -> Iterator[virtualrobot.Client]:
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.mark.long
def test_a_yellow_valve_wheel_is_found_and_its_place_too(
    client: virtualrobot.Client, tmp_path: Path, rng: np.random.Generator
) -> None:
    client.scene.clear()
    # Its axis looks at the camera, but for up to 35 degrees.
    tilt, turn = rng.uniform(-0.6, 0.6, 2)
    center = rng.uniform([1.35, -0.6, 1.1], [1.45, 0.8, 1.7])
    facing = virtualrobot.pose(*center) @ virtualrobot.pose(pitch=np.pi / 2) @ virtualrobot.pose(roll=tilt, pitch=turn)
    build_platform(client, tmp_path, facing)
    eye = virtualrobot.looking_at([-0.6, 0.2, 1.5], [1.6, 0.1, 1.3])
    settings = virtualrobot.camera(640, 480, horizontal_field=1.2, color_noise=0.02, seed=int(rng.integers(1 << 30)))
    client.scene.add_camera("eye", settings, pose=eye)
    seen = client.sensors["eye"].read(images=["color", "depth", "segmentation"]).camera
    assert seen.color is not None and seen.depth is not None

    hsv = cv2.cvtColor(seen.color, cv2.COLOR_RGB2HSV)
    yellow = cv2.inRange(hsv, np.array([22, 120, 60]), np.array([34, 255, 255]))
    yellow = cv2.morphologyEx(yellow, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(yellow, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    (x, y), (_, long), _ = cv2.fitEllipse(cv2.convexHull(max(contours, key=cv2.contourArea)))

    # What is yellow is the wheel, and no other thing is.
    wheel = seen.mask("valve")
    assert (wheel & (yellow > 0)).sum() > 0.85 * wheel.sum()
    assert (~wheel & (yellow > 0)).sum() < 0.1 * wheel.sum()
    # The ellipse's middle is where the wheel's centre is projected to, but for perspective: 3.8 pixels at most here.
    camera_t_wheel = np.linalg.inv(eye) @ facing
    middle, _ = cv2.projectPoints(camera_t_wheel[None, :3, 3], np.zeros(3), np.zeros(3), seen.camera_matrix, None)
    np.testing.assert_allclose((x, y), middle.ravel(), atol=4.5)
    # By depth, the place and the size too: the rim is of the wheel's plane.
    rim = seen.points(eye)[wheel]
    np.testing.assert_allclose(np.median(rim, axis=0), center, atol=0.06)
    distance = camera_t_wheel[2, 3]
    # A circle off the camera's axis is seen stretched by up to 1 / cos of the angle; two pixels are 3% of it.
    radius, stretch = 0.5 * long * distance / seen.camera_matrix[0, 0], np.linalg.norm(camera_t_wheel[:3, 3]) / distance
    outline = WHEEL_RADIUS + WHEEL_TUBE
    assert 0.97 * outline < radius < 1.03 * outline * stretch


@pytest.mark.long
def test_a_robot_that_looks_follows_a_black_line(
    client: virtualrobot.Client, tmp_path: Path, rng: np.random.Generator
) -> None:
    client.scene.clear()
    build_line_floor(client, tmp_path)
    x, y = -1.7, float(line_at(np.array(-1.7)) + rng.uniform(-0.05, 0.05))
    slope = (line_at(np.array(-1.6)) - line_at(np.array(-1.7))) / 0.1
    heading = float(np.arctan(slope) + rng.uniform(-0.2, 0.2))
    client.scene.add_object("rover", virtualrobot.box(0.12, 0.1, 0.06, pose=virtualrobot.pose(-0.1, 0, 0.03)))
    # 25 cm above the floor, it looks at the floor 35 cm ahead.
    mount = virtualrobot.looking_at([0.0, 0.0, 0.25], [0.35, 0.0, 0.0])
    settings = virtualrobot.camera(160, 120, horizontal_field=1.1, color_noise=0.02)
    client.scene.add_camera("eye", settings, pose=mount, parent="rover")
    eye, ways, off = client.sensors["eye"], 0, []
    while x < 1.3:
        ways += 1
        assert ways < 150, f"it does not get on: at {(x, y)}, heading {heading}"
        client.scene.set_pose("rover", virtualrobot.pose(x, y, 0.0, yaw=heading))
        picture = eye.read().camera.color
        assert picture is not None
        below = picture[60:]
        hsv = cv2.cvtColor(below, cv2.COLOR_RGB2HSV)
        black = cv2.inRange(hsv, np.array([0, 0, 0]), np.array([180, 255, 90]))
        contours, _ = cv2.findContours(black, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        assert contours, f"it has lost the line at {(x, y)}, heading {heading}"
        moments = cv2.moments(max(contours, key=cv2.contourArea))
        error = moments["m10"] / moments["m00"] - 79.5  # pixels to the right
        heading -= 0.006 * error
        x, y = x + 0.03 * math.cos(heading), y + 0.03 * math.sin(heading)
        off.append(abs(y - line_at(np.array(x))))
    assert max(off[20:]) < 0.15  # it looks 35 cm ahead, and cuts bends short
    assert np.mean(off[20:]) < 0.07
