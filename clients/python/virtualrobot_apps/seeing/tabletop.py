"""Knowledge of an arm about what stands on tables round it: an octree and a cloud of what its laser has told.

All poses are in the frame of the arm's base: joints alone tell them. `mind` is a client of a second kernel, which holds
the arm at its origin and the octree's voxels and nothing else: so plans are made of what was seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from virtualrobot_apps.demos.mapping.octree_map import Floats, OctreeMap, centers_of
from virtualrobot_apps.seeing.arms import Eye, Posture, postures
from virtualrobot_apps.seeing.grasping.antipodal import grasps
from virtualrobot_apps.seeing.grasping.jaw import Jaw
from virtualrobot_apps.seeing.grasping.surface import surface_of_cloud
from virtualrobot_apps.seeing.views.planning import views_around

RESOLUTION = 0.03
"""Edge of a voxel (m)."""
LOW, HIGH = np.array([-0.3, -0.7, 0.06]), np.array([0.9, 0.7, 1.2])
"""Corners of the workspace: what is beyond is left out (m)."""
ABOVE = 0.012
"""Height (m) over a table from which on echoes belong to what stands on it."""
AVERAGED = 0.005
"""Edge of the cubes whose echoes become one point (m)."""
SAMPLES = 1500
"""Number of points of a table that fingers may not touch."""
MAP, THING = "map", "thing"
CLOSING, TIGHT = 0.002, 0.012
"""Width (m) by which fingers close at a time, and by how much less than the width that was seen they close at most."""
VIEWS = 4
"""Number of looks at a thing."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Arm of seven axes with a laser and a jaw, by the names of both.

    home: posture (rad) from which it looks about and to which it returns. looks: postures (rad) about home with which
    it does; nothing is in the way there. half: half the edge of the square of a table that is looked at (m).
    """

    arm: str
    laser: str
    jaw: Jaw
    home: tuple[float, ...]
    looks: tuple[tuple[float, ...], ...]
    half: float


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Echoes (n, 3) of all looks, and from where each was seen (n, 3)."""

    points: Floats
    seen_from: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Thing that stands on a table: pose (4, 4) and size (3,) of the box about it, along its grasp's axes (m).

    grasp: pose (4, 4) of the tool. posture: that reaches it. width: of the body between the fingers (m).
    """

    world_t_box: Floats
    size: Floats
    grasp: Floats
    posture: Posture
    width: float


class Looks:
    """Looks of the arm: an octree and a cloud that grow with each."""

    def __init__(self, client: Client, setup: Setup) -> None:
        """Take the arm of a kernel, at home."""
        self._client, self._setup, self._arm = client, setup, client.robot(setup.arm)
        self._eye = Eye(client, setup.arm, setup.laser)
        self.octree = OctreeMap(RESOLUTION)
        self.held: Thing | None = None
        """Thing in the hand: its echoes are left out."""
        self._points, self._places = list[Floats](), list[Floats]()

    @property
    def cloud(self) -> Cloud:
        """Return all echoes."""
        return Cloud(np.vstack(self._points), np.vstack(self._places))

    def around(self) -> None:
        """Look from the postures about home where nothing is in the way."""
        for posture in self._setup.looks:
            self.go(posture)
            self._look()
        self.go(self._setup.home)

    def closely(self, mind: Client, middle: Sequence[float]) -> None:
        """Look at what stands about a place (2,) on a table, from VIEWS sides, on ways that are free in the map."""
        tell(mind, occupied(self.octree))
        top = top_of(self.cloud, middle, self._setup.half)
        target = np.array([*middle, top + 0.05])
        views = views_around(target, np.array([0.33]), 14, lowest=top + 0.16)
        found = Eye(mind, self._setup.arm, self._setup.laser).postures(views)
        free = [number for number, posture in enumerate(found) if posture is not None]
        if not free:
            raise WrongStateError(f"none of {len(views)} views of {middle} is in reach")
        at: Posture = dict(zip(self._arm.chain_joint_names, self._setup.home, strict=True))
        home, chosen = at, list[int]()
        for _ in range(min(VIEWS, len(free))):
            # The next one is the furthest from those that it has had.
            places = views[free, :3, 3]
            off = [np.linalg.norm(places - views[one, :3, 3], axis=1) for one in chosen] or [np.zeros(len(free))]
            chosen.append(free[int(np.min(off, axis=0).argmax())])
            goal = found[chosen[-1]]
            assert goal is not None
            self.along(path(mind, self._setup.arm, at, goal))
            at = goal
            self._look()
        self.along(path(mind, self._setup.arm, at, home))

    def along(self, postures: Sequence[Posture]) -> None:
        """Go along postures, the first of which is where the arm is."""
        for posture in postures[1:]:
            self.go(posture)

    def go(self, posture: Posture | Sequence[float]) -> None:
        """Go to a posture."""
        goal = posture if isinstance(posture, dict) else list(posture)
        self._client.clock.run(self._arm.move_joints(goal, wait=False))

    def _look(self) -> None:
        place, echoes = self._eye.look()
        base = np.linalg.inv(self._client.scene.pose(self._setup.arm))  # what is told in the world is meant in the base
        place, echoes = base[:3, :3] @ place + base[:3, 3], echoes @ base[:3, :3].T + base[:3, 3]
        if self.held is not None:
            box = base @ self._arm.tcp @ np.linalg.inv(self.held.grasp) @ self.held.world_t_box
            echoes = echoes[~_within(echoes, box, self.held.size)]
        self.octree.insert(echoes, place)
        self._points.append(echoes)
        self._places.append(np.tile(place, (len(echoes), 1)))


def path(mind: Client, arm: str, start: Posture, goal: Posture | Floats, apart: float = 0.0) -> list[Posture]:
    """Return postures, from a start, of a path that stays so far from what the map has (m)."""
    mind.robot(arm).set_positions(start)
    mind.collisions.set(paddings={MAP: apart})
    found = mind.paths.find(arm, goal, seed=1)
    mind.collisions.set(paddings={MAP: 0.0})
    return [dict(zip(found.joint_names, row.tolist(), strict=True)) for row in found.waypoints]


def top_of(cloud: Cloud, middle: Sequence[float], half: float) -> float:
    """Return how high a table is (m): most echoes in a square about a place, half of whose edge is told, are there."""
    near = (np.abs(cloud.points[:, :2] - middle) < 0.8 * half).all(axis=1) & (cloud.points[:, 2] > LOW[2])
    if near.sum() < 100:
        raise WrongStateError(
            f"the laser has told {near.sum()} points of a table about {middle}: 100 at least are needed"
        )
    heights = cloud.points[near, 2]
    counts, edges = np.histogram(heights, np.arange(LOW[2], HIGH[2], 0.005))
    most = edges[counts.argmax()]
    return float(np.median(heights[(heights > most - 0.005) & (heights < most + 0.01)]))


def occupied(octree: OctreeMap, thing: Thing | None = None) -> Floats:
    """Return the middles (n, 3) of occupied voxels, without those of a thing."""
    keys, odds = octree.voxels(LOW, HIGH)
    centers = centers_of(keys[odds > 0.0], RESOLUTION)
    if thing is None:
        return centers
    return centers[~_within(centers, thing.world_t_box, thing.size) | (centers[:, 2] < bottom_of(thing))]


def _within(points: Floats, world_t_box: Floats, size: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 3) are in a box or up to RESOLUTION beside it."""
    local = (points - world_t_box[:3, 3]) @ world_t_box[:3, :3]
    return np.asarray((np.abs(local) < 0.5 * size + RESOLUTION).all(axis=1), bool)


