"""Pages that hang, are killed, may not come in, or lose their kernel; and names that look like HTML."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import virtualrobot
from playwright.sync_api import Page, expect
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, apply, box, create, load
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, hold, needs_page, opened, row
from tests.apps.console.consoles import Console, consoles
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.waiting import until

HANG = "() => { setTimeout(() => { for (;;); }, 0); }"
DARK = """{
  const { fetch, WebSocket } = window;
  window.fetch = (...asked) => (window.dark ? new Promise(() => {}) : fetch(...asked));
  window.WebSocket = class extends WebSocket {
    send(frame) { if (!window.dark) super.send(frame); }
  };
  for (const name of ["onopen", "onmessage", "onclose"]) {
    Object.defineProperty(window.WebSocket.prototype, name, {
      get() { return this[`_${name}`]; },
      set(hear) {
        this[`_${name}`] = hear;
        const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, name);
        const tell = (event) => (window.dark ? setTimeout(tell, 100, event) : this[`_${name}`]?.(event));
        set.call(this, tell);
      },
    });
  }
}"""
"""Has the network carry nothing while `window.dark` is true, and say nothing of it, as where a cable is out."""

pytestmark = [*needs_page, pytest.mark.long]


def hang(page: Page) -> None:
    page.evaluate(HANG)


def kill(page: Page) -> None:
    page.close()


@pytest.mark.parametrize(("label", "end"), [("J1 lbr_iiwa_joint_1 plus", hang), ("Z minus", kill)])
def test_a_page_that_ends_ends_its_jog(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, label: str, end: Callable[[Page], None]
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="iiwa").set_positions([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])

    def moves() -> bool:
        step(stepped, 2)
        return any(state(stepped, "iiwa").velocities)

    with browsers() as browser:
        page = browser.new_page(viewport={"width": 1100, "height": 700})
        page.goto(console.url + PLAIN)
        row(page, "iiwa").click()
        hold(page, label)
        until(moves)
        end(page)
        until(lambda: not moves())
        here = state(stepped, "iiwa").positions
        step(stepped, 100)
        assert state(stepped, "iiwa").positions == here
    *_, motion = stepped.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions
    assert motion.phase != motion_pb2.MOTION_PHASE_SUCCEEDED


def test_a_network_that_is_gone_without_a_word_is_noticed(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    load(stepped, IIWA, name="iiwa")

    def moves() -> bool:
        step(stepped, 2)
        return any(state(stepped, "iiwa").velocities)

    with browsers() as browser, opened(browser, console.url + PLAIN, script=DARK) as page:
        row(page, "iiwa").click()
        hold(page, "J1 lbr_iiwa_joint_1 plus")
        until(moves)
        page.evaluate("window.dark = true")
        until(lambda: not moves())  # the button is held still
        page.keyboard.press("Space")
        expect(page.locator("#last")).to_contain_text("STOP has not been heard yet. Use the robot's own stop")
        expect(page.locator("#connection")).to_have_text("disconnected")
        expect(page.get_by_label("Z minus", exact=True)).to_be_disabled()
        page.evaluate("window.dark = false")
        expect(page.locator("#connection")).to_have_text("connected")
        apply(stepped, create(box("crate")))
        expect(row(page, "crate")).to_be_visible()


def test_names_are_words(console: Console, stepped: Stubs, stepped_kernel: KernelProcess) -> None:
    name = "<img src=x onerror=\"document.title='taken'\">"
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.scene.add_object(name, virtualrobot.box(0.2, 0.2, 0.2))
        with browsers() as browser, opened(browser, console.url + PLAIN) as page:
            row_of_it = page.get_by_role("treeitem", name=name)
            row_of_it.click()
            page.get_by_role("tab", name="Properties").click()
            expect(page.get_by_label("Name", exact=True)).to_have_value(name)
            client.scene.remove(name)
            expect(row_of_it).to_have_count(0)
            page.get_by_role("tab", name="History").click()
            expect(page.locator("#history")).to_contain_text("<img src=x")
            assert page.title() == "VirtualRobot" and page.locator("#app img").count() == 0


def test_who_has_no_link_is_told(start_kernel: StartKernel) -> None:
    kernel = start_kernel(token=True)
    with consoles(kernel.address, token=kernel.token) as console, browsers() as browser:
        with opened(browser, console.url + PLAIN) as page:
            expect(page.get_by_role("alert")).to_contain_text("may not come in")
            expect(page.get_by_role("alert")).to_contain_text("Open the link that was printed last")
            expect(page.get_by_role("button", name="Add …")).to_be_disabled()
            expect(page.get_by_text("There is no robot here yet")).to_have_count(0)
        with opened(browser, console.link) as page:
            expect(page.locator("#connection")).to_have_text("connected")
            expect(page.get_by_label("Status")).to_contain_text("admin")


LATE = """
const send = WebSocket.prototype.send, late = new Set(), held = [];
WebSocket.prototype.send = function (frame) {
  const bytes = new Uint8Array(frame.buffer ?? frame, frame.byteOffset ?? 0, frame.byteLength);
  const call = bytes.slice(0, 4).join();
  if (new TextDecoder().decode(bytes).includes('RobotService/GetRobot"')) late.add(call);
  if (late.has(call)) held.push(() => send.call(this, frame));
  else send.call(this, frame);
};
window.ask = () => held.splice(0).forEach((one) => one());
"""
"""Has a page ask for what robots are only when it is told to."""


def test_a_robot_of_which_the_kernel_tells_late_is_not_missing(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess
) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="iiwa")
    with browsers() as browser, opened(browser, console.url + PLAIN, script=LATE) as page:
        row(page, "iiwa").click()
        for tab in ("Parts", "Pendant"):
            page.get_by_role("tab", name=tab).click()
            expect(page.get_by_text("The library has some")).to_have_count(0)
        expect(page.get_by_text("The kernel is asked about iiwa")).to_be_visible()
        page.evaluate("ask()")
        expect(page.get_by_label("Robot", exact=True).first).to_have_value("iiwa")


def test_a_kernel_that_comes_again_is_shown(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    port = kernel.address.rpartition(":")[2]
    with virtualrobot.connect(kernel.address) as client:
        client.load_robot(IIWA, name="first")
    with consoles(kernel.address) as console, browsers() as browser, opened(browser, console.url + PLAIN) as page:
        row(page, "first").click()
        # Meanwhile the console was updated, so that it serves another page.
        served = page.request.get(console.url + "/").text()
        page.route(
            console.url + "/", lambda asked: asked.fulfill(body=served.replace("/assets/index-", "/assets/newer-"))
        )
        kernel.end()
        expect(page.locator("#connection")).to_have_text("disconnected")
        # What would ask it for something can't be pressed; STOP can.
        expect(page.get_by_role("status").filter(has_text="trying again")).to_be_visible()
        for label in ("J1 lbr_iiwa_joint_1 plus", "Z minus", "Speed of all robots, %"):
            expect(page.get_by_label(label, exact=True)).to_be_disabled()
        expect(page.get_by_role("slider", name="lbr_iiwa_joint_1, °")).to_have_attribute("aria-disabled", "true")
        expect(page.locator("#stop")).to_be_enabled()
        expect(page.get_by_text("another version of this page")).to_have_count(0)
        again = start_kernel("--port", port)
        with virtualrobot.connect(again.address) as client:
            client.load_robot(IIWA, name="second")
        expect(row(page, "second")).to_be_visible()
        expect(row(page, "first")).to_have_count(0)
        expect(page.locator("#connection")).to_have_text("connected")
        expect(page.get_by_text("another version of this page")).to_be_visible()
        page.unroute_all()
        page.get_by_role("button", name="Reload").click()
        expect(row(page, "second")).to_be_visible()
        expect(page.get_by_text("another version of this page")).to_have_count(0)


def test_the_console_that_goes_is_told(start_kernel: StartKernel) -> None:
    kernel = start_kernel()
    with browsers() as browser, consoles(kernel.address) as console, opened(browser, console.url + PLAIN) as page:
        expect(page.locator("#connection")).to_have_text("connected")
        console.end()
        expect(page.locator("#connection")).to_have_text("disconnected")
        expect(page.get_by_role("status").filter(has_text="trying again")).to_be_visible()
