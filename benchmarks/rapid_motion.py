"""RAPID on a robot: how soon it moves after its start, and whether it stands on a way of blended lines."""

from __future__ import annotations

import os
import statistics

import numpy as np
import virtualrobot
from virtualrobot_apps.languages.core.source import Source
from virtualrobot_apps.languages.rapid.task import RapidTask, load
from virtualrobot_apps.languages.rapid.world import World

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

TRIES = 5
LINES = 43
"""Number of lines of a way that took 6.6 s to plan before anything moved, when programs were planned as a whole."""
TICK = 0.004
"""Time (s) from one sample to the next; one that is lost counts as a standstill."""
READY = (0.0, 0.2, 0.2, 0.0, 1.0, 0.0)
LINE = "MoveL Offs(here, {}, {}, 0), v100, z5, tool0;\n"
PROGRAM = (
    "MODULE Blended\nPROC main()\nVAR robtarget here;\nhere := CRobT(\\Tool:=tool0);\n"
    + "".join(LINE.format(-2 * number, 30 * (number % 2)) for number in range(1, LINES))
    + "MoveL here, v100, fine, tool0;\nENDPROC\nENDMODULE\n"
)


def way(client: virtualrobot.Client, arm: virtualrobot.Robot) -> tuple[float, float]:
    """Return the time of the simulation until the tool moves, and its longest standstill from then on (s)."""
    arm.set_positions(READY)
    task = RapidTask(load([Source(PROGRAM)]), World(client, "arm"))
    rows = []
    with client.streams.watch("/robots/arm/tcp") as watch:
        start = client.clock.simulation_time
        task.run()
        end = client.clock.simulation_time
        while (sample := watch.next(1.0)) is not None and sample.time < end:
            rows.append([sample.time, *(sample.values[axis] for axis in "xyz")])
    times, places = np.split(np.array([one for one in rows if one[0] >= start]), [1], axis=1)
    moved = times[1:, 0][np.linalg.norm(np.diff(places, axis=0), axis=1) > 1e-9]
    return float(moved[0] - start), round(float(np.diff(moved).max()) - TICK, 9)


def run() -> list[Row]:
    """Return the rows; budgets: it moves within 100 ms of the simulation, and never stands."""
    with kernel("--headless") as (address, _), virtualrobot.connect(address) as client:
        arm = client.load_robot("model://irb120", name="arm")
        way(client, arm)  # what is compiled once
        found = [way(client, arm) for _ in range(TRIES)]
    first, stood = statistics.median(one for one, _ in found), max(one for _, one in found)
    longest, load_average = max(one for one, _ in found), os.getloadavg()[0]
    note = f"longest of {TRIES}: {1e3 * longest:.0f} ms; {load_average:.0f} threads on {os.cpu_count()} cores"
    return [
        row(f"{LINES} blended lines: from the start to the first movement", first, 0.1, "100 ms", "s", 1.0, note),
        row(f"{LINES} blended lines: longest standstill on the way", stood, TICK, "a tick", "s", 0.0),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
