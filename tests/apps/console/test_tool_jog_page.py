"""A person moves an arm's tool at the console's page: straight, within its speed limit, and told what holds it up."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client, Robot
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA
from tests.api.reading import state, step
from tests.apps.console.browsing import PLAIN, browsers, hold, needs_page, opened, row
from tests.apps.console.consoles import Console
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [*needs_page, pytest.mark.long]

HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
TICK_SECONDS = 0.004
FULL, THIRD = 0.25, 0.3
"""Greatest speed of jogs (m/s), and the part of it that the page begins with."""

Tick = Callable[[], np.ndarray]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@contextmanager
def jogging(
    browser: Browser, console: Console, client: Client, joints: Sequence[float] = HERE
) -> Iterator[tuple[Page, Robot]]:
    """Give a page whose pendant is that of an arm, and the arm."""
    arm = client.load_robot(IIWA, name="arm")
    arm.set_positions(joints)
    with opened(browser, console.url + PLAIN) as page:
        row(page, "arm").click()
        expect(page.get_by_label("Robot", exact=True).first).to_have_value("arm")
        yield page, arm


def ticks(page: Page, stubs: Stubs, arm: Robot) -> Tick:
    """Return a function that lets a tick go by, with time for the page, and returns how the tool moves (m/s)."""
    last = [arm.tcp[:3, 3]]

    def tick() -> np.ndarray:
        page.evaluate("0")
        step(stubs, 1)
        last.append(arm.tcp[:3, 3])
        return (last[-1] - last[-2]) / TICK_SECONDS

    return tick


def rests(page: Page, stubs: Stubs) -> bool:
    page.evaluate("0")
    step(stubs, 1)
    now = state(stubs, "arm")
    return not any(now.velocities) and not now.motion_ids


def test_the_tool_goes_straight_while_a_button_is_held(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        jogging(browser, console, client) as (page, arm),
    ):
        begin, tick = arm.tcp, ticks(page, stepped, arm)
        hold(page, "Y plus")
        until(lambda: abs(tick()[1] - THIRD * FULL) < 1e-4)
        way = arm.tcp[:3, 3] - begin[:3, 3]
        # A line to rounding, along the base's axes, which are the world's here; the tool turns by nothing.
        assert way[1] > 0.0 and np.abs(way[[0, 2]]).max() < 1e-6
        np.testing.assert_allclose(arm.tcp[:3, :3], begin[:3, :3], atol=1e-6)
        page.mouse.up()
        until(lambda: rests(page, stepped))
        motion = stepped.motion.ListMotions(motion_pb2.ListMotionsRequest()).motions[-1]
        assert motion.phase == motion_pb2.MOTION_PHASE_SUCCEEDED

        # Along the tool's own axis, faster; and about it, by a key.
        page.get_by_role("region", name="Tool centre point").get_by_role("radio", name="Tool", exact=True).click()
        page.get_by_label("Jog speed, %").fill("100")
        tick = ticks(page, stepped, arm)
        hold(page, "Z minus")
        until(lambda: abs(tick() @ arm.tcp[:3, 2] + FULL) < 1e-3)
        page.mouse.up()
        until(lambda: rests(page, stepped))
        begin = arm.tcp
        page.get_by_label("RZ plus", exact=True).focus()
        page.keyboard.down("Enter")
        tick = ticks(page, stepped, arm)
        until(lambda: tick() is not None and (begin[:3, :3].T @ arm.tcp[:3, :3])[1, 0] > 0.1)  # the sine of the turn
        page.keyboard.up("Enter")
        until(lambda: rests(page, stepped))
        np.testing.assert_allclose(arm.tcp[:3, 2], begin[:3, 2], atol=1e-3)

        # Along the axes of a node, though it is called as the arm's own frame.
        client.scene.add_object("base", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(0.0, -1.0, yaw=0.5))
        panel = page.get_by_role("region", name="Tool centre point")
        panel.get_by_role("radio", name="User", exact=True).click()
        row(page, "base").wait_for()
        named = panel.get_by_label("User frame: the node along whose axes the tool goes")
        named.fill("base")
        named.press("Enter")
        begin, tick = arm.tcp[:3, 3], ticks(page, stepped, arm)
        hold(page, "Y minus")
        until(lambda: abs(np.linalg.norm(tick()) - FULL) < 1e-3)
        way = (arm.tcp[:3, 3] - begin) / np.linalg.norm(arm.tcp[:3, 3] - begin)
        np.testing.assert_allclose(way, [np.sin(0.5), -np.cos(0.5), 0.0], atol=1e-4)
        page.mouse.up()
        until(lambda: rests(page, stepped))


def test_a_speed_limit_for_teaching_holds(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        jogging(browser, console, client) as (page, arm),
    ):
        arm.tcp_speed_limit = limit = 0.05
        arm.set_positions([0.4, *HERE[1:]])
        # The page has been told of the limit when its pendant shows what came after it: 0.4 rad are 22.9°.
        expect(page.get_by_label("J1 lbr_iiwa_joint_1 position", exact=True)).to_have_value("22.9")
        page.get_by_label("Jog speed, %").fill("100")
        tick, speeds = ticks(page, stepped, arm), []

        def speed() -> float:
            speeds.append(float(np.linalg.norm(tick())))
            return speeds[-1]

        hold(page, "Y minus")
        # The kernel takes a stream up to 1/1.02 of the limit.
        until(lambda: speed() > 0.99 * limit / 1.02)
        page.mouse.up()
        until(lambda: speed() == 0.0)
        assert max(speeds) <= limit
        expect(page.locator("#last")).not_to_contain_text("refused")


def test_what_holds_the_tool_up_is_told(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    nearly_stretched = (0.0, 0.5, 0.0, -0.3, 0.0, 0.4, 0.0)
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        jogging(browser, console, client, nearly_stretched) as (page, arm),
    ):
        page.get_by_label("Jog speed, %").fill("100")
        said = page.get_by_role("region", name="Tool centre point").get_by_role("status")
        tick = ticks(page, stepped, arm)
        hold(page, "Z plus")
        until(lambda: tick() is not None and said.count())
        expect(said).to_have_text(re.compile("a singularity is near|lbr_iiwa_joint_\\d holds it up"))
        page.mouse.up()
        expect(said).to_have_count(0)
        until(lambda: rests(page, stepped))
        # The other way it is free.
        tick = ticks(page, stepped, arm)
        hold(page, "Z minus")
        until(lambda: tick()[2] < -0.9 * FULL)
        page.mouse.up()
        until(lambda: rests(page, stepped))


def test_somebody_elses_lease_is_told_and_nothing_moves(
    console: Console, stepped: Stubs, stepped_kernel: KernelProcess, browser: Browser
) -> None:
    with (
        virtualrobot.connect(stepped_kernel.address) as client,
        jogging(browser, console, client) as (page, arm),
        client.lease(arm),
    ):
        before = arm.positions.copy()
        hold(page, "X plus")
        expect(page.locator("#last")).to_contain_text("lease")
        page.mouse.up()
        step(stepped, 50)
        np.testing.assert_array_equal(arm.positions, before)
