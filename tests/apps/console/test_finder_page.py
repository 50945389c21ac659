"""A person finds commands and nodes by their words at the console's page, and the kernel is asked."""

from __future__ import annotations

import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.api.asking import IIWA
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


def test_commands_and_nodes_are_found_by_words(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        client.load_robot(IIWA, name="iiwa")
        client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1))
        client.scene.rename("table", "bench")
        with opened(browser, console.url + PLAIN) as page:
            expect(row(page, "bench")).to_be_visible()
            field = page.get_by_role("combobox", name="Find a command or a node")
            options = page.get_by_role("listbox", name="What was found").get_by_role("option")
            # A command of the page, by a part of its name.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("und")
            expect(options.first).to_contain_text("Undo")
            page.keyboard.press("Enter")
            expect(field).to_be_hidden()
            until(lambda: "table" in client.scene)
            expect(row(page, "table")).to_be_visible()
            # A node, with its kind.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("table object")
            page.keyboard.press("Enter")
            expect(row(page, "table")).to_have_attribute("aria-selected", "true")
            # A panel that isn't open, by the arrow keys.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("show l")
            found = options.all_inner_texts()
            place = next(place for place, text in enumerate(found) if text.startswith("Show Library"))
            for _ in range(place):
                page.keyboard.press("ArrowDown")
            page.keyboard.press("Enter")
            expect(page.get_by_role("tab", name="Library")).to_have_attribute("aria-selected", "true")
            # A panel, by what it is for: nothing is called a jog, since its button has to be held.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("jog")
            expect(options.first).to_contain_text("Show Pendant")
            page.keyboard.press("Escape")
            # One of a choice, by what it is about; what it means is told where the pointer rests.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("notation quat")
            expect(options.first).to_contain_text("Notation of rotations: Quat")
            page.keyboard.press("Enter")
            quaternions = page.get_by_role("radio", name="Quat")
            expect(quaternions).to_be_checked()
            expect(quaternions).to_have_attribute("title", "Unit quaternion x, y, z, w")
            # Nothing of that name; Esc leaves all as it is.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("warp drive")
            expect(page.get_by_text("Nothing here is called so.")).to_be_visible()
            page.keyboard.press("Escape")
            expect(field).to_be_hidden()
            # STOP is a command as well, and works.
            page.keyboard.press("Control+k")
            expect(field).to_be_focused()
            page.keyboard.type("stops all robots")
            page.keyboard.press("Enter")
            until(lambda: client.cell.stopped is not None)
            client.cell.release()
