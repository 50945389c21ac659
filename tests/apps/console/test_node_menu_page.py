"""A person asks for what can be done with a node by the right button, and shows one alone, at the console's page."""

from __future__ import annotations

import pytest
import virtualrobot
from playwright.sync_api import expect
from virtualrobot.v1 import nodes_pb2, scene_pb2

from tests.apps.console.browsing import PLAIN, PURPLE, browsers, needs_page, opened, purple_count, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

GREY = (0.5, 0.5, 0.5)


def test_a_node_has_a_menu_and_is_shown_alone(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    def nodes() -> dict[str, nodes_pb2.Node]:
        return {node.name: node for node in stepped.scene.GetScene(scene_pb2.GetSceneRequest()).nodes}

    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.scene.add_object("cube", virtualrobot.box(0.3, 0.3, 0.3, color=GREY), pose=virtualrobot.pose(x=-0.4))
        client.scene.add_object("lid", virtualrobot.box(0.2, 0.2, 0.1), parent="cube", pose=virtualrobot.pose(z=0.2))
        client.scene.add_object("post", virtualrobot.box(0.3, 0.3, 0.3, color=PURPLE), pose=virtualrobot.pose(x=0.4))
        with opened(browser, console.url + PLAIN) as page:
            page.context.grant_permissions(["clipboard-read", "clipboard-write"])
            menu, tree = page.get_by_role("menu"), page.get_by_role("tree")
            entry = lambda name: menu.get_by_role("menuitem", name=name)  # noqa: E731
            until(lambda: purple_count(page) > 100)

            # By the right button in the tree: the node is selected; Esc leaves the menu and gives the focus back.
            tree.focus()
            row(page, "cube").click(button="right")
            expect(page.get_by_role("menu", name="cube")).to_be_visible()
            expect(row(page, "cube")).to_have_attribute("aria-selected", "true")
            expect(entry("Look at it")).to_be_focused()
            page.keyboard.press("ArrowUp")
            expect(entry("Delete")).to_be_focused()
            page.keyboard.press("Escape")
            expect(menu).to_have_count(0)
            expect(tree).to_be_focused()

            # By its key: shown alone, on this page only, and a click beside the menu closes it.
            page.keyboard.press("Shift+F10")
            entry("Show it alone").press("Enter")
            expect(page.get_by_text("Only cube is shown")).to_be_visible()
            until(lambda: purple_count(page) == 0)
            assert not any(node.hidden for node in nodes().values())
            # Locked it has a sign and no handle to be dragged by, and can't be deleted; anybody unlocks it.
            row(page, "cube").click(button="right")
            entry("Lock it").click()
            expect(row(page, "cube").get_by_title("Locked")).to_be_visible()
            tree.press("Delete")
            expect(page.get_by_text("'cube' is locked")).to_be_visible()
            row(page, "cube").click(button="right")
            entry("Unlock it").click()
            until(lambda: not nodes()["cube"].locked)
            client.scene.rename("cube", "block")
            expect(page.get_by_text("Only block is shown")).to_be_visible()
            page.get_by_role("button", name="Show all").click()
            until(lambda: purple_count(page) > 100)

            # In the view: what is under the pointer, in the middle of what is looked at; I shows alone.
            row(page, "post").click(button="right")
            entry("Look at it").click()
            canvas = page.locator(".view .canvas canvas").bounding_box()
            assert canvas is not None
            middle = canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2
            row(page, "world").click()
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            page.mouse.click(*middle, button="right")
            expect(page.get_by_role("menu", name="post")).to_be_visible()
            expect(row(page, "post")).to_have_attribute("aria-selected", "true")
            page.mouse.click(middle[0] - 0.3 * canvas["width"], middle[1])
            expect(menu).to_have_count(0)
            row(page, "block").click()
            page.keyboard.press("i")
            until(lambda: purple_count(page) == 0)
            page.keyboard.press("i")
            until(lambda: purple_count(page) > 100)

            # The right button held and moved shifts the view, and asks for nothing.
            page.mouse.move(*middle)
            page.mouse.down(button="right")
            page.mouse.move(middle[0] + 60, middle[1])
            page.mouse.up(button="right")
            expect(menu).to_have_count(0)

            # What it does: the name for programs, hiding, renaming in the row, properties, and delete.
            row(page, "lid").click(button="right")
            entry("Copy the name").click()
            expect(page.locator("#last")).to_have_text("copied: lid")
            assert page.evaluate("navigator.clipboard.readText()") == "lid"
            row(page, "lid").click(button="right")
            entry("Hide it").click()
            until(lambda: nodes()["lid"].hidden)
            row(page, "lid").click(button="right")
            entry("Rename").click()
            page.get_by_label("New name of lid").fill("cover")
            page.keyboard.press("Enter")
            until(lambda: "cover" in nodes())
            row(page, "cover").click(button="right")
            entry("Properties").click()
            expect(page.get_by_role("tab", name="Properties")).to_have_attribute("aria-selected", "true")
            row(page, "block").click()
            page.keyboard.press("i")
            expect(page.get_by_text("Only block is shown")).to_be_visible()
            row(page, "block").click(button="right")
            entry("Delete").click()
            until(lambda: set(nodes()) == {"world", "post"})

            # What was shown alone is gone: the whole cell is there again. The world's own menu deletes nothing.
            expect(page.get_by_text("Only block is shown")).to_have_count(0)
            until(lambda: purple_count(page) > 100)
            row(page, "world").click(button="right")
            expect(menu.get_by_role("menuitem")).to_have_count(2)
            page.keyboard.press("Escape")

            # A node that goes while its menu is open takes the menu along.
            row(page, "post").click(button="right")
            expect(menu).to_have_count(1)
            client.scene.remove("post")
            expect(menu).to_have_count(0)