def averaged(cloud: Cloud) -> Cloud:
    """Return a cloud with the mean of the echoes in each cube of AVERAGED: noise of looks that overlap goes down."""
    _, which = np.unique(np.floor(cloud.points / AVERAGED).astype(np.int64), axis=0, return_inverse=True)
    count = np.bincount(which)[:, None]
    both = (np.column_stack([np.bincount(which, column) for column in of.T]) for of in (cloud.points, cloud.seen_from))
    return Cloud(*(total / count for total in both))


def bottom_of(thing: Thing) -> float:
    """Return how high the lower end of a thing is (m)."""
    return float(thing.world_t_box[2, 3] - 0.5 * np.abs(thing.world_t_box[2, :3]) @ thing.size)


def tell(mind: Client, centers: Floats) -> None:
    """Give a kernel that holds the arm alone what is occupied."""
    if MAP in {node.name for node in mind.scene.nodes("object")}:
        mind.scene.remove(MAP)
    edges = 3 * (RESOLUTION,)
    boxes = [virtualrobot.box(*edges, pose=virtualrobot.pose(*place)) for place in centers]
    mind.scene.add_object(MAP, boxes)


def hold(mind: Client, arm: str, thing: Thing) -> None:
    """Let the arm of a kernel hold what was seen."""
    mind.robot(arm).set_positions(thing.posture)
    mind.scene.add_part(THING, virtualrobot.box(*thing.size), pose=thing.world_t_box)
    mind.robot(arm).pick(THING)


