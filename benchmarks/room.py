"""The page in a room by an emulated headset: how soon a goal is answered, a press moves the robot, and what is drawn.

Chromium tells when frames of the page's socket go and come (`Network.webSocketFrameSent` and `...Received`, whose clock
is CLOCK_MONOTONIC); where the robot was at which time says the kernel, whose ticks follow the wall clock.
"""

from __future__ import annotations

import base64
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import virtualrobot
from playwright.sync_api import Browser, CDPSession, Page, expect
from virtualrobot import Client
from virtualrobot_apps.demos.palletizing import cell

from benchmarks.console import LONGEST, Robot, beats, hang, pumped
from benchmarks.processes import kernel
from benchmarks.rows import Row, row
from tests.apps.console.browsing import browsers
from tests.apps.console.consoles import Console, consoles
from tests.apps.console.headsets import UNDRAWN, Person, in_room
from tests.waiting import until

ROUNDS = 10
HERE = (0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0)
WAY = (-0.1, -0.08, 0.06)
STEPS = 200
"""Places at which the goal is while it is dragged along its way, one for each picture of the headset."""

SLOWLY = 0.2
"""Speed factor of the cell, with which the short way takes so long that a page may hang on it."""

INVERSE, PRESS = 0.033, 0.060
"""Times (s) that are promised: from a goal to its posture, and from the trigger to the tick of the first movement."""

CALLS, TRIANGLES, FRAME = 50, 300e3, 0.003
"""Draw calls and triangles of an eye's picture of the demo's cell at most, and the page's time (s) for a frame."""
EYES = 2

BOTH = (("", ""), (UNDRAWN, ", nothing drawn"))
"""The page as it is, which the processor draws here, and one that draws nothing, as if a graphics card did."""

COUNTED = """
window.drawn = { calls: 0, triangles: 0 };
const count = (mode, corners) => {
  drawn.calls++;
  if (mode === WebGL2RenderingContext.TRIANGLES) drawn.triangles += corners / 3;
};
const context = WebGL2RenderingContext.prototype;
const wrap = (owner, name, corners) => {
  const was = owner[name];
  owner[name] = function (...given) {
    count(given[0], corners(given));
    return was.apply(this, given);
  };
};
wrap(context, "drawElements", (given) => given[1]);
wrap(context, "drawArrays", (given) => given[2]);
wrap(context, "drawElementsInstanced", (given) => given[1] * given[4]);
wrap(context, "drawArraysInstanced", (given) => given[2] * given[3]);
const extension = context.getExtension, wrapped = new Set();
context.getExtension = function (name) {
  const found = extension.call(this, name);
  if (name === "WEBGL_multi_draw" && found && !wrapped.has(found)) {
    wrapped.add(found);
    const sum = (counts, first, many) => counts.slice(first, first + many).reduce((one, more) => one + more, 0);
    wrap(found, "multiDrawElementsWEBGL", (given) => sum(given[1], given[2], given.at(-1)));
  }
  return found;
};
"""
"""Counts what WebGL is told to draw."""
FRAMES = """() => new Promise((done) => {
  const frames = [], { prototype } = XRSession, was = prototype.requestAnimationFrame;
  prototype.requestAnimationFrame = function (draw) {
    return was.call(this, (...given) => {
      window.drawn = { calls: 0, triangles: 0 };
      const since = performance.now();
      draw(...given);
      frames.push([drawn.calls, drawn.triangles, performance.now() - since]);
      if (frames.length === 50) done(frames);
    });
  };
})"""
"""Gives what 50 frames of a headset draw: calls, triangles and the page's time, ms."""

HEAD = struct.Struct(">IB")
BEGIN, END = 0, 2


@dataclass
class Calls:
    """Calls of a page by number: when each began, s, and how long those took that have ended, s."""

    method: bytes
    begun: dict[int, float] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)

    def sent(self, event: dict[str, Any]) -> None:
        """Take a frame that the page has sent."""
        data = base64.b64decode(event["response"]["payloadData"])
        number, kind = HEAD.unpack_from(data)
        if kind == BEGIN and self.method in data:
            self.begun[number] = event["timestamp"]

    def received(self, event: dict[str, Any]) -> None:
        """Take a frame that has come to the page."""
        number, kind = HEAD.unpack_from(base64.b64decode(event["response"]["payloadData"]))
        if kind == END and number in self.begun:
            self.seconds.append(event["timestamp"] - self.begun.pop(number))


@contextmanager
def listened(page: Page, method: str) -> Iterator[Calls]:
    """Give the calls of a method that a page makes."""
    calls = Calls(f"/{method}".encode())
    session: CDPSession = page.context.new_cdp_session(page)
    session.on("Network.webSocketFrameSent", calls.sent)
    session.on("Network.webSocketFrameReceived", calls.received)
    session.send("Network.enable")
    try:
        yield calls
    finally:
        session.detach()


