"""Costs of the console's pages: the servers behind them, their first picture, and from a press to a joint that moves.

Fifty arms move on their paths. Each page holds the two watches that have most to tell, of the scene and of the robots'
states, at 30 Hz, as the real one does: a process of its own reads them and draws nothing, so that the kernel and the
console alone are measured, by the processor time that the system counts. When a button was pressed says Chromium, when
the joint moved says the kernel.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import virtualrobot
from playwright.sync_api import Page
from virtualrobot_apps.demos.palletizing import cell

from benchmarks.console import LABEL, Robot, pumped
from benchmarks.processes import kernel, process
from benchmarks.rows import Row, row
from benchmarks.rpc import busy
from tests.apps.console.browsing import PLAIN, browsers, hold
from tests.apps.console.consoles import Console, consoles

ARMS, PAGES, HERTZ = 50, 4, 30.0
SECONDS = 10.0
LOADS, PRESSES = 5, 40

NOTE = """() => {
  addEventListener("pointerdown", ({ timeStamp }) => { window.pressedAt = performance.timeOrigin + timeStamp; }, true);
}"""
"""Keeps the wall-clock time (ms) of the last press."""

READER = """
import json, struct, sys
from websockets.sync.client import connect
from virtualrobot.v1 import robot_pb2, scene_pb2

hertz = float(sys.argv[2])
asked = {
    "SceneService/WatchScene": scene_pb2.WatchSceneRequest(max_rate_hertz=hertz),
    "RobotService/WatchRobotStates": robot_pb2.WatchRobotStatesRequest(max_rate_hertz=hertz),
}
head = struct.Struct(">IB")
with connect(sys.argv[1], max_size=None, compression=None) as socket:
    for number, (method, request) in enumerate(asked.items(), 1):
        socket.send(head.pack(number, 0) + json.dumps({"method": "/virtualrobot.v1." + method}).encode())
        socket.send(head.pack(number, 1) + request.SerializeToString())
        socket.send(head.pack(number, 2))
    for _ in range(10):
        socket.recv()
    print("reading", flush=True)
    while True:
        socket.recv()
"""


def spent(*pids: int) -> float:
    """Return the processor time (s) that processes have taken with all of their threads."""
    ticks = 0
    for pid in pids:
        with open(f"/proc/{pid}/stat") as file:
            ticks += sum(map(int, file.read().rpartition(")")[2].split()[11:13]))
    return ticks / os.sysconf("SC_CLK_TCK")


def shares_of(kernel: int, console: int) -> tuple[float, float]:
    """Return what a kernel takes of a core (%), and what it takes together with a console, by their process ids."""
    before, begin = (spent(kernel), spent(kernel, console)), time.perf_counter()
    time.sleep(SECONDS)
    after, seconds = (spent(kernel), spent(kernel, console)), time.perf_counter() - begin
    return 100.0 * (after[0] - before[0]) / seconds, 100.0 * (after[1] - before[1]) / seconds


@contextmanager
def pages(console: Console, count: int) -> Iterator[None]:
    """Have so many pages read the two watches."""
    url = f"ws://127.0.0.1:{console.port}/calls"
    with ExitStack() as stack:
        for _ in range(count):
            stack.enter_context(process([sys.executable, "-c", READER, url, str(HERTZ)], "reading"))
        yield


def costs() -> list[Row]:
    """Return what watching costs the kernel, and the kernel and the console together."""
    with kernel("--headless") as (address, served), consoles(address) as console:
        busy(address, ARMS)
        shares = {}
        for count in (0, 1, PAGES):
            with pages(console, count):
                shares[count] = shares_of(served.pid, console.process.pid)
    return [
        row(
            f"the kernel while {PAGES} pages watch {ARMS} moving arms at {HERTZ:.0f} Hz, beyond what it takes alone",
            shares[PAGES][0] - shares[0][0],
            20.0,
            "budget",
            "% of a core",
            1.0,
            f"alone {shares[0][0]:.0f}, with one page {shares[1][0]:.0f}; load {os.getloadavg()[0]:.0f}",
        ),
        row(
            f"kernel and console for each further page that watches {ARMS} arms at {HERTZ:.0f} Hz",
            (shares[PAGES][1] - shares[1][1]) / (PAGES - 1),
            10.0,
            "budget",
            "% of a core",
            1.0,
            f"the first page {shares[1][1] - shares[0][1]:.0f}",
        ),
    ]


def loads() -> list[Row]:
    """Return how long the demo's cell takes from asking for the page until it can be used, and until all is drawn."""
    used, drawn = [], []
    with kernel("--headless") as (address, _), consoles(address) as console, browsers() as browser:
        with virtualrobot.connect(address) as client:
            cell.load(client)
        for _ in range(LOADS):
            page = browser.new_page(viewport={"width": 1280, "height": 720})  # with a cache of its own
            begin = time.perf_counter()
            page.goto(console.url + PLAIN, wait_until="commit")
            page.get_by_label(LABEL, exact=True).wait_for()
            used.append(time.perf_counter() - begin)
            page.locator('.view .canvas[aria-busy="false"]').wait_for()
            drawn.append(time.perf_counter() - begin)
            page.close()
    rows = []
    for name, taken in (("its tree and pendant are there", used), ("all is drawn, WebGL on the processor", drawn)):
        note = f"median of {LOADS}; first {taken[0]:.2f} s; load {os.getloadavg()[0]:.0f}"
        what = f"the page with the demo's cell: until {name}"
        rows.append(row(what, sorted(taken)[LOADS // 2], 2.0, "budget", "s", 1.0, note))
    return rows


def presses() -> list[Row]:
    """Return the time from the press of a jog's button to the first tick in which the joint moves, 95 of 100."""
    with (
        kernel("--headless") as (address, _),
        virtualrobot.connect(address) as client,
        consoles(address) as console,
        browsers() as browser,
    ):
        client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="iiwa")
        # As few pixels as will do: drawn on the processor, a large view holds up the page itself for a second.
        page = browser.new_page(viewport={"width": 880, "height": 330})
        page.goto(console.url + PLAIN)
        page.locator('.node[data-name="iiwa"]').click()
        page.evaluate(NOTE)
        robot = Robot(client)
        try:
            taken = sorted(pressed(page, client, robot) for _ in range(PRESSES))
        finally:
            robot.end()
    note = f"{PRESSES} presses; median {taken[PRESSES // 2]:.0f} ms; load {os.getloadavg()[0]:.0f}"
    late = taken[math.ceil(0.95 * PRESSES) - 1]
    return [row("a jog: from the press to the first tick that moves, 95 of 100", late, 60.0, "budget", "ms", 1.0, note)]


def pressed(page: Page, client: virtualrobot.Client, robot: Robot) -> float:
    """Return how long (ms) after the press of a jog's button its joint moves."""
    client.robots["iiwa"].set_positions([0.0] * 7)  # far from the joint's limit
    hold(page, LABEL)
    pumped(page, lambda: robot.moves)
    at = page.evaluate("window.pressedAt")
    page.mouse.up()
    pumped(page, lambda: not robot.moves and not client.motions())
    return 1e3 * (robot.moves_since - time.monotonic() + time.time()) - at


def run() -> list[Row]:
    """Measure and return the rows."""
    return [*costs(), *loads(), *presses()]


if __name__ == "__main__":
    for result in run():
        print(result)
