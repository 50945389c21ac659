"""The page in a room by an emulated headset: how soon goals and hands are answered, and what is drawn.

When calls go and come, hands move and triggers are pulled is told in the page, by its clock; where the robot was at
which time says the kernel, whose ticks follow the wall clock.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import virtualrobot
from playwright.sync_api import Browser, expect
from virtualrobot import Client
from virtualrobot.v1 import robot_pb2
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
DRAG_SECONDS = 6.0
LEAD_SECONDS = 1.5
"""Times in which a goal is dragged along its way, and in which a hand leads the tool there: with 94 mm/s."""

SLOWLY = 0.2
"""Speed factor of the cell, with which the short way takes so long that a page may hang on it."""

SPEED = float(np.linalg.norm(WAY)) / LEAD_SECONDS

INVERSE, PRESS, LAG = 0.033, 0.060, 0.050
"""Times (s) that are promised: from a goal to its posture, from the trigger to the tick of the first movement, and by
which a tool that a hand leads is behind it."""

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

CALLS_TIMED = """
window.took = {};
const begun = new Map(), Socket = WebSocket, text = new TextDecoder();
window.WebSocket = class extends Socket {
  send(data) {
    const view = new DataView(data.buffer), begins = view.getUint8(4) === 0;
    const path = begins && JSON.parse(text.decode(data.subarray(5))).method;
    if (path) begun.set(view.getUint32(0), [path.split("/").pop(), performance.now()]);
    super.send(data);
  }
  set onmessage(hear) {
    super.onmessage = hear && ((event) => {
      const view = new DataView(event.data), [method, since] = begun.get(view.getUint32(0)) ?? [];
      if (method && view.getUint8(4) === 2) (took[method] ??= []).push(performance.now() - since);
      hear(event);
    });
  }
};
window.clock = () => performance.timeOrigin + performance.now();
// Goes a way at a constant speed, and tells when it began, by the clock of the wall.
window.go = async (way, seconds) => {
  const { position } = atHand(), from = [position.x, position.y, position.z], begin = clock();
  for (let part = 0; part < 1; ) {
    part = Math.min((clock() - begin) / 1000 / seconds, 1);
    position.set(...from.map((at, axis) => at + part * way[axis]));
    await frames(1);
  }
  return begin / 1000;
};
"""
"""Tells how long (ms) calls of the page took, from their first frame sent until it has heard their last one."""

HIDDEN = "() => { document.documentElement.style.visibility = 'hidden'; }"
"""Has the browser paint nothing of the page: headsets don't, as long as they show a room."""


def hand_goes(person: Person, way: Sequence[float], seconds: float) -> float:
    """Have the hand go a way of the world at a constant speed; return when it began (s, as `time.monotonic`)."""
    right, ahead, up = person.turned(way)
    begin = person.page.evaluate("([way, seconds]) => go(way, seconds)", [[right, up, -ahead], seconds])
    return begin + time.monotonic() - time.time()


@contextmanager
def entered(browser: Browser, console: Console, client: Client, script: str = "") -> Iterator[Person]:
    """Give a person before an arm that stands, with nothing proposed; the page runs a script before its own."""
    client.stop()
    until(lambda: not client.motions())
    for one in client.proposals.list():
        if one.state == "proposed":
            client.proposals.reject(one)
    client.robots["iiwa"].set_positions(HERE)
    with in_room(browser, console, "iiwa", script=script + CALLS_TIMED) as person:
        if script == UNDRAWN:
            person.page.evaluate(HIDDEN)
        yield person


@contextmanager
def proposed(
    browser: Browser, console: Console, client: Client, seconds: float = 0.3, script: str = ""
) -> Iterator[tuple[Person, list[float]]]:
    """Give a person who points at Hold to run, and how long (s) each of the goals on the way there took."""
    with entered(browser, console, client, script) as person:
        person.reach(client.robots["iiwa"].tcp[:3, 3])
        person.squeeze(1)
        hand_goes(person, WAY, seconds)
        took = person.page.evaluate("took.SolveInverse")
        person.page.evaluate("still", 120)  # longer than the page looks back when a hand lets go, 80 ms
        person.squeeze(0)
        expect(person.told).to_contain_text("free")
        person.point("hold")
        yield person, (1e-3 * np.array(took)).tolist()


