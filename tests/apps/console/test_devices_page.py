"""A person leads robots at the console's page by a space mouse and a gamepad, as a mapping says, while one is held."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Locator, Page, expect
from virtualrobot import Client, Robot

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.test_drive_page import PLUG
from tests.kernels import KernelProcess, Stubs
from tests.space_mice import INFO, motion, pressed, rotation, translation
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
TICK_SECONDS = 0.004
SPEED, TURN = 0.3 * 0.25, 0.3 * 0.8
"""Speeds (m/s and rad/s) of a whole axis: the part that the page begins with, of the greatest speeds of jogs."""

HID = """(about) => {
  class Device extends EventTarget {
    productName = about.product_string; vendorId = about.vendor_id; productId = about.product_id; opened = false;
    collections = [{ usagePage: about.usage_page, usage: about.usage }];
    async open() { this.opened = true; }
  }
  class Hid extends EventTarget {
    device = new Device(); granted = false;
    async getDevices() { return this.granted ? [this.device] : []; }
    async requestDevice({ filters }) {
      this.granted = filters.some(({ vendorId, usagePage, usage }) =>
        vendorId === about.vendor_id && usagePage === about.usage_page && usage === about.usage);
      return this.getDevices();
    }
    report([reportId, ...bytes]) {
      const data = new DataView(new Uint8Array(bytes).buffer);
      this.device.dispatchEvent(Object.assign(new Event("inputreport"), { reportId, data }));
    }
    tell(what) { this.dispatchEvent(Object.assign(new Event(what), { device: this.device })); }
  }
  Object.defineProperty(navigator, "hid", { value: new Hid() });
}"""
"""WebHID with one space mouse, as the browser would have it; a person who is asked takes it."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@contextmanager
def leading(browser: Browser, console: Console, client: Client) -> Iterator[tuple[Page, Robot, Locator]]:
    """Give a page whose pendant is that of an arm, the arm, and the page's panel of devices."""
    arm = client.load_robot(IIWA, name="arm")
    arm.set_positions(HERE)
    with opened(browser, console.url + PLAIN) as page:
        about = {name: value for name, value in INFO.items() if name != "path"}
        page.add_init_script(f"({HID})({json.dumps(about)})")
        page.reload()
        row(page, "arm").click()
        page.get_by_role("button", name="Gamepad and space mouse").click()
        panel = page.get_by_role("region", name="Gamepad and space mouse")
        expect(panel).to_be_visible()
        yield page, arm, panel


def report(page: Page, *reports: bytes) -> None:
    """Have the space mouse report."""
    for one in reports:
        page.evaluate("(bytes) => navigator.hid.report(bytes)", list(one))


def tick(page: Page, stubs: Stubs) -> None:
    """Let a tick go by, with time for the page."""
    page.evaluate("0")
    step(stubs, 1)


def rests(page: Page, stubs: Stubs, robot: str = "arm") -> bool:
    tick(page, stubs)
    now = state(stubs, robot)
    return not any(now.velocities) and not now.motion_ids


def stays(page: Page, stubs: Stubs, robot: str = "arm") -> bool:
    """Return whether a robot rests as long as a page would take to lead it: it looks at devices 20 times a second."""
    page.evaluate("() => new Promise((done) => setTimeout(done, 150))")
    return all(rests(page, stubs, robot) for _ in range(10))


