"""A command of `virtualrobot shell`, in its one process, against its budget and against a process of its own."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import time

import numpy as np
import virtualrobot
from virtualrobot.cli.options import Session, Target
from virtualrobot.cli.shell import run_line

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

LINES = ("ls", "state arm", "signal gate on", "speed 0.5", "rename b c", "rename c b")
ROUNDS = 20
BUDGET_MILLISECONDS = 20.0


def run() -> list[Row]:
    """Measure and return the rows."""
    with kernel("--headless") as (address, _), virtualrobot.connect(address) as client:
        client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
        client.signals.create("gate", False)
        client.scene.add_object("b", virtualrobot.box(0.1, 0.1, 0.1))
        target = Target(session=Session(client))
        seconds = []
        for _ in range(ROUNDS + 1):
            for line in LINES:
                start = time.perf_counter()
                with contextlib.redirect_stdout(io.StringIO()):
                    assert run_line(line, target) == 0
                seconds.append(time.perf_counter() - start)
        ours = 1e3 * float(np.median(seconds[len(LINES) :]))  # the first round imports the commands
        start = time.perf_counter()
        command = [sys.executable, "-m", "virtualrobot", "ls", "--address", address]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        alone = 1e3 * (time.perf_counter() - start)
    return [
        row("a command of the shell, p50", ours, BUDGET_MILLISECONDS, "the budget", "ms", 1.0),
        row("a command of the shell, p50", ours, alone, "the same as a process of its own", "ms", None),
    ]


if __name__ == "__main__":
    for result in run():
        print(result)
