"""Pages of people with headsets: their meshes are small, and they see one another."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client
from virtualrobot.kernel_process import KernelProcess
from virtualrobot.v1 import robot_pb2, scene_pb2

from tests.api.asking import IIWA, PANDA
from tests.api.reading import matrix
from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import EMULATOR, IWER, in_room
from tests.kernels import Stubs
from tests.waiting import until

pytestmark = [pytest.mark.long, *needs_page]


RECEIVED = """
window.received = 0;
window.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => { received += data.byteLength ?? data.size ?? data.length; });
  }
};
"""
"""Counts the bytes that come to the page."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        yield client


def test_a_headsets_page_gets_small_meshes_that_look_the_same(
    browser: Browser, console: Console, client: Client
) -> None:
    """A page with a headset at hand, and one without, of the same robot."""
    client.load_robot(PANDA, name="arm")
    sizes, pictures = [], []
    for headset in ("", IWER.read_text("utf-8") + EMULATOR.split("window.atHand")[0]):
        with opened(browser, console.url + PLAIN, script=RECEIVED + headset) as page:
            page.keyboard.press("1")
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            sizes.append(page.evaluate("received"))
            # Without the bars, which have one more button for each kind of room.
            page.evaluate("document.querySelectorAll('.float').forEach(bar => { bar.style.visibility = 'hidden'; })")
            data = page.locator(".view .canvas canvas").screenshot()
            pictures.append(np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float))
    full, small = sizes
    assert full > 4e6 and small < 1.2e6, sizes
    off = np.abs(pictures[0] - pictures[1]).max(axis=2)
    assert np.ptp(pictures[0][:, 200:300]) > 150.0  # the robot, and its dark rings
    assert (off > 60.0).sum() < 120  # of the 2,500 pixels that it covers


RATES = """
window.rates = {};
const asked = new Map();
window.WebSocket = class extends WebSocket {
  send(data) {
    const view = new DataView(data.buffer), number = view.getUint32(0), kind = view.getUint8(4);
    if (kind === 0) asked.set(number, JSON.parse(new TextDecoder().decode(data.subarray(5))).method);
    if (kind === 1) rates[asked.get(number)] = [...data.subarray(5)];
    super.send(data);
  }
};
"""
"""Keeps the last request that the page has sent to each method."""


@pytest.mark.parametrize(("headset", "rate"), [(False, 30.0), (True, 60.0)])
def test_poses_come_to_a_headset_sixty_times_a_second(
    browser: Browser, console: Console, client: Client, headset: bool, rate: float
) -> None:
    client.load_robot(IIWA, name="arm")
    script = RATES + (IWER.read_text("utf-8") + EMULATOR.split("window.atHand")[0] if headset else "")
    with opened(browser, console.url + PLAIN, script=script) as page:
        expect(row(page, "arm")).to_have_count(1)
        scene, states = (
            bytes(page.evaluate("(method) => rates[method]", f"/virtualrobot.v1.{method}"))
            for method in ("SceneService/WatchScene", "RobotService/WatchRobotStates")
        )
        assert scene_pb2.WatchSceneRequest.FromString(scene).max_rate_hertz == rate
        assert robot_pb2.WatchRobotStatesRequest.FromString(states).max_rate_hertz == rate


def head_pixels(page: Page) -> int:
    """Return how many pixels in the middle of what a headset shows are as teal as a head."""
    data = page.locator("[data-webxr_runtime] canvas").last.screenshot()
    picture = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float)
    high, wide = picture.shape[:2]
    middle = picture[high // 3 : -high // 3, wide // 3 : -wide // 3]
    red, green, blue = np.moveaxis(middle, 2, 0)
    return int(np.count_nonzero((np.minimum(green, blue) > 1.6 * red) & (green > 70.0)))


def test_two_people_in_the_room_see_each_other(
    browser: Browser, console: Console, stepped: Stubs, client: Client
) -> None:
    """One goes 0.7 m ahead and turns around: both look into each other's face, until one has gone.

    Where the heads are is read by a third client: people begin 1.5 m before the robot, and look along the world's y.
    """
    client.load_robot(IIWA, name="arm")
    watch = stepped.view.MeetViewers(iter(()))
    with in_room(browser, console, "arm", mode="Virtual reality") as one:
        alone = head_pixels(one.page)  # the axes of the tool
        with in_room(browser, console, "arm", mode="Virtual reality") as other:
            other.page.evaluate("headset.position.set(0, 1.6, -0.7); headset.quaternion.set(0, 1, 0, 0);")
            other.frames(5)
            places = {(0.0, -1.5, 1.6): (0.0, 1.0, 0.0), (0.0, -0.8, 1.6): (0.0, -1.0, 0.0)}

            def are_there() -> bool:
                heads = [matrix(viewer.world_t_head) for viewer in next(watch).viewers]
                found = {
                    tuple(np.round(head[:3, 3], 3) + 0.0): tuple(np.round(-head[:3, 2], 3) + 0.0) for head in heads
                }
                return found == places

            until(are_there)
            for person in (one, other):
                person.frames(5)
                until(lambda person=person: head_pixels(person.page) > alone + 100)
        one.frames(5)
        until(lambda: head_pixels(one.page) <= alone)
        until(lambda: len(next(watch).viewers) == 1)
    watch.cancel()
