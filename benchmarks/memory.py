"""Memory of a kernel in which worlds are loaded and cleared for long, against itself after the first ones.

A cycle loads an iiwa, a Panda and a box, watches for collisions, solves, moves, scans and clears the world. What may
grow is bounded: the journal to 64 MiB (63 kB a cycle), arms, ended motions and events to some hundreds each.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot import Client

from benchmarks.processes import kernel
from benchmarks.rows import Row, row

CYCLES, WARM = 300, 50
JOURNAL_KILOBYTES = 63.0
"""Size of what the journal keeps of a cycle (kB): the commands of both models, by `world/journal.py`'s own weight."""

IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
PANDA = "package://pybullet_data/franka_panda/panda.urdf"


def cycle(client: Client) -> None:
    """Load, use and clear a world."""
    arm = client.load_robot(IIWA, name="iiwa")
    client.load_robot(PANDA, name="panda", pose=virtualrobot.pose(1.0))
    client.scene.add_object("box", virtualrobot.box(1.0, 1.0, 0.1), pose=virtualrobot.pose(0.0, 2.0))
    client.collisions.set("monitor")
    client.collisions.check(detail="contacts")
    fan = virtualrobot.fan(100, -1.0, 1.0)
    client.scene.add_range_sensor("lidar", virtualrobot.range_sensor(pattern=fan), pose=virtualrobot.pose(-1.0, z=0.5))
    client.sensors.start()
    arm.solve_inverse(virtualrobot.pose(0.5, 0.1, 0.6, roll=np.pi))
    client.clock.run(arm.move_joints({"lbr_iiwa_joint_2": 0.1}, wait=False))
    client.scene.clear()


def megabytes(process: int) -> float:
    """Return how much memory of the machine a process has (MB); Linux only."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) * 1.024e-3


def measured(cycles: int, warm: int) -> tuple[float, float]:
    """Return a kernel's memory (MB) after the first cycles, and after all."""
    with kernel("--headless", "--stepped") as (address, process), virtualrobot.connect(address) as client:
        for _ in range(warm):
            cycle(client)
        before = megabytes(process.pid)
        for _ in range(cycles - warm):
            cycle(client)
        return before, megabytes(process.pid)


def run() -> list[Row]:
    """Measure and return the row."""
    before, after = measured(CYCLES, WARM)
    # What the journal takes is Python's objects, which take nearly twice their weight.
    allowed = 1.05 + 2.0 * JOURNAL_KILOBYTES * 1e-3 * (CYCLES - WARM) / before
    name = f"memory after {CYCLES} worlds loaded and cleared"
    return [row(name, after, before, f"the same kernel after {WARM}", "MB", allowed)]