def press_seconds(browser: Browser, console: Console, client: Client) -> float:
    """Return how long (s) after the trigger the robot's first tick of movement is."""
    robot = Robot(client)
    try:
        with proposed(browser, console, client, script=UNDRAWN) as (person, _):
            pressed = person.page.evaluate("() => { atHand().updateButtonValue('trigger', 1); return clock() / 1000; }")
            pumped(person.page, lambda: robot.moves)
            return robot.moves_since - (pressed + time.monotonic() - time.time())
    finally:
        robot.end()


def lags(browser: Browser, console: Console, client: Client) -> list[float]:
    """Return how much later (s) than a hand that leads it the tool is at each place, once it goes as fast."""
    offset = time.monotonic() - time.time()
    seen: list[tuple[float, list[float]]] = []

    def watch() -> None:
        with states as told:
            for one in told:
                at = one.robots[0].world_t_tcp.position
                seen.append((one.stamp.wall_time.ToNanoseconds() * 1e-9 + offset, [at.x, at.y, at.z]))

    with entered(browser, console, client, UNDRAWN) as person:
        tool = client.robots["iiwa"].tcp[:3, 3]
        person.press("lead")
        person.reach(tool)
        person.squeeze(1)
        states = client.services.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(max_rate_hertz=250.0))
        watching = threading.Thread(target=watch, daemon=True)
        watching.start()
        begin = hand_goes(person, WAY, LEAD_SECONDS)
        person.squeeze(0)
        states.cancel()
        watching.join()
    times, places = np.array([time for time, _ in seen]), np.array([place for _, place in seen])
    parts = (places - tool) @ WAY / np.dot(WAY, WAY)
    return (times - begin - parts * LEAD_SECONDS)[
        (parts > 0.4) & (parts < 0.95) & (times < begin + LEAD_SECONDS)
    ].tolist()


def hang_seconds(browser: Browser, console: Console, client: Client) -> float:
    """Return how long (s) after the last beat of a headset's page that hangs the robot stands."""
    robot = Robot(client)
    try:
        with proposed(browser, console, client, script=UNDRAWN) as (person, _), beats(person.page) as sent:
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
        solved = {}
        for script, _ in BOTH:
            with browsers() as browser, proposed(browser, console, client, DRAG_SECONDS, script) as (_, seconds):
                solved[script] = seconds
        with browsers() as browser:
            presses = [press_seconds(browser, console, client) for _ in range(ROUNDS)]
        client.speed_factor = 1.0
        with browsers() as browser:
            behind = lags(browser, console, client)
        client.speed_factor = SLOWLY
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
        row(
            "the trigger in a headset: to the tick of the first movement, nothing drawn",
            *(1e3 * np.quantile(presses, 0.95), 1e3 * PRESS, promised, "ms", 1.0),
            note=f"p95 of {ROUNDS}; median {1e3 * np.median(presses):.0f} ms",
        ),
        row(
            f"a hand leads the tool at {1e3 * SPEED:.0f} mm/s: by how much it comes later, nothing drawn",
            *(1e3 * np.quantile(behind, 0.95), 1e3 * LAG, promised, "ms", 1.0),
            note=f"p95 of {len(behind)}; median {1e3 * np.median(behind):.0f} ms",
        ),
        row(
            "a headset's page that holds a motion hangs: last beat to standstill, nothing drawn",
            *(1e3 * max(hangs), 1e3 * LONGEST, promised, "ms", 1.0),
            note=f"worst of {ROUNDS}; median {1e3 * np.median(hangs):.0f} ms",
        ),
        row("the demo's cell in a headset: draw calls an eye", calls / EYES, CALLS, promised, "calls", 1.0),
        row("the same: triangles an eye", triangles / EYES, TRIANGLES, promised, "triangles", 1.0),
        row("the same: the page's time for a frame", 1e3 * frame, 1e3 * FRAME, promised, "ms", 1.0, "median of 50"),
    ]
