"""A person drives a craft at the console's page: by keys, buttons and a gamepad, and whatever ends that stops it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot.v1 import motion_pb2

from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, hold, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HANG = "() => { setTimeout(() => { for (;;); }, 0); }"
PLUG = """() => {
  window.pad = { id: "Test pad", connected: true, mapping: "standard", axes: [0, 0, 0, 0],
                 buttons: Array.from({ length: 17 }, () => ({ pressed: false, value: 0 })) };
  navigator.getGamepads = () => [null, window.pad];
}"""
"""A gamepad at the browser's border: what its Gamepad API would tell of one in the standard layout."""
TICKS_IN_TIME = 75
"""Ticks of 4 ms in 0.3 s: the 0.2 s after which the kernel brakes, and what a page still sends before it hangs."""


@contextmanager
def driving(console: Console, kernel: KernelProcess) -> Iterator[Page]:
    """Give a page whose pendant is that of a UGV."""
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot("model://ugv", base="planar")
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        row(page, "ugv").click()
        expect(page.get_by_label("Drive by keys")).to_be_visible()
        yield page


def speed(stubs: Stubs) -> np.ndarray:
    """Let a tick go by and return the velocities of the base: x, y (m/s) and heading (rad/s)."""
    step(stubs, 1)
    return np.array(state(stubs, "ugv").velocities[:3])


def place(stubs: Stubs) -> np.ndarray:
    return np.array(state(stubs, "ugv").positions[:3])


def rests(stubs: Stubs) -> bool:
    return not speed(stubs).any() and not state(stubs, "ugv").motion_ids


def last_motion(stubs: Stubs) -> motion_pb2.Motion:
    return stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions[-1]


def test_keys_drive_while_they_are_held(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with driving(console, stepped_kernel) as page:
        page.get_by_label("Drive by keys").focus()
        page.keyboard.down("w")
        until(lambda: abs(speed(stepped)[0] - 0.3) < 1e-6)  # the limit that is set
        expect(page.locator("#driven")).to_contain_text("0.30 m/s")
        page.keyboard.down("ArrowLeft")
        until(lambda: abs(speed(stepped)[2] - 0.6) < 1e-6)
        page.keyboard.up("w")
        page.keyboard.up("ArrowLeft")
        until(lambda: rests(stepped))
        assert last_motion(stepped).phase == motion_pb2.MOTION_PHASE_SUCCEEDED
        x, _, heading = place(stepped)
        assert x > 0.01 and heading > 0.01

        # A slower limit counts at once, Space stops the cell, and what is held on drives no more.
        page.get_by_label("Greatest speed, m/s").fill("0.1")
        page.keyboard.press("Tab")
        page.get_by_label("Drive by keys").focus()
        page.keyboard.down("s")
        until(lambda: speed(stepped) @ [np.cos(heading), np.sin(heading), 0.0] < -0.09)
        assert np.hypot(*speed(stepped)[:2]) <= 0.1 + 1e-9
        page.keyboard.press("Space")
        until(lambda: rests(stepped))
        assert last_motion(stepped).end_cause == motion_pb2.END_CAUSE_CELL_STOPPED
        page.locator("#release").click()
        expect(page.locator("#stop")).to_have_text("STOP")
        assert rests(stepped)
        page.keyboard.up("s")


def test_buttons_and_a_gamepad_drive_while_they_are_held(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    with driving(console, stepped_kernel) as page:
        hold(page, "Turn left")
        until(lambda: speed(stepped)[2] > 0.5)
        page.mouse.up()
        until(lambda: rests(stepped))

        page.evaluate(PLUG)
        expect(page.locator("#pendant")).to_contain_text("Test pad: hold right shoulder")
        page.evaluate("() => { pad.axes[1] = -1; }")  # without the dead man's button
        step(stepped, 50)
        assert rests(stepped)
        page.evaluate("() => { pad.buttons[5].pressed = true; }")
        until(lambda: np.hypot(*speed(stepped)[:2]) > 0.29)
        page.evaluate("() => { pad.buttons[5].pressed = false; }")
        until(lambda: rests(stepped))
        page.evaluate("() => { pad.axes[1] = 0; pad.axes[2] = 0.575; pad.buttons[5].pressed = true; }")
        until(lambda: abs(speed(stepped)[2] + 0.3) < 1e-6)  # half of the way beyond the dead zone, to the right
        page.evaluate("() => { pad.connected = false; }")
        until(lambda: rests(stepped))


def hang(page: Page) -> None:
    page.evaluate(HANG)


def kill(page: Page) -> None:
    page.close()


@pytest.mark.parametrize("end", [hang, kill])
def test_a_page_that_ends_stops_what_it_drives(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, end: Callable[[Page], None]
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot("model://ugv", base="planar")
    with browsers() as browser:
        page = browser.new_page(viewport={"width": 1100, "height": 700})
        page.goto(console.url + PLAIN)
        row(page, "ugv").click()
        hold(page, "Ahead")
        until(lambda: abs(speed(stepped)[0] - 0.3) < 1e-6)
        end(page)
        ticks = 0
        while speed(stepped)[0] > 0.299:
            ticks += 1
            assert ticks <= TICKS_IN_TIME
        until(lambda: rests(stepped))
    assert last_motion(stepped).phase != motion_pb2.MOTION_PHASE_SUCCEEDED


def test_a_twist_that_the_craft_never_has_is_refused_in_words(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    with driving(console, stepped_kernel) as page:
        page.get_by_label("Drive by keys").focus()
        page.keyboard.down("q")  # to the side, on two wheels
        expect(page.locator("#last")).to_contain_text("cannot move to the side, at 300 mm/s")
        assert rests(stepped)
        page.keyboard.up("q")
        page.keyboard.down("w")
        until(lambda: speed(stepped)[0] > 0.1)
        page.keyboard.up("w")
        until(lambda: rests(stepped))


def test_only_crafts_are_driven(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot("model://ar_manipulator", name="arm")
        client.load_robot("model://remus100", name="auv")
        client.scene.set_craft("auv", "fossen", {"vehicle": "remus100"}, surface=10.0)
    with browsers() as browser, opened(browser, console.url + PLAIN) as page:
        for name in ("arm", "auv"):
            row(page, name).click()
            expect(page.get_by_label("Robot", exact=True).first).to_have_value(name)
            expect(page.get_by_label("Drive by keys")).to_have_count(0)
