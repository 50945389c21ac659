"""A person sets speeds and time at the console's page; the kernel is asked each time."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Locator, expect

from tests.api.asking import IIWA, PANDA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

TOOL_LIMIT = 0.1
"""m/s"""


def write(field: Locator, words: str) -> None:
    field.fill(words)
    field.press("Enter")


def test_a_person_sets_speeds(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="iiwa")
        client.load_robot(PANDA, name="panda", pose=virtualrobot.pose(1.5))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_title("Speed of each robot, and of time").click()
            panel = page.get_by_label("Speed and time", exact=True)
            write(panel.get_by_label("Speed of all robots, 1 to 100 %", exact=True), "50")
            until(lambda: client.speed_factor == 0.5)
            write(panel.get_by_label("Speed of iiwa, 1 to 100 %", exact=True), "12,5")
            until(lambda: arm.speed_factor == 0.125)
            assert client.robot("panda").speed_factor == 1.0

            # By key on a slider: one percent less.
            panel.get_by_label("Speed of panda by slider, 1 to 100 %", exact=True).press("ArrowLeft")
            until(lambda: client.robot("panda").speed_factor == 0.99)

            # The tool keeps to its limit in what is planned from now on.
            write(panel.get_by_label("Greatest speed of the tool of iiwa, 0 is no limit", exact=True), "100")
            until(lambda: arm.tcp_speed_limit == TOOL_LIMIT)
            planned = arm.plan(arm.ptp([1.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]))
            fastest = float(np.max(planned.robots["iiwa"].tcp_speeds))
            assert 0.5 * TOOL_LIMIT < fastest <= TOOL_LIMIT * (1 + 1e-6)

            # What is out of range, or no number, changes nothing; the range is told.
            said = page.locator("#last")
            write(panel.get_by_label("Speed of iiwa, 1 to 100 %", exact=True), "0")
            expect(said).to_have_text("a speed is 1 to 100 %, not 0")
            write(panel.get_by_label("Speed of iiwa, 1 to 100 %", exact=True), "fast")
            assert arm.speed_factor == 0.125

            # Time stands still here, and goes on by as many ticks as are told.
            tick = client.clock.read().stamp.tick
            write(panel.get_by_label("Ticks of a step", exact=True), "25")
            expect(panel).to_contain_text("= 100 ms")
            panel.get_by_role("button", name="Step", exact=True).click()
            until(lambda: client.clock.read().stamp.tick == tick + 25)

            # It goes on at half of the wall clock's speed, and stands still again.
            rate = panel.get_by_label("Simulated seconds for each second that are aimed at, 0.01 to 100", exact=True)
            write(rate, "1000")
            expect(said).to_contain_text("0.01 to 100 times as fast")
            assert client.clock.mode == "stepped"
            write(rate, "0,5")
            until(lambda: (client.clock.read().mode, client.clock.read().speed_factor) == ("realtime", 0.5))
            still = panel.get_by_role("radio", name="stands still")
            expect(still).not_to_be_checked()  # the page knows it, too
            still.click()
            until(lambda: client.clock.mode == "stepped")
            panel.get_by_title("Close").click()
            expect(panel).to_have_count(0)
