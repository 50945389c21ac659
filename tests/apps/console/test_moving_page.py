"""A person moves and turns a node by its handle in the view, which snaps."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import nodes_pb2, scene_pb2

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

RASTER = 0.01
"""Meters, as the page has it."""

CURSOR = "(view) => new Promise((go) => requestAnimationFrame(() => go(view.style.cursor)))"
"""Cursor that the pointer has, once the page has heard where it is: it hears of moves before it draws."""


def test_a_node_is_moved_by_its_handle(console: Console, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1), pose=virtualrobot.pose(z=0.45))
        client.scene.add_object("block", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(x=0.003, z=0.623))
        client.scene.add_object("core", virtualrobot.box(0.02, 0.02, 0.02), parent="block")
        with opened(browser, console.url + PLAIN) as page:
            row(page, "block").click()
            page.get_by_role("tab", name="Properties").click()
            for key in ("f", "1", "m"):
                page.keyboard.press(key)
            expect(page.get_by_title("Move the selected node (M)")).to_have_attribute("aria-pressed", "true")
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            canvas = page.locator(".view .canvas canvas").bounding_box()
            assert canvas is not None
            x, y = canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2
            said = page.locator(".moved")

            def dragged_until(dx: int, dy: int, words: str) -> None:
                """Drag the middle of the handle in steps of pixels until the page says words of where the node is."""
                page.mouse.move(x, y)
                page.mouse.down()
                for number in range(1, 16):
                    page.mouse.move(x + dx * number, y + dy * number)
                    if number > 1 and words in said.inner_text():
                        return
                raise AssertionError(f"never {words}: {said.inner_text()}")

            def looks_at_it_again() -> None:
                """Look at the block where it stood at first, once the page knows that it stands there."""
                expect(page.locator("#properties").get_by_label("Z", exact=True)).to_have_value("623.00")
                page.keyboard.press("f")
                page.locator('.view .canvas[aria-busy="false"]').wait_for()

            # Down to the table: near its top the block's bottom is put on it; across, it is on the raster.
            dragged_until(0, 20, "at table")
            np.testing.assert_allclose(client.scene.pose("block")[:3, 3], [0.003, 0.0, 0.623])  # nobody has let go
            page.mouse.up()
            expect(said).to_have_count(0)
            x_now, y_now, z_now = client.scene.pose("block")[:3, 3]
            assert z_now == pytest.approx(0.45 + 0.05 + 0.05, abs=1e-9)
            assert x_now / RASTER == pytest.approx(round(x_now / RASTER), abs=1e-6) and y_now == pytest.approx(0.0)
            np.testing.assert_allclose(client.scene.pose("core"), client.scene.pose("block"))
            page.keyboard.press("Control+z")
            looks_at_it_again()

            # Esc while it is dragged leaves it where it is.
            dragged_until(0, 20, "at table")
            page.keyboard.press("Escape")
            expect(said).to_have_count(0)
            page.mouse.up()
            assert client.scene.pose("block")[2, 3] == pytest.approx(0.623)

            # Without snapping it goes wherever it is let go.
            page.get_by_title("Nodes that are moved snap").click()
            looks_at_it_again()
            dragged_until(27, 13, "mm")
            page.mouse.up()
            expect(said).to_have_count(0)
            until(lambda: client.scene.pose("block")[0, 3] > 0.0031)
            assert client.scene.pose("block")[0, 3] / RASTER % 1.0 > 1e-6

            # What hangs on it is where a person writes that it is in the world.
            row(page, "core").click()
            properties = page.locator("#properties")
            properties.get_by_role("radio", name="World", exact=True).click()
            field = properties.get_by_label("X", exact=True)
            expect(field).to_have_value(f"{1000.0 * client.scene.pose('core')[0, 3]:.2f}")
            client.scene.set_pose("block", virtualrobot.pose(0.5, 0.2, 0.8, yaw=0.7))
            expect(field).to_have_value("500.00")
            field.fill("250")
            field.press("Enter")
            until(lambda: np.allclose(client.scene.pose("core"), virtualrobot.pose(0.25, 0.2, 0.8, yaw=0.7), atol=1e-6))

            # So it is in the frame of any node.
            client.scene.set_pose("table", virtualrobot.pose(0.1, 0.2, 0.45, yaw=0.7))
            properties.get_by_role("radio", name="Node", exact=True).click()
            frame = properties.get_by_label("The node in whose frame the pose is")
            frame.fill("table")
            frame.press("Enter")
            expect(properties).to_contain_text("Pose in table")
            inside = np.linalg.inv(client.scene.pose("table")) @ client.scene.pose("core")
            expect(field).to_have_value(f"{1000.0 * inside[0, 3]:.2f}")
            field.fill("10")
            field.press("Enter")
            inside[0, 3] = 0.01
            until(lambda: np.allclose(client.scene.pose("core"), client.scene.pose("table") @ inside, atol=1e-6))


def test_a_node_is_turned_by_its_handle_and_sized_by_its_faces(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    """Looked at from above, the ring about z lies flat around the node: where it is dragged to, the node turns to."""
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("plate", virtualrobot.box(0.4, 0.2, 0.02), pose=virtualrobot.pose(0.3, 0.1))
        with opened(browser, console.url + PLAIN) as page:
            row(page, "plate").click()
            for key in ("f", "5", "t"):
                page.keyboard.press(key)
            expect(page.get_by_title("Turn the selected node (T)")).to_have_attribute("aria-pressed", "true")
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            canvas = page.locator(".view .canvas canvas").bounding_box()
            assert canvas is not None
            x, y = canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2
            said = page.locator(".moved")

            # The ring has some radius in pixels: it is looked for from outside, where the ring that faces the eye ends.
            turned = False
            for radius in range(140, 30, -3):
                page.mouse.move(x + radius, y)
                page.mouse.down()
                for number in range(1, 13):
                    angle = np.radians(5.0 * number)
                    page.mouse.move(x + radius * np.cos(angle), y - radius * np.sin(angle))
                if turned := said.count() == 1 and "turned by" in said.inner_text():
                    break
                page.mouse.up()
            assert turned
            words = said.inner_text()
            np.testing.assert_allclose(client.scene.pose("plate"), virtualrobot.pose(0.3, 0.1), atol=1e-9)
            page.mouse.up()
            expect(said).to_have_count(0)
            until(lambda: not np.allclose(client.scene.pose("plate")[:3, :3], np.eye(3), atol=1e-3))
            pose = client.scene.pose("plate")
            np.testing.assert_allclose(pose[:3, 3], [0.3, 0.1, 0.0], atol=1e-9)
            degrees = np.degrees(np.arccos((np.trace(pose[:3, :3]) - 1.0) / 2.0))
            assert f"turned by {degrees:.1f}" in words
            assert degrees / 5.0 == pytest.approx(round(degrees / 5.0), abs=1e-3)
            page.keyboard.press("Control+z")
            until(lambda: np.allclose(client.scene.pose("plate"), virtualrobot.pose(0.3, 0.1), atol=1e-9))

            # A face is taken to the right of the middle, and drawn out by steps of 10 mm; the one opposite stays.
            def plate() -> nodes_pb2.Figure:
                return stepped.scene.GetScene(scene_pb2.GetSceneRequest(names=["plate"])).nodes[0].figures[0]

            def taken_hold_of() -> int:
                """Press at the face's dot and return how far it is from the middle (pixels)."""
                for right in range(20, 500, 5):
                    page.mouse.move(x + right, y)
                    if page.locator(".view .canvas").evaluate(CURSOR) == "grab":
                        page.mouse.down()
                        return right
                raise AssertionError("there is no dot")

            for key in ("5", "s"):  # who looked for the ring has turned the view
                page.keyboard.press(key)
            expect(page.get_by_title("Draw faces of the selected node out or in (S)")).to_have_attribute(
                "aria-pressed", "true"
            )
            for ends_with in (lambda: page.keyboard.press("Escape"), lambda: None):
                right = taken_hold_of()
                page.mouse.move(x + right + 60, y)
                expect(said).to_contain_text("mm")
                words = said.inner_text()
                assert plate().box.size.x == 0.4  # nobody has let go
                ends_with()
                page.mouse.up()
                expect(said).to_have_count(0)
            until(lambda: plate().box.size.x != 0.4)
            figure = plate()
            size = figure.box.size.x
            assert size > 0.4 and size / RASTER == pytest.approx(round(size / RASTER), abs=1e-6)
            assert f"X {1000.0 * size:.1f} mm" in words
            assert figure.node_t_figure.position.x == pytest.approx((size - 0.4) / 2.0)
            assert (figure.box.size.y, figure.box.size.z) == (0.2, 0.02)
            page.keyboard.press("Control+z")
            until(lambda: plate().box.size.x == 0.4)
