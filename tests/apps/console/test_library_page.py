"""A person mounts a gripper of the library at the console's page, and drags a robot to where it shall stand."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot import Client

from tests.api.asking import IIWA
from tests.api.reading import scene
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def on_the_floor(client: Client, across: float, down: float, aspect: float) -> np.ndarray:
    """Return x and y of the floor at these parts of a picture from the view of all, from where the page looks too."""
    view = client.view.read()
    eye, tangent = np.asarray(view.camera_position), np.tan((view.field_of_view or 0.9) / 2.0)
    ahead = np.asarray(view.camera_target) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    ray = ahead + tangent * ((1.0 - 2.0 * down) * up + (2.0 * across - 1.0) * aspect * right)
    return (eye - ray * eye[2] / ray[2])[:2]


def test_a_person_mounts_and_drags(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="arm")
        with opened(browser, console.url + PLAIN) as page:
            row(page, "arm").click()
            page.get_by_role("tab", name="Library").click()

            # Models that are seen have pictures, which the kernel takes; the icon of its kind stands there till then.
            page.get_by_label("Filter models").fill("ur5e")
            picture = page.locator('[data-model="ur5e"] img')
            expect(picture).to_be_visible(timeout=60_000)
            until(lambda: picture.evaluate("(one) => one.complete && one.naturalWidth") == 208)

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

            # Dragged to the floor it stands where the pointer's ray meets it, on a raster of 10 mm.
            page.get_by_role("tab", name="Views", exact=True).click()
            page.locator("#views").get_by_role("button", name="Set from here").click()
            until(lambda: client.view.read().camera_position is not None)
            page.get_by_role("tab", name="Library").click()
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
            assert z == 0.0
            np.testing.assert_allclose([x, y], on_the_floor(client, 0.7, 0.75, box["width"] / box["height"]), atol=0.01)
