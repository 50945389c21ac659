"""The real room by fingertips: a pinch moves the tip that touches, so what was touched is where it was before."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
import virtualrobot
from playwright.sync_api import Browser, expect
from virtualrobot import Client

from tests.apps.console.browsing import WRITTEN, browsers, needs_page
from tests.apps.console.consoles import Console
from tests.apps.console.headsets import AHEAD, UNDRAWN, Person, in_room
from tests.apps.console.test_xr_page import FLOAT32, needs_iwer
from tests.apps.console.test_xr_page import client as client
from tests.waiting import until

pytestmark = [*needs_page, needs_iwer, pytest.mark.long]

PLACES = {"touch-1": (0.5, 0.4, 0.2), "touch-2": (0.5, -0.5, 0.0), "touch-3": (-0.4, 0.3, 0.6)}
Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
SETTLED_MS = 900
"""Time for which a finger is still before it pinches."""

TIP = """async () => {
  const session = headset.activeSession, floor = await session.requestReferenceSpace("local-floor");
  return new Promise((go) => session.requestAnimationFrame((_, frame) => {
    const { hand } = [...session.inputSources].find((one) => one.hand && one.handedness === "right");
    const { x, y, z } = frame.getJointPose(hand.get("index-finger-tip"), floor).transform.position;
    go([x, y, z]);
  }));
}"""
MOVE = """([x, y, z]) => {
  const { position } = headset.hands.right;
  position.set(position.x + x, position.y + y, position.z + z);
}"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with browsers() as one:
        yield one


@pytest.fixture
def person(browser: Browser, console: Console, client: Client) -> Iterator[Person]:
    for name, place in PLACES.items():
        client.scene.add_frame(name, pose=virtualrobot.pose(*place))
    with in_room(browser, console, "arm", by_hand=True, script=UNDRAWN + WRITTEN) as one:
        yield one


def tip(person: Person) -> np.ndarray:
    return np.array(person.page.evaluate(TIP))


def put(person: Person, point: tuple[float, ...]) -> None:
    """Put the tip of the index finger at a point of the world."""
    for _ in range(2):
        person.page.evaluate(MOVE, (np.array(person.room(point)) - tip(person)).tolist())
        person.frames()


def pinch(person: Person) -> None:
    person.pull(1)
    person.pull(0)


def test_a_pinch_does_not_shift_what_was_touched(person: Person, client: Client) -> None:
    """The emulator's pinch takes the tip of the index finger 98 mm away."""
    person.press("register")
    for name, place in PLACES.items():
        expect(person.told).to_contain_text(f"Touch {name}")
        put(person, place)
        person.page.evaluate("still", SETTLED_MS)
        open_tip = tip(person)
        pinch(person)
        assert np.linalg.norm(person.room(place) - open_tip) < FLOAT32
    expect(person.told).to_contain_text("registered, points off by 0.0 mm at most")
    until(lambda: "headset" in client.scene)
    np.testing.assert_allclose(client.scene.pose("headset"), virtualrobot.pose(y=-AHEAD) @ Y_UP, atol=FLOAT32)


def test_the_panel_has_all_of_what_is_wrong(person: Person, client: Client) -> None:
    """250 letters, in smaller ones."""
    person.press("register")
    for name, place in zip(PLACES, reversed(PLACES.values()), strict=True):
        expect(person.told).to_contain_text(f"Touch {name}")
        put(person, place)
        person.page.evaluate("still", SETTLED_MS)
        pinch(person)
    expect(person.told).to_contain_text("the touches don't fit the points")
    until(lambda: "y is up for the device" in " ".join(person.page.evaluate("written")[-40:]))
    assert not any("…" in text for text in person.page.evaluate("written"))
    assert "headset" not in client.scene


@pytest.mark.parametrize(
    "hurry",
    [
        pytest.param(lambda person: put(person, PLACES["touch-2"]), id="from elsewhere at once"),
        pytest.param(
            lambda person: [person.page.evaluate(MOVE, [0.03, 0, 0]) or person.frames(1) for _ in range(60)],
            id="moving",
        ),
    ],
)
def test_a_finger_that_was_not_still_touches_nothing(person: Person, hurry: Callable[[Person], object]) -> None:
    person.press("register")
    put(person, PLACES["touch-1"])
    person.page.evaluate("still", SETTLED_MS)
    hurry(person)
    pinch(person)
    expect(person.told).to_contain_text("Touch touch-1")
    expect(person.told).to_contain_text("1 of 3: hold the fingertip still there for a second, and then pinch")
