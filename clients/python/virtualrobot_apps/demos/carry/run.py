"""An arm carries a red prism from table to table, in four steps: it maps the cell, grasps, plans and follows.

As in case study 1 of "A Robotics Framework for Planning the Offshore Robotizing Using Virtual Reality Techniques"
(SimUEP-Robotics, OTC Brasil 2013). Planner and law know what the laser has told and nothing else: plans are made in a
second kernel that holds the arm and its map alone. The true cell is asked only for measuring.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import virtualrobot
from virtualrobot import Client
from virtualrobot.kernel_process import KernelProcess

from virtualrobot_apps.demos.avoidance.control import RECORDED, Gains, Record, Reference, Trajectory, track
from virtualrobot_apps.demos.carry import cell
from virtualrobot_apps.demos.carry.picture import picture
from virtualrobot_apps.demos.mapping.octree_map import Floats
from virtualrobot_apps.pace import Pace
from virtualrobot_apps.seeing import tabletop
from virtualrobot_apps.seeing.arms import Posture
from virtualrobot_apps.seeing.near import NearPoints

POINTS = 6
"""Number of the nearest points of the map that the law knows about each point of the arm."""
GAINS = Gains(k_p=6.0, k_o=12.0, k_r=1.0 / POINTS, repulsion=0.0)
"""The tool goes where the planner has led it: links alone give way."""
APART = 0.08
"""Distance (m) from the map that the planner keeps."""
RISE = 0.15
"""Height (m) over a grasp from which the tool goes straight down."""
STEP, SECONDS, REST = 0.15, 0.8, 1.4
"""Distance (m) from a desired position to the next one, time for each, and for the last one of a leg (s)."""
TURN = 0.35
"""Greatest way of a joint (rad) from a desired position to the next one on a planned path."""
SETTLED = 0.005
"""Position error (m) below which the tool has come to a desired position."""
SAMPLES = 150
"""Number of instants of a run at which true distances are measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Way of the tool: desired poses (n, 4, 4), one after the other, and what the hand does at the end of it."""

    poses: Floats
    hand: str


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Run of the task.

    times: (n,) (s), and errors: (n, 3) position errors then (m). instants: (m,) times of distances (m, l) of links from
    the true obstacles (m), RECORDED at most. settling: mean time (s) from a change of the desired position to an error
    below SETTLED. off: distance (m) of the prism from where it was to come to. touched: whether both fingers felt it.
    """

    times: Floats
    errors: Floats
    links: tuple[str, ...]
    instants: Floats
    distances: Floats
    settling: float
    off: float
    touched: bool

    @property
    def least(self) -> float:
        """Least distance of a link from an obstacle (m)."""
        return float(self.distances.min())


def main(client: Client, pace: float = 0.0, plot: Path | None = None) -> tuple[Run, Run]:
    """Replace the world by the cell, carry the prism without and with avoidance, print how it went, and return it.

    Args:
        client: of the kernel.
        pace: simulated seconds for each second of the wall clock; 0: as fast as it can be.
        plot: file of the picture, an SVG.
    """
    client.clock.set_stepped()
    cell.build(client)
    with KernelProcess("--stepped", headless=True) as kernel, virtualrobot.connect(kernel.address) as mind:
        legs, centers, thing = plan(client, mind)
    runs = [follow(client, legs, centers, thing, gains, pace) for gains in (replace(GAINS, alpha=0.0), GAINS)]
    print("avoidance  least distance of a link  error at the end  settles in  prism off by")
    for name, one in zip(("without", "with"), runs, strict=True):
        print(
            f"{name:9} {1e3 * one.least:21.0f} mm {1e3 * np.linalg.norm(one.errors[-1]):14.2f} mm "
            f"{one.settling:9.2f} s {1e3 * one.off:10.1f} mm",
            flush=True,
        )
    print("the document: without 65 mm, with about 100 mm at least but at the start; both errors go to zero")
    if plot is not None:
        plot.write_text(picture(*runs), "utf-8")
        print(f"picture in {plot}", flush=True)
    return runs[0], runs[1]


def plan(client: Client, mind: Client) -> tuple[list[Leg], Floats, tabletop.Thing]:
    """Map the cell, find the prism and its grasp, and plan; return the legs, the map (n, 3) and the prism."""
    mind.scene.clear()
    cell.load_arm(mind)
    looks = tabletop.Looks(client, cell.SETUP)
    looks.around()
    looks.closely(mind, cell.FROM)
    octree, cloud = looks.octree, looks.cloud
    told = tabletop.occupied(octree)
    print(
        f"1 map: {len(cloud.points):,} echoes, {len(told):,} voxels of {tabletop.RESOLUTION:g} m occupied", flush=True
    )
    thing = tabletop.thing_on(mind, cell.SETUP, cloud, octree, cell.FROM)
    wide, deep, high = np.round(1e3 * np.sort(thing.size))
    print(f"2 grasp: {wide:.0f} x {deep:.0f} x {high:.0f} mm, {1e3 * thing.width:.0f} mm between fingers", flush=True)
    arm = mind.robot(cell.ARM)
    rise = virtualrobot.pose(z=RISE)
    put = thing.grasp.copy()
    put[:2, 3] = cell.TO
    put[2, 3] += tabletop.top_of(cloud, cell.TO, cell.HALF) - tabletop.bottom_of(thing) + 0.002
    start = dict(zip(arm.chain_joint_names, cell.HOME, strict=True))
    over = arm.solve_inverse(rise @ thing.grasp, seed=thing.posture).by_name()
    there = tabletop.path(mind, cell.ARM, start, over, APART)
    tabletop.hold(mind, cell.ARM, thing)
    across = tabletop.path(mind, cell.ARM, over, rise @ put, APART)
    tabletop.let_go(mind, cell.ARM)
    home = tabletop.path(mind, cell.ARM, across[-1], start, APART)
    legs = [
        Leg(steps(mind, there, thing.grasp), "grip"),
        Leg(steps(mind, across, put, rise @ thing.grasp), "release"),
        Leg(steps(mind, home, None, rise @ put), ""),
    ]
    count = [len(leg.poses) for leg in legs]
    print(f"3 plan: {sum(count)} desired positions in {len(legs)} legs of {', '.join(map(str, count))}", flush=True)
    return legs, tabletop.occupied(octree, thing), thing


