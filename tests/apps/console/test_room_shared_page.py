"""Small meshes for headsets in the console's page."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from PIL import Image
from playwright.sync_api import Browser
from virtualrobot import Client
from virtualrobot.kernel_process import KernelProcess

from tests.apps.console.browsing import PLAIN, browsers, needs_page, opened
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import EMULATOR, IWER
from tests.kernels import Stubs

pytestmark = [pytest.mark.long, *needs_page]

PANDA = "package://pybullet_data/franka_panda/panda.urdf"

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
            # Beside the tools, which have one more for each kind of room.
            data = page.locator(".view .canvas canvas").screenshot()
            pictures.append(np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), float)[60:])
    full, small = sizes
    assert full > 4e6 and small < 1.2e6, sizes
    off = np.abs(pictures[0] - pictures[1]).max(axis=2)
    assert np.ptp(pictures[0][:, 200:300]) > 150.0  # the robot, and its dark rings
    assert (off > 60.0).sum() < 120  # of the 2,500 pixels that it covers