@contextmanager
def proposed(
    browser: Browser, console: Console, client: Client, steps: int = 8, script: str = ""
) -> Iterator[tuple[Person, list[float]]]:
    """Give a person who points at Hold to run, and how long (s) each of the goals on the way there took.

    The page runs a script before its own.
    """
    client.stop()
    until(lambda: not client.motions())
    for one in client.proposals.list():
        if one.state == "proposed":
            client.proposals.reject(one)
    arm = client.robots["iiwa"]
    arm.set_positions(HERE)
    with in_room(browser, console, "iiwa", script=script) as person:
        with listened(person.page, "SolveInverse") as calls:
            person.take(arm.tcp[:3, 3], WAY, steps)
            expect(person.told).to_contain_text("free")
        person.point("hold")
        yield person, calls.seconds


def press_seconds(browser: Browser, console: Console, client: Client, script: str = "") -> float:
    """Return how long (s) after the trigger the robot's first tick of movement is."""
    robot = Robot(client)
    try:
        with proposed(browser, console, client, script=script) as (person, _):
            pressed = time.monotonic()
            person.page.evaluate("() => atHand().updateButtonValue('trigger', 1)")
            pumped(person.page, lambda: robot.moves)
            return robot.moves_since - pressed
    finally:
        robot.end()


def hang_seconds(browser: Browser, console: Console, client: Client) -> float:
    """Return how long (s) after the last beat of a headset's page that hangs the robot stands."""
    robot = Robot(client)
    try:
        with proposed(browser, console, client) as (person, _), beats(person.page) as sent:
            person.pull()
            pumped(person.page, lambda: robot.moves and len(sent) > 10)
            hang(browser, person.page)
            until(lambda: not robot.moves)
            browser.new_browser_cdp_session().send("Browser.getVersion")  # takes what was told meanwhile
            return robot.stands_since - sent[-1]
    finally:
        robot.end()


def drawn(browser: Browser, console: Console) -> tuple[float, float, float]:
    """Return calls, triangles and the page's time (s) of a headset's frame, medians of 50: of both eyes."""
    with in_room(browser, console, "iiwa", script=COUNTED) as person:
        calls, triangles, milliseconds = np.median(person.page.evaluate(FRAMES), axis=0)
    return calls, triangles, 1e-3 * milliseconds


def run() -> list[Row]:
    """Return the time of a dragged goal, of a press, of a page that hangs, and what is drawn of the demo's cell."""
    with (
        kernel("--headless") as (address, _),
        virtualrobot.connect(address) as client,
        consoles(address) as console,
    ):
        client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
        client.speed_factor = SLOWLY
        solved, presses = {}, {}
        for script in ("", UNDRAWN):
            with browsers() as browser, proposed(browser, console, client, STEPS, script) as (_, seconds):
                solved[script] = seconds
            with browsers() as browser:
                presses[script] = [press_seconds(browser, console, client, script) for _ in range(ROUNDS)]
        hangs = []
        for _ in range(ROUNDS):
            with browsers() as browser:
                hangs.append(hang_seconds(browser, console, client))
        client.stop()
        until(lambda: not client.motions())
        client.scene.remove("iiwa")
        cell.load(client)
        with browsers() as browser:
            calls, triangles, frame = drawn(browser, console)
    promised = "what is promised"
    return [
        *(
            row(
                f"a goal dragged by a controller: SolveInverse in the page{told}",
                *(1e3 * np.quantile(solved[script], 0.95), 1e3 * INVERSE, promised, "ms", 1.0),
                note=f"p95 of {len(solved[script])}; median {1e3 * np.median(solved[script]):.0f} ms",
            )
            for script, told in BOTH
        ),
        *(
            row(
                f"the trigger in a headset: to the tick of the first movement{told}",
                *(1e3 * np.quantile(presses[script], 0.95), 1e3 * PRESS, promised, "ms", 1.0),
                note=f"p95 of {ROUNDS}; median {1e3 * np.median(presses[script]):.0f} ms",
            )
            for script, told in BOTH
        ),
        row(
            "a headset's page that holds a motion hangs: last beat to standstill",
            *(1e3 * max(hangs), 1e3 * LONGEST, promised, "ms", 1.0),
            note=f"worst of {ROUNDS}; median {1e3 * np.median(hangs):.0f} ms",
        ),
        row("the demo's cell in a headset: draw calls an eye", calls / EYES, CALLS, promised, "calls", 1.0),
        row("the same: triangles an eye", triangles / EYES, TRIANGLES, promised, "triangles", 1.0),
        row("the same: the page's time for a frame", 1e3 * frame, 1e3 * FRAME, promised, "ms", 1.0, "median of 50"),
    ]
