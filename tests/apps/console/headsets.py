"""A person with a headset at the console's page: Meta's emulator of WebXR, IWER, with controllers and hands."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Locator, Page, expect
from virtualrobot_apps import console as console_app

from tests.apps.console.browsing import PLAIN, opened, row
from tests.apps.console.consoles import Console

IWER = Path(console_app.__file__).parent / "web" / "node_modules" / "iwer" / "build" / "iwer.min.js"

EYES = 1.6
"""Height of the head (m)."""
AHEAD = 1.5
"""Distance before a person at which the page puts the chosen robot (m)."""
PANEL, PANEL_SIZE, PANEL_PIXELS = (0.35, EYES - 0.25, -0.8), (0.48, 0.35), (768, 560)
"""Place at which the page hangs its panel in the room (m), and its size (m, pixels)."""
BUTTONS = {
    "hold": (250, 300),
    "stop": (618, 300),
    "reject": (80, 410),
    "undo": (201, 410),
    "teach": (322, 410),
    "lead": (443, 410),
    "register": (564, 410),
    "leave": (685, 410),
    "smaller": (140, 506),
    "life": (382, 506),
    "larger": (624, 506),
}
"""The middles of the panel's buttons, pixels from the left and from above."""

EMULATOR = """;
window.headset = new IWER.XRDevice(IWER.metaQuest3);
headset.stereoEnabled = false;
headset.installRuntime({ forceInstall: true });
window.atHand = () => headset.primaryInputMode === "hand" ? headset.hands.right : headset.controllers.right;
// A picture of few pixels, since there is no graphics card: the emulator's is as large as the window.
for (const [side, pixels] of [["innerWidth", 240], ["innerHeight", 160]]) {
  Object.defineProperty(window, side, { get: () => pixels });
}
window.frames = async (count) => {
  const { activeSession } = headset;
  for (let frame = 0; frame < count; frame++) await new Promise((go) => activeSession.requestAnimationFrame(go));
};
window.still = async (ms) => {
  for (const begin = performance.now(); performance.now() < begin + ms; ) await frames(1);
};
// Moves a hand until the middle between its thumb and index finger is at a point of the floor's frame.
window.reach = async (...point) => {
  const session = headset.activeSession, floor = await session.requestReferenceSpace("local-floor");
  for (let round = 0; round < 3; round++) await new Promise((go) => session.requestAnimationFrame((_, frame) => {
    const { hand } = [...session.inputSources].find((one) => one.hand && one.handedness === "right");
    const tips = ["thumb-tip", "index-finger-tip"].map((name) => frame.getJointPose(hand.get(name), floor));
    const [one, other] = tips.map(({ transform: { position: { x, y, z } } }) => [x, y, z]);
    const { position } = headset.hands.right, here = [position.x, position.y, position.z];
    position.set(...here.map((at, axis) => at + point[axis] - (one[axis] + other[axis]) / 2));
    go();
  }));
};
"""

UNDRAWN = """
for (const name of ["drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced"]) {
  WebGL2RenderingContext.prototype[name] = () => {};
}
const found = WebGL2RenderingContext.prototype.getExtension;
WebGL2RenderingContext.prototype.getExtension = function (name) {
  const extension = found.call(this, name);
  if (name === "WEBGL_multi_draw" && extension) {
    for (const draw of ["multiDrawElementsWEBGL", "multiDrawArraysWEBGL"]) extension[draw] = () => {};
  }
  return extension;
};
"""
"""Has WebGL draw nothing, as if a graphics card did it beside: else the processor draws between what is measured."""


