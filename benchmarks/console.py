"""Pages of the console that end while a jog is held: how soon after its last beat the robot stands, on the wall clock.

A page that hangs never comes to its next beat; one that is killed (its renderer, by SIGKILL) takes its connection with
it. When a beat was sent says Chromium (`Network.webSocketFrameSent`, whose clock is CLOCK_MONOTONIC), and where the
robot was at which time says the kernel, whose ticks follow the wall clock. A beat is good for 0.2 s; then it brakes.
"""

from __future__ import annotations

import base64
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import virtualrobot
from playwright.sync_api import Browser, CDPSession, Page
from virtualrobot import Client
from virtualrobot.v1 import robot_pb2

from benchmarks.processes import kernel
from benchmarks.rows import Row, row
from tests.apps.console.browsing import PLAIN, browsers, hold
from tests.apps.console.consoles import Console, consoles
from tests.waiting import until

ROUNDS = 10
LONGEST = 0.3
"""Time (s) from the last beat to standstill that the console promises."""

JOINT = 0
LABEL = "J1 lbr_iiwa_joint_1 plus"
HANG = "() => { setTimeout(() => { for (;;); }, 0); }"

End = Callable[[Browser, Page], None]


def hang(browser: Browser, page: Page) -> None:
    """Have a page compute for ever."""
    page.evaluate(HANG)


def kill(browser: Browser, page: Page) -> None:
    """Kill the process that runs a page."""
    processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    for one in processes:
        if one["type"] == "renderer":
            os.kill(one["id"], signal.SIGKILL)


class Robot:
    """Robot as the kernel tells it: since when it moves or stands, on the clock of `time.monotonic`."""

    def __init__(self, client: Client) -> None:
        """Begin to watch it."""
        self.moves = False
        self.moves_since = self.stands_since = 0.0
        self._offset = time.monotonic() - time.time()
        self._stream = client.services.robot.WatchRobotStates(robot_pb2.WatchRobotStatesRequest(max_rate_hertz=250.0))
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        with self._stream as stream:
            for told in stream:
                for robot in told.robots:
                    moves = robot.velocities[JOINT] != 0.0
                    time_of_tick = told.stamp.wall_time.ToNanoseconds() * 1e-9 + self._offset
                    if moves and not self.moves:
                        self.moves_since = time_of_tick
                    if self.moves and not moves:
                        self.stands_since = time_of_tick
                    self.moves = moves

    def end(self) -> None:
        """Watch it no more."""
        self._stream.cancel()


@contextmanager
def beats(page: Page) -> Iterator[list[float]]:
    """Give the times (s) at which a page sends what names a motion: its beats, while a jog is held."""
    sent: list[float] = []

    def note(event: dict[str, Any]) -> None:
        if b"motion-" in base64.b64decode(event["response"]["payloadData"] + "==="):
            sent.append(event["timestamp"])

    session: CDPSession = page.context.new_cdp_session(page)
    session.on("Network.webSocketFrameSent", note)
    session.send("Network.enable")
    yield sent


def seconds(client: Client, console: Console, end: End) -> float:
    """Return how long (s) after the last beat of a page that ends the robot stands."""
    client.stop()  # the jog before waits for beats
    until(lambda: not client.motions())
    client.robots["iiwa"].set_positions([0.0, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0])
    robot = Robot(client)
    try:
        with browsers() as browser:
            page = browser.new_page(viewport={"width": 1100, "height": 700})
            with beats(page) as sent:
                page.goto(console.url + PLAIN)
                page.locator('.node[data-name="iiwa"]').click()
                hold(page, LABEL)
                pumped(page, lambda: robot.moves and len(sent) > 10)
                end(browser, page)
                until(lambda: not robot.moves)
                browser.new_browser_cdp_session().send("Browser.getVersion")  # takes what was told meanwhile
                return robot.stands_since - sent[-1]
    finally:
        robot.end()


def pumped(page: Page, holds: Callable[[], bool]) -> None:
    """Wait until something holds while events of a page are taken."""
    until(lambda: page.wait_for_timeout(20.0) or holds())


def run() -> list[Row]:
    """Return the slowest of all rounds for each way in which a page ends."""
    rows = []
    with (
        kernel("--headless") as (address, _),
        virtualrobot.connect(address) as client,
        consoles(address) as console,
    ):
        client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
        for name, end in (("hangs", hang), ("is killed", kill)):
            taken = [seconds(client, console, end) for _ in range(ROUNDS)]
            note = f"worst of {ROUNDS}; median {sorted(taken)[ROUNDS // 2] * 1e3:.0f} ms"
            what = f"a page that holds a jog {name}: last beat to standstill"
            rows.append(row(what, 1e3 * max(taken), 1e3 * LONGEST, "what is promised", "ms", 1.0, note))
    return rows
