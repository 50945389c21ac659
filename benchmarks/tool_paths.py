"""Tool paths of an IRB 2400 on seams of a tee of two pipes: the search against Descartes, and what is found.

Descartes is no package of PyPI by itself; `tesseract-robotics` of PyPI has it (`tool_path_peers`). It knows no speeds:
what it finds may jump from frame to frame, which is told beside how long it takes.
"""

from __future__ import annotations

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError

from benchmarks import tool_path_peers
from benchmarks.processes import kernel
from benchmarks.rows import Row, row

MAIN, BRANCH = 0.15, 0.08
"""Radii of the pipes (m)."""
COUNT, ROTATIONS, SEAMS = 1000, 36, 20
SPEED, JUMP = 0.02, 0.5
"""Speed of the tool (m/s), and the step of a joint (rad) from one of 1,000 frames to the next that is a jump."""
BUDGET = 0.35
PEER = "Descartes (tesseract-robotics)"


def saddle(count: int, turn: float) -> NDArray[np.float64]:
    """Return frames (n, 4, 4) on the seam of a tee, from an angle about the branch on; the tool along its bisector.

    The branch, about z, stands on the main pipe, about y: x = r cos a, y = r sin a, z = sqrt(R^2 - x^2).
    """
    angles = turn + np.linspace(0.0, 1.9 * np.pi, count)
    x, y = BRANCH * np.cos(angles), BRANCH * np.sin(angles)
    points = np.stack([x, y, np.sqrt(MAIN**2 - x**2)], axis=1)
    main = points * [1.0, 0.0, 1.0] / MAIN
    branch = points * [1.0, 1.0, 0.0] / BRANCH
    return virtualrobot.path_frames(points, -(main + branch))


def placed(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return where a tee stands (4, 4): before the arm, turned at random and tilted by up to 30 degrees."""
    x, y, z = rng.uniform((0.6, -0.5, 0.3), (1.2, 0.5, 1.0))
    roll, pitch = rng.uniform(-0.5, 0.5, 2)
    return virtualrobot.pose(x, y, z, roll=roll, pitch=pitch, yaw=rng.uniform(-np.pi, np.pi))


def run() -> list[Row]:
    """Measure."""
    rng = np.random.default_rng(23)
    seams = [placed(rng) @ saddle(COUNT, rng.uniform(-np.pi, np.pi)) for _ in range(SEAMS)]
    with kernel("--headless") as (address, _), virtualrobot.connect(address, token="") as client:
        client.load_robot("model://irb2400_16_155", name="arm")
        found(client, seams[0])  # the first search starts its process
        alone = [found(client, frames) for frames in seams]
        client.scene.clear()
        client.load_robot("model://rail", name="rail")
        client.load_robot("model://irb2400_16_155", name="arm", parent="rail.carriage")
        railed = [found(client, frames, "rail") for frames in seams]
    led, carried = ([one for one in times if one is not None] for times in (alone, railed))
    note = f"median of {len(led)} of {SEAMS} seams, {COUNT} frames x {ROTATIONS} rotations, with motion and proof"
    return [
        *beside_descartes(seams, led, note),
        row("seams that are led along with a rail", len(carried), len(led), "without", "", None, f"of {SEAMS}"),
        row("a tool path with a rail", median(carried), median(led), "without", "s", None),
    ]


def beside_descartes(seams: list[NDArray[np.float64]], led: list[float], note: str) -> list[Row]:
    """Return rows of how long ways were looked for (s) and how many there are, beside Descartes where it is there."""
    title = "a tool path on a tee of pipes"
    if not tool_path_peers.is_there():
        found_alone = row("seams that are led along", len(led), len(seams), "all of them", "", None)
        return [row(title, median(led), 0.0, f"{PEER}: not installed", "s", None, note), found_alone]
    theirs = tool_path_peers.searched(seams, ROTATIONS)
    smooth = sum(step is not None and step < JUMP for _, step in theirs)
    peer = median([seconds for seconds, step in theirs if step is not None])
    return [
        row(title, median(led), peer, PEER, "s", BUDGET, note),
        row("seams that are led along without a jump", len(led), smooth, PEER, "", None, f"of {len(seams)}"),
    ]


def median(times: list[float]) -> float:
    """Return the median; 0 of none."""
    return float(np.median(times)) if times else 0.0


def found(client: Client, frames: NDArray[np.float64], *external: str) -> float | None:
    """Return how long the kernel looked for a way along frames (s), with robots that move along; None without one."""
    free = {"rotation_z": "free"}
    try:
        return client.paths.find_tool_path("arm", frames, SPEED, tolerance=free, external=external).planning_time
    except VirtualRobotError:
        return None


if __name__ == "__main__":
    for result in run():
        print(result)
