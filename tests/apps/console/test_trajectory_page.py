"""A person looks at a trajectory of a file at the console's page, and plays it; the kernel is asked each time."""

from __future__ import annotations

import re

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Locator, Page, expect
from virtualrobot import Client
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, color_count, needs_page, opened
from tests.apps.console.consoles import Console, consoles
from tests.apps.console.test_views_page import shot
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
JOINTS = ("lbr_iiwa_joint_1", "lbr_iiwa_joint_4")
SECONDS = 2.0
WAY = (0x38, 0xBD, 0xF8)
"""Colour of the tool's line."""


def swing(times: np.ndarray) -> np.ndarray:
    """Return joints 1 and 4 (n, 2): a whole cosine, so that it is at rest and at the same place at both ends."""
    turn = 0.5 * (1.0 - np.cos(2.0 * np.pi * times / SECONDS))
    return np.stack([0.2 + 0.4 * turn, -1.2 + 0.3 * turn], axis=1)


def table(change: tuple[str, str] = ("", "")) -> bytes:
    """Return the swing as CSV, with one change."""
    times = np.linspace(0.0, SECONDS, 41)
    rows = [f"{time:.3f},{one:.6f},{four:.6f}" for time, (one, four) in zip(times, swing(times), strict=True)]
    return "\n".join(["time," + ",".join(JOINTS), *rows]).replace(*change).encode()


def give(page: Page, data: bytes, name: str = "swing.csv") -> None:
    page.set_input_files("#open-trajectory", {"name": name, "mimeType": "", "buffer": data})


def shown(panel: Locator) -> float:
    """Return the time (s) that the panel is at."""
    return float(panel.locator("#moment").inner_text().split("/")[0])


