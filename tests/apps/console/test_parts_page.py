"""A person picks and places at the console's page, by clicking; the kernel is asked each time."""

from __future__ import annotations

import re

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import expect

from tests.api.asking import IIWA
from tests.api.reading import scene, step
from tests.apps.console.browsing import PLAIN, browsers, color_count, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
BEYOND = (0xE5, 0x39, 0x3F)
AWAY_METERS = 0.25
"""Distance of a part from the tool centre point: more than the 0.2 m in which the kernel picks the nearest one."""


def test_a_person_picks_and_places(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    def parents() -> dict[str, str]:
        return {node.name: node.parent for node in client.scene.nodes()}

    with virtualrobot.connect(stepped_kernel.address) as client, browsers() as browser:
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions(HERE)
        client.scene.add_tool("cup", arm.flange, tool_center_points={"tip": virtualrobot.pose(z=0.1)})
        there = np.array(arm.tcp)
        there[1, 3] += AWAY_METERS
        client.scene.add_part("brick", virtualrobot.box(0.05, 0.05, 0.05), pose=virtualrobot.pose(*there[:3, 3]))
        client.scene.add_part("other", virtualrobot.box(0.05, 0.05, 0.05), pose=virtualrobot.pose(x=-1.0))
        client.scene.add_object("table", virtualrobot.box(0.4, 0.4, 0.02), pose=virtualrobot.pose(y=-1.0))
        with opened(browser, console.url + PLAIN, 1280, 720) as page:
            page.get_by_role("tab", name="Parts", exact=True).click()
            panel = page.locator("#parts")
            said = panel.get_by_role("alert")
            expect(panel.get_by_label("Tool that holds parts")).to_have_value("cup")

            # The nearest part comes first; it is too far to be picked, says the kernel, too, and nothing has changed.
            listed = panel.get_by_role("list", name="Parts by distance").get_by_role("listitem")
            expect(listed.nth(0)).to_contain_text("brick")
            expect(listed.nth(0)).to_contain_text("250.0 mm")
            panel.get_by_role("button", name="Pick nearest").click()
            expect(said).to_contain_text("the part 'brick' is 250 mm from the tool centre point")
            listed.nth(0).get_by_role("button").press("Enter")
            expect(row(page, "brick")).to_have_attribute("aria-selected", "true")
            chosen = panel.get_by_label("Chosen part")
            expect(chosen).to_contain_text("250.0 mm")
            expect(panel.get_by_label("Parts", exact=True)).to_be_in_viewport(ratio=1.0)
            until(lambda: color_count(page, BEYOND) > 20)  # the way there, red since it is too far
            expect(page.locator("#reach")).to_have_class(re.compile("primary"))
            expect(page.locator("#pick")).not_to_have_class(re.compile("primary"))
            chosen.get_by_role("button", name="Pick", exact=True).click()
            expect(said).to_contain_text("farther than 200 mm")
            assert parents()["brick"] == "world"

            # A robot that works with no tool can't pick.
            panel.get_by_label("Tool that holds parts").select_option(label="no tool")
            expect(panel.get_by_text("iiwa works with no tool")).to_be_visible()
            panel.get_by_role("button", name="Pick nearest").click()
            expect(said).to_contain_text("works with no tool")
            panel.get_by_label("Tool that holds parts").select_option(label="cup")
            expect(said).to_have_count(0)

            # The ghost reaches it, the robot goes there, and picks: the part goes along then, and undo takes it back.
            chosen.get_by_role("button", name="Reach").click()
            page.locator("#go").click()

            def arrived() -> bool:
                step(stepped, 20)
                return bool(np.allclose(arm.tcp[:3, 3], there[:3, 3], atol=1e-4))

            until(arrived)
            expect(chosen).to_contain_text(re.compile(r"(?<!\d)0\.0 mm"))
            chosen.get_by_role("button", name="Pick", exact=True).click()
            expect(panel.get_by_label("brick, held")).to_be_visible()
            assert parents()["brick"] == "cup"
            expect(chosen).to_have_count(0)
            page.get_by_title("Undo (Ctrl-Z)").click()
            expect(panel.get_by_label("brick, held")).to_have_count(0)
            assert parents()["brick"] == "world"
            panel.get_by_role("button", name="Pick nearest").click()
            expect(panel.get_by_label("brick, held")).to_be_visible()
            arm.set_positions([-1.2, *HERE[1:]])
            held = arm.tcp[:3, 3]
            np.testing.assert_allclose(scene(stepped)["brick"][:3, 3], held, atol=1e-3)

            # Placed on what there isn't: refused; then on the table, where it stays.
            on = panel.get_by_label("What parts are placed on")
            on.fill("tabel")
            on.press("Enter")
            panel.get_by_role("button", name="Place", exact=True).click()
            expect(said).to_contain_text("tabel")
            assert parents()["brick"] == "cup"
            row(page, "table").click()
            panel.get_by_title("The selected node: table").click()
            expect(on).to_have_value("table")
            panel.get_by_role("button", name="Place", exact=True).press("Enter")
            expect(panel.get_by_label("brick, held")).to_have_count(0)
            assert parents()["brick"] == "table"
            np.testing.assert_allclose(scene(stepped)["brick"][:3, 3], held, atol=1e-3)

            # What may be picked from how far is said here: the other one is over a meter away.
            within = panel.get_by_label("Farthest that the origin")
            within.fill("5000")
            within.press("Enter")
            listed.filter(has_text="other").get_by_role("button").click()
            chosen.get_by_role("button", name="Pick", exact=True).click()
            expect(panel.get_by_label("other, held")).to_be_visible()
            assert parents()["other"] == "cup"
