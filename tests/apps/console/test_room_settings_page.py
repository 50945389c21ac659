"""Display and observer of a room, where it stays from session to session, and what others see beside it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, Page, expect
from virtualrobot import Client
from virtualrobot.v1 import view_pb2

from tests.api.asking import IIWA
from tests.api.reading import matrix
from tests.apps.console.browsing import PLAIN, PURPLE, browsers, color_count, needs_page, opened, purple_count, row
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import EMULATOR, IWER, UNDRAWN, in_room
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = [pytest.mark.long, *needs_page]

GREEN, YELLOW = (76, 195, 138), (255, 214, 92)
"""Colors of boxes and distances."""

FLOAT32 = 1e-3
"""Poses of headsets have single precision, and heads are told where they have moved by 1 mm (m)."""

Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="arm")
        yield client


@pytest.fixture
def head(stepped: Stubs) -> Iterator[Callable[[], np.ndarray]]:
    """Return a function that gives the next pose of the only head, read by somebody else."""
    watch = stepped.view.MeetViewers(iter(()))

    def read() -> np.ndarray:
        told: list[view_pb2.Viewer] = []
        while not told:
            told = list(next(watch).viewers)
        return matrix(told[0].world_t_head)

    yield read
    watch.cancel()


def begin(page: Page, mode: str) -> None:
    page.get_by_role("toolbar", name="View").get_by_title(re.compile(f"^{mode}")).click()
    expect(page.locator("#room")).to_contain_text("Take the ball")


def test_display_and_observer_are_as_a_person_has_set_them(
    browser: Browser, console: Console, client: Client, head: Callable[[], np.ndarray]
) -> None:
    """The cell is entered from a saved view, with eyes at a height; what is near and far is the session's."""
    with opened(browser, console.url + PLAIN, script=IWER.read_text("utf-8") + EMULATOR + UNDRAWN) as page:
        row(page, "arm").click()
        page.locator('.view .canvas[aria-busy="false"]').wait_for()
        page.keyboard.press("4")  # from the right, along the world's -x
        page.get_by_role("tab", name="Views").click()
        page.get_by_label("Name of the view").fill("beside")
        page.get_by_role("button", name="Save view").click()
        until(lambda: "beside" in client.scene)
        for label, value in {"Near": "0.5", "Far": "40", "Height": "2.2", "Speed by": "99"}.items():
            field = page.get_by_label(re.compile(f"^{label}"))
            field.fill(value)
            field.press("Enter")
        expect(page.get_by_label(re.compile("^Speed by"))).to_have_value("10.0")  # the most that makes sense
        page.get_by_label("Where you stand at first").select_option("beside")
        page.evaluate("() => { headset.position.set(0, 1.6, 0); headset.quaternion.set(0, 0, 0, 1); }")
        begin(page, "Virtual reality")
        seen = head()
        state = page.evaluate("(({ depthNear, depthFar }) => [depthNear, depthFar])(headset.activeSession.renderState)")
        assert state == pytest.approx([0.5, 40.0])
        eye = client.scene.pose("beside")
        np.testing.assert_allclose(seen[:3, 3], [*eye[:2, 3], 2.2], atol=FLOAT32)
        np.testing.assert_allclose(-seen[:3, 2], eye[:3, 2] * [1.0, 1.0, 0.0], atol=FLOAT32)


def test_bars_over_the_view_leave_each_other_room(browser: Browser, console: Console) -> None:
    with opened(browser, console.url + PLAIN, script=IWER.read_text("utf-8") + EMULATOR) as page:
        bars = [page.get_by_role("toolbar", name=name) for name in ("Pointer", "View")]
        expect(bars[1].locator("button")).to_have_count(9)
        for width in (1400, 1200, 1100, 950, 800, 480):
            page.set_viewport_size({"width": width, "height": 700})
            (left, right) = (bar.bounding_box() for bar in bars)
            assert left is not None and right is not None
            assert left["x"] + left["width"] <= right["x"], f"at {width} pixels"


