"""A person at the console's page: selects, renames, jogs, moves, stops; the kernel is asked each time."""

from __future__ import annotations

import re

import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot.v1 import driver_pb2, motion_pb2
from virtualrobot_apps.demos.palletizing import cell

from tests.api.asking import IIWA, joints, load, start
from tests.api.moving import READY
from tests.api.reading import scene, state, step
from tests.apps.console.browsing import PLAIN, browsers, hold, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]


LINES = """(canvas, color) => {
  const { width, height } = document.querySelector(canvas);
  const { data } = document.querySelector(canvas).getContext("2d").getImageData(0, 0, width, height);
  let count = 0;
  const isClose = (at) => color.every((part, place) => Math.abs(data[at + place] - part) < 48);
  for (let at = 0; at < data.length; at += 4) count += isClose(at);
  return count > width / 4;
}"""
"""Question in JavaScript: whether a canvas has a line of about this color, as its edges are softened, across it."""

WITHIN = """(parts, whole) => {
  const box = document.querySelector(whole).getBoundingClientRect();
  return [...document.querySelectorAll(parts)].every((part) => {
    const { top, bottom, left, right } = part.getBoundingClientRect();
    return top >= box.top && bottom <= box.bottom + 0.5 && left >= box.left && right <= box.right + 0.5;
  });
}"""
"""Question in JavaScript: whether all elements of a kind are within another one, none of them scrolled out of sight."""


def ended(stubs: Stubs) -> motion_pb2.Motion:
    """Return the last motion when it has ended; time goes on meanwhile."""

    def last() -> motion_pb2.Motion:
        step(stubs, 5)
        return stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions[-1]

    until(lambda: last().end_cause and not last().phase == motion_pb2.MOTION_PHASE_STOPPING)
    return last()


def jog(page: Page, stubs: Stubs, label: str) -> float:
    """Hold a jog's button until joint 1 has moved, let it go, and return where the joint comes to rest."""
    before = state(stubs, "iiwa").positions[0]
    hold(page, label)

    def moved() -> bool:
        step(stubs, 2)
        return abs(state(stubs, "iiwa").positions[0] - before) > 0.01

    until(moved)
    page.mouse.up()
    motion = ended(stubs)
    assert (motion.phase, motion.end_cause) == (motion_pb2.MOTION_PHASE_CANCELLED, motion_pb2.END_CAUSE_CALL)
    return state(stubs, "iiwa").positions[0] - before