def test_a_person_plays_a_trajectory(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions(HERE)
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_role("tab", name="Trajectory").click()
            panel = page.get_by_label("What happens", exact=True)
            expect(panel).to_contain_text("iiwa will follow it")

            # Looked at: the kernel's verdict, the tool's line, and by key on the slider the ghost at half of its time.
            give(page, table())
            expect(panel.get_by_role("status")).to_have_text("swing.csv: iiwa keeps all limits and touches nothing")
            until(lambda: color_count(page, WAY) > 50)
            slider = panel.get_by_label("Time of the trajectory, s")
            slider.press("Home")
            for _ in range(5):
                slider.press("PageUp")  # a tenth of it each
            expect(panel.locator("#moment")).to_have_text("1.000 / 2.000 s")
            legend = panel.get_by_title("lbr_iiwa_joint_1", exact=True)
            expect(legend).to_contain_text("34.4 °")  # 0.6 rad
            expect(page.locator("#go")).to_be_visible()
            np.testing.assert_array_equal(arm.positions, HERE)

            # All of it at once: ghosts where the arm comes by; without them the picture is as before.
            before = shot(page)
            differs = lambda: np.count_nonzero(np.abs(shot(page) - before).max(axis=2) > 0.05)  # noqa: E731
            whole = panel.get_by_role("button", name="Whole motion")
            whole.click()
            until(lambda: differs() > 500)
            whole.click()
            until(lambda: differs() < 20)

            # The speed of a cosine at a quarter of it: 0.2 rad · π/s.
            panel.get_by_role("radio", name="speeds").click()
            for _ in range(125):
                slider.press("ArrowLeft")  # a five-hundredth of it each
            expect(panel.locator("#moment")).to_have_text("0.500 / 2.000 s")
            expect(legend).to_contain_text(re.compile(r"36\.0 °/s"))

            # Played: to its start, then along it; the kernel's joints are on the curve at each step of time.
            panel.locator("#play-trajectory").click()
            until(lambda: stepped.motion.ListMotions(motion_pb2.ListMotionsRequest(running_only=True)).motions)
            farthest, off = 0.0, []

            def over() -> bool:
                nonlocal farthest
                step(stepped, 5)
                *_, motion = stepped.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions
                time = motion.progress * motion.planned_duration_seconds - (motion.planned_duration_seconds - SECONDS)
                now = state(stepped, "iiwa").positions
                farthest = max(farthest, now[0])
                if time > 0.0:
                    off.append(np.abs(np.array([now[0], now[3]]) - swing(np.array([time]))[0]).max())
                return motion.phase == motion_pb2.MOTION_PHASE_SUCCEEDED

            until(over)
            # A spline through samples of 50 ms is off by less than 1e-6 rad; a tick of 4 ms at 0.63 rad/s is 2.5e-3.
            assert len(off) > 50 and max(off) < 5e-3
            assert farthest == pytest.approx(0.6, abs=1e-3)
            np.testing.assert_allclose([arm.positions[0], arm.positions[3]], [0.2, -1.2], atol=1e-6)
            expect(panel.locator("#moment")).to_have_text("2.000 / 2.000 s")

            # What each joint does there, as another client is told.
            panel.get_by_role("radio", name="torques").click()
            slider.press("Home")
            told = arm.plan(arm.read_trajectory("swing.csv", table().decode())).robots["iiwa"]
            torque = told.efforts[0, told.joint_names.index(JOINTS[1])]
            assert abs(torque) > 1.0
            expect(panel.get_by_title(JOINTS[1], exact=True)).to_contain_text(f"{torque:.1f} N m")

            # Measured was what was planned, and this robot is where it is commanded.
            panel.get_by_role("radio", name="error").click()
            expect(panel.get_by_role("status")).to_contain_text("isn't measured: it is where it was commanded")
            expect(legend).to_contain_text("0.000 °")

            # What is wrong with files: line and column; what was here stays.
            alert = page.locator("#loading")
            for change, words in [
                (("0.050,", "0.000,"), "line 3: column 1 (time): 0 s does not come after 0 s of line 2"),
                (("0.600000", "nan"), "line 22: column 2 (lbr_iiwa_joint_1): nan is no finite number"),
                ((JOINTS[1], "panda_joint4"), "line 1: column 3 (panda_joint4): 'iiwa' has no joint"),
            ]:
                give(page, table(change))
                expect(alert).to_contain_text(words)
                alert.get_by_title("Close").click()
            give(page, b'{"times": [0, 1],\n"positions": [[0, 1, 2, 3, 4, 5],\n[0, 1, 2, 3, 4, 5]]}', "six.json")
            expect(alert).to_contain_text("line 2: column 14 (positions): ")
            expect(alert).to_contain_text("these are 6 joints: 6 values for the robot 'iiwa'")
            alert.get_by_title("Close").click()
            expect(panel.get_by_title("Close swing.csv")).to_be_visible()

            # Too fast: the kernel's words, and no way to play it.
            give(page, table(("0.600000", "2.900000")), "fast.csv")
            expect(panel.get_by_role("alert")).to_contain_text("the trajectory is too fast from")
            expect(panel.locator("#play-trajectory")).to_be_disabled()

            # Into something: where and when, by the kernel's check; a click shows the ghost there.
            place = arm.tcp[:3, 3]
            turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
            x, y = turn @ place[:2]
            client.scene.add_object("post", virtualrobot.box(0.05, 0.05, 1.0), pose=virtualrobot.pose(x, y, 0.5))
            give(page, table())
            hit = panel.get_by_role("alert")
            expect(hit).to_contain_text("post")
            hit.get_by_role("button").click()
            until(lambda: 0.1 < shown(panel) < 1.0)
            expect(page.locator("#go")).to_be_visible()
            panel.get_by_title("Close swing.csv").click()
            expect(panel).to_contain_text("iiwa will follow it")
            expect(page.locator("#go")).to_have_count(0)


def test_the_following_error(client: Client, kernel: KernelProcess) -> None:
    # Monitored, a robot stays where it is whatever its twin is told: it is beside that by all of the swing.
    client.load_robot(IIWA, name="iiwa")
    client.drivers.connect("iiwa", "loopback", {"joints": 7})
    try:
        client.drivers.set_mode("iiwa", "monitor")
        with consoles(kernel.address) as console, browsers() as browser, opened(browser, console.url + PLAIN) as page:
            page.get_by_role("tab", name="Trajectory").click()
            panel = page.get_by_label("What happens", exact=True)
            give(page, table())
            expect(panel.get_by_role("status")).to_contain_text("keeps all limits")
            panel.locator("#play-trajectory").click()
            expect(page.locator("#last")).to_contain_text("has followed swing.csv")
            panel.get_by_role("radio", name="error").click()
            expect(panel.get_by_role("status")).to_contain_text("keeps all limits")
            slider = panel.get_by_label("Time of the trajectory, s")
            slider.press("Home")
            for _ in range(5):
                slider.press("PageUp")
            said = panel.get_by_title(JOINTS[0], exact=True).inner_text()
            assert float(re.findall(r"-?[\d.]+", said)[-1]) == pytest.approx(-np.degrees(0.6), abs=1.0)
    finally:
        client.drivers.disconnect("iiwa")