class Person:
    """A person in the room, whose right hand the test moves; points are in the world, m."""

    def __init__(self, page: Page, base: Sequence[float], *, by_hand: bool) -> None:
        """Stand before a robot whose base is there, and look along the world's y.

        `heading` (rad) is how far to the left the person has turned by a stick since then, `scale` the meters of the
        world for each of the room, by which the base stays where it is seen.
        """
        self.page = page
        self.base = np.asarray(base, float)
        self.heading = 0.0
        self.scale = 1.0
        self.by_hand = by_hand
        page.evaluate(f"headset.primaryInputMode = '{'hand' if by_hand else 'controller'}'")

    @property
    def told(self) -> Locator:
        """Words of the page on what goes on in the room."""
        return self.page.locator("#room")

    def frames(self, count: int = 2) -> None:
        """Wait for frames of the headset, in which the page sees what has changed."""
        self.page.evaluate("frames", count)

    def room(self, point: Sequence[float] | np.ndarray) -> list[float]:
        """Return a point of the world in the room; the base was ahead before the person turned or walked."""
        standing = np.array([0.0, AHEAD, self.base[2]])
        right, ahead, up = self.turned(standing + (np.asarray(point, float) - self.base) / self.scale)
        return [right, up, -ahead]

    def turned(self, way: Sequence[float] | np.ndarray) -> list[float]:
        """Return a way of the world as the person sees it: to the right, ahead, up."""
        x, y, z = way
        cosine, sine = math.cos(self.heading), math.sin(self.heading)
        return [float(cosine * x + sine * y), float(cosine * y - sine * x), float(z)]

    def reach(self, point: Sequence[float] | np.ndarray) -> None:
        """Put the hand or controller at a point."""
        if self.by_hand:
            self.page.evaluate("(at) => reach(...at)", self.room(point))
        else:
            self._put(self.room(point))
        self.frames()

    def touch(self, room: Sequence[float]) -> None:
        """Put the tip of the controller at a point of the room and pull the trigger."""
        self._put(list(room))
        self.frames()
        self.pull(1)
        self.pull(0)

    def register(self, places: Mapping[str, Sequence[float]], world_t_room: np.ndarray) -> None:
        """Touch frames of the cell where they are in a room that lies so in the world."""
        self.press("register")
        for name, place in places.items():
            expect(self.told).to_contain_text(f"Touch {name}")
            self.touch((np.linalg.inv(world_t_room) @ [*place, 1.0])[:3].tolist())
        expect(self.told).to_contain_text("registered, points off by 0.0 mm at most")

    def take(
        self, point: Sequence[float] | np.ndarray, way: Sequence[float] | np.ndarray, steps: int = 3
    ) -> np.ndarray:
        """Take the ball at a point along a way and let it go there; return where that is."""
        self.reach(point)
        self.squeeze(1)
        self.move(way, steps)
        self.page.evaluate("still", 120)  # longer than the page looks back when a hand lets go, 80 ms
        self.squeeze(0)
        return np.asarray(point, float) + way

    def move(self, way: Sequence[float] | np.ndarray, steps: int = 3) -> None:
        """Move the hand along a way of the world, m."""
        here, (right, ahead, up) = self._get(), self.turned(np.asarray(way, float) / self.scale)
        for part in np.linspace(0.0, 1.0, steps + 1)[1:]:
            self._put(list(np.asarray(here) + part * np.array([right, up, -ahead])))
            self.frames(1)

    def push(self, side: str, right: float = 0.0, ahead: float = 0.0) -> None:
        """Push the stick of the left or right controller as far, from -1 to 1."""
        self.page.evaluate(
            "([side, right, back]) => headset.controllers[side].updateAxes('thumbstick', right, back)",
            [side, right, -ahead],
        )
        self.frames()

    def squeeze(self, value: int) -> None:
        """Close the hand, 1, or open it, 0."""
        self._button("squeeze", value)

    def point(self, button: str) -> None:
        """Point at a button of the panel."""
        x, y = BUTTONS[button]
        (width, height), (wide, high) = PANEL_SIZE, PANEL_PIXELS
        self._put([PANEL[0] + (x / wide - 0.5) * width, PANEL[1] + (0.5 - y / high) * height, PANEL[2] + 0.3])
        self.frames()

    def pull(self, value: int = 1) -> None:
        """Hold the trigger, 1, or let it go, 0."""
        self._button("trigger", value)

    def let_go(self) -> None:
        """Let go whatever is held."""
        self.pull(0)
        if not self.by_hand:
            self.squeeze(0)

    def press(self, button: str) -> None:
        """Press a button of the panel."""
        self.point(button)
        self.pull(1)
        self.pull(0)

    def leave(self) -> None:
        """Press the panel's Leave, after which there are no frames to wait for."""
        self.point("leave")
        self._turn("trigger", 1)
        expect(self.told).to_have_count(0)

    def back(self) -> None:
        """Press the controller's B."""
        for value in (1, 0):
            self._button("b-button", value)

    def _button(self, name: str, value: int) -> None:
        self._turn(name, value)
        self.frames()

    def _turn(self, name: str, value: int) -> None:
        if self.by_hand:
            self.page.evaluate("(value) => headset.hands.right.updatePinchValue(value)", value)
        else:
            self.page.evaluate("([name, value]) => atHand().updateButtonValue(name, value)", [name, value])

    def _put(self, at: list[float]) -> None:
        self.page.evaluate(
            "([x, y, z]) => { atHand().position.set(x, y, z); atHand().quaternion.set(0, 0, 0, 1); }", at
        )

    def _get(self) -> list[float]:
        return self.page.evaluate("() => { const { x, y, z } = atHand().position; return [x, y, z]; }")


@contextmanager
def in_room(
    browser: Browser,
    console: Console,
    robot: str,
    *,
    mode: str = "Augmented reality",
    by_hand: bool = False,
    script: str = "",
    link: str = "",
    prepare: Callable[[Page], object] = lambda page: None,
) -> Iterator[Person]:
    """Give a person in the room before a robot at the world's origin; the page runs a script before its own.

    `link` lets the page in; `prepare` is done at the page, where the robot is chosen, before the room is entered.
    """
    script = IWER.read_text("utf-8") + EMULATOR + script
    with opened(browser, console.url + PLAIN, width=900, height=500, script=script, link=link) as page:
        row(page, robot).click()
        prepare(page)
        page.keyboard.press("1")
        page.locator('.view .canvas[aria-busy="false"]').wait_for()
        page.evaluate("(eyes) => { headset.position.set(0, eyes, 0); headset.quaternion.set(0, 0, 0, 1); }", EYES)
        page.get_by_role("toolbar", name="View").get_by_title(re.compile(f"^{mode}")).click()
        person = Person(page, (0.0, 0.0, 0.0), by_hand=by_hand)
        expect(person.told).to_contain_text("Take the ball")
        person.frames()
        yield person