def test_a_registered_room_is_there_in_the_next_session(
    browser: Browser, console: Console, client: Client, head: Callable[[], np.ndarray]
) -> None:
    """The headset keeps an anchor: nothing is touched again, and where the cell is another one nothing is known."""
    world_t_room = virtualrobot.pose(0.3, -1.2, 0.1, yaw=0.4) @ Y_UP
    places = {"touch-1": (0.5, 0.4, 0.2), "touch-2": (0.5, -0.5, 0.0), "touch-3": (-0.4, 0.3, 0.6)}
    for name, place in places.items():
        client.scene.add_frame(name, pose=virtualrobot.pose(*place))
    with in_room(browser, console, "arm", script=UNDRAWN) as person:
        first = head()
        person.register(places, world_t_room)
        there = world_t_room @ [0.0, 1.6, 0.0, 1.0]
        until(lambda: np.abs(head()[:3, 3] - there[:3]).max() < FLOAT32)
        until(lambda: person.page.evaluate("localStorage.getItem('virtualrobot-anchor') !== null"))
        for known in (True, False):
            if not known:
                client.scene.remove("headset")
                expect(row(person.page, "headset")).to_have_count(0)
            person.page.evaluate("() => headset.activeSession.end()")
            expect(person.told).to_have_count(0)
            begin(person.page, "Augmented reality")
            person.frames(5)
            wanted = there[:3] if known else first[:3, 3]
            until(lambda wanted=wanted: np.abs(head()[:3, 3] - wanted).max() < FLOAT32)


def test_a_second_screen_shows_what_a_person_in_the_room_sees(
    browser: Browser, console: Console, client: Client
) -> None:
    """A person 1.5 m before the robot has a cube before the eyes, as a pinhole of 75° sees it, and turns around."""
    cube = virtualrobot.box(0.2, 0.2, 0.2, color=PURPLE)
    client.scene.add_object("cube", cube, pose=virtualrobot.pose(y=-0.9, z=1.6))
    with opened(browser, console.url + PLAIN) as page:
        page.get_by_role("tab", name="Views").click()
        with in_room(browser, console, "arm", mode="Virtual reality", script=UNDRAWN) as person:
            along = page.get_by_role("button", name="Look along")
            along.click()
            size = page.locator(".view .canvas").bounding_box()
            assert size
            side = size["height"] * 0.2 / (2.0 * 0.5 * np.tan(np.radians(75.0 / 2.0)))
            until(lambda: purple_count(page) == pytest.approx(side**2, rel=0.05))
            person.page.evaluate("headset.quaternion.set(0, 1, 0, 0)")
            person.frames(5)
            until(lambda: purple_count(page) == 0)
        expect(along).to_have_count(0)
        until(lambda: purple_count(page) > 0)


def test_axes_boxes_and_distances_are_those_of_all_viewers(browser: Browser, console: Console, client: Client) -> None:
    with opened(browser, console.url + PLAIN) as page:
        row(page, "arm").click()
        page.get_by_role("tab", name="Views").click()
        assert purple_count(page) == color_count(page, GREEN) == color_count(page, YELLOW) == 0
        page.get_by_role("button", name="Axes of the joints").click()
        until(lambda: client.view.joint_axes == ["arm"] and purple_count(page) > 0)
        page.get_by_role("button", name="Axes of the joints").click()
        until(lambda: client.view.joint_axes == [] and purple_count(page) == 0)
        client.view.bounding_boxes = ["arm"]
        until(lambda: color_count(page, GREEN) > 0)
        page.reload()  # figures come after what is shown of them
        row(page, "arm").click()
        until(lambda: color_count(page, GREEN) > 0)
        page.get_by_role("tab", name="Views").click()
        expect(page.get_by_role("button", name="Box around it")).to_have_attribute("aria-pressed", "true")
        client.view.measurements = {"high": (("arm", (0.3, 0.0, 0.2)), ("arm", (0.3, 0.0, 0.9)))}
        until(lambda: color_count(page, YELLOW) > 0)
        client.view.bounding_boxes = []
        client.view.measurements = {}
        until(lambda: color_count(page, GREEN) == color_count(page, YELLOW) == 0)