def twists(page: Page, stubs: Stubs, arm: Robot) -> Callable[[], np.ndarray]:
    """Return a function that lets a tick go by and returns how the tool moves: m/s, and sines of turns in rad/s."""
    last = [arm.tcp]

    def twist() -> np.ndarray:
        tick(page, stubs)
        last.append(arm.tcp)
        turn = last[-1][:3, :3] @ last[-2][:3, :3].T
        sines = (turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
        return np.array([*(last[-1] - last[-2])[:3, 3], *(0.5 * np.array(sines))]) / TICK_SECONDS

    return twist


def test_a_space_mouse_leads_the_tool_while_its_button_is_held(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        leading(browser, console, client) as (page, arm, panel),
    ):
        # The browser asks which one; then the pendant says what has to be held.
        mouse = panel.get_by_role("region", name="Space mouse", exact=True)
        expect(mouse.get_by_role("status")).to_have_text("none: connect it")
        mouse.get_by_role("button", name="Connect").click()
        expect(mouse.get_by_role("status")).to_have_text("SpaceMouse Compact")
        expect(page.locator("#pendant")).to_contain_text("SpaceMouse Compact: hold left")
        twist = twists(page, stepped, arm)
        report(page, translation(0, -350, 0))  # away from the hand, without the dead man's button
        assert stays(page, stepped)

        # The usual mapping looks at the arm from behind: away is ahead. Within the dead zone of a tenth nothing turns.
        report(page, pressed(0b1), rotation(0, 0, 34))
        until(lambda: np.allclose(twist(), [SPEED, 0, 0, 0, 0, 0], atol=1e-4))
        # Half of the way beyond the dead zone, of a device that tells all axes together; about z it turns to the right.
        report(page, motion(0, 0, 0, 0, 0, 193))
        until(lambda: np.allclose(twist(), [0, 0, 0, 0, 0, -0.5 * TURN], atol=1e-3))
        # Two axes at once are no faster than one.
        report(page, motion(350, 350, 0, 0, 0, 0))
        until(lambda: np.allclose(twist(), [-SPEED / np.sqrt(2), -SPEED / np.sqrt(2), 0, 0, 0, 0], atol=1e-4))
        report(page, pressed(0))
        until(lambda: rests(page, stepped))

        # The right button makes it slower by a tenth.
        report(page, pressed(0b10))
        expect(mouse).to_contain_text("Speed 90 %")
        report(page, translation(350, 0, 0), pressed(0b1))
        until(lambda: np.allclose(twist(), [0, -0.9 * SPEED, 0, 0, 0, 0], atol=1e-4))
        report(page, b"\x01\x05", b"\x17\x64")  # one that is too short, and one of the battery, tell nothing
        until(lambda: np.allclose(twist(), [0, -0.9 * SPEED, 0, 0, 0, 0], atol=1e-4))

        # A window that is left lets go, whatever the device tells meanwhile, until its button is pressed anew.
        page.evaluate("() => { document.hasFocus = () => false; dispatchEvent(new Event('blur')); }")
        until(lambda: rests(page, stepped))
        report(page, translation(350, 0, 0), pressed(0b1))
        assert stays(page, stepped)
        page.evaluate("() => { delete document.hasFocus; }")
        assert stays(page, stepped)
        report(page, pressed(0))
        assert stays(page, stepped)
        report(page, pressed(0b1))
        until(lambda: twist()[1] < -0.8 * SPEED)

        # Pulled out it lets go; plugged in again it is known.
        page.evaluate("() => navigator.hid.tell('disconnect')")
        until(lambda: rests(page, stepped))
        expect(mouse.get_by_role("status")).to_have_text("none: connect it")
        page.evaluate("() => navigator.hid.tell('connect')")
        expect(mouse.get_by_role("status")).to_have_text("SpaceMouse Compact")
        assert stays(page, stepped)


def test_mappings_are_files_and_no_robot_moves_by_surprise(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser, tmp_path: Path
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        leading(browser, console, client) as (page, arm, panel),
    ):
        other = client.load_robot(IIWA, name="other", pose=virtualrobot.pose(y=2.0))
        other.set_positions(HERE)
        mouse = panel.get_by_role("region", name="Space mouse", exact=True)
        mouse.get_by_role("button", name="Connect").click()
        expect(page.locator("#pendant")).to_contain_text("hold left")

        # A file that makes no sense is refused by its place, and the usual mapping stays.
        file = tmp_path / "mine.yaml"
        file.write_text("schema_version: 1\nhold: right\ntool: {vx: left_x}\n")
        field = page.get_by_label("Mapping of the space mouse to open")
        field.set_input_files(file)
        expect(page.locator("#last")).to_contain_text("mine.yaml: tool.vx is 'left_x'; it must be an axis, such as -y")
        expect(mouse).to_contain_text("usual mapping")

        # One along the tool's own axes, by the other button.
        file.write_text("schema_version: 1\nhold: right\ndead_zone: 0\ntool: {vz: -z}\nframe: tool\n")
        field.set_input_files(file)
        expect(mouse).to_contain_text("mine.yaml")
        expect(page.locator("#pendant")).to_contain_text("hold right")
        twist = twists(page, stepped, arm)
        report(page, translation(0, 0, 350), pressed(0b10))
        until(lambda: np.allclose(twist()[:3], -SPEED * arm.tcp[:3, 2], atol=1e-3))

        # Another robot that is chosen meanwhile isn't led before the button was let go.
        row(page, "other").click()
        until(lambda: rests(page, stepped))
        assert stays(page, stepped, "other")
        report(page, pressed(0))
        assert stays(page, stepped, "other")
        report(page, pressed(0b10))
        until(lambda: not rests(page, stepped, "other"))
        report(page, pressed(0))
        until(lambda: rests(page, stepped, "other"))

        # A mapping of joints, one of which this robot hasn't: nothing is led, which is said.
        file.write_text("schema_version: 1\nhold: left\njog: {9: x}\n")
        field.set_input_files(file)
        expect(page.locator("#pendant")).to_contain_text("hold left")
        report(page, pressed(0b1))
        expect(page.locator("#last")).to_contain_text("the mapping of the space mouse moves nothing of other")
        report(page, pressed(0))
        mouse.get_by_role("button", name="Usual one").click()
        expect(mouse).to_contain_text("usual mapping")

        # A gamepad moves joints, as the command line's usual mapping has them.
        page.evaluate(PLUG)
        expect(page.locator("#pendant")).to_contain_text("Test pad: hold right shoulder")
        row(page, "arm").click()
        before = arm.positions.copy()
        page.evaluate("() => { pad.axes[0] = -1; pad.axes[1] = 0.575; }")
        assert stays(page, stepped)
        page.evaluate("() => { pad.buttons[5].pressed = true; }")

        def velocities() -> np.ndarray:
            tick(page, stepped)
            return np.array(state(stepped, "arm").velocities)

        # The second stick's way is half beyond the dead zone of 0.15, towards the hand.
        until(lambda: np.allclose(velocities(), [TURN, -0.5 * TURN, 0, 0, 0, 0, 0], atol=1e-6))
        page.evaluate("() => { pad.connected = false; }")
        until(lambda: rests(page, stepped))
        assert arm.positions[0] > before[0]


def test_the_space_mouse_moves_the_view_and_the_keyboard_joints(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        leading(browser, console, client) as (page, _, panel),
    ):

        def looks() -> tuple[np.ndarray, np.ndarray]:
            """Return from where the page looks and at what, as it makes that the view of all."""
            client.view.set_camera([0.0, 0.0, 99.0])
            page.locator("#views").get_by_role("button", name="Set from here").click()
            until(lambda: client.view.read().camera_position[2] < 99.0)
            now = client.view.read()
            return now.camera_position, now.camera_target

        panel.get_by_role("region", name="Space mouse", exact=True).get_by_role("button", name="Connect").click()
        expect(page.locator("#pendant")).to_contain_text("hold left")
        page.get_by_role("tab", name="Views", exact=True).click()
        client.view.set_camera([0.0, -3.0, 0.5], [0.0, 0.0, 0.5])
        page.locator("#views").get_by_role("button", name="Look as they do").click()

        # Towards the hand: nearer, and nothing of the arm moves; turned clockwise its left comes to the front.
        report(page, translation(0, 350, 0))
        until(lambda: np.linalg.norm(np.subtract(*looks())) < 2.0)
        report(page, translation(0, 0, 0), rotation(0, 0, 350))
        until(lambda: looks()[0][0] > 0.5)
        report(page, rotation(0, 0, 0))
        assert stays(page, stepped)
        np.testing.assert_allclose(looks()[1], [0.0, 0.0, 0.5], atol=1e-6)

        # Keys lead joints once they are to, while Shift is held.
        page.get_by_role("tab", name="Pendant").click()
        keyboard = page.keyboard
        page.locator(".view .canvas canvas").focus()
        keyboard.down("Shift")
        keyboard.down("Digit2")
        assert stays(page, stepped)
        keyboard.up("Digit2")
        keyboard.up("Shift")
        panel.get_by_role("region", name="Keyboard").get_by_role("button", name="Use it").click()
        expect(page.locator("#pendant")).to_contain_text("keyboard: hold shift")
        page.locator(".view .canvas canvas").focus()
        keyboard.down("Shift")
        keyboard.down("Digit2")

        def velocities() -> np.ndarray:
            tick(page, stepped)
            return np.array(state(stepped, "arm").velocities)

        until(lambda: np.allclose(velocities(), [0, TURN, 0, 0, 0, 0, 0], atol=1e-6))
        keyboard.up("Digit2")
        keyboard.down("KeyQ")
        until(lambda: np.allclose(velocities(), [-TURN, 0, 0, 0, 0, 0, 0], atol=1e-6))
        keyboard.up("Shift")
        until(lambda: rests(page, stepped))
        keyboard.up("KeyQ")
