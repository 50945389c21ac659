"""Words and looks of the console's page: units, numbers that are none, who somebody is, order of the tree, theme."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Page, expect

from tests.api.asking import IIWA, joints, start
from tests.api.reading import step
from tests.apps.console.browsing import PLAIN, PURPLE, browsers, hold, needs_page, opened, purple_count, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import repeated, until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


def add_step(page: Page, label: str) -> None:
    page.get_by_label("Add a step").select_option(label=label)


def test_a_program_is_told_of_as_its_list_counts_and_goes_back_to_before_play(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        arm = client.load_robot(IIWA, name="iiwa")
        arm.set_positions(HERE)
        client.signals.create("lamp")
        with opened(browser, console.url + PLAIN) as page, repeated(lambda: step(stepped, 20)):
            row(page, "iiwa").click()
            page.get_by_role("tab", name="Program").click()
            page.get_by_label("Teach PTP").click()
            expect(row(page, "P1")).to_be_visible()
            arm.set_positions((0.3, *HERE[1:]))
            add_step(page, "Set lamp")
            page.get_by_label("Value of lamp").get_by_role("radio", name="on").click()
            steps = page.get_by_label("Steps", exact=True).get_by_role("listitem")
            expect(steps).to_have_count(2)

            # To the end, says the last line; then all is as it was before.
            page.locator("#play").click()
            expect(page.locator("#last")).to_have_text("the program is done")
            assert client.signals["lamp"] is True
            np.testing.assert_allclose(arm.positions, HERE, atol=1e-3)
            page.get_by_role("button", name="Back to before Play").click()
            expect(page.locator("#last")).to_have_text("the cell is as it was before Play")
            np.testing.assert_allclose(arm.positions, (0.3, *HERE[1:]), atol=1e-6)
            assert client.signals["lamp"] is False

            # Of two plays each can be gone back to, the last one first: the second one may have found no part to pick.
            back = page.get_by_role("button", name="Back to before Play")
            for plays in (2, 3):
                page.locator("#play").click()
                page.get_by_role("tab", name="Messages").click()
                expect(page.get_by_label("What happens").get_by_text("the program is done")).to_have_count(plays)
                page.get_by_role("tab", name="Program").click()
            back.click()
            expect(page.locator("#last")).to_have_text("the cell is as it was before Play")
            assert client.signals["lamp"] is True
            back.click()
            until(lambda: client.signals["lamp"] is False)
            np.testing.assert_allclose(arm.positions, (0.3, *HERE[1:]), atol=1e-6)
            expect(back).to_have_count(0)

            # An edit after Play would go with it: then it isn't offered.
            page.locator("#play").click()
            expect(page.get_by_role("button", name="Back to before Play")).to_be_visible()
            client.scene.add_object("crate", virtualrobot.box(0.1, 0.1, 0.1))
            expect(page.get_by_role("button", name="Back to before Play")).to_have_count(0)

            # What is wrong while it runs, and before, is told by the number that the list has: no target, step 3.
            page.get_by_label("Teach LIN").click()
            expect(steps).to_have_count(3)
            client.scene.remove("P2")
            page.locator("#play").click()
            expect(page.locator("#last")).to_contain_text("step 3: ")
            expect(steps.nth(2)).to_contain_text("P2")


def test_lengths_of_refusals_are_millimeters(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="iiwa").set_positions(HERE)
        with opened(browser, console.url + PLAIN) as page:
            row(page, "iiwa").click()
            # 9 m are far beyond an arm of about 1.3 m (KUKA's data sheet of the LBR iiwa 14 R820).
            field = page.locator("#pendant").get_by_label("X", exact=True)
            field.fill("9000")
            field.press("Enter")
            postures = page.get_by_label("Postures", exact=True)
            expect(postures).to_contain_text("Out of reach")
            words = postures.locator(".hint").inner_text()
            assert not re.search(r"\de[+-]\d|\d m\b| rad\b|degrees", words), words


def test_a_number_that_is_none_stays_red_and_says_why(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.scene.add_object("crate", virtualrobot.box(0.1, 0.1, 0.1))
        with opened(browser, console.url + PLAIN) as page:
            row(page, "crate").click()
            page.get_by_role("tab", name="Properties").click()
            field = page.locator("#properties").get_by_label("X", exact=True)
            why = page.locator("#why")
            for text, words in (("1.234,5", "write 1234.5"), ("abc", "“abc” is no number"), ("", "Write a number")):
                field.fill(text)
                field.press("Enter")
                expect(field).to_have_attribute("aria-invalid", "true")
                expect(why).to_contain_text(words)
                field.press("Tab")
                expect(field).to_have_value(text)
                expect(field).to_have_attribute("aria-invalid", "true")
            field.press("Escape")
            expect(field).to_have_value("0.00")
            expect(why).to_have_count(0)
            field.fill("1234,5")
            expect(why).to_have_count(0)
            field.press("Tab")
            until(lambda: np.isclose(client.scene.pose("crate")[0, 3], 1.2345))

            # What is wrong belongs to its node: another one has its own number.
            field.fill("x")
            field.press("Tab")
            row(page, "world").click()
            row(page, "crate").click()
            expect(field).to_have_value("1234.50")

            page.get_by_role("button", name="Add …").click()
            page.get_by_label("Height", exact=True).fill("0")
            expect(why).to_have_text("Height is more than 0")
            page.get_by_label("Height", exact=True).press("Escape")
            expect(why).to_have_count(0)


def test_who_else_moves_the_robot_is_named(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="arm").set_positions(HERE)
        with opened(browser, console.url + PLAIN) as one, opened(browser, console.url + PLAIN) as other:
            for page in (one, other):
                row(page, "arm").click()
            one.bring_to_front()
            with repeated(lambda: step(stepped, 1), 0.02):
                hold(one, "Z minus")
                expect(other.locator("#mover")).to_have_text("a page of the console")
                expect(other.locator("#pendant")).to_contain_text("Somebody else moves arm (a page of the console).")
                expect(one.locator("#motion")).to_have_text("running")
                expect(one.locator("#mover")).to_have_count(0)
                one.mouse.up()
                expect(other.locator("#mover")).to_have_count(0)

            # A program's motion is another one's for both, and stopped by one it says by whom to each.
            start(stepped, joints("arm", 0.05, lbr_iiwa_joint_1=1.0))
            step(stepped, 5)
            for page in (one, other):
                expect(page.locator("#mover")).to_be_visible()
            one.locator("#stop").click()
            with repeated(lambda: step(stepped, 1), 0.02):
                expect(one.locator("#stopped")).to_contain_text("Stopped by you at ")
                expect(other.locator("#stopped")).to_contain_text("Stopped by a page of the console at ")
                expect(one.locator("#stopped")).to_contain_text("press Release to go on")
            one.locator("#release").click()
            expect(other.locator("#stopped")).to_have_count(0)


def test_what_comes_back_has_its_place_in_the_tree(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        for name in ("one", "two", "three"):
            client.scene.add_object(name, virtualrobot.box(0.1, 0.1, 0.1))
        with opened(browser, console.url + PLAIN) as page:
            names = page.get_by_role("tree").get_by_role("treeitem")
            expect(names).to_have_text(["world", "one", "two", "three"])
            client.scene.remove("two")
            expect(names).to_have_text(["world", "one", "three"])
            page.get_by_title("Undo (Ctrl-Z)").click()
            expect(names).to_have_text(["world", "one", "two", "three"])


def test_numbers_of_a_ghost_are_told_from_the_robots(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="iiwa").set_positions(HERE)
        with opened(browser, console.url + PLAIN) as page:
            row(page, "iiwa").click()
            rows = page.get_by_role("region", name="Joints", exact=True)
            field = rows.get_by_label("J2 lbr_iiwa_joint_2 position", exact=True)
            expect(field).to_have_value("28.6")  # 0.5 rad
            field.fill("40")
            field.press("Enter")
            expect(rows.get_by_role("heading")).to_have_text("Joints of the ghost")
            expect(field.locator("..")).to_have_attribute("title", re.compile("the robot has it at 28.6, °"))
            page.get_by_title("Drop the ghost (Esc)").click()
            expect(rows.get_by_role("heading")).to_have_text("Joints")
            expect(field).to_have_value("28.6")


def test_help_is_where_a_person_is_and_the_view_goes_by_keys(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.scene.add_object("slab", virtualrobot.box(0.4, 0.1, 0.4, color=PURPLE))
        client.scene.add_object("shelf")
        with opened(browser, console.url + PLAIN) as page:
            help_ = page.get_by_role("dialog", name="Help")
            row(page, "slab").click()
            page.keyboard.press("F1")
            expect(help_.get_by_role("heading")).to_have_text("Scene")
            page.keyboard.press("Escape")
            expect(help_).to_have_count(0)
            expect(page.get_by_role("tree")).to_be_focused()
            page.get_by_role("tab", name="Modeller").click()
            page.locator("#help").click()
            expect(help_.get_by_role("heading")).to_have_text("Modeller")
            page.keyboard.press("F1")
            expect(help_).to_have_count(0)

            page.get_by_role("tab", name="Modeller").focus()
            page.keyboard.press("ArrowRight")
            expect(page.get_by_role("tab", name="History")).to_be_focused()
            expect(page.locator("#history")).to_be_visible()

            # From the front the slab is four times as wide as from its side, to which 18 presses of 5 degrees turn.
            page.locator(".view canvas").first.focus()
            for key in ("f", "1"):
                page.keyboard.press(key)
            front = purple_count(page)
            for _ in range(18):
                page.keyboard.press("ArrowRight")
            until(lambda: purple_count(page) < 0.5 * front)
            side = purple_count(page)
            page.keyboard.press("+")
            until(lambda: purple_count(page) > 1.1 * side)
            page.keyboard.press("-")
            for _ in range(20):
                page.keyboard.press("Shift+ArrowRight")
            until(lambda: purple_count(page) == 0)

            # Its name stands where it is, and not where it isn't.
            page.keyboard.press("n")
            name = page.locator(".names").get_by_text("slab")
            page.keyboard.press("f")
            expect(name).to_be_in_viewport()
            page.keyboard.press("n")
            expect(name).to_have_count(0)

            # A node hangs elsewhere by keys.
            page.get_by_role("tab", name="Properties").click()
            parent = page.get_by_label("Parent: what it hangs on; it stays where it is")
            parent.fill("shelf")
            parent.press("Enter")
            until(lambda: client.scene.node("slab").parent == "shelf")


def test_the_page_is_dark_or_light_as_its_system_until_somebody_chooses(
    console: Console, stepped: Stubs, browser: Browser
) -> None:
    with opened(browser, console.url + PLAIN) as page:
        root = page.locator("html")
        expect(root).to_have_attribute("data-theme", "dark")
        page.emulate_media(color_scheme="light")
        expect(root).to_have_attribute("data-theme", "light")
        page.get_by_title("Dark theme").click()
        expect(root).to_have_attribute("data-theme", "dark")
        page.reload()
        expect(root).to_have_attribute("data-theme", "dark")