def steps(mind: Client, postures: Sequence[Posture], end: Floats | None, begin: Floats | None = None) -> Floats:
    """Return poses (n, 4, 4), STEP apart: from `begin`, along a path of postures, and straight to an end."""
    arm, found = mind.robot(cell.ARM), [] if begin is None else [begin]
    for first, second in pairwise(postures):
        a, b = (arm.solve_forward(one).world_t_tcp[:3, 3] for one in (first, second))
        count = max(1, int(np.ceil(np.linalg.norm(b - a) / STEP)), int(np.ceil(_turn(first, second) / TURN)))
        for part in np.arange(1, count + 1) / count:
            between = {name: (1.0 - part) * first[name] + part * second[name] for name in first}
            found.append(arm.solve_forward(between).world_t_tcp)
    if end is not None:
        found += [virtualrobot.pose(z=0.5 * RISE) @ end, end]
    return np.array(found)


def _turn(first: Posture, second: Posture) -> float:
    """Return the greatest way of a joint (rad)."""
    return max(abs(first[name] - second[name]) for name in first)


def consecutive(poses: Floats) -> Trajectory:
    """Return a trajectory of desired positions (n, 4, 4), each for SECONDS; it stays at the last one."""

    def trajectory(time: float) -> Reference:
        return Reference(poses[min(int(time / SECONDS), len(poses) - 1)], np.zeros(3), np.zeros(3))

    return trajectory


def follow(
    client: Client, legs: Sequence[Leg], centers: Floats, thing: tabletop.Thing, gains: Gains, pace: float
) -> Run:
    """Carry the prism in the cell as it was at the start; return how it went."""
    cell.build(client)
    arm, keeper = client.robot(cell.ARM), Pace(pace)
    begun = client.clock.read().stamp.simulation_time
    records: list[tuple[float, Record]] = []
    touched, time, settled = False, 0.0, list[float]()

    def each(_: float) -> None:
        keeper.keep(client.clock.read().stamp.simulation_time - begun)

    watch: Callable[[float], None] = each if pace else lambda _: None
    for leg in legs:
        seconds = SECONDS * (len(leg.poses) - 1) + REST
        known = NearPoints(arm, centers, RECORDED, POINTS)
        record = track(client, arm, consecutive(leg.poses), seconds, gains, watch, known)
        records.append((time, record))
        settled += settling(record, len(leg.poses))
        time += record.times[-1]
        if leg.hand == "grip":
            touched = tabletop.grip(client, cell.ARM, cell.FINGERS, thing.width)
        elif leg.hand == "release":
            arm.place()
            client.clock.run(arm.tool().move_to_width(cell.OPEN, wait=False))
    goal = virtualrobot.pose(*cell.TO)[:2, 3] + (thing.world_t_box - thing.grasp)[:2, 3]
    off = float(np.linalg.norm(client.scene.pose(cell.PRISM)[:2, 3] - goal))
    times = np.concatenate([at + record.times for at, record in records])
    postures = np.vstack([record.positions for _, record in records])
    instants = np.linspace(0, len(times) - 1, SAMPLES).astype(int)
    links, distances = true_distances(
        client, [dict(zip(arm.chain_joint_names, postures[n], strict=True)) for n in instants]
    )
    errors = np.vstack([record.errors for _, record in records])
    return Run(times, errors, links, times[instants], distances, float(np.mean(settled)), off, touched)


def settling(record: Record, count: int) -> list[float]:
    """Return the times (s) from changes of the desired position to an error below SETTLED; SECONDS where never."""
    away = np.linalg.norm(record.errors, axis=1)
    found = []
    for number in range(count):
        mine = (record.times >= number * SECONDS) & ((record.times < (number + 1) * SECONDS) | (number == count - 1))
        near = record.times[mine & (away < SETTLED)]
        found.append(float(near[0] - number * SECONDS) if len(near) else SECONDS)
    return found


def true_distances(client: Client, postures: Sequence[Posture]) -> tuple[tuple[str, ...], Floats]:
    """Return links and their distances (n, l) from the true obstacles with the arm in n postures (m), for measuring."""
    rows: list[dict[str, float]] = []
    for posture in postures:
        found: dict[str, float] = {}
        for pair in client.collisions.distances(
            cell.ARM, max_distance=RECORDED, to=[cell.OBSTACLES], configurations={cell.ARM: posture}
        ):
            if pair.first.startswith(f"{cell.ARM}."):
                found.setdefault(pair.first, pair.distance)
        rows.append(found)
    links = tuple(link for link in client.robot(cell.ARM).links if any(link in row for row in rows))
    return links, np.array([[row.get(link, RECORDED) for link in links] for row in rows])
