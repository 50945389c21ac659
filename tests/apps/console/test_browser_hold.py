"""Hold-to-run from a browser's page: one that hangs and one that is killed lets the robot slow down on its path."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, load
from tests.api.reading import state, step
from tests.apps.console.browsing import browsers, needs_browser
from tests.apps.console.consoles import Console
from tests.apps.console.test_page_calls import PAUSED, request, start
from tests.kernels import Stubs
from tests.waiting import until

HOLD = """async (id) => {
  const { Calls } = await import("/calls.js");
  const held = new Calls().open("MotionService/HoldMotion");
  setInterval(() => held.send({ id }), 50);
}"""
HANG = "() => { setTimeout(() => { for (;;); }, 0); }"

pytestmark = [pytest.mark.long, needs_browser]


def hang(page: Page) -> None:
    page.evaluate(HANG)


def kill(page: Page) -> None:
    page.close()


@pytest.mark.parametrize("end", [hang, kill])
def test_a_page_that_ends_lets_go(console: Console, stepped: Stubs, end: Callable[[Page], None]) -> None:
    load(stepped, IIWA, name="arm")
    motion = start(stepped, hold=True)

    def phase() -> int:
        return stepped.motion.GetMotion(request(motion)).motion.phase

    def runs() -> bool:
        step(stepped, 2)
        return any(state(stepped, "arm").velocities)

    def stands() -> bool:
        step(stepped, 2)
        return phase() == PAUSED

    with browsers() as browser:
        page = browser.new_page()
        page.goto(console.url)
        page.evaluate(HOLD, motion)
        until(runs)
        end(page)
        until(stands)
        here = state(stepped, "arm").positions
        step(stepped, 200)
        assert state(stepped, "arm").positions == here
    assert phase() != motion_pb2.MOTION_PHASE_SUCCEEDED