def let_go(mind: Client, arm: str) -> None:
    """Let the arm of a kernel hold nothing any more, and forget what it was."""
    mind.robot(arm).place()
    mind.scene.remove(THING)


def grip(client: Client, arm: str, fingers: Sequence[str], width: float) -> bool:
    """Close fingers from a width (m) that was seen until contact sensors of all feel something, and hold what is there.

    Returns:
        Whether they do.
    """
    tool, width = client.robot(arm).tool(), width + CLOSING
    least = max(0.0, width - TIGHT)
    while not (felt := all(client.sensors[one].read().value for one in fingers)) and width > least:
        client.clock.run(tool.move_to_width(width, wait=False))
        width -= CLOSING
    if felt:
        client.robot(arm).pick(max_distance=0.1)
    return felt


def thing_on(mind: Client, setup: Setup, cloud: Cloud, octree: OctreeMap, middle: Sequence[float]) -> Thing:
    """Return what stands on the table about a place (2,), and the best grasp of it from above that the arm reaches.

    Raises:
        WrongStateError: where nothing stands there, or no grasp is in reach.
    """
    top = top_of(cloud, middle, setup.half)
    near = (np.abs(cloud.points[:, :2] - middle) < setup.half).all(axis=1)
    on_it = near & (cloud.points[:, 2] > top + ABOVE)
    if on_it.sum() < 200:
        raise WrongStateError(f"{on_it.sum()} echoes are above the table about {middle}: nothing stands there")
    rng = np.random.default_rng(1)
    whole = averaged(Cloud(cloud.points[on_it], cloud.seen_from[on_it]))
    body = surface_of_cloud(whole.points, whole.seen_from)
    table = cloud.points[near & ~on_it]
    table = table[rng.permutation(len(table))[:SAMPLES]]
    found = [one for one in grasps(body, setup.jaw, rng, obstacles=table) if one.pose[2, 2] < -0.95]
    for grasp in found[:40]:
        local = (cloud.points[on_it] - grasp.pose[:3, 3]) @ grasp.pose[:3, :3]
        low, high = np.quantile(local, 0.01, axis=0), np.quantile(local, 0.99, axis=0)
        high[2] = (grasp.pose[2, 3] - top) / -grasp.pose[2, 2]  # nobody sees what it stands on: down to the table
        box = grasp.pose.copy()
        box[:3, 3] += grasp.pose[:3, :3] @ (0.5 * (low + high))
        seen = Thing(box, high - low, grasp.pose, {}, grasp.width)
        tell(mind, occupied(octree, seen))
        (posture,) = postures(mind, setup.arm, [grasp.pose])
        if posture is not None:
            return Thing(box, high - low, grasp.pose, posture, grasp.width)
    raise WrongStateError(f"none of {len(found)} grasps from above is in reach")
