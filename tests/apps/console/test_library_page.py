"""A person mounts a gripper of the library at the console's page, and drags a robot to where it shall stand."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.api.asking import IIWA
from tests.api.reading import scene
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def test_a_person_mounts_and_drags(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="arm")
        with opened(browser, console.url + PLAIN) as page:
            row(page, "arm").click()
            page.get_by_role("tab", name="Library").click()

            # Mounted on the flange it is the arm's tool; a second one there is refused; undo takes the first one off.
            page.get_by_label("Filter models").fill("parallel_gripper")
            gripper = page.locator('[data-model="parallel_gripper"]')
            gripper.hover()
            gripper.get_by_role("button", name="Mount").click()
            until(lambda: arm.state.tool)
            mounted = scene(stepped).keys()
            gripper.hover()
            gripper.get_by_role("button", name="Mount").click()
            said = page.get_by_role("alert")
            expect(said).to_contain_text(str(arm.state.tool))
            said.get_by_title("Close").click()
            assert scene(stepped).keys() == mounted
            page.get_by_title("Undo (Ctrl-Z)").click()
            until(lambda: not arm.state.tool)

            # Dragged to the floor it stands there.
            page.get_by_label("Filter models").fill("iiwa7")
            view = page.locator(".view .canvas canvas")
            box = view.bounding_box()
            assert box
            before = set(client.robots)
            there = {"x": 0.7 * box["width"], "y": 0.75 * box["height"]}
            page.locator('[data-model="iiwa7"]').drag_to(view, target_position=there)  # pyright: ignore[reportArgumentType]
            until(lambda: len(set(client.robots) - before) == 1)
            (dragged,) = set(client.robots) - before
            x, y, z = scene(stepped)[dragged][:3, 3]
            assert z == 0.0 and np.hypot(x, y) > 0.2