def test_a_person_uses_the_demo_cell(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        cell.load(client)
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        # The tree has the cell; a click selects a robot, which the pendant moves then.
        expect(page.locator("#connection")).to_have_text("connected")
        row(page, "iiwa").click()
        expect(row(page, "iiwa")).to_have_attribute("aria-selected", "true")
        expect(page.get_by_label("Robot", exact=True).first).to_have_value("iiwa")

        # A name is changed, and hides what is called so.
        page.get_by_label("Filter scene").fill("cabi")
        expect(page.locator(".node")).to_have_count(1)
        row(page, "cabinet").dblclick()
        page.get_by_label("New name of cabinet").fill("switchboard")
        page.keyboard.press("Enter")
        page.get_by_label("Filter scene").fill("")
        expect(row(page, "switchboard")).to_be_visible()
        assert "switchboard" in scene(stepped) and "cabinet" not in scene(stepped)

        # F2 takes the very next letter, however late the page draws: M would else move nodes, and Space stop robots.
        row(page, "switchboard").click()
        turn_to_field = """async () => {
            document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key: "F2", bubbles: true }));
            for (let turn = 0; turn < 9; turn++) await null;
            return document.activeElement.getAttribute("aria-label");
        }"""
        assert page.evaluate(turn_to_field) == "New name of switchboard"
        page.keyboard.press("Escape")

        # It comes back by one key.
        page.get_by_label("Filter scene").blur()  # in a field for words the key undoes what was written there
        page.keyboard.press("Control+z")
        expect(row(page, "cabinet")).to_be_visible()
        assert "cabinet" in scene(stepped)

        # Jogs move while they are held.
        assert jog(page, stepped, "J1 lbr_iiwa_joint_1 plus") > 0.01
        assert jog(page, stepped, "J1 lbr_iiwa_joint_1 minus") < -0.01
        row(page, "iiwa").click()

        # A slider says where a joint shall go, and STOP ends the way there.
        track = page.get_by_label(re.compile("lbr_iiwa_joint_2, °"))
        box = track.bounding_box()
        assert box
        track.click(position={"x": 0.9 * box["width"], "y": 10})
        page.locator("#go").click()

        def moves() -> bool:
            step(stepped, 2)
            return any(state(stepped, "iiwa").velocities)

        until(moves)
        page.keyboard.press("Space")
        motion = ended(stepped)
        assert (motion.phase, motion.end_cause) == (
            motion_pb2.MOTION_PHASE_CANCELLED,
            motion_pb2.END_CAUSE_CELL_STOPPED,
        )
        assert not any(state(stepped, "iiwa").velocities)

        # It stays stopped, says by whom, and moves nothing before it is released.
        expect(page.locator("#stop")).to_have_text("STOPPED")
        expect(page.locator("#stopped")).to_contain_text("Stopped by you at ")
        page.locator("#go").click()
        expect(page.locator("#last")).to_contain_text("all robots are stopped: press Release")
        page.locator("#release").click()
        expect(page.locator("#stop")).to_have_text("STOP")
        expect(page.locator("#stopped")).to_have_count(0)
        page.locator("#go").click()
        until(moves)


def test_a_stop_of_somebody_else_is_seen_while_the_robot_brakes(console: Console, stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        expect(page.locator("#connection")).to_have_text("connected")
        start(stepped, joints("arm", 0.2, **READY))
        step(stepped, 60)
        stepped.driver.StopCell(driver_pb2.StopCellRequest(reason="a hand"))
        step(stepped, 1)
        expect(page.locator("#stop")).to_have_text("BRAKING")
        expect(page.locator("#release")).to_be_disabled()
        until(lambda: not any(state(stepped, "arm").velocities) or not step(stepped, 5))
        expect(page.locator("#stop")).to_have_text("STOPPED")
        expect(page.locator("#stopped")).to_contain_text(": a hand")
        stepped.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
        expect(page.locator("#stop")).to_have_text("STOP")


def test_all_of_the_pendant_and_the_plot_is_seen_in_low_windows(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    """On a laptop, on a desktop with a browser's bars, and on a tablet; nothing moves, and the plot has lines.

    Signals come last in the pendant: a cell may have any number of them, so they alone are scrolled to.
    """
    with virtualrobot.connect(stepped_kernel.address) as client:
        cell.load(client)
    with browsers() as browser, opened(browser, console.url + PLAIN, 1280, 720) as page:
        row(page, "iiwa").click()
        page.get_by_role("slider", name=re.compile("lbr_iiwa_joint_1, °")).click()
        expect(page.locator("#go")).to_be_visible()
        # The second joint's; four others stand at 0, one above the other.
        page.wait_for_function(f"() => ({LINES})('.plot canvas', [0xff, 0x9e, 0x4a])")
        for width, height in ((1280, 720), (1456, 819), (1024, 768)):
            page.set_viewport_size({"width": width, "height": height})
            pendant = '#pendant > section:not([aria-label="Signals of the cell"])'
            for parts, whole in ((".series", ".legend"), (pendant, "#pendant")):
                page.wait_for_function(f"() => ({WITHIN})('{parts}', '{whole}')")
            expect(page.locator(".series")).to_have_count(7)
            expect(page.get_by_label("Tools")).to_be_in_viewport(ratio=1.0)


def test_a_phone_has_all_one_under_the_other(console: Console, stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    with browsers() as browser, opened(browser, console.url + PLAIN, 390, 844) as page:
        expect(page.locator("#connection")).to_have_text("connected")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        stop = page.locator("#stop")
        top = [page.get_by_title(title) for title in ("Open a scene", "Undo (Ctrl-Z)")]
        for part in (*top, page.locator("#save"), page.locator("#time"), page.get_by_label("Speed of all robots, %")):
            expect(part).to_be_in_viewport(ratio=1.0)
        tab = page.get_by_role("tab", name="Messages")
        tab.click()
        expect(tab).to_have_attribute("aria-selected", "true")
        expect(tab).to_be_in_viewport(ratio=1.0)
        for part in (page.get_by_label("J7 lbr_iiwa_joint_7 plus"), row(page, "arm")):
            part.scroll_into_view_if_needed()
            expect(part).to_be_in_viewport(ratio=1.0)
            expect(stop).to_be_in_viewport(ratio=1.0)
        row(page, "arm").click()
        expect(row(page, "arm")).to_have_attribute("aria-selected", "true")
        expect(page.locator(".view .canvas canvas")).to_be_in_viewport(ratio=0.95)  # though the tree is far below
        stop.click()
        expect(page.locator("#stopped")).to_be_visible()
        assert stepped.driver.GetDrivers(driver_pb2.GetDriversRequest()).cell.stopped
        stepped.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
